//! Scatter between runs: a random gain a run, few of them.
//!
//! In whitened units the gains enter as y = H b + w, b ~ N(0, scatter^2 I), column k of H being the whitened force of
//! run k. With the mean's columns projected out, G = H'H = E diag(lambda) E' and t = E' H'y, the restricted
//! likelihood of the scatter needs no more than
//!
//! ```text
//! -2 log L(s) = sum_k [ log(1 + s^2 lambda_k) - s^2 t_k^2 / (1 + s^2 lambda_k) ] + const              (N2)
//! ```
//!
//! A mean that is wrong differs from whole conditions, and what it misses there is no scatter. Repeats know better: with a gain free for
//! every condition, the same evidence is that of repeats alone. Where the rest is too large for what they show, it is an error of the
//! mean, and repeats alone are believed (the test for lack of fit against pure error).

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::context::Context;

/// What the campaign says about the scatter between its runs.
#[derive(Clone, Debug)]
pub struct ScatterEvidence {
    /// Information on the gain in each of the directions between runs that the mean leaves free, 1.
    pub lambda: Vec<f64>,
    /// Score of the gain in the same directions.
    pub score: Vec<f64>,
}

impl ScatterEvidence {
    /// From whitened gain columns (n x K), the whitened mean's columns (n x p) and the whitened residual.
    pub fn new(gains: &DMatrix<f64>, mean: &DMatrix<f64>, residual: &DVector<f64>) -> Self {
        let basis = orthonormal_basis(mean);
        let projected = gains - &basis * basis.tr_mul(gains);
        let rest = residual - &basis * basis.tr_mul(residual);
        let score = projected.tr_mul(&rest);
        let (lambda, turn) = free_gains(gains, &projected);
        Self {
            lambda,
            score: turn.tr_mul(&score).iter().copied().collect(),
        }
    }

    /// The same where runs of one condition are repeats: of them alone where what the mean leaves of whole conditions contradicts them.
    pub fn of_repeats(
        gains: &DMatrix<f64>,
        mean: &DMatrix<f64>,
        residual: &DVector<f64>,
        conditions: &[usize],
    ) -> Self {
        let all = Self::new(gains, mean, residual);
        all.contradicted(gains, mean, residual, conditions)
            .unwrap_or(all)
    }

    /// The evidence of repeats alone where this one, of all directions between runs, contradicts it.
    pub fn contradicted(
        &self,
        gains: &DMatrix<f64>,
        mean: &DMatrix<f64>,
        residual: &DVector<f64>,
        conditions: &[usize],
    ) -> Option<Self> {
        let count = conditions.iter().max().map_or(0, |last| last + 1);
        if conditions.len() < count + FEWEST_REPEATS {
            return None;
        }
        let p = mean.ncols();
        let mut free = mean.clone().resize_horizontally(p + count, 0.0);
        for (gain, &condition) in gains.column_iter().zip(conditions) {
            let mut own = free.column_mut(p + condition);
            own += gain;
        }
        let repeats = Self::new(gains, &free, residual);
        let further = self
            .degrees_of_freedom()
            .saturating_sub(repeats.degrees_of_freedom());
        if repeats.degrees_of_freedom() < FEWEST_REPEATS || further == 0 {
            return None;
        }
        let tail = ChiSquared::new(further as f64).ok()?;
        let of_conditions = |s: f64| self.distance(s) - repeats.distance(s);
        let each = repeats.posterior();
        let probability: f64 = (each.iter())
            .map(|&(s, weight)| weight * tail.sf(of_conditions(s).max(0.0)))
            .sum();
        (probability < CONTRADICTION).then_some(repeats)
    }

    /// sum t^2 / (lambda (1 + s^2 lambda)): chi-squared if s is the scatter.
    fn distance(&self, scatter: f64) -> f64 {
        let s2 = scatter * scatter;
        let each = self.lambda.iter().zip(&self.score);
        each.map(|(l, t)| t * t / (l * (1.0 + s2 * l))).sum()
    }

    /// Directions between runs that are left to estimate the scatter from.
    pub fn degrees_of_freedom(&self) -> usize {
        self.lambda.len()
    }

    /// -2 log of the restricted likelihood of a scatter, up to a constant, (N2).
    pub fn deviance(&self, scatter: f64) -> f64 {
        let s2 = scatter * scatter;
        self.lambda
            .iter()
            .zip(&self.score)
            .map(|(l, t)| (s2 * l).ln_1p() - s2 * t * t / (1.0 + s2 * l))
            .sum()
    }

    /// A grid of scatters that covers all that the data allow, with weights of the posterior under the prior
    /// 1 / (s + d), d being the scatter at which runs start to differ visibly: flat below it, scale-free above it.
    pub fn posterior(&self) -> Vec<(f64, f64)> {
        const NODES: usize = 61;
        if self.lambda.is_empty() {
            return vec![(0.0, 1.0)];
        }
        let count = self.lambda.len() as f64;
        let visible = (count / self.lambda.iter().sum::<f64>()).sqrt();
        let largest = self
            .lambda
            .iter()
            .zip(&self.score)
            .map(|(l, t)| (t / l).abs())
            .fold(0.0, f64::max);
        let top = (30.0 * largest.max(visible) / visible).asinh();
        // s = visible sinh(u): nodes are even near zero and logarithmic above.
        let mut grid: Vec<(f64, f64)> = (0..NODES)
            .map(|i| {
                let u = top * i as f64 / (NODES - 1) as f64;
                let s = visible * u.sinh();
                let measure = u.cosh() / (1.0 + u.sinh());
                let edge = if i == 0 || i == NODES - 1 { 0.5 } else { 1.0 };
                (s, -0.5 * self.deviance(s) + (measure * edge).ln())
            })
            .collect();
        let best = grid.iter().map(|g| g.1).fold(f64::NEG_INFINITY, f64::max);
        let mut total = 0.0;
        for g in &mut grid {
            g.1 = (g.1 - best).exp();
            total += g.1;
        }
        grid.iter_mut().for_each(|g| g.1 /= total);
        grid
    }

    /// The scatter of largest restricted likelihood (zero where none is seen).
    pub fn estimate(&self) -> f64 {
        let grid = self.posterior();
        let Some(best) = (0..grid.len()).min_by(|&a, &b| {
            self.deviance(grid[a].0)
                .total_cmp(&self.deviance(grid[b].0))
        }) else {
            return 0.0;
        };
        let (mut lo, mut hi) = (
            grid[best.saturating_sub(1)].0,
            grid[(best + 1).min(grid.len() - 1)].0,
        );
        let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
        for _ in 0..60 {
            let (a, b) = (hi - ratio * (hi - lo), lo + ratio * (hi - lo));
            if self.deviance(a) < self.deviance(b) {
                hi = b;
            } else {
                lo = a;
            }
        }
        let s = 0.5 * (lo + hi);
        if self.deviance(s) < 0.0 { s } else { 0.0 }
    }
}

/// Directions between repeats from which a scatter is known well enough to contradict anything.
const FEWEST_REPEATS: usize = 3;
/// Probability below which what the mean leaves of conditions is no scatter.
const CONTRADICTION: f64 = 1e-3;

/// A direction between runs tells of the scatter where the mean leaves more than this share of its squared length. Of what is left of
/// others an error of the mean makes scatters of many hundred percent, beside which every effect is nothing.
const LEFT_OF_A_GAIN: f64 = 1e-3;

/// lambda (largest first) and E of (N2) in the directions between runs of which the mean leaves enough; `projected`: the whitened gains
/// with the mean's columns taken out.
pub fn free_gains(gains: &DMatrix<f64>, projected: &DMatrix<f64>) -> (Vec<f64>, DMatrix<f64>) {
    let whole = gains.tr_mul(gains);
    let eigen = projected.tr_mul(projected).symmetric_eigen();
    let left = |k: &usize| {
        let e = eigen.eigenvectors.column(*k);
        eigen.eigenvalues[*k] > LEFT_OF_A_GAIN * e.dot(&(&whole * e))
    };
    let mut order: Vec<usize> = (0..gains.ncols()).filter(left).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    let lambda = order.iter().map(|&k| eigen.eigenvalues[k]).collect();
    (lambda, eigen.eigenvectors.select_columns(&order))
}

/// Every run's own force as recorded, one behind the other.
pub(super) fn stacked_gains(context: &Context) -> Vec<f64> {
    let mut gains = context.scale.clone();
    context.recorded(&mut gains);
    gains
}

/// Stacked force of run k in column k, zero in all other runs.
pub(super) fn gain_columns(context: &Context) -> DMatrix<f64> {
    let mut gains = DMatrix::zeros(context.samples(), context.runs.len());
    for (k, run) in context.runs.iter().enumerate() {
        for i in run.clone() {
            gains[(i, k)] = context.scale[i];
        }
        context.recorded(gains.column_mut(k).as_mut_slice());
    }
    gains
}

/// Orthonormal basis of a matrix's columns, directions below 1e-9 of the largest dropped; columns are scaled first.
pub(super) fn orthonormal_basis(columns: &DMatrix<f64>) -> DMatrix<f64> {
    let mut basis: Vec<DVector<f64>> = Vec::with_capacity(columns.ncols());
    for j in 0..columns.ncols() {
        let norm = columns.column(j).norm();
        if norm == 0.0 || !norm.is_finite() {
            continue;
        }
        let mut v: DVector<f64> = columns.column(j) / norm;
        // Twice is enough (Kahan): modified Gram-Schmidt with one repetition.
        for _ in 0..2 {
            for b in &basis {
                let along = b.dot(&v);
                v.axpy(-along, b, 1.0);
            }
        }
        let left = v.norm();
        if left > 1e-7 {
            basis.push(v / left);
        }
    }
    if basis.is_empty() {
        DMatrix::zeros(columns.nrows(), 0)
    } else {
        DMatrix::from_columns(&basis)
    }
}

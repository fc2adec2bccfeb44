//! A campaign in whitened coordinates with the fitted model's own directions taken out: where every question about a
//! further effect is asked.
//!
//! With W the whitening (scatter between runs left out), J the fitted model's Jacobian, r the residual, H a gain
//! column a run, and Q an orthonormal basis of W J:
//!
//! ```text
//! y = (I - QQ') W r,   H~ = (I - QQ') W H,   H~'H~ = E diag(lambda) E',   V(s) = I + s^2 H~ H~'            (D1)
//! ```
//!
//! An effect with columns S has s~ = (I - QQ') W S. For a scatter s between runs its score statistic is
//! T(s) = u'A^-1 u with A = S~'V^-1 S~, u = S~'V^-1 y, a chi-squared with as many degrees of freedom as S has columns
//! if there is no such effect. The scatter is not known: its posterior given that the effect may be there,
//!
//! ```text
//! log p(s | y) = -1/2 [ sum log(1 + s^2 lambda) + log det A(s) - s^2 sum t^2/(1 + s^2 lambda) - T(s) ] + log prior
//! ```
//!
//! weighs the tail probabilities. Where runs tell the scatter from few degrees of freedom this is Student's t, and an
//! effect that lives within runs loses nothing. Where what the model leaves of whole conditions contradicts their repeats, it is no scatter:
//! then p(s | repeats) weighs them, whatever the effect.

use fitting::noise::{ScatterEvidence, free_gains};
use nalgebra::{Cholesky, DMatrix, DVector};

use crate::bench::Bench;
use crate::scan::Ray;
use crate::tail::{equivalent_z, log_chi2_tail, log_sum, normal_deviate};

/// Columns that keep less than this share of their length after projection are not tested: the law absorbs them.
pub(crate) const ABSORBED: f64 = 1e-4;

/// Whitened, projected coordinates of a campaign under a fitted model, see (D1).
#[derive(Clone)]
pub(crate) struct Ground {
    basis: DMatrix<f64>,
    /// Whitened residual, projected.
    pub(crate) y: DVector<f64>,
    /// H~ E.
    gains: DMatrix<f64>,
    lambda: Vec<f64>,
    turned: Vec<f64>,
    scatters: Vec<(f64, f64)>,
    /// What repeats say of the scatter, where they alone are believed.
    repeats: Option<ScatterEvidence>,
    /// Draws of what is left of channel noise, see (M5); often none.
    left: DMatrix<f64>,
}

/// A tested effect in these coordinates.
pub(crate) struct Direction {
    /// Orthonormal columns of the projected effect (n x k).
    pub(crate) columns: DMatrix<f64>,
    /// The map from the orthonormal columns' coefficients to those of the given columns.
    back: DMatrix<f64>,
}

/// The outcome of a score test.
#[derive(Clone, Debug)]
pub(crate) struct Score {
    /// Statistic at the likeliest scatter.
    pub(crate) statistic: f64,
    /// Degrees of freedom.
    pub(crate) columns: usize,
    /// Logarithm of the tail probability, scatter integrated over.
    pub(crate) log_p: f64,
    /// Estimated coefficients of the given columns, at the likeliest scatter.
    pub(crate) coefficients: Vec<f64>,
    /// Standard deviations of the coefficients.
    pub(crate) sd: Vec<f64>,
    /// The likeliest scatter with the effect in the model.
    pub(crate) scatter: f64,
    /// How many times the variance that was reckoned the noise was taken to have.
    pub(crate) background: f64,
}

impl Score {
    /// Standard deviations with the same two-sided tail.
    pub(crate) fn z(&self) -> f64 {
        equivalent_z(self.log_p)
    }

    /// The same with the sign of the first column's coefficient.
    pub(crate) fn signed_z(&self) -> f64 {
        let sign = self.coefficients.first().map_or(0.0, |c| c.signum());
        sign * self.z()
    }

    /// The same where the noise has so many times the variance that was reckoned.
    pub(crate) fn over(mut self, background: f64) -> Self {
        self.statistic /= background;
        self.log_p /= background;
        self.background *= background;
        self.sd.iter_mut().for_each(|sd| *sd *= background.sqrt());
        self
    }
}

/// Scatters with the logarithms of their prior weights: the posterior's less what is `known` beside.
fn nodes(evidence: &ScatterEvidence, known: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
    let weighed = evidence.posterior().into_iter();
    weighed
        .map(|(s, w)| match w > 0.0 {
            true => (s, w.ln() + known(s)),
            false => (s, f64::NEG_INFINITY),
        })
        .collect()
}

impl Ground {
    /// From whitened Jacobian, whitened gains (n x K) and whitened residual, the whitening being without scatter.
    pub(crate) fn new(
        jacobian: &DMatrix<f64>,
        gains: &DMatrix<f64>,
        residual: &DVector<f64>,
        conditions: &[usize],
    ) -> Self {
        let basis = orthonormal(jacobian, 1e-9).0;
        let y = residual - &basis * basis.tr_mul(residual);
        let free = gains - &basis * basis.tr_mul(gains);
        let (lambda, turn) = free_gains(gains, &free);
        let turned_gains = &free * &turn;
        let turned: Vec<f64> = turned_gains.tr_mul(&y).iter().copied().collect();
        let evidence = ScatterEvidence {
            lambda: lambda.clone(),
            score: turned.clone(),
        };
        let repeats = evidence.contradicted(gains, jacobian, residual, conditions);
        // The nodes of the scatter are kept; their weights are those of the prior, likelihoods differ by hypothesis. Repeats say the same
        // beside every hypothesis.
        let scatters = match &repeats {
            None => nodes(&evidence, |s| 0.5 * evidence.deviance(s)),
            Some(repeats) => nodes(repeats, |_| 0.0),
        };
        Self {
            basis,
            y,
            gains: turned_gains,
            lambda,
            turned,
            scatters,
            repeats,
            left: DMatrix::zeros(residual.len(), 0),
        }
    }

    /// The same where these whitened draws show what is left of channel noise.
    pub(crate) fn with_left(mut self, whitened: &DMatrix<f64>) -> Self {
        self.left = self.project(whitened);
        self
    }

    /// By how much the variance along orthonormal directions, in the mean, is larger than one for what is left of channel noise (M5).
    fn left_along(&self, columns: &DMatrix<f64>) -> f64 {
        let pairs = (self.left.ncols() * columns.ncols()).max(1);
        self.left.tr_mul(columns).norm_squared() / pairs as f64
    }

    /// The same questions in the coordinates of a few projected columns F = Q R, which the gains of the runs lie among: for effects F c, whose
    /// columns there are R c. With it R.
    pub(crate) fn narrowed(&self, free: &DMatrix<f64>) -> (Self, DMatrix<f64>) {
        let qr = free.clone().qr();
        let (q, r) = (qr.q(), qr.r());
        let narrow = Self {
            basis: DMatrix::zeros(q.ncols(), 0),
            y: q.tr_mul(&self.y),
            gains: q.tr_mul(&self.gains),
            lambda: self.lambda.clone(),
            turned: self.turned.clone(),
            scatters: self.scatters.clone(),
            repeats: self.repeats.clone(),
            left: q.tr_mul(&self.left),
        };
        (narrow, r)
    }

    /// The same with what all runs say of the scatter, where repeats alone are believed: beside the right hypothesis what is left of whole
    /// conditions is scatter, too.
    pub(crate) fn of_all_runs(&self) -> Option<Self> {
        self.repeats.as_ref()?;
        let evidence = self.evidence_of_all_runs();
        Some(Self {
            scatters: nodes(&evidence, |s| 0.5 * evidence.deviance(s)),
            repeats: None,
            ..self.clone()
        })
    }

    /// Degrees of freedom from which the scatter between runs is estimated.
    pub(crate) fn scatter_freedom(&self) -> usize {
        self.lambda.len()
    }

    /// Takes the model's directions out of whitened columns.
    pub(crate) fn project(&self, whitened: &DMatrix<f64>) -> DMatrix<f64> {
        whitened - &self.basis * self.basis.tr_mul(whitened)
    }

    /// The tested effect with these whitened columns, `None` where the model absorbs all of it.
    pub(crate) fn direction(&self, whitened: &DMatrix<f64>) -> Option<Direction> {
        let free = self.project(whitened);
        let kept = (0..free.ncols())
            .map(|j| {
                let full = whitened.column(j).norm();
                if full > 0.0 {
                    free.column(j).norm() / full
                } else {
                    0.0
                }
            })
            .fold(0.0, f64::max);
        if !(kept > ABSORBED) {
            return None;
        }
        // Columns are compared at their own lengths, so a column absorbed by the model does not come back as noise.
        let mut usable = free.clone();
        for j in 0..free.ncols() {
            if free.column(j).norm() <= ABSORBED * whitened.column(j).norm() {
                usable.column_mut(j).fill(0.0);
            }
        }
        let (columns, back) = orthonormal(&usable, 1e-5);
        (columns.ncols() > 0).then_some(Direction { columns, back })
    }

    /// The tested effect of one column that is projected already, `full` being its length before; `None` where the model absorbs it.
    pub(crate) fn along(&self, free: DVector<f64>, full: f64) -> Option<Direction> {
        let length = free.norm();
        (length > ABSORBED * full).then(|| Direction {
            columns: DMatrix::from_column_slice(free.len(), 1, (free / length).as_slice()),
            back: DMatrix::from_element(1, 1, 1.0 / length),
        })
    }

    /// The score test of an effect, the scatter between runs integrated over.
    pub(crate) fn score(&self, direction: &Direction) -> Score {
        let k = direction.columns.ncols();
        let plain = direction.columns.tr_mul(&self.y);
        let against = self.gains.tr_mul(&direction.columns);
        let mut log_weights = Vec::with_capacity(self.scatters.len());
        let mut log_tails = Vec::with_capacity(self.scatters.len());
        let mut best = (f64::NEG_INFINITY, 0.0, 0.0, DVector::zeros(k));
        for &(s, log_prior) in &self.scatters {
            let Some((statistic, log_det, coefficients)) = self.at(s, &plain, &against) else {
                continue;
            };
            let between = self.between(s);
            let (log_likelihood, log_weight) = match &self.repeats {
                None => {
                    let log_likelihood = -0.5 * (between + log_det - statistic);
                    (log_likelihood, log_likelihood + log_prior)
                }
                Some(repeats) => (-0.5 * repeats.deviance(s), log_prior),
            };
            log_weights.push(log_weight);
            log_tails.push(log_chi2_tail(statistic, k));
            if log_likelihood > best.0 {
                best = (log_likelihood, s, statistic, coefficients);
            }
        }
        let total = log_weights.iter().copied().fold(f64::NEG_INFINITY, log_sum);
        let log_p = log_weights
            .iter()
            .zip(&log_tails)
            .map(|(w, t)| w - total + t)
            .fold(f64::NEG_INFINITY, log_sum);
        let coefficients = &direction.back * &best.3;
        let sd = self.deviations(best.1, direction, &against);
        Score {
            sd,
            statistic: best.2,
            columns: k,
            log_p: log_p.min(0.0),
            coefficients: coefficients.iter().copied().collect(),
            scatter: best.1,
            background: 1.0,
        }
        .over(1.0 + self.left_along(&direction.columns))
    }

    /// What -2 log likelihood falls by with a direction in the model, each at its own likeliest scatter. Less than T at the latter where
    /// without the direction scatter between runs takes its place.
    pub(crate) fn explained(&self, direction: &Direction) -> f64 {
        let plain = direction.columns.tr_mul(&self.y);
        let against = self.gains.tr_mul(&direction.columns);
        let (mut without, mut with) = (f64::INFINITY, f64::INFINITY);
        for &(s, _) in &self.scatters {
            let between = self.between(s);
            let statistic = self.at(s, &plain, &against).map_or(0.0, |at| at.0);
            without = without.min(between);
            with = with.min(between - statistic);
        }
        without - with
    }

    /// What a scatter s adds to -2 log likelihood: sum log(1 + s^2 lambda) - s^2 t^2/(1 + s^2 lambda).
    fn between(&self, s: f64) -> f64 {
        let s2 = s * s;
        let terms = self.lambda.iter().zip(&self.turned);
        terms
            .map(|(l, t)| (s2 * l).ln_1p() - s2 * t * t / (1.0 + s2 * l))
            .sum()
    }

    /// V(s)^-1 y, see (D1).
    pub(crate) fn residual_within(&self, scatter: f64) -> DVector<f64> {
        let s2 = scatter * scatter;
        let turned = self.turned.iter().zip(&self.lambda);
        let shares = turned.map(|(t, l)| s2 / (1.0 + s2 * l) * t);
        let shares = DVector::from_iterator(self.turned.len(), shares);
        &self.y - &self.gains * shares
    }

    /// T of a direction at a scatter.
    pub(crate) fn statistic(&self, direction: &Direction, scatter: f64) -> f64 {
        let plain = direction.columns.tr_mul(&self.y);
        let against = self.gains.tr_mul(&direction.columns);
        self.at(scatter, &plain, &against).map_or(0.0, |at| at.0)
    }

    /// Standard deviations of the given columns' coefficients at a scatter.
    fn deviations(&self, s: f64, direction: &Direction, against: &DMatrix<f64>) -> Vec<f64> {
        let k = direction.columns.ncols();
        let mut a = DMatrix::identity(k, k) * (1.0 + 1e-9);
        for (m, l) in self.lambda.iter().enumerate() {
            let row = against.row(m);
            a -= row.transpose() * row * (s * s / (1.0 + s * s * l));
        }
        let covariance = a.try_inverse().unwrap_or_else(|| DMatrix::identity(k, k));
        let given = &direction.back * covariance * direction.back.transpose();
        given.diagonal().iter().map(|v| v.max(0.0).sqrt()).collect()
    }

    /// T(s), log det A(s) and A^-1 u.
    fn at(
        &self,
        s: f64,
        plain: &DVector<f64>,
        against: &DMatrix<f64>,
    ) -> Option<(f64, f64, DVector<f64>)> {
        let k = plain.len();
        let mut a = DMatrix::identity(k, k);
        let mut u = plain.clone();
        let s2 = s * s;
        for (m, (l, t)) in self.lambda.iter().zip(&self.turned).enumerate() {
            let shrink = s2 / (1.0 + s2 * l);
            for i in 0..k {
                u[i] -= shrink * against[(m, i)] * t;
                for j in 0..k {
                    a[(i, j)] -= shrink * against[(m, i)] * against[(m, j)];
                }
            }
        }
        // What the scatter leaves of a direction that lives between runs may be nothing but rounding.
        for i in 0..k {
            a[(i, i)] += 1e-9;
        }
        let factor = Cholesky::new(a)?;
        let solved = factor.solve(&u);
        let log_det = 2.0 * factor.l().diagonal().iter().map(|x| x.ln()).sum::<f64>();
        Some((u.dot(&solved), log_det, solved))
    }

    /// Length of a projected, whitened effect in the noise's units. What lives between runs is told against a scatter that
    /// is itself estimated from the runs: that part counts as the normal deviate with the tail of Student's t.
    pub(crate) fn distance(&self, projected: &DVector<f64>, scatter: f64) -> f64 {
        let along = self.gains.tr_mul(projected);
        let s2 = scatter * scatter;
        let (mut shared, mut between) = (0.0, 0.0);
        for (a, l) in along.iter().zip(&self.lambda) {
            shared += a * a / l;
            between += a * a / l / (1.0 + s2 * l);
        }
        let within = (projected.norm_squared() - shared).max(0.0);
        let freedom = (self.lambda.len() as f64 - 1.0).max(1.0);
        (within + normal_deviate(between.sqrt(), freedom).powi(2)).sqrt()
    }

    /// Standard deviation of a cause's first size, by its first tangent or chord.
    pub(crate) fn size_deviation(
        &self,
        bench: &Bench<'_>,
        rays: &[Ray],
        cause: usize,
        scatter: f64,
    ) -> Option<f64> {
        let ray = rays.iter().find(|r| r.cause == cause)?;
        let against = self.gains.tr_mul(&ray.direction.columns);
        let sd = self.deviations(scatter, &ray.direction, &against);
        Some(sd.first()? * ray.unit_size(bench).abs())
    }

    /// The scatter of largest restricted likelihood beside the fitted model.
    pub(crate) fn likeliest_scatter(&self) -> f64 {
        self.evidence().estimate()
    }

    /// Scatters with their weights given the fitted model.
    pub(crate) fn scatter_posterior(&self) -> Vec<(f64, f64)> {
        self.evidence().posterior()
    }

    fn evidence(&self) -> ScatterEvidence {
        (self.repeats.clone()).unwrap_or_else(|| self.evidence_of_all_runs())
    }

    fn evidence_of_all_runs(&self) -> ScatterEvidence {
        ScatterEvidence {
            lambda: self.lambda.clone(),
            score: self.turned.clone(),
        }
    }

    /// V(s)^-1 y.
    pub(crate) fn solved_residual(&self, scatter: f64) -> DVector<f64> {
        let s2 = scatter * scatter;
        let mut out = self.y.clone();
        for (m, (l, t)) in self.lambda.iter().zip(&self.turned).enumerate() {
            out.axpy(-s2 / (1.0 + s2 * l) * t, &self.gains.column(m), 1.0);
        }
        out
    }

    /// Takes the model's directions out of a whitened vector.
    pub(crate) fn project_vector(&self, whitened: &DVector<f64>) -> DVector<f64> {
        whitened - &self.basis * self.basis.tr_mul(whitened)
    }

    /// Root of V(s)^-1 applied to projected columns, so that plain inner products hold afterwards.
    pub(crate) fn descatter(&self, columns: &DMatrix<f64>, scatter: f64) -> DMatrix<f64> {
        let mut out = columns.clone();
        let s2 = scatter * scatter;
        for (gain, l) in self.gains.column_iter().zip(&self.lambda) {
            let shrink = 1.0 - 1.0 / (1.0 + s2 * l).sqrt();
            for mut column in out.column_iter_mut() {
                let along = gain.dot(&column);
                column.axpy(-shrink / l * along, &gain, 1.0);
            }
        }
        out
    }

    /// S~'V(s)^-1 S~ of whitened columns S, S~ their projection: with Q and the gains G = H~ E at right angles,
    /// S'S - (Q'S)'(Q'S) - (G'S)' diag(s^2 / (1 + s^2 lambda)) (G'S).
    pub(crate) fn information(&self, whitened: &DMatrix<f64>, scatter: f64) -> DMatrix<f64> {
        let (absorbed, between) = (self.basis.tr_mul(whitened), self.gains.tr_mul(whitened));
        let s2 = scatter * scatter;
        let mut shared = between.clone();
        for (mut row, l) in shared.row_iter_mut().zip(&self.lambda) {
            row *= s2 / (1.0 + s2 * l);
        }
        whitened.tr_mul(whitened) - absorbed.tr_mul(&absorbed) - between.tr_mul(&shared)
    }
}

/// Orthonormal columns X of A's range with X = A back, columns below `tolerance` of their own length dropped.
pub(crate) fn orthonormal(a: &DMatrix<f64>, tolerance: f64) -> (DMatrix<f64>, DMatrix<f64>) {
    let (n, p) = a.shape();
    let mut basis: Vec<DVector<f64>> = Vec::new();
    let mut back: Vec<DVector<f64>> = Vec::new();
    for j in 0..p {
        let norm = a.column(j).norm();
        if !(norm > 0.0) || !norm.is_finite() {
            continue;
        }
        let mut v: DVector<f64> = a.column(j) / norm;
        let mut b = DVector::zeros(p);
        b[j] = 1.0 / norm;
        // Gram-Schmidt, twice: enough for orthogonality to rounding.
        for _ in 0..2 {
            for (e, f) in basis.iter().zip(&back) {
                let along = e.dot(&v);
                v.axpy(-along, e, 1.0);
                b.axpy(-along, f, 1.0);
            }
        }
        let left = v.norm();
        if left > tolerance {
            basis.push(v / left);
            back.push(b / left);
        }
    }
    if basis.is_empty() {
        (DMatrix::zeros(n, 0), DMatrix::zeros(p, 0))
    } else {
        (DMatrix::from_columns(&basis), DMatrix::from_columns(&back))
    }
}

/// log of the tail probability of the largest of a family of tests along a path, by the volume of tubes:
/// one column: P(chi2_1 > T) + (L / pi) e^(-T/2); two: e^(-T/2) (1 + L sqrt(T / 2 pi)) (Hotelling; Davies 1987).
pub(crate) fn look_elsewhere(score: &Score, path: f64) -> f64 {
    if path <= 0.0 {
        return score.log_p;
    }
    // The scatter-integrated tail stands for a chi-squared statistic with the same tail.
    let t = match score.columns {
        1 => score.z().powi(2),
        _ => -2.0 * score.log_p,
    };
    let crossings = match score.columns {
        1 => (path / std::f64::consts::PI).ln() - 0.5 * t,
        _ => (path * (t / std::f64::consts::TAU).sqrt().max(0.3)).ln() - 0.5 * t,
    };
    log_sum(score.log_p, crossings).min(0.0)
}

/// Angle between two normalised directions: the largest principal angle of their column spaces.
pub(crate) fn angle(a: &DMatrix<f64>, b: &DMatrix<f64>) -> f64 {
    let overlap = a.tr_mul(b);
    let singular = overlap.singular_values();
    let k = a.ncols().min(b.ncols());
    let mean: f64 = singular.iter().take(k).map(|s| s * s).sum::<f64>() / k as f64;
    mean.clamp(0.0, 1.0).sqrt().acos()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    fn normal(rng: &mut ChaCha8Rng) -> f64 {
        StandardNormal.sample(rng)
    }

    /// Six runs of 40 samples with a scatter ten times what one run's own noise allows to see; an effect between runs
    /// must keep its false-alarm rate (Student's t with 4 - 1 degrees of freedom), and so must one within runs.
    #[test]
    fn tails_are_calibrated_with_few_runs() {
        let (runs, each) = (6, 40);
        let n = runs * each;
        let gains = DMatrix::from_fn(n, runs, |i, k| if i / each == k { 1.0 } else { 0.0 });
        let mean = DMatrix::from_fn(n, 2, |i, c| if (i / each) % 2 == c { 1.0 } else { 0.0 });
        let between = DMatrix::from_fn(n, 1, |i, _| (i / each) as f64);
        let within = DMatrix::from_fn(n, 1, |i, _| ((i % each) as f64 * 0.3).sin());
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let trials = 3000;
        let mut hits = [0_usize; 2];
        for _ in 0..trials {
            let b: Vec<f64> = (0..runs).map(|_| 1.6 * normal(&mut rng)).collect();
            let r = DVector::from_fn(n, |i, _| b[i / each] + normal(&mut rng));
            let ground = Ground::new(&mean, &gains, &r, &[]);
            assert_eq!(ground.scatter_freedom(), 4);
            for (hit, effect) in hits.iter_mut().zip([&between, &within]) {
                let direction = ground.direction(effect).expect("not absorbed");
                if ground.score(&direction).log_p < 0.02_f64.ln() {
                    *hit += 1;
                }
            }
        }
        // 2 % nominal: 60 expected, standard deviation 7.7.
        for (hit, least) in hits.iter().zip([15, 35]) {
            assert!((least..=85).contains(hit), "{hits:?} of {trials}");
        }
    }

    /// What is left of channel noise lies along one direction, three times as large there as the noise: with draws of it as they come (M5)
    /// an effect along that direction keeps its false-alarm rate, without them it is seen in most records, and one across it loses nothing.
    #[test]
    fn what_is_left_of_channel_noise_is_no_effect() {
        let n = 200;
        let along = DMatrix::from_fn(n, 1, |i, _| (i as f64 * 0.2).sin() / 10.0);
        let across = DMatrix::from_fn(n, 1, |i, _| (i as f64 * 0.2).cos() / 10.0);
        let gains = DMatrix::from_fn(n, 4, |i, k| if i / 50 == k { 1.0 } else { 0.0 });
        let mean = DMatrix::from_element(n, 1, 1.0);
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let trials = 1000;
        let (mut told, mut untold, mut beside) = (0, 0, 0);
        for _ in 0..trials {
            let left = 3.0 * normal(&mut rng);
            let r = DVector::from_fn(n, |i, _| left * along[i] + normal(&mut rng));
            let draws = DMatrix::from_fn(1, 8, |_, _| 3.0 * normal(&mut rng));
            let bare = Ground::new(&mean, &gains, &r, &[]);
            let ground = Ground::new(&mean, &gains, &r, &[]).with_left(&(&along * draws));
            let seen = |ground: &Ground, effect: &DMatrix<f64>| {
                let direction = ground.direction(effect).expect("not absorbed");
                usize::from(ground.score(&direction).log_p < 0.02_f64.ln())
            };
            told += seen(&ground, &along);
            untold += seen(&bare, &along);
            beside += seen(&ground, &across);
        }
        // 2 % nominal; along the draws, whose size is known to half of itself, some more.
        assert!(told <= 60, "{told} of {trials}");
        assert!(untold >= 300, "{untold} of {trials}");
        assert!((5..=40).contains(&beside), "{beside} of {trials}");
    }
}

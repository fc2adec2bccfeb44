//! Newton's step on an identified active set, with the exact Hessian.
//!
//! ```text
//! ⎡ H    J_Aᵀ ⎤ ⎡ d  ⎤     ⎡ g + J_Aᵀ y ⎤
//! ⎣ J_A   0   ⎦ ⎣ Δy ⎦ = − ⎣ c_A − b_A  ⎦        variables at a bound: d_j = bound − x_j
//! ```
//!
//! Rows outside the active set stay in the matrix as `−1` on the diagonal, so
//! the pattern, and with it the symbolic factorisation, hardly ever changes. Steep rows are
//! scaled down (by powers of two, which round nothing): without pivoting, a steep row `a`
//! eliminated on its shift `δ` would leave `‖a‖²/δ` where the Hessian stands and drown it. The
//! matrix is factorised as LDLᵀ without pivoting; `±δ` on the diagonal keeps
//! pivots alive and iterative refinement removes both rounding and shifts. The signs of D give
//! the inertia: with exactly `n` positive ones the reduced Hessian is positive
//! definite and the step is a minimiser of the subproblem.

use crate::iterate::Iterate;
use crate::ldl::{Ldl, order};
use crate::model::Structure;
use crate::pattern::{Pattern, max_abs};

/// Shift of the Hessian's diagonal.
const PRIMAL_SHIFT: f64 = 1e-9;
/// Shift of the active rows' diagonal.
const DUAL_SHIFT: f64 = 1e-9;
/// Rows with a larger entry than this are scaled down to it.
const STEEP: f64 = 8.0;
/// Refinement stops at this backward error.
const REFINED: f64 = 1e-16;
/// A step whose residual stays above this share of its right-hand side is refused,
const ACCEPTABLE: f64 = 1e-6;
/// unless the residual itself is below this: far less than a certified point may miss.
const NEGLIGIBLE: f64 = 1e-11;
/// A solve whose backward error stays above this is refused.
const BACKWARD: f64 = 1e-10;
/// Most rounds of refinement.
const ROUNDS: usize = 30;

/// The rows and variables held at a limit.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ActiveSet {
    pub rows: Vec<bool>,
    pub bounds: Vec<bool>,
}

/// Where a held row or variable sits, chosen by the sign of its multiplier.
pub(crate) fn nearest_limit(value: f64, lower: f64, upper: f64) -> f64 {
    if (value - lower).abs() <= (value - upper).abs() {
        lower
    } else {
        upper
    }
}

/// Newton's step and the multipliers after it.
#[derive(Clone, Debug)]
pub(crate) struct NewtonStep {
    pub d: Vec<f64>,
    pub y: Vec<f64>,
    pub z: Vec<f64>,
}

/// A refined solution with its residual, that relative to the right-hand side and the backward error.
struct Refined {
    x: Vec<f64>,
    miss: f64,
    residual: f64,
    backward: f64,
}

/// The matrix, its factorisation and scratch space.
pub(crate) struct NewtonSystem {
    /// Entries of Hessian and Jacobian that were ever more than nought, and the whole diagonal.
    pattern: Pattern,
    values: Vec<f64>,
    /// Largest row sum of the matrix.
    norm: f64,
    /// Diagonal shifts that the factors contain and the system does not.
    shifts: Vec<f64>,
    /// Scale of every variable (one) and row.
    scales: Vec<f64>,
    /// Entries of Hessian and Jacobian that are in the pattern.
    curved: Vec<Entry>,
    sloped: Vec<Entry>,
    /// Entries of the Hessian, then of the Jacobian, that were ever more than nought.
    known: Vec<bool>,
    diagonal: Vec<usize>,
    /// Order of elimination: that of the pattern with all entries that the blocks name. Without pivoting it decides how small
    /// pivots may get, so it does not depend on which entries happen to be nought.
    order: Option<Vec<usize>>,
    factors: Option<Ldl>,
    /// How often the pattern was laid out.
    pub layout: usize,
    /// Number of factorisations done.
    pub factorisations: usize,
}

/// Scaled entries of this size are what rounding leaves of a zero.
const NOUGHT: f64 = 1e-17;

fn is_nought(value: f64) -> bool {
    value.abs() <= NOUGHT
}

fn has_news(known: &[bool], values: &[f64]) -> bool {
    let mut entries = known.iter().zip(values);
    entries.any(|(known, value)| !known && !is_nought(*value))
}

/// An entry of Hessian or Jacobian and where it goes.
#[derive(Clone, Copy)]
struct Entry {
    from: u32,
    row: u32,
    column: u32,
    slot: u32,
}

/// The pattern of the Newton matrix with all entries that the blocks name.
fn whole_pattern(s: &Structure) -> Pattern {
    let n = s.variables();
    let size = n + s.rows();
    let mut entries: Vec<(usize, usize)> = (0..size).map(|k| (k, k)).collect();
    entries.extend(s.hessian.entries().map(|(_, r, c)| (r, c)));
    entries.extend(s.jacobian.entries().map(|(_, r, c)| (c, n + r)));
    Pattern::from_entries(size, size, entries)
}

impl NewtonSystem {
    pub(crate) fn new(s: &Structure) -> Self {
        let (n, m) = (s.variables(), s.rows());
        // Shifts make the whole diagonal of the Hessian known.
        let mut known: Vec<bool> = s.hessian.entries().map(|(_, r, c)| r == c).collect();
        known.resize(s.hessian.len() + s.jacobian.len(), false);
        Self {
            pattern: Pattern::from_entries(0, 0, Vec::new()),
            values: Vec::new(),
            norm: 0.0,
            shifts: vec![0.0; n + m],
            scales: vec![1.0; n + m],
            curved: Vec::new(),
            sloped: Vec::new(),
            known,
            diagonal: Vec::new(),
            order: order(&whole_pattern(s)),
            factors: None,
            layout: 0,
            factorisations: 0,
        }
    }

    /// Takes up the entries that are no longer nought. Blocks name all their variables, but most rows and curvatures know few of
    /// them: what has always been nought stays out of the factors.
    pub(crate) fn grow(&mut self, s: &Structure, hessian: &[f64], jacobian: &[f64]) {
        let (curved, sloped) = self.known.split_at_mut(s.hessian.len());
        if self.factors.is_some() && !has_news(curved, hessian) && !has_news(sloped, jacobian) {
            return;
        }
        for (known, values) in [(curved, hessian), (sloped, jacobian)] {
            for (known, value) in known.iter_mut().zip(values) {
                *known |= !is_nought(*value);
            }
        }
        let (n, m) = (s.variables(), s.rows());
        let (curved, sloped) = self.known.split_at(s.hessian.len());
        let curved = s.hessian.entries().filter(|e| curved[e.0]);
        let sloped = s.jacobian.entries().filter(|e| sloped[e.0]);
        let mut entries: Vec<(usize, usize)> = (0..n + m).map(|k| (k, k)).collect();
        entries.extend(curved.clone().map(|(_, r, c)| (r, c)));
        entries.extend(sloped.clone().map(|(_, r, c)| (c, n + r)));
        let pattern = Pattern::from_entries(n + m, n + m, entries);
        let entry = |(from, row, column): (usize, usize, usize), slot: usize| Entry {
            from: from as u32,
            row: row as u32,
            column: column as u32,
            slot: slot as u32,
        };
        self.curved = curved.map(|e| entry(e, pattern.slot(e.1, e.2))).collect();
        self.sloped = sloped
            .map(|e| entry(e, pattern.slot(e.2, n + e.1)))
            .collect();
        self.diagonal = (0..n + m).map(|k| pattern.slot(k, k)).collect();
        self.values = vec![0.0; pattern.len()];
        self.factors = Ldl::new(&pattern, self.order.as_deref().unwrap_or_default());
        self.pattern = pattern;
        self.layout += 1;
    }

    /// Entries of the Jacobian that were ever more than nought.
    pub(crate) fn known_slopes(&self, s: &Structure) -> &[bool] {
        &self.known[s.hessian.len()..]
    }

    /// Fills and factorises the matrix for an active set; the number of positive pivots.
    pub(crate) fn factorise(
        &mut self,
        s: &Structure,
        hessian: &[f64],
        jacobian: &[f64],
        active: &ActiveSet,
    ) -> Option<usize> {
        let n = s.variables();
        self.grow(s, hessian, jacobian);
        self.values.fill(0.0);
        for e in &self.curved {
            if !active.bounds[e.row as usize] && !active.bounds[e.column as usize] {
                self.values[e.slot as usize] = hessian[e.from as usize];
            }
        }
        let mut largest = vec![0.0_f64; s.rows()];
        for e in &self.sloped {
            let row = e.row as usize;
            if active.rows[row] && !active.bounds[e.column as usize] {
                let value = jacobian[e.from as usize];
                self.values[e.slot as usize] = value;
                largest[row] = largest[row].max(value.abs());
            }
        }
        for (scale, largest) in self.scales[n..].iter_mut().zip(&largest) {
            *scale = if largest.is_finite() {
                (-(largest / STEEP).max(1.0).log2().round()).exp2()
            } else {
                1.0
            };
        }
        for e in &self.sloped {
            self.values[e.slot as usize] *= self.scales[n + e.row as usize];
        }
        for v in 0..n {
            self.shifts[v] = if active.bounds[v] { 0.0 } else { PRIMAL_SHIFT };
            self.values[self.diagonal[v]] += if active.bounds[v] { 1.0 } else { PRIMAL_SHIFT };
        }
        for r in 0..s.rows() {
            self.shifts[n + r] = if active.rows[r] { -DUAL_SHIFT } else { 0.0 };
            self.values[self.diagonal[n + r]] = if active.rows[r] { -DUAL_SHIFT } else { -1.0 };
        }
        if self.values.iter().any(|v| !v.is_finite()) {
            return None;
        }
        self.factorisations += 1;
        self.norm = self.pattern.symmetric_norm(&self.values);
        self.factors.as_mut()?.factorise(&self.values)
    }

    /// Solves with the last factorisation; `None` if the residual stays above a small share of
    /// the right-hand side, as it does where active gradients depend on each other. Close to a solution with large
    /// multipliers that share is below rounding; there it is enough that the residual hardly counts.
    pub(crate) fn solve(&mut self, rhs: &[f64]) -> Option<Vec<f64>> {
        let refined = self.refine(rhs)?;
        (refined.residual <= ACCEPTABLE || refined.miss <= NEGLIGIBLE).then_some(refined.x)
    }

    /// Solves with the last factorisation; `None` if the backward error stays large. For questions
    /// about the matrix itself: along flat directions the solution is so much larger than its
    /// right-hand side that rounding alone exceeds every share of the latter.
    pub(crate) fn solve_backward(&mut self, rhs: &[f64]) -> Option<Vec<f64>> {
        let refined = self.refine(rhs)?;
        (refined.backward <= BACKWARD).then_some(refined.x)
    }

    /// Solves with the last factorisation and refines, in scaled rows.
    ///
    /// The residual is that of the matrix without its shifts, so the shifts cost rounds of
    /// refinement but do not bend the solution. Refinement minimises the backward error
    /// `‖b − Kx‖ / (‖K‖ ‖x‖ + ‖b‖)`.
    fn refine(&mut self, rhs: &[f64]) -> Option<Refined> {
        let norm = self.norm;
        let factors = self.factors.as_mut()?;
        let scaled =
            |v: &[f64]| -> Vec<f64> { v.iter().zip(&self.scales).map(|(v, s)| v * s).collect() };
        let rhs = scaled(rhs);
        let size = max_abs(&rhs);
        let mut x = vec![0.0; rhs.len()];
        if size == 0.0 {
            return Some(Refined {
                x,
                miss: 0.0,
                residual: 0.0,
                backward: 0.0,
            });
        }
        let mut residual = rhs.clone();
        let mut best = f64::INFINITY;
        for _ in 0..ROUNDS {
            let mut correction = residual.clone();
            factors.solve(&mut correction);
            let trial: Vec<f64> = x.iter().zip(&correction).map(|(x, c)| x + c).collect();
            let mut product: Vec<f64> = trial
                .iter()
                .zip(&self.shifts)
                .map(|(x, shift)| -shift * x)
                .collect();
            self.pattern
                .add_symmetric_product(&self.values, &trial, &mut product);
            let trial_residual: Vec<f64> = rhs.iter().zip(&product).map(|(b, p)| b - p).collect();
            let error = max_abs(&trial_residual) / (norm * max_abs(&trial) + size);
            if error.is_nan() || error >= best {
                break;
            }
            (x, residual, best) = (trial, trial_residual, error);
            if best <= REFINED {
                break;
            }
        }
        let miss = residual
            .iter()
            .zip(&self.scales)
            .map(|(r, s)| (r / s).abs());
        Some(Refined {
            x: scaled(&x),
            miss: miss.fold(0.0, f64::max),
            residual: max_abs(&residual) / size,
            backward: best,
        })
    }

    /// Newton's step from `(x, y)` on `active`; `None` where the reduced Hessian is not positive definite, which the
    /// factors tell before anything is solved.
    pub(crate) fn convex_step(
        &mut self,
        s: &Structure,
        hessian: &[f64],
        at: &Iterate,
        active: &ActiveSet,
        limits: &Limits,
    ) -> Option<NewtonStep> {
        let positive = self.factorise(s, hessian, &at.jacobian, active)?;
        if positive != s.variables() {
            return None;
        }
        self.factorised_step(s, hessian, at, active, limits)
    }

    /// Newton's step from `(x, y)` on `active`, whatever the curvature.
    pub(crate) fn step(
        &mut self,
        s: &Structure,
        hessian: &[f64],
        at: &Iterate,
        active: &ActiveSet,
        limits: &Limits,
    ) -> Option<NewtonStep> {
        self.factorise(s, hessian, &at.jacobian, active)?;
        self.factorised_step(s, hessian, at, active, limits)
    }

    fn factorised_step(
        &mut self,
        s: &Structure,
        hessian: &[f64],
        at: &Iterate,
        active: &ActiveSet,
        limits: &Limits,
    ) -> Option<NewtonStep> {
        let Iterate {
            x,
            rows,
            gradient,
            jacobian,
            y,
            ..
        } = at;
        let (n, m) = (s.variables(), s.rows());
        let held: Vec<f64> = (0..n)
            .map(|v| {
                if active.bounds[v] {
                    limits.bounds[v] - x[v]
                } else {
                    0.0
                }
            })
            .collect();
        let y: Vec<f64> = (0..m)
            .map(|r| if active.rows[r] { y[r] } else { 0.0 })
            .collect();
        let mut pull = gradient.clone();
        s.jacobian.add_transposed_product(jacobian, &y, &mut pull);
        s.hessian.add_symmetric_product(hessian, &held, &mut pull);
        let mut moved = vec![0.0; m];
        s.jacobian.add_product(jacobian, &held, &mut moved);
        let mut rhs = vec![0.0; n + m];
        for v in 0..n {
            rhs[v] = if active.bounds[v] { held[v] } else { -pull[v] };
        }
        for r in 0..m {
            if active.rows[r] {
                rhs[n + r] = limits.rows[r] - rows[r] - moved[r];
            }
        }
        let solution = self.solve(&rhs)?;
        let d = solution[..n].to_vec();
        let y: Vec<f64> = (0..m)
            .map(|r| {
                if active.rows[r] {
                    y[r] + solution[n + r]
                } else {
                    0.0
                }
            })
            .collect();
        // z_j = −(g + Hd + Jᵀy)_j where a bound holds the variable.
        let mut z = gradient.clone();
        s.hessian.add_symmetric_product(hessian, &d, &mut z);
        s.jacobian.add_transposed_product(jacobian, &y, &mut z);
        for v in 0..n {
            z[v] = if active.bounds[v] { -z[v] } else { 0.0 };
        }
        Some(NewtonStep { d, y, z })
    }
}

/// The limit at which every held row or variable sits.
#[derive(Clone, Debug)]
pub(crate) struct Limits {
    pub rows: Vec<f64>,
    pub bounds: Vec<f64>,
}

impl Limits {
    /// The side is told by the multiplier; without one, by distance.
    pub(crate) fn of(s: &Structure, x: &[f64], rows: &[f64], y: &[f64], z: &[f64]) -> Self {
        let side = |value: f64, multiplier: f64, lower: f64, upper: f64| {
            if multiplier > 0.0 && upper.is_finite() {
                upper
            } else if multiplier < 0.0 && lower.is_finite() {
                lower
            } else {
                nearest_limit(value, lower, upper)
            }
        };
        Self {
            rows: (0..s.rows())
                .map(|r| side(rows[r], y[r], s.row_lower[r], s.row_upper[r]))
                .collect(),
            bounds: (0..s.variables())
                .map(|v| side(x[v], z[v], s.lower[v], s.upper[v]))
                .collect(),
        }
    }
}

//! The ℓ₁ merit function and its line search.
//!
//! ```text
//! φ(x; ρ) = f(x) + ρ v(x)          v = Σ_r max(0, c_r − u_r, l_r − c_r)
//! D       = gᵀd − ρ (v(x) − v_lin(x, d))
//! accept α when  φ(x + αd) ≤ φ(x) + η α D
//! ```
//!
//! `v_lin` is what the linearised rows still miss after the full step: zero
//! for a feasible subproblem, positive after an elastic one. (Nocedal and
//! Wright, Numerical Optimization, 2nd edition, section 18.3.)

use crate::model::Structure;

/// Share of the predicted decrease that a step must deliver.
pub(crate) const ARMIJO: f64 = 1e-4;
/// Increases below this share of |φ| are rounding.
pub(crate) const ROUNDING: f64 = 1e-12;

/// Σ of missed limits over all rows.
pub(crate) fn violation(s: &Structure, rows: &[f64]) -> f64 {
    misses(s, rows).sum()
}

/// The largest missed limit.
pub(crate) fn worst_violation(s: &Structure, rows: &[f64]) -> f64 {
    misses(s, rows).fold(0.0, f64::max)
}

/// Σ of missed limits of the linearised rows after the step `d`.
pub(crate) fn linear_violation(s: &Structure, rows: &[f64], jacobian: &[f64], d: &[f64]) -> f64 {
    let mut moved = rows.to_vec();
    s.jacobian.add_product(jacobian, d, &mut moved);
    violation(s, &moved)
}

fn misses<'a>(s: &'a Structure, rows: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
    rows.iter()
        .zip(s.row_lower.iter().zip(&s.row_upper))
        .map(|(&c, (&l, &u))| (c - u).max(l - c).max(0.0))
}

/// φ, ρ and D at the start of a line search.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Merit {
    /// φ(x; ρ).
    pub value: f64,
    /// Directional derivative bound D ≤ 0.
    pub slope: f64,
    /// ρ.
    pub penalty: f64,
}

impl Merit {
    /// Is the point with cost `f` and violation `v`, a step `alpha` away, good enough?
    pub(crate) fn accepts(&self, alpha: f64, f: f64, v: f64) -> bool {
        let trial = f + self.penalty * v;
        let slack = ROUNDING * self.value.abs().max(1.0);
        trial.is_finite() && trial <= self.value + ARMIJO * alpha * self.slope + slack
    }
}

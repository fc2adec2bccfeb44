//! First multipliers for a start that has none.
//!
//! ```text
//! minimise ‖∇f + J_Aᵀ y‖₂ over y        A: equalities and missed rows
//! ```
//!
//! With them the first Hessian knows the curvature of the constraints. Estimates
//! that are out of proportion or have the wrong sign are dropped.

use crate::iterate::Iterate;
use crate::model::Structure;
use crate::newton::{ActiveSet, NewtonSystem};
use crate::pattern::max_abs;

/// Estimates larger than this share of the gradient say more about the start than about the solution.
const LARGEST: f64 = 1e3;

/// Least-squares multipliers of the rows at a point, or zeros.
pub(crate) fn least_squares_multipliers(
    s: &Structure,
    newton: &mut NewtonSystem,
    at: &Iterate,
) -> Vec<f64> {
    let (n, m) = (s.variables(), s.rows());
    let missed = |r: usize| at.rows[r] > s.row_upper[r] || at.rows[r] < s.row_lower[r];
    let active = ActiveSet {
        rows: (0..m)
            .map(|r| s.row_lower[r] == s.row_upper[r] || missed(r))
            .collect(),
        bounds: (0..n).map(|v| s.lower[v] == s.upper[v]).collect(),
    };
    // ⎡ I   J_Aᵀ ⎤ ⎡ w ⎤   ⎡ −∇f ⎤
    // ⎣ J_A  0   ⎦ ⎣ y ⎦ = ⎣  0  ⎦
    let identity: Vec<f64> = s
        .hessian
        .entries()
        .map(|(_, r, c)| if r == c { 1.0 } else { 0.0 })
        .collect();
    let mut rhs = vec![0.0; n + m];
    for v in (0..n).filter(|&v| !active.bounds[v]) {
        rhs[v] = -at.gradient[v];
    }
    let zeros = vec![0.0; m];
    if newton
        .factorise(s, &identity, &at.jacobian, &active)
        .is_none()
    {
        return zeros;
    }
    let Some(solution) = newton.solve(&rhs) else {
        return zeros;
    };
    let mut y = solution[n..].to_vec();
    for r in 0..m {
        let wrong = (y[r] < 0.0 && s.row_lower[r] == f64::NEG_INFINITY)
            || (y[r] > 0.0 && s.row_upper[r] == f64::INFINITY);
        if !active.rows[r] || wrong {
            y[r] = 0.0;
        }
    }
    let largest = LARGEST * max_abs(&at.gradient).max(1.0);
    if max_abs(&y) > largest { zeros } else { y }
}

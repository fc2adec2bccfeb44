//! The second-order correction of a rejected full step.
//!
//! A full step that satisfies the linearised rows misses the curved ones by
//! O(‖d‖²), which may raise the merit function however close the solution is
//! (Maratos, 1978). The correction asks the same subproblem to also take off
//! what the full step missed:
//!
//! ```text
//! J d′ + (c(x + d) − J d)  in the limits
//! ```
//!
//! Only the right-hand side changes; the matrices are those of the subproblem.

use crate::model::Structure;

/// The rows that the corrected subproblem linearises from: c(x + d) − J d.
pub(crate) fn corrected_rows(
    s: &Structure,
    jacobian: &[f64],
    d: &[f64],
    trial_rows: &[f64],
) -> Vec<f64> {
    let back: Vec<f64> = d.iter().map(|v| -v).collect();
    let mut rows = trial_rows.to_vec();
    s.jacobian.add_product(jacobian, &back, &mut rows);
    rows
}

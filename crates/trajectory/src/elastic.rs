//! The elastic subproblem: what to do when the linearised rows contradict.
//!
//! ```text
//! minimise    ½ dᵀHd + gᵀd + γ Σ t         t ≥ 0
//! subject to  J_E d + c_E = t₊ − t₋,   l − t ≤ J_I d + c_I ≤ u + t
//! ```
//!
//! It always has a solution. The price γ starts at the merit function's
//! penalty and grows tenfold while the step would leave the violation as it is;
//! if even the largest price takes nothing off, the point is (to first order)
//! a minimiser of the violation.

use crate::merit;
use crate::model::Structure;
use crate::qp::{QpData, QpStep, Subproblem};

/// Outcome of the elastic phase.
pub(crate) enum ElasticStep {
    /// A step that takes something off the violation, and its price γ.
    Step(QpStep, f64),
    /// No step takes anything off the violation.
    NoRelief,
    /// Clarabel ended without a solution.
    Failed,
}

/// Solves elastic subproblems with rising price; counts them in `solved`.
pub(crate) fn solve(
    s: &Structure,
    subproblem: &mut Subproblem,
    data: &QpData<'_>,
    penalty: f64,
    max_penalty: f64,
    interior_iterations: &mut usize,
    solved: &mut usize,
) -> ElasticStep {
    let before = merit::violation(s, data.rows);
    let mut price = penalty.clamp(1.0, max_penalty);
    let mut best: Option<(QpStep, f64, f64)> = None;
    loop {
        subproblem.set_penalty(price);
        *solved += 1;
        match subproblem.solve(s, data, 1e-8) {
            Ok(step) => {
                *interior_iterations += step.iterations;
                let after = merit::linear_violation(s, data.rows, data.jacobian, &step.d);
                if best.as_ref().is_none_or(|b| after < b.2) {
                    best = Some((step, price, after));
                }
                if after <= 0.5 * before {
                    break;
                }
            }
            Err(_) if best.is_none() && price >= max_penalty => return ElasticStep::Failed,
            Err(_) => {}
        }
        if price >= max_penalty {
            break;
        }
        price = (price * 10.0).min(max_penalty);
    }
    match best {
        Some((step, price, after)) if after < before - 1e-6 * before.max(1e-6) => {
            ElasticStep::Step(step, price)
        }
        _ => ElasticStep::NoRelief,
    }
}

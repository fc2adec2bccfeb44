//! The elastic subproblem: what to do when the linearised rows contradict.
//!
//! ```text
//! minimise    ½ dᵀHd + gᵀd + γ Σ t         t ≥ 0
//! subject to  J_E d + c_E = t₊ − t₋,   l − t ≤ J_I d + c_I ≤ u + t
//! ```
//!
//! It always has a solution. The price γ starts at the merit function's
//! penalty, but not below `PULL ‖g‖∞`: at a price below the pull of the cost the cheapest point is one that misses rows
//! to please the cost, and a search that once stands there has to buy every row back along its curve. It grows tenfold while
//! the step would leave nearly all of the violation; if even the largest price takes nothing off, the point is (to first order)
//! a minimiser of the violation. No multiplier of its step exceeds γ.

use crate::merit;
use crate::model::Structure;
use crate::pattern::max_abs;
use crate::qp::{QpData, QpStep, Subproblem};

/// Price of a missed row in units of the cost's steepest slope (scaled).
const PULL: f64 = 10.0;
/// Share of the violation that a price must take off, or a larger one is tried.
const SHARE: f64 = 0.5;

/// The price at which rows may be missed at a point with this gradient of the cost.
pub(crate) fn price(penalty: f64, gradient: &[f64], max_penalty: f64) -> f64 {
    penalty
        .max(PULL * max_abs(gradient))
        .clamp(1.0, max_penalty)
}

/// Outcome of the elastic phase.
pub(crate) enum ElasticStep {
    /// A step that takes something off the violation, and its price γ.
    Step(QpStep, f64),
    /// No step takes anything off the violation.
    NoRelief,
    /// Clarabel ended without a solution.
    Failed,
}

/// Solves elastic subproblems with rising price from `price` on; counts them in `solved`.
pub(crate) fn solve(
    s: &Structure,
    subproblem: &mut Subproblem,
    data: &QpData<'_>,
    mut price: f64,
    max_penalty: f64,
    interior_iterations: &mut usize,
    solved: &mut usize,
) -> ElasticStep {
    let before = merit::violation(s, data.rows);
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
                if after <= (1.0 - SHARE) * before {
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

//! The polish: Newton's method on the identified active set to rounding level.
//!
//! After it the answer is fixed by equations, not by the path that led there:
//! the optimality error falls to about 1e-12 in two or three steps. The polish
//! only counts if no limit is crossed and no multiplier changes sign, both of
//! which the optimality error sees.

use crate::iterate::Iterate;
use crate::model::Evaluator;
use crate::newton::Limits;
use crate::proposal::Proposer;
use crate::solution::Counters;

/// Largest number of polishing steps. A strict minimum takes three or four; towards a minimum that is flat to fourth order the
/// error falls by some 0.3 a step, and only close to it does the vanishing curvature show.
const STEPS: usize = 24;
/// No step is taken below this optimality error.
const FINISHED: f64 = 1e-13;

/// Polishes `from`; returns the better point, or `None` if nothing got better.
pub(crate) fn polish(
    e: &dyn Evaluator,
    proposer: &mut Proposer<'_>,
    from: &Iterate,
    counters: &mut Counters,
) -> Option<Iterate> {
    let s = e.structure();
    let active = proposer.active.clone()?;
    let limits = Limits::of(s, &from.x, &from.rows, &from.y, &from.z);
    let mut best = from.clone();
    let mut best_error = from.error(e).worst();
    let mut improved = false;
    for _ in 0..STEPS {
        if best_error <= FINISHED || !proposer.refresh_hessian(&best, counters) {
            break;
        }
        let step = proposer
            .newton
            .step(s, &proposer.hessian, &best, &active, &limits);
        counters.factorisations = proposer.newton.factorisations;
        let Some(step) = step else { break };
        let x: Vec<f64> = best.x.iter().zip(&step.d).map(|(x, d)| x + d).collect();
        if x.iter().any(|v| !v.is_finite()) {
            break;
        }
        let trial = Iterate::new(e, x, step.y, step.z, counters);
        let error = trial.error(e).worst();
        if !trial.is_finite() || error >= best_error {
            break;
        }
        let slow = error > 0.5 * best_error;
        (best, best_error, improved) = (trial, error, true);
        counters.newton_steps += 1;
        if slow {
            break;
        }
    }
    improved.then_some(best)
}

//! Newton's step on an active set, revised until it solves the subproblem.
//!
//! The active set comes from Clarabel. Near the solution it is almost right:
//! a handful of limits are crossed by Newton's step or hold it with a multiplier
//! of the wrong sign. Those are exchanged (crossed limits enter, wrong signs
//! leave) and the step is solved again, one factorisation a round, until every
//! condition of the subproblem holds:
//!
//! ```text
//! J_A d = b_A,   inactive limits kept,   multipliers of the right sign,   Zᵀ H_α Z ≻ 0
//! ```
//!
//! Such a step *is* the minimiser of the subproblem with the Hessian `H_α`, whose
//! share α of the clipping is as small as the inertia allows. If a few rounds do
//! not settle it, Clarabel is asked again.

use crate::iterate::Iterate;
use crate::model::Structure;
use crate::newton::{ActiveSet, Limits, NewtonStep, NewtonSystem};
use crate::pattern::max_abs;

/// Longer steps (scaled variables) are left to the subproblem: scales make variables of order one, and an active set says
/// nothing about points several of its own sizes away. A bound, not a trust region: the merit function judges shorter steps.
const REACH: f64 = 3.0;
/// Most rounds of exchange.
const ROUNDS: usize = 8;
/// With more exchanges than this after the first round the set is not nearly right.
const NEARLY: usize = 40;
/// Smallest share of the clipping after none.
const FIRST_SHARE: f64 = 0.02;
/// Growth of the share.
const GROWTH: f64 = 4.0;
/// Slack with which limits and signs are judged (scaled).
const SLACK: f64 = 1e-9;

/// The exact Hessian and what full clipping would add to it.
pub(crate) struct Hessians<'a> {
    pub exact: &'a [f64],
    pub clipping: &'a [f64],
}

impl Hessians<'_> {
    /// H + α (H₊ − H).
    fn blend(&self, share: f64) -> Vec<f64> {
        self.exact
            .iter()
            .zip(self.clipping)
            .map(|(h, c)| h + share * c)
            .collect()
    }
}

/// A settled step: minimiser of the subproblem with `hessian`, on `active`.
pub(crate) struct Settled {
    pub step: NewtonStep,
    pub active: ActiveSet,
    pub hessian: Vec<f64>,
    pub share: f64,
}

/// Revises `active` until Newton's step on it solves the subproblem.
pub(crate) fn settle(
    s: &Structure,
    newton: &mut NewtonSystem,
    hessians: &Hessians<'_>,
    at: &Iterate,
    mut active: ActiveSet,
    mut limits: Limits,
    mut share: f64,
) -> Option<Settled> {
    let mut hessian = hessians.blend(share);
    for round in 0..ROUNDS {
        let step = newton.step(s, &hessian, at, &active, &limits)?;
        if !step.positive_definite || max_abs(&step.d) > REACH {
            if share >= 1.0 {
                return None;
            }
            share = (GROWTH * share).clamp(FIRST_SHARE, 1.0);
            hessian = hessians.blend(share);
            continue;
        }
        match exchange(s, at, &step, &mut active, &mut limits) {
            0 => {
                return Some(Settled {
                    step,
                    active,
                    hessian,
                    share,
                });
            }
            many if round == 0 && many > NEARLY => return None,
            _ => {}
        }
    }
    None
}

/// Exchanges what contradicts the subproblem's conditions; returns how much.
fn exchange(
    s: &Structure,
    at: &Iterate,
    step: &NewtonStep,
    active: &mut ActiveSet,
    limits: &mut Limits,
) -> usize {
    let slack = SLACK * (1.0 + max_abs(&step.y));
    let mut moved = at.rows.clone();
    s.jacobian.add_product(&at.jacobian, &step.d, &mut moved);
    let mut exchanged = 0;
    let mut judge =
        |held: &mut bool, limit: &mut f64, multiplier: f64, value: f64, lower: f64, upper: f64| {
            if lower == upper {
                return;
            }
            if *held {
                let wrong = (*limit == upper && multiplier < -slack)
                    || (*limit == lower && multiplier > slack);
                if wrong {
                    *held = false;
                    exchanged += 1;
                }
            } else if value > upper + SLACK || value < lower - SLACK {
                *limit = if value > upper { upper } else { lower };
                *held = true;
                exchanged += 1;
            }
        };
    for r in 0..s.rows() {
        let (lower, upper) = (s.row_lower[r], s.row_upper[r]);
        judge(
            &mut active.rows[r],
            &mut limits.rows[r],
            step.y[r],
            moved[r],
            lower,
            upper,
        );
    }
    for v in 0..s.variables() {
        let x = at.x[v] + step.d[v];
        judge(
            &mut active.bounds[v],
            &mut limits.bounds[v],
            step.z[v],
            x,
            s.lower[v],
            s.upper[v],
        );
    }
    exchanged
}

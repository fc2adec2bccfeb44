//! Newton's step on an active set, revised until it solves the subproblem.
//!
//! The active set comes from Clarabel. Near the solution it is almost right:
//! a handful of limits are crossed by Newton's step or hold it with a multiplier
//! of the wrong sign. Those are exchanged (crossed limits enter, wrong signs
//! leave) and the step is solved again, one factorisation a round, until every
//! condition of the subproblem holds:
//!
//! ```text
//! J_A d = b_A,   inactive limits kept,   multipliers of the right sign,   Zᵀ (H + δI) Z ≻ 0
//! ```
//!
//! Such a step *is* the minimiser of the subproblem with the Hessian `H + δI`, whose
//! shift δ is about as small as the inertia allows (`Shift`). If a few rounds do
//! not settle it, Clarabel is asked again.

use crate::iterate::Iterate;
use crate::model::Structure;
use crate::newton::{ActiveSet, Limits, NewtonStep, NewtonSystem};
use crate::pattern::max_abs;

/// Longer steps (scaled variables) are never believed: scales make variables of order one, and an active set says
/// nothing about points several of its own sizes away.
const FARTHEST: f64 = 3.0;
/// The reach does not fall below this.
const NEAREST: f64 = 0.05;
/// Most rounds of exchange.
const ROUNDS: usize = 8;
/// With more exchanges than this after the first round the set is not nearly right.
const NEARLY: usize = 40;
/// Most shifts tried at one point.
const SHIFTS: usize = 10;
/// Slack with which limits and signs are judged (scaled).
const SLACK: f64 = 1e-9;

/// The shift δ of the Hessian's diagonal that makes its reduced form positive definite.
///
/// None is tried first at every point; then a third of the last one that was needed, then larger ones by a
/// constant factor (Wächter and Biegler, Mathematical Programming 106, 2006, algorithm IC, whose numbers these are).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shift {
    last: f64,
    reach: f64,
}

impl Default for Shift {
    fn default() -> Self {
        Self {
            last: 0.0,
            reach: FARTHEST,
        }
    }
}

impl Shift {
    const FIRST: f64 = 1e-4;
    const LEAST: f64 = 1e-8;
    const LARGEST: f64 = 1e8;
    const FALL: f64 = 1.0 / 3.0;
    const GROWTH: f64 = 8.0;
    const FIRST_GROWTH: f64 = 100.0;

    /// The line search accepted the share `alpha` of a step of this length.
    pub(crate) fn learn(&mut self, alpha: f64, length: f64) {
        if alpha < 0.3 {
            self.reach = (2.0 * alpha * length).max(NEAREST);
        } else if alpha >= 0.9 {
            self.reach = (2.0 * self.reach).min(FARTHEST);
        }
    }

    /// What to try after `failed`; `None` if even the largest did not do.
    fn next(self, failed: f64) -> Option<f64> {
        let next = match (failed == 0.0, self.last == 0.0) {
            (true, true) => Self::FIRST,
            (true, false) => (Self::FALL * self.last).max(Self::LEAST),
            (false, true) => Self::FIRST_GROWTH * failed,
            (false, false) => Self::GROWTH * failed,
        };
        (next <= Self::LARGEST).then_some(next)
    }
}

/// A settled step: minimiser of the subproblem with `hessian`, on `active`.
pub(crate) struct Settled {
    pub step: NewtonStep,
    pub active: ActiveSet,
    pub hessian: Vec<f64>,
}

/// Revises `active` until Newton's step on it solves the subproblem.
///
/// A step that leaves the set's neighbourhood (too long, too many exchanges, or not settled in a few rounds) is tried
/// again from the same set with a larger shift, which shortens it.
pub(crate) fn settle(
    s: &Structure,
    newton: &mut NewtonSystem,
    exact: &[f64],
    at: &Iterate,
    active: &ActiveSet,
    limits: &Limits,
    shift: &mut Shift,
) -> Option<Settled> {
    let mut delta = 0.0;
    for _ in 0..SHIFTS {
        let mut hessian = exact.to_vec();
        s.hessian.add_to_diagonal(&mut hessian, delta);
        if let Some((step, active)) = exchanges(
            s,
            newton,
            &hessian,
            at,
            active.clone(),
            limits.clone(),
            shift.reach,
        ) {
            if delta > 0.0 {
                shift.last = delta;
            }
            return Some(Settled {
                step,
                active,
                hessian,
            });
        }
        delta = shift.next(delta)?;
    }
    None
}

/// Rounds of exchange with one Hessian; `None` if they do not settle.
fn exchanges(
    s: &Structure,
    newton: &mut NewtonSystem,
    hessian: &[f64],
    at: &Iterate,
    mut active: ActiveSet,
    mut limits: Limits,
    reach: f64,
) -> Option<(NewtonStep, ActiveSet)> {
    for round in 0..ROUNDS {
        let step = newton.convex_step(s, hessian, at, &active, &limits)?;
        if max_abs(&step.d) > reach {
            return None;
        }
        match exchange(s, at, &step, &mut active, &mut limits) {
            0 => return Some((step, active)),
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

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
//! shift δ is about as small as the inertia and the reach allow (`Shift`). If a few rounds do
//! not settle it, Clarabel is asked again.
//!
//! Exchanging everything at once is quick, but may go round in a circle even where `H` is positive definite (F. Curtis, Z. Han and D.
//! Robinson, Computational Optimization and Applications 60, 2015). So once the number of contradictions has not fallen for a few
//! rounds, they are resolved one by one, the last in the fixed order of rows and variables first, until it falls again, which for a
//! positive definite `H` comes to an end (J. Judice and F. Pires, Computers and Operations Research 21, 1994; K. Murty, 1974).

use crate::iterate::Iterate;
use crate::model::Structure;
use crate::newton::{ActiveSet, Limits, NewtonStep, NewtonSystem};
use crate::optimality::{gap, multiplier_size};
use crate::pattern::max_abs;
use crate::shift::{NEAREST, Shift};

/// Most rounds of exchange.
const ROUNDS: usize = 16;
/// Rounds without fewer exchanges than ever before, after which they are made one by one.
const PATIENCE: usize = 3;
/// With more exchanges than this after the first round the set is not nearly right.
const NEARLY: usize = 40;
/// With at most this many contradictions left after the last round a long step is taken as it is: the line search judges it, the
/// correction sees what it crosses, and the next point begins with the revised set. Close to the end only a settled step will do.
const FEW: usize = 12;
/// Most shifts tried at one point.
const SHIFTS: usize = 10;
/// Slack with which limits and signs are judged: crossings in scaled units, signs by the complementarity they leave. That is what a
/// certified point may have, so that no limit is kept which alone would withhold the certificate.
const SLACK: f64 = 1e-9;

/// A settled step: minimiser of the subproblem with `hessian`, on `active`.
pub(crate) struct Settled {
    pub step: NewtonStep,
    pub active: ActiveSet,
    pub hessian: Vec<f64>,
}

/// Revises `active` until Newton's step on it solves the subproblem.
///
/// A step that leaves the set's neighbourhood (too long, too many exchanges, or not settled in a few rounds) is tried
/// again from the same set with a larger shift, which shortens it; one that is short of the reach with a smaller one.
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
    // The largest shift that failed, and the step of the smallest that did not.
    let (mut failed, mut found) = (0.0, None::<(f64, Settled)>);
    let (mut active, mut limits) = (active.clone(), limits.clone());
    for _ in 0..SHIFTS {
        let mut hessian = exact.to_vec();
        s.hessian.add_to_diagonal(&mut hessian, delta);
        let (from, at_limits) = (active.clone(), limits.clone());
        let next = match exchanges(s, newton, &hessian, at, from, at_limits, shift.reach) {
            Trial::Settled(step, held, at_limits) => {
                let length = max_abs(&step.d);
                // A set that is right for this shift is nearly right for a smaller one.
                (active, limits) = (held.clone(), at_limits);
                let settled = Settled {
                    step,
                    active: held,
                    hessian,
                };
                found = Some((delta, settled));
                (delta > 0.0)
                    .then(|| shift.smaller(delta, length, failed))
                    .flatten()
            }
            _ if found.is_some() => None,
            Trial::Far(length) => shift.shortening(delta, length),
            Trial::Indefinite | Trial::Unsettled => shift.larger(delta),
        };
        if found.is_none() {
            failed = delta;
        }
        match next {
            Some(next) => delta = next,
            None => break,
        }
    }
    let (delta, settled) = found?;
    if delta > 0.0 {
        shift.last = delta;
    }
    Some(settled)
}

/// How a try with one shift ended.
enum Trial {
    Settled(NewtonStep, ActiveSet, Limits),
    /// The reduced Hessian is not positive definite, or the system could not be solved.
    Indefinite,
    /// The step is longer than the reach.
    Far(f64),
    /// The exchanges did not come to an end.
    Unsettled,
}

/// Rounds of exchange with one Hessian.
fn exchanges(
    s: &Structure,
    newton: &mut NewtonSystem,
    hessian: &[f64],
    at: &Iterate,
    mut active: ActiveSet,
    mut limits: Limits,
    reach: f64,
) -> Trial {
    let (mut fewest, mut patience) = (usize::MAX, PATIENCE);
    for round in 0..ROUNDS {
        let Some(mut step) = newton.convex_step(s, hessian, at, &active, &limits) else {
            return Trial::Indefinite;
        };
        let length = max_abs(&step.d);
        if length > reach {
            return Trial::Far(length);
        }
        let list = contradictions(s, at, &step, &active, &limits);
        let many = list.len();
        if many == 0 {
            return Trial::Settled(step, active, limits);
        }
        if round == 0 && many > NEARLY {
            return Trial::Unsettled;
        }
        if many < fewest {
            (fewest, patience) = (many, PATIENCE);
        } else {
            patience = patience.saturating_sub(1);
        }
        let last = round + 1 == ROUNDS;
        let exchanged = if patience > 0 || last {
            &list[..]
        } else {
            &list[many - 1..]
        };
        exchanged
            .iter()
            .for_each(|change| change.make(&mut active, &mut limits));
        if last && many <= FEW && length > NEAREST {
            release(&mut step, &active);
            return Trial::Settled(step, active, limits);
        }
    }
    Trial::Unsettled
}

/// Multipliers of what is not held are zero.
fn release(step: &mut NewtonStep, active: &ActiveSet) {
    for (y, held) in step.y.iter_mut().zip(&active.rows) {
        if !held {
            *y = 0.0;
        }
    }
    for (z, held) in step.z.iter_mut().zip(&active.bounds) {
        if !held {
            *z = 0.0;
        }
    }
}

/// A row or variable on the wrong side of the active set.
#[derive(Clone, Copy, Debug)]
enum Change {
    HoldRow(usize, f64),
    HoldBound(usize, f64),
    FreeRow(usize),
    FreeBound(usize),
}

impl Change {
    fn make(self, active: &mut ActiveSet, limits: &mut Limits) {
        match self {
            Self::HoldRow(r, limit) => (active.rows[r], limits.rows[r]) = (true, limit),
            Self::HoldBound(v, limit) => (active.bounds[v], limits.bounds[v]) = (true, limit),
            Self::FreeRow(r) => active.rows[r] = false,
            Self::FreeBound(v) => active.bounds[v] = false,
        }
    }
}

/// What contradicts the subproblem's conditions after a step.
fn contradictions(
    s: &Structure,
    at: &Iterate,
    step: &NewtonStep,
    active: &ActiveSet,
    limits: &Limits,
) -> Vec<Change> {
    // What the optimality error will say of a limit that holds with the wrong sign, in the same scale.
    let slack = SLACK * multiplier_size(&step.y, &step.z);
    let mut moved = at.rows.clone();
    s.jacobian.add_product(&at.jacobian, &step.d, &mut moved);
    // The limit that is crossed, or `NAN` for one that holds with the wrong sign.
    let judge = |held: bool, limit: f64, multiplier: f64, value: f64, lower: f64, upper: f64| {
        if lower == upper {
            None
        } else if held {
            (gap(limit, multiplier, lower, upper) > slack).then_some(f64::NAN)
        } else if value > upper + SLACK {
            Some(upper)
        } else {
            (value < lower - SLACK).then_some(lower)
        }
    };
    let rows = (0..s.rows()).filter_map(|r| {
        let (lower, upper) = (s.row_lower[r], s.row_upper[r]);
        let limit = judge(
            active.rows[r],
            limits.rows[r],
            step.y[r],
            moved[r],
            lower,
            upper,
        )?;
        Some(if limit.is_nan() {
            Change::FreeRow(r)
        } else {
            Change::HoldRow(r, limit)
        })
    });
    let bounds = (0..s.variables()).filter_map(|v| {
        let (lower, upper, x) = (s.lower[v], s.upper[v], at.x[v] + step.d[v]);
        let limit = judge(
            active.bounds[v],
            limits.bounds[v],
            step.z[v],
            x,
            lower,
            upper,
        )?;
        Some(if limit.is_nan() {
            Change::FreeBound(v)
        } else {
            Change::HoldBound(v, limit)
        })
    });
    rows.chain(bounds).collect()
}

#[cfg(test)]
mod tests {
    use crate::model::{Evaluator, Model};
    use crate::newton::ActiveSet;
    use crate::proposal::Proposer;
    use crate::solution::Counters;
    use crate::{Block, Options, Programme, Scalar, Variable};

    /// min ½ xᵀHx + cᵀx, x ≤ 0, with the positive definite H on which exchanges of everything at once circle (Curtis, Han and
    /// Robinson, 2015); c is theirs by a hundredth, so that steps are within reach.
    struct Circling;

    impl Programme for Circling {
        fn variables(&self) -> Vec<Variable> {
            let below = |name: &str| Variable::new(name, f64::NEG_INFINITY, 0.0, 1.0);
            vec![below("x1"), below("x2"), below("x3")]
        }

        fn blocks(&self) -> Vec<Block> {
            vec![Block::new("cost", vec![0, 1, 2], vec![])]
        }

        fn evaluate<D: Scalar>(&self, _: usize, x: &[D], f: &mut D, _: &mut [D]) {
            let squares = x[0] * x[0] * 2.0 + x[1] * x[1] * 4.5 + x[2] * x[2] * 3.5;
            let products = (x[0] * x[1] - x[0] * x[2] - x[1] * x[2]) * 5.0;
            *f = squares + products + x[0] * 0.02 + x[1] * 0.01 - x[2] * 0.03;
        }
    }

    #[test]
    fn exchanges_from_every_set_come_to_an_end() {
        let model = Model::new(&Circling).expect("a programme");
        let options = Options::default();
        let mut counters = Counters::default();
        let at = crate::iterate::Iterate::new(
            &model,
            vec![-1.0; 3],
            vec![],
            vec![0.0; 3],
            &mut counters,
        );
        for set in 0..8 {
            let mut proposer = Proposer::new(&model, &options);
            assert!(proposer.refresh_hessian(&at, &mut counters));
            proposer.active = Some(ActiveSet {
                rows: vec![false; model.structure().rows()],
                bounds: (0..3).map(|v| set & (1 << v) != 0).collect(),
            });
            let step = proposer.newton_step(&at, &mut counters).expect("settled");
            let x: Vec<f64> = at.x.iter().zip(&step.d).map(|(x, d)| x + d).collect();
            let right = [-0.005, 0.0, 0.0];
            let near = x.iter().zip(right).all(|(x, r)| (x - r).abs() < 1e-12);
            assert!(near, "from set {set}: {x:?}");
        }
    }
}

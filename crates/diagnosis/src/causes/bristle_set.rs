//! A lasting bend: the lean of a run is theta0 + angle S. After a reverse run S moves towards 1, after a forward run towards
//! 0, by the share 1 - exp(-1/runs) of what is left; a run that reverses leaves it as it is. S = 0 before the first run. In a further
//! form forward runs leave it as it is too, in another one a run that reverses counts by the way in which it ends. In the last
//! two S moves while the contact slides, dS/ds = (goal - S) / d, d a distance (m): towards 1 in reverse and 0 forward, or always towards 0
//! from the 1 that a run which ends in reverse has left.

use std::collections::BTreeMap;

use friction::{ParameterSpec, Scalar, LawKind, Law};
use rig::{Cause, Experiment, Place, Reach, Requirement, Station};
use campaign::Direction;

use super::{grids, marker};

/// The bristles keep a lasting bend after reverse runs.
#[derive(Clone, Copy, Debug)]
pub struct BristleSet;

const PARAMETERS: &[ParameterSpec] = &[
    ParameterSpec::new("angle_rad", "rad", "bend after many reverse runs", -1.0, 1.0, 0.05).with_null(0.0),
    ParameterSpec::new("runs", "1", "runs in which the bend settles", 0.1, 100.0, 2.0),
];

impl Cause for BristleSet {
    fn id(&self) -> &'static str {
        "bristle-set"
    }

    fn station(&self) -> Station {
        Station::History
    }

    fn reach(&self) -> Reach {
        Reach::Law
    }

    fn describe(&self) -> &'static str {
        "The bristles keep a lasting bend after reverse runs."
    }

    fn parameters(&self) -> &'static [ParameterSpec] {
        PARAMETERS
    }

    fn requirements(&self) -> &'static [Requirement] {
        &[Requirement::Order, Requirement::BothDirections]
    }

    fn applies_to(&self, law: LawKind) -> bool {
        law.needs_height()
    }

    fn memory(&self) -> usize {
        1
    }

    fn shape_grid(&self, _experiment: &Experiment) -> Vec<Vec<f64>> {
        [0.3, 1.0, 2.0, 4.0, 10.0].iter().map(|&runs| vec![0.0, runs]).collect()
    }

    fn law<D: Scalar>(&self, p: &[D], at: Place<'_>, law: &mut Law<D>, memory: &mut [D]) {
        lean(p, law, memory[0]);
        if let Some(bends) = bends(at) {
            settle(p, if bends { 1.0 } else { 0.0 }, &mut memory[0]);
        }
    }
}

/// The same where forward runs do not straighten the bristles again.
#[derive(Clone, Copy, Debug)]
pub struct KeptSet;

/// Beside bend and runs, what tells this form from the other one in a file.
const KEPT: &str = "kept";

impl Cause for KeptSet {
    marker::marked_form!(BristleSet, "kept by forward runs", KEPT);

    fn requirements(&self) -> &'static [Requirement] {
        BristleSet.requirements()
    }

    fn shape_grid(&self, experiment: &Experiment) -> Vec<Vec<f64>> {
        BristleSet.shape_grid(experiment)
    }

    fn law<D: Scalar>(&self, p: &[D], at: Place<'_>, law: &mut Law<D>, memory: &mut [D]) {
        lean(p, law, memory[0]);
        if bends(at) == Some(true) {
            settle(p, 1.0, &mut memory[0]);
        }
    }
}

/// The same where a run that reverses counts by the way in which it ends.
#[derive(Clone, Copy, Debug)]
pub struct LastWaySet;

/// Beside bend and runs, what tells this form from the others in a file.
const LAST_WAY: &str = "by_last_way";

impl Cause for LastWaySet {
    marker::marked_form!(BristleSet, "runs count by their last way", LAST_WAY);

    fn requirements(&self) -> &'static [Requirement] {
        &[Requirement::Order, Requirement::BothDirections, Requirement::Reversals]
    }

    fn shape_grid(&self, experiment: &Experiment) -> Vec<Vec<f64>> {
        BristleSet.shape_grid(experiment)
    }

    fn law<D: Scalar>(&self, p: &[D], at: Place<'_>, law: &mut Law<D>, memory: &mut [D]) {
        lean(p, law, memory[0]);
        if let Some(bends) = bends(at).or_else(|| ends(at)) {
            settle(p, if bends { 1.0 } else { 0.0 }, &mut memory[0]);
        }
    }
}

const OF_THE_WAY: &[ParameterSpec] = &[
    ParameterSpec::new("angle_rad", "rad", "bend after a long way in reverse", -1.0, 1.0, 0.05).with_null(0.0),
    ParameterSpec::new("distance_m", "m", "way in which the bend settles", 1e-9, 1e9, 1.0),
];

/// What the forms share in which the bend settles within runs.
macro_rules! within_runs {
    ($variant:literal) => {
        marker::form_of!(BristleSet, $variant, Reach::Along);

        fn parameters(&self) -> &'static [ParameterSpec] {
            OF_THE_WAY
        }

        fn parameters_for(&self, experiment: &Experiment) -> Vec<ParameterSpec> {
            let (run, all) = grids::slid_m(experiment);
            vec![OF_THE_WAY[0].clone(), grids::bounded(&OF_THE_WAY[1], 0.02 * run, 3.0 * all, run)]
        }

        fn requirements(&self) -> &'static [Requirement] {
            BristleSet.requirements()
        }

        fn applies_to(&self, law: LawKind) -> bool {
            BristleSet.applies_to(law)
        }

        fn memory(&self) -> usize {
            BristleSet.memory()
        }

        fn shape_grid(&self, experiment: &Experiment) -> Vec<Vec<f64>> {
            let (run, _) = grids::slid_m(experiment);
            [0.2, 0.6, 2.0].iter().map(|&runs| vec![0.0, runs * run]).collect()
        }

        fn law<D: Scalar>(&self, p: &[D], _at: Place<'_>, law: &mut Law<D>, memory: &mut [D]) {
            lean(p, law, memory[0]);
        }
    };
}

/// The same where the bend settles with every bit of the way, and not at the end of a run.
#[derive(Clone, Copy, Debug)]
pub struct SlidingSet;

impl Cause for SlidingSet {
    within_runs!("settles within runs");

    fn along<D: Scalar>(&self, p: &[D], at: Place<'_>, share: &mut [D], memory: &mut [D]) {
        let run = at.run;
        let turn = if run.specimen_turned { -1.0 } else { 1.0 };
        go(p, at, share, memory, |i| {
            let back = turn * (run.velocity_m_s[i] + run.velocity_m_s[i + 1]) < 0.0;
            if back { 1.0 } else { 0.0 }
        });
    }
}

/// The same where a run that ends in reverse leaves the whole bend, which is lost with the way of the next ones.
#[derive(Clone, Copy, Debug)]
pub struct LostSet;

/// Beside bend and distance, what tells this form from the one before in a file.
const LEFT_BY_RUNS: &str = "left_by_runs";

impl Cause for LostSet {
    within_runs!("lost within runs");

    fn reported(&self, fitted: &[f64]) -> Vec<rig::Reported> {
        marker::marked(SlidingSet.reported(fitted), LEFT_BY_RUNS)
    }

    fn from_reported(&self, reported: &BTreeMap<String, f64>) -> Result<Vec<f64>, String> {
        marker::demanded(reported, LEFT_BY_RUNS)?;
        SlidingSet.from_reported(reported)
    }

    fn along<D: Scalar>(&self, p: &[D], at: Place<'_>, share: &mut [D], memory: &mut [D]) {
        go(p, at, share, memory, |_| 0.0);
        if bends(at).or_else(|| ends(at)) == Some(true) {
            memory[0] = D::constant(1.0);
        }
    }
}

/// S at the samples, which moves from each to the next towards its goal there.
fn go<D: Scalar>(p: &[D], at: Place<'_>, share: &mut [D], memory: &mut [D], goal: impl Fn(usize) -> f64) {
    let run = at.run;
    let bend = &mut memory[0];
    share[0] = *bend;
    for i in 1..share.len() {
        if run.in_contact() {
            let slid = run.distance_m[i] - run.distance_m[i - 1];
            let kept = (-(p[1].recip() * slid)).exp();
            let goal = goal(i - 1);
            *bend = (*bend - goal) * kept + goal;
        }
        share[i] = *bend;
    }
}

/// theta0 + angle S.
fn lean<D: Scalar>(p: &[D], law: &mut Law<D>, bend: D) {
    if let Some(lean) = &mut law.lean {
        lean.angle += p[0] * bend;
    }
}

/// Whether a run bends the bristles or straightens them; a specimen turned round is bent by the other direction. `None` of a run that
/// reverses or touches nothing.
fn bends(at: Place<'_>) -> Option<bool> {
    match at.run.direction {
        _ if !at.run.in_contact() => None,
        Direction::Both => None,
        direction => Some((direction == Direction::Reverse) != at.run.specimen_turned),
    }
}

/// Whether the way in which a run ends bends the bristles; `None` of one that touches nothing or does not move.
fn ends(at: Place<'_>) -> Option<bool> {
    let last = at.run.velocity_m_s.iter().rev().find(|v| **v != 0.0)?;
    let in_contact = at.run.in_contact();
    in_contact.then_some((*last < 0.0) != at.run.specimen_turned)
}

/// S moves towards its goal by the share 1 - exp(-1/runs) of what is left.
fn settle<D: Scalar>(p: &[D], goal: f64, bend: &mut D) {
    let share = -(-p[1].recip()).exp() + 1.0;
    *bend = *bend + (-*bend + goal) * share;
}

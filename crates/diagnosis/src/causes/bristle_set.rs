//! A lasting bend: the lean of a run is theta0 + angle S. After a reverse run S moves towards 1, after a forward run towards
//! 0, by the share 1 - exp(-1/runs) of what is left; a run that reverses leaves it as it is. S = 0 before the first run. In a further
//! form forward runs leave it as it is too, in another one a run that reverses counts by the way in which it ends.

use friction::{ParameterSpec, Scalar, LawKind, Law};
use rig::{Cause, Experiment, Place, Reach, Requirement, Station};
use campaign::Direction;

use super::marker;

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
        let ends = || {
            let last = at.run.velocity_m_s.iter().rev().find(|v| **v != 0.0)?;
            let in_contact = at.run.in_contact();
            in_contact.then_some((*last < 0.0) != at.run.specimen_turned)
        };
        if let Some(bends) = bends(at).or_else(ends) {
            settle(p, if bends { 1.0 } else { 0.0 }, &mut memory[0]);
        }
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

/// S moves towards its goal by the share 1 - exp(-1/runs) of what is left.
fn settle<D: Scalar>(p: &[D], goal: f64, bend: &mut D) {
    let share = -(-p[1].recip()).exp() + 1.0;
    *bend = *bend + (-*bend + goal) * share;
}

//! A lasting bend: the lean of a run is theta0 + angle S. After a reverse run S moves towards 1, after a forward run towards
//! 0, by the share 1 - exp(-1/runs) of what is left; a run that reverses leaves it as it is. S = 0 before the first run.

use friction::{ParameterSpec, Scalar, LawKind, Law};
use rig::{Cause, Experiment, Place, Reach, Requirement, Station};
use campaign::Direction;

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
        if let Some(lean) = &mut law.lean {
            lean.angle += p[0] * memory[0];
        }
        if !at.run.in_contact() {
            return;
        }
        // a specimen turned round is bent by the other direction
        let goal = match (at.run.direction, at.run.specimen_turned) {
            (Direction::Reverse, false) | (Direction::Forward, true) => 1.0,
            (Direction::Forward, false) | (Direction::Reverse, true) => 0.0,
            (Direction::Both, _) => return,
        };
        let share = -(-p[1].recip()).exp() + 1.0;
        memory[0] = memory[0] + (-memory[0] + goal) * share;
    }
}

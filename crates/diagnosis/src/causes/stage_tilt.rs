//! A stage that is not level: F + N sin(angle), with the other sign where the rig was turned round.

use friction::{ParameterSpec, Scalar};
use rig::{Cause, Place, Reach, Requirement, Station};

/// A component of the weight acts along the stage.
#[derive(Clone, Copy, Debug)]
pub struct StageTilt;

const PARAMETERS: &[ParameterSpec] = &[
    ParameterSpec::new("angle_rad", "rad", "angle of the stage against the level", -0.5, 0.5, 0.01).with_null(0.0),
];

impl Cause for StageTilt {
    fn id(&self) -> &'static str {
        "stage-tilt"
    }

    fn station(&self) -> Station {
        Station::Load
    }

    fn reach(&self) -> Reach {
        Reach::Record
    }

    fn describe(&self) -> &'static str {
        "A component of the weight acts along the stage."
    }

    fn parameters(&self) -> &'static [ParameterSpec] {
        PARAMETERS
    }

    fn requirements(&self) -> &'static [Requirement] {
        &[Requirement::Load]
    }

    fn record<D: Scalar>(&self, p: &[D], at: Place<'_>, force_n: &mut [D]) {
        let side = if at.run.stage_turned { -1.0 } else { 1.0 };
        let share = p[0].sin() * side;
        for (f, &load) in force_n.iter_mut().zip(&at.run.load_n) {
            *f += share * load;
        }
    }
}

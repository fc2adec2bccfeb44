//! The force channel reads a share of the normal load: F + k N, whichever way the rig stands.

use friction::{ParameterSpec, Scalar};
use rig::{Cause, Place, Reach, Requirement, Station};

/// The force channel reads part of the normal load.
#[derive(Clone, Copy, Debug)]
pub struct LoadCrosstalk;

const PARAMETERS: &[ParameterSpec] = &[
    ParameterSpec::new("ratio", "1", "share of the load in the force channel", -0.9, 0.9, 0.01).with_null(0.0),
];

impl Cause for LoadCrosstalk {
    fn id(&self) -> &'static str {
        "load-crosstalk"
    }

    fn station(&self) -> Station {
        Station::Sensor
    }

    fn rank(&self) -> u8 {
        1
    }

    fn reach(&self) -> Reach {
        Reach::Record
    }

    fn describe(&self) -> &'static str {
        "The force channel reads part of the normal load."
    }

    fn parameters(&self) -> &'static [ParameterSpec] {
        PARAMETERS
    }

    fn requirements(&self) -> &'static [Requirement] {
        &[Requirement::Load]
    }

    fn record<D: Scalar>(&self, p: &[D], at: Place<'_>, force_n: &mut [D]) {
        for (f, &load) in force_n.iter_mut().zip(&at.run.load_n) {
            *f += p[0] * load;
        }
    }
}

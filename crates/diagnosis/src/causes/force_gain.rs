//! The gain of the force channel: F (1 + e).

use friction::{ParameterSpec, Scalar};
use rig::{Cause, Place, Reach, Station};

/// The force reads too large or too small.
#[derive(Clone, Copy, Debug)]
pub struct ForceGain;

const PARAMETERS: &[ParameterSpec] = &[
    ParameterSpec::new("gain_minus_1", "1", "gain of the force channel, less one", -0.95, 20.0, 0.05).with_null(0.0),
];

impl Cause for ForceGain {
    fn id(&self) -> &'static str {
        "force-gain"
    }

    fn station(&self) -> Station {
        Station::Sensor
    }

    fn rank(&self) -> u8 {
        3
    }

    fn reach(&self) -> Reach {
        Reach::Record
    }

    fn describe(&self) -> &'static str {
        "The force reads too large or too small."
    }

    fn parameters(&self) -> &'static [ParameterSpec] {
        PARAMETERS
    }

    fn record<D: Scalar>(&self, p: &[D], _at: Place<'_>, force_n: &mut [D]) {
        force_n.iter_mut().for_each(|f| *f *= p[0] + 1.0);
    }
}

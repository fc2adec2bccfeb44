//! The force channel is quantised: F rounded to the nearest multiple of a step (N). Rounding has no derivative in the step;
//! that of the force is passed on. Step 0 stands for a channel that is not quantised.

use friction::{ParameterSpec, Scalar};
use rig::{Cause, Experiment, Place, Reach, Station};

use super::grids;

/// The force is recorded in coarse steps.
#[derive(Clone, Copy, Debug)]
pub struct ForceResolution;

const PARAMETERS: &[ParameterSpec] = &[
    ParameterSpec::new("step_n", "N", "step of the record", 0.0, 1e9, 0.01).with_null(0.0),
];

impl Cause for ForceResolution {
    fn id(&self) -> &'static str {
        "force-resolution"
    }

    fn station(&self) -> Station {
        Station::Sensor
    }

    fn rank(&self) -> u8 {
        6
    }

    fn reach(&self) -> Reach {
        Reach::Record
    }

    fn describe(&self) -> &'static str {
        "The force is recorded in coarse steps."
    }

    fn parameters(&self) -> &'static [ParameterSpec] {
        PARAMETERS
    }

    fn parameters_for(&self, experiment: &Experiment) -> Vec<ParameterSpec> {
        let force = experiment.scales.force_n;
        vec![grids::bounded(&PARAMETERS[0], 0.0, force, 0.01 * force)]
    }

    fn is_data_integrity(&self) -> bool {
        true
    }

    fn record<D: Scalar>(&self, p: &[D], _at: Place<'_>, force_n: &mut [D]) {
        let step = p[0].value();
        if step > 0.0 {
            for f in force_n {
                *f += (f.value() / step).round() * step - f.value();
            }
        }
    }
}

//! The force channel clips: F is held between -level and +level (N). Level 0 stands for a channel that does not clip.

use friction::{ParameterSpec, Scalar};
use rig::{Cause, Experiment, Place, Reach, Station};

use super::grids;

/// The force channel clips at a level.
#[derive(Clone, Copy, Debug)]
pub struct ForceSaturation;

const PARAMETERS: &[ParameterSpec] = &[
    ParameterSpec::new("level_n", "N", "level at which the force clips; 0: none", 0.0, 1e9, 1.0).with_null(0.0),
];

impl Cause for ForceSaturation {
    fn id(&self) -> &'static str {
        "force-saturation"
    }

    fn station(&self) -> Station {
        Station::Sensor
    }

    fn rank(&self) -> u8 {
        5
    }

    fn reach(&self) -> Reach {
        Reach::Record
    }

    fn describe(&self) -> &'static str {
        "The force channel clips at a level."
    }

    fn parameters(&self) -> &'static [ParameterSpec] {
        PARAMETERS
    }

    fn parameters_for(&self, experiment: &Experiment) -> Vec<ParameterSpec> {
        let force = experiment.scales.force_n;
        vec![grids::bounded(&PARAMETERS[0], 0.0, 2.0 * force, 0.95 * force)]
    }

    fn is_data_integrity(&self) -> bool {
        true
    }

    fn record<D: Scalar>(&self, p: &[D], _at: Place<'_>, force_n: &mut [D]) {
        for f in force_n {
            if f.value() > p[0].value() {
                *f = p[0];
            } else if f.value() < -p[0].value() {
                *f = -p[0];
            }
        }
    }
}

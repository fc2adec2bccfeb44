//! The zero of the force channel: F + b, b in N, the same in both directions and at any load.

use friction::{ParameterSpec, Scalar};
use rig::{Cause, Experiment, Place, Reach, Station};

use super::grids;

/// A constant force is added to the record.
#[derive(Clone, Copy, Debug)]
pub struct ForceZeroOffset;

const PARAMETERS: &[ParameterSpec] = &[
    ParameterSpec::new("force_n", "N", "force at zero", -1e9, 1e9, 0.1).with_null(0.0),
];

impl Cause for ForceZeroOffset {
    fn id(&self) -> &'static str {
        "force-zero-offset"
    }

    fn station(&self) -> Station {
        Station::Sensor
    }

    fn rank(&self) -> u8 {
        4
    }

    fn reach(&self) -> Reach {
        Reach::Record
    }

    fn describe(&self) -> &'static str {
        "A constant force is added to the record."
    }

    fn parameters(&self) -> &'static [ParameterSpec] {
        PARAMETERS
    }

    fn mistaken_for(&self) -> &'static [&'static str] {
        &["force-zero-drift"]
    }

    fn parameters_for(&self, experiment: &Experiment) -> Vec<ParameterSpec> {
        let force = experiment.scales.force_n;
        vec![grids::bounded(&PARAMETERS[0], -force, force, 0.02 * force)]
    }

    fn record<D: Scalar>(&self, p: &[D], _at: Place<'_>, force_n: &mut [D]) {
        force_n.iter_mut().for_each(|f| *f += p[0]);
    }
}

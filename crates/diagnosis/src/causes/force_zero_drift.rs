//! The zero of the force channel moves with the campaign's clock: F + r T, T the time since the start of the first run (s),
//! r the rate (N/s).

use friction::{ParameterSpec, Scalar};
use rig::{Cause, Experiment, Place, Reach, Requirement, Station};

use super::grids;

/// The zero of the force channel drifts with the campaign's clock.
#[derive(Clone, Copy, Debug)]
pub struct ForceZeroDrift;

const PARAMETERS: &[ParameterSpec] = &[
    ParameterSpec::new("rate_n_s", "N/s", "rate of the zero", -1e9, 1e9, 1e-4).with_null(0.0),
];

impl Cause for ForceZeroDrift {
    fn id(&self) -> &'static str {
        "force-zero-drift"
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
        "The zero of the force channel drifts with the campaign's clock."
    }

    fn parameters(&self) -> &'static [ParameterSpec] {
        PARAMETERS
    }

    fn parameters_for(&self, experiment: &Experiment) -> Vec<ParameterSpec> {
        let rate = experiment.scales.force_n / grids::day_s(experiment);
        vec![grids::bounded(&PARAMETERS[0], -3.0 * rate, 3.0 * rate, 0.02 * rate)]
    }

    fn requirements(&self) -> &'static [Requirement] {
        &[Requirement::Clock]
    }

    fn record<D: Scalar>(&self, p: &[D], at: Place<'_>, force_n: &mut [D]) {
        let Some(started) = at.run.started_s else { return };
        for (f, &t) in force_n.iter_mut().zip(&at.run.time_s) {
            *f += p[0] * (started + t);
        }
    }
}

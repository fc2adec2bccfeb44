//! Force and velocity channels are shifted against each other: F_rec(t) = F(t - d), d in s, positive where the force comes late.

use friction::{ParameterSpec, Scalar};
use rig::{Cause, Experiment, Place, Reach, RunMotion, Station};

use super::grids;

/// The force channel is late or early against the velocity channel.
#[derive(Clone, Copy, Debug)]
pub struct ClockOffset;

const PARAMETERS: &[ParameterSpec] = &[
    ParameterSpec::new("delay_s", "s", "delay of the force channel", -1e9, 1e9, 0.05).with_null(0.0),
];

impl Cause for ClockOffset {
    fn id(&self) -> &'static str {
        "clock-offset"
    }

    fn station(&self) -> Station {
        Station::Clock
    }

    fn reach(&self) -> Reach {
        Reach::Record
    }

    fn describe(&self) -> &'static str {
        "The force channel is late or early against the velocity channel."
    }

    fn parameters(&self) -> &'static [ParameterSpec] {
        PARAMETERS
    }

    fn parameters_for(&self, experiment: &Experiment) -> Vec<ParameterSpec> {
        let run = grids::duration_s(experiment);
        vec![grids::bounded(&PARAMETERS[0], -0.3 * run, 0.3 * run, 0.01 * run)]
    }

    fn starts(&self, experiment: &Experiment) -> Vec<Vec<f64>> {
        let delays = grids::delays_s(experiment);
        delays.iter().flat_map(|&t| [vec![t], vec![-t]]).collect()
    }

    fn mistaken_for(&self) -> &'static [&'static str] {
        &["sensor-lag", "velocity-lag", "frictional-memory"]
    }

    fn lateness_s(&self, p: &[f64]) -> f64 {
        p[0]
    }

    fn steps_a_sample(&self, p: &[f64], run: &RunMotion) -> usize {
        grids::steps_within(p[0], run)
    }

    fn record<D: Scalar>(&self, p: &[D], at: Place<'_>, force_n: &mut [D]) {
        rig::signal::delay(&at.run.time_s, force_n, p[0]);
    }
}

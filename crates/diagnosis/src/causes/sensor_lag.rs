//! First-order low-pass in the force channel: tau F_rec' = F - F_rec, tau in s; the record starts settled.

use friction::{ParameterSpec, Scalar};
use rig::{Cause, Experiment, Place, Reach, RunMotion, Station};

use super::{grids, marker};

/// The force channel is low-pass filtered.
#[derive(Clone, Copy, Debug)]
pub struct SensorLag;

const PARAMETERS: &[ParameterSpec] = &[
    ParameterSpec::new("time_constant_s", "s", "time constant of the filter", 0.0, 1e9, 0.05).with_null(0.0),
];

impl Cause for SensorLag {
    fn id(&self) -> &'static str {
        "sensor-lag"
    }

    fn station(&self) -> Station {
        Station::Sensor
    }

    fn rank(&self) -> u8 {
        2
    }

    fn reach(&self) -> Reach {
        Reach::Record
    }

    fn describe(&self) -> &'static str {
        "The force channel is low-pass filtered."
    }

    fn parameters(&self) -> &'static [ParameterSpec] {
        PARAMETERS
    }

    fn parameters_for(&self, experiment: &Experiment) -> Vec<ParameterSpec> {
        let run = grids::duration_s(experiment);
        vec![grids::bounded(&PARAMETERS[0], 0.0, 0.5 * run, 0.01 * run)]
    }

    fn starts(&self, experiment: &Experiment) -> Vec<Vec<f64>> {
        grids::delays_s(experiment).into_iter().map(|t| vec![t]).collect()
    }

    fn lateness_s(&self, p: &[f64]) -> f64 {
        p[0]
    }

    fn steps_a_sample(&self, p: &[f64], run: &RunMotion) -> usize {
        grids::steps_within(p[0], run)
    }

    fn record<D: Scalar>(&self, p: &[D], at: Place<'_>, force_n: &mut [D]) {
        rig::signal::lag(&at.run.time_s, force_n, p[0]);
    }
}

/// Two equal stages of half the time constant each: the record lags behind by the same time, and sets in more gently.
#[derive(Clone, Copy, Debug)]
pub struct TwoStageLag;

/// Beside the time constant, what tells this form from the plain one in a file.
const TWO_STAGES: &str = "two_stages";

impl Cause for TwoStageLag {
    marker::marked_form!(SensorLag, "two stages", TWO_STAGES);

    /// Beside a law that bends it explains too much on its own.
    fn refines(&self) -> bool {
        true
    }

    fn rank(&self) -> u8 {
        SensorLag.rank()
    }

    fn starts(&self, experiment: &Experiment) -> Vec<Vec<f64>> {
        SensorLag.starts(experiment)
    }

    fn lateness_s(&self, p: &[f64]) -> f64 {
        SensorLag.lateness_s(p)
    }

    fn steps_a_sample(&self, p: &[f64], run: &RunMotion) -> usize {
        SensorLag.steps_a_sample(p, run)
    }

    fn record<D: Scalar>(&self, p: &[D], at: Place<'_>, force_n: &mut [D]) {
        for _ in 0..2 {
            rig::signal::lag(&at.run.time_s, force_n, p[0] * 0.5);
        }
    }
}

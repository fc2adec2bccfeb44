//! Low-pass in the force channel: tau F_rec' = F - F_rec, tau in s; the record starts settled.

use friction::{ParameterSpec, Scalar};
use rig::second_order::lag_second_order;
use rig::{Cause, Experiment, Place, Reach, RunMotion, Station};

use super::grids;
use super::second_order::second_order_form;

/// The force channel is low-pass filtered.
#[derive(Clone, Copy, Debug)]
pub struct SensorLag;

const TIME_CONSTANT: ParameterSpec =
    ParameterSpec::new("time_constant_s", "s", "time constant of the filter", 0.0, 1e9, 0.05).with_null(0.0);
const PARAMETERS: &[ParameterSpec] = &[TIME_CONSTANT];

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

    fn mistaken_for(&self) -> &'static [&'static str] {
        &["frictional-memory"]
    }

    fn lateness_s(&self, p: &[f64]) -> f64 {
        p[0]
    }

    fn filters_force(&self) -> bool {
        true
    }

    fn steps_a_sample(&self, p: &[f64], run: &RunMotion) -> usize {
        grids::steps_within(p[0], run)
    }

    fn record<D: Scalar>(&self, p: &[D], at: Place<'_>, force_n: &mut [D]) {
        rig::signal::lag(&at.run.time_s, force_n, p[0]);
    }
}

/// A channel of second order that lags behind by the same time and sets in more gently.
#[derive(Clone, Copy, Debug)]
pub struct SecondOrderLag;

impl Cause for SecondOrderLag {
    second_order_form!(SensorLag);

    fn record<D: Scalar>(&self, p: &[D], at: Place<'_>, force_n: &mut [D]) {
        lag_second_order(&at.run.time_s, force_n, p[0], p[1]);
    }
}

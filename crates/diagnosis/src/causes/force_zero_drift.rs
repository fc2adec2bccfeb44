//! The zero of the force channel moves with the campaign's clock: F + r T, T what that clock reads (s; the time since the start of the first
//! run where it was not set for the campaign), r the rate (N/s); or it settles, r s (1 - e^(-T/s)), s the time in which it does (s). In a
//! further form the zero was taken at the first run: T is the time since then.

use friction::{ParameterSpec, Scalar};
use rig::{Cause, Experiment, Place, Reach, Requirement, RunMotion, Station};

use super::{grids, marker};

/// The zero of the force channel drifts with the campaign's clock.
#[derive(Clone, Copy, Debug)]
pub struct ForceZeroDrift;

const RATE: ParameterSpec =
    ParameterSpec::new("rate_n_s", "N/s", "rate of the zero", -1e9, 1e9, 1e-4).with_null(0.0);
const PARAMETERS: &[ParameterSpec] = &[RATE];

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
        vec![grids::bounded(&RATE, -3.0 * rate, 3.0 * rate, 0.02 * rate)]
    }

    fn requirements(&self) -> &'static [Requirement] {
        &[Requirement::Clock]
    }

    fn record<D: Scalar>(&self, p: &[D], at: Place<'_>, force_n: &mut [D]) {
        drift(p[0], at.run, at.experiment.first_start_s, force_n);
    }
}

/// F + r T, T the time since `before_s` before the first run began.
fn drift<D: Scalar>(rate: D, run: &RunMotion, before_s: f64, force_n: &mut [D]) {
    let Some(started) = run.started_s else { return };
    for (f, &t) in force_n.iter_mut().zip(&run.time_s) {
        *f += rate * (started + before_s + t);
    }
}

/// A zero that was taken at the first run, though the campaign's clock ran before.
#[derive(Clone, Copy, Debug)]
pub struct DriftSinceFirstRun;

const SINCE_FIRST_RUN: &str = "since_first_run";

impl Cause for DriftSinceFirstRun {
    marker::marked_form!(ForceZeroDrift, "since the first run", SINCE_FIRST_RUN);

    fn rank(&self) -> u8 {
        ForceZeroDrift.rank()
    }

    fn requirements(&self) -> &'static [Requirement] {
        &[Requirement::Clock, Requirement::RunningClock]
    }

    fn refines(&self) -> bool {
        true
    }

    fn record<D: Scalar>(&self, p: &[D], at: Place<'_>, force_n: &mut [D]) {
        drift(p[0], at.run, 0.0, force_n);
    }
}

/// A channel that warms up: the zero moves at first and settles.
#[derive(Clone, Copy, Debug)]
pub struct SettlingZero;

const SETTLING: ParameterSpec =
    ParameterSpec::new("settling_time_s", "s", "time in which the zero settles", 0.0, 1e9, 1e3);

/// Settling times that are told from a step at the start and from a straight line, shares of the campaign's day.
const SETTLES: [f64; 2] = [0.02, 3.0];

impl Cause for SettlingZero {
    marker::refining_form!(ForceZeroDrift, "settling", [RATE, SETTLING]);

    fn parameters_for(&self, experiment: &Experiment) -> Vec<ParameterSpec> {
        let day = grids::day_s(experiment);
        let [least, most] = SETTLES;
        let rate = experiment.scales.force_n / (least * day);
        vec![
            grids::bounded(&RATE, -rate, rate, 1e-3 * rate),
            grids::bounded(&SETTLING, least * day, most * day, 0.3 * day),
        ]
    }

    fn shape_grid(&self, experiment: &Experiment) -> Vec<Vec<f64>> {
        let day = grids::day_s(experiment);
        [0.1, 0.3, 1.0].map(|share| vec![0.0, share * day]).to_vec()
    }

    fn record<D: Scalar>(&self, p: &[D], at: Place<'_>, force_n: &mut [D]) {
        let Some(started) = at.run.started_s else { return };
        let started = started + at.experiment.first_start_s;
        for (f, &t) in force_n.iter_mut().zip(&at.run.time_s) {
            let left = (-(p[1].recip() * (started + t))).exp();
            *f += p[0] * p[1] * (-left + 1.0);
        }
    }
}

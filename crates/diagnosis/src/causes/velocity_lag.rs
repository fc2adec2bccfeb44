//! The velocity channel is filtered: tau v_rec' = v - v_rec, so the true speed leads, v = v_rec + tau v_rec', tau in s.
//! The true speed is taken to be linear between samples, as everywhere; the record then is not.

use friction::{ParameterSpec, Scalar};
use rig::second_order::unlag_second_order;
use rig::signal::unlag;
use rig::{Cause, Experiment, Place, Reach, Station};

use super::grids;
use super::second_order::second_order_form;

/// The velocity channel is low-pass filtered, so the true speed leads the record.
#[derive(Clone, Copy, Debug)]
pub struct VelocityLag;

const TIME_CONSTANT: ParameterSpec =
    ParameterSpec::new("time_constant_s", "s", "time constant of the filter", 0.0, 1e9, 0.05).with_null(0.0);
const PARAMETERS: &[ParameterSpec] = &[TIME_CONSTANT];

impl Cause for VelocityLag {
    fn id(&self) -> &'static str {
        "velocity-lag"
    }

    fn station(&self) -> Station {
        Station::Sensor
    }

    fn reach(&self) -> Reach {
        Reach::Stage
    }

    fn describe(&self) -> &'static str {
        "The velocity channel is low-pass filtered, so the true speed leads the record."
    }

    fn parameters(&self) -> &'static [ParameterSpec] {
        PARAMETERS
    }

    fn parameters_for(&self, experiment: &Experiment) -> Vec<ParameterSpec> {
        let run = grids::duration_s(experiment);
        vec![grids::bounded(&PARAMETERS[0], 0.0, 0.3 * run, 0.01 * run)]
    }

    fn starts(&self, experiment: &Experiment) -> Vec<Vec<f64>> {
        grids::delays_s(experiment).into_iter().map(|t| vec![t]).collect()
    }

    fn lateness_s(&self, p: &[f64]) -> f64 {
        -p[0]
    }

    fn stage<D: Scalar>(&self, p: &[D], at: Place<'_>, velocity: &mut [D]) {
        lead(at, velocity, |time, output| unlag(time, output, p[0]));
    }
}

/// A velocity channel of second order: the true speed leads the record by the same time.
#[derive(Clone, Copy, Debug)]
pub struct SecondOrderVelocityLag;

impl Cause for SecondOrderVelocityLag {
    second_order_form!(VelocityLag);

    fn stage<D: Scalar>(&self, p: &[D], at: Place<'_>, velocity: &mut [D]) {
        lead(at, velocity, |time, output| {
            unlag_second_order(time, output, p[0], p[1])
        });
    }
}

/// Gives the speed what the filter held back, linear between samples; `input` finds what came in from the times and the record.
fn lead<D: Scalar>(at: Place<'_>, velocity: &mut [D], input: impl Fn(&[f64], &[f64]) -> Vec<D>) {
    let parts = at.run.steps_a_sample;
    let recorded = |series: &[f64]| -> Vec<f64> { series.iter().copied().step_by(parts).collect() };
    let (time, output) = (recorded(&at.run.time_s), recorded(&at.run.velocity_m_s));
    let input = input(&time, &output);
    let held: Vec<D> = input.iter().zip(&output).map(|(x, &y)| *x - y).collect();
    for (j, v) in velocity.iter_mut().enumerate() {
        let (i, share) = (j / parts, (j % parts) as f64 / parts as f64);
        let next = held.get(i + 1).copied().unwrap_or(held[i]);
        *v += held[i] + (next - held[i]) * share;
    }
}

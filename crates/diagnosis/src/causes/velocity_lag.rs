//! The velocity channel is filtered: tau v_rec' = v - v_rec, so the true speed leads, v = v_rec + tau v_rec', tau in s.
//! The true speed is taken to be linear between samples, as everywhere; the record then is not.

use friction::{ParameterSpec, Scalar};
use rig::signal::unlag;
use rig::{Cause, Experiment, Place, Reach, Station};

use super::grids;

/// The velocity channel is low-pass filtered, so the true speed leads the record.
#[derive(Clone, Copy, Debug)]
pub struct VelocityLag;

const PARAMETERS: &[ParameterSpec] = &[
    ParameterSpec::new("time_constant_s", "s", "time constant of the filter", 0.0, 1e9, 0.05).with_null(0.0),
];

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
        let parts = at.run.steps_a_sample;
        let recorded = |series: &[f64]| -> Vec<f64> { series.iter().copied().step_by(parts).collect() };
        let (time, output) = (recorded(&at.run.time_s), recorded(&at.run.velocity_m_s));
        let input = unlag(&time, &output, p[0]);
        // What the filter held back, linear between samples.
        let held: Vec<D> = input.iter().zip(&output).map(|(x, &y)| *x - y).collect();
        for (j, v) in velocity.iter_mut().enumerate() {
            let (i, share) = (j / parts, (j % parts) as f64 / parts as f64);
            let next = held.get(i + 1).copied().unwrap_or(held[i]);
            *v += held[i] + (next - held[i]) * share;
        }
    }
}

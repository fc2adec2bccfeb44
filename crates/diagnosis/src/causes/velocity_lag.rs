//! The velocity channel is filtered: tau v_rec' = v - v_rec, so the true speed leads, v = v_rec + tau v_rec', tau in s.

use friction::{ParameterSpec, Scalar};
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

    fn lateness_s(&self, p: &[f64]) -> f64 {
        -p[0]
    }

    fn stage<D: Scalar>(&self, p: &[D], at: Place<'_>, velocity: &mut [D]) {
        for (v, &a) in velocity.iter_mut().zip(&at.run.acceleration_m_s2) {
            *v += p[0] * a;
        }
    }
}

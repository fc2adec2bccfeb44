//! The normal load oscillates: N (1 + A sin(2 pi f t + phase)), t the time of the run (s), f the frequency (Hz). Where a
//! load is recorded and shows the oscillation, the recorded load already carries it.

use std::collections::BTreeMap;

use friction::{ParameterSpec, Scalar};
use rig::{Cause, Experiment, Place, Reach, Reported, Requirement, Station};

use super::{grids, periodic};

/// The normal load oscillates in time.
#[derive(Clone, Copy, Debug)]
pub struct LoadOscillation;

const PARAMETERS: &[ParameterSpec] = &[
    periodic::SIN,
    periodic::COS,
    ParameterSpec::new("frequency_hz", "Hz", "frequency of the load", 1e-9, 1e9, 1.0),
];

impl Cause for LoadOscillation {
    fn id(&self) -> &'static str {
        "load-oscillation"
    }

    fn station(&self) -> Station {
        Station::Load
    }

    fn reach(&self) -> Reach {
        Reach::Factor
    }

    fn describe(&self) -> &'static str {
        "The normal load oscillates in time."
    }

    fn parameters(&self) -> &'static [ParameterSpec] {
        PARAMETERS
    }

    fn parameters_for(&self, experiment: &Experiment) -> Vec<ParameterSpec> {
        let (lowest, highest) = grids::frequencies_hz(experiment);
        let shape = grids::bounded(&PARAMETERS[2], lowest, 1.1 * highest, 5.0 * lowest);
        vec![PARAMETERS[0].clone(), PARAMETERS[1].clone(), shape]
    }

    fn sizes(&self) -> &'static [usize] {
        &[0, 1]
    }

    fn shape_grid(&self, experiment: &Experiment) -> Vec<Vec<f64>> {
        let (lowest, highest) = grids::frequencies_hz(experiment);
        let duration = grids::duration_s(experiment);
        grids::rates(lowest, highest, duration).into_iter().map(|f| vec![0.0, 0.0, f]).collect()
    }

    fn is_periodic(&self) -> bool {
        true
    }

    fn requirements(&self) -> &'static [Requirement] {
        &[Requirement::Load]
    }

    fn reported(&self, fitted: &[f64]) -> Vec<Reported> {
        periodic::reported(fitted, "frequency_hz", "Hz")
    }

    fn from_reported(&self, reported: &BTreeMap<String, f64>) -> Result<Vec<f64>, String> {
        periodic::from_reported(reported, "frequency_hz")
    }

    fn factor<D: Scalar>(&self, p: &[D], at: Place<'_>, _friction_n: &[D], factor: &mut [D], _memory: &mut [D]) {
        for (f, &t) in factor.iter_mut().zip(&at.run.time_s) {
            *f *= periodic::ripple(p, p[2] * (std::f64::consts::TAU * t));
        }
    }
}

//! The normal load oscillates: N (1 + A sin(2 pi f t + phase)), f the frequency (Hz), t the time of the run (s), as where the
//! drive shakes the load, or the time of the day since the first run began, as where something beside the rig does. Where a
//! load is recorded and shows the oscillation, the recorded load already carries it.

use std::collections::BTreeMap;

use friction::{ParameterSpec, Scalar};
use rig::{Cause, Experiment, Place, Reach, Reported, Requirement, Station};

use super::{grids, periodic};
use periodic::{Edged, Harmonics, Sine, Wave};

const DESCRIPTION: &str = "The normal load oscillates in time.";

/// It begins anew with each run.
#[derive(Clone, Copy, Debug)]
pub struct LoadOscillation;

const FREQUENCY: ParameterSpec = ParameterSpec::new("frequency_hz", "Hz", "frequency of the load", 1e-9, 1e9, 1.0);
const PARAMETERS: &[ParameterSpec] = &[periodic::SIN, periodic::COS, FREQUENCY];

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
        DESCRIPTION
    }

    fn parameters(&self) -> &'static [ParameterSpec] {
        PARAMETERS
    }

    fn parameters_for(&self, experiment: &Experiment) -> Vec<ParameterSpec> {
        bounds(experiment)
    }

    fn sizes(&self) -> &'static [usize] {
        &[0, 1]
    }

    fn shape_grid(&self, experiment: &Experiment) -> Vec<Vec<f64>> {
        frequencies(experiment)
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
        swing::<Sine, D>(p, 0.0, &at.run.time_s, factor);
    }
}

/// It goes on between the runs.
#[derive(Clone, Copy, Debug)]
pub struct OscillationOfTheDay;

/// The phase at the start of the first run.
const PHASE: &str = "phase_of_the_day_rad";

impl Cause for OscillationOfTheDay {
    fn id(&self) -> &'static str {
        "load-oscillation"
    }

    fn variant(&self) -> Option<&'static str> {
        Some("by the clock of the day")
    }

    fn station(&self) -> Station {
        Station::Load
    }

    fn reach(&self) -> Reach {
        Reach::Factor
    }

    fn describe(&self) -> &'static str {
        DESCRIPTION
    }

    fn parameters(&self) -> &'static [ParameterSpec] {
        PARAMETERS
    }

    fn parameters_for(&self, experiment: &Experiment) -> Vec<ParameterSpec> {
        bounds(experiment)
    }

    fn sizes(&self) -> &'static [usize] {
        &[0, 1]
    }

    fn shape_grid(&self, experiment: &Experiment) -> Vec<Vec<f64>> {
        frequencies(experiment)
    }

    fn is_periodic(&self) -> bool {
        true
    }

    fn goes_on_between_runs(&self) -> bool {
        true
    }

    fn requirements(&self) -> &'static [Requirement] {
        &[Requirement::Load, Requirement::Clock]
    }

    fn reported(&self, fitted: &[f64]) -> Vec<Reported> {
        let mut reported = LoadOscillation.reported(fitted);
        if let Some(phase) = reported.last_mut() {
            phase.name = PHASE;
        }
        reported
    }

    fn from_reported(&self, reported: &BTreeMap<String, f64>) -> Result<Vec<f64>, String> {
        let phase = *reported.get(PHASE).ok_or_else(|| PHASE.to_owned())?;
        let mut plain = reported.clone();
        plain.insert("phase_rad".to_owned(), phase);
        periodic::from_reported(&plain, "frequency_hz")
    }

    fn factor<D: Scalar>(&self, p: &[D], at: Place<'_>, _friction_n: &[D], factor: &mut [D], _memory: &mut [D]) {
        swing::<Sine, D>(p, at.run.started_s.unwrap_or(0.0), &at.run.time_s, factor);
    }
}

/// A load that comes and goes: between a sine and a square wave, anew with each run.
#[derive(Clone, Copy, Debug)]
pub struct EdgedOscillation;

impl Cause for EdgedOscillation {
    periodic::refined_form!(LoadOscillation, Edged, FREQUENCY);

    fn factor<D: Scalar>(&self, p: &[D], at: Place<'_>, _friction_n: &[D], factor: &mut [D], _memory: &mut [D]) {
        swing::<Edged, D>(p, 0.0, &at.run.time_s, factor);
    }
}

/// With the second and the third harmonic, anew with each run.
#[derive(Clone, Copy, Debug)]
pub struct HarmonicOscillation;

impl Cause for HarmonicOscillation {
    periodic::refined_form!(LoadOscillation, Harmonics, FREQUENCY);

    fn factor<D: Scalar>(&self, p: &[D], at: Place<'_>, _friction_n: &[D], factor: &mut [D], _memory: &mut [D]) {
        swing::<Harmonics, D>(p, 0.0, &at.run.time_s, factor);
    }
}

fn bounds(experiment: &Experiment) -> Vec<ParameterSpec> {
    let (lowest, highest) = grids::frequencies_hz(experiment);
    let shape = grids::bounded(&PARAMETERS[2], lowest, 1.1 * highest, 5.0 * lowest);
    vec![PARAMETERS[0].clone(), PARAMETERS[1].clone(), shape]
}

fn frequencies(experiment: &Experiment) -> Vec<Vec<f64>> {
    let (lowest, highest) = grids::frequencies_hz(experiment);
    let duration = grids::duration_s(experiment);
    grids::rates(lowest, highest, duration).into_iter().map(|f| vec![0.0, 0.0, f]).collect()
}

/// Multiplies a run's factor by the wave at the phase 2 pi f (since + t).
fn swing<W: Wave, D: Scalar>(p: &[D], since_s: f64, time_s: &[f64], factor: &mut [D]) {
    for (f, &t) in factor.iter_mut().zip(time_s) {
        *f *= W::ripple(p, p[2] * (std::f64::consts::TAU * (since_s + t)));
    }
}

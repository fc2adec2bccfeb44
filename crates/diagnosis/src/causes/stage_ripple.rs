//! The drive's pitch or cogging: v_true = v (1 + A sin(2 pi x/p + phase)), x the coordinate (m) where the stage truly is,
//! dx/dt = v_true from the recorded start on, p the pitch (m).

use std::collections::BTreeMap;

use friction::{ParameterSpec, Scalar};
use rig::{Cause, Experiment, Place, Reach, Reported, Requirement, RunMotion, Station};

use super::marker::marked_form;
use super::{grids, periodic};
use periodic::{Edged, Harmonics, Sine, Toothed, Wave};

/// The true speed of the stage ripples with the pitch of its drive.
#[derive(Clone, Copy, Debug)]
pub struct StageRipple;

const PITCH: ParameterSpec = ParameterSpec::new("pitch_m", "m", "pitch of the drive", 1e-9, 1e9, 1.0);
const PARAMETERS: &[ParameterSpec] = &[periodic::SIN, periodic::COS, PITCH];

/// Steps over a pitch: chords over a twelfth of a period make its amplitude 2 % small.
const STEPS_A_PITCH: f64 = 12.0;
/// How many times finer a wave with harmonics or edges is.
const FINER: f64 = 3.0;
/// Steps from sample to sample, at most.
const MOST_STEPS: f64 = 16.0;

impl Cause for StageRipple {
    fn id(&self) -> &'static str {
        "stage-ripple"
    }

    fn station(&self) -> Station {
        Station::Stage
    }

    fn reach(&self) -> Reach {
        Reach::Stage
    }

    fn describe(&self) -> &'static str {
        "The true speed of the stage ripples with the pitch of its drive."
    }

    fn parameters(&self) -> &'static [ParameterSpec] {
        PARAMETERS
    }

    fn parameters_for(&self, experiment: &Experiment) -> Vec<ParameterSpec> {
        let (shortest, longest) = grids::wavelengths_m(experiment);
        let shape = grids::bounded(&PARAMETERS[2], 0.8 * shortest, longest, 0.1 * longest);
        vec![PARAMETERS[0].clone(), PARAMETERS[1].clone(), shape]
    }

    fn sizes(&self) -> &'static [usize] {
        &[0, 1]
    }

    fn shape_grid(&self, experiment: &Experiment) -> Vec<Vec<f64>> {
        let (shortest, longest) = grids::wavelengths_m(experiment);
        grids::rates(1.0 / longest, 1.0 / shortest, longest).into_iter().map(|k| vec![0.0, 0.0, 1.0 / k]).collect()
    }

    fn is_periodic(&self) -> bool {
        true
    }

    fn requirements(&self) -> &'static [Requirement] {
        &[]
    }

    fn reported(&self, fitted: &[f64]) -> Vec<Reported> {
        periodic::reported(fitted, "pitch_m", "m")
    }

    fn from_reported(&self, reported: &BTreeMap<String, f64>) -> Result<Vec<f64>, String> {
        periodic::from_reported(reported, "pitch_m")
    }

    fn steps_a_sample(&self, p: &[f64], run: &RunMotion) -> usize {
        steps(p[2], run)
    }

    fn stage<D: Scalar>(&self, p: &[D], at: Place<'_>, velocity: &mut [D]) {
        ripple::<Sine, D>(p, at, velocity);
    }
}

/// What marked forms of the sine, asked in its place, share with it: everything but what a campaign must have, and the hook.
macro_rules! in_place_of_the_sine {
    ($variant:literal, $marker:ident) => {
        marked_form!(StageRipple, $variant, $marker);

        fn sizes(&self) -> &'static [usize] {
            StageRipple.sizes()
        }

        fn shape_grid(&self, experiment: &Experiment) -> Vec<Vec<f64>> {
            StageRipple.shape_grid(experiment)
        }

        fn is_periodic(&self) -> bool {
            StageRipple.is_periodic()
        }

        fn refines(&self) -> bool {
            true
        }

        fn steps_a_sample(&self, p: &[f64], run: &RunMotion) -> usize {
            StageRipple.steps_a_sample(p, run)
        }
    };
}

/// The rig's moving mass stands on the stage and ripples with it: F + M d(v_true)/dt. In the plain form it follows the motor.
#[derive(Clone, Copy, Debug)]
pub struct CarryingRipple;

/// The marker's name in files.
const CARRYING: &str = "moves_the_mass";

impl Cause for CarryingRipple {
    in_place_of_the_sine!("of a stage that carries the mass", CARRYING);

    fn requirements(&self) -> &'static [Requirement] {
        &[Requirement::MovingMass]
    }

    fn moves_the_mass(&self) -> bool {
        true
    }

    fn stage<D: Scalar>(&self, p: &[D], at: Place<'_>, velocity: &mut [D]) {
        StageRipple.stage(p, at, velocity);
    }
}

/// The pitch is that of a screw whose turns are what is recorded: x is the recorded coordinate. Of amplitudes A the plain form differs from that
/// by a second harmonic of A^2/2, and by as much in its pitch.
#[derive(Clone, Copy, Debug)]
pub struct ScrewRipple;

/// The marker's name in files.
const SCREW: &str = "follows_the_record";

impl Cause for ScrewRipple {
    in_place_of_the_sine!("of a screw whose turns are recorded", SCREW);

    fn requirements(&self) -> &'static [Requirement] {
        StageRipple.requirements()
    }

    fn stage<D: Scalar>(&self, p: &[D], at: Place<'_>, velocity: &mut [D]) {
        let wave = p[2].recip() * std::f64::consts::TAU;
        for (v, &x) in velocity.iter_mut().zip(&at.run.position_m) {
            *v *= Sine::ripple(p, wave * x);
        }
    }
}

/// A drive that steps: between a sine and a square wave.
#[derive(Clone, Copy, Debug)]
pub struct EdgedRipple;

impl Cause for EdgedRipple {
    periodic::refined_form!(StageRipple, Edged, PITCH);

    fn steps_a_sample(&self, p: &[f64], run: &RunMotion) -> usize {
        steps(p[2] / FINER, run)
    }

    fn stage<D: Scalar>(&self, p: &[D], at: Place<'_>, velocity: &mut [D]) {
        ripple::<Edged, D>(p, at, velocity);
    }
}

/// A drive that sticks and leaps: its speed rises evenly and falls at once, or the other way round.
#[derive(Clone, Copy, Debug)]
pub struct ToothedRipple;

impl Cause for ToothedRipple {
    periodic::refined_form!(StageRipple, Toothed, PITCH);

    fn steps_a_sample(&self, p: &[f64], run: &RunMotion) -> usize {
        steps(p[2] / FINER, run)
    }

    fn stage<D: Scalar>(&self, p: &[D], at: Place<'_>, velocity: &mut [D]) {
        ripple::<Toothed, D>(p, at, velocity);
    }
}

/// Poles: with the second and the third harmonic.
#[derive(Clone, Copy, Debug)]
pub struct HarmonicRipple;

impl Cause for HarmonicRipple {
    periodic::refined_form!(StageRipple, Harmonics, PITCH);

    fn steps_a_sample(&self, p: &[f64], run: &RunMotion) -> usize {
        steps(p[2] / FINER, run)
    }

    fn stage<D: Scalar>(&self, p: &[D], at: Place<'_>, velocity: &mut [D]) {
        ripple::<Harmonics, D>(p, at, velocity);
    }
}

/// Steps from sample to sample for a pitch.
fn steps(pitch_m: f64, run: &RunMotion) -> usize {
    (STEPS_A_PITCH * run.widest_step_m() / pitch_m).ceil().clamp(1.0, MOST_STEPS) as usize
}

/// The speed that the drive makes of the commanded one.
fn ripple<W: Wave, D: Scalar>(p: &[D], at: Place<'_>, velocity: &mut [D]) {
    let wave = p[2].recip() * std::f64::consts::TAU;
    let time = &at.run.time_s;
    let mut x = D::constant(at.run.position_m[0]);
    let mut before = velocity[0] * W::ripple(p, wave * x);
    velocity[0] = before;
    // dx/dt = v(x, t): the speed at the end of a step is read where the speed at its start leads, the way is their mean
    for i in 1..velocity.len() {
        let step = time[i] - time[i - 1];
        let now = velocity[i] * W::ripple(p, wave * (x + before * step));
        x += (before + now) * (0.5 * step);
        velocity[i] = now;
        before = now;
    }
}

//! Frictional heating: E' = abs(F v) - E/tau, mu (1 - k E), E the heat held (J), k the strength (1/J), tau the time constant
//! (s); in further forms friction levels off, mu / (1 + k E), or falls by equal shares, mu exp(-k E). Heat is carried from run to run and leaves during rests. The power is
//! that of the softened friction; between samples it is linear.

use friction::{ParameterSpec, Scalar};
use rig::{Cause, Experiment, Place, Reach, Requirement, Station};

use super::{grids, marker};

/// Friction falls with frictional heat and recovers during rests.
#[derive(Clone, Copy, Debug)]
pub struct ThermalSoftening;

const PARAMETERS: &[ParameterSpec] = &[
    ParameterSpec::new("strength_per_j", "1/J", "loss of friction per joule held", 0.0, 1e12, 1.0).with_null(0.0),
    ParameterSpec::new("time_constant_s", "s", "time constant of cooling", 1e-9, 1e12, 10.0),
];

impl Cause for ThermalSoftening {
    fn id(&self) -> &'static str {
        "thermal-softening"
    }

    fn station(&self) -> Station {
        Station::History
    }

    fn reach(&self) -> Reach {
        Reach::Factor
    }

    fn describe(&self) -> &'static str {
        "Friction falls with frictional heat and recovers during rests."
    }

    fn parameters(&self) -> &'static [ParameterSpec] {
        PARAMETERS
    }

    fn parameters_for(&self, experiment: &Experiment) -> Vec<ParameterSpec> {
        // typical: a loss of a twentieth by the work of one run
        let work = 0.5 * experiment.scales.force_n * grids::slid_m(experiment).0;
        let (run, day) = (grids::duration_s(experiment), grids::day_s(experiment));
        vec![
            grids::bounded(&PARAMETERS[0], 0.0, 20.0 / work, 0.05 / work),
            grids::bounded(&PARAMETERS[1], 0.02 * run, 30.0 * day, run),
        ]
    }

    fn requirements(&self) -> &'static [Requirement] {
        &[Requirement::Order]
    }

    fn memory(&self) -> usize {
        1
    }

    fn shape_grid(&self, experiment: &Experiment) -> Vec<Vec<f64>> {
        cooling_times(experiment, 8)
    }

    fn factor<D: Scalar>(&self, p: &[D], at: Place<'_>, friction_n: &[D], factor: &mut [D], memory: &mut [D]) {
        let strength = p[0];
        let soften = Softening {
            cooling_s: p[1],
            left: |heat: D| -(strength * heat) + 1.0,
            // E = a + h p (1 - k E)
            held: |a: D, gain: D| (a + gain) / (strength * gain + 1.0),
        };
        soften.run(at, friction_n, factor, &mut memory[0]);
    }
}

/// The same, levelling off: twice the heat does not take twice as much.
#[derive(Clone, Copy, Debug)]
pub struct LevellingSoftening;

/// Beside strength and time constant, what tells this form from the other one in a file.
const LEVELS_OFF: &str = "levels_off";

impl Cause for LevellingSoftening {
    marker::marked_form!(ThermalSoftening, "levelling off", LEVELS_OFF);

    fn requirements(&self) -> &'static [Requirement] {
        ThermalSoftening.requirements()
    }

    // A small effect is that of the first form: few tangents will do.
    fn shape_grid(&self, experiment: &Experiment) -> Vec<Vec<f64>> {
        cooling_times(experiment, 4)
    }

    fn factor<D: Scalar>(&self, p: &[D], at: Place<'_>, friction_n: &[D], factor: &mut [D], memory: &mut [D]) {
        let strength = p[0];
        let soften = Softening {
            cooling_s: p[1],
            left: |heat: D| (strength * heat + 1.0).recip(),
            // E = a + h p / (1 + k E): the root of k E^2 + (1 - k a) E = a + h p that is a + h p where k is nothing
            held: |a: D, gain: D| {
                let linear = -(strength * a) + 1.0;
                let root = (linear * linear + strength * (a + gain) * 4.0).sqrt();
                (a + gain) * 2.0 / (linear + root)
            },
        };
        soften.run(at, friction_n, factor, &mut memory[0]);
    }
}

/// The same, where equal heats take equal shares of what is left.
#[derive(Clone, Copy, Debug)]
pub struct ExponentialSoftening;

/// Beside strength and time constant, what tells this form from the others in a file.
const EXPONENTIAL: &str = "exponential";
/// Newton's steps for the heat at the end of a sample, which differs little from that at its start.
const NEWTON: usize = 3;

impl Cause for ExponentialSoftening {
    marker::marked_form!(ThermalSoftening, "exponential", EXPONENTIAL);

    fn requirements(&self) -> &'static [Requirement] {
        ThermalSoftening.requirements()
    }

    fn shape_grid(&self, experiment: &Experiment) -> Vec<Vec<f64>> {
        LevellingSoftening.shape_grid(experiment)
    }

    fn factor<D: Scalar>(&self, p: &[D], at: Place<'_>, friction_n: &[D], factor: &mut [D], memory: &mut [D]) {
        let strength = p[0];
        let left = |heat: D| (-(strength * heat)).exp();
        let soften = Softening {
            cooling_s: p[1],
            left,
            // E = a + h p exp(-k E)
            held: |a: D, gain: D| {
                (0..NEWTON).fold(a, |heat, _| {
                    let gained = gain * left(heat);
                    heat - (heat - a - gained) / (strength * gained + 1.0)
                })
            },
        };
        soften.run(at, friction_n, factor, &mut memory[0]);
    }
}

/// Time constants of cooling at which the scan looks.
fn cooling_times(experiment: &Experiment, looks: usize) -> Vec<Vec<f64>> {
    let (run, day) = (grids::duration_s(experiment), grids::day_s(experiment));
    grids::logarithmic(0.1 * run, 3.0 * day, looks).into_iter().map(|tau| vec![0.0, tau]).collect()
}

/// Heat along a run and what it leaves of friction.
struct Softening<D, L, H> {
    cooling_s: D,
    /// Factor on friction at a heat.
    left: L,
    /// The heat E that solves E = a + h p left(E); its arguments are a and h p.
    held: H,
}

impl<D: Scalar, L: Fn(D) -> D, H: Fn(D, D) -> D> Softening<D, L, H> {
    fn run(&self, at: Place<'_>, friction_n: &[D], factor: &mut [D], memory: &mut D) {
        let tau = self.cooling_s;
        let (time, speed) = (&at.run.time_s, &at.run.velocity_m_s);
        let keep = |dt: f64| (-(tau.recip() * dt)).exp();
        let mut heat = *memory * keep(at.run.rest_s.unwrap_or(0.0));
        // power p of the friction as it would be without softening
        let power = |i: usize| (friction_n[i] * speed[i]).magnitude();
        let mut left = (self.left)(heat);
        let mut before = power(0) * left;
        factor[0] *= left;
        for i in 1..friction_n.len() {
            // E1 = E0 e^-r + (P0 + P1) h with h = tau (1 - e^-r)/2, P1 = p1 left(E1), r = dt/tau
            let kept = keep(time[i] - time[i - 1]);
            let half = tau * (-kept + 1.0) * 0.5;
            let full = power(i);
            heat = (self.held)(heat * kept + half * before, half * full);
            left = (self.left)(heat);
            before = full * left;
            factor[i] *= left;
        }
        *memory = heat;
    }
}

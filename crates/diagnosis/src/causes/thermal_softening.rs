//! Frictional heating: E' = abs(F v) - E/tau, mu (1 - k E), E the heat held (J), k the strength (1/J), tau the time constant
//! (s). Heat is carried from run to run and leaves during rests. The power is that of the softened friction; between
//! samples it is linear.

use friction::{ParameterSpec, Scalar};
use rig::{Cause, Experiment, Place, Reach, Requirement, Station};

use super::grids;

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
        let (run, day) = (grids::duration_s(experiment), grids::day_s(experiment));
        grids::logarithmic(0.1 * run, 3.0 * day, 8).into_iter().map(|tau| vec![0.0, tau]).collect()
    }

    fn factor<D: Scalar>(&self, p: &[D], at: Place<'_>, friction_n: &[D], factor: &mut [D], memory: &mut [D]) {
        let (strength, tau) = (p[0], p[1]);
        let (time, speed) = (&at.run.time_s, &at.run.velocity_m_s);
        let keep = |dt: f64| (-(tau.recip() * dt)).exp();
        let mut heat = memory[0] * keep(at.run.rest_s.unwrap_or(0.0));
        // power of the friction as it would be without softening
        let power = |i: usize| (friction_n[i] * speed[i]).magnitude();
        let mut before = power(0) * (-(strength * heat) + 1.0);
        factor[0] *= -(strength * heat) + 1.0;
        for i in 1..friction_n.len() {
            // E1 = E0 e^-r + (P0 + P1) tau (1 - e^-r)/2 with P1 = p1 (1 - k E1), r = dt/tau
            let kept = keep(time[i] - time[i - 1]);
            let half = tau * (-kept + 1.0) * 0.5;
            let full = power(i);
            heat = (heat * kept + half * (before + full)) / (half * strength * full + 1.0);
            let left = -(strength * heat) + 1.0;
            before = full * left;
            factor[i] *= left;
        }
        memory[0] = heat;
    }
}

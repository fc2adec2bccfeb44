//! A mass between contact and sensor that moves with the stage: F + m dv/dt, m in kg, in addition to the rig's known moving mass.

use friction::{ParameterSpec, Scalar};
use rig::{Cause, Experiment, Place, Reach, Station};

use super::grids;

/// A mass moves between contact and sensor.
#[derive(Clone, Copy, Debug)]
pub struct MovingInertia;

const PARAMETERS: &[ParameterSpec] = &[
    ParameterSpec::new("mass_kg", "kg", "additional moving mass", -1e9, 1e9, 0.1).with_null(0.0),
];

impl Cause for MovingInertia {
    fn id(&self) -> &'static str {
        "moving-inertia"
    }

    fn station(&self) -> Station {
        Station::Coupling
    }

    fn reach(&self) -> Reach {
        Reach::Record
    }

    fn describe(&self) -> &'static str {
        "A mass moves between contact and sensor."
    }

    fn parameters(&self) -> &'static [ParameterSpec] {
        PARAMETERS
    }

    fn parameters_for(&self, experiment: &Experiment) -> Vec<ParameterSpec> {
        let known = experiment.moving_mass_kg;
        let accelerations = experiment.runs.iter().flat_map(|run| run.acceleration_m_s2.iter());
        let fastest = accelerations.fold(0.0_f64, |a, x| a.max(x.abs())).max(1e-12);
        let mass = experiment.scales.force_n / fastest;
        vec![grids::bounded(&PARAMETERS[0], -known, 10.0 * mass, 0.05 * mass)]
    }

    fn record<D: Scalar>(&self, p: &[D], at: Place<'_>, force_n: &mut [D]) {
        for (f, &a) in force_n.iter_mut().zip(&at.run.acceleration_m_s2) {
            *f += p[0] * a;
        }
    }
}

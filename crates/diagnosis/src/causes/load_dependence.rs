//! Friction is not proportional to the load: mu (N/N_ref)^-a, N_ref the geometric mean of the campaign's loads, at which
//! the law's coefficients are stated.

use friction::{ParameterSpec, Scalar};
use rig::{Cause, Place, Reach, Requirement, Station};

/// The coefficient of friction depends on the load.
#[derive(Clone, Copy, Debug)]
pub struct LoadDependence;

const PARAMETERS: &[ParameterSpec] = &[
    ParameterSpec::new("exponent", "1", "exponent a of mu ~ N^-a", -2.0, 2.0, 0.1).with_null(0.0),
];

impl Cause for LoadDependence {
    fn id(&self) -> &'static str {
        "load-dependence"
    }

    fn station(&self) -> Station {
        Station::Load
    }

    fn reach(&self) -> Reach {
        Reach::Factor
    }

    fn describe(&self) -> &'static str {
        "The coefficient of friction depends on the load."
    }

    fn parameters(&self) -> &'static [ParameterSpec] {
        PARAMETERS
    }

    fn requirements(&self) -> &'static [Requirement] {
        &[Requirement::Load, Requirement::TwoLoads]
    }

    fn factor<D: Scalar>(&self, p: &[D], at: Place<'_>, _friction_n: &[D], factor: &mut [D], _memory: &mut [D]) {
        for (f, &load) in factor.iter_mut().zip(&at.run.load_n) {
            if load > 0.0 {
                *f *= (p[0] * -(load / at.experiment.reference_load_n).ln()).exp();
            }
        }
    }
}

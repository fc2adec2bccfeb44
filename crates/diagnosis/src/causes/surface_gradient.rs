//! Friction changes along the plate: mu (1 + c x), x the place on the plate (m), c the slope (1/m).

use friction::{ParameterSpec, Scalar};
use rig::{Cause, Experiment, Place, Reach, Station};

use super::grids;

/// Friction changes linearly along the plate.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceGradient;

const PARAMETERS: &[ParameterSpec] = &[
    ParameterSpec::new("slope_per_m", "1/m", "relative change per metre", -1e9, 1e9, 0.1).with_null(0.0),
];

impl Cause for SurfaceGradient {
    fn id(&self) -> &'static str {
        "surface-gradient"
    }

    fn station(&self) -> Station {
        Station::Surface
    }

    fn reach(&self) -> Reach {
        Reach::Factor
    }

    fn describe(&self) -> &'static str {
        "Friction changes linearly along the plate."
    }

    fn parameters(&self) -> &'static [ParameterSpec] {
        PARAMETERS
    }

    fn parameters_for(&self, experiment: &Experiment) -> Vec<ParameterSpec> {
        let span = grids::plate_span_m(experiment);
        vec![grids::bounded(&PARAMETERS[0], -3.0 / span, 30.0 / span, 0.05 / span)]
    }

    fn factor<D: Scalar>(&self, p: &[D], at: Place<'_>, _friction_n: &[D], factor: &mut [D], _memory: &mut [D]) {
        for (f, &x) in factor.iter_mut().zip(&at.run.position_m) {
            *f *= p[0] * x + 1.0;
        }
    }
}

//! Friction changes along the plate: mu (1 + c x), x the place on the plate (m), c the slope (1/m). Or it bends as it does so, with the next
//! term of the series, mu (1 + c x + b x^2), b in 1/m^2: what an exponential along the plate, or a plate that is thin at one end, looks like.

use friction::{ParameterSpec, Scalar};
use rig::{Cause, Experiment, Place, Reach, Station};

use super::{grids, marker};

/// Friction changes linearly along the plate.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceGradient;

const SLOPE: ParameterSpec =
    ParameterSpec::new("slope_per_m", "1/m", "relative change per metre", -1e9, 1e9, 0.1).with_null(0.0);
const CURVATURE: ParameterSpec =
    ParameterSpec::new("curvature_per_m2", "1/m^2", "coefficient of the place's square", -1e9, 1e9, 0.1).with_null(0.0);
const PARAMETERS: &[ParameterSpec] = &[SLOPE];

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

/// Friction changes along the plate, more at one end than at the other.
#[derive(Clone, Copy, Debug)]
pub struct BentGradient;

impl Cause for BentGradient {
    marker::refining_form!(SurfaceGradient, "bent", [SLOPE, CURVATURE]);

    fn parameters_for(&self, experiment: &Experiment) -> Vec<ParameterSpec> {
        let square = grids::plate_span_m(experiment).powi(2);
        let mut specs = SurfaceGradient.parameters_for(experiment);
        specs.push(grids::bounded(&CURVATURE, -30.0 / square, 30.0 / square, 0.05 / square));
        specs
    }

    fn sizes(&self) -> &'static [usize] {
        &[0, 1]
    }

    fn factor<D: Scalar>(&self, p: &[D], at: Place<'_>, _friction_n: &[D], factor: &mut [D], _memory: &mut [D]) {
        for (f, &x) in factor.iter_mut().zip(&at.run.position_m) {
            *f *= p[1] * (x * x) + p[0] * x + 1.0;
        }
    }
}

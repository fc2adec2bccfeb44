//! Stribeck friction without a state: mu = (mu_c + (mu_s - mu_c) exp(-(v/v_s)^2)) tanh(v/width) + sigma2 v.

use crate::law::SIGN_WIDTH;
use crate::{Aged, Exponent, Law, LawKind, ParameterSpec, Scalar, StribeckCurve};

pub(crate) const PARAMETERS: &[ParameterSpec] = &[
    ParameterSpec::new("mu_c", "1", "kinetic coefficient", 1e-6, 1e3, 0.3),
    ParameterSpec::new("mu_s", "1", "static coefficient", 1e-6, 1e3, 0.4),
    ParameterSpec::new("v_s", "m/s", "Stribeck speed", 1e-5, 1e2, 0.01),
    ParameterSpec::new("sigma2", "s/m", "viscous coefficient", 0.0, 1e3, 0.1),
];

pub(crate) fn build<D: Scalar>(p: &[D]) -> Law<D> {
    Law {
        kind: LawKind::Stribeck,
        curve: StribeckCurve {
            kinetic: p[0],
            at_rest: p[1],
            speed: Some(p[2]),
            exponent: Exponent::Two,
            aged: Aged::StaticLevel,
        },
        stiffness: D::constant(0.0),
        damping: D::constant(0.0),
        viscous: p[3],
        lean: None,
        asymmetry: None,
        sign_width: SIGN_WIDTH,
    }
}

//! Coulomb friction and linear viscosity: mu = mu_c tanh(v/width) + sigma2 v.

use crate::law::SIGN_WIDTH;
use crate::{Law, LawKind, ParameterSpec, Scalar, StribeckCurve};

pub(crate) const PARAMETERS: &[ParameterSpec] = &[
    ParameterSpec::new("mu_c", "1", "Coulomb coefficient", 1e-6, 1e3, 0.3),
    ParameterSpec::new("sigma2", "s/m", "viscous coefficient", 0.0, 1e3, 0.1),
];

pub(crate) fn build<D: Scalar>(p: &[D]) -> Law<D> {
    Law {
        kind: LawKind::CoulombViscous,
        curve: StribeckCurve::flat(p[0]),
        stiffness: D::constant(0.0),
        damping: D::constant(0.0),
        viscous: p[1],
        lean: None,
        asymmetry: None,
        sign_width: SIGN_WIDTH,
    }
}

//! Dahl's law with exponent one: z' = v (1 - sigma0 z sgn(v)/mu_c), mu = sigma0 z.

use crate::law::SIGN_WIDTH;
use crate::{Law, LawKind, ParameterSpec, Scalar, StribeckCurve};

pub(crate) const PARAMETERS: &[ParameterSpec] = &[
    ParameterSpec::new("mu_c", "1", "Coulomb coefficient", 1e-6, 1e3, 0.3),
    ParameterSpec::new("sigma0", "1/m", "stiffness before sliding", 1e-1, 1e8, 1e3),
];

pub(crate) fn build<D: Scalar>(p: &[D]) -> Law<D> {
    Law {
        kind: LawKind::Dahl,
        curve: StribeckCurve::flat(p[0] / p[1]),
        stiffness: p[1],
        damping: D::constant(0.0),
        viscous: D::constant(0.0),
        lean: None,
        asymmetry: None,
        sign_width: SIGN_WIDTH,
    }
}

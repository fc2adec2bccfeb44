//! LuGre (Canudas de Wit, Olsson, Astrom, Lischinsky, IEEE Trans. Automatic Control 40, 1995):
//! z' = v - sigma0 abs(v) z / g(v), mu = sigma0 z + sigma1 z' + sigma2 v, g = mu_c + (mu_s - mu_c) exp(-(v/v_s)^2).

use crate::law::SIGN_WIDTH;
use crate::{Aged, Exponent, Law, LawKind, ParameterSpec, Scalar, StribeckCurve};

pub(crate) const PARAMETERS: &[ParameterSpec] = &[
    ParameterSpec::new("mu_c", "1", "kinetic coefficient", 1e-6, 1e3, 0.3),
    ParameterSpec::new("mu_s", "1", "static coefficient", 1e-6, 1e3, 0.4),
    ParameterSpec::new("v_s", "m/s", "Stribeck speed", 1e-5, 1e2, 0.01),
    ParameterSpec::new("sigma0", "1/m", "stiffness before sliding", 1e-1, 1e8, 1e3),
    ParameterSpec::new("sigma1", "s/m", "damping of the bristles", 0.0, 1e5, 1.0),
    ParameterSpec::new("sigma2", "s/m", "viscous coefficient", 0.0, 1e3, 0.1),
];

pub(crate) fn build<D: Scalar>(p: &[D]) -> Law<D> {
    Law {
        kind: LawKind::Lugre,
        curve: StribeckCurve {
            kinetic: p[0] / p[3],
            at_rest: p[1] / p[3],
            speed: Some(p[2]),
            exponent: Exponent::Two,
            aged: Aged::StaticLevel,
        },
        stiffness: p[3],
        damping: p[4],
        viscous: p[5],
        lean: None,
        asymmetry: None,
        sign_width: SIGN_WIDTH,
    }
}

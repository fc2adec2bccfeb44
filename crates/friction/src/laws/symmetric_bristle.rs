//! Upright bristles: E1-E7 with theta0 = 0 (E8).

use crate::law::SIGN_WIDTH;
use crate::{
    Aged, CosinePlacement, Exponent, Law, LawKind, Lean, ParameterSpec, Scalar, StribeckCurve,
};

pub(crate) const THETA_C: ParameterSpec = ParameterSpec::new(
    "theta_c_over_sigma",
    "rad",
    "mean rotation at high speed, theta_c/sigma",
    1e-3,
    3.0,
    0.5,
);
pub(crate) const THETA_S: ParameterSpec = ParameterSpec::new(
    "theta_s_over_sigma",
    "rad",
    "mean rotation at rest, theta_s/sigma",
    1e-3,
    3.0,
    0.6,
);
pub(crate) const SIGMA0: ParameterSpec =
    ParameterSpec::new("sigma0", "1/rad", "stiffness k/(N h)", 1e-4, 1e4, 1.0);
pub(crate) const SIGMA1: ParameterSpec =
    ParameterSpec::new("sigma1", "s/rad", "damping of the bristles", 0.0, 1e3, 0.05);
pub(crate) const SIGMA2: ParameterSpec =
    ParameterSpec::new("sigma2", "s/rad", "viscous coefficient", 0.0, 1e3, 0.005);
pub(crate) const OMEGA_SC: ParameterSpec =
    ParameterSpec::new("omega_sc", "rad/s", "Stribeck rate w_sc", 1e-3, 1e3, 1.0);

pub(crate) const PARAMETERS: &[ParameterSpec] =
    &[THETA_C, THETA_S, SIGMA0, SIGMA1, SIGMA2, OMEGA_SC];

pub(crate) fn build<D: Scalar>(p: &[D], height_m: f64) -> Law<D> {
    Law {
        kind: LawKind::SymmetricBristle,
        curve: StribeckCurve {
            kinetic: p[0],
            at_rest: p[1],
            speed: Some(p[5]),
            exponent: Exponent::Two,
            aged: Aged::StaticLevel,
        },
        stiffness: p[2],
        damping: p[3],
        viscous: p[4],
        lean: Some(Lean {
            angle: D::constant(0.0),
            height: height_m,
            placement: CosinePlacement::AllTerms,
        }),
        asymmetry: None,
        sign_width: SIGN_WIDTH,
    }
}

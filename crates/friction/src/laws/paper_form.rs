//! The paper's own parameters of E3: X = [sigma, sigma0, sigma1, sigma2, theta_c, theta_s, w_sc] and theta0.
//!
//! They are redundant: (a sigma, a theta_c, a theta_s) moves every curve by nothing, for any a. This form exists so
//! that the flat ray can be shown; everything else uses the identifiable form.

use crate::{ParameterSpec, Scalar};

/// X and theta0, in the paper's order; sigma, theta_c and theta_s are numbers of one common, arbitrary unit.
pub const PARAMETERS: &[ParameterSpec] = &[
    ParameterSpec::new(
        "sigma",
        "1",
        "rate constant of E3 (not identifiable)",
        1e-3,
        1e6,
        200.0,
    ),
    ParameterSpec::new("sigma0", "1/rad", "stiffness k/(N h)", 1e-4, 1e4, 1.0),
    ParameterSpec::new("sigma1", "s/rad", "damping of the bristles", 0.0, 1e3, 0.05),
    ParameterSpec::new("sigma2", "s/rad", "viscous coefficient", 0.0, 1e3, 0.005),
    ParameterSpec::new(
        "theta_c",
        "1",
        "kinetic level of E5, in units of sigma",
        1e-3,
        1e6,
        100.0,
    ),
    ParameterSpec::new(
        "theta_s",
        "1",
        "static level of E5, in units of sigma",
        1e-3,
        1e6,
        120.0,
    ),
    ParameterSpec::new("omega_sc", "rad/s", "Stribeck rate w_sc", 1e-3, 1e3, 1.0),
    ParameterSpec::new(
        "theta0",
        "rad",
        "fixed lean of the bristles",
        -1.3,
        1.3,
        0.3,
    ),
];

/// From the paper's eight numbers to the seven of [`crate::LawKind::AsymmetricBristle`].
pub fn identifiable<D: Scalar>(paper: &[D; 8]) -> [D; 7] {
    let [
        sigma,
        sigma0,
        sigma1,
        sigma2,
        theta_c,
        theta_s,
        omega_sc,
        theta0,
    ] = *paper;
    [
        theta_c / sigma,
        theta_s / sigma,
        sigma0,
        sigma1,
        sigma2,
        omega_sc,
        theta0,
    ]
}

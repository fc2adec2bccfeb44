//! Leaning bristles, E1-E7: theta' = w - abs(w) theta/(g/sigma), w = (v/h) cos^2(theta + theta0),
//! mu = (sigma0 theta + sigma1 theta' + sigma2 w) cos^2(theta + theta0).
//!
//! sigma, theta_c and theta_s enter E3 only through theta_c/sigma and theta_s/sigma: these two are the parameters.

use super::symmetric_bristle::{self, OMEGA_SC, SIGMA0, SIGMA1, SIGMA2, THETA_C, THETA_S};
use crate::{Law, LawKind, Lean, ParameterSpec, Scalar};

pub(crate) const PARAMETERS: &[ParameterSpec] = &[
    THETA_C,
    THETA_S,
    SIGMA0,
    SIGMA1,
    SIGMA2,
    OMEGA_SC,
    ParameterSpec::new(
        "theta0",
        "rad",
        "fixed lean of the bristles",
        -1.3,
        1.3,
        0.3,
    )
    .with_null(0.0),
];

pub(crate) fn build<D: Scalar>(p: &[D], height_m: f64) -> Law<D> {
    let mut law = symmetric_bristle::build(&p[..6], height_m);
    law.kind = LawKind::AsymmetricBristle;
    law.lean = law.lean.map(|lean| Lean {
        angle: p[6],
        ..lean
    });
    law
}

//! The exponent of the Stribeck curve: g(u) = k + (s - k) exp(-abs(u/u_s)^(2 + e)), e the difference from two.

use friction::{Exponent, ParameterSpec, Scalar, LawKind, Law};
use rig::{Cause, Place, Reach, Station};

/// The Stribeck curve falls off with an exponent other than two.
#[derive(Clone, Copy, Debug)]
pub struct StribeckShape;

const PARAMETERS: &[ParameterSpec] = &[
    ParameterSpec::new("exponent_minus_2", "1", "exponent of the Stribeck curve, less two", -1.7, 12.0, 0.5).with_null(0.0),
];

impl Cause for StribeckShape {
    fn id(&self) -> &'static str {
        "stribeck-shape"
    }

    fn station(&self) -> Station {
        Station::Law
    }

    fn reach(&self) -> Reach {
        Reach::Law
    }

    fn describe(&self) -> &'static str {
        "The Stribeck curve falls off with an exponent other than two."
    }

    fn parameters(&self) -> &'static [ParameterSpec] {
        PARAMETERS
    }

    fn applies_to(&self, law: LawKind) -> bool {
        // the tyre form has another exponent to start with, the others no curve
        !matches!(law, LawKind::CoulombViscous | LawKind::Dahl | LawKind::LugreTyre)
    }

    fn law<D: Scalar>(&self, p: &[D], _at: Place<'_>, law: &mut Law<D>, _memory: &mut [D]) {
        let baseline = match law.curve.exponent {
            Exponent::Two => D::constant(2.0),
            Exponent::Half => D::constant(0.5),
            Exponent::General(p) => p,
        };
        law.curve.exponent = Exponent::General(baseline + p[0]);
    }
}

//! Reverse friction over forward friction, less one, for the Coulomb part (the level g) and the viscous part (sigma2).

use friction::{Asymmetry, ParameterSpec, Scalar, Law};
use rig::{Cause, Place, Reach, Requirement, Station};

/// Friction differs by direction.
#[derive(Clone, Copy, Debug)]
pub struct DirectionAsymmetry;

const PARAMETERS: &[ParameterSpec] = &[
    ParameterSpec::new("coulomb_ratio_minus_1", "1", "Coulomb part, reverse over forward, less one", -0.95, 20.0, 0.05).with_null(0.0),
    ParameterSpec::new("viscous_ratio_minus_1", "1", "viscous part, reverse over forward, less one", -0.95, 20.0, 0.05).with_null(0.0),
];

impl Cause for DirectionAsymmetry {
    fn id(&self) -> &'static str {
        "direction-asymmetry"
    }

    fn station(&self) -> Station {
        Station::Law
    }

    fn reach(&self) -> Reach {
        Reach::Law
    }

    fn describe(&self) -> &'static str {
        "Friction differs by direction."
    }

    fn parameters(&self) -> &'static [ParameterSpec] {
        PARAMETERS
    }

    fn requirements(&self) -> &'static [Requirement] {
        &[Requirement::BothDirections]
    }

    fn sizes(&self) -> &'static [usize] {
        &[0, 1]
    }

    fn law<D: Scalar>(&self, p: &[D], _at: Place<'_>, law: &mut Law<D>, _memory: &mut [D]) {
        law.asymmetry = Some(Asymmetry { coulomb: p[0], viscous: p[1] });
    }
}

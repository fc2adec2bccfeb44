//! Reverse friction over forward friction, less one, for the Coulomb part and the viscous part (sigma2). The Coulomb part is the level g, to
//! which the bristles bend anew after a reversal, or their force sigma0 z + sigma1 z' itself, which jumps there.

use friction::{Asymmetry, Law, ParameterSpec, Scalar};
use rig::{Cause, Place, Reach, Requirement, Station};

use super::marker;

/// The level of friction differs by direction.
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
        law.asymmetry = Some(Asymmetry { coulomb: p[0], viscous: p[1], jumps: false });
    }
}

/// The force itself differs by direction and jumps where the motion turns.
#[derive(Clone, Copy, Debug)]
pub struct JumpingAsymmetry;

/// Beside the ratios, what tells this form from the plain one in a file.
const JUMPS: &str = "jumps_in_turning";

impl Cause for JumpingAsymmetry {
    marker::marked_form!(DirectionAsymmetry, "jumps where the motion turns", JUMPS);

    fn sizes(&self) -> &'static [usize] {
        DirectionAsymmetry.sizes()
    }

    fn requirements(&self) -> &'static [Requirement] {
        &[Requirement::BothDirections, Requirement::Reversals]
    }

    fn law<D: Scalar>(&self, p: &[D], _at: Place<'_>, law: &mut Law<D>, _memory: &mut [D]) {
        law.asymmetry = Some(Asymmetry { coulomb: p[0], viscous: p[1], jumps: true });
    }
}

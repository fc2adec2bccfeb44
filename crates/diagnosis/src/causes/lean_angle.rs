//! The specimen's own lean: theta0 + angle (rad). Where theta0 is free it is absorbed by it; it means something against a
//! model that was identified elsewhere, and beside upright bristles, which have no theta0.

use friction::{ParameterSpec, Scalar, LawKind, Law};
use rig::{Cause, Place, Reach, Station};

/// The bristles of this specimen lean by another angle.
#[derive(Clone, Copy, Debug)]
pub struct LeanAngle;

const PARAMETERS: &[ParameterSpec] = &[
    ParameterSpec::new("angle_rad", "rad", "additional lean", -1.0, 1.0, 0.05).with_null(0.0),
];

impl Cause for LeanAngle {
    fn id(&self) -> &'static str {
        "lean-angle"
    }

    fn station(&self) -> Station {
        Station::Law
    }

    fn reach(&self) -> Reach {
        Reach::Law
    }

    fn describe(&self) -> &'static str {
        "The bristles of this specimen lean by another angle."
    }

    fn parameters(&self) -> &'static [ParameterSpec] {
        PARAMETERS
    }

    fn applies_to(&self, law: LawKind) -> bool {
        law.needs_height()
    }

    fn law<D: Scalar>(&self, p: &[D], _at: Place<'_>, law: &mut Law<D>, _memory: &mut [D]) {
        if let Some(lean) = &mut law.lean {
            lean.angle += p[0];
        }
    }
}

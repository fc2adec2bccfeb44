//! The foot on the ground: a compliant normal force with contact loss and a
//! friction coefficient that depends on the direction of sliding.
//!
//! The friction law of the brush was identified below 0.06 m/s. A gait slides at metres
//! per second, where its rate terms grow without bound, so the gait uses the steady
//! coefficients of the two directions, joined smoothly through zero.

use crate::kinematics::Scalar;
use serde::{Deserialize, Serialize};

/// Friction coefficients of a foot in its two directions of pushing, both positive.
///
/// `forward`: largest F_x/F_y that pushes the body forward (the brush slips backwards over the
/// ground); `reverse`: the same against the motion.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Brush {
    /// Coefficient of the force that drives forward.
    pub forward: f64,
    /// Coefficient of the force that brakes.
    pub reverse: f64,
}

impl Brush {
    /// The coefficient of both directions averaged.
    pub fn symmetric(self) -> Self {
        let mean = 0.5 * (self.forward + self.reverse);
        Self {
            forward: mean,
            reverse: mean,
        }
    }

    /// The same brush mounted the other way round.
    pub fn backwards(self) -> Self {
        Self {
            forward: self.reverse,
            reverse: self.forward,
        }
    }
}

/// Normal contact k, c and the speed over which friction changes its sign.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ground {
    /// Hertz stiffness k, N/m^1.5.
    pub stiffness_n_m15: f64,
    /// Contact loss c, s/m: share of the force that is lost with the speed of indentation.
    pub loss_s_m: f64,
    /// Slip speed at which friction has reached 71 % of its limit, m/s.
    pub slip_scale_m_s: f64,
}

/// Square of the indentation at which the smoothed Hertz law leaves d^1.5, m^2.
const INDENTATION_SMOOTHING_M2: f64 = 1e-8;

impl Ground {
    /// Factor (1 - 1.5 c v_y) of the normal force; a foot that sinks (v_y < 0) is pushed
    /// harder, one that rises faster than 2/(3c) would be pulled: a gait must keep it >= 0.
    pub fn loss_factor<D: Scalar>(&self, vertical_speed: D) -> D {
        -vertical_speed * (1.5 * self.loss_s_m) + 1.0
    }

    /// Normal force F_n = k (d^2 + 1e-8)^(3/4) (1 - 1.5 c v_y), N, of a foot at height -d.
    ///
    /// For a foot in the ground (d >= 0) only: the smoothing makes it even in d.
    pub fn normal_force<D: Scalar>(&self, height: D, vertical_speed: D) -> D {
        let squared = height * height + INDENTATION_SMOOTHING_M2;
        // s^(3/4) = sqrt(s) sqrt(sqrt(s)).
        let root = squared.sqrt();
        root * root.sqrt() * self.stiffness_n_m15 * self.loss_factor(vertical_speed)
    }

    /// Friction coefficient F_x/F_n of a foot that slides with `sliding` m/s over the ground.
    ///
    /// With u the slip of the brush against the direction of travel in units of the slip scale
    /// and s = u/sqrt(1 + u^2),
    ///
    /// mu = ((mu_f - mu_r) s^2 + (mu_f + mu_r) s)/2,
    ///
    /// which is mu_f at s = 1, 0 at rest and -mu_r at s = -1.
    pub fn friction_coefficient<D: Scalar>(&self, brush: Brush, sliding: D) -> D {
        let u = -sliding / self.slip_scale_m_s;
        let s = u / (u * u + 1.0).sqrt();
        (s * (brush.forward - brush.reverse) + (brush.forward + brush.reverse)) * s * 0.5
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The formula is written out here because the solver's recorded numbers do not cross threads, as the scalars of
    /// the friction crate do. It is the same law.
    #[test]
    fn the_normal_force_is_that_of_the_friction_crate() {
        let ground = Ground {
            stiffness_n_m15: 2e5,
            loss_s_m: 1.3,
            slip_scale_m_s: 0.1,
        };
        let hertz = friction::Hertz::new(ground.stiffness_n_m15, ground.loss_s_m);
        for (depth, rate) in [(1e-5, 0.3), (2e-3, -0.2), (0.013, 4.6), (0.02, -3.0)] {
            let expected = hertz.signed_force(depth, rate);
            let force = ground.normal_force(-depth, -rate);
            assert!((force / expected - 1.0).abs() < 1e-12, "{force} {expected}");
        }
    }
}

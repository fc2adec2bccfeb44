//! Force envelope of a foot: which ground forces the joint torques can hold.
//!
//! At rest with the foot fixed (foot acceleration zero),
//!
//! F(tau) = -(J M^-1 J^T)^-1 J M^-1 (S tau - G),
//!
//! an affine map of the torques. Its image of the box |tau| <= tau_max is a parallelogram (a
//! zonogon where more than two joints drive), cut by the friction cone
//! -mu_reverse F_y <= F_x <= mu_forward F_y. Two paths compute the largest forces, the exact polygon
//! ([`polygon`]) and a linear programme ([`programme`]); they must agree.

pub mod family;
pub mod polygon;
pub mod programme;

use crate::contact::Brush;
use crate::dynamics::{inverse_dynamics_with, mass_matrix_with};
use crate::kinematics::{COORDINATES, Leg, foot_jacobian};
use crate::parameters::Biped;
use nalgebra::{DMatrix, DVector, Matrix2, Matrix2xX, Vector2};
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// What of the biped takes part, and how.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Body {
    /// Torso and one leg, the torso free to move: five degrees of freedom.
    FloatingOneLeg,
    /// One leg at a torso that is held fast: two degrees of freedom.
    FixedTorso,
    /// The whole biped, the other leg in the same posture without torque.
    OtherLegLimp,
    /// The whole biped, the other leg in the same posture and driven too.
    OtherLegDriven,
}

/// Where the hip of the loaded leg sits on the torso.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Hip {
    /// In the torso's mass centre.
    Centre,
    /// At the forward end.
    FrontEnd,
    /// At the rear end.
    RearEnd,
}

/// One way to read the paper's envelope computation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Variant {
    /// Bodies that take part.
    pub body: Body,
    /// Place of the hip.
    pub hip: Hip,
    /// Whether the weight of the links counts.
    pub weight: bool,
}

impl Variant {
    /// The variant without free parameters: torso and one leg, hip in the middle.
    pub const NATURAL: Variant = Variant {
        body: Body::FloatingOneLeg,
        hip: Hip::Centre,
        weight: true,
    };
}

/// Posture of the loaded leg, rad, in the coordinates of [`crate::kinematics`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Posture {
    /// Pitch of the torso, counter-clockwise (nose up) positive.
    pub pitch_rad: f64,
    /// Hip relative to the torso.
    pub hip_rad: f64,
    /// Knee relative to the thigh.
    pub knee_rad: f64,
}

/// The posture has no unique holding force.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum EnvelopeError {
    /// J M^-1 J^T or M cannot be inverted: the leg is stretched or folded flat.
    #[error("envelope: the foot cannot be moved in every direction in posture {0:?}")]
    Singular(Posture),
    /// The linear programme did not end solved.
    #[error("envelope: the linear programme ended {0}")]
    Programme(String),
}

/// F = offset + map tau, N, with |tau_k| <= limit_k.
#[derive(Clone, Debug, PartialEq)]
pub struct ForceMap {
    /// Force at zero torque, N.
    pub offset_n: Vector2<f64>,
    /// Force per torque, N/(N m); one column a joint: hip, knee (of the loaded leg first).
    pub per_torque: Matrix2xX<f64>,
    /// Largest torque of each joint, N m.
    pub limits_n_m: Vec<f64>,
}

impl ForceMap {
    /// The affine map of a posture under one variant.
    ///
    /// # Errors
    /// [`EnvelopeError::Singular`] where the leg is stretched.
    pub fn new(biped: &Biped, variant: Variant, posture: Posture) -> Result<Self, EnvelopeError> {
        let singular = || EnvelopeError::Singular(posture);
        let (leg, length) = match variant.hip {
            Hip::Centre => (Leg::Front, 0.0),
            Hip::FrontEnd => (Leg::Front, biped.torso_length_m),
            Hip::RearEnd => (Leg::Rear, biped.torso_length_m),
        };
        let biped = Biped {
            torso_length_m: length,
            ..*biped
        };
        let other = if leg == Leg::Front {
            Leg::Rear
        } else {
            Leg::Front
        };
        let (loaded, idle) = (
            [leg.hip_index(), leg.knee_index()],
            [other.hip_index(), other.knee_index()],
        );
        let (legs, kept, driven) = match variant.body {
            Body::FloatingOneLeg => (
                vec![leg],
                vec![0, 1, 2, loaded[0], loaded[1]],
                loaded.to_vec(),
            ),
            Body::FixedTorso => (vec![leg], loaded.to_vec(), loaded.to_vec()),
            Body::OtherLegLimp => (
                Leg::BOTH.to_vec(),
                (0..COORDINATES).collect(),
                loaded.to_vec(),
            ),
            Body::OtherLegDriven => (
                Leg::BOTH.to_vec(),
                (0..COORDINATES).collect(),
                vec![loaded[0], loaded[1], idle[0], idle[1]],
            ),
        };
        let mut q = [0.0; COORDINATES];
        q[2] = posture.pitch_rad;
        for pair in [loaded, idle] {
            q[pair[0]] = posture.hip_rad;
            q[pair[1]] = posture.knee_rad;
        }
        let still = [0.0; COORDINATES];
        let full_mass = mass_matrix_with(&biped, &legs, &q);
        let full_weight = inverse_dynamics_with(&biped, &legs, &q, &still, &still);
        let full_jacobian = foot_jacobian(&biped, &q, leg);

        let n = kept.len();
        let mass = DMatrix::from_fn(n, n, |i, j| full_mass[(kept[i], kept[j])]);
        let weight = DVector::from_fn(n, |i, _| {
            if variant.weight {
                full_weight[kept[i]]
            } else {
                0.0
            }
        });
        let jacobian = DMatrix::from_fn(2, n, |i, j| full_jacobian[i][kept[j]]);
        let selection = DMatrix::from_fn(n, driven.len(), |i, j| {
            f64::from(u8::from(kept[i] == driven[j]))
        });

        // F = -(J M^-1 J^T)^-1 J M^-1 (S tau - G)
        let factor = mass.cholesky().ok_or_else(singular)?;
        let inverse_mass_jt = factor.solve(&jacobian.transpose());
        let mobility: Matrix2<f64> = (&jacobian * &inverse_mass_jt)
            .fixed_view::<2, 2>(0, 0)
            .into();
        let scale = mobility.norm();
        if mobility.determinant() <= 1e-12 * scale * scale {
            return Err(singular());
        }
        let inverse = mobility.try_inverse().ok_or_else(singular)?;
        let per_torque = inverse * (-inverse_mass_jt.transpose() * selection).fixed_rows::<2>(0);
        let offset_n = inverse * (inverse_mass_jt.transpose() * weight).fixed_rows::<2>(0);
        let limits_n_m = driven
            .iter()
            .map(|&k| {
                if k == 3 || k == 5 {
                    biped.hip_torque_n_m
                } else {
                    biped.knee_torque_n_m
                }
            })
            .collect();
        Ok(Self {
            offset_n,
            per_torque,
            limits_n_m,
        })
    }

    /// The force that torques tau hold, N.
    pub fn force_n(&self, torques_n_m: &[f64]) -> Vector2<f64> {
        self.offset_n + &self.per_torque * DVector::from_column_slice(torques_n_m)
    }
}

/// What the two frictions make of one posture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Gain {
    /// Gain of the largest forward force, percent.
    pub forward_percent: f64,
    /// Change of the largest vertical force, percent.
    pub vertical_percent: f64,
    /// Largest (forward, vertical) force with the asymmetric brush, N.
    pub asymmetric_n: [f64; 2],
    /// The same with the symmetric coefficient, N.
    pub symmetric_n: [f64; 2],
}

/// Gains of the asymmetric brush over its symmetric mean in one posture, by the exact polygon.
///
/// # Errors
/// Those of [`ForceMap::new`].
pub fn gain(
    biped: &Biped,
    variant: Variant,
    posture: Posture,
    brush: Brush,
) -> Result<Gain, EnvelopeError> {
    let map = ForceMap::new(biped, variant, posture)?;
    let largest = |brush: Brush| {
        let region = polygon::cut_by_friction(&polygon::zonogon(&map), brush);
        [polygon::largest(&region, 0), polygon::largest(&region, 1)]
    };
    let (asymmetric_n, symmetric_n) = (largest(brush), largest(brush.symmetric()));
    let percent = |k: usize| 100.0 * (asymmetric_n[k] / symmetric_n[k] - 1.0);
    Ok(Gain {
        forward_percent: percent(0),
        vertical_percent: percent(1),
        asymmetric_n,
        symmetric_n,
    })
}

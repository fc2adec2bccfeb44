//! Positions and velocities of the biped, generic over the scalar.
//!
//! Coordinates q = [x, y, pitch, t1, t2, t3, t4]: torso centre (m), torso pitch,
//! front hip and knee, rear hip and knee (rad). x forward, y up, angles
//! counter-clockwise. Hips are relative to the torso, knees to the thigh; at zero a
//! leg hangs straight down:
//!
//! a link at absolute angle a points along e(a) = (sin a, -cos a),
//! e'(a) = (cos a, sin a), e''(a) = -e(a).
//!
//! The torso lies along e'(pitch); the hips are at +-L0/2 on it.

use crate::parameters::Biped;
use num_dual::DualNum;
use serde::{Deserialize, Serialize};

/// What the mechanics is computed with: a float or a dual number over floats.
pub trait Scalar: DualNum<Primitive = f64> + Copy {}
impl<D: DualNum<Primitive = f64> + Copy> Scalar for D {}

/// Number of coordinates.
pub const COORDINATES: usize = 7;
/// Number of driven joints: front hip, front knee, rear hip, rear knee.
pub const JOINTS: usize = 4;

/// One of the two legs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Leg {
    /// The leg at the forward end of the torso.
    Front,
    /// The leg at the other end.
    Rear,
}

impl Leg {
    /// Front, then rear: the order of their joints in q.
    pub const BOTH: [Leg; 2] = [Leg::Front, Leg::Rear];

    /// Index of the hip in q; the knee follows.
    pub fn hip_index(self) -> usize {
        match self {
            Leg::Front => 3,
            Leg::Rear => 5,
        }
    }

    /// Index of the knee in q.
    pub fn knee_index(self) -> usize {
        self.hip_index() + 1
    }

    /// Side of the torso on which the hip sits: +1 front, -1 rear.
    pub fn side(self) -> f64 {
        match self {
            Leg::Front => 1.0,
            Leg::Rear => -1.0,
        }
    }
}

/// e(a) = (sin a, -cos a): direction of a link at absolute angle a.
pub(crate) fn along<D: Scalar>(angle: D) -> [D; 2] {
    let (sine, cosine) = angle.sin_cos();
    [sine, -cosine]
}

/// Absolute angles of thigh and shank of a leg, rad.
pub fn link_angles<D: Scalar>(q: &[D; COORDINATES], leg: Leg) -> [D; 2] {
    let thigh = q[2] + q[leg.hip_index()];
    [thigh, thigh + q[leg.knee_index()]]
}

/// Points of one leg.
#[derive(Clone, Copy, Debug)]
pub struct LegPoints<D> {
    /// Hip, m.
    pub hip: [D; 2],
    /// Knee, m.
    pub knee: [D; 2],
    /// Foot, m.
    pub foot: [D; 2],
}

/// Hip, knee and foot of a leg in the world, m.
pub fn leg_points<D: Scalar>(biped: &Biped, q: &[D; COORDINATES], leg: Leg) -> LegPoints<D> {
    let half = leg.side() * 0.5 * biped.torso_length_m;
    let (sine, cosine) = q[2].sin_cos();
    let hip = [q[0] + cosine * half, q[1] + sine * half];
    let [thigh, shank] = link_angles(q, leg);
    let thigh = along(thigh);
    let shank = along(shank);
    let knee = [
        hip[0] + thigh[0] * biped.thigh.length_m,
        hip[1] + thigh[1] * biped.thigh.length_m,
    ];
    let foot = [
        knee[0] + shank[0] * biped.shank.length_m,
        knee[1] + shank[1] * biped.shank.length_m,
    ];
    LegPoints { hip, knee, foot }
}

/// Jacobian of the foot of a leg, d(foot)/dq: two rows (x, y) of seven, m/rad and 1.
///
/// A rotation of everything below a point p moves the foot f by the perpendicular
/// of its lever: d f / d angle = (-(f_y - p_y), f_x - p_x).
pub fn foot_jacobian<D: Scalar>(
    biped: &Biped,
    q: &[D; COORDINATES],
    leg: Leg,
) -> [[D; COORDINATES]; 2] {
    let points = leg_points(biped, q, leg);
    let zero = D::from(0.0);
    let mut rows = [[zero; COORDINATES]; 2];
    rows[0][0] = D::from(1.0);
    rows[1][1] = D::from(1.0);
    let centre = [q[0], q[1]];
    for (column, pivot) in [
        (2, centre),
        (leg.hip_index(), points.hip),
        (leg.knee_index(), points.knee),
    ] {
        rows[0][column] = pivot[1] - points.foot[1];
        rows[1][column] = points.foot[0] - pivot[0];
    }
    rows
}

/// Velocity of the foot of a leg, J v, m/s.
pub fn foot_velocity<D: Scalar>(
    biped: &Biped,
    q: &[D; COORDINATES],
    v: &[D; COORDINATES],
    leg: Leg,
) -> [D; 2] {
    let jacobian = foot_jacobian(biped, q, leg);
    let row = |row: &[D; COORDINATES]| {
        let (hip, knee) = (leg.hip_index(), leg.knee_index());
        row[2] * v[2] + row[hip] * v[hip] + row[knee] * v[knee]
    };
    [v[0] + row(&jacobian[0]), v[1] + row(&jacobian[1])]
}

/// Acceleration of the foot of a leg, J a + dJ/dt v, m/s^2.
///
/// Along the chain torso - thigh - shank every segment s e(angle) contributes
/// s (angle'' e' - angle'^2 e).
pub fn foot_acceleration<D: Scalar>(
    biped: &Biped,
    q: &[D; COORDINATES],
    v: &[D; COORDINATES],
    a: &[D; COORDINATES],
    leg: Leg,
) -> [D; 2] {
    let (hip, knee) = (leg.hip_index(), leg.knee_index());
    // The torso axis is e(pitch + 90 deg) = (cos, sin).
    let (sine, cosine) = q[2].sin_cos();
    let [thigh, shank] = link_angles(q, leg);
    let segments = [
        (
            leg.side() * 0.5 * biped.torso_length_m,
            [cosine, sine],
            v[2],
            a[2],
        ),
        (
            biped.thigh.length_m,
            along(thigh),
            v[2] + v[hip],
            a[2] + a[hip],
        ),
        (
            biped.shank.length_m,
            along(shank),
            v[2] + v[hip] + v[knee],
            a[2] + a[hip] + a[knee],
        ),
    ];
    let mut total = [a[0], a[1]];
    for (length, direction, rate, acceleration) in segments {
        let perpendicular = [-direction[1], direction[0]];
        for k in 0..2 {
            total[k] += (perpendicular[k] * acceleration - direction[k] * rate * rate) * length;
        }
    }
    total
}

//! Equations of motion M(q) a + C(q, v) + G(q) = [0, 0, 0, tau] + J^T F as a residual.
//!
//! The left side is computed by virtual work, body by body: with p_b the mass
//! centre of body b, phi_b its angle and g the acceleration of gravity,
//!
//! M a + C + G = sum_b (dp_b/dq)^T m_b (p_b'' + g e_y) + (dphi_b/dq)^T I_b phi_b''.
//!
//! No matrix is inverted, so the derivatives stay cheap and the residual is linear in
//! a, tau and F. SI units throughout; signs as in [`crate::kinematics`].

use crate::kinematics::{
    COORDINATES, JOINTS, Leg, Scalar, along, foot_jacobian, leg_points, link_angles,
};
use crate::parameters::{Biped, Link};
use nalgebra::{SMatrix, SVector};

/// Coordinates that turn a link, and the points about which they turn it.
type Pivots = Vec<(usize, [f64; 2])>;

/// Square matrix over the coordinates.
pub type Matrix7 = SMatrix<f64, COORDINATES, COORDINATES>;
/// Vector over the coordinates.
pub type Vector7 = SVector<f64, COORDINATES>;

/// Acceleration of one point (gravity included); it accumulates along the chain.
#[derive(Clone, Copy)]
struct Point<D> {
    acceleration: [D; 2],
}

impl<D: Scalar> Point<D> {
    /// The point `length` further along a segment of direction e turning at `rate`:
    /// p'' + length (angle'' e_perp - angle'^2 e).
    fn further(self, length: f64, direction: [D; 2], rate: D, angular: D) -> Self {
        let squared = rate * rate;
        Self {
            acceleration: [
                self.acceleration[0] + (-direction[1] * angular - direction[0] * squared) * length,
                self.acceleration[1] + (direction[0] * angular - direction[1] * squared) * length,
            ],
        }
    }
}

/// Generalised forces M(q) a + C(q, v) + G(q), N and N m.
///
/// **Shape**: seven coordinates in, seven forces out, in the order of q.
pub fn inverse_dynamics<D: Scalar>(
    biped: &Biped,
    q: &[D; COORDINATES],
    v: &[D; COORDINATES],
    a: &[D; COORDINATES],
) -> [D; COORDINATES] {
    inverse_dynamics_with(biped, &Leg::BOTH, q, v, a)
}

/// [`inverse_dynamics`] of a torso that carries only `legs`: the rows of a missing leg are zero.
pub fn inverse_dynamics_with<D: Scalar>(
    biped: &Biped,
    legs: &[Leg],
    q: &[D; COORDINATES],
    v: &[D; COORDINATES],
    a: &[D; COORDINATES],
) -> [D; COORDINATES] {
    let gravity = biped.gravity_m_s2;
    let mut force = [D::from(0.0); COORDINATES];
    // Torso: m0 (x'', y'' + g) and I0 pitch''.
    force[0] = a[0] * biped.torso_mass_kg;
    force[1] = (a[1] + gravity) * biped.torso_mass_kg;
    force[2] = a[2] * biped.torso_inertia_kg_m2;

    let (sine, cosine) = q[2].sin_cos();
    let axis = [cosine, sine];
    let centre = Point {
        acceleration: [a[0], a[1] + gravity],
    };
    for &leg in legs {
        let half = leg.side() * 0.5 * biped.torso_length_m;
        let hip = centre.further(half, axis, v[2], a[2]);
        let (i, j) = (leg.hip_index(), leg.knee_index());
        let thigh_rate = v[2] + v[i];
        let thigh_angular = a[2] + a[i];
        let (shank_rate, shank_angular) = (thigh_rate + v[j], thigh_angular + a[j]);
        let [thigh_angle, shank_angle] = link_angles(q, leg);
        let (thigh, shank) = (along(thigh_angle), along(shank_angle));

        let thigh_centre = hip.further(biped.thigh.centre_m, thigh, thigh_rate, thigh_angular);
        let knee = hip.further(biped.thigh.length_m, thigh, thigh_rate, thigh_angular);
        let shank_centre = knee.further(biped.shank.centre_m, shank, shank_rate, shank_angular);

        // Forces that move the mass centres, gravity included.
        let on_thigh = thigh_centre.acceleration.map(|c| c * biped.thigh.mass_kg);
        let on_shank = shank_centre.acceleration.map(|c| c * biped.shank.mass_kg);
        // Moment about a joint: lever x force, with the lever of the segment (e_x, e_y).
        let moment = |e: [D; 2], f: [D; 2]| e[0] * f[1] - e[1] * f[0];
        let about_knee = shank_angular * biped.shank.inertia_kg_m2
            + moment(shank, on_shank) * biped.shank.centre_m;
        let about_hip = about_knee
            + thigh_angular * biped.thigh.inertia_kg_m2
            + moment(thigh, on_thigh) * biped.thigh.centre_m
            + moment(thigh, on_shank) * biped.thigh.length_m;
        let on_leg = [on_thigh[0] + on_shank[0], on_thigh[1] + on_shank[1]];

        force[0] += on_leg[0];
        force[1] += on_leg[1];
        force[2] += about_hip + moment(axis, on_leg) * half;
        force[i] = about_hip;
        force[j] = about_knee;
    }
    force
}

/// Residual of the equations of motion, M a + C + G - [0, 0, 0, tau] - sum J^T F, N and N m.
///
/// `contacts`: force of the ground on the foot (x, y), N, leg by leg.
pub fn residual<D: Scalar>(
    biped: &Biped,
    q: &[D; COORDINATES],
    v: &[D; COORDINATES],
    a: &[D; COORDINATES],
    torques: &[D; JOINTS],
    contacts: &[(Leg, [D; 2])],
) -> [D; COORDINATES] {
    let mut residual = inverse_dynamics(biped, q, v, a);
    for (k, torque) in torques.iter().enumerate() {
        residual[3 + k] -= *torque;
    }
    for (leg, force) in contacts {
        let jacobian = foot_jacobian(biped, q, *leg);
        residual[0] -= force[0];
        residual[1] -= force[1];
        for k in [2, leg.hip_index(), leg.knee_index()] {
            residual[k] -= jacobian[0][k] * force[0] + jacobian[1][k] * force[1];
        }
    }
    residual
}

/// Mass matrix M(q) by virtual work, sum_b m_b J_b^T J_b + I_b Jphi_b^T Jphi_b.
///
/// A second path beside [`inverse_dynamics`], whose columns M e_k must agree.
pub fn mass_matrix(biped: &Biped, q: &[f64; COORDINATES]) -> Matrix7 {
    mass_matrix_with(biped, &Leg::BOTH, q)
}

/// [`mass_matrix`] of a torso that carries only `legs`: rows and columns of a missing leg are zero.
pub fn mass_matrix_with(biped: &Biped, legs: &[Leg], q: &[f64; COORDINATES]) -> Matrix7 {
    let mut mass = Matrix7::zeros();
    for k in 0..2 {
        mass[(k, k)] += biped.torso_mass_kg;
    }
    mass[(2, 2)] += biped.torso_inertia_kg_m2;
    for &leg in legs {
        let points = leg_points(biped, q, leg);
        let [thigh, shank] = link_angles(q, leg);
        let (i, j) = (leg.hip_index(), leg.knee_index());
        let bodies: [(Link, [f64; 2], [f64; 2], Pivots); 2] = [
            (
                biped.thigh,
                points.hip,
                along(thigh),
                vec![(2, [q[0], q[1]]), (i, points.hip)],
            ),
            (
                biped.shank,
                points.knee,
                along(shank),
                vec![(2, [q[0], q[1]]), (i, points.hip), (j, points.knee)],
            ),
        ];
        for (link, joint, direction, pivots) in bodies {
            let centre = [
                joint[0] + link.centre_m * direction[0],
                joint[1] + link.centre_m * direction[1],
            ];
            let mut rows = [Vector7::zeros(), Vector7::zeros(), Vector7::zeros()];
            rows[0][0] = 1.0;
            rows[1][1] = 1.0;
            for (column, pivot) in pivots {
                rows[0][column] = pivot[1] - centre[1];
                rows[1][column] = centre[0] - pivot[0];
                rows[2][column] = 1.0;
            }
            mass += link.mass_kg * (rows[0] * rows[0].transpose() + rows[1] * rows[1].transpose())
                + link.inertia_kg_m2 * rows[2] * rows[2].transpose();
        }
    }
    mass
}

/// Kinetic and potential energy, J (potential zero at y = 0).
pub fn energies<D: Scalar>(biped: &Biped, q: &[D; COORDINATES], v: &[D; COORDINATES]) -> (D, D) {
    let mut kinetic = (v[0] * v[0] + v[1] * v[1]) * (0.5 * biped.torso_mass_kg)
        + v[2] * v[2] * (0.5 * biped.torso_inertia_kg_m2);
    let mut potential = q[1] * (biped.torso_mass_kg * biped.gravity_m_s2);
    for (mass, inertia, position, velocity, rate) in leg_bodies(biped, q, v) {
        kinetic += (velocity[0] * velocity[0] + velocity[1] * velocity[1]) * (0.5 * mass)
            + rate * rate * (0.5 * inertia);
        potential += position[1] * (mass * biped.gravity_m_s2);
    }
    (kinetic, potential)
}

/// Linear momentum (x, y), N s, and angular momentum about the mass centre of the whole
/// biped, N m s.
pub fn momenta<D: Scalar>(
    biped: &Biped,
    q: &[D; COORDINATES],
    v: &[D; COORDINATES],
) -> ([D; 2], D) {
    let mut bodies = leg_bodies(biped, q, v);
    bodies.push((
        biped.torso_mass_kg,
        biped.torso_inertia_kg_m2,
        [q[0], q[1]],
        [v[0], v[1]],
        v[2],
    ));
    let total = biped.total_mass_kg();
    let zero = D::from(0.0);
    let (mut linear, mut centre) = ([zero; 2], [zero; 2]);
    for (mass, _, position, velocity, _) in &bodies {
        for k in 0..2 {
            linear[k] += velocity[k] * *mass;
            centre[k] += position[k] * (*mass / total);
        }
    }
    let mut angular = zero;
    for (mass, inertia, position, velocity, rate) in bodies {
        let lever = [position[0] - centre[0], position[1] - centre[1]];
        angular += (lever[0] * velocity[1] - lever[1] * velocity[0]) * mass + rate * inertia;
    }
    (linear, angular)
}

/// Mass, inertia, position, velocity and angular rate of the four links.
#[allow(clippy::type_complexity)]
fn leg_bodies<D: Scalar>(
    biped: &Biped,
    q: &[D; COORDINATES],
    v: &[D; COORDINATES],
) -> Vec<(f64, f64, [D; 2], [D; 2], D)> {
    let half = 0.5 * biped.torso_length_m;
    let (sine, cosine) = q[2].sin_cos();
    let mut bodies = Vec::with_capacity(5);
    for leg in Leg::BOTH {
        let (i, j) = (leg.hip_index(), leg.knee_index());
        let points = leg_points(biped, q, leg);
        let [thigh, shank] = link_angles(q, leg).map(along);
        let rates = [v[2] + v[i], v[2] + v[i] + v[j]];
        let lever = leg.side() * half;
        let hip_velocity = [v[0] - sine * v[2] * lever, v[1] + cosine * v[2] * lever];
        let turned =
            |e: [D; 2], rate: D, length: f64| [-e[1] * rate * length, e[0] * rate * length];
        let add = |p: [D; 2], r: [D; 2]| [p[0] + r[0], p[1] + r[1]];
        let at = |p: [D; 2], e: [D; 2], l: f64| [p[0] + e[0] * l, p[1] + e[1] * l];
        let (m1, m2) = (&biped.thigh, &biped.shank);
        bodies.push((
            m1.mass_kg,
            m1.inertia_kg_m2,
            at(points.hip, thigh, m1.centre_m),
            add(hip_velocity, turned(thigh, rates[0], m1.centre_m)),
            rates[0],
        ));
        let knee_velocity = add(hip_velocity, turned(thigh, rates[0], m1.length_m));
        bodies.push((
            m2.mass_kg,
            m2.inertia_kg_m2,
            at(points.knee, shank, m2.centre_m),
            add(knee_velocity, turned(shank, rates[1], m2.centre_m)),
            rates[1],
        ));
    }
    bodies
}

/// Accelerations from torques and ground forces: M a = [0, 0, 0, tau] + J^T F - C - G.
///
/// For integrating a motion forward; the optimisation never calls it. `None` where the mass
/// matrix is not positive definite (which a checked [`Biped`] cannot have).
pub fn forward_dynamics(
    biped: &Biped,
    q: &[f64; COORDINATES],
    v: &[f64; COORDINATES],
    torques: &[f64; JOINTS],
    contacts: &[(Leg, [f64; 2])],
) -> Option<[f64; COORDINATES]> {
    let bias = residual(biped, q, v, &[0.0; COORDINATES], torques, contacts);
    let solution = mass_matrix(biped, q)
        .cholesky()?
        .solve(&-Vector7::from(bias));
    Some(solution.into())
}

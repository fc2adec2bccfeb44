//! What holds at one collocation point, in time-scaled variables.
//!
//! With w = h v and b = h^2 a the equations of motion times h^2 read
//!
//! M(q) b + C(q, w) + h^2 (G(q) - S tau - J^T F) = 0.
//!
//! C is quadratic in the velocity, so h^2 C(q, v) = C(q, w): one call of the inverse dynamics with
//! (w, b) and gravity h^2 g gives the first part.

use super::{Contact, Problem};
use crate::dynamics::inverse_dynamics;
use crate::kinematics::{
    COORDINATES, JOINTS, Leg, Scalar, foot_jacobian, foot_velocity, leg_points,
};

/// The quantities of one point.
pub(super) struct Point<D> {
    pub q: [D; COORDINATES],
    pub w: [D; COORDINATES],
    pub b: [D; COORDINATES],
    pub torques: [D; JOINTS],
    /// Length of the interval, s.
    pub h: D,
}

/// Equations of motion times h^2, with the ground force on the standing leg.
pub(super) fn motion_rows<D: Scalar>(
    problem: &Problem,
    point: &Point<D>,
    standing: Option<(Leg, [D; 2])>,
    rows: &mut [D],
) {
    let biped = &problem.biped;
    let h2 = point.h * point.h;
    // Gravity enters as an upward acceleration of the whole body: y'' + g, here h^2 (y'' + g).
    let gravity = biped.gravity_m_s2;
    let weightless = crate::parameters::Biped {
        gravity_m_s2: 0.0,
        ..*biped
    };
    let mut lifted = point.b;
    lifted[1] += h2 * gravity;
    let inertial = inverse_dynamics(&weightless, &point.q, &point.w, &lifted);
    rows[..COORDINATES].copy_from_slice(&inertial);
    for k in 0..JOINTS {
        rows[3 + k] -= h2 * point.torques[k];
    }
    if let Some((leg, force)) = standing {
        let jacobian = foot_jacobian(biped, &point.q, leg);
        let force = force.map(|component| component * h2);
        rows[0] -= force[0];
        rows[1] -= force[1];
        for k in [2, leg.hip_index(), leg.knee_index()] {
            rows[k] -= jacobian[0][k] * force[0] + jacobian[1][k] * force[1];
        }
    }
}

/// Height of the foot, its scaled velocity h (v_x, v_y), and, of a compliant contact, the
/// ground force (x, y), N.
pub(super) fn compliant_force<D: Scalar>(
    problem: &Problem,
    point: &Point<D>,
    leg: Leg,
) -> Option<[D; 2]> {
    let Contact::Compliant(ground) = problem.contact else {
        return None;
    };
    let height = leg_points(&problem.biped, &point.q, leg).foot[1];
    let speed = foot_velocity(&problem.biped, &point.q, &point.w, leg).map(|s| s / point.h);
    let normal = ground.normal_force(height, speed[1]);
    Some([
        ground.friction_coefficient(problem.brush, speed[0]) * normal,
        normal,
    ])
}

/// Impact times h_before h_after, M (w+ h- - w- h+) - J^T L h+ h-: zero when the impulse L, N s,
/// changes the velocity from w-/h- to w+/h+.
pub(super) fn impact_rows<D: Scalar>(
    problem: &Problem,
    q: &[D; COORDINATES],
    before: (&[D; COORDINATES], D),
    after: (&[D; COORDINATES], D),
    leg: Leg,
    impulse: [D; 2],
    rows: &mut [D],
) {
    let weightless = crate::parameters::Biped {
        gravity_m_s2: 0.0,
        ..problem.biped
    };
    let jump = std::array::from_fn(|k| after.0[k] * before.1 - before.0[k] * after.1);
    let still = [D::from(0.0); COORDINATES];
    let momentum = inverse_dynamics(&weightless, q, &still, &jump);
    let jacobian = foot_jacobian(&problem.biped, q, leg);
    let impulse = impulse.map(|component| component * before.1 * after.1);
    for k in 0..COORDINATES {
        rows[k] = momentum[k] - jacobian[0][k] * impulse[0] - jacobian[1][k] * impulse[1];
    }
}

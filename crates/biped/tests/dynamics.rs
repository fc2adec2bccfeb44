//! Rigid-body dynamics: every equation by a second path.

mod sample;

use biped::dynamics::{
    energies, forward_dynamics, inverse_dynamics, mass_matrix, momenta, residual,
};
use biped::kinematics::{
    COORDINATES, Leg, Scalar, foot_acceleration, foot_jacobian, foot_velocity, leg_points,
};
use nalgebra::SVector;
use num_dual::{Dual2_64, Dual64, HyperDual64, gradient};
use proptest::prelude::*;

type State = [f64; COORDINATES];

fn state() -> impl Strategy<Value = State> {
    prop::array::uniform7(-1.5_f64..1.5)
}

fn close(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance * (1.0 + a.abs().max(b.abs()))
}

/// d/dt (dL/dv) - dL/dq by automatic differentiation of the energies.
fn lagrange(q: &State, v: &State, a: &State) -> State {
    let biped = sample::biped();
    std::array::from_fn(|k| {
        // d/dt dL/dv_k = sum_j (d2L/dv_k dq_j) v_j + (d2L/dv_k dv_j) a_j: a second
        // derivative along the direction (v, a), mixed with v_k.
        let mut qd = q.map(HyperDual64::from);
        let mut vd = v.map(HyperDual64::from);
        for j in 0..COORDINATES {
            qd[j].eps2 = v[j];
            vd[j].eps2 = a[j];
        }
        vd[k].eps1 = 1.0;
        let (kinetic, potential) = energies(&biped, &qd, &vd);
        let rate = (kinetic - potential).eps1eps2;
        let mut qd = q.map(Dual64::from);
        qd[k].eps = 1.0;
        let (kinetic, potential) = energies(&biped, &qd, &v.map(Dual64::from));
        rate - (kinetic - potential).eps
    })
}

proptest! {
    #[test]
    fn equations_of_motion_are_those_of_lagrange(q in state(), v in state(), a in state()) {
        let expected = lagrange(&q, &v, &a);
        let ours = inverse_dynamics(&sample::biped(), &q, &v, &a);
        for k in 0..COORDINATES {
            prop_assert!(close(ours[k], expected[k], 1e-12), "row {k}: {} / {}", ours[k], expected[k]);
        }
    }

    #[test]
    fn mass_matrix_is_the_derivative_by_the_accelerations(q in state(), v in state()) {
        let biped = sample::biped();
        let mass = mass_matrix(&biped, &q);
        let zero = [0.0; COORDINATES];
        let base = inverse_dynamics(&biped, &q, &v, &zero);
        for k in 0..COORDINATES {
            let mut a = zero;
            a[k] = 1.0;
            let column = inverse_dynamics(&biped, &q, &v, &a);
            for row in 0..COORDINATES {
                prop_assert!(close(column[row] - base[row], mass[(row, k)], 1e-12));
            }
        }
        prop_assert!(mass.cholesky().is_some());
        let speed = SVector::from(v);
        let kinetic = energies(&biped, &q, &v).0;
        prop_assert!(close(0.5 * (speed.transpose() * mass * speed)[0], kinetic, 1e-12));
    }

    #[test]
    fn foot_velocity_and_acceleration_are_time_derivatives_of_its_place(
        q in state(), v in state(), a in state(),
    ) {
        let biped = sample::biped();
        // q(t) = q + v t + a t^2/2 as a second-order dual number in t.
        let path: [Dual2_64; COORDINATES] = std::array::from_fn(|k| Dual2_64::new(q[k], v[k], a[k]));
        for leg in Leg::BOTH {
            let place = leg_points(&biped, &path, leg).foot;
            let velocity = foot_velocity(&biped, &q, &v, leg);
            let acceleration = foot_acceleration(&biped, &q, &v, &a, leg);
            let jacobian = foot_jacobian(&biped, &q, leg);
            for k in 0..2 {
                prop_assert!(close(place[k].v1, velocity[k], 1e-12));
                prop_assert!(close(place[k].v2, acceleration[k], 1e-12));
                let (_, exact) = gradient(
                    |x: SVector<_, COORDINATES>| leg_points(&biped, &x.into(), leg).foot[k],
                    &SVector::from(q),
                );
                for j in 0..COORDINATES {
                    prop_assert!(close(jacobian[k][j], exact[j], 1e-12));
                }
            }
        }
    }

    /// Power balance: d(T + V)/dt = sum tau t' + F . v_foot.
    #[test]
    fn power_of_torques_and_forces_is_the_change_of_energy(
        q in state(), v in state(), torques in prop::array::uniform4(-35.0_f64..35.0),
        force in prop::array::uniform2(-100.0_f64..100.0),
    ) {
        let biped = sample::biped();
        let contact = [(Leg::Rear, force)];
        let a = forward_dynamics(&biped, &q, &v, &torques, &contact).unwrap();
        let qd: [Dual64; COORDINATES] = std::array::from_fn(|k| Dual64::new(q[k], v[k]));
        let vd: [Dual64; COORDINATES] = std::array::from_fn(|k| Dual64::new(v[k], a[k]));
        let (kinetic, potential) = energies(&biped, &qd, &vd);
        let foot = foot_velocity(&biped, &q, &v, Leg::Rear);
        let joints: f64 = (0..4).map(|k| torques[k] * v[3 + k]).sum();
        let power = joints + force[0] * foot[0] + force[1] * foot[1];
        prop_assert!(close((kinetic + potential).eps, power, 1e-9));
    }

    /// Momentum balance: forces change linear momentum, their moments the angular one.
    #[test]
    fn only_the_ground_and_gravity_change_the_momentum(
        q in state(), v in state(), torques in prop::array::uniform4(-35.0_f64..35.0),
        force in prop::array::uniform2(-100.0_f64..100.0),
    ) {
        let biped = sample::biped();
        let a = forward_dynamics(&biped, &q, &v, &torques, &[(Leg::Front, force)]).unwrap();
        let qd: [Dual64; COORDINATES] = std::array::from_fn(|k| Dual64::new(q[k], v[k]));
        let vd: [Dual64; COORDINATES] = std::array::from_fn(|k| Dual64::new(v[k], a[k]));
        let (linear, angular) = momenta(&biped, &qd, &vd);
        prop_assert!(close(linear[0].eps, force[0], 1e-10));
        prop_assert!(close(linear[1].eps, force[1] - biped.total_mass_kg() * biped.gravity_m_s2, 1e-10));
        let foot = leg_points(&biped, &q, Leg::Front).foot;
        let centre = mass_centre(&q);
        let moment = (foot[0] - centre[0]) * force[1] - (foot[1] - centre[1]) * force[0];
        prop_assert!(close(angular.eps, moment, 1e-9), "{} / {moment}", angular.eps);
    }

    /// With the accelerations of the forward dynamics the residual vanishes.
    #[test]
    fn the_residual_vanishes_on_the_motion(q in state(), v in state()) {
        let biped = sample::biped();
        let torques = [3.0, -2.0, 1.0, 4.0];
        let contacts = [(Leg::Front, [12.0, 80.0]), (Leg::Rear, [-3.0, 20.0])];
        let a = forward_dynamics(&biped, &q, &v, &torques, &contacts).unwrap();
        for row in residual(&biped, &q, &v, &a, &torques, &contacts) {
            prop_assert!(row.abs() < 1e-9);
        }
    }
}

/// Potential energy over weight gives the height; its derivative along x is zero, so the
/// place along x comes from the momentum at unit rates.
fn mass_centre(q: &State) -> [f64; 2] {
    let biped = sample::biped();
    let weight = biped.total_mass_kg() * biped.gravity_m_s2;
    let y = energies(&biped, q, &[0.0; COORDINATES]).1 / weight;
    // Turn the whole body by -90 degrees about the torso centre: heights become x.
    let mut turned = *q;
    turned[0] = 0.0;
    turned[1] = 0.0;
    turned[2] += std::f64::consts::FRAC_PI_2;
    let x = q[0] + energies(&biped, &turned, &[0.0; COORDINATES]).1 / weight;
    [x, y]
}

/// A body in free fall without torque keeps T + V, and RK4 shows it with fourth order.
#[test]
fn free_fall_keeps_its_energy_to_fourth_order() {
    let drifts: Vec<f64> = [400_usize, 800].into_iter().map(energy_drift).collect();
    let order = (drifts[0] / drifts[1]).log2();
    assert!(order > 3.5, "order {order}, drifts {drifts:?}");
    assert!(drifts[1] < 1e-6);
}

fn energy_drift(steps: usize) -> f64 {
    let biped = sample::biped();
    let rate = |s: &[f64; 14]| -> [f64; 14] {
        let q: State = std::array::from_fn(|k| s[k]);
        let v: State = std::array::from_fn(|k| s[7 + k]);
        let a = forward_dynamics(&biped, &q, &v, &[0.0; 4], &[]).unwrap();
        std::array::from_fn(|k| if k < 7 { v[k] } else { a[k - 7] })
    };
    let along = |s: &[f64; 14], d: &[f64; 14], h: f64| std::array::from_fn(|k| s[k] + h * d[k]);
    let mut s = [
        0.0, 1.0, 0.1, -0.7, 1.4, -0.3, 0.9, 5.0, 1.0, 2.0, 8.0, -9.0, -6.0, 7.0,
    ];
    let total = |s: &[f64; 14]| {
        let (t, v) = energies(
            &biped,
            &std::array::from_fn(|k| s[k]),
            &std::array::from_fn(|k| s[7 + k]),
        );
        t + v
    };
    let before = total(&s);
    let h = 0.4 / steps as f64;
    for _ in 0..steps {
        let k1 = rate(&s);
        let k2 = rate(&along(&s, &k1, h / 2.0));
        let k3 = rate(&along(&s, &k2, h / 2.0));
        let k4 = rate(&along(&s, &k3, h));
        for k in 0..14 {
            s[k] += h / 6.0 * (k1[k] + 2.0 * k2[k] + 2.0 * k3[k] + k4[k]);
        }
    }
    (total(&s) - before).abs()
}

/// Taylor test: the error of the first-order prediction falls with the square of the step.
#[test]
fn derivatives_pass_the_taylor_test() {
    fn value<D: Scalar>(x: &[D; 21]) -> D {
        let q = std::array::from_fn(|k| x[k]);
        let v = std::array::from_fn(|k| x[7 + k]);
        let a = std::array::from_fn(|k| x[14 + k]);
        inverse_dynamics(&sample::biped(), &q, &v, &a)
            .into_iter()
            .enumerate()
            .map(|(k, row)| row * (1.0 + k as f64))
            .fold(D::from(0.0), |sum, term| sum + term)
    }
    let x: [f64; 21] = std::array::from_fn(|k| (1.3 * k as f64).sin());
    let direction: [f64; 21] = std::array::from_fn(|k| (0.7 * k as f64).cos());
    let dual: [Dual64; 21] = std::array::from_fn(|k| Dual64::new(x[k], direction[k]));
    let slope = value(&dual).eps;
    assert!(slope.abs() > 1.0);
    let error = |h: f64| {
        let shifted: [f64; 21] = std::array::from_fn(|k| x[k] + h * direction[k]);
        (value(&shifted) - value(&x) - h * slope).abs()
    };
    for h in [1e-1, 3e-2, 1e-2, 3e-3] {
        let ratio = error(h) / error(h / 2.0);
        assert!((3.3..4.7).contains(&ratio), "step {h}: ratio {ratio}");
    }
}

/// Values of a second program: the Lagrangian differentiated by CasADi (benches/gait/stride.py).
#[test]
fn generalised_forces_are_those_of_a_second_program() {
    let q = [0.3, 0.41, 0.12, -0.8, 1.5, -0.4, 1.1];
    let v = [6.0, -0.3, 1.2, -14.0, 9.0, 11.0, -7.0];
    let a = [12.0, -9.0, 30.0, -150.0, 220.0, 90.0, -310.0];
    let golden = [
        174.01148589735416,
        66.78649804888454,
        25.525120966098253,
        -3.2747400099089603,
        1.9202027000780273,
        6.67881990398669,
        -1.2009101867308547,
    ];
    for (ours, golden) in inverse_dynamics(&sample::biped(), &q, &v, &a)
        .into_iter()
        .zip(golden)
    {
        assert!(close(ours, golden, 1e-12), "{ours} / {golden}");
    }
}

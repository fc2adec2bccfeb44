//! Solves strides again from starts in a JSON file and prints what the certificate says.
//!
//! `cargo run --release -p biped --example certify -- FILE [LIMIT]`

use biped::contact::{Brush, Ground};
use biped::gait::{
    Contact, Goal, Limits, Mesh, Problem, Touchdown, motion::Motion, programme::Stride,
};
use biped::parameters::{Biped, Link};
use trajectory::{Options, Start, solve};

fn main() {
    let path = std::env::args().nth(1).unwrap();
    let limit: usize = std::env::args()
        .nth(2)
        .and_then(|n| n.parse().ok())
        .unwrap_or(30);
    let rows: Vec<serde_json::Value> =
        serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let biped = Biped {
        torso_mass_kg: 7.5,
        torso_inertia_kg_m2: 0.1,
        torso_length_m: 0.6,
        thigh: Link {
            mass_kg: 2.0,
            inertia_kg_m2: 0.016,
            length_m: 0.3,
            centre_m: 0.05,
        },
        shank: Link {
            mass_kg: 0.28,
            inertia_kg_m2: 0.01,
            length_m: 0.3,
            centre_m: 0.05,
        },
        hip_torque_n_m: 35.0,
        knee_torque_n_m: 35.0,
        gravity_m_s2: 9.81,
    };
    let brush = Brush {
        forward: 0.9049,
        reverse: 0.4314,
    };
    for row in rows {
        let number = |key: &str| row[key].as_f64().unwrap();
        let contact = if row["kind"] == "rigid" {
            Contact::Rigid(Touchdown::Impact)
        } else {
            Contact::Compliant(Ground {
                stiffness_n_m15: number("k"),
                loss_s_m: number("c"),
                slip_scale_m_s: 0.1,
            })
        };
        let problem = Problem {
            biped,
            brush: match row["brush"].as_str().unwrap() {
                "symmetric" => brush.symmetric(),
                "asymmetric" => brush,
                _ => brush.backwards(),
            },
            contact,
            goal: Goal::Speed {
                weight: number("weight"),
                aim_m_s: number("aim"),
            },
            limits: Limits::default(),
            mesh: Mesh::default(),
            rate_weight_s2: 1e-6,
        };
        let x: Vec<f64> = row["x"]
            .as_array()
            .unwrap()
            .iter()
            .map(|v| v.as_f64().unwrap())
            .collect();
        let clock = std::time::Instant::now();
        let s = solve(
            &Stride::new(problem),
            &Start::cold(x),
            &Options {
                max_iterations: limit,
                ..Options::default()
            },
        )
        .unwrap();
        let motion = Motion::new(&problem, &s.x);
        println!(
            "{} {} Qv {} : {:?} cost {:.8} (ipopt {:.8}) speed {:.4} it {} qp {} newton {} error {:.1e} curvature {:.1e} sv {:.1e} pd {} gap {:.1e} {:.1e} energy {:.1e} reint {:.1e} {:.1?}",
            row["kind"],
            row["brush"],
            number("weight"),
            s.status,
            s.cost,
            number("cost"),
            motion.speed_m_s,
            s.counters.iterations,
            s.counters.subproblems,
            s.counters.newton_steps,
            s.certificate.error.stationarity,
            s.certificate.smallest_curvature,
            s.certificate.smallest_singular_value,
            s.certificate.positive_definite,
            motion.momentum_gap_n_s(&problem)[0],
            motion.momentum_gap_n_s(&problem)[1],
            motion.energy_gap(&problem),
            motion.reintegration_error(&problem, 20),
            clock.elapsed()
        );
    }
}

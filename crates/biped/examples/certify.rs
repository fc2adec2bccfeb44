//! Solves strides again from starts in a JSON file and prints what the certificate says.
//!
//! `cargo run --release -p biped --example certify -- FILE [LIMIT]`

use biped::contact::{Brush, Ground};
use biped::gait::{
    Contact, Goal, Limits, Mesh, Problem, Touchdown, motion::Motion, programme::Stride,
};
use trajectory::{Options, Start, solve};

#[path = "../tests/sample/mod.rs"]
mod sample;

fn main() {
    let path = std::env::args().nth(1).unwrap();
    let limit: usize = std::env::args()
        .nth(2)
        .and_then(|n| n.parse().ok())
        .unwrap_or(30);
    let rows: Vec<serde_json::Value> =
        serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let biped = sample::biped();
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

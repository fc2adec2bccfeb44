//! Solves one stride by the chain from soft and lossless to stiff and damped, and prints how it went.

use biped::contact::{Brush, Ground};
use biped::gait::{
    Contact, Goal, Limits, Mesh, Problem, motion::Motion, programme::Stride, start::Guess,
};
use trajectory::{Options, Start, solve};

#[path = "../tests/sample/mod.rs"]
mod sample;

fn main() {
    let biped = sample::biped();
    let brush = Brush {
        forward: 0.9049,
        reverse: 0.4314,
    };
    let mut problem = Problem {
        biped,
        brush: brush.symmetric(),
        contact: Contact::Compliant(Ground {
            stiffness_n_m15: 2e4,
            loss_s_m: 0.0,
            slip_scale_m_s: 1.0,
        }),
        goal: Goal::Speed {
            weight: 1.0,
            aim_m_s: 20.0,
        },
        limits: Limits::default(),
        mesh: Mesh::default(),
        rate_weight_s2: 1e-6,
    };
    let mut start = Start::cold(Guess::default().variables(&problem));
    let limit = std::env::args()
        .nth(1)
        .and_then(|n| n.parse().ok())
        .unwrap_or(300);
    let options = Options {
        history: std::env::args().len() > 3,
        max_iterations: limit,
        ..Options::default()
    };
    let cap: f64 = std::env::args()
        .nth(2)
        .and_then(|n| n.parse().ok())
        .unwrap_or(1e8);
    let options = Options {
        max_penalty: cap,
        ..options
    };
    for (aim_m_s, weight, stiffness_n_m15, loss_s_m, slip_scale_m_s, brush) in [
        (20.0, 0.002, 2e4, 0.0, 1.0, brush.symmetric()),
        (20.0, 0.005, 5e4, 0.3, 0.3, brush.symmetric()),
        (20.0, 0.01, 1e5, 0.6, 0.1, brush.symmetric()),
        (20.0, 0.01, 2e5, 1.0, 0.1, brush.symmetric()),
        (20.0, 0.03, 2e5, 1.0, 0.1, brush.symmetric()),
        (20.0, 0.1, 2e5, 1.0, 0.1, brush.symmetric()),
        (20.0, 0.3, 2e5, 1.0, 0.1, brush.symmetric()),
        (20.0, 1.0, 2e5, 1.0, 0.1, brush.symmetric()),
        (20.0, 1.0, 2e5, 1.0, 0.1, brush),
    ] {
        problem.contact = Contact::Compliant(Ground {
            stiffness_n_m15,
            loss_s_m,
            slip_scale_m_s,
        });
        problem.brush = brush;
        problem.goal = Goal::Speed { weight, aim_m_s };
        let stride = Stride::new(problem);
        let options = Options {
            max_iterations: if loss_s_m == 1.0 && stiffness_n_m15 == 2e5 {
                300
            } else {
                limit
            },
            ..options.clone()
        };
        let clock = std::time::Instant::now();
        let solution = solve(&stride, &start, &options).unwrap();
        let motion = Motion::new(&problem, &solution.x);
        println!(
            "k {stiffness_n_m15:e} c {loss_s_m}: {:?} cost {:.6} speed {:.4} T {:.4?} {:?} gap {:.1?} energy {:.1e} reint {:.1e} in {:.2?}",
            solution.status,
            solution.cost,
            motion.speed_m_s,
            motion.durations_s,
            solution.counters,
            motion.momentum_gap_n_s(&problem),
            motion.energy_gap(&problem),
            motion.reintegration_error(&problem, 20),
            clock.elapsed()
        );
        println!("{:?}", solution.certificate.error);
        for (i, it) in solution.history.iter().enumerate() {
            println!("{i} {it:?}");
        }
        start = Start::warm(&solution);
    }
}

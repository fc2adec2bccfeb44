//! Writes the cold starts of the rigid and the compliant stride as JSON, for the comparison under benches/gait.
//!
//! `cargo run --release -p biped --example cold_starts -- DIR`

use biped::contact::{Brush, Ground};
use biped::gait::{Contact, Goal, Limits, Mesh, Problem, Touchdown, start::Guess};

#[path = "../tests/sample/mod.rs"]
mod sample;

fn main() -> std::io::Result<()> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| ".".to_owned());
    let biped = sample::biped();
    let soft = Ground {
        stiffness_n_m15: 2e4,
        loss_s_m: 0.0,
        slip_scale_m_s: 1.0,
    };
    for (name, contact) in [
        ("rigid", Contact::Rigid(Touchdown::Impact)),
        ("compliant", Contact::Compliant(soft)),
    ] {
        let problem = Problem {
            biped,
            brush: Brush {
                forward: 0.9049,
                reverse: 0.4314,
            }
            .symmetric(),
            contact,
            goal: Goal::Speed {
                weight: 1.0,
                aim_m_s: 20.0,
            },
            limits: Limits::default(),
            mesh: Mesh::default(),
            rate_weight_s2: 1e-6,
        };
        let start = Guess::default().variables(&problem);
        std::fs::write(format!("{folder}/{name}.json"), format!("{start:?}"))?;
    }
    Ok(())
}

//! Writes the cold starts of the rigid and the compliant stride as JSON, for the comparison under benches/gait.
//!
//! `cargo run --release -p biped --example cold_starts -- DIR`

use biped::contact::Ground;
use biped::gait::catalogue::{CONTACT, Mount, Name};
use biped::gait::{Contact, Problem, start::Guess};

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
    let (mount, weight, aim) = (Mount::Symmetric, 1.0, 20.0);
    let rigid = Name::rigid(mount, weight, aim).problem(&biped, sample::brush());
    let stiff = Name::compliant(CONTACT, mount, weight, aim).problem(&biped, sample::brush());
    let compliant = Problem {
        contact: Contact::Compliant(soft),
        ..stiff
    };
    for (name, problem) in [("rigid", rigid), ("compliant", compliant)] {
        let start = Guess::default().variables(&problem);
        std::fs::write(format!("{folder}/{name}.json"), format!("{start:?}"))?;
    }
    Ok(())
}

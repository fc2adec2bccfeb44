//! Solves strides again from starts in a JSON file and prints what the certificate says.
//!
//! `cargo run --release -p biped --example certify -- FILE [LIMIT [OUT]]`; FILE as benches/gait writes it, or data/strides.json; OUT gets
//! the strides that were reached, as JSON.

use biped::gait::catalogue::Name;
use biped::gait::file::NamedStart;
use biped::gait::{motion::Motion, programme::Stride};
use serde::{Deserialize, Serialize};
use std::error::Error;
use trajectory::{Options, Start, solve};

#[path = "../tests/sample/mod.rs"]
mod sample;

#[derive(Deserialize)]
struct Row {
    #[serde(flatten)]
    start: NamedStart,
    /// Cost that the other program found.
    cost: Option<f64>,
}

/// What was reached from one start.
#[derive(Serialize)]
struct Reached {
    #[serde(flatten)]
    name: Name,
    certified: bool,
    cost: f64,
    speed_m_s: f64,
    steps: usize,
    x: Vec<f64>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("which file?")?;
    let limit = std::env::args().nth(2).map_or(Ok(30), |n| n.parse())?;
    let mut json: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(path)?)?;
    if let Some(starts) = json.get_mut("starts") {
        json = starts.take();
    }
    let rows: Vec<Row> = serde_json::from_value(json)?;
    let brush = sample::brush();
    let mut reached = Vec::new();
    for Row { start, cost } in rows {
        let NamedStart { name, x, .. } = start;
        let problem = name.problem(&sample::biped(), brush);
        let clock = std::time::Instant::now();
        let options = Options {
            max_iterations: limit,
            ..Options::default()
        };
        let s = solve(&Stride::new(problem), &Start::cold(x), &options)?;
        let seconds = clock.elapsed();
        let motion = Motion::new(&problem, &s.x);
        println!(
            "{name:?}: {:?} cost {:.8} (other program {cost:?}) speed {:.4} steps {} subproblems {} newton {} error {:.1e} curvature \
             {:.1e} singular value {:.1e} momentum {:.3?} energy {:.1e} {seconds:.1?}",
            s.status,
            s.cost,
            motion.speed_m_s,
            s.counters.iterations,
            s.counters.subproblems,
            s.counters.newton_steps,
            s.certificate.error.worst(),
            s.certificate.smallest_curvature,
            s.certificate.smallest_singular_value,
            motion.momentum_gap_n_s(&problem),
            motion.energy_gap(&problem),
        );
        reached.push(Reached {
            name,
            certified: s.status.is_solved(),
            cost: s.cost,
            speed_m_s: motion.speed_m_s,
            steps: s.counters.iterations,
            x: s.x,
        });
    }
    if let Some(out) = std::env::args().nth(3) {
        std::fs::write(out, serde_json::to_string(&reached)?)?;
    }
    Ok(())
}

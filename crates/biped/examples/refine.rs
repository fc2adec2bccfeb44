//! Strides on finer and finer meshes: what the mesh does to cost and speed, and what it costs.
//!
//! `cargo run --release -p biped --example refine -- FILE [WEIGHT [INTERVALS]]`; FILE as data/strides.json, INTERVALS of a stance as in
//! 32,36,42,56 (in halves of the stride's own mesh without them), each mesh from the stride on the one before.

use biped::gait::file::{NamedStart, StridesFile};
use biped::gait::refine::on_mesh;
use biped::gait::{Mesh, Problem, motion::Motion, programme::Stride};
use std::error::Error;
use trajectory::{Options, Start, solve};

#[path = "../tests/sample/mod.rs"]
mod sample;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("which file?")?;
    let wanted: Option<f64> = std::env::args().nth(2).map(|n| n.parse()).transpose()?;
    let stances: Option<Vec<usize>> = std::env::args()
        .nth(3)
        .map(|list| list.split(',').map(str::parse).collect())
        .transpose()?;
    let file: StridesFile = serde_json::from_str(&std::fs::read_to_string(path)?)?;
    let brush = sample::brush();
    for NamedStart { name, x, .. } in file.starts {
        if wanted.is_some_and(|weight| weight != name.weight) {
            continue;
        }
        println!("{name:?}");
        let mut problem = name.problem(&sample::biped(), brush);
        let mut start = Start::cold(x);
        let own = problem.mesh;
        let halves = || [2, 3, 4].map(|h| own.stance * h / 2).to_vec();
        for stance in stances.clone().unwrap_or_else(halves) {
            let mesh = Mesh {
                stance,
                flight: (own.flight * stance).div_ceil(own.stance),
                ..own
            };
            start = Start::cold(on_mesh(&problem, &start.x, mesh));
            problem = Problem { mesh, ..problem };
            let clock = std::time::Instant::now();
            let options = Options {
                max_iterations: 150,
                ..Options::default()
            };
            let s = solve(&Stride::new(problem), &start, &options)?;
            let seconds = clock.elapsed();
            let motion = Motion::new(&problem, &s.x);
            println!(
                "  {}/{}: {:?} cost {:.6} speed {:.4} energy {:.1e} again {:?} steps {} subproblems {} {seconds:.2?}",
                mesh.stance,
                mesh.flight,
                s.status,
                s.cost,
                motion.speed_m_s,
                motion.energy_gap(&problem),
                motion.reintegration(&problem, 8),
                s.counters.iterations,
                s.counters.subproblems,
            );
            start.x = s.x;
        }
    }
    Ok(())
}

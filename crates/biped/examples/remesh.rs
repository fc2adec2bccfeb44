//! Reads strides of a file on another mesh, as starts there.
//!
//! `cargo run --release -p biped --example remesh -- FILE STANCE/FLIGHT NEW_STANCE/NEW_FLIGHT OUT`; FILE as data/strides.json; a mesh as 28/8
//! (even intervals) or 28/8graded (short where the foot strikes). Strides whose length is that of another mesh are left out.

use biped::gait::file::{NamedStart, StridesFile};
use biped::gait::layout::Layout;
use biped::gait::refine::on_mesh;
use biped::gait::{Mesh, Problem};
use std::error::Error;

#[path = "../tests/sample/mod.rs"]
mod sample;

fn mesh(text: &str) -> Result<Mesh, Box<dyn Error>> {
    let (stance, flight) = text
        .split_once('/')
        .ok_or("a mesh is written STANCE/FLIGHT")?;
    let (graded, flight) = match flight.strip_suffix("graded") {
        Some(flight) => (true, flight),
        None => (false, flight),
    };
    let (stance, flight) = (stance.parse()?, flight.parse()?);
    Ok(if graded {
        Mesh::for_strikes(stance, flight)
    } else {
        Mesh::even(stance, flight)
    })
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [path, from, to, out] = arguments.as_slice() else {
        return Err("FILE STANCE/FLIGHT NEW_STANCE/NEW_FLIGHT OUT".into());
    };
    let (from, to) = (mesh(from)?, mesh(to)?);
    let file: StridesFile = serde_json::from_str(&std::fs::read_to_string(path)?)?;
    let brush = sample::brush();
    let mut rows = Vec::new();
    for NamedStart { name, x, .. } in file.starts {
        let problem = Problem {
            mesh: from,
            ..name.problem(&sample::biped(), brush)
        };
        if x.len() == Layout::new(&problem).count() {
            let x = on_mesh(&problem, &x, to);
            rows.push(serde_json::to_string(&NamedStart {
                name,
                search: None,
                x,
            })?);
        }
    }
    let text = format!("{{\"about\":\"\",\"starts\":[\n{}\n]}}\n", rows.join(",\n"));
    Ok(std::fs::write(out, text)?)
}

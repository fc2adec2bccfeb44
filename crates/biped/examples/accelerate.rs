//! Starts of the accelerating strides: each brush from periodic strides of all brushes, then from one another until nothing gets
//! better. FILE is data/strides.json, OUT data/accelerating.json.
//!
//! `cargo run --release -p biped --example accelerate -- FILE OUT`

use biped::gait::catalogue::{CONTACT, Choice, Kind, MAP_WEIGHT, Mount, Name};
use biped::gait::chain::{Case, Outcome, solve_all};
use biped::gait::file::{NamedStart, Search, StridesFile};
use biped::gait::layout::Layout;
use std::error::Error;
use trajectory::{Options, Start};

#[path = "../tests/sample/mod.rs"]
mod sample;

/// Speed at which the strides begin, m/s.
const START_M_S: f64 = 8.0;
/// Speed weights of the periodic strides that are starts.
const FROM_WEIGHTS: [f64; 3] = [0.1, 1.0, 10.0];
const STEPS: usize = 80;
const ROUNDS: usize = 4;
const ABOUT: &str = "Starts of the accelerating strides of the gait stage, not results (cargo run --release -p biped --example accelerate): \
                     solved from periodic strides of all brushes and from one another. The stage solves each again and certifies it.";

fn main() -> Result<(), Box<dyn Error>> {
    let mut paths = std::env::args().skip(1);
    let (path, out) = (
        paths.next().ok_or("which file?")?,
        paths.next().ok_or("where to?")?,
    );
    let file: StridesFile = serde_json::from_str(&std::fs::read_to_string(path)?)?;
    let periodic: Vec<Vec<f64>> = file
        .starts
        .into_iter()
        .filter(|row| {
            let own = row.name.kind == Kind::Compliant && row.name.choice == Choice::Own;
            own && (row.name.k, row.name.c) == CONTACT && FROM_WEIGHTS.contains(&row.name.weight)
        })
        .map(|row| row.x)
        .collect();
    let mut best: Vec<Option<Outcome>> = vec![None; Mount::ALL.len()];
    let mut starts = vec![periodic; Mount::ALL.len()];
    for round in 0..ROUNDS {
        let before: Vec<f64> = best.iter().map(cost).collect();
        improve(&mut best, &starts)?;
        for (mount, (found, before)) in Mount::ALL.iter().zip(best.iter().zip(&before)) {
            if let Some(found) = found {
                println!(
                    "round {round}, {}: {:?} {:.4} m/s^2, cost {:.8} ({before:.8} before), {} of {} starts",
                    mount.id(),
                    found.status,
                    found.motion.acceleration_m_s2,
                    found.cost,
                    found.found_by,
                    found.tried
                );
            }
        }
        write(&best, &out)?;
        let better: Vec<usize> = (0..best.len())
            .filter(|&k| cost(&best[k]) < before[k] - 1e-9)
            .collect();
        if better.is_empty() {
            break;
        }
        // What got better is a start for the others.
        for (k, starts) in starts.iter_mut().enumerate() {
            let others = better.iter().filter(|&&other| other != k);
            let others = others.filter_map(|&other| best[other].as_ref());
            *starts = others.map(|stride| stride.x.clone()).collect();
        }
    }
    Ok(())
}

fn cost(found: &Option<Outcome>) -> f64 {
    let certified = found.as_ref().filter(|stride| stride.is_certified());
    certified.map_or(f64::INFINITY, |stride| stride.cost)
}

fn name(mount: Mount) -> Name {
    Name::compliant(CONTACT, mount, MAP_WEIGHT, START_M_S)
}

/// Solves every brush from its starts and keeps the better of before and after.
fn improve(best: &mut [Option<Outcome>], starts: &[Vec<Vec<f64>>]) -> Result<(), Box<dyn Error>> {
    let options = Options {
        max_iterations: STEPS,
        ..Options::default()
    };
    let cases: Vec<Case> = Mount::ALL
        .iter()
        .zip(starts)
        .map(|(&mount, starts)| {
            let problem = name(mount).problem(&sample::biped(), sample::brush());
            let problem = problem.accelerating(START_M_S);
            let count = Layout::new(&problem).count();
            let starts = starts.iter().map(|x| {
                let mut x = x.clone();
                x.resize(count, 0.0);
                Start::cold(x)
            });
            Case {
                problem,
                starts: starts.collect(),
            }
        })
        .collect();
    for (kept, found) in best.iter_mut().zip(solve_all(&cases, &options)?) {
        let better = found.as_ref().is_some_and(|new| {
            let worse = kept.as_ref().is_none_or(|old| !old.is_certified());
            worse || new.is_certified() && cost(&found) < cost(kept)
        });
        if better {
            *kept = found;
        }
    }
    Ok(())
}

fn write(best: &[Option<Outcome>], path: &str) -> Result<(), Box<dyn Error>> {
    let mut rows = Vec::new();
    for (&mount, found) in Mount::ALL.iter().zip(best) {
        let Some(found) = found.as_ref().filter(|stride| stride.is_certified()) else {
            continue;
        };
        let short = |x: &f64| format!("{x:.8e}").parse::<f64>();
        rows.push(serde_json::to_string(&NamedStart {
            name: name(mount),
            search: Some(Search {
                found: found.found_by,
                tried: found.tried,
                hops: 0,
                from: None,
            }),
            x: found.x.iter().map(short).collect::<Result<_, _>>()?,
        })?);
    }
    let about = serde_json::to_string(ABOUT)?;
    let rows = rows.join(",\n");
    std::fs::write(
        path,
        format!("{{\"about\":{about},\n\"starts\":[\n{rows}\n]}}\n"),
    )?;
    Ok(())
}

//! Fills and improves a file of strides: every problem of the chapter on the gait, solved from its neighbours until nothing
//! gets better. The file is read at the start and written with every stride that is found or improved, so the work can be interrupted and resumed;
//! without a file it begins with chains from cold starts.
//!
//! `cargo run --release -p biped --example explore -- FILE [ROUNDS]`

use biped::contact::Ground;
use biped::gait::book::Book;
use biped::gait::catalogue::{CONTACT, Mount, Name, WEIGHTS, all};
use biped::gait::chain::{Case, solve_all};
use biped::gait::start::Guess;
use biped::gait::{Contact, Goal, Problem};
use serde::{Deserialize, Serialize};
use std::error::Error;
use std::path::Path;
use std::time::Instant;
use trajectory::{Options, Start};

#[path = "../tests/sample/mod.rs"]
mod sample;

const TARGETS: [f64; 2] = [8.0, 20.0];
const ABOUT: &str = "Starts of the gait stage, not results: strides of the project's own solver, each improved from its neighbours \
                     (cargo run --release -p biped --example explore). The stage solves every problem again from them and certifies \
                     what it reports.";

#[derive(Serialize, Deserialize)]
struct File {
    about: String,
    starts: Vec<Row>,
}

#[derive(Serialize, Deserialize)]
struct Row {
    #[serde(flatten)]
    name: Name,
    #[serde(flatten)]
    search: Option<Search>,
    x: Vec<f64>,
}

/// Starts that ended in a stride, of those tried, over all runs.
#[derive(Clone, Copy, Serialize, Deserialize)]
struct Search {
    found: usize,
    tried: usize,
}

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("which file?")?;
    let rounds: usize = std::env::args().nth(2).map_or(Ok(20), |n| n.parse())?;
    let clock = Instant::now();
    let options = Options {
        max_iterations: 80,
        ..Options::default()
    };
    let rows = if Path::new(&path).exists() {
        serde_json::from_str::<File>(&std::fs::read_to_string(&path)?)?.starts
    } else {
        cold()?
    };
    let biped = sample::biped();
    let mut book = Book::default();
    let named = all(TARGETS[0], TARGETS[1]).into_iter().map(|name| {
        let own = rows.iter().filter(|row| row.name == name);
        let starts = own.map(|row| Start::cold(row.x.clone())).collect();
        (name, name.problem(&biped, sample::brush()), starts)
    });
    book.add(named.collect(), &options)?;
    for entry in &mut book.entries {
        // A stride of the file, solved again, is no further start: its count goes on.
        let row = rows.iter().find(|row| row.name == entry.name);
        if let (Some(outcome), Some(search)) = (&mut entry.outcome, row.and_then(|row| row.search))
        {
            (outcome.found_by, outcome.tried) = (search.found, search.tried);
        }
    }
    write(&book, &path)?;
    report(&book, "starts", 0, clock);
    // Gaps first, so that every problem soon has a stride to start its neighbours from.
    let mut filling = true;
    for round in 1..=rounds {
        let names: Vec<Name> = if filling {
            book.gaps().collect()
        } else {
            book.entries.iter().map(|entry| entry.name).collect()
        };
        let mut better = 0;
        for name in names {
            // One problem at a time: the next one starts from what this one found.
            let found = book.cross_seed(|other| *other == name, &options)?;
            if found > 0 {
                write(&book, &path)?;
            }
            better += found;
        }
        report(&book, &format!("round {round}"), better, clock);
        match (better, filling) {
            (0, false) => break,
            (0, true) => filling = false,
            _ => {}
        }
    }
    for entry in &book.entries {
        let Some(o) = &entry.outcome else { continue };
        println!(
            "{:?}: {:?} cost {:.8} speed {:.4} found by {} of {}",
            entry.name, o.status, o.cost, o.motion.speed_m_s, o.found_by, o.tried
        );
    }
    Ok(())
}

fn report(book: &Book, what: &str, better: usize, clock: Instant) {
    let strides = book.entries.iter().filter_map(|e| e.outcome.as_ref());
    let certified = strides.clone().filter(|o| o.is_certified()).count();
    let thrice = strides.filter(|o| o.found_by >= 3).count();
    println!(
        "{what}: {better} better, {certified} of {} certified, {thrice} found by three starts, {:.0?}",
        book.entries.len(),
        clock.elapsed()
    );
}

fn write(book: &Book, path: &str) -> Result<(), Box<dyn Error>> {
    let mut lines = Vec::new();
    for entry in &book.entries {
        let Some(outcome) = entry.outcome.as_ref().filter(|o| o.is_certified()) else {
            continue;
        };
        // Six digits are enough for a start.
        let short = |x: &f64| format!("{x:.5e}").parse::<f64>();
        let x = outcome.x.iter().map(short).collect::<Result<_, _>>()?;
        let name = entry.name;
        let search = Some(Search {
            found: outcome.found_by,
            tried: outcome.tried,
        });
        lines.push(serde_json::to_string(&Row { name, search, x })?);
    }
    let about = serde_json::to_string(ABOUT)?;
    let text = format!(
        "{{\"about\":{about},\n\"starts\":[\n{}\n]}}\n",
        lines.join(",\n")
    );
    let part = format!("{path}.part");
    std::fs::write(&part, text)?;
    Ok(std::fs::rename(part, path)?)
}

/// Strides at the smallest weight from cold starts: the rigid one directly, the compliant one by a chain from a soft
/// and lossless to the stiff and damped ground, each from several guesses.
fn cold() -> Result<Vec<Row>, Box<dyn Error>> {
    let options = Options::default();
    let biped = sample::biped();
    let guesses =
        [(3.0, 0.06), (4.0, 0.06), (5.0, 0.08), (6.0, 0.05)].map(|(speed_m_s, stance_s)| Guess {
            speed_m_s,
            stance_s,
            ..Guess::default()
        });
    let mut rows = Vec::new();
    let soft_to_stiff = [
        Some((2e4, 0.0, 1.0, 0.002)),
        Some((5e4, 0.3, 0.3, 0.005)),
        Some((1e5, 0.6, 0.1, 0.01)),
        None,
    ];
    for name in [
        Name::rigid(Mount::Symmetric, WEIGHTS[0], TARGETS[1]),
        Name::compliant(CONTACT, Mount::Symmetric, WEIGHTS[0], TARGETS[1]),
    ] {
        let last = name.problem(&biped, sample::brush());
        let mut starts: Vec<Option<Start>> = vec![None; guesses.len()];
        let steps: &[_] = if last.is_rigid() {
            &[None]
        } else {
            &soft_to_stiff
        };
        for step in steps {
            let problem = step.map_or(
                last,
                |(stiffness_n_m15, loss_s_m, slip_scale_m_s, weight)| Problem {
                    contact: Contact::Compliant(Ground {
                        stiffness_n_m15,
                        loss_s_m,
                        slip_scale_m_s,
                    }),
                    goal: Goal::Speed {
                        weight,
                        aim_m_s: TARGETS[1],
                    },
                    ..last
                },
            );
            let cases: Vec<Case> = guesses
                .iter()
                .zip(&starts)
                .map(|(guess, start)| Case {
                    problem,
                    starts: vec![
                        start
                            .clone()
                            .unwrap_or_else(|| Start::cold(guess.variables(&problem))),
                    ],
                })
                .collect();
            for (start, outcome) in starts.iter_mut().zip(solve_all(&cases, &options)?) {
                if let Some(o) = &outcome {
                    println!(
                        "cold {:?} {step:?}: {:?} cost {:.6} after {}",
                        name.kind, o.status, o.cost, o.iterations
                    );
                }
                *start = outcome.map(|o| o.start());
            }
        }
        rows.extend(starts.into_iter().flatten().map(|start| Row {
            name,
            search: None,
            x: start.x,
        }));
    }
    Ok(rows)
}

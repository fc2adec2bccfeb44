//! Fills and improves a file of strides: every problem of the chapter on the gait, solved from the strides of others, the nearest first,
//! until three starts have found the best. The problem that may soonest be there has its turn; where the strides of others are used up,
//! hops from problems drawn at random go on, and what no start reaches is walked to. File and list of starts tried (FILE.tried) are
//! written after every problem, so the work can be interrupted and resumed; without a file it begins with chains from cold starts.
//!
//! `cargo run --release -p biped --example explore -- FILE [SECONDS [PARTS [OTHER]]]`; PARTS as in sweep,map; OTHER a file of further
//! starts, as the example cold_sweep writes it, each of which is tried once and counted. Starts are counted by the list: where it lacks a problem
//! its count begins from nothing with the first start.

use biped::contact::Ground;
use biped::gait::book::{Book, Entry, Looked, Source};
use biped::gait::catalogue::{CONTACT, Choice, Kind, Mount, Name, WEIGHTS, all};
use biped::gait::chain::{Case, solve_all};
use biped::gait::file::{NamedStart, Search};
use biped::gait::start::Guess;
use biped::gait::{Contact, Goal, Problem};
use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Instant;
use trajectory::{Options, Start};

#[path = "../tests/sample/mod.rs"]
mod sample;
mod store;

const TARGETS: [f64; 2] = [8.0, 20.0];
/// Steps that a solve may take: 19 of the 21 strides of a cold sweep are reached in fewer, and in the same time many starts find
/// more than long ones.
const STEPS: usize = 40;
/// Quadratic subproblems that a solve may take. They take most of the time, and of the starts that ended at a certificate within them
/// half needed four or fewer; those that lead nowhere ask for one a step or more.
const SUBPROBLEMS: usize = 12;
/// The same for the strides of the file, which may be those of another mesh or of other limits.
const OPENING: (usize, usize) = (200, 80);
/// Starts that should find a stride.
const STARTS: usize = 3;
/// Starts tried at one problem before the next one has its turn.
const AT_ONCE: usize = 1;
/// Farthest strides that are followed ([`Name::distance`]),
const NEAR: f64 = 1.25;
/// and those that hops start from.
const FARTHEST: f64 = 1.2;
/// Hops at one problem before the next one has its turn.
const HOPS: usize = 6;
/// How fast starts get worse with their distance ([`Name::distance`]): of those from another brush a quarter led to a better stride, of those
/// from another brush and another contact one in thirty.
const FADING: f64 = 2.0;
const ABOUT: &str = "Starts of the gait stage, not results: strides of the project's own solver (cargo run --release -p biped --example \
                     explore) and, at first, of CasADi with IPOPT (benches/gait/explore.py), each improved from those of other problems. The \
                     stage solves every problem again from them and certifies what it reports; found and tried count the starts of that search.";

fn main() -> Result<(), Box<dyn Error + Send + Sync>> {
    let path = PathBuf::from(std::env::args().nth(1).ok_or("which file?")?);
    let seconds = std::env::args()
        .nth(2)
        .map_or(Ok(f64::INFINITY), |n| n.parse())?;
    let clock = Instant::now();
    let options = Options {
        max_iterations: STEPS,
        max_subproblems: SUBPROBLEMS,
        ..Options::default()
    };
    let (max_iterations, max_subproblems) = OPENING;
    let opening = Options {
        max_iterations,
        max_subproblems,
        ..options.clone()
    };
    let mut book = open(&path, &opening)?;
    write(&book, &path)?;
    report(&book, "starts", clock);
    let wanted = std::env::args().nth(3);
    let mut order: Vec<usize> = (0..book.entries.len()).collect();
    order.retain(|&place| {
        let part = PARTS[part(&book.entries[place])];
        wanted
            .as_ref()
            .is_none_or(|list| list.split(',').any(|w| w == part))
    });
    order.sort_by_key(|&place| part(&book.entries[place]));
    if let Some(other) = std::env::args().nth(4) {
        offer(&mut book, Path::new(&other), &path, &options, clock)?;
    }
    let mut hopped = vec![0; book.entries.len()];
    let mut walked = Vec::new();
    while clock.elapsed().as_secs_f64() < seconds {
        let (place, looked) = if let Some(place) = next(&book, &order) {
            (place, book.look(place, NEAR, AT_ONCE, &options)?)
        } else if let Some(place) = next_walk(&book, &order, &walked) {
            walked.push(place);
            (place, book.walk(place, &options)?)
        } else {
            let Some(place) = next_hop(&book, &order, &hopped) else {
                break;
            };
            hopped[place] += 1;
            (place, book.hop(place, FARTHEST, HOPS, &options)?)
        };
        write(&book, &path)?;
        say(&book.entries[place], &looked, clock);
    }
    report(&book, "end", clock);
    Ok(())
}

/// The problem that has its turn while strides near one are news to it: the one that may soonest have its stride found by enough starts,
/// weighed by how near its next start is; those that enough have found come last.
fn next(book: &Book, order: &[usize]) -> Option<usize> {
    let turns = order.iter().filter_map(|&place| {
        let left = book.entries[place].starts_left(STARTS);
        let distance = book.nearest(place).filter(|&d| d <= NEAR)?;
        let effort = left.unwrap_or(STARTS as f64) * (FADING * distance).exp();
        Some((left.is_none(), effort, place))
    });
    turns
        .min_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)))
        .map(|(_, _, place)| place)
}

/// The next problem without a stride to which no way from its neighbours was tried in this run.
fn next_walk(book: &Book, order: &[usize], walked: &[usize]) -> Option<usize> {
    let mut places = order.iter().copied();
    places.find(|place| !book.entries[*place].is_certified() && !walked.contains(place))
}

/// The problem that hops have their turn at: of those whose stride is not found by enough starts the one with the fewest turns.
fn next_hop(book: &Book, order: &[usize], hopped: &[usize]) -> Option<usize> {
    let open = order.iter().copied().filter(|&place| {
        book.entries[place].starts_left(STARTS).is_some() && book.can_hop(place, FARTHEST)
    });
    open.min_by_key(|&place| hopped[place])
}

/// Parts of the work in their order: the halved mesh, whose solves take longest, and the holes of the map, which have to be walked to, last.
const PARTS: [&str; 6] = ["sweep", "map", "rigid", "choices", "mesh", "holes"];

/// Place in [`PARTS`].
fn part(entry: &Entry) -> usize {
    let name = &entry.name;
    match (name.kind, name.choice) {
        (Kind::Compliant, Choice::Own) if (name.k, name.c) == CONTACT => 0,
        (Kind::Compliant, Choice::Own) if entry.is_certified() => 1,
        (Kind::Compliant, Choice::Own) => 5,
        (Kind::Compliant, Choice::FineMesh) => 4,
        (Kind::Compliant, _) => 3,
        (Kind::Rigid, _) => 2,
    }
}

/// The book of a file: every problem of the chapter, solved again from the strides in the file.
fn open(path: &Path, options: &Options) -> Result<Book, Box<dyn Error + Send + Sync>> {
    let rows = if path.exists() {
        store::read(path)?
    } else {
        cold()?
    };
    let tried: Vec<(Name, Source)> = match std::fs::read_to_string(tried_path(path)) {
        Ok(text) => serde_json::from_str(&text)?,
        Err(_) => Vec::new(),
    };
    let biped = sample::biped();
    let mut book = Book::default();
    let named = all(TARGETS[0], TARGETS[1]).into_iter().map(|name| {
        let own = rows.iter().filter(|row| row.name == name);
        let starts = own.map(|row| Start::cold(row.x.clone())).collect();
        (name, name.problem(&biped, sample::brush()), starts)
    });
    book.add(named.collect(), options)?;
    for entry in &mut book.entries {
        // A stride of the file, solved again, is no further start: its count and its list go on.
        let row = rows.iter().find(|row| row.name == entry.name);
        if let (Some(outcome), Some(search)) = (&mut entry.outcome, row.and_then(|row| row.search))
        {
            (outcome.found_by, outcome.tried) = (search.found, search.tried);
            (entry.hops, entry.from) = (search.hops, search.from);
            let own = tried.iter().filter(|(name, _)| *name == entry.name);
            entry.tried = own.map(|&(_, source)| source).collect();
        }
    }
    Ok(book)
}

/// Tries every start of another file.
fn offer(
    book: &mut Book,
    other: &Path,
    path: &Path,
    options: &Options,
    clock: Instant,
) -> Result<(), Box<dyn Error + Send + Sync>> {
    for row in store::read(other)? {
        let named = |entry: &Entry| entry.name == row.name;
        let Some(place) = book.entries.iter().position(named) else {
            continue;
        };
        let looked = book.offer(place, Start::cold(row.x), options)?;
        say(&book.entries[place], &looked, clock);
    }
    write(book, path)
}

/// Beside the file: which starts were tried, so that a search that is resumed counts none twice.
fn tried_path(path: &Path) -> PathBuf {
    let mut beside = path.as_os_str().to_owned();
    beside.push(".tried");
    beside.into()
}

fn say(entry: &Entry, looked: &Looked, clock: Instant) {
    let Some(o) = &entry.outcome else { return };
    for end in &looked.ends {
        let (name, from) = end.source;
        println!(
            "  {} k {} c {} {} Q_v {} aim {} (cost {from:.6}): {:?} after {} steps and {} subproblems, {:+.2e} of the best, {:.1e} apart",
            name.choice.id(),
            name.k,
            name.c,
            name.brush.id(),
            name.weight,
            name.aim,
            end.status,
            end.iterations,
            end.subproblems,
            end.cost / o.cost - 1.0,
            end.apart.unwrap_or(f64::NAN),
        );
    }
    println!(
        "{:?}: {} tried{}; {:?} cost {:.8} speed {:.4} found by {} of {}, {:.0?}",
        entry.name,
        looked.ends.len(),
        if looked.better { ", better" } else { "" },
        o.status,
        o.cost,
        o.motion.speed_m_s,
        o.found_by,
        o.tried,
        clock.elapsed()
    );
}

fn report(book: &Book, what: &str, clock: Instant) {
    let certified = book.entries.iter().filter(|e| e.is_certified()).count();
    let strides = book.entries.iter().filter_map(|e| e.outcome.as_ref());
    let found = strides.filter(|o| o.is_certified() && o.found_by >= STARTS);
    println!(
        "{what}; {certified} of {} certified, {} found by {STARTS} starts, {:.0?}",
        book.entries.len(),
        found.count(),
        clock.elapsed()
    );
}

fn write(book: &Book, path: &Path) -> Result<(), Box<dyn Error + Send + Sync>> {
    let mut rows = Vec::new();
    for entry in book.entries.iter().filter(|e| e.is_certified()) {
        let Some(outcome) = &entry.outcome else {
            continue;
        };
        let search = Some(Search {
            found: outcome.found_by,
            tried: outcome.tried,
            hops: entry.hops,
            from: entry.from,
        });
        rows.push(store::row(entry.name, search, &outcome.x)?);
    }
    store::write(path, ABOUT, rows)?;
    let tried: Vec<(Name, Source)> = book
        .entries
        .iter()
        .flat_map(|entry| entry.tried.iter().map(|&source| (entry.name, source)))
        .collect();
    store::replace(&tried_path(path), &serde_json::to_string(&tried)?)
}

/// Strides at the smallest weight from cold starts: the rigid one directly, the compliant one by a chain from a soft
/// and lossless to the stiff and damped ground, each from several guesses.
fn cold() -> Result<Vec<NamedStart>, Box<dyn Error + Send + Sync>> {
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
        rows.extend(starts.into_iter().flatten().map(|start| NamedStart {
            name,
            search: None,
            x: start.x,
        }));
    }
    Ok(rows)
}

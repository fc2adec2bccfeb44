//! The sweep of Fig. 12 from nothing: one guess, walked to the compliant contact, then every brush along the weights, and what
//! stays open once more from its neighbours. Prints every solve, how many of the 21 strides are certified, and the time.
//!
//! `cargo run --release -p biped --example cold_sweep -- [FILE [OUT]]`; FILE as data/strides.json, to compare costs with; OUT gets the
//! strides, for the example `explore` to go on from. Two threads: `RAYON_NUM_THREADS=2`.

use biped::gait::catalogue::{CONTACT, Mount, Name, WEIGHTS};
use biped::gait::chain::{Case, Outcome, solve_all};
use biped::gait::cold::walk;
use biped::gait::programme::Stride;
use biped::gait::start::Guess;
use std::error::Error;
use std::path::Path;
use std::sync::Mutex;
use std::time::Instant;
use trajectory::{Options, Start, solve};

#[path = "../tests/sample/mod.rs"]
mod sample;
mod store;

const ABOUT: &str =
    "Strides of one cold sweep (cargo run --release -p biped --example cold_sweep).";

const AIM_M_S: f64 = 20.0;
/// Steps that a solve from a neighbour may take.
const STEPS: usize = 80;
/// Guesses of the first stride: speed, m/s, and stance, s; the next one where a walk does not arrive.
const GUESSES: [(f64, f64); 4] = [(4.0, 0.06), (3.0, 0.06), (5.0, 0.08), (6.0, 0.05)];

type Found = (Name, Option<Outcome>);
type Failure = Box<dyn Error + Send + Sync>;

fn main() -> Result<(), Failure> {
    let clock = Instant::now();
    let first = first()?.ok_or("no guess led to a stride")?;
    println!("first stride after {:.1?}", clock.elapsed());
    let mut found: Vec<Found> = sweeps(&first)?
        .into_iter()
        .flat_map(|chain| chain.found)
        .collect();
    println!(
        "sweep after {:.1?}: {} certified",
        clock.elapsed(),
        certified(&found)
    );
    fill(&mut found)?;
    let seconds = clock.elapsed();
    if let Some(path) = std::env::args().nth(1) {
        compare(&found, Path::new(&path))?;
    }
    if let Some(out) = std::env::args().nth(2) {
        let certified = found
            .iter()
            .filter_map(|(name, stride)| Some((name, stride.as_ref()?)));
        let rows: Vec<_> = certified
            .map(|(name, stride)| store::row(*name, None, &stride.x))
            .collect::<Result<_, _>>()?;
        store::write(Path::new(&out), ABOUT, rows)?;
    }
    println!(
        "{} of {} certified in {seconds:.1?} on {} threads",
        certified(&found),
        found.len(),
        rayon::current_num_threads()
    );
    Ok(())
}

fn certified(found: &[Found]) -> usize {
    found.iter().filter(|(_, stride)| stride.is_some()).count()
}

fn first() -> Result<Option<Outcome>, trajectory::ProgrammeError> {
    let name = Name::compliant(CONTACT, Mount::Symmetric, WEIGHTS[0], AIM_M_S);
    for (speed_m_s, stance_s) in GUESSES {
        let guess = Guess {
            speed_m_s,
            stance_s,
            ..Guess::default()
        };
        let walk = walk(&name.problem(&sample::biped(), sample::brush()), &guess)?;
        for tread in &walk.treads {
            println!(
                "{speed_m_s} m/s, {stance_s} s: part {:.4} on {}/{}: {:?} cost {:.6} after {} steps",
                tread.part,
                tread.mesh.stance,
                tread.mesh.flight,
                tread.status,
                tread.cost,
                tread.iterations
            );
        }
        if walk.stride.is_some() {
            return Ok(walk.stride);
        }
    }
    Ok(None)
}

/// One brush along the weights, each stride from the last one that was certified.
struct Chain {
    brush: Mount,
    last: Outcome,
    found: Vec<Found>,
    /// A thread is at work on it.
    taken: bool,
}

/// All brushes along the weights. Three chains on two threads, each on one from end to end, would leave one thread idle while the other does
/// the third; so a thread that has solved one weight goes on with the chain that has the most weights left. What is solved from what
/// does not depend on this.
fn sweeps(first: &Outcome) -> Result<Vec<Chain>, Failure> {
    let chain = |brush| Chain {
        brush,
        last: first.clone(),
        found: Vec::new(),
        taken: false,
    };
    let chains = Mutex::new(Mount::ALL.map(chain));
    rayon::broadcast(|_| work(&chains))
        .into_iter()
        .collect::<Result<Vec<()>, Failure>>()?;
    let chains = chains.into_inner().map_err(|_| "a thread broke off")?;
    Ok(chains.into())
}

/// Solves weights until no chain is left that waits for a thread.
fn work(chains: &Mutex<[Chain; 3]>) -> Result<(), Failure> {
    let lock = || chains.lock().map_err(|_| "a thread broke off");
    loop {
        let (place, name, start) = {
            let mut chains = lock()?;
            let open = |chain: &Chain| !chain.taken && chain.found.len() < WEIGHTS.len();
            let waiting = (0..chains.len()).filter(|&k| open(&chains[k]));
            let Some(place) = waiting.min_by_key(|&k| chains[k].found.len()) else {
                return Ok(());
            };
            let chain = &mut chains[place];
            chain.taken = true;
            let weight = WEIGHTS[chain.found.len()];
            let name = Name::compliant(CONTACT, chain.brush, weight, AIM_M_S);
            (place, name, chain.last.start())
        };
        let stride = from(&name, start)?;
        let chain = &mut lock()?[place];
        if let Some(stride) = &stride {
            chain.last = stride.clone();
        }
        chain.found.push((name, stride));
        chain.taken = false;
    }
}

/// Solves a problem from one start; the stride if it is certified.
fn from(name: &Name, start: Start) -> Result<Option<Outcome>, trajectory::ProgrammeError> {
    let options = Options {
        max_iterations: STEPS,
        ..Options::default()
    };
    let clock = Instant::now();
    let case = Case {
        problem: name.problem(&sample::biped(), sample::brush()),
        starts: vec![start],
    };
    let found = solve_all(&[case], &options)?.pop().flatten();
    if let Some(o) = &found {
        println!(
            "{} {}: {:?} cost {:.8} speed {:.4} after {} steps and {} subproblems, {:.1?}",
            name.brush.id(),
            name.weight,
            o.status,
            o.cost,
            o.motion.speed_m_s,
            o.iterations,
            o.subproblems,
            clock.elapsed()
        );
    }
    Ok(found.filter(Outcome::is_certified))
}

/// What stayed open, from its certified neighbours one after the other.
fn fill(found: &mut [Found]) -> Result<(), trajectory::ProgrammeError> {
    for place in 0..found.len() {
        let name = found[place].0;
        if found[place].1.is_some() {
            continue;
        }
        let near: Vec<Start> = found
            .iter()
            .filter(|(other, _)| other.is_beside(&name))
            .filter_map(|(_, stride)| Some(stride.as_ref()?.start()))
            .collect();
        for start in near {
            if let Some(stride) = from(&name, start)? {
                found[place].1 = Some(stride);
                break;
            }
        }
    }
    Ok(())
}

/// Costs beside those of the strides in a file, which many starts have improved.
fn compare(found: &[Found], path: &Path) -> Result<(), Box<dyn Error + Send + Sync>> {
    let starts = store::read(path)?;
    for (name, stride) in found {
        let row = starts.iter().find(|row| row.name == *name);
        let (Some(stride), Some(row)) = (stride, row) else {
            continue;
        };
        let problem = name.problem(&sample::biped(), sample::brush());
        let best = solve(
            &Stride::new(problem),
            &Start::cold(row.x.clone()),
            &Options::default(),
        )?;
        println!(
            "{} {}: cost {:.8}, {:+.1e} of that in the file ({:?}), speed {:+.2} m/s",
            name.brush.id(),
            name.weight,
            stride.cost,
            stride.cost / best.cost - 1.0,
            best.status,
            stride.motion.speed_m_s - best.x[biped::gait::layout::Layout::new(&problem).speed()]
        );
    }
    Ok(())
}

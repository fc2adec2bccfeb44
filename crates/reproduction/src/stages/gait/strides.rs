//! The strides of the stage: which problems are solved, and from where.

use biped::contact::Brush;
use biped::gait::Problem;
use biped::gait::catalogue::{Kind, Mount, Name};
use biped::gait::chain::{Case, Outcome, solve_all};
use biped::gait::file::{Search, StridesFile};
use biped::parameters::Biped;
use trajectory::{Options, Start as Point};

use crate::stage::StageError;

/// Steps that a solve may take from a start that is already near.
const MAX_ITERATIONS: usize = 30;

/// A solved stride with the name of its problem.
#[derive(Clone, Debug)]
pub(super) struct Solved {
    pub(super) name: Name,
    /// Of the search for its start, where it kept a count.
    pub(super) search: Option<Search>,
    pub(super) outcome: Outcome,
}

/// The shipped starts.
const STARTS: &str = include_str!("../../../../../data/strides.json");

const ACCELERATING: &str = include_str!("../../../../../data/accelerating.json");

fn options() -> Options {
    Options {
        max_iterations: MAX_ITERATIONS,
        ..Options::default()
    }
}

/// Solves every problem of the file that `wanted` takes, each from its start.
pub(super) fn solve(
    biped: &Biped,
    brush: Brush,
    wanted: impl Fn(&Name) -> bool,
) -> Result<Vec<Solved>, StageError> {
    let problem = |name: &Name| wanted(name).then(|| name.problem(biped, brush));
    of_file("data/strides.json", STARTS, problem)
}

/// Solves the problems that a file's names stand for, each from its start; none where `problem` has none.
fn of_file(
    path: &str,
    text: &str,
    problem: impl Fn(&Name) -> Option<Problem>,
) -> Result<Vec<Solved>, StageError> {
    let file: StridesFile = serde_json::from_str(text)
        .map_err(|error| StageError::Failed(format!("{path}: {error}")))?;
    let (names, cases): (Vec<(Name, Option<Search>)>, Vec<Case>) = file
        .starts
        .into_iter()
        .filter_map(|start| {
            let case = Case {
                problem: problem(&start.name)?,
                starts: vec![Point::cold(start.x)],
            };
            Some(((start.name, start.search), case))
        })
        .unzip();
    let outcomes =
        solve_all(&cases, &options()).map_err(|error| StageError::Failed(error.to_string()))?;
    Ok(names
        .into_iter()
        .zip(outcomes)
        .filter_map(|((name, search), outcome)| {
            Some(Solved {
                name,
                search,
                outcome: outcome?,
            })
        })
        .collect())
}

/// Accelerating strides, periodic but for the forward speed, each from its shipped start.
pub(super) fn accelerate(
    biped: &Biped,
    brush: Brush,
    start_m_s: f64,
) -> Result<Vec<Solved>, StageError> {
    let problem = |name: &Name| Some(name.problem(biped, brush).accelerating(start_m_s));
    of_file("data/accelerating.json", ACCELERATING, problem)
}

/// The name of a stride of a sweep on one kind of contact.
pub(super) fn of_sweep(kind: Kind, mount: Mount, weight: f64, aim_m_s: f64) -> Name {
    match kind {
        Kind::Rigid => Name::rigid(mount, weight, aim_m_s),
        Kind::Compliant => Name::compliant(biped::gait::catalogue::CONTACT, mount, weight, aim_m_s),
    }
}

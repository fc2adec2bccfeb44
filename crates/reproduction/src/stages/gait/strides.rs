//! The strides of the stage: which problems are solved, and from where.

use biped::contact::Brush;
use biped::gait::catalogue::{Kind, Mount, Name};
use biped::gait::chain::{Case, Outcome, solve_all};
use biped::gait::file::{Search, StridesFile};
use biped::gait::layout::Layout;
use biped::gait::{Goal, Problem};
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
    let file: StridesFile = serde_json::from_str(STARTS)
        .map_err(|error| StageError::Failed(format!("data/strides.json: {error}")))?;
    let (names, cases): (Vec<(Name, Option<Search>)>, Vec<Case>) = file
        .starts
        .into_iter()
        .filter(|start| wanted(&start.name))
        .map(|start| {
            let case = Case {
                problem: start.name.problem(biped, brush),
                starts: vec![Point::cold(start.x)],
            };
            ((start.name, start.search), case)
        })
        .unzip();
    named(names, &cases, &options())
}

fn named(
    names: Vec<(Name, Option<Search>)>,
    cases: &[Case],
    options: &Options,
) -> Result<Vec<Solved>, StageError> {
    let outcomes =
        solve_all(cases, options).map_err(|error| StageError::Failed(error.to_string()))?;
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

/// Accelerating strides: periodic but for the forward speed, each from the periodic strides of all brushes.
pub(super) fn accelerate(periodic: &[&Solved], start_m_s: f64) -> Result<Vec<Solved>, StageError> {
    let cases: Vec<Case> = periodic
        .iter()
        .map(|solved| {
            let goal = Goal::Acceleration {
                weight: 1.0,
                start_m_s,
            };
            let problem = Problem {
                goal,
                ..solved.outcome.problem
            };
            let count = Layout::new(&problem).count();
            let starts = periodic.iter().map(|other| {
                let mut x = other.outcome.x.clone();
                x.resize(count, 0.0);
                Point::cold(x)
            });
            Case {
                problem,
                starts: starts.collect(),
            }
        })
        .collect();
    let options = Options {
        max_iterations: 2 * MAX_ITERATIONS,
        ..options()
    };
    let names = periodic.iter().map(|solved| (solved.name, None)).collect();
    named(names, &cases, &options)
}

/// The name of a stride of a sweep on one kind of contact.
pub(super) fn of_sweep(kind: Kind, mount: Mount, weight: f64, aim_m_s: f64) -> Name {
    match kind {
        Kind::Rigid => Name::rigid(mount, weight, aim_m_s),
        Kind::Compliant => Name::compliant(biped::gait::catalogue::CONTACT, mount, weight, aim_m_s),
    }
}

//! Solving many strides: from given starts, each result certified or named.
//!
//! Local minima dominate this problem: a single cold start is worthless. So every case is solved from
//! several starts (its own, and the solutions of its neighbours), the cheapest certified stride
//! is kept, and how many starts found it is counted.

use super::Problem;
use super::motion::Motion;
use super::programme::Stride;
use rayon::prelude::*;
use trajectory::{Options, ProgrammeError, Solution, Start, Status, solve};

/// A case and the points to start it from.
#[derive(Clone, Debug)]
pub struct Case {
    /// The problem.
    pub problem: Problem,
    /// Starts, each a full vector of variables.
    pub starts: Vec<Vec<f64>>,
}

/// The best stride found for a case.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The problem.
    pub problem: Problem,
    /// How the best start ended; only [`Status::Solved`] is a stride to rely on.
    pub status: Status,
    /// Cost.
    pub cost: f64,
    /// Variables.
    pub x: Vec<f64>,
    /// The stride read from them.
    pub motion: Motion,
    /// Starts that ended in this minimum (cost within 1e-6 relative).
    pub found_by: usize,
    /// Starts tried.
    pub tried: usize,
    /// Steps taken over all starts.
    pub iterations: usize,
    /// Quadratic subproblems solved over all starts.
    pub subproblems: usize,
}

impl Outcome {
    /// Whether the certificate holds.
    pub fn is_certified(&self) -> bool {
        self.status.is_solved()
    }
}

/// Relative difference of costs below which two strides are one minimum.
const SAME_MINIMUM: f64 = 1e-6;

/// Solves every case from every one of its starts. Cases and starts run in parallel, results are
/// folded in their given order, so the bits do not depend on the number of threads.
///
/// # Errors
/// A start of the wrong length, or a problem that contradicts itself.
pub fn solve_all(cases: &[Case], options: &Options) -> Result<Vec<Outcome>, ProgrammeError> {
    let tasks: Vec<(usize, &Vec<f64>)> = cases
        .iter()
        .enumerate()
        .flat_map(|(index, case)| case.starts.iter().map(move |start| (index, start)))
        .collect();
    let solutions: Vec<(usize, Solution)> = tasks
        .par_iter()
        .map(|(index, start)| {
            let stride = Stride::new(cases[*index].problem);
            Ok((
                *index,
                solve(&stride, &Start::cold((*start).clone()), options)?,
            ))
        })
        .collect::<Result<_, ProgrammeError>>()?;
    Ok(cases
        .iter()
        .enumerate()
        .filter_map(|(index, case)| {
            let own: Vec<&Solution> = solutions
                .iter()
                .filter(|(i, _)| *i == index)
                .map(|(_, s)| s)
                .collect();
            best(case, &own)
        })
        .collect())
}

/// The cheapest certified solution, or the one nearest to being one.
fn best(case: &Case, solutions: &[&Solution]) -> Option<Outcome> {
    let rank = |s: &Solution| (usize::from(!s.status.is_solved()), s.cost);
    let winner = solutions.iter().copied().min_by(|a, b| {
        let ((a_open, a_cost), (b_open, b_cost)) = (rank(a), rank(b));
        a_open.cmp(&b_open).then(a_cost.total_cmp(&b_cost))
    })?;
    let same = |s: &&&Solution| {
        s.status == winner.status
            && (s.cost - winner.cost).abs() <= SAME_MINIMUM * winner.cost.abs()
    };
    Some(Outcome {
        problem: case.problem,
        status: winner.status,
        cost: winner.cost,
        x: winner.x.clone(),
        motion: Motion::new(&case.problem, &winner.x),
        found_by: solutions.iter().filter(same).count(),
        tried: solutions.len(),
        iterations: solutions.iter().map(|s| s.counters.iterations).sum(),
        subproblems: solutions.iter().map(|s| s.counters.subproblems).sum(),
    })
}

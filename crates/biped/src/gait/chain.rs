//! Solving many strides: from given starts and from each other, each result certified or named.
//!
//! Local minima dominate this problem: a single start is worthless. So every case is solved from
//! several starts (its own, and the strides of its neighbours), the cheapest certified stride
//! is kept, with what its mesh gives away priced in ([`Outcome::priced`]), and how many starts found it is counted. Two strides are
//! one minimum when their variables are close; equal costs prove nothing.

use super::Problem;
use super::motion::Motion;
use super::programme::Stride;
use rayon::prelude::*;
use trajectory::{
    Multipliers, Options, ProgrammeError, Solution, Start, Status, scaled_distance, solve,
};

/// A case and the points to start it from.
#[derive(Clone, Debug)]
pub struct Case {
    /// The problem.
    pub problem: Problem,
    /// Starts, each with a full vector of variables.
    pub starts: Vec<Start>,
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
    /// Multipliers: they tell a neighbour which limits hold.
    pub multipliers: Multipliers,
    /// The stride read from them.
    pub motion: Motion,
    /// Starts that ended in this minimum.
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

    /// This stride as a start for a neighbour.
    pub fn start(&self) -> Start {
        Start {
            x: self.x.clone(),
            multipliers: Some(self.multipliers.clone()),
        }
    }

    fn new(problem: &Problem, solution: &Solution) -> Self {
        Self {
            problem: *problem,
            status: solution.status,
            cost: solution.cost,
            x: solution.x.clone(),
            multipliers: solution.multipliers.clone(),
            motion: Motion::new(problem, &solution.x),
            found_by: 1,
            tried: 1,
            iterations: solution.counters.iterations,
            subproblems: solution.counters.subproblems,
        }
    }

    /// Cost with what the mesh gives away priced in: cost (1 + 5 gap), with the share of its energy that the stride misses
    /// ([`Motion::energy_gap`]). Among many minima a search by cost alone finds those that profit from the error of the mesh.
    pub fn priced(&self) -> f64 {
        self.cost * (1.0 + MESH_PRICE * self.motion.energy_gap(&self.problem))
    }

    /// The better of two outcomes of one problem, with the starts and the work of both. A certified stride is
    /// better than any other, then the cheaper one is ([`Self::priced`]).
    #[must_use]
    pub fn merged(self, other: Self) -> Self {
        let stride = Stride::new(self.problem);
        let same = self.status == other.status
            && scaled_distance(&stride, &self.x, &other.x) <= SAME_MINIMUM;
        let (tried, found) = (self.tried + other.tried, self.found_by + other.found_by);
        let iterations = self.iterations + other.iterations;
        let subproblems = self.subproblems + other.subproblems;
        let rank = |o: &Self| (usize::from(!o.is_certified()), o.priced());
        let ((a_open, a_cost), (b_open, b_cost)) = (rank(&self), rank(&other));
        let first = a_open.cmp(&b_open).then(a_cost.total_cmp(&b_cost)).is_le();
        // Of two finds of one minimum the earlier stays, so that a last digit does not count as progress.
        let best = if same || first { self } else { other };
        Self {
            found_by: if same { found } else { best.found_by },
            tried,
            iterations,
            subproblems,
            ..best
        }
    }
}

/// Distance of two strides, in scales of the variables, within which they are one minimum.
const SAME_MINIMUM: f64 = 1e-3;

/// Share of the cost that a stride pays for the share of its energy that it misses. Of 14 pairs of strides of one problem, the cheaper one of which
/// missed more (0.2 to 0.9 %), both followed to the halved mesh, this orders twelve as their costs do there (so does any price from 3 to 8); cost alone
/// orders eight so.
const MESH_PRICE: f64 = 5.0;

/// Solves every case from every one of its starts; `None` for a case without starts. Cases and starts run in
/// parallel, results are folded in their given order, so the bits do not depend on the number of threads.
///
/// # Errors
/// A start of the wrong length, or a problem that contradicts itself.
pub fn solve_all(
    cases: &[Case],
    options: &Options,
) -> Result<Vec<Option<Outcome>>, ProgrammeError> {
    let tasks: Vec<(usize, &Start)> = cases
        .iter()
        .enumerate()
        .flat_map(|(index, case)| case.starts.iter().map(move |start| (index, start)))
        .collect();
    let outcomes: Vec<(usize, Outcome)> = tasks
        .par_iter()
        .map(|(index, start)| {
            let problem = cases[*index].problem;
            let solution = solve(&Stride::new(problem), start, options)?;
            Ok((*index, Outcome::new(&problem, &solution)))
        })
        .collect::<Result<_, ProgrammeError>>()?;
    let mut best: Vec<Option<Outcome>> = vec![None; cases.len()];
    for (index, outcome) in outcomes {
        best[index] = Some(match best[index].take() {
            Some(before) => before.merged(outcome),
            None => outcome,
        });
    }
    Ok(best)
}

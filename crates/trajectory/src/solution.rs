//! What a solve returns.

use crate::{Certificate, Multipliers, Status};

/// Where a solve starts: a point and, if known, multipliers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Start {
    /// The point, in the variables' own units.
    pub x: Vec<f64>,
    /// Multipliers of a neighbouring problem; their signs tell its active set.
    pub multipliers: Option<Multipliers>,
}

impl Start {
    /// A point without further knowledge.
    pub fn cold(x: Vec<f64>) -> Self {
        Self {
            x,
            multipliers: None,
        }
    }

    /// The solution of a neighbouring problem.
    pub fn warm(neighbour: &Solution) -> Self {
        Self {
            x: neighbour.x.clone(),
            multipliers: Some(neighbour.multipliers.clone()),
        }
    }
}

/// Integer work counters: equal on every machine of one target.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Accepted steps.
    pub iterations: usize,
    /// Quadratic subproblems given to Clarabel, corrections and elastic ones included.
    pub subproblems: usize,
    /// Elastic subproblems among them.
    pub elastic: usize,
    /// Second-order corrections tried.
    pub corrections: usize,
    /// Second-order corrections accepted.
    pub corrections_accepted: usize,
    /// Newton steps accepted on an identified active set, polish included.
    pub newton_steps: usize,
    /// Evaluations of cost and rows alone.
    pub value_evaluations: usize,
    /// Evaluations with first derivatives.
    pub derivative_evaluations: usize,
    /// Evaluations of the Hessian of the Lagrangian.
    pub hessian_evaluations: usize,
    /// Interior-point iterations over all subproblems.
    pub interior_iterations: usize,
    /// Factorisations of the Newton system.
    pub factorisations: usize,
}

/// Which step an iteration took.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StepKind {
    /// The step of the convex subproblem.
    Subproblem,
    /// Newton's step on the active set.
    Newton,
    /// The step of the elastic subproblem.
    Elastic,
    /// A step with second-order correction.
    Corrected,
}

/// One iteration, for tables and figures. All numbers are scaled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Iteration {
    /// Cost.
    pub cost: f64,
    /// Sum of missed rows.
    pub violation: f64,
    /// Optimality error.
    pub optimality: f64,
    /// Step length.
    pub alpha: f64,
    /// Largest entry of the full step.
    pub step: f64,
    /// Penalty of the merit function.
    pub penalty: f64,
    /// Which step it was.
    pub kind: StepKind,
    /// Smallest eigenvalue of any Hessian group, where a convex Hessian was made.
    pub smallest_eigenvalue: f64,
    /// Eigenvalues that were changed to make it convex.
    pub changed_eigenvalues: usize,
}

/// The answer to a programme.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// How the solve ended; only `Status::Solved` is a solution.
    pub status: Status,
    /// The point, in the variables' own units.
    pub x: Vec<f64>,
    /// The cost, in its own unit.
    pub cost: f64,
    /// Multipliers of rows and bounds, in their own units.
    pub multipliers: Multipliers,
    /// What is known about the point.
    pub certificate: Certificate,
    /// Work done.
    pub counters: Counters,
    /// One record per iteration, if asked for.
    pub history: Vec<Iteration>,
}

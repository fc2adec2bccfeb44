//! What a caller may choose about a solve.

use crate::HessianModel;

/// Tolerances, limits and ingredients of a solve. All tolerances are scaled.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Largest number of iterations.
    pub max_iterations: usize,
    /// Largest number of quadratic subproblems. They take nearly all of the time, and a solve that asks for many of them is
    /// mostly one that leads nowhere.
    pub max_subproblems: usize,
    /// Optimality error at which the polish takes over.
    pub optimality: f64,
    /// Largest missed row at which the polish takes over.
    pub feasibility: f64,
    /// Optimality error and violation that a certified point may have.
    pub certified: f64,
    /// How the Hessian of the subproblem is made.
    pub hessian: HessianModel,
    /// Weight ρ of the squares of a group's own equality rows (see `convexify`).
    pub row_weight: f64,
    /// Smallest eigenvalue of a convexified group.
    pub curvature_floor: f64,
    /// Newton steps on the active set that the last subproblem found.
    pub newton_steps: bool,
    /// Second-order correction of a rejected full step.
    pub second_order_correction: bool,
    /// How many past points the merit function may be compared with; 0 asks every step to descend.
    pub memory: usize,
    /// Largest penalty of the elastic subproblem.
    pub max_penalty: f64,
    /// Keep a record of every iteration.
    pub history: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            max_iterations: 300,
            max_subproblems: usize::MAX,
            optimality: 1e-4,
            feasibility: 1e-6,
            certified: 1e-9,
            hessian: HessianModel::ExactClip,
            row_weight: 10.0,
            curvature_floor: 1e-7,
            newton_steps: true,
            second_order_correction: true,
            memory: 2,
            max_penalty: 1e8,
            history: false,
        }
    }
}

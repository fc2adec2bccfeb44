//! The force envelope by linear programming: max w . F over torques within limits and friction.
//!
//! Over the torques alone: maximise w . (F0 + B tau) with |tau| <= tau_max and, both sides of the
//! cone, F_x - mu_forward F_y <= 0 and -F_x - mu_reverse F_y <= 0. Solved by Clarabel with one
//! thread and its own factorisation, so that the bits do not depend on the machine's threads.

use super::{EnvelopeError, ForceMap};
use crate::contact::Brush;
use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettings, DefaultSettingsBuilder, DefaultSolver, IPSolver, NonnegativeConeT,
    SolverStatus,
};
use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

/// A limit that the optimum touches.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Binding {
    /// Torque limit of a joint: 0 hip, 1 knee of the loaded leg; 2, 3 those of the other.
    Torque {
        /// Index of the joint.
        joint: usize,
        /// True at the upper limit.
        upper: bool,
    },
    /// The forward edge of the friction cone.
    FrictionForward,
    /// The reverse edge of the friction cone.
    FrictionReverse,
}

/// Optimum of one linear programme.
#[derive(Clone, Debug, PartialEq)]
pub struct Optimum {
    /// Force, N.
    pub force_n: Vector2<f64>,
    /// Torques that hold it, N m.
    pub torques_n_m: Vec<f64>,
    /// Limits with a positive multiplier: what would have to give for more force.
    pub binding: Vec<Binding>,
}

/// Largest w . F over the cut envelope.
///
/// **Units**: direction w without unit; force in N. **Accuracy**: 1e-9 relative and better at the
/// tolerance of 1e-12 set here.
///
/// # Errors
/// [`EnvelopeError::Programme`] with Clarabel's status if it did not end solved.
pub fn largest(
    map: &ForceMap,
    brush: Brush,
    direction: Vector2<f64>,
) -> Result<Optimum, EnvelopeError> {
    let n = map.limits_n_m.len();
    // Torques in units of their limits, forces in units of the map's largest entry: O(1) numbers.
    let b = |i: usize, j: usize| map.per_torque[(i, j)] * map.limits_n_m[j];
    let scale = (0..n)
        .flat_map(|j| [b(0, j).abs(), b(1, j).abs()])
        .fold(1.0, f64::max);
    let cone = [
        (Vector2::new(1.0, -brush.forward), Binding::FrictionForward),
        (Vector2::new(-1.0, -brush.reverse), Binding::FrictionReverse),
    ];
    let mut rows: Vec<Vec<f64>> = Vec::new();
    let mut right = Vec::new();
    let mut names = Vec::new();
    for j in 0..n {
        for upper in [true, false] {
            let mut row = vec![0.0; n];
            row[j] = if upper { 1.0 } else { -1.0 };
            rows.push(row);
            right.push(1.0);
            names.push(Binding::Torque { joint: j, upper });
        }
    }
    for (normal, name) in cone {
        rows.push(
            (0..n)
                .map(|j| (normal[0] * b(0, j) + normal[1] * b(1, j)) / scale)
                .collect(),
        );
        right.push(-normal.dot(&map.offset_n) / scale);
        names.push(name);
    }
    let cost: Vec<f64> = (0..n)
        .map(|j| -(direction[0] * b(0, j) + direction[1] * b(1, j)) / scale)
        .collect();

    let cones = [NonnegativeConeT(rows.len())];
    let constraints = CscMatrix::from(&rows);
    let zero = CscMatrix::zeros((n, n));
    let mut solver = DefaultSolver::new(&zero, &cost, &constraints, &right, &cones, settings())
        .map_err(|error| EnvelopeError::Programme(error.to_string()))?;
    solver.solve();
    if solver.solution.status != SolverStatus::Solved {
        return Err(EnvelopeError::Programme(format!(
            "{:?}",
            solver.solution.status
        )));
    }
    let torques_n_m: Vec<f64> = solver
        .solution
        .x
        .iter()
        .zip(&map.limits_n_m)
        .map(|(x, limit)| x * limit)
        .collect();
    let binding = names
        .into_iter()
        .zip(&solver.solution.z)
        .filter(|(_, multiplier)| **multiplier > 1e-6)
        .map(|(name, _)| name)
        .collect();
    Ok(Optimum {
        force_n: map.force_n(&torques_n_m),
        torques_n_m,
        binding,
    })
}

/// Tight tolerances, one thread, no output.
fn settings() -> DefaultSettings<f64> {
    DefaultSettingsBuilder::default()
        .verbose(false)
        .max_threads(1)
        .direct_solve_method("qdldl".to_owned())
        .presolve_enable(false)
        .tol_gap_abs(1e-12)
        .tol_gap_rel(1e-12)
        .tol_feas(1e-12)
        .build()
        .unwrap_or_default()
}

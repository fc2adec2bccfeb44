//! An optimal control problem in phases, as the user states it.
//!
//! ```text
//! minimise    Σ_phases ∫₀^T ℓ(q, v, a, s, u) dt + Σ_linkages m(ends)
//! subject to  r(q, v, a, s, ṡ, u) in limits       at every collocation point
//!             q̇ = v, v̇ = a, ṡ = rate              by collocation
//!             link(ends, durations, parameters) in limits
//! ```

use crate::{Row, Scalar, Variable};

/// A coordinate with a second-order equation of motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Coordinate {
    /// Position: bounds and scale.
    pub position: Variable,
    /// Velocity: bounds and scale.
    pub velocity: Variable,
    /// Acceleration: bounds and scale.
    pub acceleration: Variable,
}

/// A quantity with a first-order equation, `ṡ = rate`.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// The state: bounds and scale.
    pub value: Variable,
    /// Its rate: bounds and scale.
    pub rate: Variable,
}

/// One phase: its variables, mesh and the rows that hold at every point.
#[derive(Clone, Debug, PartialEq)]
pub struct Phase {
    /// Name used in messages.
    pub name: String,
    /// Coordinates of second order.
    pub coordinates: Vec<Coordinate>,
    /// States of first order.
    pub states: Vec<State>,
    /// Controls and other algebraic variables, contact forces among them.
    pub controls: Vec<Variable>,
    /// Duration in s; equal bounds fix it.
    pub duration: Variable,
    /// Number of equal intervals.
    pub intervals: usize,
    /// Rows at every collocation point: equations of motion and path limits.
    pub rows: Vec<Row>,
}

/// The variables of one collocation point.
#[derive(Clone, Copy, Debug)]
pub struct Point<'a, D> {
    /// Positions.
    pub q: &'a [D],
    /// Velocities.
    pub v: &'a [D],
    /// Accelerations.
    pub a: &'a [D],
    /// First-order states.
    pub s: &'a [D],
    /// Their rates.
    pub rate: &'a [D],
    /// Controls.
    pub u: &'a [D],
    /// Parameters of the problem.
    pub p: &'a [D],
}

/// What a collocation point contributes.
#[derive(Debug)]
pub struct PointRows<'a, D> {
    /// Running cost ℓ, per second.
    pub cost: &'a mut D,
    /// The phase's rows.
    pub rows: &'a mut [D],
}

/// An end of a phase.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// At time 0 of the phase.
    Start(usize),
    /// At the end of the phase.
    Finish(usize),
}

/// Position, velocity and states at an end of a phase, with its duration.
#[derive(Clone, Copy, Debug)]
pub struct EndPoint<'a, D> {
    /// Positions.
    pub q: &'a [D],
    /// Velocities.
    pub v: &'a [D],
    /// First-order states.
    pub s: &'a [D],
    /// Duration of the phase in s.
    pub duration: D,
}

/// A relation between ends of phases: boundary values, impacts, periodicity.
#[derive(Clone, Debug, PartialEq)]
pub struct Linkage {
    /// Name used in messages.
    pub name: String,
    /// The ends it relates.
    pub ends: Vec<End>,
    /// Its rows.
    pub rows: Vec<Row>,
}

/// An optimal control problem.
pub trait OptimalControl: Sync {
    /// The phases.
    fn phases(&self) -> Vec<Phase>;

    /// Parameters that all points and linkages may use.
    fn parameters(&self) -> Vec<Variable> {
        Vec::new()
    }

    /// The linkages.
    fn linkages(&self) -> Vec<Linkage> {
        Vec::new()
    }

    /// The size that the cost is expected to have.
    fn cost_scale(&self) -> f64 {
        1.0
    }

    /// Running cost and rows at a point of a phase; both come in as zeros.
    fn point<D: Scalar>(&self, phase: usize, at: &Point<'_, D>, out: PointRows<'_, D>);

    /// Cost and rows of a linkage; both come in as zeros.
    fn link<D: Scalar>(
        &self,
        linkage: usize,
        ends: &[EndPoint<'_, D>],
        parameters: &[D],
        cost: &mut D,
        rows: &mut [D],
    ) {
        let _ = (linkage, ends, parameters, cost, rows);
    }
}

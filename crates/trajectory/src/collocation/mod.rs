//! Direct collocation of second-order systems with several linked phases.
//!
//! Accelerations are variables, so the dynamics may be implicit: a residual
//! `r(q, v, a, u) = 0` at every collocation point, with no mass matrix to
//! invert. Within an interval the acceleration is one polynomial, the velocity
//! its integral and the position the integral of that: `q̇ = v` and `v̇ = a` hold
//! everywhere, not only at the collocation points (Moreno-Martín, Ros and
//! Celaya, Collocation methods for second and higher order systems, Autonomous
//! Robots, 2023).

mod problem;
mod scheme;
mod trajectory;
mod transcription;

pub use problem::{
    Coordinate, End, EndPoint, Linkage, OptimalControl, Phase, Point, PointRows, State,
};
pub use scheme::Scheme;
pub use trajectory::{Knot, PhaseTrajectory};
pub use transcription::{Guess, Transcription};

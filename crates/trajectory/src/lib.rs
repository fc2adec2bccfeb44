//! Direct collocation and sequential quadratic programming on Clarabel:
//! functions and sparsity, not robots.
//!
//! A [`Programme`] is made of small blocks, each a function of a few variables
//! written once over [`Scalar`]. [`solve`] finds a local minimum and says in a
//! [`Status`] and a [`Certificate`] what is known about it.

// Sparse and block loops run over slots of several arrays at once.
#![allow(clippy::needless_range_loop)]

mod active_set;
mod certificate;
pub mod collocation;
mod convexify;
mod damping;
mod elastic;
mod estimate;
mod iterate;
mod ldl;
mod merit;
mod model;
mod multistart;
mod newton;
mod optimality;
mod options;
mod pattern;
mod penalty;
mod polish;
mod probe;
mod programme;
mod proposal;
mod qp;
mod scalar;
mod scaling;
mod shift;
mod soc;
mod solution;
mod solver;
mod status;
mod tape;

pub use certificate::Certificate;
pub use convexify::HessianModel;
pub use multistart::{Minimum, MultiStart, multistart, scaled_distance, sort_into_minima};
pub use optimality::OptimalityError;
pub use options::Options;
pub use programme::{Block, LinearRow, Programme, ProgrammeError, Row, Variable};
pub use scalar::Scalar;
pub use scaling::Multipliers;
pub use solution::{Counters, Iteration, Solution, Start, StepKind};
pub use solver::solve;
pub use status::Status;

//! Measured data: the tabular data package, units at the door, validation, frames.
//!
//! A [`Campaign`] is a set of [`Run`]s of one specimen on one rig, already checked and in SI units. Nothing in
//! this crate knows physics; whoever holds a `Campaign` may rely on every invariant that its documentation names.

mod open;
mod record;
mod refusal;
mod units;

pub use open::open;
pub use record::{
    Axis, Campaign, Direction, InitialState, Protocol, Provenance, RigData, Run, Specimen,
};
pub use refusal::{Problem, Refusal};

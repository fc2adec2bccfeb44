//! Measured data: the tabular data package, units at the door, validation, frames.
//!
//! A [`Campaign`] is a set of [`Run`]s of one specimen on one rig, already checked and in SI units. Nothing in
//! this crate knows physics; whoever holds a `Campaign` may rely on every invariant that its documentation names.
//!
//! The way of a package: `description` reads `datapackage.json`, `cells` the CSV files as text, `units` converts once,
//! `assemble` checks each run, `open` puts the runs into canonical order. `write` is the way back, `init` makes a
//! package from plain files.

mod assemble;
mod cells;
mod conditions;
mod description;
mod frame;
mod guess;
mod init;
mod json;
pub mod noise;
mod open;
mod record;
mod refusal;
mod units;
mod write;

pub use frame::csv;
pub use init::{InitError, Initiated, init};
pub use open::open;
pub use record::{
    Axis, Campaign, Direction, InitialState, Protocol, Provenance, RigData, Run, Specimen,
};
pub use refusal::{Problem, Refusal};
pub use write::{WriteError, write, write_atomically};

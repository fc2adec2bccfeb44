//! The measurement chain: law, stations and a run's protocol to the predicted record, with derivatives.
//!
//! ```text
//! stage -> coupling -> contact (law, surface, history) -> load -> sensor -> clock -> recorded force
//! ```
//!
//! An [`Experiment`] is a campaign prepared for prediction, a [`Model`] a law with the effects that act at the
//! stations, a [`Cause`] one such effect. Nothing here knows which causes exist, reads a file other than a
//! [`ModelFile`], or fits anything.

mod along;
mod bends;
mod chain;
mod channel_noise;
mod commands;
mod contact;
mod cord;
mod driven;
mod effect;
mod experiment;
mod factorised;
mod followed;
mod jacobian;
mod load_noise;
mod model;
mod model_file;
mod refined;
mod scales;
pub mod second_order;
pub mod signal;
mod station;
mod velocity_noise;
mod whittaker;

pub use channel_noise::ChannelNoise;
pub use contact::Paths;
pub use cord::Coupling;
pub use effect::{Cause, ChainScalar, Follows, Hook, Hooks, Place, Reach, Reported, Requirement};
pub use experiment::{Experiment, ExperimentError, GRAVITY_M_S2, RunMotion};
pub use load_noise::LoadNoise;
pub use model::{Model, ModelError};
pub use model_file::{
    Extension, ExtensionEntry, ModelFile, ModelFileError, ParameterEntry, SCHEMA,
};
pub use scales::Scales;
pub use station::Station;

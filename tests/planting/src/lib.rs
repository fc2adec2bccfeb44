//! An independent simulator of the rig: writes the stand-in campaigns and hides effects in synthetic ones.
//!
//! It shares no code with the program that is tested with it: own equations, own integrator, own file writer. What it
//! hides, it hides at the level of physics (a mass on a cord, a heat balance, a plate with a texture, a filter in the
//! sensor), and a part of it has deliberately another shape than the program's catalogue.

pub mod case;
mod contact;
pub mod effect;
pub mod integrator;
pub mod law;
pub mod machine;
pub mod motion;
pub mod package;
pub mod plan;
mod play;
pub mod protocols;
pub mod published;
pub mod roughness;
pub mod species;
pub mod stand_ins;

pub use case::{Base, Case, Key, NoiseKind, Outcome, Planted};
pub use protocols::Protocol;

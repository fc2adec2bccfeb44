//! The paper: published numbers, stages, claims, cache and provenance; the program behind cargo xtask.
//!
//! The way of a run: [`published`] and [`claims`] are read, [`campaigns`] opened; [`engine`] runs [`stages`] (each a
//! [`Stage`]), keeping outputs by content ([`cache`]); [`judgements`] set values beside printed numbers and [`judge`]
//! makes verdicts of them; [`results`] is what other programs read, [`compose`] the page.

#[macro_use]
mod say;

pub mod against;
mod audit;
pub mod cache;
mod campaign_page;
pub mod campaigns;
pub mod claims;
pub mod cli;
pub mod compose;
pub mod controls;
pub mod costs;
mod design_page;
mod diagnosis_page;
pub mod engine;
pub mod flips;
mod integrators;
pub mod judge;
pub mod judgements;
pub mod merge;
pub mod multiverse;
pub mod names;
pub mod numbers;
pub mod parcel;
pub mod provenance;
pub mod published;
pub mod results;
pub mod stage;
pub mod stages;
pub mod watch;

pub use published::{Interval, LawNumbers, Printed, Published};
pub use report::{Evidence, Value, Verdict};
pub use stage::{
    ModelText, Needs, Stage, StageContext, StageError, StageOutput, StageStatus, TableFile,
};

/// Evidence of data with this provenance.
#[must_use]
pub fn evidence_of(provenance: campaign::Provenance) -> Evidence {
    match provenance {
        campaign::Provenance::Measured => Evidence::Measured,
        campaign::Provenance::Synthetic => Evidence::Synthetic,
    }
}

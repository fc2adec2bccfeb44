//! The paper: published numbers, stages, claims, cache and provenance; the program behind cargo xtask.

pub mod campaigns;
pub mod names;
pub mod published;
pub mod stage;

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

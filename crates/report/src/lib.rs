//! The document of a reproduction: figures, tables and the page.
//!
//! Whoever has results builds a [`Document`] of plain values and calls [`render`]: out comes one HTML file that loads
//! nothing from a network and is complete without JavaScript. The crate reads results and computes nothing physical;
//! the only arithmetic here is that of drawing (scales, ticks, decimation) and of rounding for the reader.
//!
//! Map of the crate, from the outside in:
//! * [`Document`] and its parts: [`Header`], [`Value`], [`ClaimRow`], [`Deviation`], [`AuditItem`], [`NegativeControl`],
//!   [`Multiverse`], [`Drift`], [`Section`];
//! * a [`Section`] holds [`Block`]s: [`Prose`], [`figure::Figure`], [`Table`], [`Equation`], [`Notice`], [`Chain`];
//! * a figure holds a [`figure::Plot`]: [`figure::LinePlot`], [`figure::BarPlot`], [`figure::HeatMap`],
//!   [`figure::Drawing`], [`figure::Animation`];
//! * [`machine`] writes what programs read: RO-Crate, `codecheck.yml`, the in-toto statement of the verdicts.
//!
//! All parts are serialisable, because stages are cached with the section that they wrote.
//!
//! Numbers never stand in a text: [`Prose`] names a value and the renderer puts it there, see [`prose`].

mod audit;
mod chain;
mod checklist;
mod claim;
mod document;
mod drift;
mod escape;
pub mod figure;
pub mod machine;
mod mathml;
mod number;
mod page;
mod palette;
pub mod prose;
mod section;
mod table;
mod value;

pub use audit::{AuditItem, AuditOutcome};
pub use chain::{Chain, Station, Suspect, SuspectState};
pub use checklist::{Answer, CheckItem};
pub use claim::{
    CauseClass, ClaimRow, Comparison, Deviation, Multiverse, NegativeControl, Verdict,
};
pub use document::{Choice, Document, Header, Input, Run, Status, Subject, Symbol};
pub use drift::{Drift, DriftClass, DriftRow};
pub use number::{unit as printed_unit, with_unit as printed_with_unit};
pub use page::{hex, identity, render, table_file};
pub use prose::{Prose, literal, typeset, typeset_prose};
pub use section::{Block, Equation, Notice, NoticeKind, Section};
pub use table::{Align, Cell, Column, Table};
pub use value::{Evidence, Value};

/// What can stop a document from being rendered. Each names the place, so that the author can find it.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A text names a value that the document does not have.
    #[error("{place}: no value has the id `{id}`")]
    UnknownValue {
        /// Where the text stands.
        place: String,
        /// The id as written.
        id: String,
    },
    /// Two parts of the page have one id, so a link could not tell them apart.
    #[error("the id `{0}` stands on two parts of the page")]
    DoubledId(String),
    /// An equation that the LaTeX reader refuses.
    #[error("{place}: the equation `{latex}` cannot be read: {why}")]
    Equation {
        /// Where the equation stands.
        place: String,
        /// The source.
        latex: String,
        /// What the reader said.
        why: String,
    },
    /// A text whose mark-up does not close.
    #[error("{place}: {why}")]
    Prose {
        /// Where the text stands.
        place: String,
        /// What is wrong with it.
        why: String,
    },
    /// A figure that cannot be drawn (lengths differ, no finite point).
    #[error("figure `{id}`: {why}")]
    Figure {
        /// Id of the figure.
        id: String,
        /// Why it cannot be drawn.
        why: String,
    },
    /// A table with a row of another width, or a frame that cannot be read.
    #[error("table `{id}`: {why}")]
    Table {
        /// Id of the table.
        id: String,
        /// What is wrong.
        why: String,
    },
    /// The page template failed: a defect of this crate.
    #[error("page template: {0}")]
    Template(#[from] minijinja::Error),
    /// The results could not be written as JSON.
    #[error("results: {0}")]
    Json(#[from] serde_json::Error),
}

//! Self-consistency of the paper: what its own numbers say about each other, each with its sum shown.

use serde::{Deserialize, Serialize};

use crate::Prose;

/// How one sum came out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum AuditOutcome {
    /// The printed numbers agree.
    Holds,
    /// They do not.
    Fails,
    /// The paper does not say enough.
    Open,
}

impl AuditOutcome {
    /// The word shown.
    pub fn word(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::Fails => "fails",
            Self::Open => "open",
        }
    }

    /// A sign that tells the outcomes apart without colour.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Holds => "✓",
            Self::Fails => "✕",
            Self::Open => "?",
        }
    }
}

/// One sum over printed numbers. What holds is listed with what does not.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AuditItem {
    /// Short id, such as `A07`: also its address.
    pub id: String,
    /// What is checked.
    pub subject: String,
    /// Place in the paper.
    pub locator: String,
    /// The sum, as inline LaTeX (`$...$`) or words, with the numbers by value id.
    pub sum: Prose,
    /// How it came out.
    pub outcome: AuditOutcome,
    /// What follows from it.
    pub consequence: Prose,
    /// Claims that it bears on.
    pub claims: Vec<String>,
}

//! The questions that reviewers of artefacts ask, answered as far as a program can answer them about itself.

use serde::{Deserialize, Serialize};

use crate::Prose;

/// What the program says to a question.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Answer {
    /// It is so, and the evidence shows it.
    Yes,
    /// In part: the evidence says which.
    Partly,
    /// It is not so.
    No,
    /// Only a person can say.
    Yours,
}

impl Answer {
    /// The word shown.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Yes => "yes",
            Self::Partly => "partly",
            Self::No => "no",
            Self::Yours => "yours to say",
        }
    }

    /// A sign that tells the answers apart without colour.
    #[must_use]
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Yes => "✓",
            Self::Partly => "≈",
            Self::No => "✕",
            Self::Yours => "?",
        }
    }

    /// Class of its colour, shared with the outcomes of sums.
    #[must_use]
    pub fn class(self) -> &'static str {
        match self {
            Self::Yes => "holds",
            Self::No => "fails",
            Self::Partly | Self::Yours => "open",
        }
    }
}

/// One question of the list.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CheckItem {
    /// `R01` and so on: also the address of the row.
    pub id: String,
    /// Whose question it is, such as `ACM: functional`.
    pub source: String,
    /// The question.
    pub question: String,
    /// The answer.
    pub answer: Answer,
    /// What shows it, with links into the page.
    pub evidence: Prose,
}

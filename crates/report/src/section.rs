//! Sections and what they are made of.

use serde::{Deserialize, Serialize};

use crate::figure::Figure;
use crate::{Chain, Prose, Status, Table};

/// One chapter of the page: a stage, the diagnosis of a campaign, the audit.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Section {
    /// Id, unique on the page: its address.
    pub id: String,
    /// Heading.
    pub title: String,
    /// What came out, in one or two sentences: the reader who stops here has the answer.
    pub lead: Prose,
    /// The method box: what was done, how, and how to read what follows.
    pub method: Option<Prose>,
    /// How the stage ended, where it did not simply succeed (named non-convergence, refusal).
    pub status: Option<String>,
    /// Claims that the section bears on.
    pub claims: Vec<String>,
    /// The content.
    pub blocks: Vec<Block>,
}

/// One part of a section.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[allow(clippy::large_enum_variant)] // a page holds a few dozen blocks; plain values are easier to write
pub enum Block {
    /// A heading inside the section: (id, text).
    Heading(String, String),
    /// One or more paragraphs, separated by blank lines.
    Prose(Prose),
    /// A list of points.
    List(Vec<Prose>),
    /// A figure card.
    Figure(Box<Figure>),
    /// A table card.
    Table(Table),
    /// A numbered equation.
    Equation(Equation),
    /// A box that must not be overlooked.
    Notice(Notice),
    /// The chain diagram.
    Chain(Chain),
}

impl From<Figure> for Block {
    fn from(figure: Figure) -> Self {
        Self::Figure(Box::new(figure))
    }
}

impl From<Table> for Block {
    fn from(table: Table) -> Self {
        Self::Table(table)
    }
}

impl Block {
    /// A paragraph.
    pub fn prose(text: impl Into<Prose>) -> Self {
        Self::Prose(text.into())
    }

    /// A heading inside the section.
    pub fn heading(id: &str, text: &str) -> Self {
        Self::Heading(id.into(), text.into())
    }

    /// A box that must not be overlooked.
    pub fn notice(kind: NoticeKind, title: &str, body: impl Into<Prose>) -> Self {
        Self::Notice(Notice {
            kind,
            title: title.into(),
            body: body.into(),
        })
    }
}

/// A displayed equation, rendered to MathML when the page is built.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Equation {
    /// Id, unique on the page, such as `E3`: also its number.
    pub id: String,
    /// LaTeX source.
    pub latex: String,
    /// Where it comes from.
    pub status: Status,
    /// What it says in words.
    pub caption: Prose,
}

/// What a box is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum NoticeKind {
    /// Stand-in data are shown.
    Synthetic,
    /// A result to remember.
    Finding,
    /// Something to be wary of.
    Caution,
    /// The program declines to answer.
    Refusal,
    /// Anything else worth a box.
    Note,
}

/// A box that must not be overlooked.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Notice {
    /// What it is about.
    pub kind: NoticeKind,
    /// A few words.
    pub title: String,
    /// The text.
    pub body: Prose,
}

//! The document: everything that one page shows.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::{
    AuditItem, CheckItem, ClaimRow, Deviation, Drift, NegativeControl, Prose, Section, Value,
};

/// Everything that one page shows. Parts that are empty are left out of the page, so the same type serves the whole
/// reproduction and the report of a single campaign.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Document {
    /// Title of the page.
    pub title: String,
    /// One or two sentences under the title: the answer for a reader in a hurry.
    pub lead: Prose,
    /// The paper or campaign that is examined.
    pub subject: Subject,
    /// Facts about the run that do not change between two runs.
    pub header: Header,
    /// Facts about this run that do: the only part of the page that may differ between two runs.
    pub run: Run,
    /// Every number that a text may name.
    pub values: Vec<Value>,
    /// The ledger; empty in the report of a campaign.
    pub claims: Vec<ClaimRow>,
    /// Every claim that is not green, with its cause and what would settle it.
    pub deviations: Vec<Deviation>,
    /// The paper's own arithmetic.
    pub audit: Vec<AuditItem>,
    /// Stages and diagnosis, in reading order.
    pub sections: Vec<Section>,
    /// What changed against an earlier report.
    pub drift: Option<Drift>,
    /// Assumptions under which the verdicts hold, and what would make the report wrong.
    pub doubts: Vec<Prose>,
    /// Deliberate damages and the claims that they turned.
    pub controls: Vec<NegativeControl>,
    /// What is synthetic.
    pub synthetic: Vec<Prose>,
    /// What is not published.
    pub unpublished: Vec<Prose>,
    /// What was not reproduced or is out of scope, with reasons.
    pub out_of_scope: Vec<Prose>,
    /// The questions of reviewers, answered as far as the program can.
    pub checklist: Vec<CheckItem>,
    /// Every reconstruction choice with its status.
    pub choices: Vec<Choice>,
    /// Symbols with units.
    pub glossary: Vec<Symbol>,
    /// The results as in results.json, without `run`: embedded in the page; their SHA-256 is the identity of the report.
    pub results: serde_json::Value,
}

/// The paper (or the campaign) that is examined.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Subject {
    /// Authors, title, journal, as one reference.
    pub reference: String,
    /// Digital object identifier, without the resolver.
    pub doi: Option<String>,
}

/// One input of the run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Input {
    /// Path relative to the repository or to the folder that the reader named.
    pub path: String,
    /// Its hash, named by the algorithm: `blake3:...` or `sha256:...`.
    pub hash: String,
    /// What it is: `synthetic`, `measured`, `published numbers`, `claims`.
    pub kind: String,
}

/// Facts about the run that are equal for two runs of one program on one target.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// Name and version of the program.
    pub program: String,
    /// Command that makes this page again.
    pub command: String,
    /// Inputs with their hashes.
    pub inputs: Vec<Input>,
    /// Further facts: (name, value), such as seeds, features.
    pub facts: Vec<(String, String)>,
    /// How each stage ended: (stage, status).
    pub stages: Vec<(String, String)>,
    /// Public address of the repository, so that file and line can be linked; nothing is loaded from it.
    pub repository: Option<String>,
}

/// Volatile facts: the one block of the page that may differ between two runs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// Commit of the program.
    pub commit: String,
    /// Whether the working copy had changes.
    pub dirty: bool,
    /// Compiler.
    pub rustc: String,
    /// Target triple.
    pub target: String,
    /// When the run started, ISO 8601.
    pub started: String,
    /// When the last stage ended, ISO 8601; empty where it is not known.
    pub finished: String,
    /// Seconds by stage or claim.
    pub seconds: BTreeMap<String, f64>,
    /// Address of the run in continuous integration.
    pub link: Option<String>,
}

/// Where an equation or a choice comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// The paper says it in words or in a table.
    Stated,
    /// It follows from what is stated.
    Derived,
    /// We chose it.
    Inferred,
}

impl Status {
    /// The word shown.
    pub fn word(self) -> &'static str {
        match self {
            Self::Stated => "stated",
            Self::Derived => "derived",
            Self::Inferred => "inferred",
        }
    }
}

/// One choice that the reconstruction had to make.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Choice {
    /// What is chosen.
    pub subject: Prose,
    /// What we took.
    pub taken: Prose,
    /// Where it comes from.
    pub status: Status,
    /// How results depend on it.
    pub sensitivity: Prose,
}

/// One symbol of the glossary.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Symbol {
    /// LaTeX of the symbol.
    pub latex: String,
    /// What it is.
    pub meaning: Prose,
    /// Unit, `1` for none.
    pub unit: String,
}

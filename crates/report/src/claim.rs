//! The claims ledger: what the paper says, what came out, and the verdict; and what tests the ledger itself.

use serde::{Deserialize, Serialize};

use crate::{Evidence, Prose};

/// How a claim fared. All six are counted on the verdict board, zeros included.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Verdict {
    /// Within the stated tolerance.
    #[serde(rename = "reproduced")]
    Reproduced,
    /// Agrees, but the data or the equation is not published.
    #[serde(rename = "consistent")]
    Consistent,
    /// Differs: by how much, and the likeliest reason, stand beside it.
    #[serde(rename = "differs")]
    Differs,
    /// The paper's own numbers disagree.
    #[serde(rename = "contradicted")]
    Contradicted,
    /// Nothing is published to test it with.
    #[serde(rename = "not testable")]
    NotTestable,
    /// Not part of this run, or its stage came to no result.
    #[serde(rename = "not run")]
    NotRun,
}

impl Verdict {
    /// All six, best news first.
    pub const ALL: [Self; 6] = [
        Self::Reproduced,
        Self::Consistent,
        Self::Differs,
        Self::Contradicted,
        Self::NotTestable,
        Self::NotRun,
    ];

    /// The word of results.json.
    pub fn word(self) -> &'static str {
        match self {
            Self::Reproduced => "reproduced",
            Self::Consistent => "consistent",
            Self::Differs => "differs",
            Self::Contradicted => "contradicted",
            Self::NotTestable => "not testable",
            Self::NotRun => "not run",
        }
    }

    /// The word as a CSS class and as a filter in the page's address.
    pub fn class(self) -> &'static str {
        match self {
            Self::NotTestable => "not-testable",
            Self::NotRun => "not-run",
            other => other.word(),
        }
    }

    /// A sign that tells the verdicts apart without colour.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Reproduced => "✓",
            Self::Consistent => "≈",
            Self::Differs => "≠",
            Self::Contradicted => "✕",
            Self::NotTestable => "?",
            Self::NotRun => "–",
        }
    }

    /// One sentence for the legend.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Reproduced => "Our number lies within the stated tolerance of the published one.",
            Self::Consistent => "Agrees, but the data or the equation behind it is not published.",
            Self::Differs => "Does not agree; by how much and the likeliest reason are given.",
            Self::Contradicted => "The paper’s own numbers disagree with each other.",
            Self::NotTestable => "Nothing is published that could test it.",
            Self::NotRun => "Not part of this run, or its stage came to no result.",
        }
    }
}

/// One row of the ledger. Texts that are [`Prose`] may name values; plain strings are shown as they are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ClaimRow {
    /// `C01` to `C22`: also the address of the row.
    pub id: String,
    /// The claim in one sentence.
    pub claim: Prose,
    /// Place in the paper: section, table cell, figure.
    pub locator: String,
    /// The paper's words, where short ones exist.
    pub quote: Option<String>,
    /// Published number or statement; a number as its rounding interval.
    pub published: Prose,
    /// Ours, with its interval.
    pub ours: Prose,
    /// The same number by number, where there are several: shown as a table in place of `ours` and `deviation`.
    pub comparisons: Vec<Comparison>,
    /// How far apart, in the units that make sense (absolute, relative, last printed digits).
    pub deviation: Option<Prose>,
    /// The tolerance of the verdict.
    pub tolerance: Prose,
    /// Why this tolerance and not another.
    pub reason: Prose,
    /// The smallest tolerance at which the verdict would flip.
    pub flips_at: Option<Prose>,
    /// The verdict.
    pub verdict: Verdict,
    /// What it rests on.
    pub evidence: Evidence,
    /// How it was checked and what follows, a few sentences.
    pub account: Prose,
    /// Ids of the values that decide.
    pub values: Vec<String>,
    /// Ids of figures and tables that show it.
    pub figures: Vec<String>,
    /// Name of the test that pins it.
    pub pinned_by: Option<String>,
    /// Verdict over the product of defensible choices.
    pub multiverse: Option<Multiverse>,
}

impl ClaimRow {
    /// A row with the parts that every claim has; fill in the rest with struct update or by assignment.
    pub fn new(id: &str, claim: impl Into<Prose>, verdict: Verdict, evidence: Evidence) -> Self {
        Self {
            id: id.into(),
            claim: claim.into(),
            locator: String::new(),
            quote: None,
            published: Prose::default(),
            ours: Prose::default(),
            comparisons: Vec::new(),
            deviation: None,
            tolerance: Prose::default(),
            reason: Prose::default(),
            flips_at: None,
            verdict,
            evidence,
            account: Prose::default(),
            values: Vec::new(),
            figures: Vec::new(),
            pinned_by: None,
            multiverse: None,
        }
    }
}

/// One number of a claim, the paper's beside ours.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Comparison {
    /// What is compared.
    pub label: Prose,
    /// The published interval, or the range that the claim's words allow.
    pub published: Prose,
    /// Ours.
    pub ours: Prose,
    /// How far outside, or nothing where they meet.
    pub deviation: Prose,
    /// How far outside still agrees.
    pub tolerance: Prose,
    /// Whether they agree within the tolerance; `None` where ours was not computed.
    pub agrees: Option<bool>,
}

/// How often a verdict holds over the product of defensible choices.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Multiverse {
    /// Combinations in which the verdict is the ledger's.
    pub holds: usize,
    /// Combinations that came to a result.
    pub of: usize,
    /// The axes with their options: (what was chosen, the options).
    pub axes: Vec<(String, Vec<String>)>,
    /// One mark a combination, in the order of the product: its verdict. Empty where only the count is known.
    pub verdicts: Vec<Verdict>,
    /// What decides, in a sentence.
    pub account: Prose,
}

/// What kind of cause a deviation has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CauseClass {
    /// A slip in the paper's text or numbers.
    PaperTypo,
    /// The paper leaves open something that the result depends on.
    UnderSpecified,
    /// Other data than the paper's.
    DifferentData,
    /// Another numerical method.
    NumericalMethod,
    /// The model cannot do what is asked of it.
    ModelLimit,
    /// A defect of ours that is not yet resolved.
    OwnDefect,
}

impl CauseClass {
    /// The words shown.
    pub fn words(self) -> &'static str {
        match self {
            Self::PaperTypo => "slip in the paper",
            Self::UnderSpecified => "under-specified",
            Self::DifferentData => "different data",
            Self::NumericalMethod => "numerical method",
            Self::ModelLimit => "limit of the model",
            Self::OwnDefect => "our open defect",
        }
    }
}

/// One claim that did not come out green: why, and what would settle it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Deviation {
    /// Claim that it belongs to.
    pub claim: String,
    /// Class of the cause.
    pub cause: CauseClass,
    /// What deviates and why we think so.
    pub account: Prose,
    /// The experiment or document that would settle it.
    pub settles: Prose,
}

/// A deliberate damage to the inputs, and the claims that it turned.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NegativeControl {
    /// Short id, such as `N3`.
    pub id: String,
    /// What was altered.
    pub mutation: Prose,
    /// Claims whose verdict must change.
    pub expected: Vec<String>,
    /// Claims whose verdict did change.
    pub turned: Vec<String>,
}

impl NegativeControl {
    /// Whether exactly the expected claims turned.
    pub fn passed(&self) -> bool {
        self.expected == self.turned
    }
}

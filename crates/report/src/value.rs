//! One number of the results, as results.json carries it.

use serde::{Deserialize, Serialize};

/// What a number or a verdict rests on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Evidence {
    /// Read off an instrument.
    Measured,
    /// The paper's own numbers, one against the other.
    Published,
    /// Computed from published parameters alone.
    Computed,
    /// Made from stand-in data: whatever shows it says so.
    Synthetic,
}

impl Evidence {
    /// All kinds, in the order in which the page explains them.
    pub const ALL: [Self; 4] = [
        Self::Measured,
        Self::Published,
        Self::Computed,
        Self::Synthetic,
    ];

    /// The word of results.json.
    pub fn word(self) -> &'static str {
        match self {
            Self::Measured => "measured",
            Self::Published => "published",
            Self::Computed => "computed",
            Self::Synthetic => "synthetic",
        }
    }
}

/// One number of the results, with its unit, interval and published counterpart (contract: results.json, `values`).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Value {
    /// Dotted id, such as `identification.aluminium.sigma0`.
    pub id: String,
    /// The number; absent where the stage could not produce one (the stage's status says why).
    pub value: Option<f64>,
    /// Unit, `1` for none.
    pub unit: String,
    /// 95 % interval.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ci95: Option<[f64; 2]>,
    /// The published number as printed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub published: Option<String>,
    /// Stage that made it.
    pub stage: String,
    /// What it rests on.
    pub evidence: Evidence,
}

impl Value {
    /// A number without interval or published counterpart.
    pub fn new(
        id: impl Into<String>,
        value: f64,
        unit: &str,
        stage: &str,
        evidence: Evidence,
    ) -> Self {
        Self {
            id: id.into(),
            value: value.is_finite().then_some(value),
            unit: unit.into(),
            ci95: None,
            published: None,
            stage: stage.into(),
            evidence,
        }
    }

    /// The same with a 95 % interval; an interval that is not finite is dropped.
    #[must_use]
    pub fn with_ci95(mut self, low: f64, high: f64) -> Self {
        self.ci95 = (low.is_finite() && high.is_finite()).then_some([low, high]);
        self
    }

    /// The same with the published number as printed.
    #[must_use]
    pub fn with_published(mut self, printed: impl Into<String>) -> Self {
        self.published = Some(printed.into());
        self
    }
}

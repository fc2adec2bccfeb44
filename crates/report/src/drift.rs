//! What changed against an earlier report.

use serde::{Deserialize, Serialize};

/// Why a value moved, as far as the two reports can tell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum DriftClass {
    /// A few units in the last place, same target and toolchain.
    Noise,
    /// Another target or toolchain, same inputs: within tolerance of the physics.
    Platform,
    /// Same inputs, other program: within tolerance of the physics.
    Algorithm,
    /// Other inputs.
    Input,
    /// Beyond the tolerance with the same inputs.
    Physics,
}

impl DriftClass {
    /// The word shown.
    pub fn word(self) -> &'static str {
        match self {
            Self::Noise => "noise",
            Self::Platform => "platform",
            Self::Algorithm => "algorithm",
            Self::Input => "input",
            Self::Physics => "physics",
        }
    }
}

/// One value that moved, appeared or vanished.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DriftRow {
    /// Value id or claim id.
    pub id: String,
    /// Before; `None` where it did not exist.
    pub old: Option<f64>,
    /// Now; `None` where it no longer exists.
    pub new: Option<f64>,
    /// Unit.
    pub unit: String,
    /// Share of the tolerance that the difference uses up, percent.
    pub tolerance_used_percent: Option<f64>,
    /// Why, as far as can be told.
    pub class: DriftClass,
    /// Claims whose verdict flipped with it.
    pub flips: Vec<String>,
}

/// The comparison with an earlier report.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Drift {
    /// What was compared with: the file as named by the user, and its identity.
    pub against: String,
    /// SHA-256 of the earlier results.
    pub old_identity: String,
    /// Values that are equal bit for bit.
    pub unchanged: usize,
    /// What moved.
    pub rows: Vec<DriftRow>,
    /// Verdicts that changed: (claim, before, now).
    pub verdicts: Vec<(String, String, String)>,
    /// Claims with one verdict in both reports for which the earlier values, judged by the present rules, ask for another:
    /// (claim, by the earlier values, now).
    pub by_values: Vec<(String, String, String)>,
    /// Target and compiler of the earlier report and of this one, where they are not the same.
    pub platforms: Option<[String; 2]>,
}

impl Drift {
    /// Whether both reports say the same.
    #[must_use]
    pub fn nothing(&self) -> bool {
        self.rows.is_empty() && self.verdicts.is_empty() && self.by_values.is_empty()
    }
}

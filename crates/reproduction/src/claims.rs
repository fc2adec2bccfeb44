//! The claims as `data/claims.toml` lists them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use report::{CauseClass, Verdict};
use serde::Deserialize;

use crate::judge::{Combine, Nature};

/// One claim of the paper.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Claim {
    /// `C01` to `C22`.
    pub id: String,
    /// The claim in our words.
    pub text: String,
    /// Where the paper makes it.
    pub locator: String,
    /// What kind of statement it is.
    pub nature: Nature,
    /// How its checks combine.
    #[serde(default)]
    pub combine: Combine,
    /// The published number or statement in words.
    pub published_text: String,
    /// Ids in data/published.toml on which the verdict depends.
    #[serde(default)]
    pub published: Vec<String>,
    /// Stages whose values decide.
    pub stages: Vec<String>,
    /// The tolerance, in words.
    pub tolerance_text: String,
    /// The tolerances as numbers, by the name under which the judgement uses them.
    #[serde(default)]
    pub tolerance: BTreeMap<String, f64>,
    /// Why these and no others.
    pub reason: String,
    /// How it was checked and what follows; may name values.
    pub account: String,
    /// Why no verdicts over a product of choices stand beside it; may name values.
    pub no_choices: Option<String>,
    /// The verdict on the shipped data.
    pub expected: Verdict,
    /// Values on the shipped data: id -> [value, tolerance].
    #[serde(default)]
    pub pinned: BTreeMap<String, [f64; 2]>,
    /// Ids of figures and tables that show it.
    #[serde(default)]
    pub figures: Vec<String>,
    /// Where it does not come out green: the class of the cause.
    pub cause: Option<CauseClass>,
    /// The likeliest reason for the deviation; may name values.
    pub deviation: Option<String>,
    /// The experiment or document that would settle it.
    pub settles: Option<String>,
}

/// Why the claims could not be read.
#[derive(Debug, thiserror::Error)]
pub enum ClaimsError {
    /// The file could not be read.
    #[error("{}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The file is not TOML of this form.
    #[error("claims: {0}")]
    Toml(#[from] Box<toml::de::Error>),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ClaimsFile {
    claim: Vec<Claim>,
}

/// Reads the claims in the order of the file.
///
/// # Errors
/// Where the file cannot be read or an entry lacks a field.
pub fn read(path: &Path) -> Result<Vec<Claim>, ClaimsError> {
    let text = std::fs::read_to_string(path).map_err(|source| ClaimsError::Read {
        path: path.to_owned(),
        source,
    })?;
    let file: ClaimsFile = toml::from_str(&text).map_err(Box::new)?;
    Ok(file.claim)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Claims for which a stage leaves verdicts over choices.
    const WITH_CHOICES: [&str; 15] = [
        "C01", "C02", "C03", "C05", "C06", "C07", "C09", "C10", "C11", "C12", "C13", "C17", "C18",
        "C21", "C22",
    ];

    #[test]
    fn a_claim_has_verdicts_over_choices_or_the_reason_why_not() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/claims.toml");
        for claim in read(&path).unwrap() {
            let has = WITH_CHOICES.contains(&claim.id.as_str());
            assert_eq!(claim.no_choices.is_none(), has, "{}", claim.id);
        }
    }
}

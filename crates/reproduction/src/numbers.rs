//! Whether every number that the paper prints has its place: in a claim, in a table or a sum, or with a reason why not.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::claims::Claim;
use crate::published::Published;

/// What is done with a number on which no claim rests.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
pub enum Treatment {
    /// Compared in a table or a sum.
    #[serde(rename = "compared")]
    Compared,
    /// An input or a setting.
    #[serde(rename = "not a claim")]
    NotAClaim,
    /// Something is said, and nothing is published to test it with.
    #[serde(rename = "not testable")]
    NotTestable,
}

impl Treatment {
    /// The word shown.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Compared => "compared",
            Self::NotAClaim => "not a claim",
            Self::NotTestable => "not testable",
        }
    }
}

/// Numbers of data/published.toml that are treated alike.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Group {
    /// Their ids.
    pub numbers: Vec<String>,
    /// What is done with them.
    pub status: Treatment,
    /// The part of the page that shows them.
    pub shown: Option<String>,
    /// Why.
    pub reason: String,
}

/// Printed numbers from which nothing is computed under a name of their own.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Beside {
    /// As they stand in the paper.
    pub printed: Vec<String>,
    /// Unit.
    pub unit: String,
    /// Where.
    pub locator: String,
    /// What they are.
    pub meaning: String,
    /// What is done with them.
    pub status: Treatment,
    /// Why.
    pub reason: String,
}

/// `data/other-numbers.toml`.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OtherNumbers {
    /// Numbers with an id.
    #[serde(default)]
    pub group: Vec<Group>,
    /// Numbers without.
    #[serde(default)]
    pub beside: Vec<Beside>,
}

/// Why the file could not be read.
#[derive(Debug, thiserror::Error)]
pub enum NumbersError {
    /// It is not there or cannot be read.
    #[error("{}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// It is not TOML of this form.
    #[error("other numbers: {0}")]
    Toml(#[from] Box<toml::de::Error>),
}

/// Reads the file.
///
/// # Errors
/// Where it cannot be read or has another form.
pub fn read(path: &Path) -> Result<OtherNumbers, NumbersError> {
    let text = std::fs::read_to_string(path).map_err(|source| NumbersError::Read {
        path: path.to_owned(),
        source,
    })?;
    Ok(toml::from_str(&text).map_err(Box::new)?)
}

/// Where every printed number stands.
#[derive(Clone, Debug, Default)]
pub struct Coverage {
    /// How many numbers the paper prints, those without an id included.
    pub printed: usize,
    /// Claims by the number that they rest on.
    pub claimed: BTreeMap<String, Vec<String>>,
    /// What is done with the others.
    pub others: OtherNumbers,
    /// Numbers that are nowhere.
    pub unledgered: Vec<String>,
    /// Rows that cover no printed number, or one that a claim or another row covers already.
    pub orphans: Vec<String>,
}

/// Looks every number up.
#[must_use]
pub fn coverage(published: &Published, claims: &[Claim], others: &OtherNumbers) -> Coverage {
    let ids: BTreeSet<&str> = published.iter().map(|(id, _)| id).collect();
    let mut found = Coverage {
        printed: ids.len()
            + others
                .beside
                .iter()
                .map(|row| row.printed.len())
                .sum::<usize>(),
        others: others.clone(),
        ..Coverage::default()
    };
    for claim in claims {
        for id in &claim.published {
            if !ids.contains(id.as_str()) {
                found.orphans.push(format!("{id} ({})", claim.id));
            }
            let claims = found.claimed.entry(id.clone()).or_default();
            claims.push(claim.id.clone());
        }
    }
    let mut listed = BTreeSet::new();
    for id in others.group.iter().flat_map(|group| &group.numbers) {
        let needless = found.claimed.contains_key(id) || !listed.insert(id.as_str());
        if needless || !ids.contains(id.as_str()) {
            found.orphans.push(format!("{id} (other numbers)"));
        }
    }
    found.unledgered = ids
        .into_iter()
        .filter(|id| !found.claimed.contains_key(*id) && !listed.contains(id))
        .map(str::to_owned)
        .collect();
    found
}

impl Coverage {
    /// Numbers on which a claim rests.
    #[must_use]
    pub fn in_claims(&self) -> usize {
        self.claimed.len()
    }

    /// How many numbers are treated in one way.
    #[must_use]
    pub fn treated(&self, treatment: Treatment) -> usize {
        let groups = self
            .others
            .group
            .iter()
            .filter(|row| row.status == treatment);
        let beside = self
            .others
            .beside
            .iter()
            .filter(|row| row.status == treatment);
        groups.map(|row| row.numbers.len()).sum::<usize>()
            + beside.map(|row| row.printed.len()).sum::<usize>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn data() -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data")
    }

    fn shipped() -> (Published, Vec<Claim>, OtherNumbers) {
        (
            Published::shipped(),
            crate::claims::read(&data().join("claims.toml")).unwrap(),
            read(&data().join("other-numbers.toml")).unwrap(),
        )
    }

    #[test]
    fn every_printed_number_has_its_place_and_every_row_its_number() {
        let (published, claims, others) = shipped();
        let found = coverage(&published, &claims, &others);
        assert!(found.unledgered.is_empty(), "{:?}", found.unledgered);
        assert!(found.orphans.is_empty(), "{:?}", found.orphans);
        let treated: usize = [
            Treatment::Compared,
            Treatment::NotAClaim,
            Treatment::NotTestable,
        ]
        .map(|treatment| found.treated(treatment))
        .iter()
        .sum();
        assert_eq!(found.in_claims() + treated, found.printed, "each once");
    }

    #[test]
    fn a_dropped_row_leaves_its_numbers_unledgered() {
        let (published, claims, mut others) = shipped();
        let dropped = others.group.remove(0);
        let found = coverage(&published, &claims, &others);
        assert_eq!(found.unledgered.len(), dropped.numbers.len());
    }

    #[test]
    fn rows_without_a_number_of_their_own_are_orphans() {
        let (published, mut claims, mut others) = shipped();
        others.group[0].numbers.push("table9.sigma".into());
        others.group[0].numbers.push("table1.sigma".into());
        claims[0].published.push("steady.sideways".into());
        let found = coverage(&published, &claims, &others);
        assert_eq!(
            found.orphans,
            [
                "steady.sideways (C01)",
                "table9.sigma (other numbers)",
                "table1.sigma (other numbers)"
            ]
        );
    }
}

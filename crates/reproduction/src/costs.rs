//! What stages cost to compute, s: as measured on this machine when they were last computed, else as shipped.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::engine::Finished;

/// Seconds by stage.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Costs {
    /// Where and how they were measured.
    pub measured: String,
    /// Wall time of a stage beside those that ran with it.
    pub seconds: BTreeMap<String, f64>,
}

/// Why the shipped costs cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("{}: {problem}", path.display())]
pub struct CostsError {
    path: PathBuf,
    problem: String,
}

/// Name of the file with the costs of this machine: it lies beside the kept outputs.
pub const FILE: &str = "seconds.json";

impl Costs {
    /// The shipped ones, over them those that were measured beside the outputs in `kept`.
    ///
    /// # Errors
    /// Where the shipped file cannot be read. An own file that cannot is no measurement.
    pub fn read(root: &Path, kept: &Path) -> Result<Self, CostsError> {
        let mut costs = Self::shipped(root)?;
        if let Some(here) = Self::here(kept) {
            costs.seconds.extend(here.seconds);
            costs.measured = here.measured;
        }
        Ok(costs)
    }

    /// The shipped ones: the same for everybody.
    ///
    /// # Errors
    /// Where the file cannot be read.
    pub fn shipped(root: &Path) -> Result<Self, CostsError> {
        let path = root.join("data/costs.json");
        let refuse = |error: &dyn std::fmt::Display| CostsError {
            path: path.clone(),
            problem: error.to_string(),
        };
        let text = std::fs::read_to_string(&path).map_err(|error| refuse(&error))?;
        serde_json::from_str(&text).map_err(|error| refuse(&error))
    }

    fn here(kept: &Path) -> Option<Self> {
        let text = std::fs::read_to_string(kept.join(FILE)).ok()?;
        serde_json::from_str(&text).ok()
    }

    /// Keeps the times of the stages that were computed in this run.
    ///
    /// # Errors
    /// Where the file cannot be written.
    pub fn record(kept: &Path, stages: &[Finished]) -> std::io::Result<()> {
        let computed = stages
            .iter()
            .filter(|stage| !stage.kept && stage.output.is_ok());
        let new: BTreeMap<String, f64> = computed
            .map(|stage| (stage.id.to_owned(), stage.seconds))
            .collect();
        if new.is_empty() {
            return Ok(());
        }
        let mut costs = Self::here(kept).unwrap_or_default();
        costs.measured = "on this machine, when they were last computed".to_owned();
        costs.seconds.extend(new);
        costs.write(kept)
    }

    /// Brings together what several machines measured; a folder without times adds none.
    ///
    /// # Errors
    /// Where the file cannot be written.
    pub fn gather(from: &[PathBuf], kept: &Path) -> std::io::Result<()> {
        let mut costs = Self::here(kept).unwrap_or_default();
        costs.measured = "on the machines that last computed them".to_owned();
        for other in from.iter().filter_map(|folder| Self::here(folder)) {
            costs.seconds.extend(other.seconds);
        }
        costs.write(kept)
    }

    fn write(&self, kept: &Path) -> std::io::Result<()> {
        let text = serde_json::to_string_pretty(self).map_err(std::io::Error::other)?;
        campaign::write_atomically(&kept.join(FILE), (text + "\n").as_bytes())
            .map_err(std::io::Error::other)
    }

    /// What these stages cost together; one that was never measured counts nothing.
    #[must_use]
    pub fn of<'a>(&self, stages: impl IntoIterator<Item = &'a str>) -> f64 {
        stages
            .into_iter()
            .filter_map(|stage| self.seconds.get(stage))
            .sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_stage_has_a_shipped_cost() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let costs = Costs::read(&root, Path::new("/nonexistent")).unwrap();
        let stages: Vec<&str> = crate::stages::all()
            .iter()
            .map(|stage| stage.id())
            .collect();
        let mut sorted = stages.clone();
        sorted.sort_unstable();
        assert!(costs.seconds.keys().map(String::as_str).eq(sorted));
        assert!(costs.of(stages) > 1.0);
    }

    #[test]
    fn what_was_measured_here_counts_before_what_is_shipped() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let out = std::env::temp_dir().join(format!("bristle-costs-{}", std::process::id()));
        let here = r#"{"measured": "here", "seconds": {"audit": 123.0}}"#;
        campaign::write_atomically(&out.join(FILE), here.as_bytes()).unwrap();
        let costs = Costs::read(&root, &out).unwrap();
        assert_eq!(costs.of(["audit"]), 123.0);
        assert!(costs.of(["gait"]) > 0.0, "shipped");
        std::fs::remove_dir_all(out).unwrap();
    }
}

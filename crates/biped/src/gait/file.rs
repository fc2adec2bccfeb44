//! The file of strides (`data/strides.json`): for each named problem a stride to start from.

use super::catalogue::Name;
use serde::{Deserialize, Serialize};

/// A file of strides.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct StridesFile {
    /// What the strides are and where they come from.
    #[serde(default)]
    pub about: String,
    /// One a problem, or several.
    pub starts: Vec<NamedStart>,
}

/// The name of a problem and a vector of its variables.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct NamedStart {
    /// Which problem.
    #[serde(flatten)]
    pub name: Name,
    /// Of the search that found the stride, where it kept a count.
    #[serde(flatten)]
    pub search: Option<Search>,
    /// Variables of the stride, in the order of its layout.
    pub x: Vec<f64>,
}

/// What the search for a stride knows of it, over all its runs.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Search {
    /// Starts from which it ended in this stride.
    pub found: usize,
    /// Starts from which it solved the problem.
    pub tried: usize,
    /// How many of these were hops ([`super::hopping`]): no strides of other problems as they are.
    #[serde(default)]
    pub hops: usize,
    /// The start that led to the stride, where the search kept it: whose stride it was, and its cost.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<(Name, f64)>,
}

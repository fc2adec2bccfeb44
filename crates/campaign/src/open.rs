//! Opening a package.

use std::path::Path;

use crate::record::Campaign;
use crate::refusal::{Problem, Refusal};

/// Opens the package in the folder `path`, checks it and converts it to SI units.
///
/// # Errors
/// The first thing that is wrong with it, in one line.
pub fn open(path: &Path) -> Result<Campaign, Refusal> {
    Err(Refusal::of(
        &path.display().to_string(),
        Problem::Unreadable("not read yet".to_owned()),
    ))
}

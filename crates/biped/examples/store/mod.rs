//! Files of strides on disk, for the examples that search.

use biped::gait::catalogue::Name;
use biped::gait::file::{NamedStart, Search, StridesFile};
use std::cmp::{Ordering, Reverse};
use std::error::Error;
use std::path::Path;

/// A stride as a file keeps it: six digits are enough for a start.
pub(crate) fn row(
    name: Name,
    search: Option<Search>,
    x: &[f64],
) -> Result<NamedStart, Box<dyn Error + Send + Sync>> {
    let short = |x: &f64| format!("{x:.5e}").parse::<f64>();
    let x = x.iter().map(short).collect::<Result<_, _>>()?;
    Ok(NamedStart { name, search, x })
}

/// The strides of a file.
#[allow(dead_code, reason = "not every search reads")]
pub(crate) fn read(path: &Path) -> Result<Vec<NamedStart>, Box<dyn Error + Send + Sync>> {
    let text = std::fs::read_to_string(path)?;
    Ok(serde_json::from_str::<StridesFile>(&text)?.starts)
}

/// Writes strides, one a line, in the order of their names, so that a search changes no lines but its own.
pub(crate) fn write(
    path: &Path,
    about: &str,
    mut starts: Vec<NamedStart>,
) -> Result<(), Box<dyn Error + Send + Sync>> {
    let order = |row: &NamedStart| {
        let n = row.name;
        let ground = (Reverse(n.kind), n.k, n.c, n.brush.id());
        (ground, n.weight, n.aim, n.choice.id())
    };
    starts.sort_by(|a, b| order(a).partial_cmp(&order(b)).unwrap_or(Ordering::Equal));
    let about = serde_json::to_string(about)?;
    let lines: Vec<String> = starts
        .iter()
        .map(serde_json::to_string)
        .collect::<Result<_, _>>()?;
    let lines = lines.join(",\n");
    replace(
        path,
        &format!("{{\"about\":{about},\n\"starts\":[\n{lines}\n]}}\n"),
    )
}

/// Writes a text whole or not at all.
pub(crate) fn replace(path: &Path, text: &str) -> Result<(), Box<dyn Error + Send + Sync>> {
    let mut part = path.as_os_str().to_owned();
    part.push(".part");
    std::fs::write(&part, text)?;
    Ok(std::fs::rename(&part, path)?)
}

//! What a run left in its folder, and whether another one left the same bytes.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use serde_json::Value as Json;
use sha2::{Digest, Sha256};

use super::Failure;
use crate::compose::{Prints, Twice};

/// What two folders hold, and where they differ.
pub(super) fn compare(folders: [&Path; 2], threads: [&str; 2]) -> Result<Twice, Failure> {
    let [one, other] = folders.map(Left::read);
    let (one, other) = (one?, other?);
    Ok(Twice {
        different: one.differences(&other),
        prints: [one.prints(threads[0]), other.prints(threads[1])],
    })
}

/// What a run left.
struct Left {
    results: Json,
    files: BTreeMap<String, Vec<u8>>,
}

impl Left {
    fn read(folder: &Path) -> Result<Self, Failure> {
        let path = folder.join("results.json");
        let failed =
            |error: &dyn std::fmt::Display| Failure::Output(format!("{}: {error}", path.display()));
        let text = std::fs::read_to_string(&path).map_err(|error| failed(&error))?;
        let results = serde_json::from_str(&text).map_err(|error| failed(&error))?;
        let mut files = BTreeMap::new();
        for part in ["tables", "figures"] {
            let Ok(entries) = std::fs::read_dir(folder.join(part)) else {
                continue;
            };
            for entry in entries.filter_map(Result::ok) {
                let name = format!("{part}/{}", entry.file_name().to_string_lossy());
                files.insert(name, std::fs::read(entry.path()).map_err(Failure::output)?);
            }
        }
        let page = folder.join("report.html");
        if let Ok(page) = std::fs::read_to_string(&page) {
            files.insert("report.html".to_owned(), without_run(&page).into_bytes());
        }
        Ok(Self { results, files })
    }

    fn prints(&self, threads: &str) -> Prints {
        let mut files = Sha256::new();
        for (name, bytes) in &self.files {
            // Lengths keep the end of one file from passing as the start of the next.
            for part in [name.as_bytes(), bytes.as_slice()] {
                files.update((part.len() as u64).to_le_bytes());
                files.update(part);
            }
        }
        Prints {
            threads: threads.to_owned(),
            results: report::identity(&self.results),
            files: report::hex(&files.finalize()),
        }
    }

    /// Values, other parts of the results and files that are not equal.
    fn differences(&self, other: &Self) -> Vec<String> {
        let (ours, theirs) = (entries(&self.results), entries(&other.results));
        let names: BTreeSet<&String> = ours.keys().chain(theirs.keys()).collect();
        let mut found: Vec<String> = names
            .into_iter()
            .filter(|name| ours.get(*name) != theirs.get(*name))
            .cloned()
            .collect();
        let names: BTreeSet<&String> = self.files.keys().chain(other.files.keys()).collect();
        found.extend(
            names
                .into_iter()
                .filter(|name| self.files.get(*name) != other.files.get(*name))
                .cloned(),
        );
        found
    }
}

/// Values, claims and stages by id, as text: numbers are compared by their shortest decimal form, which is exact.
fn entries(results: &Json) -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    for part in ["values", "claims", "stages"] {
        for entry in results[part].as_array().into_iter().flatten() {
            let id = entry["id"].as_str().unwrap_or_default();
            let name = match part {
                "stages" => format!("stage {id}"),
                _ => id.to_owned(),
            };
            found.insert(name, entry.to_string());
        }
    }
    found
}

/// The page without its one block of volatile facts.
fn without_run(page: &str) -> String {
    let block = page
        .split_once("<!-- volatile:begin -->")
        .and_then(|(before, rest)| Some((before, rest.split_once("<!-- volatile:end -->")?.1)));
    block.map_or_else(
        || page.to_owned(),
        |(before, after)| before.to_owned() + after,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    /// A folder as a run leaves it.
    fn folder(name: &str, value: f64, started: &str, csv: &str) -> std::path::PathBuf {
        let folder = std::env::temp_dir().join(format!("bristle-{name}-{}", std::process::id()));
        let results = json!({"values": [{"id": "gait.gain", "value": value}],
            "claims": [], "stages": [], "run": {"started": started}});
        let text = results.to_string();
        campaign::write_atomically(&folder.join("results.json"), text.as_bytes()).unwrap();
        campaign::write_atomically(&folder.join("tables/laws.csv"), csv.as_bytes()).unwrap();
        folder
    }

    #[test]
    fn one_bit_in_a_value_or_a_table_is_found_and_the_clock_is_not_compared() {
        let value = 4.67_f64;
        let next = f64::from_bits(value.to_bits() + 1);
        let own = folder("twice-own", value, "monday", "a\n1\n");
        let cases = [
            (folder("twice-same", value, "tuesday", "a\n1\n"), vec![]),
            (
                folder("twice-value", next, "monday", "a\n1\n"),
                vec!["gait.gain"],
            ),
            (
                folder("twice-table", value, "monday", "a\n2\n"),
                vec!["tables/laws.csv"],
            ),
        ];
        for (other, different) in &cases {
            let twice = compare([&own, other], ["1", "all"]).unwrap();
            assert_eq!(&twice.different, different);
            assert_eq!(twice.same(), different.is_empty());
        }
        let folders = cases.iter().map(|(folder, _)| folder).chain([&own]);
        for folder in folders {
            std::fs::remove_dir_all(folder).unwrap();
        }
    }
}

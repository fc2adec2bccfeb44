//! `reproduce --twice`: the same work in two processes of their own, one with a single thread and one with all.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::{Command, Stdio};

use serde_json::Value as Json;
use sha2::{Digest, Sha256};

use super::{Failure, ReproduceArguments};
use crate::compose::{Prints, Twice};

/// Runs both and compares them; what the second one computed is kept in `out`, so that the page costs no third run.
pub(super) fn run(arguments: &ReproduceArguments, out: &Path) -> Result<Twice, Failure> {
    let folder = out.join(".twice");
    remove(&folder)?;
    // One processor can still interleave two threads.
    let all = std::thread::available_parallelism().map_or(2, |count| count.get().max(2));
    let [one, many] = ["one", "all"].map(|name| folder.join(name));
    child(arguments, 1, &one)?;
    child(arguments, all, &many)?;
    let twice = compare(&one, &many)?;
    keep(&many.join(".cache"), &out.join(".cache"))?;
    remove(&folder)?;
    Ok(twice)
}

fn remove(folder: &Path) -> Result<(), Failure> {
    match std::fs::remove_dir_all(folder) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(Failure::output(format!("{}: {error}", folder.display())))
        }
        _ => Ok(()),
    }
}

/// A whole reproduction from nothing in a process of its own; its progress is shown, its answer is not.
fn child(arguments: &ReproduceArguments, threads: usize, out: &Path) -> Result<(), Failure> {
    let program = std::env::current_exe().map_err(Failure::output)?;
    let mut command = Command::new(program);
    command.arg("reproduce").arg("--out").arg(out);
    command.args(["--threads", &threads.to_string()]);
    if let Some(data) = &arguments.data {
        command.arg("--data").arg(data);
    }
    if let Some(stage) = &arguments.stage {
        command.args(["--stage", stage]);
    }
    if let Some(model) = &arguments.model {
        command.arg("--model").arg(model);
    }
    if arguments.quick {
        command.arg("--quick");
    }
    let status = command
        .stdout(Stdio::null())
        .status()
        .map_err(Failure::output)?;
    match status.code() {
        // Verdicts that are not as pinned are told by the run that writes the report.
        Some(0 | 1) => Ok(()),
        Some(2) => Err(Failure::Input(
            "the input was refused (see above)".to_owned(),
        )),
        _ => Err(Failure::Output(format!(
            "the run with {threads} threads did not end"
        ))),
    }
}

/// What two folders hold, and where they differ.
fn compare(one: &Path, many: &Path) -> Result<Twice, Failure> {
    let left = Left::read(one)?;
    let right = Left::read(many)?;
    Ok(Twice {
        different: left.differences(&right),
        prints: [left.prints("1"), right.prints("all")],
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

/// Copies kept outputs of stages.
fn keep(from: &Path, to: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(to).map_err(Failure::output)?;
    for entry in std::fs::read_dir(from).map_err(Failure::output)? {
        let entry = entry.map_err(Failure::output)?;
        let bytes = std::fs::read(entry.path()).map_err(Failure::output)?;
        campaign::write_atomically(&to.join(entry.file_name()), &bytes).map_err(Failure::output)?;
    }
    Ok(())
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
            let twice = compare(&own, other).unwrap();
            assert_eq!(&twice.different, different);
            assert_eq!(twice.same(), different.is_empty());
        }
        let folders = cases.iter().map(|(folder, _)| folder).chain([&own]);
        for folder in folders {
            std::fs::remove_dir_all(folder).unwrap();
        }
    }
}

//! Kept outputs of several machines brought together: exactly one for each task of a plan, or a refusal that says why.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde_json::Value as Json;

use crate::costs;
use crate::engine::Task;
use crate::names::nearest;
use crate::parcel::{Parcel, ParcelError};

/// Why outputs do not make one report.
#[derive(Debug, thiserror::Error)]
pub enum MergeError {
    /// A folder cannot be listed.
    #[error("{}: {source}", path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A file is no kept output, or a damaged one.
    #[error(transparent)]
    Parcel(#[from] ParcelError),
    /// A file is the output of a stage that the plan does not have.
    #[error("{}: the plan has no stage `{stage}`; the nearest name is `{nearest}`", path.display())]
    Stage {
        /// The file.
        path: PathBuf,
        /// Its stage.
        stage: String,
        /// The nearest right name.
        nearest: String,
    },
    /// An output was made from something else than what the plan names.
    #[error("{}: the output of {stage} has another key than the plan: {because}", path.display())]
    Key {
        /// The file.
        path: PathBuf,
        /// Its stage.
        stage: String,
        /// What is not the same.
        because: String,
    },
    /// Two machines gave two outputs from the same inputs.
    #[error(
        "two outputs of {stage} with the same key are not equal; the first difference is at {difference} ({} and {})",
        files[0].display(),
        files[1].display()
    )]
    TwoOutputs {
        /// The stage.
        stage: String,
        /// Where they differ.
        difference: String,
        /// Where they lie.
        files: [PathBuf; 2],
    },
    /// Nobody computed a task.
    #[error("no folder holds the output of {}: cargo xtask run-task {} --out DIR", stages.join(", "), stages.join(" "))]
    Missing {
        /// The stages.
        stages: Vec<String>,
    },
}

/// One output for each task, in the order of the plan.
///
/// # Errors
/// Where one is missing, does not fit, or is there twice and not equal.
pub fn merge(tasks: &[Task], folders: &[PathBuf]) -> Result<Vec<Parcel>, MergeError> {
    let mut found: BTreeMap<&str, (PathBuf, Parcel)> = BTreeMap::new();
    for folder in folders {
        for path in files(folder)? {
            let parcel = Parcel::read(&path)?;
            let task = fitting(tasks, &path, &parcel)?;
            match found.get(task.stage) {
                None => {
                    found.insert(task.stage, (path, parcel));
                }
                Some((other, twin)) => {
                    if let Some(difference) = difference(&twin.output, &parcel.output) {
                        return Err(MergeError::TwoOutputs {
                            stage: parcel.stage,
                            difference,
                            files: [other.clone(), path],
                        });
                    }
                }
            }
        }
    }
    let missing: Vec<String> = tasks
        .iter()
        .filter(|task| !found.contains_key(task.stage))
        .map(|task| task.stage.to_owned())
        .collect();
    if !missing.is_empty() {
        return Err(MergeError::Missing { stages: missing });
    }
    Ok(tasks
        .iter()
        .filter_map(|task| found.remove(task.stage))
        .map(|(_, parcel)| parcel)
        .collect())
}

/// Files that are to be kept outputs, by name; times that were measured beside them are none.
fn files(folder: &Path) -> Result<Vec<PathBuf>, MergeError> {
    let refuse = |source| MergeError::Folder {
        path: folder.to_owned(),
        source,
    };
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(refuse)? {
        let path = entry.map_err(refuse)?.path();
        let json = path.extension().is_some_and(|ending| ending == "json");
        if json && path.file_name().is_some_and(|name| name != costs::FILE) {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}

/// The task of which a parcel is the output.
fn fitting<'t>(tasks: &'t [Task], path: &Path, parcel: &Parcel) -> Result<&'t Task, MergeError> {
    let stages = || tasks.iter().map(|task| task.stage);
    let task = tasks
        .iter()
        .find(|task| task.stage == parcel.stage)
        .ok_or_else(|| MergeError::Stage {
            path: path.to_owned(),
            stage: parcel.stage.clone(),
            nearest: nearest(&parcel.stage, stages()).to_owned(),
        })?;
    match task.origin.difference(&parcel.origin) {
        None => Ok(task),
        Some(because) => Err(MergeError::Key {
            path: path.to_owned(),
            stage: parcel.stage.clone(),
            because,
        }),
    }
}

/// The first place at which two outputs differ, bit for bit, with both sides; `None` where they are equal.
fn difference(one: &Json, other: &Json) -> Option<String> {
    let mut place = Vec::new();
    let sides = descend(one, other, &mut place)?;
    let [one, other] = sides.map(|side| side.map_or_else(|| "nothing".to_owned(), short));
    Some(format!("{}: {one}, {other}", place.join(" > ")))
}

type Sides<'j> = [Option<&'j Json>; 2];

/// Goes down to the first difference; `place` is the way there.
fn descend<'j>(one: &'j Json, other: &'j Json, place: &mut Vec<String>) -> Option<Sides<'j>> {
    let mut step = |name: String, one: Option<&'j Json>, other: Option<&'j Json>| {
        place.push(name);
        let found = match (one, other) {
            (Some(one), Some(other)) => descend(one, other, place),
            (None, None) => None,
            sides => Some([sides.0, sides.1]),
        };
        if found.is_none() {
            place.pop();
        }
        found
    };
    match (one, other) {
        (Json::Object(a), Json::Object(b)) => a
            .keys()
            .chain(b.keys())
            .find_map(|name| step(name.clone(), a.get(name), b.get(name))),
        (Json::Array(a), Json::Array(b)) => (0..a.len().max(b.len())).find_map(|k| {
            let name = [a, b]
                .into_iter()
                .find_map(|side| side.get(k)?["id"].as_str());
            let name = name.map_or_else(|| k.to_string(), str::to_owned);
            step(name, a.get(k), b.get(k))
        }),
        _ => {
            // As text: numbers that are equal but for the sign of zero are not the same bytes.
            let [left, right] = [one, other].map(Json::to_string);
            (left != right).then_some([Some(one), Some(other)])
        }
    }
}

/// A value in a few words.
fn short(value: &Json) -> String {
    const SHOWN: usize = 60;
    let text = value.to_string();
    if text.chars().count() <= SHOWN {
        return text;
    }
    let start: String = text.chars().take(SHOWN).collect();
    format!("{start}...")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parcel::tests::origin;
    use crate::stage::StageOutput;
    use serde_json::json;

    /// A folder with the outputs of these stages, each a list of numbers, by this program.
    fn folder(name: &str, program: &str, outputs: &[(&str, Json)]) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("bristle-{name}-{}", std::process::id()));
        for (stage, numbers) in outputs {
            let mut output = StageOutput::done();
            output
                .artefacts
                .insert("numbers".to_owned(), numbers.clone());
            let parcel = Parcel::pack(stage, &origin(program), &output).unwrap();
            parcel.write(&folder).unwrap();
        }
        folder
    }

    #[test]
    fn what_fits_is_folded_in_the_order_of_the_plan_and_all_else_is_refused() {
        let task = |stage| Task {
            stage,
            origin: origin("one"),
        };
        let plan = [task("gait"), task("envelope")];
        let same = json!([{"id": "speed", "value": 0.5}, 2]);
        let next = json!([{"id": "speed", "value": f64::from_bits(0.5_f64.to_bits() + 1)}, 2]);
        let one = folder(
            "merge-one",
            "one",
            &[("envelope", json!([])), ("gait", same.clone())],
        );
        let twin = folder("merge-twin", "one", &[("gait", same.clone())]);
        let bit = folder("merge-bit", "one", &[("gait", next)]);
        let longer = folder(
            "merge-longer",
            "one",
            &[("gait", json!([{"id": "speed", "value": 0.5}, 2, 3]))],
        );
        let alien = folder("merge-alien", "two", &[("gait", same.clone())]);
        let unknown = folder("merge-unknown", "one", &[("gate", same)]);
        std::fs::write(one.join(costs::FILE), "{}").unwrap();

        let merged = merge(&plan, &[one.clone(), twin.clone()]).unwrap();
        let stages: Vec<&str> = merged.iter().map(|parcel| parcel.stage.as_str()).collect();
        assert_eq!(stages, ["gait", "envelope"]);
        for (folders, words) in [
            (
                vec![&one, &bit],
                "at artefacts > numbers > speed > value: 0.5, 0.5000000000000001",
            ),
            (
                vec![&one, &longer],
                "at artefacts > numbers > 2: nothing, 3",
            ),
            (vec![&one, &alien], "another program made it"),
            (
                vec![&one, &unknown],
                "no stage `gate`; the nearest name is `gait`",
            ),
            (vec![&twin], "no folder holds the output of envelope"),
        ] {
            let folders: Vec<PathBuf> = folders.into_iter().cloned().collect();
            let problem = merge(&plan, &folders).unwrap_err().to_string();
            assert!(problem.contains(words), "{problem}");
        }
        for folder in [one, twin, bit, longer, alien, unknown] {
            std::fs::remove_dir_all(folder).unwrap();
        }
    }
}

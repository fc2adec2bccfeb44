//! A kept output with everything that it depends on: what a stage leaves for a later run, on this machine or another.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::Value as Json;

use crate::cache::Key;
use crate::stage::StageOutput;

/// Form of the files; another one makes all older ones misses.
const SCHEMA: &str = "bristle/kept/1";

/// Everything that an output depends on.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Origin {
    /// Hash of the program: code, libraries, compiler and flags are all in it.
    pub program: String,
    /// Fewer starts and repetitions.
    pub quick: bool,
    /// Hashes of files by path.
    pub inputs: BTreeMap<String, String>,
    /// Keys of the stages whose outputs are read.
    pub needs: BTreeMap<String, String>,
}

impl Origin {
    /// The key of the output of a stage: equal keys mean equal outputs, for a stage reads nothing that it did not declare.
    #[must_use]
    pub fn key(&self, stage: &str) -> String {
        let mut key = Key::new(&self.program);
        key.add("stage", stage);
        key.add("quick", if self.quick { "yes" } else { "no" });
        for (name, hash) in self.inputs.iter().chain(&self.needs) {
            key.add(name, hash);
        }
        key.text()
    }

    /// The first thing in which `other` is not the same, in words; `None` where all is.
    #[must_use]
    pub fn difference(&self, other: &Self) -> Option<String> {
        if self.program != other.program {
            return Some("another program made it (build once and copy the executable, or build the same commit in the same folder with the same compiler)".to_owned());
        }
        if self.quick != other.quick {
            let [made, asked] = [other.quick, self.quick].map(|quick| match quick {
                true => "with --quick",
                false => "without --quick",
            });
            return Some(format!("it was made {made}, the plan is {asked}"));
        }
        let files = first(&self.inputs, &other.inputs).map(|path| format!("input {path}"));
        let stages = || first(&self.needs, &other.needs).map(|id| format!("output of {id}"));
        files
            .or_else(stages)
            .map(|what| format!("it was made from another {what}"))
    }
}

/// The first name whose hash is not the same in both, or that only one of them has.
fn first<'m>(
    one: &'m BTreeMap<String, String>,
    other: &'m BTreeMap<String, String>,
) -> Option<&'m str> {
    one.keys()
        .chain(other.keys())
        .find(|name| one.get(*name) != other.get(*name))
        .map(String::as_str)
}

/// A kept output.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parcel {
    schema: String,
    /// The stage that left it.
    pub stage: String,
    /// Hash of the origin.
    pub key: String,
    /// What it was made from.
    pub origin: Origin,
    /// Hash of the output's text. It finds damage; it is no signature.
    pub digest: String,
    /// The output, as the stage left it.
    pub output: Json,
}

/// Why a file is no kept output.
#[derive(Debug, thiserror::Error)]
#[error("{}: {problem}", path.display())]
pub struct ParcelError {
    path: PathBuf,
    problem: String,
}

/// The name under which an output is kept.
#[must_use]
pub fn file_name(stage: &str, key: &str) -> String {
    format!("{stage}-{}.json", key.get(..32).unwrap_or(key))
}

impl Parcel {
    /// Packs an output.
    ///
    /// # Errors
    /// Where the output has no JSON form.
    pub fn pack(stage: &str, origin: &Origin, output: &StageOutput) -> serde_json::Result<Self> {
        let output = serde_json::to_value(output)?;
        Ok(Self {
            schema: SCHEMA.to_owned(),
            stage: stage.to_owned(),
            key: origin.key(stage),
            origin: origin.clone(),
            digest: digest(&output),
            output,
        })
    }

    /// Reads a kept output and checks that it is whole: its key is that of its origin, its digest that of its output.
    ///
    /// # Errors
    /// Where it is not.
    pub fn read(path: &Path) -> Result<Self, ParcelError> {
        let refuse = |problem: String| ParcelError {
            path: path.to_owned(),
            problem,
        };
        let text = std::fs::read_to_string(path).map_err(|error| refuse(error.to_string()))?;
        let parcel: Self = serde_json::from_str(&text)
            .map_err(|error| refuse(format!("is no kept output of a stage: {error}")))?;
        if parcel.schema != SCHEMA {
            return Err(refuse(format!(
                "has the form {}, not {SCHEMA}",
                parcel.schema
            )));
        }
        if parcel.key != parcel.origin.key(&parcel.stage) {
            return Err(refuse(
                "what it says it was made from was altered: the key is another".to_owned(),
            ));
        }
        if parcel.digest != digest(&parcel.output) {
            return Err(refuse(format!(
                "its output was altered or damaged: the digest is another; compute {} again",
                parcel.stage
            )));
        }
        Ok(parcel)
    }

    /// The output; `None` where it is not one of the present program.
    #[must_use]
    pub fn unpack(self) -> Option<StageOutput> {
        serde_json::from_value(self.output).ok()
    }

    /// Writes it into a folder, whole or not at all.
    ///
    /// # Errors
    /// Where it cannot be written.
    pub fn write(&self, folder: &Path) -> std::io::Result<()> {
        let text = serde_json::to_string(self).map_err(std::io::Error::other)?;
        let path = folder.join(file_name(&self.stage, &self.key));
        campaign::write_atomically(&path, text.as_bytes()).map_err(std::io::Error::other)
    }
}

fn digest(output: &Json) -> String {
    blake3::hash(output.to_string().as_bytes())
        .to_hex()
        .to_string()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// An origin that differs by its program only.
    pub(crate) fn origin(program: &str) -> Origin {
        Origin {
            program: program.to_owned(),
            quick: false,
            inputs: BTreeMap::from([("data/published.toml".to_owned(), "p".to_owned())]),
            needs: BTreeMap::from([("audit".to_owned(), "a".to_owned())]),
        }
    }

    #[test]
    fn every_part_of_the_origin_is_in_the_key_and_is_named() {
        let own = origin("one");
        assert_eq!(own.difference(&own), None);
        let cases = [
            (origin("two"), "another program"),
            (
                Origin {
                    quick: true,
                    ..own.clone()
                },
                "with --quick, the plan is without",
            ),
            (
                Origin {
                    inputs: BTreeMap::new(),
                    ..own.clone()
                },
                "another input data/published.toml",
            ),
            (
                Origin {
                    needs: BTreeMap::from([("audit".to_owned(), "b".to_owned())]),
                    ..own.clone()
                },
                "another output of audit",
            ),
        ];
        for (other, words) in cases {
            assert_ne!(own.key("gait"), other.key("gait"), "{words}");
            let found = own.difference(&other).unwrap();
            assert!(found.contains(words), "{found}");
        }
        assert_ne!(own.key("gait"), own.key("envelope"));
    }

    #[test]
    fn what_was_altered_is_refused_and_what_was_not_comes_back() {
        let folder = std::env::temp_dir().join(format!("bristle-parcel-{}", std::process::id()));
        let mut output = StageOutput::done();
        output
            .artefacts
            .insert("x".to_owned(), serde_json::json!([0.1, -0.0, 1e-300]));
        let parcel = Parcel::pack("gait", &origin("one"), &output).unwrap();
        parcel.write(&folder).unwrap();
        let path = folder.join(file_name("gait", &parcel.key));
        assert_eq!(Parcel::read(&path).unwrap(), parcel);
        let text = std::fs::read_to_string(&path).unwrap();
        for (from, to, words) in [
            ("1e-300", "2e-300", "altered or damaged"),
            ("-0.0", "0.0", "altered or damaged"),
            ("\"quick\":false", "\"quick\":true", "made from was altered"),
            ("bristle/kept/1", "bristle/kept/0", "has the form"),
            ("{", "[", "is no kept output"),
        ] {
            assert!(text.contains(from), "{from}");
            std::fs::write(&path, text.replacen(from, to, 1)).unwrap();
            let problem = Parcel::read(&path).unwrap_err().to_string();
            assert!(problem.contains(words), "{problem}");
        }
        std::fs::remove_dir_all(folder).unwrap();
    }
}

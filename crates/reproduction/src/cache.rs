//! Outputs of stages, kept by the content of what they were made from.
//!
//! A key is the hash of the program itself (its executable: code, libraries, compiler and flags are all in it), of the
//! published numbers, of every campaign, model and earlier stage that the stage declared, and of the options. What a
//! stage did not declare it cannot read, so an equal key means an equal output.

use std::io;
use std::path::{Path, PathBuf};

use crate::engine::Task;
use crate::parcel::{Parcel, file_name};
use crate::stage::{StageError, StageOutput};

/// What a key is made of, in which order; a new number makes all older files misses.
const FORM: &str = "bristle/cache/2";

/// A hash that grows by named parts; each is preceded by its length, so no two lists of parts run into each other.
#[derive(Clone, Debug)]
pub struct Key(blake3::Hasher);

impl Key {
    /// An empty key of this program.
    #[must_use]
    pub fn new(program: &str) -> Self {
        let mut key = Self(blake3::Hasher::new());
        key.add("form", FORM);
        key.add("program", program);
        key
    }

    /// Adds a part.
    pub fn add(&mut self, name: &str, content: &str) {
        for text in [name, content] {
            self.0.update(&(text.len() as u64).to_le_bytes());
            self.0.update(text.as_bytes());
        }
    }

    /// The key as text.
    #[must_use]
    pub fn text(&self) -> String {
        self.0.finalize().to_hex().to_string()
    }
}

/// Hash of the running executable.
///
/// # Errors
/// Where the executable cannot be read.
pub fn program_identity() -> io::Result<String> {
    let bytes = std::fs::read(std::env::current_exe()?)?;
    Ok(blake3::hash(&bytes).to_hex().to_string())
}

/// The folder of kept outputs in an output folder.
#[must_use]
pub fn folder(out: &Path) -> PathBuf {
    out.join(".cache")
}

/// A folder of kept outputs.
#[derive(Clone, Debug)]
pub struct Cache {
    folder: PathBuf,
    newest: usize,
}

impl Cache {
    /// A cache in this folder, which need not be there yet. It keeps the newest few outputs of a stage: switching between
    /// two data sets or options should stay quick.
    #[must_use]
    pub fn new(folder: &Path) -> Self {
        Self {
            folder: folder.to_owned(),
            newest: 4,
        }
    }

    /// A folder that goes to another machine: one output of a stage, the newest.
    #[must_use]
    pub fn portable(folder: &Path) -> Self {
        Self {
            folder: folder.to_owned(),
            newest: 1,
        }
    }

    /// The kept output; a file that cannot be read, is damaged or has another key is a miss, for the stage can always be
    /// run.
    #[must_use]
    pub fn get(&self, task: &Task) -> Option<StageOutput> {
        let key = task.key();
        let parcel = Parcel::read(&self.folder.join(file_name(task.stage, &key))).ok()?;
        if parcel.stage == task.stage && parcel.key == key {
            parcel.unpack()
        } else {
            None
        }
    }

    /// Keeps an output and drops older ones of the same stage, so that the folder does not grow.
    ///
    /// # Errors
    /// Where the file cannot be written.
    pub fn put(&self, task: &Task, output: &StageOutput) -> Result<(), StageError> {
        let parcel = Parcel::pack(task.stage, &task.origin, output);
        self.keep(&parcel.map_err(|error| failed(task.stage, &error))?)
    }

    /// The same for an output that is packed already.
    ///
    /// # Errors
    /// Where the file cannot be written.
    pub fn keep(&self, parcel: &Parcel) -> Result<(), StageError> {
        self.drop_older(&parcel.stage);
        let written = parcel.write(&self.folder);
        written.map_err(|error| failed(&parcel.stage, &error))
    }

    /// Leaves room for one more.
    fn drop_older(&self, stage: &str) {
        let Ok(entries) = std::fs::read_dir(&self.folder) else {
            return;
        };
        let mut files: Vec<_> = entries
            .filter_map(Result::ok)
            .filter(|entry| kept(&entry.file_name().to_string_lossy(), stage))
            .filter_map(|entry| Some((entry.metadata().ok()?.modified().ok()?, entry.path())))
            .collect();
        files.sort();
        let surplus = (files.len() + 1).saturating_sub(self.newest);
        for (_, path) in files.into_iter().take(surplus) {
            // A file that stays is only a little space.
            let _ = std::fs::remove_file(path);
        }
    }
}

fn failed(stage: &str, error: &dyn std::fmt::Display) -> StageError {
    StageError::Failed(format!("the output of {stage} cannot be kept: {error}"))
}

/// Whether a file is a kept output of a stage by its name; other files in a folder are somebody's own.
fn kept(name: &str, stage: &str) -> bool {
    let key = name
        .strip_prefix(stage)
        .and_then(|rest| rest.strip_prefix('-'))
        .and_then(|rest| rest.strip_suffix(".json"));
    key.is_some_and(|key| key.len() == 32 && key.bytes().all(|byte| byte.is_ascii_hexdigit()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parcel::tests::origin;

    #[test]
    fn a_portable_folder_holds_the_newest_output_of_a_stage_and_leaves_other_files_alone() {
        let folder = std::env::temp_dir().join(format!("bristle-cache-{}", std::process::id()));
        let own = folder.join("gait-notes.json");
        campaign::write_atomically(&own, b"mine").unwrap();
        let task = |program| Task {
            stage: "gait",
            origin: origin(program),
        };
        let cache = Cache::portable(&folder);
        for program in ["one", "two"] {
            cache.put(&task(program), &StageOutput::done()).unwrap();
            assert!(cache.get(&task(program)).is_some());
        }
        assert!(cache.get(&task("one")).is_none(), "only the newest is kept");
        assert!(own.is_file());
        std::fs::remove_dir_all(folder).unwrap();
    }
}

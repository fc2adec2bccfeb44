//! Outputs of stages, kept by the content of what they were made from.
//!
//! A key is the hash of the program itself (its executable: code, libraries, compiler and flags are all in it), of the
//! published numbers, of every campaign, model and earlier stage that the stage declared, and of the options. What a
//! stage did not declare it cannot read, so an equal key means an equal output.

use std::io;
use std::path::{Path, PathBuf};

use crate::stage::StageOutput;

/// Form of the cached files; a new number makes all older ones misses.
const FORM: &str = "bristle/cache/1";

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

/// The folder of kept outputs.
#[derive(Clone, Debug)]
pub struct Cache {
    folder: PathBuf,
}

impl Cache {
    /// A cache in this folder, which need not be there yet.
    #[must_use]
    pub fn new(folder: &Path) -> Self {
        Self {
            folder: folder.to_owned(),
        }
    }

    fn path(&self, stage: &str, key: &str) -> PathBuf {
        self.folder.join(format!("{stage}-{}.json", &key[..32]))
    }

    /// The kept output; a file that cannot be read or parsed is a miss, for the stage can always be run.
    #[must_use]
    pub fn get(&self, stage: &str, key: &str) -> Option<StageOutput> {
        let text = std::fs::read_to_string(self.path(stage, key)).ok()?;
        serde_json::from_str(&text).ok()
    }

    /// Keeps an output and drops older ones of the same stage, so that the folder does not grow.
    ///
    /// # Errors
    /// Where the file cannot be written.
    pub fn put(
        &self,
        stage: &str,
        key: &str,
        output: &StageOutput,
    ) -> Result<(), crate::stage::StageError> {
        let failed = |error: &dyn std::fmt::Display| {
            crate::stage::StageError::Failed(format!(
                "the output of {stage} cannot be kept: {error}"
            ))
        };
        let text = serde_json::to_string(output).map_err(|error| failed(&error))?;
        let path = self.path(stage, key);
        self.drop_older(stage);
        campaign::write_atomically(&path, text.as_bytes()).map_err(|error| failed(&error))
    }

    /// Keeps the newest few outputs of a stage: switching between two data sets or options should stay quick.
    fn drop_older(&self, stage: &str) {
        const KEPT: usize = 4;
        let Ok(entries) = std::fs::read_dir(&self.folder) else {
            return;
        };
        let mut files: Vec<_> = entries
            .filter_map(Result::ok)
            .filter(|entry| {
                let name = entry.file_name().to_string_lossy().into_owned();
                name.strip_prefix(stage)
                    .is_some_and(|rest| rest.starts_with('-'))
            })
            .filter_map(|entry| Some((entry.metadata().ok()?.modified().ok()?, entry.path())))
            .collect();
        files.sort();
        let surplus = files.len().saturating_sub(KEPT - 1);
        for (_, path) in files.into_iter().take(surplus) {
            // A file that stays is only a little space.
            let _ = std::fs::remove_file(path);
        }
    }
}

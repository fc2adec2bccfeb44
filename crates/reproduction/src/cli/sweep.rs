//! What runs wrote into an output folder, so that a later run can take away what it no longer writes.
//!
//! The list is all that this program knows to be its own. A file that is not in it, or whose content is no longer what was
//! written, is somebody's and stays. While a run writes, the list names the files of the run before and of this one: a run
//! that is killed halfway leaves nothing that the next one would not know.

use std::collections::BTreeSet;
use std::path::{Component, Path};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::Failure;

/// Name of the list in the output folder.
const FILE: &str = ".written.json";

/// One file as it was written.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub(super) struct Written {
    /// Path relative to the output folder, with forward slashes.
    pub(super) path: String,
    /// SHA-256 of its content, hexadecimal.
    pub(super) sha256: String,
}

/// A folder between the files of earlier runs and those of this one.
pub(super) struct Sweep<'a> {
    out: &'a Path,
    earlier: BTreeSet<Written>,
    now: BTreeSet<Written>,
}

impl<'a> Sweep<'a> {
    /// Notes down which files this run is about to write; nothing is removed yet.
    pub(super) fn begin(
        out: &'a Path,
        now: impl IntoIterator<Item = Written>,
    ) -> Result<Self, Failure> {
        let sweep = Self {
            out,
            earlier: read(out),
            now: now.into_iter().collect(),
        };
        note(out, &sweep.earlier.union(&sweep.now).collect())?;
        Ok(sweep)
    }

    /// Removes what earlier runs wrote and this one did not; gives back the files that stay because somebody altered them.
    pub(super) fn end(self) -> Result<Vec<String>, Failure> {
        let kept: BTreeSet<&str> = self.now.iter().map(|file| file.path.as_str()).collect();
        let mut altered = BTreeSet::new();
        let mut gone = BTreeSet::new();
        let left = |file: &&Written| !kept.contains(file.path.as_str()) && inside(&file.path);
        for file in self.earlier.iter().filter(left) {
            let path = self.out.join(&file.path);
            // Runs write files, never links.
            let ours = path
                .symlink_metadata()
                .is_ok_and(|metadata| metadata.is_file());
            if !ours {
                continue;
            }
            let failed = |error: std::io::Error| {
                Failure::Output(format!(
                    "{}: an earlier run wrote it and this one did not; it cannot be removed ({error}): remove it by hand",
                    path.display()
                ))
            };
            let bytes = std::fs::read(&path).map_err(failed)?;
            if report::hex(&Sha256::digest(&bytes)) == file.sha256 {
                std::fs::remove_file(&path).map_err(failed)?;
                gone.insert(file.path.clone());
            } else {
                altered.insert(file.path.clone());
            }
        }
        note(self.out, &self.now.iter().collect())?;
        // A run that was killed may have left a file in either of two forms.
        Ok(altered.difference(&gone).cloned().collect())
    }
}

/// The list; an output folder without one, or with one that does not read, has nothing that is known to be ours.
fn read(out: &Path) -> BTreeSet<Written> {
    let text = std::fs::read_to_string(out.join(FILE)).unwrap_or_default();
    serde_json::from_str(&text).unwrap_or_default()
}

fn note(out: &Path, files: &BTreeSet<&Written>) -> Result<(), Failure> {
    let text = serde_json::to_string_pretty(files).map_err(Failure::output)?;
    campaign::write_atomically(&out.join(FILE), (text + "\n").as_bytes()).map_err(Failure::output)
}

/// Whether a path stays in the folder whatever somebody made of the list.
fn inside(path: &str) -> bool {
    let mut parts = Path::new(path).components().peekable();
    parts.peek().is_some() && parts.all(|part| matches!(part, Component::Normal(_)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(path: &str, text: &str) -> Written {
        Written {
            path: path.to_owned(),
            sha256: report::hex(&Sha256::digest(text.as_bytes())),
        }
    }

    /// Writes these files as a run would, up to the moment at which it is killed, if it is.
    fn run(out: &Path, files: &[(&str, &str)], killed: bool) -> Vec<String> {
        let list = files.iter().map(|(path, text)| written(path, text));
        let sweep = Sweep::begin(out, list).unwrap();
        for (path, text) in files {
            campaign::write_atomically(&out.join(path), text.as_bytes()).unwrap();
        }
        if killed {
            return Vec::new();
        }
        sweep.end().unwrap()
    }

    fn files(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> = std::fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn only_what_is_known_to_be_ours_goes() {
        let home = tempfile::tempdir().unwrap();
        let (out, tables) = (home.path().join("out"), home.path().join("out/tables"));
        let stranger = home.path().join("stranger.csv");
        std::fs::write(&stranger, "x").unwrap();
        run(
            &out,
            &[
                ("tables/a.csv", "1"),
                ("tables/b.csv", "1"),
                ("tables/c.csv", "1"),
            ],
            false,
        );
        std::fs::write(tables.join("own.csv"), "1").unwrap();
        std::fs::write(tables.join("c.csv"), "my notes").unwrap();
        // A list that somebody made to point elsewhere.
        let mut list = read(&out);
        list.insert(written("../stranger.csv", "x"));
        list.insert(written(stranger.to_str().unwrap(), "x"));
        note(&out, &list.iter().collect()).unwrap();

        let altered = run(&out, &[("tables/a.csv", "2")], false);
        assert_eq!(altered, ["tables/c.csv"]);
        assert_eq!(files(&tables), ["a.csv", "c.csv", "own.csv"]);
        assert!(stranger.is_file());
        // What was altered is theirs from now on: it is said once.
        assert!(run(&out, &[("tables/a.csv", "2")], false).is_empty());
    }

    #[test]
    fn a_run_that_was_killed_leaves_nothing_that_the_next_one_does_not_know() {
        let home = tempfile::tempdir().unwrap();
        let (out, tables) = (home.path().join("out"), home.path().join("out/tables"));
        run(&out, &[("tables/a.csv", "1"), ("tables/b.csv", "1")], false);
        run(&out, &[("tables/b.csv", "2"), ("tables/c.csv", "2")], true);
        assert!(run(&out, &[("tables/d.csv", "3")], false).is_empty());
        assert_eq!(files(&tables), ["d.csv"]);
    }
}

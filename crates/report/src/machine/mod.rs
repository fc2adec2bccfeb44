//! What programs read beside the report: a Workflow Run RO-Crate, a `codecheck.yml` and the in-toto statement of the
//! verdicts. Pure functions from the document and the list of files written to text.

mod codecheck;
mod ro_crate;
mod statement;

pub use codecheck::codecheck;
pub use ro_crate::ro_crate;
pub use statement::{predicate, statement};

use crate::{Document, Verdict};

/// Name of the script that repeats the run; it is the workflow of the RO-Crate.
pub const WORKFLOW: &str = "reproduce.sh";

/// Name of the file that says what lies in the output folder.
pub const README: &str = "README.md";

/// One file of the output folder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OutputFile {
    /// Path relative to the output folder, with forward slashes.
    pub path: String,
    /// Media type, such as `text/html`.
    pub media_type: String,
    /// What it holds, in a sentence.
    pub description: String,
    /// SHA-256 of its content, hexadecimal.
    pub sha256: String,
    /// Its size.
    pub bytes: u64,
}

/// How many claims have each verdict, in words.
fn counted_verdicts(document: &Document) -> String {
    let claims = || document.claims.iter();
    let counts = Verdict::ALL.map(|verdict| {
        let count = claims().filter(|claim| claim.verdict == verdict).count();
        format!("{count} {}", verdict.word())
    });
    counts.join(", ")
}

/// What lies in the output folder, to be written as [`README`] beside `files`.
#[must_use]
pub fn readme(document: &Document, files: &[OutputFile]) -> String {
    let mut text = format!(
        "# {}\n\nMade by `{}` ({}). Open `report.html` in a browser; everything else is for programs.\n\n",
        document.title, document.header.command, document.header.program
    );
    text.push_str("| file | what it holds |\n|---|---|\n");
    for file in files {
        let description = file.description.replace('|', "\\|");
        text.push_str(&format!("| `{}` | {description} |\n", file.path));
    }
    text
}

/// The script that repeats the run from a clone of the repository: to be written as [`WORKFLOW`].
pub fn workflow_script(document: &Document) -> String {
    let mut script = String::from(
        "#!/bin/sh\n# Repeats the run whose results lie beside this file, in a clone of the repository.\nset -e\n",
    );
    let commit = &document.run.commit;
    if !commit.is_empty() && commit.chars().all(|c| c.is_ascii_hexdigit()) {
        script.push_str(&format!("git checkout {commit}\n"));
    }
    if document.run.dirty {
        script.push_str("# The working copy had changes that no commit holds: this script cannot bring them back.\n");
    }
    // A command goes on one line; whatever follows a line break would be another command.
    let command = document.header.command.lines().next().unwrap_or_default();
    script.push_str(command);
    script.push('\n');
    script
}

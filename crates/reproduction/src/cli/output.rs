//! Writing the output folder of a reproduction: tables, figures, results, the page, and what programs read beside it.

use std::path::Path;

use report::machine::{self, OutputFile};
use report::{Block, Document, Run};
use sha2::{Digest, Sha256};

use super::Failure;
use super::sweep::{Sweep, Written};
use crate::results::Results;

/// Files as they are going to lie in the folder.
#[derive(Default)]
struct Folder {
    /// What those that list them say of them.
    files: Vec<OutputFile>,
    /// Their contents, in the same order.
    texts: Vec<String>,
}

impl Folder {
    fn add(&mut self, path: &str, media_type: &str, description: &str, text: String) {
        self.files.push(OutputFile {
            path: path.to_owned(),
            media_type: media_type.to_owned(),
            description: description.to_owned(),
            sha256: report::hex(&Sha256::digest(text.as_bytes())),
            bytes: text.len() as u64,
        });
        self.texts.push(text);
    }

    /// Writes each file whole or not at all, and takes away what an earlier run wrote and this one does not.
    fn write(&self, out: &Path) -> Result<(), Failure> {
        let list = self.files.iter().map(|file| Written {
            path: file.path.clone(),
            sha256: file.sha256.clone(),
        });
        let sweep = Sweep::begin(out, list)?;
        for (file, text) in self.files.iter().zip(&self.texts) {
            campaign::write_atomically(&out.join(&file.path), text.as_bytes())
                .map_err(Failure::output)?;
        }
        for path in sweep.end()? {
            say_aside!(
                "{}: an earlier run wrote it and somebody altered it since; this run does not write it and leaves it there",
                out.join(path).display()
            );
        }
        Ok(())
    }
}

/// Writes everything: first what the page stands on, then the page, then what programs read beside it.
pub(super) fn write(
    out: &Path,
    results: &Results,
    document: &Document,
    run: &Run,
) -> Result<(), Failure> {
    // All of it is made before any of it is written: a page that cannot be rendered leaves the folder as it was.
    let mut folder = Folder::default();
    for stage in &results.stages {
        let Ok(output) = &stage.output else { continue };
        for table in &output.tables {
            let description = format!("table of stage {}", stage.id);
            folder.add(
                &format!("tables/{}.csv", table.name),
                "text/csv",
                &description,
                table.csv.clone(),
            );
        }
    }
    for block in document.sections.iter().flat_map(|section| &section.blocks) {
        let figure = match block {
            Block::Figure(figure) => figure,
            Block::Table(table) => {
                let csv = report::table_file(table, &document.values).map_err(Failure::output)?;
                let path = format!("tables/{}.csv", table.id);
                folder.add(&path, "text/csv", &table.title, csv);
                continue;
            }
            _ => continue,
        };
        let svg = report::figure::svg_file(figure).map_err(Failure::output)?;
        folder.add(
            &format!("figures/{}.svg", figure.id),
            "image/svg+xml",
            &figure.title,
            svg,
        );
        if let Some(csv) = report::figure::csv_file(figure) {
            let description = format!("data of figure {}", figure.id);
            folder.add(
                &format!("tables/{}.csv", figure.id),
                "text/csv",
                &description,
                csv,
            );
        }
    }
    let json =
        serde_json::to_string_pretty(&results.json_with_run(run)).map_err(Failure::output)?;
    folder.add(
        "results.json",
        "application/json",
        "values, claims and stages",
        json + "\n",
    );
    let page = report::render(document).map_err(Failure::output)?;
    folder.add("report.html", "text/html", "the report", page);
    beside(&mut folder, document)?;
    folder.write(out)
}

/// The script that repeats the run, the in-toto statement, `codecheck.yml` and the RO-Crate, which lists all the others.
fn beside(folder: &mut Folder, document: &Document) -> Result<(), Failure> {
    let script = machine::workflow_script(document);
    folder.add(
        machine::WORKFLOW,
        "text/x-shellscript",
        "repeats the run",
        script,
    );
    let predicate = machine::predicate(document).map_err(Failure::output)?;
    folder.add(
        "test-result.json",
        "application/json",
        "verdicts as a test result, for attestation",
        predicate,
    );
    let statement = machine::statement(document, &folder.files).map_err(Failure::output)?;
    folder.add(
        "statement.json",
        "application/vnd.in-toto+json",
        "verdicts as an in-toto statement",
        statement,
    );
    let codecheck = machine::codecheck(document, &folder.files);
    folder.add(
        "codecheck.yml",
        "application/yaml",
        "CODECHECK manifest",
        codecheck,
    );
    let readme = machine::readme(document, &folder.files);
    folder.add(
        machine::README,
        "text/markdown",
        "what lies in this folder",
        readme,
    );
    let crate_text = machine::ro_crate(document, &folder.files).map_err(Failure::output)?;
    folder.add(
        "ro-crate-metadata.json",
        "application/ld+json",
        "Workflow Run RO-Crate",
        crate_text,
    );
    Ok(())
}

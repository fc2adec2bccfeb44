//! Writing the output folder of a reproduction: tables, figures, results, the page, and what programs read beside it.

use std::path::Path;

use report::machine::{self, OutputFile};
use report::{Block, Document, Run};
use sha2::{Digest, Sha256};

use super::Failure;
use crate::results::Results;

/// Files that were written, for those that list them.
struct Folder<'a> {
    out: &'a Path,
    written: Vec<OutputFile>,
}

impl Folder<'_> {
    /// Writes a file whole or not at all.
    fn write(
        &mut self,
        path: &str,
        media_type: &str,
        description: &str,
        text: &str,
    ) -> Result<(), Failure> {
        campaign::write_atomically(&self.out.join(path), text.as_bytes())
            .map_err(Failure::output)?;
        self.written.push(OutputFile {
            path: path.to_owned(),
            media_type: media_type.to_owned(),
            description: description.to_owned(),
            sha256: report::hex(&Sha256::digest(text.as_bytes())),
            bytes: text.len() as u64,
        });
        Ok(())
    }
}

/// Writes everything; the page last, so that a page that is there has everything beside it.
pub(super) fn write(
    out: &Path,
    results: &Results,
    document: &Document,
    run: &Run,
) -> Result<(), Failure> {
    // Rendered first: a page that cannot be rendered leaves the folder as it was.
    let page = report::render(document).map_err(Failure::output)?;
    let mut folder = Folder {
        out,
        written: Vec::new(),
    };
    for stage in &results.stages {
        let Ok(output) = &stage.output else { continue };
        for table in &output.tables {
            let description = format!("table of stage {}", stage.id);
            folder.write(
                &format!("tables/{}.csv", table.name),
                "text/csv",
                &description,
                &table.csv,
            )?;
        }
    }
    for block in document.sections.iter().flat_map(|section| &section.blocks) {
        let figure = match block {
            Block::Figure(figure) => figure,
            Block::Table(table) => {
                let csv = report::table_file(table, &document.values).map_err(Failure::output)?;
                let path = format!("tables/{}.csv", table.id);
                folder.write(&path, "text/csv", &table.title, &csv)?;
                continue;
            }
            _ => continue,
        };
        let svg = report::figure::svg_file(figure).map_err(Failure::output)?;
        folder.write(
            &format!("figures/{}.svg", figure.id),
            "image/svg+xml",
            &figure.title,
            &svg,
        )?;
        if let Some(csv) = report::figure::csv_file(figure) {
            let description = format!("data of figure {}", figure.id);
            folder.write(
                &format!("tables/{}.csv", figure.id),
                "text/csv",
                &description,
                &csv,
            )?;
        }
    }
    let json =
        serde_json::to_string_pretty(&results.json_with_run(run)).map_err(Failure::output)?;
    folder.write(
        "results.json",
        "application/json",
        "values, claims and stages",
        &(json + "\n"),
    )?;
    folder.write("report.html", "text/html", "the report", &page)?;
    beside(&mut folder, document)
}

/// The script that repeats the run, the in-toto statement, `codecheck.yml` and the RO-Crate, which lists all the others.
fn beside(folder: &mut Folder<'_>, document: &Document) -> Result<(), Failure> {
    let script = machine::workflow_script(document);
    folder.write(
        machine::WORKFLOW,
        "text/x-shellscript",
        "repeats the run",
        &script,
    )?;
    let predicate = machine::predicate(document).map_err(Failure::output)?;
    folder.write(
        "test-result.json",
        "application/json",
        "verdicts as a test result, for attestation",
        &predicate,
    )?;
    let statement = machine::statement(document, &folder.written).map_err(Failure::output)?;
    folder.write(
        "statement.json",
        "application/vnd.in-toto+json",
        "verdicts as an in-toto statement",
        &statement,
    )?;
    let codecheck = machine::codecheck(document, &folder.written);
    folder.write(
        "codecheck.yml",
        "application/yaml",
        "CODECHECK manifest",
        &codecheck,
    )?;
    let readme = machine::readme(document, &folder.written);
    folder.write(
        machine::README,
        "text/markdown",
        "what lies in this folder",
        &readme,
    )?;
    let crate_text = machine::ro_crate(document, &folder.written).map_err(Failure::output)?;
    folder.write(
        "ro-crate-metadata.json",
        "application/ld+json",
        "Workflow Run RO-Crate",
        &crate_text,
    )
}

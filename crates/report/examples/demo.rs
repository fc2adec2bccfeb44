//! Writes the demonstration document into the folder given, with what programs read beside it: to look at, and to try
//! validators on.

#[path = "../tests/demo/mod.rs"]
mod demo;

use report::machine;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::path::PathBuf::from(std::env::args().nth(1).ok_or("usage: demo FOLDER")?);
    std::fs::create_dir_all(&folder)?;
    let document = demo::document();
    let mut files = Vec::new();
    for (path, media_type, text) in [
        ("report.html", "text/html", report::render(&document)?),
        (
            machine::WORKFLOW,
            "text/x-shellscript",
            machine::workflow_script(&document),
        ),
    ] {
        std::fs::write(folder.join(path), &text)?;
        files.push(machine::OutputFile {
            path: path.into(),
            media_type: media_type.into(),
            description: format!("The file {path}."),
            sha256: "00".repeat(32),
            bytes: text.len() as u64,
        });
    }
    std::fs::write(
        folder.join("ro-crate-metadata.json"),
        machine::ro_crate(&document, &files)?,
    )?;
    std::fs::write(
        folder.join("codecheck.yml"),
        machine::codecheck(&document, &files),
    )?;
    std::fs::write(
        folder.join("test-result.json"),
        machine::predicate(&document)?,
    )?;
    Ok(())
}

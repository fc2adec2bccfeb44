//! `codecheck.yml`: the manifest that a human code checker works through (<https://codecheck.org.uk/spec/config/1.0/>).

use super::{OutputFile, counted_verdicts};
use crate::Document;

/// The manifest: files with what they hold, and the paper. Who checked and when is left to the person who does.
pub fn codecheck(document: &Document, files: &[OutputFile]) -> String {
    let mut out = String::from("---\nversion: https://codecheck.org.uk/spec/config/1.0/\n");
    if let Some(repository) = &document.header.repository {
        out.push_str(&format!("source: {}\n", quoted(repository)));
    }
    out.push_str("manifest:\n");
    for file in files {
        out.push_str(&format!(
            "  - file: {}\n    comment: {}\n",
            quoted(&file.path),
            quoted(&file.description)
        ));
    }
    out.push_str("paper:\n");
    out.push_str(&format!(
        "  title: {}\n",
        quoted(&document.subject.reference)
    ));
    if let Some(doi) = &document.subject.doi {
        out.push_str(&format!(
            "  reference: {}\n",
            quoted(&format!("https://doi.org/{doi}"))
        ));
    }
    out.push_str(&format!("summary: {}\n", quoted(&summary(document))));
    out
}

fn summary(document: &Document) -> String {
    let claims = document.claims.len();
    format!("{claims} claims: {}.", counted_verdicts(document))
}

/// A double-quoted YAML scalar, which is a JSON string.
fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

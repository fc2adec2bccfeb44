//! The verdicts as an in-toto statement with the predicate *test result* (type URI
//! `https://in-toto.io/attestation/test-result/v0.1`), for attestation.
//!
//! Each claim is a test: *reproduced* and *consistent* passed, *not testable* and *not run* warned, *differs* and
//! *contradicted* failed. A failed test is a finding about the paper, not a fault of the run.

use serde_json::{Value, json};

use super::OutputFile;
use crate::{Document, Error, Verdict, identity};

/// The predicate alone, as `actions/attest` wants it.
///
/// # Errors
/// [`Error::Json`] where it cannot be written.
pub fn predicate(document: &Document) -> Result<String, Error> {
    Ok(serde_json::to_string_pretty(&predicate_value(document))? + "\n")
}

/// The whole statement about these files.
///
/// # Errors
/// [`Error::Json`] where it cannot be written.
pub fn statement(document: &Document, files: &[OutputFile]) -> Result<String, Error> {
    let subject: Vec<Value> = files
        .iter()
        .map(|file| json!({ "name": file.path, "digest": { "sha256": file.sha256 } }))
        .collect();
    let statement = json!({
        "_type": "https://in-toto.io/Statement/v1",
        "subject": subject,
        "predicateType": "https://in-toto.io/attestation/test-result/v0.1",
        "predicate": predicate_value(document),
    });
    Ok(serde_json::to_string_pretty(&statement)? + "\n")
}

fn predicate_value(document: &Document) -> Value {
    let named = |verdicts: &[Verdict]| -> Vec<String> {
        document
            .claims
            .iter()
            .filter(|claim| verdicts.contains(&claim.verdict))
            .map(|claim| format!("{} {}", claim.id, claim.verdict.word()))
            .collect()
    };
    let passed = named(&[Verdict::Reproduced, Verdict::Consistent]);
    let warned = named(&[Verdict::NotTestable, Verdict::NotRun]);
    let failed = named(&[Verdict::Differs, Verdict::Contradicted]);
    let result = if !failed.is_empty() {
        "FAILED"
    } else if !warned.is_empty() {
        "WARNED"
    } else {
        "PASSED"
    };
    let mut configuration: Vec<Value> = document
        .header
        .inputs
        .iter()
        .map(|input| {
            let (algorithm, digest) = input
                .hash
                .split_once(':')
                .unwrap_or(("blake3", &input.hash));
            json!({ "name": input.path, "digest": { algorithm: digest } })
        })
        .collect();
    configuration
        .push(json!({ "name": "results", "digest": { "sha256": identity(&document.results) } }));
    json!({
        "result": result,
        "configuration": configuration,
        "passedTests": passed,
        "warnedTests": warned,
        "failedTests": failed,
    })
}

//! The run as a Workflow Run RO-Crate 0.5 (<https://w3id.org/ro/wfrun/workflow/0.5>): what was run, by what, from what,
//! and what came out. Written into the output folder as `ro-crate-metadata.json`.

use serde_json::{Value, json};

use super::{OutputFile, README, WORKFLOW, counted_verdicts};
use crate::{Document, Error, identity};

const PROFILES: [(&str, &str, &str); 3] = [
    (
        "https://w3id.org/ro/wfrun/process/0.5",
        "Process Run Crate",
        "0.5",
    ),
    (
        "https://w3id.org/ro/wfrun/workflow/0.5",
        "Workflow Run Crate",
        "0.5",
    ),
    (
        "https://w3id.org/workflowhub/workflow-ro-crate/1.0",
        "Workflow RO-Crate",
        "1.0",
    ),
];
const BIOSCHEMAS: &str = "https://bioschemas.org/profiles/ComputationalWorkflow/1.0-RELEASE";
const AUTHORS: &str = "#authors";
const LICENSE: &str = "https://spdx.org/licenses/MIT";

/// The metadata of the crate. `files` are all files of the folder, [`WORKFLOW`] among them, without the metadata itself.
///
/// # Errors
/// [`Error::Json`] where it cannot be written.
pub fn ro_crate(document: &Document, files: &[OutputFile]) -> Result<String, Error> {
    let mut graph = vec![
        json!({
            "@id": "ro-crate-metadata.json",
            "@type": "CreativeWork",
            "conformsTo": [
                { "@id": "https://w3id.org/ro/crate/1.1" },
                { "@id": "https://w3id.org/workflowhub/workflow-ro-crate/1.0" },
            ],
            "about": { "@id": "./" },
        }),
        root(document, files),
    ];
    graph.extend(PROFILES.iter().map(|(id, name, version)| {
        json!({ "@id": id, "@type": "CreativeWork", "name": name, "version": version })
    }));
    graph.push(json!({
        "@id": BIOSCHEMAS, "@type": "CreativeWork", "name": "Bioschemas ComputationalWorkflow", "version": "1.0",
    }));
    graph.push(json!({
        "@id": LICENSE, "@type": "CreativeWork", "name": "MIT License",
        "identifier": "https://spdx.org/licenses/MIT", "url": "https://opensource.org/license/mit",
    }));
    graph.extend(workflow(document));
    graph.extend(action(document, files));
    graph.extend(
        files
            .iter()
            .filter(|file| file.path != WORKFLOW)
            .map(file_entity),
    );
    graph.extend(document.header.inputs.iter().map(|input| {
        json!({
            "@id": input_id(&input.path),
            "@type": "PropertyValue",
            "name": input.path,
            "description": input.kind,
            "value": input.hash,
            "exampleOfWork": { "@id": parameter_id(&input.path) },
        })
    }));
    if let Some(doi) = &document.subject.doi {
        graph.push(json!({
            "@id": format!("https://doi.org/{doi}"),
            "@type": "ScholarlyArticle",
            "name": document.subject.reference,
        }));
    }
    let metadata = json!({
        "@context": ["https://w3id.org/ro/crate/1.1/context", "https://w3id.org/ro/terms/workflow-run/context"],
        "@graph": graph,
    });
    Ok(serde_json::to_string_pretty(&metadata)? + "\n")
}

fn root(document: &Document, files: &[OutputFile]) -> Value {
    let profiles: Vec<Value> = PROFILES
        .iter()
        .map(|(id, ..)| json!({ "@id": id }))
        .collect();
    let parts: Vec<Value> = files
        .iter()
        .map(|file| json!({ "@id": file_id(&file.path) }))
        .collect();
    let mut root = json!({
        "@id": "./",
        "@type": "Dataset",
        "name": document.title,
        "description": description(document),
        "datePublished": date(document),
        "license": { "@id": LICENSE },
        "conformsTo": profiles,
        "hasPart": one_or_many(parts),
        "mainEntity": { "@id": WORKFLOW },
        "mentions": { "@id": "#run" },
        "author": { "@id": AUTHORS },
        "publisher": { "@id": AUTHORS },
        "identifier": format!("sha256:{}", identity(&document.results)),
    });
    if let Some(doi) = &document.subject.doi {
        root["citation"] = json!({ "@id": format!("https://doi.org/{doi}") });
    }
    root
}

/// One value stands alone, several in a list: what the specification of RO-Crate recommends.
fn one_or_many(mut values: Vec<Value>) -> Value {
    if values.len() == 1 {
        values.remove(0)
    } else {
        Value::from(values)
    }
}

fn description(document: &Document) -> String {
    format!(
        "Reproduction and audit of a paper; verdicts: {}.",
        counted_verdicts(document)
    )
}

/// The day of the run; where it is not known, the first day that any calendar agrees on.
fn date(document: &Document) -> String {
    let day: String = document.run.started.chars().take(10).collect();
    if day.len() == 10 {
        day
    } else {
        "1970-01-01".into()
    }
}

/// The script that was run, its language and the program behind it.
fn workflow(document: &Document) -> Vec<Value> {
    let inputs: Vec<Value> = document
        .header
        .inputs
        .iter()
        .map(|input| json!({ "@id": parameter_id(&input.path) }))
        .collect();
    let mut out = vec![
        json!({
            "@id": WORKFLOW,
            "@type": ["File", "SoftwareSourceCode", "ComputationalWorkflow"],
            "name": document.header.command,
            "description": "Repeats the run from a clone of the repository.",
            "programmingLanguage": { "@id": "#sh" },
            "encodingFormat": "text/x-shellscript",
            "license": { "@id": LICENSE },
            "version": document.run.commit,
            "input": one_or_many(inputs),
            "output": { "@id": "#output-report" },
            "hasPart": { "@id": "#program" },
            "conformsTo": { "@id": BIOSCHEMAS },
        }),
        json!({ "@id": "#sh", "@type": "ComputerLanguage", "name": "POSIX shell", "alternateName": "sh", "url": "https://pubs.opengroup.org/onlinepubs/9699919799/utilities/sh.html" }),
        json!({
            "@id": "#program",
            "@type": "SoftwareApplication",
            "name": document.header.program,
            "softwareVersion": document.run.commit,
            "softwareRequirements": document.run.rustc,
            "operatingSystem": document.run.target,
        }),
        json!({
            "@id": "#output-report",
            "@type": "FormalParameter",
            "additionalType": "File",
            "name": "report",
            "description": "The audit as one HTML file.",
            "workExample": { "@id": "report.html" },
        }),
    ];
    for application in [0, 2] {
        link(&mut out[application], document);
    }
    out.extend(document.header.inputs.iter().map(|input| {
        json!({
            "@id": parameter_id(&input.path),
            "@type": "FormalParameter",
            "additionalType": "PropertyValue",
            "name": input.path,
            "workExample": { "@id": input_id(&input.path) },
        })
    }));
    out
}

/// What happened: the run of the workflow.
fn action(document: &Document, files: &[OutputFile]) -> Vec<Value> {
    let results: Vec<Value> = files
        .iter()
        .filter(|file| file.path != WORKFLOW)
        .map(|file| json!({ "@id": file_id(&file.path) }))
        .collect();
    let objects: Vec<Value> = document
        .header
        .inputs
        .iter()
        .map(|input| json!({ "@id": input_id(&input.path) }))
        .collect();
    let mut action = json!({
        "@id": "#run",
        "@type": "CreateAction",
        "name": document.header.command,
        "description": document.header.command,
        "instrument": { "@id": WORKFLOW },
        "object": one_or_many(objects),
        "result": one_or_many(results),
        "agent": { "@id": AUTHORS },
        "actionStatus": "http://schema.org/CompletedActionStatus",
    });
    if !document.run.started.is_empty() {
        action["startTime"] = json!(with_offset(&document.run.started));
    }
    if !document.run.finished.is_empty() {
        action["endTime"] = json!(with_offset(&document.run.finished));
    }
    let mut authors =
        json!({ "@id": AUTHORS, "@type": "Organization", "name": "The Bristle authors" });
    link(&mut authors, document);
    vec![action, authors]
}

/// The profile asks for times with an offset in digits.
fn with_offset(time: &str) -> String {
    time.strip_suffix('Z')
        .map_or_else(|| time.to_owned(), |time| format!("{time}+00:00"))
}

/// The public address of the repository, where it is known, as the `url` of an entity.
fn link(entity: &mut Value, document: &Document) {
    if let Some(repository) = &document.header.repository {
        entity["url"] = json!(repository);
    }
}

fn file_entity(file: &OutputFile) -> Value {
    let mut entity = json!({
        "@id": file_id(&file.path),
        "@type": "File",
        "name": file.path,
        "description": file.description,
        "encodingFormat": file.media_type,
        "contentSize": file.bytes.to_string(),
        "sha256": file.sha256,
    });
    if file.path == "report.html" {
        entity["exampleOfWork"] = json!({ "@id": "#output-report" });
    }
    if file.path == README {
        entity["about"] = json!({ "@id": "./" });
    }
    entity
}

/// A path as an identifier: what a URI may not hold is written as %XX.
fn file_id(path: &str) -> String {
    percent(path)
}

fn input_id(path: &str) -> String {
    format!("#input-{}", percent(path))
}

fn parameter_id(path: &str) -> String {
    format!("#parameter-{}", percent(path))
}

fn percent(path: &str) -> String {
    path.bytes()
        .map(|byte| match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'/' | b'.' | b'-' | b'_' => {
                char::from(byte).to_string()
            }
            other => format!("%{other:02X}"),
        })
        .collect()
}

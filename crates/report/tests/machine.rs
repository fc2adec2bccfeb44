//! What programs read beside the report.

mod demo;

use report::machine::{
    OutputFile, WORKFLOW, codecheck, predicate, ro_crate, statement, workflow_script,
};

fn files() -> Vec<OutputFile> {
    [
        (WORKFLOW, "text/x-shellscript"),
        ("report.html", "text/html"),
        ("results.json", "application/json"),
        ("figures/fig with space.svg", "image/svg+xml"),
    ]
    .into_iter()
    .map(|(path, media_type)| OutputFile {
        path: path.into(),
        media_type: media_type.into(),
        description: format!("{path}: \"a\" file"),
        sha256: "00".repeat(32),
        bytes: 10,
    })
    .collect()
}

#[test]
fn the_crate_refers_only_to_what_it_describes() {
    let text = ro_crate(&demo::document(), &files()).expect("written");
    let metadata: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let graph = metadata["@graph"].as_array().expect("a graph");
    let ids: Vec<&str> = graph
        .iter()
        .filter_map(|entity| entity["@id"].as_str())
        .collect();
    let mut unique = ids.clone();
    unique.sort_unstable();
    unique.dedup();
    assert_eq!(ids.len(), unique.len());
    fn references<'v>(value: &'v serde_json::Value, top: bool, out: &mut Vec<&'v str>) {
        match value {
            serde_json::Value::Array(items) => {
                items.iter().for_each(|item| references(item, false, out))
            }
            serde_json::Value::Object(map) => {
                if !top && map.len() == 1 {
                    out.extend(map.get("@id").and_then(|id| id.as_str()));
                }
                map.values().for_each(|item| references(item, false, out));
            }
            _ => {}
        }
    }
    let mut wanted = Vec::new();
    graph
        .iter()
        .for_each(|entity| references(entity, true, &mut wanted));
    for id in wanted {
        assert!(
            ids.contains(&id)
                || id == "https://w3id.org/ro/crate/1.1"
                || id.starts_with("http://schema.org/"),
            "{id} is not described"
        );
    }
    assert!(ids.contains(&"figures/fig%20with%20space.svg"));
}

#[test]
fn every_claim_is_in_the_predicate_once() {
    let document = demo::document();
    let read: serde_json::Value =
        serde_json::from_str(&predicate(&document).expect("written")).expect("JSON");
    let count = |key: &str| read[key].as_array().map_or(0, Vec::len);
    assert_eq!(count("passedTests"), 2);
    assert_eq!(count("warnedTests"), 2);
    assert_eq!(count("failedTests"), 2);
    assert_eq!(read["result"], "FAILED");
    let whole: serde_json::Value =
        serde_json::from_str(&statement(&document, &files()).expect("written")).expect("JSON");
    assert_eq!(whole["predicate"], read);
    assert_eq!(whole["subject"].as_array().map_or(0, Vec::len), 4);
}

#[test]
fn the_manifest_and_the_script_hold_hostile_words_as_text() {
    let mut document = demo::document();
    let manifest = codecheck(&document, &files());
    assert_eq!(manifest.matches("- file: ").count(), 4);
    assert!(manifest.contains("comment: \"report.html: \\\"a\\\" file\""));
    document.header.command = "cargo xtask reproduce\nrm -rf .".into();
    document.run.commit = "0123; echo".into();
    let script = workflow_script(&document);
    assert!(
        !script.contains("rm -rf") && !script.contains("echo"),
        "{script}"
    );
}

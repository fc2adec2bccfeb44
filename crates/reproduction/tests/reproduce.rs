//! The main job: verdicts as pinned, the same bytes from any number of threads, the comparison with an earlier report.

mod program;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use program::{Answer, run};
use reproduction::claims;
use reproduction::judgements::{Facts, judge};
use reproduction::published::Published;
use reproduction::{Value, Verdict};
use tempfile::TempDir;

/// One whole reproduction, shared by the tests; its stages are kept from one test run to the next by content.
fn whole() -> &'static (PathBuf, Answer) {
    static WHOLE: OnceLock<(PathBuf, Answer)> = OnceLock::new();
    WHOLE.get_or_init(|| {
        let out = Path::new(env!("CARGO_TARGET_TMPDIR")).join("reproduction");
        let answer = run(&["reproduce", "--out", out.to_str().unwrap()]);
        (out, answer)
    })
}

#[test]
fn verdicts_and_values_are_as_pinned() {
    let (out, answer) = whole();
    assert_eq!(answer.code, 0, "{}\n{}", answer.stdout, answer.stderr);
    assert_eq!(
        answer.stdout.lines().count(),
        5,
        "five lines: {}",
        answer.stdout
    );
    for file in [
        "report.html",
        "results.json",
        "ro-crate-metadata.json",
        "codecheck.yml",
        "test-result.json",
    ] {
        assert!(out.join(file).is_file(), "{file}");
    }
    let results: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(out.join("results.json")).unwrap()).unwrap();
    assert_eq!(results["claims"].as_array().unwrap().len(), 22);
    let not_run = results["claims"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|claim| claim["verdict"] == "not run")
        .count();
    assert_eq!(not_run, 0, "every claim was run");
    checklist(&fs::read_to_string(out.join("report.html")).unwrap());
}

/// The reviewer's checklist says what this run knows, and leaves to the reviewer what it does not.
fn checklist(page: &str) {
    let answer = |question: &str| -> String {
        let (_, rest) = page.split_once(question).expect(question);
        let (_, rest) = rest.split_once("</span> ").unwrap();
        let (_, rest) = rest.split_once("</span> ").unwrap();
        rest.split_once("</span>").unwrap().0.to_owned()
    };
    assert_eq!(answer("Does it run to its end?"), "yes");
    assert_eq!(answer("Can the check fail?"), "yes");
    assert_eq!(
        answer("Is everything there that the results were made from?"),
        "partly"
    );
    assert_eq!(answer("Do the results agree with the paper?"), "partly");
    assert_eq!(answer("Do two runs give the same bytes?"), "yours to say");
    assert_eq!(
        answer("Did somebody else run it, and do the outputs match?"),
        "yours to say"
    );
}

#[test]
fn a_second_run_keeps_everything_and_changes_nothing() {
    // In a copy: a report that was compared with another says so, and other tests read the one without.
    let (whole, _) = whole();
    let home = TempDir::new().unwrap();
    let out = &home.path().join("reproduction");
    copy(whole, out);
    let before = stable(out);
    let page = out.join("report.html");
    let again = run(&[
        "reproduce",
        "--out",
        out.to_str().unwrap(),
        "--against",
        page.to_str().unwrap(),
    ]);
    assert!(
        again
            .stdout
            .starts_with("against report.html: nothing changed"),
        "{}",
        again.stdout
    );
    let fresh = again
        .stderr
        .lines()
        .filter(|line| line.contains(" s ") && !line.contains("(kept)"))
        .count();
    assert_eq!(fresh, 0, "{}", again.stderr);
    let after = stable(out);
    for (path, text) in before
        .iter()
        .filter(|(path, _)| path.as_str() != "report.html")
    {
        assert_eq!(Some(text), after.get(path), "{path}");
    }
}

/// Outputs of the dear stages in one folder, of the cheap ones computed from them in another: the report is the same.
#[test]
fn a_folder_that_goes_on_from_another_one_merges_to_the_same_report() {
    let (whole, answer) = whole();
    let home = TempDir::new().unwrap();
    let [dear, cheap, out] = ["dear", "cheap", "out"].map(|name| home.path().join(name));
    let plan: serde_json::Value = serde_json::from_str(&run(&["plan"]).stdout).unwrap();
    for task in plan["include"].as_array().unwrap() {
        let (stage, key) = (
            task["stage"].as_str().unwrap(),
            task["key"].as_str().unwrap(),
        );
        let name = reproduction::parcel::file_name(stage, key);
        let folders: &[&PathBuf] = match stage {
            "audit" | "identification" => &[&dear, &cheap],
            "gait" | "diagnosis" => &[&dear],
            _ => &[],
        };
        for folder in folders {
            fs::create_dir_all(folder).unwrap();
            fs::copy(whole.join(".cache").join(&name), folder.join(&name)).unwrap();
        }
    }
    let [dear, cheap, out] = [&dear, &cheap, &out].map(|folder| folder.to_str().unwrap());
    let ran = run(&[
        "run-task",
        "validation",
        "materials",
        "envelope",
        "--out",
        cheap,
    ]);
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    let there = ran
        .stdout
        .lines()
        .filter(|line| line.ends_with("(was there)"));
    assert_eq!(there.count(), 2, "audit and identification: {}", ran.stdout);
    let like = whole.to_str().unwrap();
    let merged = run(&["merge", dear, cheap, "--out", out, "--like", like]);
    assert_eq!(merged.code, answer.code, "{}", merged.stderr);
    assert!(
        merged
            .stdout
            .contains("like      results, tables, figures and page are equal"),
        "{}",
        merged.stdout
    );
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap().map(Result::unwrap) {
        let target = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy(&entry.path(), &target);
        } else {
            fs::copy(entry.path(), target).unwrap();
        }
    }
}

/// Files of an output folder without volatile facts.
fn stable(out: &Path) -> BTreeMap<String, String> {
    let mut files = BTreeMap::new();
    for part in ["", "tables", "figures"] {
        let Ok(entries) = fs::read_dir(out.join(part)) else {
            continue;
        };
        for entry in entries
            .map(Result::unwrap)
            .filter(|entry| entry.path().is_file())
        {
            let name = format!("{part}/{}", entry.file_name().to_string_lossy())
                .trim_start_matches('/')
                .to_owned();
            let text = fs::read_to_string(entry.path()).unwrap();
            let text = match name.as_str() {
                "results.json" => {
                    let mut json: serde_json::Value = serde_json::from_str(&text).unwrap();
                    json.as_object_mut().unwrap().remove("run");
                    json.to_string()
                }
                "report.html" => without_run(&text),
                _ if part.is_empty() => continue,
                _ => text,
            };
            files.insert(name, text);
        }
    }
    files
}

/// The page without its one block of volatile facts.
fn without_run(page: &str) -> String {
    let start = page
        .find("<!-- volatile:begin -->")
        .expect("the block is marked");
    let end = page.find("<!-- volatile:end -->").expect("the block ends");
    format!("{}{}", &page[..start], &page[end..])
}

#[test]
fn one_thread_and_two_give_the_same_bytes() {
    let folder = TempDir::new().unwrap();
    let outs = ["1", "2"].map(|threads| {
        let out = folder.path().join(threads);
        let answer = run(&[
            "reproduce",
            "--quick",
            "--threads",
            threads,
            "--out",
            out.to_str().unwrap(),
        ]);
        assert!(answer.code == 0 || answer.code == 1, "{answer:?}");
        stable(&out)
    });
    assert!(!outs[0].is_empty());
    for (path, text) in &outs[0] {
        assert!(
            outs[1].get(path) == Some(text),
            "{path} depends on the number of threads"
        );
    }
    assert_eq!(outs[0].len(), outs[1].len());
}

/// The page with one number replaced in the results that it embeds; verdicts stay as they are.
fn altered(out: &Path, id: &str, number: f64) -> String {
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    let json: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(out.join("results.json")).unwrap()).unwrap();
    let values = json["values"].as_array().unwrap();
    let value = values.iter().find(|value| value["id"] == id).unwrap();
    let mut other = value.clone();
    other["value"] = serde_json::json!(number);
    assert!(
        page.contains(&value.to_string()),
        "the page embeds its results"
    );
    page.replacen(&value.to_string(), &other.to_string(), 1)
}

#[test]
fn against_a_report_with_one_altered_value_names_it_and_what_it_flips() {
    let (out, _) = whole();
    let folder = TempDir::new().unwrap();
    let copy = folder.path().join("out");
    // What was computed once is there for every comparison.
    fs::create_dir_all(copy.join(".cache")).unwrap();
    for entry in fs::read_dir(out.join(".cache")).unwrap() {
        let entry = entry.unwrap();
        fs::copy(entry.path(), copy.join(".cache").join(entry.file_name())).unwrap();
    }
    for (id, number, flips) in [
        ("audit.brushes_missing", 0.0, "flips C16"),
        ("gait.gain", 15.0, "flips C22"),
        ("envelope.gain.pitch0", 5.0, "flips C22"),
    ] {
        let old = folder.path().join("old.html");
        fs::write(&old, altered(out, id, number)).unwrap();
        let answer = run(&[
            "reproduce",
            "--out",
            copy.to_str().unwrap(),
            "--against",
            old.to_str().unwrap(),
        ]);
        let said = &answer.stdout;
        assert!(said.contains(": 1 value changed"), "{said}");
        assert!(said.contains(&format!("  {id}: {number} -> ")), "{said}");
        assert!(said.contains(flips), "{said}");
    }
    // A report of another target with a difference within the tolerance of its quantity.
    let results = fs::read_to_string(out.join("results.json")).unwrap();
    let results: serde_json::Value = serde_json::from_str(&results).unwrap();
    let values = results["values"].as_array().unwrap();
    let gain = values
        .iter()
        .find(|value| value["id"] == "gait.gain")
        .unwrap();
    let moved = gain["value"].as_f64().unwrap() * (1.0 + 1e-6);
    let target = format!("\"target\":{}", results["run"]["target"]);
    let page = altered(out, "gait.gain", moved);
    assert!(page.contains(&target), "the page says where it was made");
    let old = folder.path().join("old.html");
    for (page, class) in [
        (
            page.replacen(&target, "\"target\":\"riscv64\"", 1),
            ", platform",
        ),
        (page, ", algorithm"),
    ] {
        fs::write(&old, page).unwrap();
        let (copy, old) = (copy.to_str().unwrap(), old.to_str().unwrap());
        let answer = run(&["reproduce", "--out", copy, "--against", old]);
        let said = answer
            .stdout
            .lines()
            .find(|line| line.contains("gait.gain"));
        assert!(
            said.is_some_and(|line| line.ends_with(class)),
            "{}",
            answer.stdout
        );
    }
}

/// Altering one number in published.toml flips exactly its claims: none that does not list it, whatever the number.
#[test]
fn a_published_number_moves_only_the_claims_that_list_it() {
    let (out, _) = whole();
    let root = program::root();
    let published = Published::read(&root.join("data/published.toml")).unwrap();
    let claims = claims::read(&root.join("data/claims.toml")).unwrap();
    let json: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(out.join("results.json")).unwrap()).unwrap();
    let values: Vec<Value> = serde_json::from_value(json["values"].clone()).unwrap();
    let values: BTreeMap<String, Value> = values
        .into_iter()
        .map(|value| (value.id.clone(), value))
        .collect();
    let verdicts =
        |published: &Published, values: &BTreeMap<String, Value>| -> BTreeMap<String, Verdict> {
            let facts = Facts { published, values };
            claims
                .iter()
                .map(|claim| (claim.id.clone(), judge(claim, &facts).unwrap().verdict))
                .collect()
        };
    let before = verdicts(&published, &values);
    let mut moved = 0;
    let mut unlisted = Vec::new();
    for (id, number) in published.iter() {
        for factor in [0.5, 2.0] {
            let altered = published
                .altered(id, &format!("{:.6}", factor * number.value))
                .unwrap();
            let mut found = values.clone();
            found.extend(reproduction::controls::audited(&altered).unwrap());
            let after = verdicts(&altered, &found);
            for claim in &claims {
                if before[&claim.id] != after[&claim.id] {
                    moved += 1;
                    if !claim.published.iter().any(|listed| listed == id) {
                        unlisted.push(format!("{id} x {factor} moved {}", claim.id));
                    }
                }
            }
        }
    }
    assert!(unlisted.is_empty(), "not listed: {unlisted:#?}");
    assert!(
        moved >= 20,
        "the ledger reacts to what is printed: {moved} moves"
    );
}

//! A reproduction split over folders, as machines would, and put together again.

mod program;

use std::fs;
use std::path::{Path, PathBuf};

use program::{Answer, run};
use reproduction::parcel::Parcel;
use serde_json::Value as Json;
use tempfile::TempDir;

/// Runs the program on folders.
fn on(words: &[&str], folders: &[&Path]) -> Answer {
    let folders = folders.iter().map(|folder| folder.to_str().unwrap());
    run(&words.iter().copied().chain(folders).collect::<Vec<_>>())
}

/// The kept output of a stage.
fn kept(folder: &Path, stage: &str) -> PathBuf {
    let entries = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path());
    let named = |path: &PathBuf| {
        let name = path.file_name().unwrap().to_str().unwrap();
        name.starts_with(&format!("{stage}-"))
    };
    let found: Vec<PathBuf> = entries.filter(named).collect();
    assert_eq!(found.len(), 1, "{stage} in {}", folder.display());
    found[0].clone()
}

/// What either folder's stage and the merge are asked for.
const STAGES: [&str; 4] = ["--stage", "audit", "--stage", "envelope"];

/// Two folders give the report of one process byte for byte. What was altered, what two machines computed differently, what
/// is missing and what was made otherwise is refused.
#[test]
fn two_folders_make_the_report_of_one_process() {
    let home = TempDir::new().unwrap();
    let [one, left, right, out] =
        ["one", "left", "right", "out"].map(|name| home.path().join(name));
    let single = on(&[&["reproduce"], &STAGES[..], &["--out"]].concat(), &[&one]);
    assert_eq!(single.code, 0, "{}", single.stderr);

    let plan = run(&[&["plan"], &STAGES[..]].concat());
    assert_eq!(plan.code, 0, "{}", plan.stderr);
    let plan: Json = serde_json::from_str(&plan.stdout).unwrap();
    let tasks = plan["include"].as_array().unwrap();
    let stages: Vec<&str> = tasks
        .iter()
        .map(|task| task["stage"].as_str().unwrap())
        .collect();
    assert_eq!(stages, ["audit", "envelope"]);
    // The audit by both, so that two outputs meet.
    for (task, folders) in tasks.iter().zip([vec![&left, &right], vec![&right]]) {
        let stage = task["stage"].as_str().unwrap();
        for folder in folders {
            let answer = on(&["run-task", stage, "--out"], &[folder]);
            assert_eq!(answer.code, 0, "{}", answer.stderr);
            let parcel = Parcel::read(&kept(folder, stage)).unwrap();
            assert_eq!(task["key"], parcel.key, "{stage}");
        }
    }

    let out = out.to_str().unwrap();
    let merge = [&["merge"], &STAGES[..], &["--out", out]].concat();
    let like = ["--like", one.to_str().unwrap()];
    let merged = on(&[&merge[..], &like].concat(), &[&left, &right]);
    assert_eq!(merged.code, 0, "{merged:?}");
    for line in [
        "merged    2 outputs from 2 folders; each fits the plan",
        "like      results, tables, figures and page are equal byte for byte",
    ] {
        assert!(merged.stdout.contains(line), "{}", merged.stdout);
    }
    assert_eq!(
        merged.stderr.matches("(kept)").count(),
        2,
        "{}",
        merged.stderr
    );
    // A page that one process did not leave.
    let page = fs::read_to_string(one.join("report.html")).unwrap();
    fs::write(
        one.join("report.html"),
        page.replacen("<h1>", "<h1>Not: ", 1),
    )
    .unwrap();
    let other = on(&[&merge[..], &like].concat(), &[&left, &right]);
    assert_eq!(other.code, 1);
    assert!(
        other.stdout.contains("like      not equal: report.html\n"),
        "{}",
        other.stdout
    );

    let refused = |folders: &[&Path], words: &[&str]| {
        let answer = on(&merge, folders);
        assert_eq!(answer.code, 2, "{answer:?}");
        for word in words {
            assert!(
                answer.stderr.contains(word),
                "`{word}` in {}",
                answer.stderr
            );
        }
    };
    refused(&[&home.path().join("nowhere")], &["nowhere"]);
    // Made with other options.
    let quick = home.path().join("quick");
    assert_eq!(
        on(&["run-task", "audit", "--quick", "--out"], &[&quick]).code,
        0
    );
    refused(
        &[&quick, &right],
        &["audit has another key", "made with --quick"],
    );
    // Computed by nobody.
    refused(
        &[&left],
        &["holds the output of envelope", "run-task envelope"],
    );
    // Another machine's other bits, honestly sealed.
    let file = kept(&right, "audit");
    let whole = fs::read_to_string(&file).unwrap();
    let mut parcel = Parcel::read(&file).unwrap();
    let value = &mut parcel.output["values"][0];
    let id = value["id"].as_str().unwrap().to_owned();
    let number = value["value"].as_f64().unwrap();
    let next = f64::from_bits(number.to_bits() + 1);
    value["value"] = serde_json::json!(next);
    let text = parcel.output.to_string();
    parcel.digest = blake3::hash(text.as_bytes()).to_hex().to_string();
    parcel.write(&right).unwrap();
    let place = format!("values > {id} > value: {number:?}, {next:?}");
    refused(&[&left, &right], &["two outputs of audit", &place]);
    // Altered and not sealed again.
    let altered = whole.replacen(&format!("{number:?}"), &format!("{next:?}"), 1);
    assert_ne!(altered, whole);
    fs::write(&file, altered).unwrap();
    refused(&[&left, &right], &["audit-", "altered or damaged"]);
}

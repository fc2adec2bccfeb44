//! Bad input at the command line: one line on stderr, nothing on stdout, exit code 2, whatever the command. The messages
//! of the door itself are pinned one by one in crate `campaign`.

mod program;

use std::fs;

use program::{package, run};
use tempfile::TempDir;

#[test]
fn every_command_that_opens_a_package_refuses_a_bad_one_in_one_line() {
    let folder = TempDir::new().unwrap();
    package(folder.path());
    let file = folder.path().join("runs/0-forward.csv");
    let text = fs::read_to_string(&file).unwrap();
    fs::write(&file, text.replacen("0.05,0.3", "0.05,oops", 1)).unwrap();
    let home = folder.path().to_str().unwrap();
    let model = folder.path().join("model.json");
    let out = folder.path().join("out");
    let message = format!("error: {home}/runs/0-forward.csv, row 3, column velocity_mm_s: `oops");
    let commands: [&[&str]; 4] = [
        &["check", home],
        &["identify", home],
        &["diagnose", home],
        &[
            "simulate",
            home,
            "--model",
            model.to_str().unwrap(),
            "--out",
            out.to_str().unwrap(),
        ],
    ];
    for command in commands {
        let answer = run(command);
        assert_eq!(answer.code, 2, "{command:?}: {answer:?}");
        assert!(
            answer.stderr.starts_with(&message),
            "{command:?}: {}",
            answer.stderr
        );
        assert_eq!(answer.stderr.lines().count(), 1);
        assert_eq!(answer.stdout, "");
    }
    assert!(!out.exists());
}

#[test]
fn a_package_that_is_not_there_is_bad_input() {
    let answer = run(&["check", "no/such/folder"]);
    assert_eq!((answer.code, answer.stdout.as_str()), (2, ""));
    assert_eq!(
        answer.stderr,
        "error: no/such/folder: cannot be read: there is no such folder\n"
    );
}

#[test]
fn a_model_that_is_none_is_bad_input() {
    let folder = TempDir::new().unwrap();
    package(&folder.path().join("p"));
    let home = folder.path().join("p");
    let model = folder.path().join("model.json");
    for text in [
        "",
        "[]",
        "{\"schema\": \"bristle/model/1\"}",
        "{\"schema\": \"bristle/model/1\", \"law\": \"lugre\", \"parameters\": []}",
    ] {
        fs::write(&model, text).unwrap();
        let out = folder.path().join("out");
        let answer = run(&[
            "simulate",
            home.to_str().unwrap(),
            "--model",
            model.to_str().unwrap(),
            "--out",
            out.to_str().unwrap(),
        ]);
        assert_eq!(answer.code, 2, "{text}: {answer:?}");
        assert!(!out.exists(), "nothing is written for a refused model");
    }
}

#[test]
fn a_model_with_an_unknown_cause_names_the_nearest() {
    let folder = TempDir::new().unwrap();
    package(&folder.path().join("p"));
    let model = folder.path().join("model.json");
    fs::write(
        &model,
        "{\"schema\": \"bristle/model/1\", \"law\": \"coulomb-viscous\", \"parameters\": [{\"name\": \"mu_c\", \"value\": 0.5, \"unit\": \"1\"}, {\"name\": \"sigma2\", \"value\": 0.1, \"unit\": \"s/m\"}], \"extension\": [{\"cause\": \"sensor-lagg\", \"parameters\": []}]}",
    )
    .unwrap();
    let home = folder.path().join("p");
    let out = folder.path().join("out");
    let answer = run(&[
        "simulate",
        home.to_str().unwrap(),
        "--model",
        model.to_str().unwrap(),
        "--out",
        out.to_str().unwrap(),
    ]);
    assert_eq!(answer.code, 2);
    assert!(
        answer
            .stderr
            .contains("no cause is called `sensor-lagg`; the nearest name is `sensor-lag`"),
        "{}",
        answer.stderr
    );
}

#[test]
fn data_with_an_unknown_name_names_the_nearest() {
    let folder = TempDir::new().unwrap();
    package(&folder.path().join("brush-2x2-alumnium"));
    let answer = run(&[
        "reproduce",
        "--data",
        folder.path().to_str().unwrap(),
        "--stage",
        "audit",
    ]);
    assert_eq!(answer.code, 2);
    let home = folder.path().to_str().unwrap();
    assert_eq!(
        answer.stderr,
        format!(
            "error: {home}: no campaign is called `brush-2x2-alumnium`; the nearest name is `brush-2x2-aluminium`\n"
        )
    );
}

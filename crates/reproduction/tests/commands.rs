//! The commands as a user meets them: help, names, the way in from plain files, identification, simulation.

mod program;

use std::fs;

use program::{package, root, run};
use tempfile::TempDir;

const COMMANDS: [&str; 11] = [
    "reproduce",
    "claim",
    "plan",
    "run-task",
    "merge",
    "identify",
    "diagnose",
    "simulate",
    "init",
    "check",
    "bench",
];

#[test]
fn help_lists_every_command_and_each_explains_itself() {
    let help = run(&["help"]);
    assert_eq!(help.code, 0);
    for command in COMMANDS.iter().chain(&["stand-ins"]) {
        assert!(help.stdout.contains(command), "{command}");
    }
    for command in COMMANDS {
        let own = run(&[command, "--help"]);
        assert_eq!(own.code, 0, "{command}");
        assert!(own.stdout.contains("--threads"), "{command}");
        assert_eq!(run(&[command, "--version"]).code, 0, "{command}");
    }
}

#[test]
fn wrong_names_bring_the_nearest_right_ones() {
    let folder = TempDir::new().unwrap();
    package(folder.path());
    let home = folder.path().to_str().unwrap();
    let cases: [(&[&str], &str); 4] = [
        (
            &["reproduce", "--stage", "enveloppe"],
            "no stage is called `enveloppe`; the nearest name is `envelope`",
        ),
        (
            &["claim", "C23"],
            "no claim is called `C23`; the nearest name is `C",
        ),
        (
            &["identify", home, "--law", "lugree"],
            "no law is called `lugree`; the nearest name is `lugre`",
        ),
        (
            &["diagnose", home, "--law", "dal"],
            "no law is called `dal`; the nearest name is `dahl`",
        ),
    ];
    for (command, message) in cases {
        let answer = run(command);
        assert_eq!(answer.code, 2, "{command:?}");
        assert!(
            answer.stderr.contains(message),
            "{command:?}: {}",
            answer.stderr
        );
    }
    let answer = run(&["reprodce"]);
    assert_eq!(answer.code, 2);
    assert!(answer.stderr.contains("reproduce"), "{}", answer.stderr);
}

#[test]
fn a_claim_prints_verdict_evidence_and_cost() {
    let folder = TempDir::new().unwrap();
    let answer = run(&["claim", "c16", "--out", folder.path().to_str().unwrap()]);
    assert_eq!(answer.code, 0, "{answer:?}");
    for line in [
        "verdict    contradicted",
        "evidence   published",
        "cost       ",
    ] {
        assert!(answer.stdout.contains(line), "{}", answer.stdout);
    }
    assert!(
        answer.stdout.contains("stages: audit\n"),
        "only what the claim needs: {}",
        answer.stdout
    );
}

#[test]
fn a_budget_runs_what_it_pays_for_and_names_the_rest() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().to_str().unwrap();
    let answer = run(&["claim", "--budget", "15s", "--out", out]);
    assert_eq!(answer.code, 0, "{answer:?}");
    let line = |name: &str| {
        let found = answer.stdout.lines().find(|line| line.starts_with(name));
        found.unwrap_or_else(|| panic!("no {name} in {}", answer.stdout))
    };
    assert!(line("plan").contains(" of 22 claims"), "{}", line("plan"));
    for cheap in ["C07", "C12", "C16"] {
        assert!(line("order").contains(cheap), "{}", line("order"));
    }
    for dear in ["C01 (", "C11 ("] {
        assert!(line("left out").contains(dear), "{}", line("left out"));
    }
    assert!(line("C16").contains("contradicted"), "{}", line("C16"));
    assert!(!answer.stdout.contains("\nC11"), "{}", answer.stdout);
    for arguments in [
        &["claim", "C16", "--budget", "1h"][..],
        &["claim", "--budget", "soon"],
    ] {
        assert_eq!(run(arguments).code, 2, "{arguments:?}");
    }
}

#[test]
fn from_plain_files_to_parameters() {
    let folder = TempDir::new().unwrap();
    package(&folder.path().join("by-hand"));
    let csv = |name: &str| {
        folder
            .path()
            .join(format!("by-hand/runs/{name}.csv"))
            .to_str()
            .unwrap()
            .to_owned()
    };
    let package = folder.path().join("package");
    let made = run(&[
        "init",
        package.to_str().unwrap(),
        &csv("0-forward"),
        &csv("1-reverse"),
        &csv("2-forward"),
    ]);
    assert_eq!(made.code, 0, "{made:?}");
    assert!(
        made.stdout.contains("direction reverse, protocol ramp"),
        "{}",
        made.stdout
    );
    assert!(
        made.stdout.contains("optional  run.normal_load_n"),
        "{}",
        made.stdout
    );
    let checked = run(&["check", package.to_str().unwrap()]);
    assert_eq!(checked.code, 0, "{checked:?}");
    assert!(
        checked.stdout.contains("3 runs, 600 samples, 2 conditions"),
        "{}",
        checked.stdout
    );
    let json = folder.path().join("answer.json");
    let report = folder.path().join("answer.html");
    let model = folder.path().join("model.json");
    let answer = run(&[
        "identify",
        package.to_str().unwrap(),
        "--law",
        "coulomb-viscous",
        "--json",
        json.to_str().unwrap(),
        "--report",
        report.to_str().unwrap(),
        "--model-out",
        model.to_str().unwrap(),
    ]);
    assert_eq!(answer.code, 0, "{answer:?}");
    let json: serde_json::Value = serde_json::from_str(&fs::read_to_string(json).unwrap()).unwrap();
    assert_eq!(json["schema"], "bristle/identification/1");
    let coulomb = json["parameters"][0]["value"].as_f64().unwrap();
    assert!(
        (coulomb - 1.2).abs() < 0.02,
        "the record was made with 1.2 N: {coulomb}"
    );
    assert!(
        fs::read_to_string(report)
            .unwrap()
            .contains("An honest word about the fit")
    );

    let out = folder.path().join("predicted");
    let simulated = run(&[
        "simulate",
        package.to_str().unwrap(),
        "--model",
        model.to_str().unwrap(),
        "--out",
        out.to_str().unwrap(),
    ]);
    assert_eq!(simulated.code, 0, "{simulated:?}");
    let predicted = run(&["check", out.to_str().unwrap()]);
    assert!(
        predicted.stdout.contains("synthetic"),
        "a prediction says that it is none: {}",
        predicted.stdout
    );
}

/// What a protocol could tell follows from its motions: the same answer with any forces, a threshold for what the ramps show,
/// none for what one load cannot, and what is one thing on one load has no angle between.
#[test]
fn a_design_reads_no_forces_and_gives_thresholds() {
    let shipped = root().join("data/campaigns/brush-2x2-aluminium");
    let answer = run(&["diagnose", "--design", shipped.to_str().unwrap()]);
    assert_eq!(answer.code, 0, "{answer:?}");
    let line = |cause: &str| {
        let start = format!("{cause} | ");
        let found = answer.stdout.lines().find(|l| l.starts_with(&start));
        found.map(str::to_owned).unwrap_or_default()
    };
    for cause in ["wear", "surface-gradient", "sensor-lag", "surface-texture"] {
        let size = line(cause)
            .split_whitespace()
            .filter_map(|word| word.parse::<f64>().ok())
            .next();
        assert!(size.is_some_and(|s| s > 0.0), "{cause}: {}", answer.stdout);
    }
    assert!(line("stage-tilt").ends_with("force-zero-offset (0)"));
    assert!(line("load-dependence").is_empty(), "one load only");

    let folder = TempDir::new().unwrap();
    let other = folder.path().join("other");
    fs::create_dir_all(other.join("runs")).unwrap();
    fs::copy(
        shipped.join("datapackage.json"),
        other.join("datapackage.json"),
    )
    .unwrap();
    for entry in fs::read_dir(shipped.join("runs")).unwrap() {
        let entry = entry.unwrap();
        let text = fs::read_to_string(entry.path()).unwrap();
        let path = other.join("runs").join(entry.file_name());
        fs::write(path, with_other_forces(&text)).unwrap();
    }
    let page = folder.path().join("design.html");
    let again = run(&[
        "diagnose",
        "--design",
        other.to_str().unwrap(),
        "--report",
        page.to_str().unwrap(),
    ]);
    assert_eq!(again.stdout, answer.stdout);
    let page = fs::read_to_string(page).unwrap();
    for part in [
        "design-isolability",
        "design-thresholds",
        "design-undecidable",
    ] {
        assert!(page.contains(&format!("id=\"{part}\"")), "no {part}");
    }
}

/// The same run with the last column scaled and bent.
fn with_other_forces(csv: &str) -> String {
    let mut lines = csv.lines();
    let mut out = format!("{}\n", lines.next().unwrap());
    for (place, line) in lines.enumerate() {
        let (rest, force) = line.rsplit_once(',').unwrap();
        let force: f64 = force.parse().unwrap();
        let bent = 0.5 * force + 0.01 * (place as f64 * 0.3).sin();
        out.push_str(&format!("{rest},{bent:.6}\n"));
    }
    out
}

/// A public tribometer record lies beside some working copies; it is not the project's to ship.
#[test]
fn a_real_tribometer_record_is_checked_and_identified() {
    let package = root().join("../shared/real/microtribo");
    if !package.is_dir() {
        eprintln!("not run: the tribometer record is not beside this working copy");
        return;
    }
    let home = package.to_str().unwrap();
    let checked = run(&["check", home]);
    assert_eq!(checked.code, 0, "{checked:?}");
    assert!(
        checked.stdout.contains("9 runs, 39600 samples"),
        "{}",
        checked.stdout
    );
    let folder = TempDir::new().unwrap();
    let report = folder.path().join("report.html");
    let answer = run(&[
        "identify",
        home,
        "--law",
        "lugre",
        "--report",
        report.to_str().unwrap(),
    ]);
    assert_eq!(answer.code, 0, "{answer:?}");
    assert!(answer.stdout.contains("sigma0"), "{}", answer.stdout);
    assert!(
        fs::read_to_string(report)
            .unwrap()
            .contains("What the law leaves")
    );
}

#[test]
fn two_processes_with_one_thread_and_with_all_leave_the_same_bytes() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().join("out");
    let arguments = [
        "reproduce",
        "--stage",
        "envelope",
        "--out",
        out.to_str().unwrap(),
    ];
    let once = run(&arguments);
    assert_eq!(once.code, 0, "{}", once.stderr);
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("id=\"bit-identity\"") && !page.contains("bit-identity-hashes"));
    fs::remove_dir_all(out.join(".cache")).unwrap();
    let twice = run(&[&arguments[..], &["--twice"]].concat());
    assert_eq!(twice.code, 0, "{}", twice.stderr);
    assert!(
        twice
            .stdout
            .starts_with("twice     results, tables, figures and page are equal byte for byte"),
        "{}",
        twice.stdout
    );
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("id=\"bit-identity-hashes\""));
    assert!(!out.join(".twice").exists(), "no trace is left");
    assert!(out.join(".cache").is_dir(), "what was computed is kept");
}

/// A folder holds what its report says and what strangers put there: an earlier run's files go with the run that made them,
/// so that a folder with a past is, for `merge --like`, the same as a new one.
#[test]
fn a_folder_with_a_past_holds_what_its_last_run_wrote_and_what_strangers_put_there() {
    let home = TempDir::new().unwrap();
    let [used, new, part] = ["used", "new", "part"].map(|name| home.path().join(name));
    let reproduce = |stages: &[&str], out: &std::path::Path| {
        let stages = stages.iter().flat_map(|stage| ["--stage", stage]);
        let words = ["reproduce", "--out", out.to_str().unwrap()];
        let answer = run(&words.into_iter().chain(stages).collect::<Vec<_>>());
        assert_eq!(answer.code, 0, "{}", answer.stderr);
        answer
    };
    let names = |folder: &std::path::Path| -> std::collections::BTreeSet<String> {
        let parts = ["tables", "figures"].map(|part| folder.join(part));
        let files = parts
            .iter()
            .filter_map(|part| fs::read_dir(part).ok())
            .flatten();
        files
            .map(|file| file.unwrap().file_name().into_string().unwrap())
            .collect()
    };
    reproduce(&["audit", "envelope"], &used);
    let own = used.join("tables/own.csv");
    fs::write(&own, "a,b\n").unwrap();
    reproduce(&["audit"], &new);
    let (before, after) = (names(&used), names(&new));
    let altered = before
        .difference(&after)
        .map(|name| used.join("tables").join(name))
        .find(|table| table.is_file() && *table != own)
        .unwrap();
    fs::write(&altered, "my notes").unwrap();

    let said = reproduce(&["audit"], &used).stderr;
    assert!(said.contains(altered.to_str().unwrap()), "{said}");
    assert_eq!(fs::read_to_string(&altered).unwrap(), "my notes");
    let strangers = [&own, &altered];
    for stranger in strangers {
        fs::remove_file(stranger).expect("no stranger's file is taken away");
    }
    assert_eq!(names(&used), after);
    assert!(before.len() > after.len() + strangers.len());
    let part = part.to_str().unwrap();
    assert_eq!(run(&["run-task", "audit", "--out", part]).code, 0);
    let [used, new] = [&used, &new].map(|folder| folder.to_str().unwrap());
    let merged = run(&[
        "merge", part, "--stage", "audit", "--out", used, "--like", new,
    ]);
    assert_eq!(merged.code, 0, "{merged:?}");
}

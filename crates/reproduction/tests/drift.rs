//! Drift: the results of the shipped data against a snapshot, numbers by a tolerance a quantity, everything else exactly.

mod program;

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use insta::Comparator;
use program::run;
use reproduction::against::tolerance;
use serde_json::Value as Json;

/// Values by `ID unit evidence` in the snapshot's text, one a line, `ID: number unit evidence`.
#[derive(Clone, Copy)]
struct Quantities;

/// One line as its words around the number, and the number.
fn parts(line: &str) -> (String, Option<f64>) {
    match line.split_once(": ") {
        Some((id, rest)) => {
            let (number, tail) = rest.split_once(' ').unwrap_or((rest, ""));
            (format!("{id}: {tail}"), number.parse().ok())
        }
        None => (line.to_owned(), None),
    }
}

/// Whether two texts hold the same lines, numbers within the tolerance of their quantity.
fn equal(reference: &str, test: &str) -> bool {
    let lines = |text: &str| text.trim().lines().map(str::to_owned).collect::<Vec<_>>();
    let (old, new) = (lines(reference), lines(test));
    old.len() == new.len()
        && old.iter().zip(&new).all(|(old, new)| {
            let ((old_words, a), (new_words, b)) = (parts(old), parts(new));
            let id = old.split(": ").next().unwrap_or_default();
            let close = match (a, b) {
                (Some(a), Some(b)) => {
                    (a - b).abs() <= allowed(id) * a.abs().max(b.abs()) + f64::MIN_POSITIVE
                }
                _ => old == new,
            };
            old_words == new_words && close
        })
}

/// Across targets the last digits of an optimum move more than from run to run.
fn allowed(id: &str) -> f64 {
    if id.starts_with("work.") {
        0.0
    } else {
        10.0 * tolerance(id)
    }
}

impl Comparator for Quantities {
    fn matches(&self, reference: &insta::Snapshot, test: &insta::Snapshot) -> bool {
        match (reference.as_text(), test.as_text()) {
            (Some(old), Some(new)) => equal(&old.to_string(), &new.to_string()),
            _ => false,
        }
    }

    fn dyn_clone(&self) -> Box<dyn Comparator> {
        Box::new(*self)
    }
}

fn results() -> Json {
    let out = Path::new(env!("CARGO_TARGET_TMPDIR")).join("reproduction");
    run(&["reproduce", "--out", out.to_str().unwrap()]);
    serde_json::from_str(&fs::read_to_string(out.join("results.json")).unwrap()).unwrap()
}

/// The results as lines: values of the stages (not the printed numbers), work counters, verdicts.
fn lines(results: &Json) -> String {
    let text = |entry: &Json, key: &str| entry[key].as_str().unwrap_or_default().to_owned();
    let array = |key: &str| results[key].as_array().cloned().unwrap_or_default();
    let mut lines = Vec::new();
    for value in array("values")
        .iter()
        .filter(|value| !text(value, "id").starts_with("published."))
    {
        lines.push(format!(
            "{}: {} {} {}",
            text(value, "id"),
            value["value"],
            text(value, "unit"),
            text(value, "evidence")
        ));
    }
    for stage in array("stages") {
        let work: BTreeMap<String, Json> = serde_json::from_value(stage["work"].clone()).unwrap();
        for (name, count) in work {
            lines.push(format!(
                "work.{}.{name}: {count} counted",
                text(&stage, "id")
            ));
        }
        lines.push(format!(
            "stage {}: {}",
            text(&stage, "id"),
            text(&stage, "status")
        ));
    }
    for claim in array("claims") {
        lines.push(format!(
            "claim {}: {}",
            text(&claim, "id"),
            text(&claim, "verdict")
        ));
    }
    lines.join("\n")
}

#[test]
fn results_are_those_of_the_snapshot() {
    let mut settings = insta::Settings::clone_current();
    settings.set_comparator(Box::new(Quantities));
    settings.set_description("relative tolerance of a quantity: ten times that of against::tolerance; work counters exact");
    settings.set_omit_expression(true);
    settings.bind(|| insta::assert_snapshot!("results", lines(&results())));
}

#[test]
fn the_comparison_can_fail() {
    let old = "envelope.gain.pitch0: 18.6 percent computed\nwork.gait.iterations: 400 counted\nclaim C12: differs";
    assert!(equal(old, old));
    assert!(
        equal(old, &old.replace("18.6", "18.600000000001")),
        "within its tolerance"
    );
    for (word, other) in [
        ("18.6", "18.61"),
        ("400", "401"),
        ("differs", "reproduced"),
        ("percent", "1"),
        ("computed", "synthetic"),
        ("18.6", "null"),
    ] {
        assert!(
            !equal(old, &old.replacen(word, other, 1)),
            "{word} -> {other} must fail"
        );
    }
    assert!(
        !equal(old, "envelope.gain.pitch0: 18.6 percent computed"),
        "a missing line must fail"
    );
    assert!(!equal(old, ""), "nothing at all must fail");
}

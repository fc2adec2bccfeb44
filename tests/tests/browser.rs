//! The report in a real browser: no message, no request, no sideways scroll, nothing that assistive technology
//! stumbles over, complete without JavaScript. Where no browser or no Node is at hand, the test says so on stderr.

#[path = "../../crates/report/tests/demo/mod.rs"]
mod demo;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Straight to stderr, which the test harness does not capture.
fn say(words: &str) {
    // A closed stderr is no reason to fail.
    let _ = writeln!(std::io::stderr(), "{words}");
}

/// Opens the page in the browser; panics with every failure found, tells whether the browser ran.
fn check(page: &Path) -> bool {
    let script = repository().join("tests/browser/check.mjs");
    let output = match Command::new("node").arg(&script).arg(page).output() {
        Ok(output) => output,
        Err(error) => {
            say(&format!(
                "browser tests DID NOT RUN: node could not be started ({error})"
            ));
            return false;
        }
    };
    let answer: serde_json::Value = match serde_json::from_slice(&output.stdout) {
        Ok(answer) => answer,
        Err(error) => panic!(
            "the browser gave no answer ({error}): {}",
            String::from_utf8_lossy(&output.stderr)
        ),
    };
    if answer["ran"] != true {
        say(&format!("browser tests DID NOT RUN: {}", answer["because"]));
        return false;
    }
    say(&format!(
        "browser tests ran on {}: {}",
        page.display(),
        answer["facts"]
    ));
    let failures: Vec<&str> = answer["failures"]
        .as_array()
        .map(|all| all.iter().filter_map(serde_json::Value::as_str).collect())
        .unwrap_or_default();
    assert!(
        failures.is_empty(),
        "{} failures:\n{}",
        failures.len(),
        failures.join("\n")
    );
    true
}

#[test]
fn the_demonstration_in_a_browser() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let page = folder.path().join("demonstration.html");
    std::fs::write(&page, report::render(&demo::document()).expect("renders")).expect("written");
    check(&page);
}

/// The checks themselves can fail: a page with a script of its own, a request, a wide block and a picture without words.
#[test]
fn a_bad_page_is_found_out() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let page = folder.path().join("bad.html");
    let good = report::render(&demo::document()).expect("renders");
    let bad = good
        .replace("default-src 'none';", "default-src * 'unsafe-inline';")
        .replace("script-src 'sha256-", "x-off 'sha256-")
        .replace("img-src data:;", "img-src *;")
        .replace(
            "<main id=\"content\">",
            "<main id=\"content\"><script>console.log('x')</script><p id=\"top\" style=\"width:3000px\">wide</p>\
             <img src=\"https://example.invalid/x.png\">",
        );
    std::fs::write(&page, bad).expect("written");
    let ran = std::panic::catch_unwind(|| check(&page));
    let Err(panic) = ran else {
        // Without a browser there is nothing to find out.
        assert_eq!(ran.ok(), Some(false), "the bad page passed");
        return;
    };
    let message = panic.downcast_ref::<String>().cloned().unwrap_or_default();
    for found in [
        "console log",
        "request",
        "px too wide",
        "axe image-alt",
        "html-validate no-dup-id",
    ] {
        assert!(
            message.contains(found),
            "`{found}` was not found out:\n{message}"
        );
    }
}

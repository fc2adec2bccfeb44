//! The built program, driven as a user drives it.

#![allow(dead_code, reason = "each test binary uses its part")]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The repository.
pub(crate) fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../..")
        .canonicalize()
        .unwrap()
}

/// Runs the program in the repository.
pub(crate) fn run(arguments: &[&str]) -> Answer {
    let output = Command::new(env!("CARGO_BIN_EXE_bristle"))
        .args(arguments)
        .current_dir(root())
        .output()
        .unwrap();
    Answer::from(output)
}

/// What the program said and how it ended.
#[derive(Debug)]
pub(crate) struct Answer {
    pub(crate) code: i32,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl From<Output> for Answer {
    fn from(output: Output) -> Self {
        Self {
            // A signal has no code: no test expects one.
            code: output.status.code().unwrap_or(-1),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }
}

/// A package of two ramps each way, written as CSV by hand.
pub(crate) fn package(folder: &Path) {
    std::fs::create_dir_all(folder.join("runs")).unwrap();
    let mut resources = Vec::new();
    for (place, (direction, sign)) in [("forward", 1.0), ("reverse", -1.0)]
        .into_iter()
        .cycle()
        .take(4)
        .enumerate()
    {
        let name = format!("{place}-{direction}");
        let mut text = String::from("time_s,velocity_mm_s,force_n\n");
        for sample in 0..200 {
            let t = f64::from(sample) * 0.05;
            // Coulomb and viscous friction with a little scatter that no generator is needed for.
            let scatter = 0.01 * (f64::from(sample) * 1.7 + place as f64).sin();
            text += &format!(
                "{t},{},{}\n",
                sign * 6.0 * t,
                sign * (1.2 + 0.05 * t + scatter)
            );
        }
        std::fs::write(folder.join(format!("runs/{name}.csv")), text).unwrap();
        resources.push(serde_json::json!({
            "name": name, "path": format!("runs/{name}.csv"), "profile": "tabular-data-resource",
            "schema": {"fields": [{"name": "time_s", "type": "number", "unit": "s"},
                {"name": "velocity_mm_s", "type": "number", "unit": "mm/s"},
                {"name": "force_n", "type": "number", "unit": "N"}]},
            "run": {"direction": direction, "protocol": "ramp", "order": place + 1, "normal_load_n": 2.0}}));
    }
    let description = serde_json::json!({"profile": "tabular-data-package", "name": "hand-made",
        "campaign": {"provenance": "measured"}, "resources": resources});
    std::fs::write(folder.join("datapackage.json"), description.to_string()).unwrap();
}

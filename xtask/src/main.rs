//! Dispatcher: passes the verb on to the release build of the real program.
//!
//! No dependencies, so that the first answer to `cargo xtask help` takes a second. Verbs of the planting package
//! (which the program may not depend on) and of the benchmarks are separate programs; everything else is `bristle`.

use std::process::{Command, ExitCode};

/// Which program answers a verb: (package, binary).
fn program(verb: Option<&str>) -> (&'static str, &'static str) {
    match verb {
        Some("stand-ins") => ("planting", "planting"),
        _ => ("reproduction", "bristle"),
    }
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (package, binary) = program(arguments.first().map(String::as_str));
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let status = Command::new(cargo)
        .args([
            "run",
            "--quiet",
            "--release",
            "--package",
            package,
            "--bin",
            binary,
            "--",
        ])
        .args(&arguments)
        .status();
    match status {
        // A signal leaves no code: report it as "no result could be written".
        Ok(status) => ExitCode::from(u8::try_from(status.code().unwrap_or(3)).unwrap_or(3)),
        Err(error) => {
            eprintln!("xtask: cargo could not be started: {error}");
            ExitCode::from(3)
        }
    }
}

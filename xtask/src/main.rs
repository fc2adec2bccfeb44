//! Dispatcher: passes the verb on to the release build of the real program.
//!
//! No dependencies, so that the first answer to `cargo xtask help` takes a second. What plants effects lives in packages
//! that the program may not depend on: those verbs are separate programs; everything else is `bristle`.

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

/// Which program answers: package, binary, and how many words it does not need to see.
fn program(arguments: &[String]) -> (&'static str, &'static str, usize) {
    let words: Vec<&str> = arguments.iter().take(2).map(String::as_str).collect();
    match words.as_slice() {
        ["stand-ins", ..] => ("planting", "planting", 0),
        ["bench", "hidden-effects"] => ("whole-program", "hidden_effects", 2),
        _ => ("reproduction", "bristle", 0),
    }
}

/// Where the release build of a program will lie.
fn release_build(binary: &str) -> PathBuf {
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../target"),
        PathBuf::from,
    );
    let name = format!("{binary}{}", std::env::consts::EXE_SUFFIX);
    target.join("release").join(name)
}

fn main() -> ExitCode {
    let mut arguments: Vec<String> = std::env::args().skip(1).collect();
    if arguments.is_empty() {
        arguments.push("help".to_owned());
    }
    let (package, binary, known) = program(&arguments);
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut run = Command::new(cargo);
    run.args(["run", "--release", "--package", package, "--bin", binary]);
    if release_build(binary).exists() {
        run.arg("--quiet");
    } else {
        // The first build takes minutes: the reader sees it go on.
        eprintln!("xtask: building {binary} for the first time, libraries included");
    }
    match run.arg("--").args(&arguments[known..]).status() {
        // A signal leaves no code: report it as "no result could be written".
        Ok(status) => ExitCode::from(
            status
                .code()
                .and_then(|code| u8::try_from(code).ok())
                .unwrap_or(3),
        ),
        Err(error) => {
            eprintln!("xtask: cargo could not be started: {error}");
            ExitCode::from(3)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::program;

    #[test]
    fn planting_is_never_asked_for_anything_else() {
        let of = |line: &str| program(&line.split(' ').map(str::to_owned).collect::<Vec<_>>());
        assert_eq!(of("stand-ins --check").0, "planting");
        assert_eq!(
            of("bench hidden-effects --limit 3"),
            ("whole-program", "hidden_effects", 2)
        );
        assert_eq!(of("bench ramp"), ("reproduction", "bristle", 0));
        assert_eq!(of("reproduce"), ("reproduction", "bristle", 0));
    }
}

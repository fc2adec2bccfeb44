//! Writes the stand-in campaigns, or checks that they are what their recipe makes.

use std::path::PathBuf;
use std::process::ExitCode;

const USAGE: &str = "usage: planting stand-ins [--check] [--folder DIR]";

fn main() -> ExitCode {
    let mut check = false;
    let mut folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../data/campaigns");
    let mut arguments = std::env::args().skip(1);
    if arguments.next().as_deref() != Some("stand-ins") {
        eprintln!("{USAGE}");
        return ExitCode::from(2);
    }
    while let Some(argument) = arguments.next() {
        match (argument.as_str(), argument == "--folder") {
            ("--check", _) => check = true,
            (_, true) => match arguments.next() {
                Some(value) => folder = value.into(),
                None => return usage("--folder needs a folder"),
            },
            ("--help", _) => {
                println!(
                    "{USAGE}\nRegenerates the stand-in campaigns from recipe.toml, or checks them against it."
                );
                return ExitCode::SUCCESS;
            }
            (other, _) => return usage(&format!("unknown option {other:?}")),
        }
    }
    if check {
        run_check(&folder)
    } else {
        run_regenerate(&folder)
    }
}

fn usage(problem: &str) -> ExitCode {
    eprintln!("{problem}\n{USAGE}");
    ExitCode::from(2)
}

fn run_regenerate(folder: &std::path::Path) -> ExitCode {
    match planting::stand_ins::regenerate(folder) {
        Ok(count) => {
            println!("{count} files written");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("stand-ins: {error}");
            ExitCode::from(3)
        }
    }
}

fn run_check(folder: &std::path::Path) -> ExitCode {
    match planting::stand_ins::check(folder) {
        Ok(complaints) if complaints.is_empty() => {
            println!("the stand-in campaigns are what the recipe makes");
            ExitCode::SUCCESS
        }
        Ok(complaints) => {
            for complaint in complaints {
                eprintln!("{complaint}");
            }
            ExitCode::from(1)
        }
        Err(error) => {
            eprintln!("stand-ins: {error}");
            ExitCode::from(2)
        }
    }
}

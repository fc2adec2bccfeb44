//! `reproduce --twice`: the same work in two processes of their own, one with a single thread and one with all.

use std::path::Path;
use std::process::{Command, Stdio};

use super::left::compare;
use super::{Failure, ReproduceArguments};
use crate::cache;
use crate::compose::Twice;

/// Runs both and compares them; what the second one computed is kept in `out`, so that the page costs no third run.
pub(super) fn run(arguments: &ReproduceArguments, out: &Path) -> Result<Twice, Failure> {
    let folder = out.join(".twice");
    remove(&folder)?;
    // One processor can still interleave two threads.
    let all = std::thread::available_parallelism().map_or(2, |count| count.get().max(2));
    let [one, many] = ["one", "all"].map(|name| folder.join(name));
    child(arguments, 1, &one)?;
    child(arguments, all, &many)?;
    let twice = compare([&one, &many], ["1", "all"])?;
    keep(&cache::folder(&many), &cache::folder(out))?;
    remove(&folder)?;
    Ok(twice)
}

fn remove(folder: &Path) -> Result<(), Failure> {
    match std::fs::remove_dir_all(folder) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(Failure::output(format!("{}: {error}", folder.display())))
        }
        _ => Ok(()),
    }
}

/// A whole reproduction from nothing in a process of its own; its progress is shown, its answer is not.
fn child(arguments: &ReproduceArguments, threads: usize, out: &Path) -> Result<(), Failure> {
    let program = std::env::current_exe().map_err(Failure::output)?;
    let mut command = Command::new(program);
    command.arg("reproduce").arg("--out").arg(out);
    command.args(["--threads", &threads.to_string()]);
    if let Some(data) = &arguments.basis.data {
        command.arg("--data").arg(data);
    }
    for stage in &arguments.stage {
        command.args(["--stage", stage]);
    }
    if let Some(model) = &arguments.basis.model {
        command.arg("--model").arg(model);
    }
    if arguments.basis.quick {
        command.arg("--quick");
    }
    let status = command
        .stdout(Stdio::null())
        .status()
        .map_err(Failure::output)?;
    match status.code() {
        // Verdicts that are not as pinned are told by the run that writes the report.
        Some(0 | 1) => Ok(()),
        Some(2) => Err(Failure::Input(
            "the input was refused (see above)".to_owned(),
        )),
        _ => Err(Failure::Output(format!(
            "the run with {threads} threads did not end"
        ))),
    }
}

/// Copies kept outputs of stages.
fn keep(from: &Path, to: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(to).map_err(Failure::output)?;
    for entry in std::fs::read_dir(from).map_err(Failure::output)? {
        let entry = entry.map_err(Failure::output)?;
        let bytes = std::fs::read(entry.path()).map_err(Failure::output)?;
        campaign::write_atomically(&to.join(entry.file_name()), &bytes).map_err(Failure::output)?;
    }
    Ok(())
}

//! `run-task`: stages computed here, their outputs left for `merge` anywhere.

use super::inputs::{Inputs, keep_times, stages_named};
use super::{Failure, Outcome, RunTaskArguments};
use crate::cache::Cache;
use crate::parcel::file_name;
use crate::stages;
use crate::watch::Watch;

pub(super) fn run(arguments: &RunTaskArguments) -> Result<Outcome, Failure> {
    let basis = &arguments.basis;
    let inputs = Inputs::read(basis.data.as_deref())?;
    let stages = stages_named(&stages::all(), &arguments.stages)?;
    let model = basis.model()?;
    inputs.open_all(&stages)?;
    let folder = &arguments.out;
    let watch = Watch::new();
    let cache = Cache::portable(folder);
    let engine = inputs.engine(cache, model.as_ref(), basis.quick, &watch)?;
    let tasks = engine.plan(&stages).map_err(Failure::input)?;
    let finished = engine.run(&stages);
    keep_times(folder, &finished);
    for (task, stage) in tasks.iter().zip(&finished) {
        if let Err(problem) = &stage.output {
            return Err(Failure::Input(format!("stage {}: {problem}", stage.id)));
        }
        let path = folder.join(file_name(task.stage, &task.key()));
        if !path.is_file() {
            return Err(Failure::Output(format!(
                "{} was not written",
                path.display()
            )));
        }
        let source = if stage.kept { " (was there)" } else { "" };
        say!(
            "{:14} {}: {}{source}",
            stage.id,
            stage.status(),
            path.display()
        );
    }
    Ok(Outcome::Done)
}

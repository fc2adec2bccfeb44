//! `merge`: the report from outputs that several machines left.

use super::inputs::{Inputs, stages_named};
use super::root::out;
use super::{Failure, MergeArguments, Outcome, ReproduceArguments, left, reproduce};
use crate::cache::{self, Cache};
use crate::costs::Costs;
use crate::merge::merge;
use crate::stages;
use crate::watch::Watch;

pub(super) fn run(arguments: &MergeArguments) -> Result<Outcome, Failure> {
    let basis = &arguments.basis;
    let inputs = Inputs::read(basis.data.as_deref())?;
    let stages = stages_named(&stages::all(), &arguments.stage)?;
    let model = basis.model()?;
    inputs.open_all(&stages)?;
    let folder = out(&inputs.root, &arguments.out);
    let kept = cache::folder(&folder);
    let watch = Watch::new();
    let engine = inputs.engine(Cache::new(&kept), model.as_ref(), basis.quick, &watch)?;
    let tasks = engine.plan(&stages).map_err(Failure::input)?;
    if let Some(like) = arguments
        .like
        .as_deref()
        .filter(|like| !like.join("results.json").is_file())
    {
        return Err(Failure::Input(format!(
            "{}: holds no results.json",
            like.display()
        )));
    }
    let parcels = merge(&tasks, &arguments.folders).map_err(Failure::input)?;
    // From here on it is a run of one process that finds everything computed.
    for parcel in &parcels {
        engine.cache.keep(parcel).map_err(Failure::output)?;
    }
    Costs::gather(&arguments.folders, &kept).map_err(Failure::output)?;
    say!(
        "merged    {} outputs from {} folders; each fits the plan",
        parcels.len(),
        arguments.folders.len()
    );
    let outcome = reproduce::run(&ReproduceArguments {
        out: arguments.out.clone(),
        stage: arguments.stage.clone(),
        basis: basis.clone(),
        twice: false,
        against: None,
    })?;
    let Some(like) = &arguments.like else {
        return Ok(outcome);
    };
    let both = left::compare([&folder, like], ["merged", "one process"])?;
    say!("like      {}", both.words());
    Ok(if both.same() {
        outcome
    } else {
        Outcome::Disagrees
    })
}

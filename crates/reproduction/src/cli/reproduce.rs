//! `reproduce`: all stages, the ledger, the report.

use std::path::Path;

use report::{NegativeControl, Verdict};

use super::inputs::{Inputs, stages_named};
use super::root::out;
use super::{Failure, Outcome, ReproduceArguments, output, twice};
use crate::claims::Claim;
use crate::compose::{self, Surroundings};
use crate::costs::Costs;
use crate::engine::closure;
use crate::numbers::Coverage;
use crate::results::Results;
use crate::stage::Stage;
use crate::{against, cache, controls, provenance, stages};

pub(super) fn run(arguments: &ReproduceArguments) -> Result<Outcome, Failure> {
    let basis = &arguments.basis;
    let inputs = Inputs::read(basis.data.as_deref())?;
    let all = stages::all();
    let stages = stages_named(&all, &arguments.stage)?;
    let model = basis.model()?;
    let old = arguments
        .against
        .as_deref()
        .map(against::read)
        .transpose()
        .map_err(Failure::input)?;
    let campaigns = inputs.open_all(&stages)?;
    let out = out(&inputs.root, &arguments.out);
    let twice = match arguments.twice {
        true => Some(twice::run(arguments, &out)?),
        false => None,
    };
    let mut run = provenance::run(&inputs.root);
    let results = inputs.run(&stages, &out, model.as_ref(), basis.quick)?;
    run.finished = provenance::now();
    let costs = Costs::read(&inputs.root, &cache::folder(&out)).map_err(Failure::input)?;
    run.seconds = results.seconds(&costs, |claim| needed(&all, claim));
    let rules = against::Rules {
        claims: &inputs.claims,
        published: &inputs.published,
    };
    let drift = arguments
        .against
        .as_deref()
        .zip(old.as_ref())
        .map(|(path, old)| {
            let platform = against::Platform::of(&run);
            against::compare(path, old, &results.json(), &platform, &rules)
        })
        .transpose()
        .map_err(Failure::input)?;
    let drift_words = drift.as_ref().map(against::words);
    let controls = controls::run(&inputs.claims, &inputs.published, &results.values)
        .map_err(Failure::input)?;
    let surroundings = Surroundings {
        command: command(arguments),
        run: run.clone(),
        drift,
        controls: controls.clone(),
        campaigns,
        repository: provenance::repository(&inputs.root),
        benchmarks: compose::Benchmarks::read(&inputs.root).map_err(Failure::Input)?,
        twice: twice.clone(),
        published: inputs.published.clone(),
        numbers: inputs.numbers.clone(),
        quick: basis.quick,
    };
    let document = compose::document(&results, surroundings);
    output::write(&out, &results, &document, &run)?;
    if let Some(words) = drift_words {
        say!("{words}");
    }
    if let Some(twice) = &twice {
        say!("twice     {}", twice.words());
    }
    let shipped = basis.data.is_none() && basis.model.is_none();
    let disagreements = if shipped {
        disagreements(&results)
    } else {
        Vec::new()
    };
    summary(&results, &inputs.numbers, &controls, &disagreements, &out);
    let faulty = !disagreements.is_empty()
        || controls.iter().any(|control| !control.passed())
        || twice.is_some_and(|twice| !twice.same());
    Ok(if faulty {
        Outcome::Disagrees
    } else {
        Outcome::Done
    })
}

/// Ids of the stages that a claim needs, with what these need.
pub(super) fn needed(all: &[&'static dyn Stage], claim: &Claim) -> Vec<String> {
    let wanted: Vec<&str> = claim.stages.iter().map(String::as_str).collect();
    closure(all, &wanted)
        .iter()
        .map(|stage| stage.id().to_owned())
        .collect()
}

/// The command that makes this page again; folders are the reader's own and stay out of the page.
fn command(arguments: &ReproduceArguments) -> String {
    let mut command = "cargo xtask reproduce".to_owned();
    if arguments.basis.data.is_some() {
        command += " --data DIR";
    }
    for stage in &arguments.stage {
        command += &format!(" --stage {stage}");
    }
    if arguments.basis.model.is_some() {
        command += " --model FILE";
    }
    if arguments.basis.quick {
        command += " --quick";
    }
    if arguments.twice {
        command += " --twice";
    }
    command
}

/// Verdicts and values that are not the pinned ones. What was not run disagrees with nothing.
pub(super) fn disagreements(results: &Results) -> Vec<String> {
    let mut found = Vec::new();
    for (claim, judged) in &results.claims {
        let ran = judged.verdict != Verdict::NotRun
            || claim
                .stages
                .iter()
                .all(|id| results.stages.iter().any(|stage| stage.id == id));
        if ran && judged.verdict != claim.expected {
            found.push(format!(
                "{}: {} (pinned: {})",
                claim.id,
                judged.verdict.word(),
                claim.expected.word()
            ));
        }
        for (id, [pinned, tolerance]) in &claim.pinned {
            let Some(value) = results.values.get(id) else {
                continue;
            };
            let off = value
                .value
                .is_none_or(|value| (value - pinned).abs() > *tolerance);
            if off {
                let now = value
                    .value
                    .map_or_else(|| "nothing".to_owned(), |value| value.to_string());
                found.push(format!(
                    "{}: {id} is {now} (pinned: {pinned} +- {tolerance})",
                    claim.id
                ));
            }
        }
    }
    found
}

/// Five lines.
fn summary(
    results: &Results,
    numbers: &Coverage,
    controls: &[NegativeControl],
    disagreements: &[String],
    out: &Path,
) {
    let counts: Vec<String> = compose::counts(results)
        .into_iter()
        .map(|(verdict, count)| format!("{count} {}", verdict.word()))
        .collect();
    let done = results
        .stages
        .iter()
        .filter(|stage| stage.status() == "done")
        .count();
    let passed = controls.iter().filter(|control| control.passed()).count();
    say!(
        "claims    {}; {}",
        counts.join(", "),
        compose::completeness_words(numbers)
    );
    say!("stages    {done} of {} done", results.stages.len());
    say!(
        "controls  {passed} of {} turned exactly the claims that they must",
        controls.len()
    );
    match disagreements {
        [] => say!("pinned    all verdicts and values as pinned"),
        some => say!("pinned    {} disagree: {}", some.len(), some.join("; ")),
    }
    say!("report    {}", out.join("report.html").display());
}

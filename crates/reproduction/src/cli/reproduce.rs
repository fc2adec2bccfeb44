//! `reproduce`: all stages, the ledger, the report.

use std::path::Path;

use report::{NegativeControl, Verdict};

use super::root::{out, root};
use super::{Failure, Outcome, ReproduceArguments, output, twice};
use crate::cache::{Cache, program_identity};
use crate::campaigns::Campaigns;
use crate::claims::{self, Claim};
use crate::compose::{self, Surroundings};
use crate::costs::Costs;
use crate::engine::{Engine, closure};
use crate::names::nearest;
use crate::numbers::{self, Coverage};
use crate::published::Published;
use crate::results::Results;
use crate::stage::{ModelText, Stage};
use crate::watch::Watch;
use crate::{against, controls, provenance, stages};

/// What every command reads that runs stages.
pub(super) struct Inputs {
    pub(super) root: std::path::PathBuf,
    pub(super) published: Published,
    pub(super) published_hash: String,
    pub(super) claims: Vec<Claim>,
    pub(super) numbers: Coverage,
    pub(super) campaigns: Campaigns,
}

impl Inputs {
    /// Reads published numbers and claims, and finds the campaigns.
    pub(super) fn read(data: Option<&Path>) -> Result<Self, Failure> {
        let root = root()?;
        let path = root.join("data/published.toml");
        let text = std::fs::read_to_string(&path)
            .map_err(|error| Failure::Input(format!("{}: {error}", path.display())))?;
        let published = Published::parse(&text).map_err(Failure::input)?;
        let claims = claims::read(&root.join("data/claims.toml")).map_err(Failure::input)?;
        let others =
            numbers::read(&root.join("data/other-numbers.toml")).map_err(Failure::input)?;
        Ok(Self {
            numbers: numbers::coverage(&published, &claims, &others),
            published,
            published_hash: blake3::hash(text.as_bytes()).to_hex().to_string(),
            claims,
            campaigns: Campaigns::new(&root.join("data/campaigns"), data)
                .map_err(Failure::input)?,
            root,
        })
    }

    /// Runs stages, keeping their outputs under `out`.
    pub(super) fn run(
        &self,
        stages: &[&'static dyn Stage],
        out: &Path,
        model: Option<&ModelText>,
        quick: bool,
    ) -> Result<Results, Failure> {
        let watch = Watch::new();
        let engine = Engine {
            published: &self.published,
            published_hash: self.published_hash.clone(),
            campaigns: &self.campaigns,
            model,
            quick,
            program: program_identity().map_err(Failure::output)?,
            cache: Cache::new(&out.join(".cache")),
            watch: &watch,
        };
        let finished = engine.run(stages);
        // A run whose times cannot be kept is a run all the same.
        if let Err(problem) = Costs::record(out, &finished) {
            eprintln!("the times of the stages cannot be kept: {problem}");
        }
        Results::new(finished, &self.claims, &self.published).map_err(Failure::input)
    }

    /// Opens every campaign that the stages need: bad input is refused before anything is computed.
    pub(super) fn open_all(
        &self,
        stages: &[&'static dyn Stage],
    ) -> Result<Vec<(String, &'static str)>, Failure> {
        let mut names: Vec<&str> = stages
            .iter()
            .flat_map(|stage| stage.needs().campaigns)
            .copied()
            .collect();
        names.sort_unstable();
        names.dedup();
        names
            .into_iter()
            .map(|name| {
                let campaign = self.campaigns.open(name).map_err(Failure::input)?;
                Ok((
                    name.to_owned(),
                    crate::evidence_of(campaign.provenance).word(),
                ))
            })
            .collect()
    }
}

pub(super) fn run(arguments: &ReproduceArguments) -> Result<Outcome, Failure> {
    let inputs = Inputs::read(arguments.data.as_deref())?;
    let all = stages::all();
    let stages = match &arguments.stage {
        Some(name) => one(&all, name)?,
        None => all.clone(),
    };
    let model = arguments.model.as_deref().map(read_model).transpose()?;
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
    let results = inputs.run(&stages, &out, model.as_ref(), arguments.quick)?;
    run.finished = provenance::now();
    let costs = Costs::read(&inputs.root, &out).map_err(Failure::input)?;
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
        quick: arguments.quick,
    };
    let document = compose::document(&results, surroundings);
    output::write(&out, &results, &document, &run)?;
    if let Some(words) = drift_words {
        println!("{words}");
    }
    if let Some(twice) = &twice {
        println!("twice     {}", twice.words());
    }
    let shipped = arguments.data.is_none() && arguments.model.is_none();
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

/// A stage by name with what it needs.
fn one(all: &[&'static dyn Stage], name: &str) -> Result<Vec<&'static dyn Stage>, Failure> {
    if all.iter().any(|stage| stage.id() == name) {
        return Ok(closure(all, &[name]));
    }
    let near = nearest(name, all.iter().map(|stage| stage.id()));
    Err(Failure::Input(format!(
        "no stage is called `{name}`; the nearest name is `{near}`"
    )))
}

/// Ids of the stages that a claim needs, with what these need.
pub(super) fn needed(all: &[&'static dyn Stage], claim: &Claim) -> Vec<String> {
    let wanted: Vec<&str> = claim.stages.iter().map(String::as_str).collect();
    closure(all, &wanted)
        .iter()
        .map(|stage| stage.id().to_owned())
        .collect()
}

fn read_model(path: &Path) -> Result<ModelText, Failure> {
    let text = std::fs::read_to_string(path)
        .map_err(|error| Failure::Input(format!("{}: {error}", path.display())))?;
    rig::ModelFile::load(path).map_err(Failure::input)?;
    Ok(ModelText {
        path: path.to_owned(),
        text,
    })
}

/// The command that makes this page again; folders are the reader's own and stay out of the page.
fn command(arguments: &ReproduceArguments) -> String {
    let mut command = "cargo xtask reproduce".to_owned();
    if arguments.data.is_some() {
        command += " --data DIR";
    }
    if let Some(stage) = &arguments.stage {
        command += &format!(" --stage {stage}");
    }
    if arguments.model.is_some() {
        command += " --model FILE";
    }
    if arguments.quick {
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
    println!(
        "claims    {}; {}",
        counts.join(", "),
        compose::completeness_words(numbers)
    );
    println!("stages    {done} of {} done", results.stages.len());
    println!(
        "controls  {passed} of {} turned exactly the claims that they must",
        controls.len()
    );
    match disagreements {
        [] => println!("pinned    all verdicts and values as pinned"),
        some => println!("pinned    {} disagree: {}", some.len(), some.join("; ")),
    }
    println!("report    {}", out.join("report.html").display());
}

//! Runs stages in the order of what they need, independent ones side by side, each once per content of its inputs.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use rayon::prelude::*;

use crate::cache::Cache;
use crate::campaigns::Campaigns;
use crate::parcel::Origin;
use crate::published::Published;
use crate::stage::{ModelText, Stage, StageContext, StageError, StageOutput, StageStatus};
use crate::watch::{Source, Watch};

/// What a run of stages needs besides the stages.
pub struct Engine<'a> {
    /// The paper's numbers.
    pub published: &'a Published,
    /// Hash of the text that they were read from.
    pub published_hash: String,
    /// The campaigns.
    pub campaigns: &'a Campaigns,
    /// An extended model.
    pub model: Option<&'a ModelText>,
    /// Fewer starts and repetitions.
    pub quick: bool,
    /// Hash of the program.
    pub program: String,
    /// Kept outputs.
    pub cache: Cache,
    /// Whoever watches.
    pub watch: &'a Watch,
}

/// One stage after the run.
#[derive(Clone, Debug)]
pub struct Finished {
    /// Its id.
    pub id: &'static str,
    /// Its output, or why there is none.
    pub output: Result<Arc<StageOutput>, String>,
    /// Inputs by path with their hashes.
    pub inputs: BTreeMap<String, String>,
    /// Wall time in this run, s: near zero where the output was kept.
    pub seconds: f64,
    /// Whether the output was kept from an earlier run.
    pub kept: bool,
    /// Key of its output: part of the keys of stages that need it.
    key: String,
}

/// One stage as a piece of work that any machine can do: what its output depends on, known before anything runs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Task {
    /// The stage.
    pub stage: &'static str,
    /// Everything that its output depends on.
    pub origin: Origin,
}

impl Task {
    /// Hash of all that the output depends on.
    #[must_use]
    pub fn key(&self) -> String {
        self.origin.key(self.stage)
    }
}

impl Finished {
    /// The words for `results.json`.
    #[must_use]
    pub fn status(&self) -> String {
        match &self.output {
            Ok(output) => output.status.words(),
            Err(problem) => format!("failed: {problem}"),
        }
    }
}

/// The stages named in `wanted` with everything that they need, in the order of `stages`.
#[must_use]
pub fn closure<'s>(stages: &[&'s dyn Stage], wanted: &[&str]) -> Vec<&'s dyn Stage> {
    let mut needed: BTreeSet<&str> = wanted.iter().copied().collect();
    // A stage stands behind those that it needs: one pass from the back finds them all.
    for stage in stages.iter().rev() {
        if needed.contains(stage.id()) {
            needed.extend(stage.needs().stages);
        }
    }
    stages
        .iter()
        .copied()
        .filter(|stage| needed.contains(stage.id()))
        .collect()
}

impl Engine<'_> {
    /// Runs the stages (closed under needs, in order); outputs come in the same order. Side by side or one after the
    /// other gives the same outputs, since a stage sees nothing but what it declared.
    #[must_use]
    pub fn run(&self, stages: &[&'static dyn Stage]) -> Vec<Finished> {
        let mut done: BTreeMap<&'static str, Finished> = BTreeMap::new();
        while done.len() < stages.len() {
            let ready: Vec<&&'static dyn Stage> = stages
                .iter()
                .filter(|stage| !done.contains_key(stage.id()))
                .filter(|stage| {
                    stage
                        .needs()
                        .stages
                        .iter()
                        .all(|need| done.contains_key(need))
                })
                .collect();
            assert!(!ready.is_empty(), "stages need each other in a circle");
            let outputs: Vec<Finished> = ready
                .par_iter()
                .map(|stage| self.run_one(**stage, &done))
                .collect();
            done.extend(outputs.into_iter().map(|finished| (finished.id, finished)));
        }
        stages
            .iter()
            .filter_map(|stage| done.remove(stage.id()))
            .collect()
    }

    fn run_one(
        &self,
        stage: &'static dyn Stage,
        done: &BTreeMap<&'static str, Finished>,
    ) -> Finished {
        let id = stage.id();
        self.watch.start(id, stage.title());
        let task = match self.task(stage, |need| done[need].key.clone()) {
            Ok(task) => task,
            Err(error) => {
                return self.finished(
                    id,
                    Err(error),
                    BTreeMap::new(),
                    String::new(),
                    Source::Computed,
                );
            }
        };
        let (inputs, key) = (task.origin.inputs.clone(), task.key());
        if let Some(kept) = self.cache.get(&task) {
            return self.finished(id, Ok(kept), inputs, key, Source::Kept);
        }
        let earlier: BTreeMap<String, Arc<StageOutput>> = done
            .iter()
            .filter_map(|(id, finished)| {
                Some(((*id).to_owned(), Arc::clone(finished.output.as_ref().ok()?)))
            })
            .collect();
        let context = StageContext {
            stage: id,
            declared: stage.needs(),
            published: self.published,
            quick: self.quick,
            model: self.model.filter(|_| stage.needs().model),
            campaigns: self.campaigns,
            earlier: &earlier,
            say: &|stage, line| self.watch.say(stage, line),
        };
        let output = self
            .missing(stage, done)
            .unwrap_or_else(|| stage.run(&context));
        // An output that cannot be kept is an output all the same: the next run computes it again.
        if let Ok(output) = &output
            && let Err(problem) = self.cache.put(&task, output)
        {
            self.watch.say(id, &problem.to_string());
        }
        self.finished(id, output, inputs, key, Source::Computed)
    }

    /// The output of a stage that cannot run because one that it needs failed.
    fn missing(
        &self,
        stage: &'static dyn Stage,
        done: &BTreeMap<&'static str, Finished>,
    ) -> Option<Result<StageOutput, StageError>> {
        let failed = stage
            .needs()
            .stages
            .iter()
            .find(|need| done[*need].output.is_err())?;
        let detail = format!("stage {failed} gave no output");
        Some(Ok(StageOutput {
            status: StageStatus::MissingInput(detail),
            ..StageOutput::done()
        }))
    }

    /// The stages (closed under needs, in order) as tasks. Nothing is computed: a key is made of inputs and of other keys.
    ///
    /// # Errors
    /// Where a campaign is refused at the door.
    pub fn plan(&self, stages: &[&'static dyn Stage]) -> Result<Vec<Task>, StageError> {
        let mut keys: BTreeMap<&str, String> = BTreeMap::new();
        let mut tasks = Vec::new();
        for stage in stages {
            let task = self.task(*stage, |need| keys[need].clone())?;
            keys.insert(task.stage, task.key());
            tasks.push(task);
        }
        Ok(tasks)
    }

    /// A stage as a task; `key_of` knows the keys of the stages that it needs.
    fn task(
        &self,
        stage: &'static dyn Stage,
        key_of: impl Fn(&str) -> String,
    ) -> Result<Task, StageError> {
        let needs = stage.needs();
        let mut inputs = BTreeMap::new();
        inputs.insert(
            "data/published.toml".to_owned(),
            self.published_hash.clone(),
        );
        for name in needs.campaigns {
            for (path, hash) in &self.campaigns.open(name)?.input_hashes {
                inputs.insert(format!("data/campaigns/{name}/{path}"), hash.clone());
            }
        }
        if let Some(model) = self.model.filter(|_| needs.model) {
            inputs.insert(
                "--model".to_owned(),
                blake3::hash(model.text.as_bytes()).to_hex().to_string(),
            );
        }
        let needs = needs.stages.iter();
        Ok(Task {
            stage: stage.id(),
            origin: Origin {
                program: self.program.clone(),
                quick: self.quick,
                inputs,
                needs: needs
                    .map(|need| ((*need).to_owned(), key_of(need)))
                    .collect(),
            },
        })
    }

    fn finished(
        &self,
        id: &'static str,
        output: Result<StageOutput, StageError>,
        inputs: BTreeMap<String, String>,
        key: String,
        source: Source,
    ) -> Finished {
        let output = output.map(Arc::new).map_err(|error| error.to_string());
        let mut finished = Finished {
            id,
            output,
            inputs,
            seconds: 0.0,
            kept: matches!(source, Source::Kept),
            key,
        };
        finished.seconds = self.watch.end(id, &finished.status(), source);
        finished
    }
}

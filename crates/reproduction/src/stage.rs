//! A stage: one part of the reproduction, a pure function of its inputs, cached by their content.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use campaign::Campaign;
use report::Value;
use serde::{Deserialize, Serialize};

use crate::campaigns::Campaigns;
use crate::published::{Published, PublishedError};

/// How a stage ended. Not converging is a result with a name, not an error.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "status", content = "detail")]
pub enum StageStatus {
    /// Everything that was asked for was computed.
    Done,
    /// Some numerics did not converge; the detail names which.
    NotConverged(String),
    /// An input that the stage needs is not there; the detail names it. Its claims are `not run`.
    MissingInput(String),
}

impl StageStatus {
    /// The words that stand in `results.json`.
    #[must_use]
    pub fn words(&self) -> String {
        match self {
            Self::Done => "done".to_owned(),
            Self::NotConverged(detail) => format!("not converged: {detail}"),
            Self::MissingInput(detail) => format!("missing input: {detail}"),
        }
    }
}

/// A table that goes to `tables/NAME.csv`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TableFile {
    /// File name without ending, unique in the reproduction: letters, digits and dashes.
    pub name: String,
    /// The file's text, header first.
    pub csv: String,
}

/// What a stage gives back. The same inputs give the same bytes, on one thread and on many.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct StageOutput {
    /// How it ended.
    pub status: StageStatus,
    /// Its numbers, for `results.json`.
    pub values: Vec<Value>,
    /// Its part of the page, in order.
    pub sections: Vec<report::Section>,
    /// Tables as files, beside those of the sections (which need not be repeated).
    pub tables: Vec<TableFile>,
    /// Exact counts of work done (iterations, evaluations): pinned by snapshots, never times.
    pub work: BTreeMap<String, u64>,
    /// What a later stage needs and is not a number: a model, a set of curves, as JSON.
    pub artefacts: BTreeMap<String, serde_json::Value>,
}

impl StageOutput {
    /// An empty output that is done.
    #[must_use]
    pub fn done() -> Self {
        Self {
            status: StageStatus::Done,
            values: Vec::new(),
            sections: Vec::new(),
            tables: Vec::new(),
            work: BTreeMap::new(),
            artefacts: BTreeMap::new(),
        }
    }

    /// The number with this id.
    #[must_use]
    pub fn value(&self, id: &str) -> Option<f64> {
        self.values
            .iter()
            .find(|value| value.id == id)
            .and_then(|value| value.value)
    }
}

/// Why a stage gave no output.
#[derive(Debug, thiserror::Error)]
pub enum StageError {
    /// A campaign was refused at the door.
    #[error(transparent)]
    Refused(#[from] campaign::Refusal),
    /// A published number is missing or broken.
    #[error(transparent)]
    Published(#[from] PublishedError),
    /// A stage asked for a campaign that it had not declared, or for the output of a stage that it does not need.
    #[error("stage {stage} asked for {wanted}, which it does not declare")]
    Undeclared {
        /// The stage.
        stage: String,
        /// What it asked for.
        wanted: String,
    },
    /// The model file cannot be used.
    #[error("{}: {problem}", path.display())]
    Model {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        problem: String,
    },
    /// Anything else that stopped it.
    #[error("{0}")]
    Failed(String),
}

/// What a stage may read.
pub struct StageContext<'a> {
    /// The stage that reads.
    pub(crate) stage: &'static str,
    /// Campaigns and stages that it declared.
    pub(crate) declared: Needs,
    /// The paper's numbers.
    pub published: &'a Published,
    /// Fewer starts and repetitions: for a look, not for the record.
    pub quick: bool,
    /// An extended model (`--model`) to use beside the paper's, parsed by whoever uses it.
    pub model: Option<&'a ModelText>,
    pub(crate) campaigns: &'a Campaigns,
    pub(crate) earlier: &'a BTreeMap<String, Arc<StageOutput>>,
    pub(crate) say: &'a (dyn Fn(&str, &str) + Sync),
}

/// A model file's path (for messages) and text.
#[derive(Clone, Debug)]
pub struct ModelText {
    /// Where it was read.
    pub path: PathBuf,
    /// Its text, JSON.
    pub text: String,
}

impl StageContext<'_> {
    /// The campaign with this name: the reader's own where `--data` brings it, else the stand-in.
    ///
    /// # Errors
    /// Where the door refuses it or the stage did not declare it.
    pub fn campaign(&self, name: &str) -> Result<Arc<Campaign>, StageError> {
        if !self.declared.campaigns.contains(&name) {
            return Err(self.undeclared(&format!("campaign {name}")));
        }
        Ok(self.campaigns.open(name)?)
    }

    /// The output of a stage that this one needs.
    ///
    /// # Errors
    /// Where the stage did not declare it.
    pub fn earlier(&self, stage: &str) -> Result<&StageOutput, StageError> {
        self.earlier
            .get(stage)
            .filter(|_| self.declared.stages.contains(&stage))
            .map(Arc::as_ref)
            .ok_or_else(|| self.undeclared(&format!("stage {stage}")))
    }

    /// A line of progress for whoever watches.
    pub fn say(&self, line: &str) {
        (self.say)(self.stage, line);
    }

    fn undeclared(&self, wanted: &str) -> StageError {
        StageError::Undeclared {
            stage: self.stage.to_owned(),
            wanted: wanted.to_owned(),
        }
    }
}

/// What a stage reads: the cache key is made of the content of exactly this, so reading more is an error.
#[derive(Clone, Copy, Debug, Default)]
pub struct Needs {
    /// Campaigns by the name of their folder.
    pub campaigns: &'static [&'static str],
    /// Earlier stages by id.
    pub stages: &'static [&'static str],
    /// Whether the result depends on `--model`.
    pub model: bool,
}

/// One part of the reproduction. One file each in `stages/`.
pub trait Stage: Sync {
    /// The id in `--stage`, in results and in value ids.
    fn id(&self) -> &'static str;
    /// A title for the stage tree.
    fn title(&self) -> &'static str;
    /// What it reads.
    fn needs(&self) -> Needs;
    /// Computes it.
    ///
    /// # Errors
    /// Where an input cannot be used. Numerics that do not converge are a status of the output.
    fn run(&self, context: &StageContext<'_>) -> Result<StageOutput, StageError>;
}

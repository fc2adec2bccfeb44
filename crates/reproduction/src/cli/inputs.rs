//! What every command reads that runs stages.

use std::path::Path;

use super::root::root;
use super::{Basis, Failure};
use crate::cache::{self, Cache, program_identity};
use crate::campaigns::Campaigns;
use crate::claims::{self, Claim};
use crate::costs::Costs;
use crate::engine::{Engine, Finished, closure};
use crate::names::nearest;
use crate::numbers::{self, Coverage};
use crate::published::Published;
use crate::results::Results;
use crate::stage::{ModelText, Stage};
use crate::watch::Watch;

/// Published numbers, claims and campaigns.
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

    /// The engine over these inputs.
    pub(super) fn engine<'a>(
        &'a self,
        cache: Cache,
        model: Option<&'a ModelText>,
        quick: bool,
        watch: &'a Watch,
    ) -> Result<Engine<'a>, Failure> {
        Ok(Engine {
            published: &self.published,
            published_hash: self.published_hash.clone(),
            campaigns: &self.campaigns,
            model,
            quick,
            program: program_identity().map_err(Failure::output)?,
            cache,
            watch,
        })
    }

    /// Runs stages, keeping their outputs under `out`, and judges the claims.
    pub(super) fn run(
        &self,
        stages: &[&'static dyn Stage],
        out: &Path,
        model: Option<&ModelText>,
        quick: bool,
    ) -> Result<Results, Failure> {
        let kept = cache::folder(out);
        let watch = Watch::new();
        let engine = self.engine(Cache::new(&kept), model, quick, &watch)?;
        let finished = engine.run(stages);
        keep_times(&kept, &finished);
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

/// Keeps the times of the stages that were computed. A run whose times cannot be kept is a run all the same.
pub(super) fn keep_times(kept: &Path, finished: &[Finished]) {
    if let Err(problem) = Costs::record(kept, finished) {
        say_aside!("the times of the stages cannot be kept: {problem}");
    }
}

/// The stages with these names and what they need, in the order of the report; all of them without a name.
pub(super) fn stages_named(
    all: &[&'static dyn Stage],
    names: &[String],
) -> Result<Vec<&'static dyn Stage>, Failure> {
    if names.is_empty() {
        return Ok(all.to_vec());
    }
    let known = || all.iter().map(|stage| stage.id());
    if let Some(name) = names.iter().find(|name| known().all(|id| id != **name)) {
        let near = nearest(name, known());
        return Err(Failure::Input(format!(
            "no stage is called `{name}`; the nearest name is `{near}`"
        )));
    }
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    Ok(closure(all, &names))
}

impl Basis {
    /// The model file, checked.
    pub(super) fn model(&self) -> Result<Option<ModelText>, Failure> {
        self.model.as_deref().map(read_model).transpose()
    }
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

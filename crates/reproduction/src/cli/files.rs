//! Reading laws and models, writing answers.

use std::path::Path;

use campaign::Campaign;
use friction::LawKind;
use serde::Serialize;

use super::Failure;
use crate::names::nearest;

/// The law by name, or the default: the asymmetric bristle where the specimen has a layout, else LuGre.
pub(super) fn law(name: Option<&str>, campaign: &Campaign) -> Result<LawKind, Failure> {
    match name {
        None => Ok(diagnosis::default_law(campaign)),
        Some(name) => LawKind::from_id(name).map_err(|_| {
            let near = nearest(name, LawKind::ALL.iter().map(|law| law.id()));
            Failure::Input(format!(
                "no law is called `{name}`; the nearest name is `{near}`"
            ))
        }),
    }
}

/// A model file that reads, with the nearest name for a cause that is not in the catalogue.
pub(super) fn model(path: &Path) -> Result<rig::ModelFile, Failure> {
    let model = rig::ModelFile::load(path).map_err(Failure::input)?;
    let catalogue = diagnosis::causes::catalogue();
    for entry in &model.extension {
        if !catalogue.iter().any(|cause| cause.id() == entry.cause) {
            let near = nearest(&entry.cause, catalogue.iter().map(|cause| cause.id()));
            return Err(Failure::Input(format!(
                "{}: no cause is called `{}`; the nearest name is `{near}`",
                path.display(),
                entry.cause
            )));
        }
    }
    model
        .extension_from(&catalogue)
        .map_err(|problem| Failure::Input(format!("{}: {problem}", path.display())))?;
    Ok(model)
}

/// Writes JSON, if a file was named.
pub(super) fn json(path: Option<&Path>, answer: &impl Serialize) -> Result<(), Failure> {
    let Some(path) = path else { return Ok(()) };
    let text = serde_json::to_string_pretty(answer).map_err(Failure::output)?;
    campaign::write_atomically(path, (text + "\n").as_bytes()).map_err(Failure::output)
}

/// Writes a page, if a file was named.
pub(super) fn page(
    path: Option<&Path>,
    document: impl FnOnce() -> report::Document,
) -> Result<(), Failure> {
    let Some(path) = path else { return Ok(()) };
    let page = report::render(&document()).map_err(Failure::output)?;
    campaign::write_atomically(path, page.as_bytes()).map_err(Failure::output)
}

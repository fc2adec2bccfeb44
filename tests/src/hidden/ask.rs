//! Puts a planted package before the diagnosis, which gets the written folder and nothing else.

use std::path::Path;

use diagnosis::{Curves, Options, diagnose_fully};
use friction::LawKind;
use planting::machine::run_day;
use planting::plan::Noise;
use planting::{Base, Case, Outcome};
use serde_json::Value;

use crate::hidden::oracle::Oracle;

/// An answer and the curves behind it.
pub struct Answer {
    /// The answer as in its JSON.
    pub json: Value,
    /// Fitted curves, in the order of the day.
    pub curves: Curves,
}

/// The law that the reader of a campaign on this rig would ask for; `None`: the program's default.
pub fn asked_law(base: Base) -> Option<LawKind> {
    match base {
        Base::AsymmetricBristle => None,
        Base::SymmetricBristle => Some(LawKind::SymmetricBristle),
        Base::Lugre => Some(LawKind::Lugre),
        Base::Dahl => Some(LawKind::Dahl),
        Base::Stribeck => Some(LawKind::Stribeck),
        Base::CoulombViscous => Some(LawKind::CoulombViscous),
    }
}

/// Diagnoses the package in `folder`.
///
/// # Errors
/// What the door or the diagnosis refuses, in words.
pub fn ask_folder(folder: &Path, options: &Options) -> Result<Answer, String> {
    let campaign = campaign::open(folder).map_err(|refusal| refusal.to_string())?;
    let diagnosed = diagnose_fully(&campaign, options).map_err(|error| error.to_string())?;
    let json = serde_json::to_value(&diagnosed.answer).map_err(|error| error.to_string())?;
    Ok(Answer {
        json,
        curves: diagnosed.curves,
    })
}

/// Writes the files of an outcome into a folder of its own and diagnoses them.
///
/// # Errors
/// What the file system, the door or the diagnosis refuses, in words.
pub fn ask(files: &[(String, String)], options: &Options) -> Result<Answer, String> {
    let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
    planting::package::write(folder.path(), files).map_err(|error| error.to_string())?;
    ask_folder(folder.path(), options)
}

/// The share of the law's error against the noise-free truth that the extension removes, as the oracle weighs errors.
///
/// # Errors
/// If the case cannot be set up.
pub fn true_gain(
    oracle: &Oracle,
    case: &Case,
    outcome: &Outcome,
    curves: &Curves,
) -> Result<f64, String> {
    let (rig, plan, _) = case.set_up()?;
    let truth: Vec<f64> = run_day(&rig, &plan, &Noise::NONE, 0)
        .into_iter()
        .flat_map(|run| run.force_n)
        .collect();
    if truth.len() != curves.law.len() || outcome.recordings.len() != curves.runs.len() {
        return Err("the curves do not fit the day".into());
    }
    Ok(oracle.true_gain(&truth, &curves.law, &curves.extended))
}

//! Error on runs that the fit has not seen: one run of each condition is left out in turn.

use campaign::Campaign;
use rayon::prelude::*;
use rig::Experiment;

use crate::identify::{Identification, identify};
use crate::question::{IdentificationError, Question};

/// Held-out error, in the unit of y = F/N (of the force itself without a load).
#[derive(Clone, Debug, PartialEq)]
pub struct HeldOut {
    /// Root mean square over all left-out samples.
    pub rmse: f64,
    /// The same for each fold.
    pub folds: Vec<f64>,
    /// Runs left out in each fold, by index in the campaign.
    pub left_out: Vec<Vec<usize>>,
}

/// Folds: the k-th leaves out the k-th run of every condition that has repeats; empty without repeats.
pub fn folds(campaign: &Campaign) -> Vec<Vec<usize>> {
    let conditions = campaign.conditions();
    let most = conditions.iter().map(Vec::len).max().unwrap_or(0);
    if most < 2 {
        return Vec::new();
    }
    (0..most)
        .map(|k| {
            conditions
                .iter()
                .filter(|c| c.len() > 1)
                .filter_map(|c| c.get(k).copied())
                .collect()
        })
        .filter(|fold: &Vec<usize>| !fold.is_empty() && fold.len() < campaign.runs.len())
        .collect()
}

/// Fits every fold anew (parameters and noise, beginning at the whole campaign's answer) and predicts what was left out.
///
/// The bent state at the start of a left-out run is no property of the law: it is taken from the whole fit.
///
/// # Errors
/// When a fold cannot be fitted; `Ok(None)` without repeats.
pub fn held_out(
    campaign: &Campaign,
    whole: &Identification,
    question: &Question,
) -> Result<Option<HeldOut>, IdentificationError> {
    let folds = folds(campaign);
    if folds.is_empty() {
        return Ok(None);
    }
    let question = question.clone().values_only().near(whole);
    let errors: Vec<(f64, usize)> = folds
        .par_iter()
        .map(|fold| fold_error(campaign, whole, &question, fold))
        .collect::<Result<_, _>>()?;
    let (sum, count) = errors
        .iter()
        .fold((0.0, 0), |(s, c), (square, n)| (s + square, c + n));
    Ok(Some(HeldOut {
        rmse: (sum / count.max(1) as f64).sqrt(),
        folds: errors
            .iter()
            .map(|(square, n)| (square / (*n).max(1) as f64).sqrt())
            .collect(),
        left_out: folds,
    }))
}

/// Sum of squares and number of left-out samples in contact.
fn fold_error(
    campaign: &Campaign,
    whole: &Identification,
    question: &Question,
    fold: &[usize],
) -> Result<(f64, usize), IdentificationError> {
    let mut kept = campaign.clone();
    kept.runs = campaign
        .runs
        .iter()
        .enumerate()
        .filter(|(k, _)| !fold.contains(k))
        .map(|(_, run)| run.clone())
        .collect();
    let part = identify(&kept, question)?;
    let experiment = Experiment::new(campaign)?;
    let mut parameters = whole.parameters.clone();
    for (slot, estimate) in parameters.iter_mut().zip(&part.estimates) {
        *slot = estimate.value;
    }
    let predicted = whole.model.predict(&experiment, &parameters);
    let (mut sum, mut count) = (0.0, 0);
    for &k in fold {
        let run = &experiment.runs[k];
        for (i, load) in run.samples.clone().zip(&run.load_n) {
            if *load > 0.0 {
                sum += ((predicted[i] - experiment.measured_n[i]) / load).powi(2);
                count += 1;
            }
        }
    }
    Ok((sum, count))
}

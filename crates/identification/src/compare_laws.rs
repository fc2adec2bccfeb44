//! All laws on the same data, side by side.

use campaign::Campaign;
use friction::LawKind;
use rayon::prelude::*;

use crate::held_out::{HeldOut, held_out};
use crate::identify::{Identification, identify};
use crate::question::{IdentificationError, Question};
use crate::thinning::thinned;

/// One law on a campaign.
pub struct LawFit {
    /// The law.
    pub law: LawKind,
    /// Its identification, or why there is none.
    pub identification: Result<Identification, IdentificationError>,
    /// Error on held-out runs; `None` without repeats or identification.
    pub held_out: Option<HeldOut>,
    /// Whether the law by itself can make friction depend on direction.
    pub directional: bool,
    /// Ratio of the predicted mean |force| forward over reverse; `None` where one direction is missing.
    pub direction_ratio: Option<f64>,
}

/// Samples beyond which laws are compared on a thinned record: their differences are far larger than what it loses.
const MOST: usize = 6000;

/// Fits every law to a campaign: values and noise, no intervals. `found` is the answer to the plain question for one of them:
/// its law is not fitted again, unless the comparison is made on fewer samples.
pub fn compare_laws(campaign: &Campaign, found: &Identification) -> Vec<LawFit> {
    let whole = campaign;
    let campaign = &thinned(whole, MOST);
    let samples = |c: &Campaign| -> usize { c.runs.iter().map(|run| run.time_s.len()).sum() };
    let known = Some(found).filter(|_| samples(campaign) == samples(whole));
    LawKind::ALL
        .par_iter()
        .map(|&law| {
            let identification = match known.filter(|found| found.law == law) {
                Some(found) => Ok(found.clone()),
                None => identify(campaign, &Question::of(law).values_only()),
            };
            let held = identification
                .as_ref()
                .ok()
                .and_then(|whole| held_out(campaign, whole, &Question::of(law)).ok().flatten());
            let direction_ratio = identification
                .as_ref()
                .ok()
                .and_then(|i| direction_ratio(campaign, &i.predicted_n));
            LawFit {
                law,
                identification,
                held_out: held,
                directional: law.is_directional(),
                direction_ratio,
            }
        })
        .collect()
}

/// Mean |force| over forward samples over that over reverse samples, above half of the top speed.
fn direction_ratio(campaign: &Campaign, force_n: &[f64]) -> Option<f64> {
    let top = campaign
        .runs
        .iter()
        .flat_map(|run| &run.velocity_m_s)
        .fold(0.0_f64, |t, v| t.max(v.abs()));
    let mean = |sign: f64| {
        let (sum, count) = campaign
            .runs
            .iter()
            .flat_map(|run| &run.velocity_m_s)
            .zip(force_n)
            .filter(|(v, _)| **v * sign > 0.5 * top)
            .fold((0.0, 0_usize), |(s, c), (_, f)| (s + f.abs(), c + 1));
        (count > 0).then(|| sum / count as f64)
    };
    Some(mean(1.0)? / mean(-1.0)?)
}

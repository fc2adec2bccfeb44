//! All laws on the same data under one noise model: which of them fits better.

use friction::LawKind;
use rayon::prelude::*;
use rig::Model;

use crate::answer::LawFit;
use crate::bench::Bench;
use crate::floor;
use crate::samples::Samples;
use crate::selection::Selected;
use crate::stand::{gain_matrix, scatter_deviance};
use crate::whole::Whole;

/// A law whose rough fits stay this many times above the noise is not carried to its end: the last digits of its error decide nothing.
const HOPELESS: f64 = 10.0;

/// Fits of all laws alone, best first; laws that do not go with the campaign are left out.
pub(crate) fn compare(bench: &Bench<'_>, whole: &Whole<'_>, selected: &Selected) -> Vec<LawFit> {
    let stand = &selected.baseline;
    let subset = &selected.subset;
    let context = subset.context_of(bench, &stand.fitted);
    let gains = stand.whitener.whiten_columns(&gain_matrix(&context));
    let n = subset.len() as f64;
    // Half of what a law's residual is under this noise where it fits as well as noise allows, times how much worse is out of the race.
    let hopeless = HOPELESS * 0.5 * n;
    let fits: Vec<Option<(LawKind, f64, f64)>> = LawKind::ALL
        .par_iter()
        .map(|&law| {
            let fitted = if law == bench.law {
                stand.fitted.clone()
            } else {
                let experiment = bench.experiment.clone();
                Model::new(law, Vec::new(), &experiment).ok()?;
                let other = Bench {
                    campaign: bench.campaign,
                    experiment,
                    samples: Samples::clone(&bench.samples),
                    law,
                    catalogue: Vec::new(),
                    prior: None,
                    stated_sensor: bench.stated_sensor,
                    repeats: bench.repeats,
                    masked: bench.masked.clone(),
                    step_n: bench.step_n,
                };
                other.law_fit(subset, &stand.sizes, hopeless)?
            };
            let residual = subset.gather(&bench.samples.force) - subset.gather(&fitted.prediction);
            let deviance = scatter_deviance(&gains, &stand.whitener.whiten(&residual));
            let k = law.parameters().len() as f64 + 1.0;
            let aicc = deviance + 2.0 * k + 2.0 * k * (k + 1.0) / (n - k - 1.0).max(1.0);
            let rmse = floor::rmse(whole.bench, &whole.prediction(&fitted), None);
            Some((law, rmse, aicc))
        })
        .collect();
    let mut fits: Vec<(LawKind, f64, f64)> = fits
        .into_iter()
        .flatten()
        .filter(|f| f.2.is_finite())
        .collect();
    fits.sort_by(|a, b| a.2.total_cmp(&b.2).then(a.0.cmp(&b.0)));
    let best = fits.first().map_or(0.0, |f| f.2);
    fits.into_iter()
        .map(|(law, rmse, aicc)| LawFit {
            law: law.id().into(),
            rmse,
            delta_aicc: aicc - best,
        })
        .collect()
}

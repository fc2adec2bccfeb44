//! Does 95 % mean 95 %? Campaigns are simulated from known parameters and noise, identified like any other, and the
//! share of intervals that hold the truth is counted.
//!
//! Every fit begins at the truth: what is checked are the intervals, not the search for the minimum.

use campaign::Campaign;
use fitting::noise::Sizes;
use friction::LawKind;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use rig::{Experiment, Model};

use crate::identify::identify;
use crate::intervals::LEVEL;
use crate::question::{IdentificationError, Question};
use crate::resampling::resample_runs;
use crate::simulate::with_fresh_noise;

/// What is simulated.
#[derive(Clone, Debug)]
pub struct Truth {
    /// The law.
    pub law: LawKind,
    /// Its parameters.
    pub parameters: Vec<f64>,
    /// The noise.
    pub noise: Sizes,
}

/// Counts for one parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterCoverage {
    /// Name.
    pub name: String,
    /// Truth.
    pub truth: f64,
    /// Campaigns whose interval holds the truth.
    pub covered: usize,
    /// Campaigns whose interval lies above the truth.
    pub above: usize,
    /// Campaigns whose interval lies below the truth.
    pub below: usize,
    /// Campaigns with the estimate on a bound.
    pub at_bound: usize,
    /// Campaigns whose bootstrap interval holds the truth, of those that were resampled.
    pub bootstrap_covered: usize,
    /// Median of the larger half width of the interval over |truth|.
    pub median_half_width: f64,
    /// Median of the degrees of freedom.
    pub median_degrees: f64,
    /// Median share of the variance that comes from the gains of runs.
    pub median_gain_share: f64,
    /// Mean of (estimate - truth) over the mean standard deviation: bias in its own units.
    pub bias: f64,
}

/// Result of a coverage run.
#[derive(Clone, Debug, PartialEq)]
pub struct Coverage {
    /// Campaigns simulated.
    pub campaigns: usize,
    /// Campaigns that converged; the others count as not covered.
    pub converged: usize,
    /// Campaigns whose intervals were also taken by bootstrap over runs.
    pub resampled: usize,
    /// One entry a parameter.
    pub parameters: Vec<ParameterCoverage>,
}

/// Bootstrap draws a campaign.
const DRAWS: usize = 399;

/// One parameter in one campaign.
#[derive(Clone, Copy)]
struct One {
    value: f64,
    sd: f64,
    low: f64,
    high: f64,
    at_bound: bool,
    degrees: f64,
    gain_share: f64,
    bootstrap: Option<bool>,
}

/// Simulates and identifies `count` campaigns on the motions of `template`; stream k of `seed` makes campaign k.
/// Every `resample_every`-th campaign is also resampled (0: none).
///
/// # Errors
/// When the template cannot be predicted.
pub fn coverage(
    template: &Campaign,
    truth: &Truth,
    count: usize,
    seed: u64,
    resample_every: usize,
) -> Result<Coverage, IdentificationError> {
    let experiment = Experiment::new(template)?;
    let force =
        Model::new(truth.law, Vec::new(), &experiment)?.predict(&experiment, &truth.parameters);
    let names: Vec<String> = truth
        .law
        .parameters()
        .iter()
        .map(|s| s.name.to_string())
        .collect();
    let outcomes: Vec<Option<Vec<One>>> = (0..count)
        .into_par_iter()
        .map(|k| {
            let mut generator = ChaCha8Rng::seed_from_u64(seed);
            generator.set_stream(k as u64);
            let simulated =
                with_fresh_noise(template, &experiment, &force, &truth.noise, &mut generator);
            let resample = resample_every > 0 && k % resample_every == 0;
            one_campaign(
                &simulated,
                truth,
                &names,
                resample.then_some(seed ^ k as u64),
            )
        })
        .collect();
    let parameters = names
        .iter()
        .enumerate()
        .map(|(j, name)| {
            let all: Vec<One> = outcomes.iter().flatten().map(|o| o[j]).collect();
            summarise(name, truth.parameters[j], &all)
        })
        .collect();
    Ok(Coverage {
        campaigns: count,
        converged: outcomes.iter().flatten().count(),
        resampled: outcomes
            .iter()
            .flatten()
            .filter(|o| o.iter().any(|one| one.bootstrap.is_some()))
            .count(),
        parameters,
    })
}

/// `None` where the fit did not converge.
fn one_campaign(
    simulated: &Campaign,
    truth: &Truth,
    names: &[String],
    resample_seed: Option<u64>,
) -> Option<Vec<One>> {
    let mut question = Question::of(truth.law);
    question.test_fit = false;
    question.near = Some(
        names
            .iter()
            .cloned()
            .zip(truth.parameters.iter().copied())
            .collect(),
    );
    let found = identify(simulated, &question).ok()?;
    if !found.status.converged() {
        return None;
    }
    let draws = resample_seed.and_then(|seed| resample_runs(simulated, &found, DRAWS, seed).ok());
    let inside: Vec<&str> = found
        .estimates
        .iter()
        .filter(|e| !e.held && e.at_bound.is_none())
        .map(|e| e.name.as_str())
        .collect();
    found
        .estimates
        .iter()
        .zip(&truth.parameters)
        .map(|(e, truth)| {
            let interval = e.interval.as_ref()?;
            let bootstrap = draws.as_ref().and_then(|d| {
                let column = inside.iter().position(|n| *n == e.name)?;
                let (low, high) = d.percentile_interval(column, LEVEL)?;
                Some(low <= *truth && *truth <= high)
            });
            Some(One {
                value: e.value,
                sd: e.sd.unwrap_or(f64::NAN),
                low: interval.low(),
                high: interval.high(),
                at_bound: e.at_bound.is_some(),
                degrees: e.drivers.map_or(f64::NAN, |d| d.degrees),
                gain_share: e.drivers.map_or(f64::NAN, |d| d.gain_share),
                bootstrap,
            })
        })
        .collect()
}

fn summarise(name: &str, truth: f64, all: &[One]) -> ParameterCoverage {
    let count = |test: &dyn Fn(&One) -> bool| all.iter().filter(|o| test(o)).count();
    let median = |of: &dyn Fn(&One) -> f64| {
        let mut values: Vec<f64> = all.iter().map(of).filter(|v| !v.is_nan()).collect();
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
    };
    let mean = |of: &dyn Fn(&One) -> f64| {
        let values: Vec<f64> = all.iter().map(of).filter(|v| v.is_finite()).collect();
        values.iter().sum::<f64>() / values.len().max(1) as f64
    };
    ParameterCoverage {
        name: name.to_owned(),
        truth,
        covered: count(&|o| o.low <= truth && truth <= o.high),
        above: count(&|o| o.low > truth),
        below: count(&|o| o.high < truth),
        at_bound: count(&|o| o.at_bound),
        bootstrap_covered: count(&|o| o.bootstrap == Some(true)),
        median_half_width: median(&|o| (o.high - o.value).max(o.value - o.low)) / truth.abs(),
        median_degrees: median(&|o| o.degrees),
        median_gain_share: median(&|o| o.gain_share),
        bias: (mean(&|o| o.value) - truth) / mean(&|o| o.sd),
    }
}

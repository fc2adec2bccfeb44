//! Does 95 % mean 95 %? Campaigns are simulated from known parameters and noise, identified like any other, and the
//! share of intervals that hold the truth is counted.
//!
//! Every fit begins at the truth: what is checked are the intervals, not the search for the minimum.

use campaign::Campaign;
use fitting::noise::Sizes;
use friction::LawKind;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rig::{Experiment, Model};

use crate::band::prediction_band;
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

/// One parameter in one simulated campaign.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Simulated {
    /// Estimate.
    pub value: f64,
    /// Standard deviation by the covariance, not a number where there is none.
    pub sd: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end of the interval.
    pub high: f64,
    /// Whether the estimate lies on a bound.
    pub at_bound: bool,
    /// Degrees of freedom of the interval's quantile.
    pub degrees: f64,
    /// Share of the variance that comes from the gains of runs.
    pub gain_share: f64,
    /// Whether the bootstrap's interval holds the truth, where it was taken.
    pub bootstrap: Option<bool>,
}

/// Simulates and identifies campaigns one at a time on the motions of a template; stream k of the seed makes campaign
/// k, so campaigns can be made in any order and at any time.
pub struct Simulation<'a> {
    template: &'a Campaign,
    experiment: Experiment,
    force_n: Vec<f64>,
    truth: &'a Truth,
    seed: u64,
    resample_every: usize,
}

impl<'a> Simulation<'a> {
    /// Every `resample_every`-th campaign is also resampled over runs (0: none).
    ///
    /// # Errors
    /// When the template cannot be predicted.
    pub fn new(
        template: &'a Campaign,
        truth: &'a Truth,
        seed: u64,
        resample_every: usize,
    ) -> Result<Self, IdentificationError> {
        let experiment = Experiment::new(template)?;
        let force_n =
            Model::new(truth.law, Vec::new(), &experiment)?.predict(&experiment, &truth.parameters);
        Ok(Self {
            template,
            experiment,
            force_n,
            truth,
            seed,
            resample_every,
        })
    }

    /// Campaign k, one entry a parameter of the law; `None` where the fit did not converge.
    #[must_use]
    pub fn campaign(&self, k: usize) -> Option<Vec<Simulated>> {
        let simulated = self.drawn(k as u64);
        let resample = self.resample_every > 0 && k.is_multiple_of(self.resample_every);
        one_campaign(
            &simulated,
            self.truth,
            resample.then_some(self.seed ^ k as u64),
        )
    }

    /// Share of the samples of another campaign of the same truth that lie in the band predicted from campaign k; `None`
    /// where the fit did not converge.
    #[must_use]
    pub fn share_in_band(&self, k: usize) -> Option<f64> {
        let question = near_the(self.truth).values_only();
        let found = identify(&self.drawn(k as u64), &question).ok()?;
        if !found.status.converged() {
            return None;
        }
        let other = Experiment::new(&self.drawn(PREDICTED + k as u64)).ok()?;
        let model = Model::new(self.truth.law, Vec::new(), &other).ok()?;
        let band = prediction_band(&other, &model, &found.parameters, &found.spread()?);
        Some(band.share_inside(&other))
    }

    fn drawn(&self, stream: u64) -> Campaign {
        let mut generator = ChaCha8Rng::seed_from_u64(self.seed);
        generator.set_stream(stream);
        with_fresh_noise(
            self.template,
            &self.experiment,
            &self.force_n,
            &self.truth.noise,
            &mut generator,
        )
    }
}

/// Streams from here on belong to campaigns that are predicted.
const PREDICTED: u64 = 1 << 32;

/// Counts over campaigns.
#[must_use]
pub fn coverage(truth: &Truth, outcomes: &[Option<Vec<Simulated>>]) -> Coverage {
    let parameters = truth
        .law
        .parameters()
        .iter()
        .enumerate()
        .map(|(j, spec)| {
            let all: Vec<Simulated> = outcomes.iter().flatten().map(|o| o[j]).collect();
            summarise(&spec.name, truth.parameters[j], &all)
        })
        .collect();
    Coverage {
        campaigns: outcomes.len(),
        converged: outcomes.iter().flatten().count(),
        resampled: outcomes
            .iter()
            .flatten()
            .filter(|o| o.iter().any(|one| one.bootstrap.is_some()))
            .count(),
        parameters,
    }
}

fn near_the(truth: &Truth) -> Question {
    let names = truth
        .law
        .parameters()
        .iter()
        .map(|spec| spec.name.to_string());
    let mut question = Question::of(truth.law);
    question.near = Some(names.zip(truth.parameters.iter().copied()).collect());
    question
}

/// `None` where the fit did not converge.
fn one_campaign(
    simulated: &Campaign,
    truth: &Truth,
    resample_seed: Option<u64>,
) -> Option<Vec<Simulated>> {
    let mut question = near_the(truth);
    question.test_fit = false;
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
            Some(Simulated {
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

fn summarise(name: &str, truth: f64, all: &[Simulated]) -> ParameterCoverage {
    let count = |test: &dyn Fn(&Simulated) -> bool| all.iter().filter(|o| test(o)).count();
    let median = |of: &dyn Fn(&Simulated) -> f64| {
        let mut values: Vec<f64> = all.iter().map(of).filter(|v| !v.is_nan()).collect();
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
    };
    let mean = |of: &dyn Fn(&Simulated) -> f64| {
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

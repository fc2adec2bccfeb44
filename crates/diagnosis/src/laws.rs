//! All laws on the same data under one noise model: which of them fits better.
//!
//! Each law is fitted alone as if it had been asked for (the one that was is fitted already), under noise that multiplies its own
//! friction. They are compared under one noise, that beneath the law r whose first fit errs least, with its scatter between runs: a
//! run's gain belongs to the rig and not to the law. Were the scatter each law's own, one that predicts next to nothing would call the whole record gains and
//! pay a logarithm a run. With p parameters (the scatter among them) and n samples
//!
//! ```text
//! S = max { s : D_r(s) <= min D_r + 3.84 },   criterion = min over s <= S of D(s) + 2 p + 2 p (p + 1) / (n - p - 1)    (D10)
//! ```
//!
//! with D(s) of (D9) under the noise of r, and 3.84 the 95 % quantile of chi-squared with one degree of freedom. S is a bound and
//! no value, lest two laws that fit nearly alike were told apart by the scatter at which one of them happens to be likeliest.

use fitting::noise::Sizes;
use friction::LawKind;
use nalgebra::DMatrix;
use rayon::prelude::*;
use rig::Model;

use crate::answer::LawFit;
use crate::bench::{Bench, Fitted};
use crate::floor;
use crate::scatter::ScatterDeviance;
use crate::selection::Selected;
use crate::settled::under_its_noise;
use crate::stand::{Likelihood, Stand, gain_matrix};
use crate::subset::Subset;
use crate::whole::Whole;

/// A law whose rough fits stay this many times above the noise is not carried to its end: the last digits of its error decide nothing.
const HOPELESS: f64 = 10.0;
/// Steps of a fit under a law's own noise, and how often noise and fit follow each other at most.
const STEPS: u64 = 20;
const ROUNDS: usize = 4;
/// What a round must save of -2 log likelihood to be followed by another.
const WORTH: f64 = 0.1;

/// Fits of all laws alone, best first; laws that do not go with the campaign are left out.
pub(crate) fn compare(bench: &Bench<'_>, whole: &Whole<'_>, selected: &Selected) -> Vec<LawFit> {
    let subset = &selected.subset;
    let mut laws: Vec<Contender<'_>> = LawKind::ALL
        .par_iter()
        .filter_map(|&law| {
            let own = (law == bench.law).then(|| selected.baseline.fitted.clone());
            Contender::new(bench, subset, law, own)
        })
        .collect();
    let Some(nearest) = laws.iter().min_by(|a, b| a.error().total_cmp(&b.error())) else {
        return Vec::new();
    };
    // The noise beneath the law that was asked for is known.
    let other = Some(nearest)
        .filter(|law| law.bench.law != bench.law)
        .and_then(|law| Some((law.bench.law, law.stand(subset)?)));
    let judge = match &other {
        Some((law, stand)) => Judge::new(bench, subset, *law, stand),
        None => Judge::new(bench, subset, bench.law, &selected.baseline),
    };
    let mut fits: Vec<(LawKind, f64, f64)> = laws
        .par_iter_mut()
        .map(|law| {
            law.settle(&judge, subset);
            let rmse = floor::rmse(whole.bench, &whole.prediction(&law.fitted), None);
            (law.bench.law, rmse, judge.criterion(law, subset))
        })
        .collect();
    fits.retain(|f| f.2.is_finite());
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

/// A law, fitted alone.
struct Contender<'a> {
    bench: Bench<'a>,
    fitted: Fitted,
}

impl<'a> Contender<'a> {
    /// A law as it is `fitted` already, or from its own starts. `None` where it does not go with the campaign.
    fn new(
        bench: &Bench<'a>,
        subset: &Subset,
        law: LawKind,
        fitted: Option<Fitted>,
    ) -> Option<Self> {
        let bench = with_law(bench, law)?;
        if let Some(fitted) = fitted {
            return Some(Self { bench, fitted });
        }
        // Half of what a law's residual is under this noise where it fits as well as noise allows, times how much worse is out of
        // the race.
        let hopeless = HOPELESS * 0.5 * subset.len() as f64;
        let fitted = bench.law_fit(subset, &bench.first_sizes(), hopeless)?;
        Some(Self { bench, fitted })
    }

    fn error(&self) -> f64 {
        floor::rmse(&self.bench, &self.fitted.prediction, None)
    }

    /// The fit with the noise beneath it; `None` where no noise can be told.
    fn stand(&self, subset: &Subset) -> Option<Stand> {
        let (bench, sizes) = (&self.bench, self.bench.first_sizes());
        under_its_noise(bench, subset, self.fitted.clone(), sizes, None)
    }

    /// Fits under noise of the judge's sizes that multiplies the fit's own friction, until the likelihood rises no more.
    fn settle(&mut self, judge: &Judge<'_>, subset: &Subset) {
        let (sizes, bound) = (judge.stand.sizes, judge.scatter);
        if self.bench.law == judge.law {
            self.fitted = judge.stand.fitted.clone();
            return;
        }
        let mut own = Likelihood::of(&self.bench, subset, &self.fitted, sizes);
        for _ in 0..ROUNDS {
            let Some(fitted) = self.refitted(&own, sizes, subset) else {
                return;
            };
            let next = Likelihood::of(&self.bench, subset, &fitted, sizes);
            let saved = own.deviance_within(bound) - next.deviance_within(bound);
            if !(saved > 0.0) {
                return;
            }
            (self.fitted, own) = (fitted, next);
            if saved < WORTH {
                return;
            }
        }
    }

    fn refitted(&self, own: &Likelihood, sizes: Sizes, subset: &Subset) -> Option<Fitted> {
        let whitener = own.scattered(sizes.scatter);
        let start = &self.fitted.parameters;
        self.bench.fit(subset, &[], start, &whitener, None, STEPS)
    }
}

/// The law that errs least with the noise beneath it: what all are compared under.
struct Judge<'a> {
    law: LawKind,
    stand: &'a Stand,
    /// Whitened gains of the runs.
    gains: DMatrix<f64>,
    /// S of (D10).
    scatter: f64,
}

impl<'a> Judge<'a> {
    fn new(bench: &Bench<'_>, subset: &Subset, law: LawKind, stand: &'a Stand) -> Self {
        let context = subset.context_of(bench, &stand.fitted);
        let mut judge = Self {
            law,
            stand,
            gains: stand.whitener.whiten_columns(&gain_matrix(&context)),
            scatter: f64::INFINITY,
        };
        judge.scatter = judge.deviance(bench, &stand.fitted, subset).largest();
        judge
    }

    /// D of (D9) of a fit under the judge's noise.
    fn deviance(&self, bench: &Bench<'_>, fitted: &Fitted, subset: &Subset) -> ScatterDeviance {
        let residual = subset.gather(&bench.samples.force) - subset.gather(&fitted.prediction);
        ScatterDeviance::new(&self.gains, &self.stand.whitener.whiten(&residual))
    }

    /// The criterion of (D10).
    fn criterion(&self, law: &Contender<'_>, subset: &Subset) -> f64 {
        let n = subset.len() as f64;
        let p = law.bench.law.parameters().len() as f64 + 1.0;
        let deviance = self.deviance(&law.bench, &law.fitted, subset);
        deviance.least_within(self.scatter) + 2.0 * p + 2.0 * p * (p + 1.0) / (n - p - 1.0).max(1.0)
    }
}

/// The bench for a law without any cause; `None` where the law does not go with the campaign.
fn with_law<'a>(bench: &Bench<'a>, law: LawKind) -> Option<Bench<'a>> {
    Model::new(law, Vec::new(), &bench.experiment).ok()?;
    Some(Bench {
        law,
        catalogue: Vec::new(),
        prior: None,
        told: None,
        ..bench.clone()
    })
}

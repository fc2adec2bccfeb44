//! Where a fit begins: of many starts those whose prediction is nearest to the record.
//!
//! What some of the runs cost is a lower bound of what all do: r_S' V_SS^-1 r_S is at most r' V^-1 r. A start that is far off on these is
//! predicted on no others.

use fitting::noise::Whitener;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use rig::{Model, Paths};

use crate::bench::Bench;
use crate::subset::Subset;

/// Parameters of a model with its law at each of these starts and the rest as it is.
pub(crate) fn with_laws(whole: &[f64], laws: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let with_law = |law: Vec<f64>| {
        let mut parameters = whole.to_vec();
        parameters[..law.len()].copy_from_slice(&law);
        parameters
    };
    laws.into_iter().map(with_law).collect()
}

/// Starts of a model with their cost |W (predicted - measured)|^2, the nearest first; those without a finite prediction are left
/// out. `paths` may be those of any law among the starts. Columns are whitened side by side, which is cheaper than one by one.
pub(crate) fn ranked(
    bench: &Bench<'_>,
    subset: &Subset,
    whitener: &Whitener,
    model: &Model,
    starts: Vec<Vec<f64>>,
    paths: &Paths,
) -> Vec<(f64, Vec<f64>)> {
    if starts.is_empty() {
        return Vec::new();
    }
    let measured = subset.gather(&bench.experiment.measured_n);
    let residuals: Vec<DVector<f64>> = starts
        .par_iter()
        .map(|start| {
            let predicted = model.predict_beside(&bench.experiment, start, paths);
            subset.gather(&predicted) - &measured
        })
        .collect();
    let white = whitener.whiten_columns(&DMatrix::from_columns(&residuals));
    let mut ranked: Vec<(f64, Vec<f64>)> = white
        .column_iter()
        .map(|column| column.norm_squared())
        .zip(starts)
        .filter(|(cost, _)| cost.is_finite())
        .collect();
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    ranked
}

/// Every so many-th run is looked at first.
const FIRST: usize = 3;
/// Share of a bound that counts: some runs have a grid of the plate of their own.
const SURE: f64 = 0.9;
/// Starts that are predicted side by side once their bounds are known.
const SIDE_BY_SIDE: usize = 2;

/// Runs that are looked at before others, with their noise.
struct FirstLook {
    subset: Subset,
    whitener: Whitener,
}

/// The record that starts are held against.
pub(crate) struct Record<'a> {
    bench: &'a Bench<'a>,
    subset: &'a Subset,
    whitener: Whitener,
    /// `None` where the runs are few.
    first: Option<FirstLook>,
}

impl<'a> Record<'a> {
    /// These runs under the noise of a healthy rig.
    pub(crate) fn of_a_healthy_rig(bench: &'a Bench<'a>, subset: &'a Subset) -> Self {
        let scale = bench.crude_scale();
        let noise = |of: &Subset| bench.healthy_noise(&of.context(bench, &scale));
        let some: Vec<usize> = subset.runs.iter().copied().step_by(FIRST).collect();
        let first = (some.len() < subset.runs.len()).then(|| {
            let subset = subset.only(bench, some);
            let whitener = noise(&subset);
            FirstLook { subset, whitener }
        });
        Self {
            whitener: noise(subset),
            bench,
            subset,
            first,
        }
    }

    /// The noise of all runs.
    pub(crate) fn whitener(&self) -> &Whitener {
        &self.whitener
    }

    /// Of these starts the nearest with its cost |W (predicted - measured)|^2, if that is finite and less than `enough`; of starts that cost the same
    /// the first. `paths` may be those of any law among the starts.
    pub(crate) fn nearest(
        &self,
        model: &Model,
        starts: Vec<Vec<f64>>,
        paths: &Paths,
        enough: f64,
    ) -> Option<(f64, Vec<f64>)> {
        let mut looks: Vec<(usize, Look)> = (starts.par_iter())
            .map(|start| self.look(model, start, paths))
            .enumerate()
            .collect();
        looks.retain(|(_, look)| look.bound.is_finite());
        looks.sort_by(|(_, a), (_, b)| a.bound.total_cmp(&b.bound));
        let mut nearest: Option<(f64, usize)> = None;
        for some in looks.chunks(SIDE_BY_SIDE) {
            let enough = nearest.map_or(enough, |(cost, _)| cost.min(enough));
            let costs = some.par_iter().map(|(start, look)| {
                let near = SURE * look.bound <= enough;
                let cost = near.then(|| self.cost(model, &starts[*start], paths, look));
                Some((cost?, *start))
            });
            let costs: Vec<Option<(f64, usize)>> = costs.collect();
            let finite = costs.into_iter().flatten().filter(|c| c.0.is_finite());
            nearest = nearest
                .into_iter()
                .chain(finite)
                .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        }
        let (cost, start) = nearest.filter(|(cost, _)| *cost < enough)?;
        starts.into_iter().nth(start).map(|start| (cost, start))
    }

    fn look(&self, model: &Model, start: &[f64], paths: &Paths) -> Look {
        let Some(first) = &self.first else {
            return Look {
                predicted: Vec::new(),
                bound: 0.0,
            };
        };
        let runs = |run: usize| first.subset.runs.contains(&run);
        let predicted = model.predict_of(&self.bench.experiment, start, paths, runs);
        Look {
            bound: cost(self.bench, &first.subset, &first.whitener, &predicted),
            predicted,
        }
    }

    /// What a start costs that has been looked at.
    fn cost(&self, model: &Model, start: &[f64], paths: &Paths, look: &Look) -> f64 {
        let seen = self.first.as_ref().map(|first| &first.subset.runs);
        let is_seen = |run: usize| seen.is_some_and(|seen| seen.contains(&run));
        let others = |run: usize| !is_seen(run);
        let mut predicted = model.predict_of(&self.bench.experiment, start, paths, others);
        for &run in seen.into_iter().flatten() {
            let rows = self.bench.samples.runs[run].clone();
            predicted[rows.clone()].copy_from_slice(&look.predicted[rows]);
        }
        cost(self.bench, self.subset, &self.whitener, &predicted)
    }
}

/// What is known of a start from the runs that are looked at first.
struct Look {
    predicted: Vec<f64>,
    /// The least that it may cost.
    bound: f64,
}

/// |W (predicted - measured)|^2 over these runs.
fn cost(bench: &Bench<'_>, subset: &Subset, whitener: &Whitener, predicted: &[f64]) -> f64 {
    let measured = subset.gather(&bench.experiment.measured_n);
    let residual = subset.gather(predicted) - measured;
    whitener.whiten(&residual).norm_squared()
}

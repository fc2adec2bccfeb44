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

/// Every so many-th run is looked at, before all are. Each a multiple of the next, so that a view holds those before it.
const LOOKS: [usize; 2] = [6, 3];
/// Share of a bound that counts: some runs have a grid of the plate of their own.
const SURE: f64 = 0.9;
/// Starts that are followed side by side once they have been looked at.
const SIDE_BY_SIDE: usize = 2;

/// The record that starts are held against.
pub(crate) struct Record<'a> {
    bench: &'a Bench<'a>,
    /// Of more and more runs.
    before: Vec<View>,
    whole: View,
}

/// Some runs with their noise.
struct View {
    subset: Subset,
    whitener: Whitener,
    /// Those that no view before shows.
    new: Vec<usize>,
}

/// A start as far as it has been looked at.
struct Prospect {
    /// Its place among the starts.
    start: usize,
    predicted: Vec<f64>,
    /// What the runs of the last view cost, the least that all may cost.
    bound: f64,
}

impl<'a> Record<'a> {
    /// These runs under the noise of a healthy rig.
    pub(crate) fn of_a_healthy_rig(bench: &'a Bench<'a>, subset: &Subset) -> Self {
        let scale = bench.crude_scale();
        let view = |subset: Subset, before: &[View]| {
            let shown = before.last().map(|view| &view.subset.runs);
            let mut new = subset.runs.clone();
            new.retain(|run| !shown.is_some_and(|shown| shown.contains(run)));
            View {
                whitener: bench.healthy_noise(&subset.context(bench, &scale)),
                subset,
                new,
            }
        };
        let mut before: Vec<View> = Vec::new();
        for step in LOOKS {
            let runs: Vec<usize> = subset.runs.iter().copied().step_by(step).collect();
            let shown = before.last().map_or(0, |view| view.subset.runs.len());
            if (shown + 1..subset.runs.len()).contains(&runs.len()) {
                before.push(view(subset.only(bench, runs), &before));
            }
        }
        Self {
            bench,
            whole: view(subset.clone(), &before),
            before,
        }
    }

    /// |W (predicted - measured)|^2 over all runs.
    pub(crate) fn cost(&self, predicted: &[f64]) -> f64 {
        self.cost_in(&self.whole, predicted)
    }

    /// Of these starts the nearest with its cost, if that is finite and less than `enough`; of starts that cost the same the first. `paths` may be
    /// those of any law among the starts.
    pub(crate) fn nearest(
        &self,
        model: &Model,
        starts: Vec<Vec<f64>>,
        paths: &Paths,
        enough: f64,
    ) -> Option<(f64, Vec<f64>)> {
        let views: Vec<&View> = self.before.iter().chain([&self.whole]).collect();
        let (first, further) = views.split_first()?;
        let look = |view: &View, prospect: &mut Prospect| {
            let start = &starts[prospect.start];
            let runs = |run: usize| view.new.contains(&run);
            let seen = model.predict_of(&self.bench.experiment, start, paths, runs);
            for &run in &view.new {
                let rows = self.bench.samples.runs[run].clone();
                prospect.predicted[rows.clone()].copy_from_slice(&seen[rows]);
            }
            prospect.bound = self.cost_in(view, &prospect.predicted);
        };
        let begun = (0..starts.len()).into_par_iter().map(|start| {
            let mut prospect = Prospect {
                start,
                predicted: vec![f64::NAN; self.bench.samples.len()],
                bound: 0.0,
            };
            look(first, &mut prospect);
            prospect
        });
        let mut prospects: Vec<Prospect> = begun.collect();
        prospects.sort_by(|a, b| a.bound.total_cmp(&b.bound));
        let mut nearest: Option<(f64, usize)> = None;
        for some in prospects.chunks_mut(SIDE_BY_SIDE) {
            let enough = nearest.map_or(enough, |(cost, _)| cost.min(enough));
            let costs = some.par_iter_mut().map(|prospect| {
                for view in further {
                    // A prediction that left the numbers is near nothing.
                    if !(SURE * prospect.bound <= enough) {
                        return None;
                    }
                    look(view, prospect);
                }
                Some((prospect.bound, prospect.start))
            });
            let costs: Vec<Option<(f64, usize)>> = costs.collect();
            let finite = costs.into_iter().flatten().filter(|c| c.0.is_finite());
            nearest = (nearest.into_iter().chain(finite))
                .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        }
        let (cost, start) = nearest.filter(|(cost, _)| *cost < enough)?;
        starts.into_iter().nth(start).map(|start| (cost, start))
    }

    fn cost_in(&self, view: &View, predicted: &[f64]) -> f64 {
        let measured = view.subset.gather(&self.bench.experiment.measured_n);
        let residual = view.subset.gather(predicted) - measured;
        view.whitener.whiten(&residual).norm_squared()
    }

    /// The noise of all runs.
    pub(crate) fn whitener(&self) -> &Whitener {
        &self.whole.whitener
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Options;
    use crate::prepare::{self, stand_in};

    /// Some of the runs cost at most what all do, and the nearest start is the one that all runs of all starts tell, however near is near enough.
    #[test]
    fn starts_that_are_left_early_are_not_the_nearest() {
        let campaign = stand_in("brush-2x2-aluminium");
        let bench = prepare::bench(&campaign, &Options::default()).expect("a bench");
        let subset = Subset::all(&bench);
        let model = bench.model(&[]).expect("a model");
        let starts = bench.law_starts(&model);
        let record = Record::of_a_healthy_rig(&bench, &subset);
        let whitener = record.whitener();
        let all = ranked(
            &bench,
            &subset,
            whitener,
            &model,
            starts.clone(),
            Paths::NONE,
        );
        assert!(!record.before.is_empty() && all.len() > 10);
        for (cost, start) in &all {
            let predicted = model.predict(&bench.experiment, start);
            for view in &record.before {
                let bound = record.cost_in(view, &predicted);
                assert!(SURE * bound <= *cost, "{bound} {cost}");
            }
        }
        let nearest = &all[0];
        for (enough, found) in [
            (f64::INFINITY, Some(nearest)),
            (1.01 * nearest.0, Some(nearest)),
            (nearest.0, None),
        ] {
            let own = record.nearest(&model, starts.clone(), Paths::NONE, enough);
            assert_eq!(own.as_ref(), found, "{enough}");
        }
    }

    /// However few the runs, each is in just one view, and a start is found.
    #[test]
    fn few_runs_are_all_looked_at() {
        let campaign = stand_in("brush-2x2-aluminium");
        let bench = prepare::bench(&campaign, &Options::default()).expect("a bench");
        let model = bench.model(&[]).expect("a model");
        let starts = bench.law_starts(&model);
        for runs in 1..=campaign.runs.len() {
            let subset = Subset::new(&bench, (0..runs).collect());
            let record = Record::of_a_healthy_rig(&bench, &subset);
            let views = record.before.iter().chain([&record.whole]);
            let mut seen: Vec<usize> = views.flat_map(|view| view.new.iter().copied()).collect();
            seen.sort_unstable();
            assert_eq!(seen, subset.runs);
            let found = record.nearest(&model, starts.clone(), Paths::NONE, f64::INFINITY);
            assert!(found.is_some(), "{runs} runs");
        }
    }
}

//! Runs that do not belong to the others: one or two that were made with another specimen.
//!
//! Their law has parameters of its own, so what they show is in the span of the law's Jacobian with the rows of all other runs taken out.
//! It is a rival of every cause in the catalogue, of which several together may imitate it.

use std::ops::Range;

use nalgebra::DMatrix;

use fitting::noise::Search;

use crate::answer::Place;
use crate::bench::Bench;
use crate::general::MOST_RUNS;
use crate::stand::Stand;
use crate::subset::Subset;

/// With fewer runs two with a law of their own are a third of the campaign, and nothing says which are the others.
const FEWEST_RUNS: usize = 6;
/// Runs that stand out most, of which all pairs are asked.
const PAIRED: usize = 8;

/// Runs with a law of their own beside the law alone.
pub(crate) struct Foreign {
    /// Places of the runs in the subset.
    runs: Vec<usize>,
    /// Deviance that their own law explains, less what choosing them costs.
    pub(crate) explained: f64,
    /// Logarithm of its tail probability, choosing them paid for.
    pub(crate) log_p: f64,
}

/// The run or the two whose own law explains most beside a stand of the law.
pub(crate) fn strangest(bench: &Bench<'_>, subset: &Subset, law: &Stand) -> Option<Foreign> {
    let runs = subset.samples(bench).runs;
    if !(FEWEST_RUNS..=MOST_RUNS).contains(&runs.len()) {
        return None;
    }
    let rows = subset.gather_columns(&law.jacobian);
    let own: Vec<DMatrix<f64>> = (runs.iter())
        .map(|run| law.whiten_own(&of_runs(&rows, [run.clone()])))
        .collect();
    let alone = (own.iter().enumerate()).filter_map(|(k, white)| ask(law, white, vec![k]));
    let mut found: Vec<Foreign> = alone.collect();
    found.sort_by(|a, b| b.explained.total_cmp(&a.explained));
    let strange: Vec<usize> = found.iter().take(PAIRED).map(|f| f.runs[0]).collect();
    for (i, &a) in strange.iter().enumerate() {
        let pairs = strange[..i]
            .iter()
            .map(|&b| (&own[a] + &own[b], vec![b, a]));
        found.extend(pairs.filter_map(|(white, runs)| ask(law, &white, runs)));
    }
    let best = found
        .into_iter()
        .max_by(|a, b| a.explained.total_cmp(&b.explained))?;
    Some(best.paying(runs.len()))
}

/// The same question with the noise estimated beside their own law: beside the law alone they are taken for noise in part.
pub(crate) fn beside_the_noise_of(
    bench: &Bench<'_>,
    subset: &Subset,
    law: &Stand,
    foreign: &Foreign,
) -> Option<Foreign> {
    let runs = foreign.runs.iter();
    let ranges = runs.map(|&k| bench.samples.runs[subset.runs[k]].clone());
    let within = of_runs(&law.jacobian, ranges);
    let search = Search::Again(law.sizes);
    let noise = bench.noise(subset, &law.fitted, &law.jacobian, &within, search);
    let own = Stand::new(bench, subset, law.fitted.clone(), noise.sizes);
    let mut closer = strangest(bench, subset, &own)?;
    closer.explained += law.deviance - own.deviance;
    Some(closer)
}

/// What whitened columns of some runs explain beside a stand of the law.
fn ask(law: &Stand, white: &DMatrix<f64>, runs: Vec<usize>) -> Option<Foreign> {
    let direction = law.ground.direction(white)?;
    Some(Foreign {
        runs,
        explained: law.ground.explained(&direction),
        log_p: law.ground.score(&direction).log_p,
    })
}

/// Columns with the rows of all other runs taken out.
fn of_runs(columns: &DMatrix<f64>, runs: impl IntoIterator<Item = Range<usize>>) -> DMatrix<f64> {
    let mut own = DMatrix::zeros(columns.nrows(), columns.ncols());
    for run in runs {
        let (from, length) = (run.start, run.len());
        own.rows_mut(from, length)
            .copy_from(&columns.rows(from, length));
    }
    own
}

impl Foreign {
    /// The choice among all runs and pairs of a campaign paid for.
    fn paying(mut self, count: usize) -> Self {
        let price = ((count * (count + 1) / 2) as f64).ln();
        self.explained -= 2.0 * price;
        self.log_p = (self.log_p + price).min(0.0);
        self
    }

    /// Where they are: all of their time.
    pub(crate) fn place(&self, bench: &Bench<'_>, subset: &Subset) -> Place {
        let names = bench.run_names(subset);
        subset.samples(bench).place_of_runs(&self.runs, &names)
    }
}

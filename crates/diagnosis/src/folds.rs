//! Which runs are left out to see what an extension gains on runs that it has not seen.
//!
//! Each fold leaves out one run of every repeated condition. Campaigns of more conditions also leave out whole ones: those in which
//! the extension says most that the law does not, for on the others there is nothing to gain. A condition that shows more than
//! all others together stays: without it no fold would find the cause again.

use nalgebra::DMatrix;

use crate::bench::Bench;
use crate::selection::Selected;
use crate::settled::likely_scatter;
use crate::whole::Whole;

/// Conditions that are left out as a whole, at most.
const WHOLE_CONDITIONS: usize = 3;
/// Conditions among which these are chosen; of more the first are left out.
const MOST_CONDITIONS: usize = 64;
/// Folds over repeats, at most.
const MOST_FOLDS: usize = 12;

/// Runs left out, fold by fold.
pub(crate) fn folds(bench: &Bench<'_>, whole: &Whole<'_>, selected: &Selected) -> Vec<Vec<usize>> {
    let mut folds = merged(identification::folds(whole.bench.campaign));
    let conditions = whole.bench.campaign.conditions();
    let runs = bench.samples.runs.len();
    if conditions.len() > 2 {
        let mut some = most_shown(bench, selected, &conditions);
        some.retain(|&c| 2 * conditions[c].len() < runs);
        some.truncate(WHOLE_CONDITIONS);
        some.sort_unstable();
        folds.extend(some.into_iter().map(|c| conditions[c].clone()));
    }
    if folds.is_empty() && runs > 2 {
        // No repeats: each run in turn, at most six.
        folds = (0..runs.min(6)).map(|k| vec![k]).collect();
    }
    folds
}

/// Conditions, those first in which the extension says most that the law does not; in the campaign's order where nothing is named.
fn most_shown(bench: &Bench<'_>, selected: &Selected, conditions: &[Vec<usize>]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..conditions.len()).collect();
    if selected.stand.fitted.effects.is_empty() || conditions.len() > MOST_CONDITIONS {
        return order;
    }
    let shown = shown(bench, selected, conditions);
    let half = 0.5 * shown.iter().sum::<f64>();
    order.retain(|&c| shown[c] <= half);
    order.sort_by(|&a, &b| shown[b].total_cmp(&shown[a]).then(a.cmp(&b)));
    order
}

/// |M (f_extended - f_law)|^2 over the runs of each condition, M whitening with the scatter between runs.
fn shown(bench: &Bench<'_>, selected: &Selected, conditions: &[Vec<usize>]) -> Vec<f64> {
    let (stand, subset) = (&selected.stand, &selected.subset);
    let (extended, law) = (
        &stand.fitted.prediction,
        &selected.baseline.fitted.prediction,
    );
    let mut columns = DMatrix::zeros(extended.len(), conditions.len());
    for (c, condition) in conditions.iter().enumerate() {
        for i in condition
            .iter()
            .flat_map(|&run| bench.samples.runs[run].clone())
        {
            columns[(i, c)] = extended[i] - law[i];
        }
    }
    let context = subset.context_of(bench, &stand.fitted);
    let whitener = stand.whitener.with_scatter(&context, likely_scatter(stand));
    let white = whitener.whiten_columns(&subset.gather_columns(&columns));
    white.column_iter().map(|c| c.norm_squared()).collect()
}

/// At most [`MOST_FOLDS`] folds: with more repeats each leaves out several runs of a condition.
fn merged(folds: Vec<Vec<usize>>) -> Vec<Vec<usize>> {
    if folds.len() <= MOST_FOLDS {
        return folds;
    }
    let mut few = vec![Vec::new(); MOST_FOLDS];
    for (k, fold) in folds.into_iter().enumerate() {
        few[k % MOST_FOLDS].extend(fold);
    }
    few
}

//! Which runs are left out to see what an extension gains on runs that it has not seen.
//!
//! Each fold leaves out one run of every repeated condition. Campaigns of more conditions also leave out whole ones: those in which
//! the extension says most that the law does not, for on the others there is nothing to gain. A condition stays where without it half
//! of what shows one of the named causes would be gone: no fold would find that cause again. Of the k-th cause rows show
//!
//! ```text
//! t_k = |(I - P_k) M (f - f_k)|^2                                                                        (D15)
//! ```
//!
//! f being the extension's prediction and f_k the same without the cause, M whitening with the scatter between runs, and P_k the projection
//! on what the law and the other causes can follow, M J without the cause's own columns, all on these rows.

use std::ops::Range;

use fitting::noise::Whitener;
use nalgebra::{DMatrix, DVector};

use crate::bench::Bench;
use crate::look_back::bare;
use crate::prior::append_prior;
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

/// Conditions that may be left out, those first in which the extension says most that the law does not; in the campaign's order where nothing
/// is named.
fn most_shown(bench: &Bench<'_>, selected: &Selected, conditions: &[Vec<usize>]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..conditions.len()).collect();
    if selected.names_nothing() || conditions.len() > MOST_CONDITIONS {
        return order;
    }
    // What each run tells of itself, and not of the plate that the others pass.
    let scatter = likely_scatter(&selected.stand);
    let noise = (selected.stand).by_sample(bench, &selected.subset, scatter);
    let shown = shown(bench, selected, &noise, conditions);
    for k in 0..selected.stand.fitted.effects.len() {
        let spared = spared(bench, selected, &noise, conditions, k);
        order.retain(|&c| spared[c]);
    }
    order.sort_by(|&a, &b| shown[b].total_cmp(&shown[a]).then(a.cmp(&b)));
    order
}

/// Whether the other conditions show half of the k-th cause at least, (D15).
fn spared(
    bench: &Bench<'_>,
    selected: &Selected,
    noise: &Whitener,
    conditions: &[Vec<usize>],
    k: usize,
) -> Vec<bool> {
    let (stand, subset) = (&selected.stand, &selected.subset);
    let Some(bare) = bare(bench, &stand.fitted, k) else {
        return vec![true; conditions.len()];
    };
    let own = stand.fitted.model.span(k);
    let others: Vec<usize> = (0..stand.columns.len())
        .filter(|&j| !own.contains(&stand.columns[j]))
        .collect();
    let mut columns = stand.jacobian.select_columns(&others);
    columns = columns.insert_column(others.len(), 0.0);
    let both = stand.fitted.prediction.iter().zip(&bare.prediction);
    for (i, (with, without)) in both.enumerate() {
        columns[(i, others.len())] = with - without;
    }
    let white = noise.whiten_columns(&subset.gather_columns(&columns));
    let owners: Vec<Option<usize>> = others.iter().map(|&j| Some(stand.columns[j])).collect();
    let white = append_prior(bench.prior.as_ref(), white, &owners);
    let products = |rows: Range<usize>| {
        let rows = white.rows(rows.start, rows.len());
        rows.tr_mul(&rows)
    };
    let known = products(subset.len()..white.nrows());
    let each: Vec<DMatrix<f64>> = (conditions.iter())
        .map(|condition| {
            let runs = condition.iter().map(|&run| products(subset.rows_of(run)));
            runs.fold(known.map(|_| 0.0), |sum, own| sum + own)
        })
        .collect();
    // Added up and not taken off the whole: a run that is left out must leave its own state exactly nothing.
    let without = |out: Option<usize>| {
        let kept = each.iter().enumerate().filter(|(c, _)| Some(*c) != out);
        beyond(&kept.fold(known.clone(), |sum, (_, own)| sum + own))
    };
    let half = 0.5 * without(None);
    (0..conditions.len())
        .map(|c| without(Some(c)) >= half)
        .collect()
}

/// What the last of some columns has beyond the others, squared, from the products of all: g - b' A^+ b.
fn beyond(products: &DMatrix<f64>) -> f64 {
    /// Eigenvalues below this share of the largest belong to directions that no row tells.
    const TOLD: f64 = 1e-9;
    let p = products.nrows() - 1;
    // Columns in units of their lengths: those of a run that is left out have none.
    let unit = |j: usize| match products[(j, j)] {
        square if square > 0.0 => square.sqrt().recip(),
        _ => 0.0,
    };
    let scaled = DMatrix::from_fn(p, p, |i, j| products[(i, j)] * unit(i) * unit(j));
    let along = DVector::from_fn(p, |i, _| products[(i, p)] * unit(i));
    let eigen = scaled.symmetric_eigen();
    let largest = eigen.eigenvalues.iter().copied().fold(0.0, f64::max);
    let directions = eigen.eigenvectors.column_iter();
    let told = (eigen.eigenvalues.iter().zip(directions))
        .filter(|(l, _)| **l > TOLD * largest)
        .map(|(l, direction)| direction.dot(&along).powi(2) / l);
    (products[(p, p)] - told.sum::<f64>()).max(0.0)
}

/// |M (f_extended - f_law)|^2 over the runs of each condition, M whitening with the scatter between runs.
fn shown(
    bench: &Bench<'_>,
    selected: &Selected,
    noise: &Whitener,
    conditions: &[Vec<usize>],
) -> Vec<f64> {
    let (extended, law) = (
        &selected.stand.fitted.prediction,
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
    let own = selected.subset.gather_columns(&columns);
    let white = noise.whiten_columns(&own);
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A column of length 5 of which the others hold 3, one of them twice, and one without a length.
    #[test]
    fn what_a_column_has_beyond_others_that_repeat() {
        let columns = DMatrix::from_row_slice(
            3,
            4,
            &[1.0, 2.0, 0.0, 3.0, 0.0, 0.0, 0.0, 4.0, 0.0, 0.0, 0.0, 0.0],
        );
        let products = columns.tr_mul(&columns);
        assert!((beyond(&products) - 16.0).abs() < 1e-12);
    }
}

//! Where a fit begins: of many starts those whose prediction is nearest to the record.

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

//! The extended model as a file that the other commands take.

use rig::ModelFile;

use crate::bench::{Bench, Fitted};
use crate::intervals;
use crate::stand::Stand;

/// A fitted model as a file: the parameters of `fitted`, which are as uncertain as the stand says.
pub(crate) fn model_file(bench: &Bench<'_>, stand: &Stand, fitted: &Fitted) -> ModelFile {
    let law = fitted.model.law_parameters();
    let covariance = intervals::covariance(stand);
    let place = |p: usize| stand.columns.iter().position(|&c| c == p);
    let entry = |i: usize, j: usize| match (place(i), place(j), &covariance) {
        (Some(a), Some(b), Some(c)) => c[(a, b)],
        _ => 0.0,
    };
    let sd: Vec<f64> = (0..law).map(|i| entry(i, i).max(0.0).sqrt()).collect();
    let mut file = ModelFile::new(bench.law, &fitted.parameters[..law], Some(&sd));
    let fastest = bench
        .samples
        .velocity
        .iter()
        .fold(0.0_f64, |m, v| m.max(v.abs()));
    file.valid_speed_m_s = Some([0.0, fastest]);
    file.covariance = covariance.as_ref().map(|_| {
        (0..law)
            .map(|i| (0..law).map(|j| entry(i, j)).collect())
            .collect()
    });
    for k in 0..fitted.effects.len() {
        let span = fitted.model.span(k);
        let own: Vec<Vec<f64>> = span
            .clone()
            .map(|i| span.clone().map(|j| entry(i, j)).collect())
            .collect();
        let mut entry = ModelFile::extension_entry(
            bench.catalogue[fitted.effects[k]].as_ref(),
            &fitted.parameters[span],
            covariance.as_ref().map(|_| own.as_slice()),
        );
        for parameter in &mut entry.parameters {
            parameter.unit = intervals::unit_on_rig(bench, &parameter.unit);
        }
        file.extension.push(entry);
    }
    file
}

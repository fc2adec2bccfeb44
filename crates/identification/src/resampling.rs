//! The bootstrap over runs, as a diagnostic: with three repeats a condition its intervals are too narrow.
//!
//! Runs are drawn with replacement within their condition. A draw's parameters follow from one Gauss-Newton step with
//! weights w_k on the runs, min over s of sum_k w_k |J_k s + r_k|^2, taken by QR of the stacked factors sqrt(w_k) R_k.

use campaign::Campaign;
use fitting::{Bootstrap, bootstrap};
use nalgebra::{DMatrix, DVector};
use rand_distr::{Distribution, Uniform};
use rig::Experiment;

use crate::identify::Identification;
use crate::question::IdentificationError;

/// `count` draws of the estimated parameters of law and effects, in the order of the estimates that are not held.
///
/// # Errors
/// When the campaign cannot be predicted.
pub fn resample_runs(
    campaign: &Campaign,
    identified: &Identification,
    count: usize,
    seed: u64,
) -> Result<Bootstrap, IdentificationError> {
    let experiment = Experiment::new(campaign)?;
    let columns: Vec<usize> = (0..identified.estimates.len())
        .filter(|&j| !identified.estimates[j].held && identified.estimates[j].at_bound.is_none())
        .collect();
    let (predicted, jacobian) =
        identified
            .model
            .predict_with_jacobian(&experiment, &identified.parameters, Some(&columns));
    let residual =
        DVector::from_vec(predicted) - DVector::from_column_slice(&experiment.measured_n);
    // Run by run: R_k and Q_k^T r_k.
    let factors: Vec<(DMatrix<f64>, DVector<f64>)> = experiment
        .runs
        .iter()
        .map(|run| {
            let rows = run.samples.len();
            let qr = jacobian.rows(run.samples.start, rows).into_owned().qr();
            let mut rhs = residual.rows(run.samples.start, rows).into_owned();
            qr.q_tr_mul(&mut rhs);
            (qr.r(), rhs.rows(0, columns.len().min(rows)).into_owned())
        })
        .collect();
    let conditions = campaign.conditions();
    let n = columns.len();
    let best: Vec<f64> = columns.iter().map(|&j| identified.parameters[j]).collect();
    Ok(bootstrap(count, seed, |generator| {
        let drawn: Vec<usize> = conditions
            .iter()
            .flat_map(|condition| {
                let pick = Uniform::new(0, condition.len());
                (0..condition.len())
                    .filter_map(|_| pick.as_ref().ok().map(|u| condition[u.sample(generator)]))
                    .collect::<Vec<_>>()
            })
            .collect();
        let mut stacked = DMatrix::zeros(n * drawn.len(), n);
        let mut rhs = DVector::zeros(n * drawn.len());
        for (block, &k) in drawn.iter().enumerate() {
            let (r, b) = &factors[k];
            stacked.view_mut((block * n, 0), r.shape()).copy_from(r);
            rhs.rows_mut(block * n, b.len()).copy_from(&(-b));
        }
        let qr = stacked.qr();
        qr.q_tr_mul(&mut rhs);
        let step = qr
            .r()
            .solve_upper_triangular(&rhs.rows(0, n).into_owned())?;
        step.iter()
            .all(|s| s.is_finite())
            .then(|| best.iter().zip(step.iter()).map(|(p, s)| p + s).collect())
    }))
}

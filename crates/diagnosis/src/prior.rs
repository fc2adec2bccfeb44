//! What is known of the law's parameters before this campaign: a model file's values and covariance, as rows of the
//! least-squares problem.

use friction::LawKind;
use nalgebra::{Cholesky, DMatrix, DVector};
use rig::ModelFile;

/// Knowledge of the law's parameters from a model file: values and the root of their precision.
#[derive(Clone)]
pub(crate) struct Prior {
    pub(crate) values: Vec<f64>,
    /// C^-1/2, one row a pseudo-observation.
    root: DMatrix<f64>,
}

impl Prior {
    /// From a model file; parameters without an uncertainty are taken as exact to one part in a million.
    pub(crate) fn new(file: &ModelFile, law: LawKind) -> Result<Self, String> {
        let values = file.law_values()?;
        let n = values.len();
        let floor: Vec<f64> = values
            .iter()
            .zip(law.parameters())
            .map(|(v, spec)| 1e-6 * v.abs().max(1e-3 * spec.typical.abs()))
            .collect();
        let mut covariance = match &file.covariance {
            Some(c) => DMatrix::from_fn(n, n, |i, j| c[i][j]),
            None => DMatrix::from_fn(n, n, |i, j| {
                if i == j {
                    file.parameters[i].sd.unwrap_or(0.0).powi(2)
                } else {
                    0.0
                }
            }),
        };
        for i in 0..n {
            covariance[(i, i)] += floor[i] * floor[i];
        }
        // Scaled to a correlation matrix first: parameters differ by powers of ten.
        let sd: Vec<f64> = (0..n).map(|i| covariance[(i, i)].sqrt()).collect();
        let correlation = DMatrix::from_fn(n, n, |i, j| {
            covariance[(i, j)] / (sd[i] * sd[j]) + if i == j { 1e-9 } else { 0.0 }
        });
        let factor = Cholesky::new(correlation)
            .ok_or_else(|| "the model's covariance is not positive definite".to_owned())?;
        let scaled = DMatrix::from_fn(n, n, |i, j| if i == j { 1.0 / sd[i] } else { 0.0 });
        let root = factor
            .l()
            .solve_lower_triangular(&scaled)
            .ok_or_else(|| "the model's covariance cannot be inverted".to_owned())?;
        Ok(Self { values, root })
    }
}

/// Appends the prior's pseudo-observations (value less parameter) to a whitened residual (measured less predicted).
pub(crate) fn with_prior_rows(
    prior: Option<&Prior>,
    white: DVector<f64>,
    parameters: &[f64],
) -> DVector<f64> {
    let Some(prior) = prior else { return white };
    let extra = prior.values.len();
    let shift = DVector::from_iterator(
        extra,
        prior.values.iter().zip(parameters).map(|(v, p)| v - p),
    );
    let n = white.len();
    let mut out = white.resize_vertically(n + extra, 0.0);
    out.rows_mut(n, extra).copy_from(&(&prior.root * shift));
    out
}

/// Appends the prior's rows to whitened columns that belong to these parameters (`None`: not a law parameter).
pub(crate) fn append_prior(
    prior: Option<&Prior>,
    whitened: DMatrix<f64>,
    parameters: &[Option<usize>],
) -> DMatrix<f64> {
    let Some(prior) = prior else { return whitened };
    let (n, p) = whitened.shape();
    let extra = prior.values.len();
    let mut out = whitened.resize_vertically(n + extra, 0.0);
    for (c, column) in parameters.iter().enumerate().take(p) {
        if let Some(k) = column.filter(|k| *k < extra) {
            out.view_mut((n, c), (extra, 1))
                .copy_from(&prior.root.column(k));
        }
    }
    out
}

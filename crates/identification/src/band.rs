//! The band in which a new run should lie.
//!
//! A prediction F with parameters p of covariance C, for a run with a gain, roughness and sensor noise of its own:
//!
//! ```text
//! var(y) = J C J^T + F^2 (scatter^2 + private^2 + plate^2) + sensor^2
//! ```

use fitting::noise::Sizes;
use nalgebra::DMatrix;
use rig::{Experiment, Model};

/// A prediction with the standard deviation of a new record about it, both stacked like the experiment, N (N m).
#[derive(Clone, Debug)]
pub struct Band {
    /// F.
    pub force_n: Vec<f64>,
    /// Standard deviation of a new record.
    pub sd_n: Vec<f64>,
    /// The part of it that comes from the parameters alone.
    pub parameter_sd_n: Vec<f64>,
}

/// Prediction and band on an experiment; `covariance` over the law's parameters, which come first in `parameters`.
pub fn prediction_band(
    experiment: &Experiment,
    model: &Model,
    parameters: &[f64],
    covariance: &DMatrix<f64>,
    sizes: &Sizes,
) -> Band {
    let columns: Vec<usize> = (0..covariance.ncols()).collect();
    let (force_n, jacobian) = model.predict_with_jacobian(experiment, parameters, Some(&columns));
    let spread = &jacobian * covariance;
    let relative = sizes.scatter.powi(2) + sizes.private.powi(2) + sizes.plate.powi(2);
    let parameter_variance: Vec<f64> = (0..force_n.len())
        .map(|i| spread.row(i).dot(&jacobian.row(i)).max(0.0))
        .collect();
    let sd_n = force_n
        .iter()
        .zip(&parameter_variance)
        .map(|(f, v)| (v + f * f * relative + sizes.sensor.powi(2)).sqrt())
        .collect();
    Band {
        force_n,
        sd_n,
        parameter_sd_n: parameter_variance.iter().map(|v| v.sqrt()).collect(),
    }
}

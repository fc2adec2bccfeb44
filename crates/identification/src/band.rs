//! The band in which 95 % of the samples of new runs should lie.
//!
//! A prediction F with parameters p, for a run with a gain, roughness and sensor noise of its own:
//!
//! ```text
//! var(y | s) = J C0 J' + F^2 (private^2 + plate^2) + sensor^2 + s^2 (F^2 + |M' J'|^2)
//! ```
//!
//! s is the scatter between runs, C0 the covariance of the parameters without it, and M (parameters x runs) how the gains
//! of the runs of the identified campaign moved them. What happens within runs is told by many correlation lengths, but s
//! by a few runs only: y is a mixture of normals over the posterior of s, as for the intervals, and the half width is
//! that of the mixture. (One Student t on the whole would widen the well known parts for the scatter's sake.)
//!
//! The 95 % are a mean over campaigns: the gains of the few runs of one campaign move all of its samples together.

use fitting::noise::Sizes;
use nalgebra::DMatrix;
use rig::{Experiment, Model};

use crate::degrees::half_width;

/// How uncertain parameters are, and which noise a new run will have.
#[derive(Clone, Debug, PartialEq)]
pub struct Spread {
    /// Covariance of the law's parameters at the estimated noise.
    pub covariance: DMatrix<f64>,
    /// Change of the parameters (rows) a relative gain of each run (columns) that they were identified from.
    pub moved_by_gains: DMatrix<f64>,
    /// The estimated noise.
    pub sizes: Sizes,
    /// Scatters between runs with their posterior weights.
    pub scatters: Vec<(f64, f64)>,
}

/// A prediction with its band, stacked like the experiment, N (N m).
#[derive(Clone, Debug)]
pub struct Band {
    /// F.
    pub force_n: Vec<f64>,
    /// Half width that holds 95 % of new samples.
    pub half_width_n: Vec<f64>,
}

impl Band {
    /// Share of the recorded samples inside the band.
    #[must_use]
    pub fn share_inside(&self, experiment: &Experiment) -> f64 {
        let hits = (0..self.force_n.len())
            .filter(|&i| (experiment.measured_n[i] - self.force_n[i]).abs() <= self.half_width_n[i])
            .count();
        hits as f64 / self.force_n.len() as f64
    }
}

/// Prediction and band on an experiment; the law's parameters come first in `parameters`.
#[must_use]
pub fn prediction_band(
    experiment: &Experiment,
    model: &Model,
    parameters: &[f64],
    spread: &Spread,
) -> Band {
    let columns: Vec<usize> = (0..spread.covariance.ncols()).collect();
    let (force_n, jacobian) = model.predict_with_jacobian(experiment, parameters, Some(&columns));
    let turned = &jacobian * &spread.covariance;
    let moved = &jacobian * &spread.moved_by_gains;
    let sizes = &spread.sizes;
    let half_width_n = (0..force_n.len())
        .map(|i| {
            let f2 = force_n[i] * force_n[i];
            let moved2 = moved.row(i).norm_squared();
            let parameters = turned.row(i).dot(&jacobian.row(i));
            let within = (parameters - sizes.scatter.powi(2) * moved2).max(0.0)
                + f2 * (sizes.private.powi(2) + sizes.plate.powi(2))
                + sizes.of_the_channel();
            let parts: Vec<(f64, f64)> = spread
                .scatters
                .iter()
                .map(|(s, weight)| (*weight, (within + s * s * (f2 + moved2)).sqrt()))
                .collect();
            half_width(&parts)
        })
        .collect();
    Band {
        force_n,
        half_width_n,
    }
}

//! How well the noise that drives a parameter is known: the degrees of freedom of its interval.
//!
//! The estimate moves by C J^T V^-1 n when the noise is n, C = (J^T V^-1 J)^-1. Split n into the gains of the runs
//! (few, so their variance is poorly known) and what happens within runs (many correlation lengths, so it is well
//! known): the two shares of each parameter's variance and the degrees of freedom of each give, by Satterthwaite, those
//! of the parameter. A stiffness is nearly all gain; a Stribeck rate nearly none.

use fitting::criteria::satterthwaite;
use fitting::noise::{Context, NoiseModel, Whitener};
use nalgebra::DMatrix;

/// What drives the uncertainty of one parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drivers {
    /// Share of the variance that comes from the gains of the runs, 0 to 1.
    pub gain_share: f64,
    /// Degrees of freedom.
    pub degrees: f64,
}

/// Effective number of gains from which the scatter was estimated: sum of (s^2 l / (1 + s^2 l))^2 over the directions
/// between runs, l being the information on each (directions that the law's own parameters soak up count little).
pub(crate) fn scatter_degrees(noise: &NoiseModel) -> f64 {
    let s2 = noise.sizes.scatter.powi(2);
    noise
        .scatter
        .lambda
        .iter()
        .map(|l| (s2 * l / (1.0 + s2 * l)).powi(2))
        .sum()
}

/// Effective number of independent pieces of roughness: one a two correlation lengths of sliding, less the parameters.
fn within_degrees(context: &Context, noise: &NoiseModel, parameters: usize) -> f64 {
    let slid: f64 = context
        .runs
        .iter()
        .map(|run| context.sliding[run.end - 1] - context.sliding[run.start])
        .sum();
    let pieces = slid / (2.0 * noise.sizes.length.max(f64::MIN_POSITIVE));
    (pieces.min(context.samples() as f64) - parameters as f64).max(1.0)
}

/// Drivers of every parameter; `jacobian` whitened (samples x parameters), `covariance` (zero rows: not estimated).
pub(crate) fn drivers(
    context: &Context,
    whitener: &Whitener,
    noise: &NoiseModel,
    jacobian: &DMatrix<f64>,
    covariance: &DMatrix<f64>,
) -> Vec<Drivers> {
    let gain_degrees = scatter_degrees(noise);
    let within = within_degrees(context, noise, jacobian.ncols());
    // C J^T V^-1 h_k for the unit gain h_k of every run
    let mut gains = DMatrix::zeros(context.samples(), context.runs.len());
    for (k, run) in context.runs.iter().enumerate() {
        for i in run.clone() {
            gains[(i, k)] = context.scale[i];
        }
    }
    let moved = covariance * jacobian.tr_mul(&whitener.whiten_columns(&gains));
    (0..jacobian.ncols())
        .map(|j| {
            let total = covariance[(j, j)];
            let gain = (noise.sizes.scatter.powi(2) * moved.row(j).norm_squared()).min(total);
            if total <= 0.0 {
                return Drivers {
                    gain_share: 0.0,
                    degrees: within,
                };
            }
            let degrees = if gain <= 0.0 {
                within
            } else if gain_degrees < 0.5 {
                // A scatter that no repeats tell of: the interval rests on one direction at most.
                1.0
            } else {
                satterthwaite(&[(gain, gain_degrees), (total - gain, within)])
            };
            Drivers {
                gain_share: gain / total,
                degrees,
            }
        })
        .collect()
}

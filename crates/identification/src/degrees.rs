//! The quantile of each interval: how well the noise that drives a parameter is known.
//!
//! What happens within runs is told by many correlation lengths; the scatter between the gains of a few runs is not. With
//! the weights that the estimate uses, a gain b_k of run k moves the parameters by m_k = C J^T V^-1 h_k (C the
//! covariance, h_k the force of run k), so for a scatter s
//!
//! ```text
//! var(p_hat) = within + s^2 sum_k m_k^2,     p_hat - p ~ sum over s of w(s) N(0, within + s^2 sum_k m_k^2)
//! ```
//!
//! w being the posterior weight of s from the restricted likelihood under a scale-free prior. For a parameter that is all
//! gain this is Student's t with the degrees of freedom of the runs; for one that the gain does not touch it is normal;
//! in between it is the Behrens-Fisher mixture. (Satterthwaite's degrees, taken at an estimated share, cover too little
//! when the scatter happens to come out small.) The half width of 95 % over the standard deviation at the estimate of s
//! is the quantile that the profile uses.

use fitting::criteria::t_quantile;
use fitting::noise::{Context, NoiseModel, Whitener};
use nalgebra::{DMatrix, DVector};
use statrs::distribution::{Continuous, ContinuousCDF, Normal};

use crate::intervals::LEVEL;

/// What drives the uncertainty of one parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drivers {
    /// Share of the variance that comes from the gains of the runs, 0 to 1.
    pub gain_share: f64,
    /// Quantile of its 95 % interval, in standard deviations at the estimated noise.
    pub quantile: f64,
    /// Degrees of freedom of Student's t with that quantile.
    pub degrees: f64,
}

/// Of the movable columns, in their order.
pub(crate) struct Driven {
    /// Drivers and standard deviations, bounds left aside.
    pub(crate) each: Vec<(Drivers, f64)>,
    /// m_k of every run: change of the parameters (rows) a relative gain of run k.
    pub(crate) moved: DMatrix<f64>,
}

/// What drives the movable columns of `whitened` (samples x parameters), in the order of `movable`; `None` where the data
/// leave a direction open.
pub(crate) fn drivers(
    context: &Context,
    whitener: &Whitener,
    noise: &NoiseModel,
    whitened: &DMatrix<f64>,
    movable: &[usize],
) -> Option<Driven> {
    let jacobian = whitened.select_columns(movable);
    let covariance = fitting::covariance_of(&jacobian)?;
    let mut gains = DMatrix::zeros(context.samples(), context.runs.len());
    for (k, run) in context.runs.iter().enumerate() {
        for i in run.clone() {
            gains[(i, k)] = context.scale[i];
        }
    }
    let moved = &covariance * jacobian.tr_mul(&whitener.whiten_columns(&gains));
    let scatters = noise.scatter.posterior();
    let each = (0..movable.len())
        .map(|j| {
            let total = covariance[(j, j)];
            let by_gain = moved.row(j).norm_squared();
            let at_estimate = (noise.sizes.scatter.powi(2) * by_gain).min(total);
            let within = total - at_estimate;
            let parts: Vec<(f64, f64)> = scatters
                .iter()
                .map(|(s, weight)| (*weight, (within + s * s * by_gain).sqrt()))
                .collect();
            let sd = total.sqrt();
            let quantile = half_width(&parts) / sd;
            let driver = Drivers {
                gain_share: at_estimate / total,
                quantile,
                degrees: degrees_of(quantile),
            };
            (driver, sd)
        })
        .collect();
    Some(Driven { each, moved })
}

/// The same for a law that misses the record: its residual is structure, not noise, and counts for as many independent
/// pieces as its autocorrelation leaves. The quantile is Student's with one degree a run less one, widened by
/// sqrt(1 + 2 sum of autocorrelations).
pub(crate) fn plain_drivers(
    context: &Context,
    residual: &DVector<f64>,
    whitened: &DMatrix<f64>,
    movable: &[usize],
) -> Option<Driven> {
    let covariance = fitting::covariance_of(&whitened.select_columns(movable))?;
    let degrees = (context.runs.len() as f64 - 1.0).max(1.0);
    let quantile = t_quantile(LEVEL, degrees) * correlation_time(context, residual).sqrt();
    let driver = Drivers {
        gain_share: 0.0,
        quantile,
        degrees,
    };
    let each = (0..movable.len())
        .map(|j| (driver, covariance[(j, j)].sqrt()))
        .collect();
    Some(Driven {
        each,
        moved: DMatrix::zeros(movable.len(), 0),
    })
}

/// 1 + 2 sum of the autocorrelations of a residual within runs, up to the first that is not positive, in samples.
fn correlation_time(context: &Context, residual: &DVector<f64>) -> f64 {
    let power = residual.norm_squared();
    let longest = context.runs.iter().map(|run| run.len()).max().unwrap_or(0);
    let mut time = 1.0;
    for lag in 1..longest {
        let product: f64 = context
            .runs
            .iter()
            .flat_map(|run| run.clone().skip(lag).map(move |i| (i, i - lag)))
            .map(|(i, k)| residual[i] * residual[k])
            .sum();
        if product <= 0.0 {
            break;
        }
        time += 2.0 * product / power;
    }
    time
}

/// q with P(|error| <= q) = 95 % for a mixture of normals given as (weight, standard deviation).
///
/// P(|error| > q) falls and is convex for q > 0, so that Newton's steps from the left of the root stay on the left.
pub(crate) fn half_width(parts: &[(f64, f64)]) -> f64 {
    let normal = Normal::standard();
    let total: f64 = parts.iter().map(|p| p.0).sum();
    let narrowest = parts.iter().map(|p| p.1).fold(f64::INFINITY, f64::min);
    let mut q = normal.inverse_cdf(0.5 * (1.0 + LEVEL)) * narrowest;
    for _ in 0..100 {
        let (mut outside, mut slope) = (0.0, 0.0);
        for (w, sd) in parts.iter().filter(|p| p.1 > 0.0) {
            outside += 2.0 * w / total * normal.cdf(-q / sd);
            slope += 2.0 * w / total * normal.pdf(q / sd) / sd;
        }
        let step = (outside - (1.0 - LEVEL)) / slope;
        if step.is_nan() || step <= 1e-12 * q {
            break;
        }
        q += step;
    }
    q
}

/// Degrees of freedom at which Student's t has this two-sided 95 % quantile (1 at least, infinite at the normal one).
fn degrees_of(quantile: f64) -> f64 {
    if quantile <= t_quantile(LEVEL, 1e5) {
        return f64::INFINITY;
    }
    let (mut low, mut high) = (0.0_f64, 1e5_f64.ln());
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if t_quantile(LEVEL, middle.exp()) > quantile {
            low = middle;
        } else {
            high = middle;
        }
    }
    (0.5 * (low + high)).exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_normal_has_the_normal_quantile() {
        assert!((half_width(&[(1.0, 2.0)]) - 2.0 * 1.959_964).abs() < 1e-5);
        assert!(degrees_of(1.9599).is_infinite());
    }

    /// Normals whose variance is nu over chi-squared with nu degrees of freedom mix to Student's t with nu.
    #[test]
    fn scaled_inverse_chi_squares_mix_to_student() {
        let nu = 4.0_f64;
        // Density of the standard deviation: s^-(nu+1) exp(-nu/(2 s^2)), on an even grid of log s (measure s).
        let parts: Vec<(f64, f64)> = (-400..1600)
            .map(|k| {
                let s = (0.005 * f64::from(k)).exp();
                (s.powf(-nu) * (-nu / (2.0 * s * s)).exp(), s)
            })
            .collect();
        let quantile = half_width(&parts);
        assert!((quantile - 2.776).abs() < 2e-3, "{quantile}");
        assert!((degrees_of(quantile) - nu).abs() < 0.02);
    }
}

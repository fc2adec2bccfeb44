//! Many starts, one answer: local minima are found by looking, not assumed away.

use crate::bounds::{Bounds, BoundsError};
use crate::levenberg_marquardt::Options;
use crate::minimise::{Fit, minimise};
use crate::residuals::Residuals;
use rayon::prelude::*;

/// Result of a multi-start.
#[derive(Clone, Debug)]
pub struct MultiStart {
    /// The best fit (lowest cost among converged ones; the lowest of all when none converged; ties by order of starts).
    pub best: Fit,
    /// Which start led there.
    pub winner: usize,
    /// How many converged starts ended within a relative 1e-6 of the best cost.
    pub agreeing: usize,
    /// How many starts converged at all.
    pub converged: usize,
    /// How many were tried.
    pub tried: usize,
    /// Accepted steps, evaluations of r, evaluations of J over all starts.
    pub work: (u64, u64, u64),
    /// All fits, in the order of the starts.
    pub fits: Vec<Fit>,
}

/// Minimises from every start in parallel; the answer depends on the starts and their order only.
///
/// # Errors
/// When there is no start, or one has the wrong length.
pub fn multi_start<R: Residuals + ?Sized>(
    problem: &R,
    starts: &[Vec<f64>],
    bounds: &Bounds,
    options: &Options,
) -> Result<MultiStart, BoundsError> {
    let fits: Vec<Fit> = starts
        .par_iter()
        .map(|start| minimise(problem, start, bounds, options))
        .collect::<Result<_, _>>()?;
    let rank = |fit: &Fit| {
        let cost = if fit.cost.is_finite() {
            fit.cost
        } else {
            f64::INFINITY
        };
        (!fit.status.converged(), cost)
    };
    let winner = (0..fits.len())
        .min_by(|&a, &b| {
            let ((na, ca), (nb, cb)) = (rank(&fits[a]), rank(&fits[b]));
            na.cmp(&nb).then(ca.total_cmp(&cb)).then(a.cmp(&b))
        })
        .ok_or(BoundsError::Lengths {
            lower: bounds.len(),
            upper: 0,
        })?;
    let lowest = fits[winner].cost;
    let converged = fits.iter().filter(|f| f.status.converged()).count();
    let agreeing = fits
        .iter()
        .filter(|f| f.status.converged() && f.cost - lowest <= 1e-6 * lowest)
        .count();
    let work = fits.iter().fold((0, 0, 0), |w, f| {
        (w.0 + f.iterations, w.1 + f.evaluations, w.2 + f.jacobians)
    });
    Ok(MultiStart {
        best: fits[winner].clone(),
        winner,
        agreeing,
        converged,
        tried: fits.len(),
        work,
        fits,
    })
}

/// `count` points that fill the box [low, high] evenly: the Halton sequence (Halton 1960), no random numbers.
///
/// Where both ends are positive the points are spread evenly in the logarithm.
pub fn spread_starts(low: &[f64], high: &[f64], count: usize) -> Vec<Vec<f64>> {
    const PRIMES: [u32; 16] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53];
    (1..=count as u32)
        .map(|k| {
            low.iter()
                .zip(high)
                .enumerate()
                .map(|(j, (&l, &h))| {
                    let u = radical_inverse(k, PRIMES[j % PRIMES.len()]);
                    if l > 0.0 && h > l {
                        l * (h / l).powf(u)
                    } else {
                        l + u * (h - l)
                    }
                })
                .collect()
        })
        .collect()
}

/// The digits of k in `base`, mirrored at the point.
fn radical_inverse(mut k: u32, base: u32) -> f64 {
    let (mut value, mut place) = (0.0, 1.0 / f64::from(base));
    while k > 0 {
        value += place * f64::from(k % base);
        k /= base;
        place /= f64::from(base);
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halton_points_are_the_published_ones_and_stay_inside() {
        // First terms of the base 2 and base 3 sequences.
        let points = spread_starts(&[0.0, 0.0], &[1.0, 1.0], 4);
        let first: Vec<f64> = points.iter().map(|p| p[0]).collect();
        assert_eq!(first, vec![0.5, 0.25, 0.75, 0.125]);
        assert!((points[3][1] - 4.0 / 9.0).abs() < 1e-15);
        let logarithmic = spread_starts(&[1e-3], &[1e3], 1);
        assert!((logarithmic[0][0] - 1.0).abs() < 1e-12);
    }
}

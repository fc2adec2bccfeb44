//! What a fit's residual says of the scatter between runs, and what the scatter costs it.
//!
//! With W the whitening without scatter, r the residual, H a gain column a run, (W H)'(W H) = E diag(lambda) E' and
//! t = E'(W H)'W r, the fit's -2 log likelihood under a relative scatter s of the runs' gains is, but for a constant,
//!
//! ```text
//! D(s) = log det V(s) + (W r)'V(s)^-1 W r,   V(s) = I + s^2 (W H)(W H)'
//!      = |W r|^2 + sum_k [ log(1 + s^2 lambda_k) - s^2 t_k^2 / (1 + s^2 lambda_k) ]                       (D9)
//! ```

use nalgebra::{DMatrix, DVector};

/// 95 % quantile of chi-squared with one degree of freedom: what a likelihood loses at the end of an interval.
const WITHIN: f64 = 3.841_458_820_694_124;
/// Scatters from far below to far above anything that a rig shows, in steps of five percent.
const SMALLEST: f64 = 1e-6;
const RATIO: f64 = 1.05;
const SCATTERS: i32 = 280;

/// D of (D9) as a function of the scatter.
pub(crate) struct ScatterDeviance {
    /// |W r|^2.
    plain: f64,
    /// lambda and t.
    pairs: Vec<(f64, f64)>,
}

impl ScatterDeviance {
    /// From whitened gain columns and a whitened residual.
    pub(crate) fn new(gains: &DMatrix<f64>, residual: &DVector<f64>) -> Self {
        let eigen = gains.tr_mul(gains).symmetric_eigen();
        let turned = eigen.eigenvectors.tr_mul(&gains.tr_mul(residual));
        let pairs = eigen
            .eigenvalues
            .iter()
            .zip(turned.iter())
            .filter(|(l, _)| **l > 0.0)
            .map(|(l, t)| (*l, *t))
            .collect();
        Self {
            plain: residual.norm_squared(),
            pairs,
        }
    }

    /// D(s) - D(0).
    fn between(&self, scatter: f64) -> f64 {
        let s2 = scatter * scatter;
        self.pairs
            .iter()
            .map(|(l, t)| (s2 * l).ln_1p() - s2 * t * t / (1.0 + s2 * l))
            .sum()
    }

    /// The smallest D over all scatters.
    pub(crate) fn least(&self) -> f64 {
        self.least_within(f64::INFINITY)
    }

    /// The smallest D over scatters up to a bound.
    pub(crate) fn least_within(&self, bound: f64) -> f64 {
        let best = scatters()
            .take_while(|s| *s <= bound)
            .map(|s| self.between(s))
            .fold(0.0, f64::min);
        self.plain + best
    }

    /// The largest scatter that agrees with the residual: D there is within [`WITHIN`] of the smallest.
    pub(crate) fn largest(&self) -> f64 {
        let limit = self.least() - self.plain + WITHIN;
        scatters()
            .filter(|s| self.between(*s) <= limit)
            .fold(0.0, f64::max)
    }
}

fn scatters() -> impl Iterator<Item = f64> {
    (0..SCATTERS).map(|i| SMALLEST * RATIO.powi(i))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whitened friction of a run: its root is what a gain of one moves, in standard deviations.
    const LAMBDA: f64 = 1e4;

    /// Runs of two whitened samples each: the first is the run's friction, missed by the given gain, the second is none of it.
    fn deviance(gains: &[f64], rest: f64) -> ScatterDeviance {
        let runs = gains.len();
        let columns =
            DMatrix::from_fn(
                2 * runs,
                runs,
                |i, k| {
                    if i == 2 * k { LAMBDA.sqrt() } else { 0.0 }
                },
            );
        let residual = DVector::from_fn(2 * runs, |i, _| match i % 2 {
            0 => gains[i / 2] * LAMBDA.sqrt(),
            _ => rest,
        });
        ScatterDeviance::new(&columns, &residual)
    }

    /// For gains +-g the likeliest scatter has 1 + s^2 lambda = g^2 lambda = q and D = rest^2 + log q + 1 a run.
    #[test]
    fn the_smallest_deviance_is_that_at_the_scatter_of_the_gains() {
        for (gain, rest) in [(0.02, 3.0), (0.1, 0.0), (0.2, 20.0)] {
            let own = deviance(&[gain, -gain, gain], rest);
            let q: f64 = gain * gain * LAMBDA;
            let exact = 3.0 * (rest * rest + q.ln() + 1.0);
            assert!(
                (own.least() - exact).abs() < 5e-3,
                "{} {exact}",
                own.least()
            );
            let likeliest = ((q - 1.0) / LAMBDA).sqrt();
            assert!(own.largest() > likeliest);
            let limit = own.least() + WITHIN;
            assert!(own.plain + own.between(own.largest()) <= limit);
            assert!(own.plain + own.between(RATIO * own.largest()) > limit);
        }
    }

    #[test]
    fn no_gains_leave_the_scatter_within_what_the_runs_would_show() {
        let own = deviance(&[0.0; 4], 1.0);
        assert_eq!(own.least(), 4.0);
        // 4 log(1 + s^2 lambda) = 3.84
        let exact = ((WITHIN / 4.0).exp_m1() / LAMBDA).sqrt();
        assert!(own.largest() <= exact && RATIO * own.largest() > exact);
    }

    /// What predicts nothing has gains of one, and with a scatter of its own it beats a law that misses a little within runs.
    /// Held to the scatter of the law that fits, each of its gains costs (1/s)^2.
    #[test]
    fn gains_cost_what_the_law_that_fits_lets_them_cost() {
        let fits = deviance(&[0.01, -0.02, 0.02, 0.0, 0.01, -0.01], 1.0);
        let nothing = deviance(&[1.0; 6], 1.0);
        let misses = deviance(&[0.01, -0.02, 0.02, 0.0, 0.01, -0.01], 20.0);
        assert!(fits.least() < nothing.least() && nothing.least() < misses.least());
        let bound = fits.largest();
        assert_eq!(fits.least_within(bound), fits.least());
        assert_eq!(misses.least_within(bound), misses.least());
        let held = nothing.least_within(bound);
        assert!(held > misses.least_within(bound));
        let spread = 1.0 + bound * bound * LAMBDA;
        let exact = 6.0 * (1.0 + spread.ln() + LAMBDA / spread);
        assert!((held / exact - 1.0).abs() < 1e-9, "{held} {exact}");
    }
}

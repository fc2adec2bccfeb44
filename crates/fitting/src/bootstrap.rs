//! Resampling, as a diagnostic: with few runs its intervals are too narrow, and that is worth showing.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// Draws of all parameters.
#[derive(Clone, Debug)]
pub struct Bootstrap {
    /// One row of parameters per draw that could be fitted.
    pub draws: Vec<Vec<f64>>,
    /// Draws that could not.
    pub failed: usize,
}

impl Bootstrap {
    /// Percentile interval of parameter `index` at `level`; `None` with fewer than 20 draws.
    pub fn percentile_interval(&self, index: usize, level: f64) -> Option<(f64, f64)> {
        if self.draws.len() < 20 {
            return None;
        }
        let mut values: Vec<f64> = self.draws.iter().map(|d| d[index]).collect();
        values.sort_by(f64::total_cmp);
        let tail = 0.5 * (1.0 - level);
        Some((quantile(&values, tail), quantile(&values, 1.0 - tail)))
    }
}

/// Linear interpolation between order statistics (definition 7 of Hyndman and Fan 1996).
fn quantile(sorted: &[f64], p: f64) -> f64 {
    let place = p * (sorted.len() - 1) as f64;
    let below = place.floor() as usize;
    let above = (below + 1).min(sorted.len() - 1);
    sorted[below] + (place - below as f64) * (sorted[above] - sorted[below])
}

/// Repeats `refit` with a generator of its own per draw: stream k of `seed`, so the number of threads changes nothing.
pub fn bootstrap<F>(count: usize, seed: u64, refit: F) -> Bootstrap
where
    F: Fn(&mut ChaCha8Rng) -> Option<Vec<f64>> + Sync,
{
    let draws: Vec<Option<Vec<f64>>> = (0..count)
        .into_par_iter()
        .map(|k| {
            let mut generator = ChaCha8Rng::seed_from_u64(seed);
            generator.set_stream(k as u64);
            refit(&mut generator)
        })
        .collect();
    let failed = draws.iter().filter(|d| d.is_none()).count();
    Bootstrap {
        draws: draws.into_iter().flatten().collect(),
        failed,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_distr::{Distribution, Normal};

    #[test]
    fn percentile_interval_of_normal_draws_is_two_standard_deviations() {
        let normal = Normal::new(3.0, 0.5).unwrap();
        let draws = bootstrap(4000, 7, |generator| Some(vec![normal.sample(generator)]));
        let (low, high) = draws.percentile_interval(0, 0.95).unwrap();
        assert!((low - (3.0 - 0.98)).abs() < 0.05, "{low}");
        assert!((high - (3.0 + 0.98)).abs() < 0.05, "{high}");
        let again = bootstrap(4000, 7, |generator| Some(vec![normal.sample(generator)]));
        assert_eq!(draws.draws, again.draws);
    }

    #[test]
    fn failures_are_counted_not_hidden() {
        let draws = bootstrap(10, 1, |_| None);
        assert_eq!(draws.failed, 10);
        assert!(draws.percentile_interval(0, 0.95).is_none());
    }
}

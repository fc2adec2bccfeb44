//! Spikes: single samples far out, here and there, such as a bad contact makes them.
//!
//! Noise with heavy tails has samples far out too, and ever fewer the further out. No healthy noise is taken to have heavier tails than
//! Student's t with four degrees of freedom: more samples beyond r times the median of all than such noise has are spikes,
//!
//! ```text
//! count of |y| > r m,   m = median |y|,   expected n P(|t_4| > r m_4),   m_4 = median |t_4| = 0.741
//! ```
//!
//! with r on a grid that Bonferroni's bound pays for. What stands close together is one spike: whitening carries a sample into the next.

use std::ops::Range;

use nalgebra::DVector;
use statrs::distribution::{ContinuousCDF, StudentsT};

use crate::answer::Place;
use crate::bursts::{levelled, log_poisson_tail};
use crate::general::Lack;
use crate::samples::Samples;

/// The heaviest tails of a healthy noise.
const FREEDOM: f64 = 4.0;
/// Multiples of the median beyond which samples are counted.
const LEVELS: [f64; 4] = [8.0, 11.0, 16.0, 22.0];
/// Whitening is not perfect everywhere: so many times more are let pass.
const UNEVEN: f64 = 2.0;
/// Samples within which several far out are one spike.
const TOGETHER: usize = 5;

/// Spikes in the whitened residual, and the runs that hold them.
pub(crate) fn spikes(y: &DVector<f64>, samples: &Samples, names: &[String]) -> Lack {
    let y = levelled(y.as_slice(), &samples.runs);
    let Some((log_p, found)) = far_out(&y, &samples.runs).filter(|(log_p, _)| *log_p < 0.0) else {
        return Lack::nothing();
    };
    Lack {
        log_p,
        excess: found.iter().map(|&i| y[i] * y[i] - 1.0).sum(),
        place: place(&found, samples, names),
    }
}

/// Logarithm of the tail probability of the least probable count, all levels paid for, and the samples that it counts.
fn far_out(y: &[f64], runs: &[Range<usize>]) -> Option<(f64, Vec<usize>)> {
    let student = StudentsT::new(0.0, 1.0, FREEDOM).ok()?;
    let mut sizes: Vec<f64> = y.iter().map(|v| v.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let median = *sizes.get(sizes.len() / 2).filter(|m| **m > 0.0)?;
    let unit = student.inverse_cdf(0.75);
    let counted = LEVELS.iter().map(|&level| {
        let found = apart(y, runs, level * median);
        let share = 2.0 * student.cdf(-level * unit);
        let log_p = log_poisson_tail(UNEVEN * share * y.len() as f64, found.len());
        ((log_p + (LEVELS.len() as f64).ln()).min(0.0), found)
    });
    counted.min_by(|a, b| a.0.total_cmp(&b.0))
}

/// The samples beyond a level, of those that stand close together in a run the first.
fn apart(y: &[f64], runs: &[Range<usize>], level: f64) -> Vec<usize> {
    let mut found: Vec<usize> = Vec::new();
    for run in runs {
        let mut last = None;
        for i in run.clone().filter(|&i| y[i].abs() > level) {
            if last.is_none_or(|last| i > last + TOGETHER) {
                found.push(i);
            }
            last = Some(i);
        }
    }
    found
}

/// The time of the runs in which they lie, from the first to the last.
fn place(found: &[usize], samples: &Samples, names: &[String]) -> Option<Place> {
    let times = || found.iter().map(|&i| samples.time[i]);
    let mut runs: Vec<usize> = found.iter().map(|&i| samples.owner[i]).collect();
    runs.dedup();
    (!runs.is_empty()).then(|| Place {
        axis: "time".into(),
        from: times().fold(f64::INFINITY, f64::min),
        to: times().fold(f64::NEG_INFINITY, f64::max),
        unit: "s".into(),
        runs: runs.into_iter().map(|run| names[run].clone()).collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal, StudentT};

    /// Eighty samples of 7.7 standard deviations among 6,800 normal ones are spikes; the tails of Student's t are none, nor are three
    /// samples in a row that one event made.
    #[test]
    fn spikes_are_told_from_heavy_tails() {
        const RUN: usize = 680;
        const NAMED: f64 = 0.004;
        let runs: Vec<Range<usize>> = (0..10).map(|k| k * RUN..(k + 1) * RUN).collect();
        let mut generator = ChaCha8Rng::seed_from_u64(11);
        let t = StudentT::new(FREEDOM).expect("a freedom");
        for _ in 0..20 {
            let mut normal: Vec<f64> = (0..10 * RUN)
                .map(|_| StandardNormal.sample(&mut generator))
                .collect();
            let heavy: Vec<f64> = (0..10 * RUN).map(|_| t.sample(&mut generator)).collect();
            for healthy in [&normal, &heavy] {
                let (log_p, _) = far_out(healthy, &runs).expect("samples");
                assert!(log_p > NAMED.ln(), "{log_p}");
            }
            let mut event = normal.clone();
            event[300..303].fill(9.0);
            let (_, found) = far_out(&event, &runs).expect("samples");
            assert!(found.len() <= 1, "{found:?}");
            for _ in 0..80 {
                normal[generator.random_range(0..10 * RUN)] += 7.7;
            }
            let (log_p, found) = far_out(&normal, &runs).expect("samples");
            assert!(log_p < -20.0 && found.len() > 40, "{log_p} {}", found.len());
        }
    }
}

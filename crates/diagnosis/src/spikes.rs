//! Spikes: single samples far out, here and there, such as a bad contact makes them.
//!
//! Noise with heavy tails has samples far out too, and ever fewer the further out. No healthy noise is taken to have heavier tails than
//! Student's t with four degrees of freedom. Spikes are more samples beyond a level l than such noise has, or, where they are all alike,
//! more just beyond a level than just below it:
//!
//! ```text
//! #(|y| > l)                       against   n P(|t_4| > l),
//! #(l < |y| < R l)   out of   #(l / R < |y| < R l)   against   P(l < |t_4| < R l) / P(l / R < |t_4| < R l)
//! ```
//!
//! in units of the median. A spike may be two samples wide, each no further out than heavy tails are; but these do not come in pairs: more
//! neighbours beyond a level together, on one side or on opposite ones, than the share of samples beyond it makes, and what little
//! whitening leaves of one sample in the next,
//!
//! ```text
//! #(|y_i| > l, |y_i+1| > l, y_i y_i+1 >< 0)   against   exp(+-r l^2) sum over runs n p^2 / 2,   p: share of the run's samples beyond l.
//! ```
//!
//! The levels are paid for by Bonferroni's bound. What stands close together is one spike: whitening carries a sample into the next.

use std::ops::Range;

use statrs::distribution::{ContinuousCDF, StudentsT};

use crate::answer::Place;
use crate::bursts::log_poisson_tail;
use crate::general::Lack;
use crate::samples::Samples;

/// The heaviest tails of a healthy noise.
const FREEDOM: f64 = 4.0;
/// Multiples of the median beyond which samples are counted.
const LEVELS: [f64; 4] = [8.0, 11.0, 16.0, 22.0];
/// Multiples of the median at which what lies just beyond is held against what lies just below, and R.
const EDGES: [f64; 7] = [4.5, 5.5, 6.7, 8.2, 10.0, 12.2, 15.0];
const BAND: f64 = 1.3;
/// Multiples of the median beyond which two neighbours together are counted.
const ROWS: [f64; 4] = [3.4, 4.1, 5.0, 6.0];
/// Whitening is not perfect everywhere: so many times more are let pass, of all samples and of those near a level.
const UNEVEN: f64 = 2.0;
const UNEVEN_NEAR: f64 = 1.2;
/// Multiples of a normal standard deviation beyond which samples say nothing of how neighbours go together.
const CALM: f64 = 2.0;
/// Samples within which several far out are one spike.
const TOGETHER: usize = 5;

/// Spikes in the whitened residual without its level, and the runs that hold them.
pub(crate) fn spikes(y: &[f64], samples: &Samples, names: &[String]) -> Lack {
    let Some((log_p, found)) = far_out(y, &samples.runs).filter(|(log_p, _)| *log_p < 0.0) else {
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
    let beyond = |level: f64| 2.0 * student.cdf(-level * unit);
    let many = LEVELS.iter().map(|&level| {
        let found = Event::beyond(y, runs, level * median);
        let expected = UNEVEN * beyond(level) * y.len() as f64;
        (log_poisson_tail(expected, found.len()), found)
    });
    let alike = EDGES.iter().map(|&level| {
        let (below, above) = (beyond(level / BAND), beyond(level * BAND));
        let share = UNEVEN_NEAR * (beyond(level) - above) / (below - above);
        let mut found = Event::beyond(y, runs, level / BAND * median);
        found.retain(|event| event.size < level * BAND * median);
        let near = found.len();
        found.retain(|event| event.size > level * median);
        (log_binomial_tail(share, found.len(), near), found)
    });
    let carried = carried_over(y, runs, CALM * median / unit);
    let in_a_row = ROWS.iter().flat_map(|&level| {
        // the joint tail of two normal numbers of correlation r, both beyond l, is some exp(r l^2) times that of independent ones
        [1.0, -1.0].map(|sign| {
            let normal = level * unit;
            let near = (sign * carried * normal * normal).max(0.0).exp();
            let (expected, found) = in_a_row(y, runs, level * median, sign);
            let expected = UNEVEN * near * expected;
            (log_poisson_tail(expected, found.len()), found)
        })
    });
    let price = ((LEVELS.len() + EDGES.len() + 2 * ROWS.len()) as f64).ln();
    let (log_p, found) = (many.chain(alike).chain(in_a_row)).min_by(|a, b| a.0.total_cmp(&b.0))?;
    let at = found.into_iter().map(|event| event.at).collect();
    Some(((log_p + price).min(0.0), at))
}

/// How many pairs of neighbours are to be expected beyond a level together, on the same side (`sign` 1) or on opposite ones (-1), and where
/// they are. Each run has a share of samples beyond it of its own.
fn in_a_row(y: &[f64], runs: &[Range<usize>], level: f64, sign: f64) -> (f64, Vec<Event>) {
    let (mut expected, mut found) = (0.0, Vec::new());
    for run in runs {
        let beyond = |i: &usize| y[*i].abs() > level;
        let share = run.clone().filter(beyond).count() as f64 / run.len().max(1) as f64;
        expected += 0.5 * run.len() as f64 * share * share;
        let mut free_from = run.start;
        for i in run.start..run.end.max(1) - 1 {
            let size = y[i].abs().min(y[i + 1].abs());
            if i >= free_from && size > level && sign * y[i] * y[i + 1] > 0.0 {
                found.push(Event { at: i, size });
                free_from = i + TOGETHER;
            }
        }
    }
    (expected, found)
}

/// Correlation of neighbours, of what lies within a level.
fn carried_over(y: &[f64], runs: &[Range<usize>], level: f64) -> f64 {
    let calm = |v: f64| v.clamp(-level, level);
    let of_run = |run: &Range<usize>| {
        y[run.clone()]
            .windows(2)
            .map(|w| calm(w[0]) * calm(w[1]))
            .sum::<f64>()
    };
    let squares: f64 = y.iter().map(|&v| calm(v).powi(2)).sum();
    runs.iter().map(of_run).sum::<f64>() / squares.max(f64::MIN_POSITIVE)
}

/// ln P(X >= count) of a number X out of n, each with the probability p, or above: Chernoff's bound.
fn log_binomial_tail(p: f64, count: usize, n: usize) -> f64 {
    let share = count as f64 / n.max(1) as f64;
    if share <= p {
        return 0.0;
    }
    let part = |share: f64, p: f64| match share > 0.0 {
        true => share * (share / p).ln(),
        false => 0.0,
    };
    -(n as f64) * (part(share, p) + part(1.0 - share, 1.0 - p))
}

/// Samples far out that stand close together in a run: where the first is, and how far out the furthest.
struct Event {
    at: usize,
    size: f64,
}

impl Event {
    /// All events beyond a level.
    fn beyond(y: &[f64], runs: &[Range<usize>], level: f64) -> Vec<Self> {
        let mut found: Vec<Self> = Vec::new();
        for run in runs {
            let mut last = None;
            for i in run.clone().filter(|&i| y[i].abs() > level) {
                let size = y[i].abs();
                match found.last_mut() {
                    Some(event) if last.is_some_and(|last| i <= last + TOGETHER) => {
                        event.size = event.size.max(size);
                    }
                    _ => found.push(Self { at: i, size }),
                }
                last = Some(i);
            }
        }
        found
    }
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

    const RUN: usize = 680;
    const NAMED: f64 = 0.004;

    fn runs() -> Vec<Range<usize>> {
        (0..10).map(|k| k * RUN..(k + 1) * RUN).collect()
    }

    fn found(y: &[f64]) -> (f64, Vec<usize>) {
        far_out(y, &runs()).expect("samples")
    }

    /// Neither normal noise nor that with the heaviest tails has spikes, nor has a sum of both; three samples in a row are one event.
    #[test]
    fn tails_are_no_spikes() {
        let mut generator = ChaCha8Rng::seed_from_u64(11);
        let t = StudentT::new(FREEDOM).expect("a freedom");
        let mut draw = |normal: f64, heavy: f64| -> Vec<f64> {
            let mut one = || {
                let z: f64 = StandardNormal.sample(&mut generator);
                normal * z + heavy * t.sample(&mut generator)
            };
            (0..10 * RUN).map(|_| one()).collect()
        };
        for (normal, heavy) in [(1.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.3)] {
            for _ in 0..20 {
                let mut y = draw(normal, heavy);
                assert!(found(&y).0 > NAMED.ln(), "{}", found(&y).0);
                let far = 40.0;
                y[300..303].fill(far);
                let events = Event::beyond(&y, &runs(), far - 1.0);
                assert_eq!(
                    events.iter().filter(|e| (300..303).contains(&e.at)).count(),
                    1
                );
            }
        }
    }

    /// Twenty spikes of two samples each in four runs, no sample further out than tails are, are told from noise; the same samples apart are
    /// not.
    #[test]
    fn spikes_of_two_samples_are_told_from_tails() {
        const SIZE: f64 = 3.8;
        let mut generator = ChaCha8Rng::seed_from_u64(13);
        for (second, apart, seen) in [(SIZE, 1, 18..=20), (-SIZE, 1, 18..=20), (SIZE, 17, 0..=1)] {
            let mut told = 0;
            for _ in 0..20 {
                let mut y: Vec<f64> = (0..10 * RUN)
                    .map(|_| StandardNormal.sample(&mut generator))
                    .collect();
                for k in 0..20 {
                    let within = generator.random_range(0..RUN / 5 - 20);
                    let at = (k % 4) * RUN + (k / 4) * (RUN / 5) + within;
                    let sign = if generator.random::<bool>() {
                        1.0
                    } else {
                        -1.0
                    };
                    y[at] += sign * SIZE;
                    y[at + apart] += sign * second;
                }
                told += usize::from(found(&y).0 < NAMED.ln());
            }
            assert!(seen.contains(&told), "{second} {apart}: {told}");
        }
    }

    /// Eighty samples among 6,800 normal ones are spikes where they lie far out, and where they are all alike no further out than
    /// heavy tails.
    #[test]
    fn spikes_are_told_from_tails() {
        let mut generator = ChaCha8Rng::seed_from_u64(12);
        for size in [12.0, 9.0, 7.7] {
            for _ in 0..20 {
                let mut y: Vec<f64> = (0..10 * RUN)
                    .map(|_| StandardNormal.sample(&mut generator))
                    .collect();
                for _ in 0..80 {
                    y[generator.random_range(0..10 * RUN)] += size;
                }
                let (log_p, spikes) = found(&y);
                assert!(log_p < NAMED.ln(), "{size}: {log_p}");
                assert!(spikes.len() > 30, "{size}: {}", spikes.len());
            }
        }
    }
}

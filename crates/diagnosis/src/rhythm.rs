//! A rhythm that one run keeps for a while: stick-slip, chatter, something that turns.
//!
//! The whitened residual of a healthy rig has the same power at every frequency, so the periodogram of a stretch,
//!
//! ```text
//! P(f) = (2 / n) |sum_j y_j exp(-2 pi i f j)|^2                                                        (D7)
//! ```
//!
//! is a chi-squared with two degrees of freedom. What whitening leaves uneven over the frequencies is taken from the other
//! stretches of the campaign, at least the healthy rig's own.
//!
//! Stick-slip is a sawtooth. Its h-th harmonic has 1 / h^2 of the power, and roughness that falls as steeply leaves them all alike in the whitened
//! residual: P(f) + P(2f) + ... + P(Hf), a chi-squared with 2H degrees of freedom, shows what no single one of them does.

use std::ops::Range;

use nalgebra::DVector;

use crate::answer::Place;
use crate::bursts::in_run;
use crate::general::Lack;
use crate::samples::Samples;
use crate::tail::log_chi2_tail;

/// Samples of a stretch; neighbours overlap by half.
const WINDOW: usize = 90;
/// Slowest rhythm, in turns a stretch.
const SLOWEST: usize = 3;
/// Frequencies in one turn a stretch: of a rhythm between two of them the last harmonic loses less than a third of its power.
const BETWEEN: usize = 8;
/// As many of them count as asked on their own.
const APART: usize = 2;
/// Harmonics that are summed, at most.
const HARMONICS: usize = 5;
/// Median of a chi-squared with two degrees of freedom, 2 ln 2.
const MEDIAN: f64 = 2.0 * std::f64::consts::LN_2;

/// One stretch of a run with its periodogram over that of the campaign's other stretches.
struct Stretch {
    run: usize,
    start: usize,
    /// Place in the run, in half stretches.
    slot: usize,
    powers: Vec<f64>,
}

/// The strongest rhythm in a residual of unit variance: of one run, or of all runs at the same time together (a rhythm that comes back
/// in every other run is weak in each of them). The two searches pay for one another by Bonferroni's bound.
pub(crate) fn rhythm(y: &DVector<f64>, samples: &Samples, names: &[String]) -> Lack {
    let stretches = stretches(y, &samples.runs);
    if stretches.len() < 4 {
        return Lack::nothing();
    }
    let mut best = alone(&stretches, samples, names);
    let shared = together(&stretches, samples, names);
    if shared.log_p < best.log_p {
        best = shared;
    }
    best.log_p = (best.log_p + 2.0_f64.ln()).min(0.0);
    best
}

fn stretches(y: &DVector<f64>, runs: &[Range<usize>]) -> Vec<Stretch> {
    let waves = waves();
    let mut out = Vec::new();
    for (run, range) in runs.iter().enumerate() {
        let last = range.end.saturating_sub(WINDOW - 1);
        for (slot, start) in (range.start..last).step_by(WINDOW / 2).enumerate() {
            let powers = periodogram(&y.as_slice()[start..start + WINDOW], &waves);
            out.push(Stretch {
                run,
                start,
                slot,
                powers,
            });
        }
    }
    for f in 0..waves.len() {
        let mut own: Vec<f64> = out.iter().map(|s| s.powers[f]).collect();
        own.sort_by(f64::total_cmp);
        let background = own
            .get(own.len() / 2)
            .map_or(1.0, |m| (m / MEDIAN).max(1.0));
        out.iter_mut().for_each(|s| s.powers[f] /= background);
    }
    out
}

fn alone(stretches: &[Stretch], samples: &Samples, names: &[String]) -> Lack {
    let Some(Loudest {
        log_p,
        excess,
        stretch: best,
    }) = loudest(stretches)
    else {
        return Lack::nothing();
    };
    let last = best.start + WINDOW - 1;
    Lack {
        log_p: log_p.min(0.0),
        place: Some(in_run(samples, names, best.run, best.start, last)),
        excess: excess.max(0.0),
    }
}

/// The stretch with the least probable sum of harmonics.
struct Loudest<'a> {
    /// Logarithm of the tail probability, all stretches, frequencies and numbers of harmonics paid for.
    log_p: f64,
    /// Power beyond what is expected of noise.
    excess: f64,
    stretch: &'a Stretch,
}

fn loudest(stretches: &[Stretch]) -> Option<Loudest<'_>> {
    let frequencies = stretches.first()?.powers.len();
    let asked = (stretches.len() * frequencies * APART * HARMONICS) as f64 / BETWEEN as f64;
    let combs = (1..=HARMONICS).filter_map(|harmonics| {
        let strongest = |s: &Stretch| strongest_comb(&s.powers, harmonics);
        let powers = stretches.iter().map(|s| (strongest(s), s));
        let (power, stretch) = powers.max_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(Loudest {
            log_p: log_chi2_tail(power, 2 * harmonics) + asked.ln(),
            excess: power - 2.0 * harmonics as f64,
            stretch,
        })
    });
    combs.min_by(|a, b| a.log_p.total_cmp(&b.log_p))
}

/// The largest P(f) + ... + P(Hf) of a periodogram; 0 where it has no such frequency.
fn strongest_comb(powers: &[f64], harmonics: usize) -> f64 {
    const FIRST: usize = SLOWEST * BETWEEN;
    let combs = (FIRST..).take_while(|f| harmonics * f < FIRST + powers.len());
    combs
        .map(|f| (1..=harmonics).map(|h| powers[h * f - FIRST]).sum())
        .fold(0.0, f64::max)
}

fn together(stretches: &[Stretch], samples: &Samples, names: &[String]) -> Lack {
    /// A run is said to take part where so little would be chance.
    const TAKES_PART: f64 = 0.05;
    let slots = stretches.iter().map(|s| s.slot + 1).max().unwrap_or(0);
    let frequencies = stretches.first().map_or(0, |s| s.powers.len());
    let mut best = (0.0, 0, 0, 0.0);
    for slot in 0..slots {
        let own: Vec<&Stretch> = stretches.iter().filter(|s| s.slot == slot).collect();
        for f in 0..frequencies {
            let sum: f64 = own.iter().map(|s| s.powers[f]).sum();
            let log_p = log_chi2_tail(sum, 2 * own.len());
            if log_p < best.0 {
                best = (log_p, slot, f, sum - 2.0 * own.len() as f64);
            }
        }
    }
    let (log_p, slot, f, excess) = best;
    let loud: Vec<&Stretch> = stretches
        .iter()
        .filter(|s| s.slot == slot && s.powers[f] > -2.0 * TAKES_PART.ln())
        .collect();
    let place = loud.first().map(|first| Place {
        runs: loud.iter().map(|s| names[s.run].clone()).collect(),
        ..in_run(
            samples,
            names,
            first.run,
            first.start,
            first.start + WINDOW - 1,
        )
    });
    Lack {
        log_p: (log_p + ((slots * frequencies * APART) as f64 / BETWEEN as f64).ln()).min(0.0),
        place,
        excess: excess.max(0.0),
    }
}

/// cos and sin of 2 pi f j over one stretch, for each frequency that is asked.
fn waves() -> Vec<Vec<(f64, f64)>> {
    (SLOWEST * BETWEEN..BETWEEN * WINDOW / 2)
        .map(|f| {
            let step = std::f64::consts::TAU * f as f64 / (BETWEEN * WINDOW) as f64;
            (0..WINDOW)
                .map(|j| ((step * j as f64).cos(), (step * j as f64).sin()))
                .collect()
        })
        .collect()
}

/// (D7) of one stretch.
fn periodogram(y: &[f64], waves: &[Vec<(f64, f64)>]) -> Vec<f64> {
    waves
        .iter()
        .map(|wave| {
            let (re, im) = y
                .iter()
                .zip(wave)
                .fold((0.0, 0.0), |(re, im), (v, (c, s))| (re + v * c, im + v * s));
            2.0 / y.len() as f64 * (re * re + im * im)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal, StudentT};

    /// A wave of amplitude A gives P = n A^2 / 2 at its own frequency.
    #[test]
    fn the_power_of_a_wave_is_known() {
        let f = 9;
        let y: Vec<f64> = (0..WINDOW)
            .map(|j| {
                0.7 * (std::f64::consts::TAU * f as f64 * j as f64 / WINDOW as f64 + 0.3).sin()
            })
            .collect();
        let powers = periodogram(&y, &waves());
        let own = powers[(f - SLOWEST) * BETWEEN];
        assert!((own - 0.5 * WINDOW as f64 * 0.49).abs() < 1e-9, "{own}");
        assert!(powers.iter().all(|p| *p <= own + 1e-9));
    }

    /// Logarithm of the loudest stretch's tail probability and its run: eight runs of 600 samples of normal noise or of Student's t with four degrees
    /// of freedom, with a sawtooth of `height` in 70 samples of the third run whose harmonics are alike, as behind a whitener.
    fn loudest_of(height: f64, seed: u64) -> (f64, usize) {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        let heavy = StudentT::new(4.0).expect("a distribution");
        let mut y = DVector::from_fn(8 * 600, |_, _| match seed % 2 {
            0 => StandardNormal.sample(&mut generator),
            _ => (heavy.sample(&mut generator) / 2.0_f64.sqrt()).clamp(-5.0, 5.0),
        });
        for j in 0..70 {
            let turn = std::f64::consts::TAU * 0.09 * f64::from(j);
            let waves = (1..=5).map(|h| (f64::from(h) * turn).cos());
            y[2 * 600 + 213 + j as usize] += height * waves.sum::<f64>();
        }
        let runs: Vec<Range<usize>> = (0..8).map(|k| 600 * k..600 * (k + 1)).collect();
        let stretches = stretches(&y, &runs);
        let found = loudest(&stretches).expect("there are stretches");
        (found.log_p, found.stretch.run)
    }

    /// A sawtooth none of whose harmonics stands out is found where it is, and noise is none, of heavy tails neither.
    #[test]
    fn a_sawtooth_is_found_by_its_harmonics() {
        const NAMED: f64 = 0.001;
        let there = |seed: &u64| {
            let (log_p, run) = loudest_of(0.85, *seed);
            log_p < NAMED.ln() && run == 2
        };
        let seen = (0..40).filter(there).count();
        assert!(seen >= 36, "{seen} of 40");
        let healthy = (0..40).map(|seed| loudest_of(0.0, seed).0);
        let loudest = healthy.fold(0.0, f64::min);
        assert!(loudest > NAMED.ln(), "{loudest}");
    }
}

//! A sawtooth that one run keeps for a while: stick-slip.
//!
//! Its h-th harmonic has 1 / h^2 of the power, and roughness that falls as steeply leaves them all alike in the whitened residual. So
//!
//! ```text
//! S(f) = P(f) + P(2f) + ... + P(Hf),   H = 2 ... 5,                                                     (D14)
//! ```
//!
//! with P of (D7), a chi-squared with 2H degrees of freedom in healthy stretches, shows what no single line does.

use nalgebra::DVector;

use crate::general::Lack;
use crate::rhythm::{SLOWEST, Stretch, stretches};
use crate::samples::Samples;
use crate::tail::log_chi2_tail;

/// Frequencies in one turn a stretch: of a sawtooth between two of them the last harmonic loses less than a third of its power.
const BETWEEN: usize = 8;
/// As many of them count as asked on their own.
const APART: usize = 2;
/// Harmonics that are summed, at most.
const HARMONICS: usize = 5;

/// The strongest sawtooth in a residual of unit variance.
pub(crate) fn sawtooth(y: &DVector<f64>, samples: &Samples, names: &[String]) -> Lack {
    let stretches = stretches(y, &samples.runs, &samples.sliding, BETWEEN);
    loudest(&stretches).map_or_else(Lack::nothing, |found| Lack {
        log_p: found.log_p.min(0.0),
        place: Some(found.stretch.place(samples, names)),
        excess: found.excess.max(0.0),
    })
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
    let combs = (2..=HARMONICS).filter_map(|harmonics| {
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

/// The largest S(f) of a periodogram; 0 where it has no such frequency.
fn strongest_comb(powers: &[f64], harmonics: usize) -> f64 {
    const FIRST: usize = SLOWEST * BETWEEN;
    let combs = (FIRST..).take_while(|f| harmonics * f < FIRST + powers.len());
    combs
        .map(|f| (1..=harmonics).map(|h| powers[h * f - FIRST]).sum())
        .fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ops::Range;

    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal, StudentT};

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
        let sliding: Vec<f64> = (0..y.len()).map(|i| i as f64).collect();
        let stretches = stretches(&y, &runs, &sliding, BETWEEN);
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

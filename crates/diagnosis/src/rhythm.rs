//! A rhythm that one run keeps for a while, or that comes wherever runs go as fast: stick-slip, chatter, a resonance, something that turns.
//!
//! The whitened residual of a healthy rig has the same power at every frequency, so the periodogram of a stretch,
//!
//! ```text
//! P(f) = (2 / n) |sum_j y_j exp(-2 pi i f j)|^2                                                        (D7)
//! ```
//!
//! is a chi-squared with two degrees of freedom. What whitening leaves uneven over the frequencies, and over the wavelengths on the surface (roughness
//! that is smoother than any covariance known here), is taken from the other stretches of the campaign, at least the healthy rig's own.

use std::collections::{BTreeMap, BTreeSet};
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
pub(crate) const SLOWEST: usize = 3;
/// Frequencies between two that are independent: a rhythm between them would lose a third of its power.
const BETWEEN: usize = 2;
/// Median of a chi-squared with two degrees of freedom, 2 ln 2.
const MEDIAN: f64 = 2.0 * std::f64::consts::LN_2;

/// One stretch of a run with its periodogram over that of the campaign's other stretches.
pub(crate) struct Stretch {
    pub(crate) run: usize,
    start: usize,
    /// Place in the run, in half stretches.
    slot: usize,
    /// Distance slid in it.
    slid: f64,
    pub(crate) powers: Vec<f64>,
}

impl Stretch {
    pub(crate) fn place(&self, samples: &Samples, names: &[String]) -> Place {
        let last = self.start + WINDOW - 1;
        in_run(samples, names, self.run, self.start, last)
    }
}

/// The strongest rhythm in a residual of unit variance: of one run, of all runs at the same time together (a rhythm that comes back
/// in every other run is weak in each of them), or of all stretches of like speed. The searches pay for one another by Bonferroni's bound.
pub(crate) fn rhythm(y: &DVector<f64>, samples: &Samples, names: &[String]) -> Lack {
    let stretches = stretches(y, &samples.runs, &samples.sliding, BETWEEN);
    if stretches.len() < 4 {
        return Lack::nothing();
    }
    let searches = [
        alone(&stretches, samples, names),
        together(&stretches, samples, names),
        at_one_speed(&stretches, samples, names),
    ];
    let price = (searches.len() as f64).ln();
    let mut best = (searches.into_iter())
        .min_by(|a, b| a.log_p.total_cmp(&b.log_p))
        .unwrap_or_else(Lack::nothing);
    best.log_p = (best.log_p + price).min(0.0);
    best
}

/// All stretches with their periodograms, at so many frequencies in one turn a stretch. `sliding`: distance slid at each sample.
pub(crate) fn stretches(
    y: &DVector<f64>,
    runs: &[Range<usize>],
    sliding: &[f64],
    between: usize,
) -> Vec<Stretch> {
    let waves = waves(between);
    let mut out = Vec::new();
    for (run, range) in runs.iter().enumerate() {
        let last = range.end.saturating_sub(WINDOW - 1);
        for (slot, start) in (range.start..last).step_by(WINDOW / 2).enumerate() {
            let powers = periodogram(&y.as_slice()[start..start + WINDOW], &waves);
            out.push(Stretch {
                run,
                start,
                slot,
                slid: sliding[start + WINDOW - 1] - sliding[start],
                powers,
            });
        }
    }
    let of_wavelengths = background_of_wavelengths(&out, between);
    for f in 0..waves.len() {
        let own = out.iter().map(|s| s.powers[f]).collect();
        let background = background(own);
        for (s, of_wavelength) in out.iter_mut().zip(&of_wavelengths) {
            s.powers[f] /= background.max(of_wavelength[f]);
        }
    }
    out
}

/// What whitening leaves, by the median: at least what it leaves of a healthy rig.
fn background(mut powers: Vec<f64>) -> f64 {
    powers.sort_by(f64::total_cmp);
    let median = powers.get(powers.len() / 2);
    median.map_or(1.0, |m| (m / MEDIAN).max(1.0))
}

/// For each stretch and frequency the background of its wavelength, the distance slid over the turns, among all that are as long to a fifth.
fn background_of_wavelengths(stretches: &[Stretch], between: usize) -> Vec<Vec<f64>> {
    const FIFTH: f64 = 0.2;
    /// Of fewer stretches the median may be one stretch's rhythm.
    const FEWEST: usize = 8;
    let class = |stretch: &Stretch, f: usize| {
        let turns = (SLOWEST * between + f) as f64 / between as f64;
        (stretch.slid > 0.0).then(|| ((stretch.slid / turns).ln() / FIFTH).floor() as i64)
    };
    let mut classes: BTreeMap<i64, (Vec<f64>, BTreeSet<usize>)> = BTreeMap::new();
    for (k, stretch) in stretches.iter().enumerate() {
        for (f, power) in stretch.powers.iter().enumerate() {
            if let Some(class) = class(stretch, f) {
                let (powers, from) = classes.entry(class).or_default();
                powers.push(*power);
                from.insert(k);
            }
        }
    }
    let of_class: BTreeMap<i64, f64> = classes
        .into_iter()
        .filter(|(_, (_, from))| from.len() >= FEWEST)
        .map(|(class, (powers, _))| (class, background(powers)))
        .collect();
    let of = |stretch: &Stretch, f: usize| {
        let known = class(stretch, f).and_then(|class| of_class.get(&class).copied());
        known.unwrap_or(1.0)
    };
    let each = stretches.iter();
    each.map(|s| (0..s.powers.len()).map(|f| of(s, f)).collect())
        .collect()
}

fn alone(stretches: &[Stretch], samples: &Samples, names: &[String]) -> Lack {
    let strongest = |s: &Stretch| s.powers.iter().copied().fold(0.0, f64::max);
    let Some(best) = stretches
        .iter()
        .max_by(|a, b| strongest(a).total_cmp(&strongest(b)))
    else {
        return Lack::nothing();
    };
    let power = strongest(best);
    let asked = (stretches.len() * best.powers.len()) as f64;
    Lack {
        log_p: (asked.ln() - 0.5 * power).min(0.0),
        place: Some(best.place(samples, names)),
        excess: (power - 2.0).max(0.0),
    }
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
        ..first.place(samples, names)
    });
    Lack {
        log_p: (log_p + ((slots * frequencies) as f64).ln()).min(0.0),
        place,
        excess: excess.max(0.0),
    }
}

/// Stretches of like speed in which a rhythm of one frequency is loud.
struct Band {
    log_p: f64,
    excess: f64,
    /// Least and largest speed.
    speeds: (f64, f64),
}

/// A rhythm of one frequency wherever runs go about as fast, with any phase in each: a resonance that one speed excites is weak in every run.
fn at_one_speed(stretches: &[Stretch], samples: &Samples, names: &[String]) -> Lack {
    let speed = |s: &Stretch| {
        let last = s.start + WINDOW - 1;
        s.slid / (samples.time[last] - samples.time[s.start]).max(f64::MIN_POSITIVE)
    };
    let speeds: Vec<f64> = stretches.iter().map(speed).collect();
    let Some(found) = loudest_band(stretches, &speeds) else {
        return Lack::nothing();
    };
    let (from, to) = found.speeds;
    let within = stretches.iter().zip(&speeds);
    let runs: BTreeSet<usize> = (within.filter(|(_, v)| (from..=to).contains(*v)))
        .map(|(s, _)| s.run)
        .collect();
    Lack {
        log_p: found.log_p,
        place: Some(Place {
            axis: "speed".into(),
            from,
            to,
            unit: "m/s".into(),
            runs: runs.into_iter().map(|run| names[run].clone()).collect(),
        }),
        excess: found.excess,
    }
}

/// The least probable sum of powers at one frequency over neighbours in speed, all bands and frequencies paid for.
fn loudest_band(stretches: &[Stretch], speeds: &[f64]) -> Option<Band> {
    /// Whitening is not perfect everywhere: so much more power than elsewhere is let pass.
    const UNEVEN: f64 = 1.25;
    let frequencies = stretches.first()?.powers.len();
    let bands = bands(stretches, speeds);
    let price = ((bands.len() * frequencies).max(1) as f64).ln();
    let loudness = |members: &[usize], frequency: usize| {
        let powers = members.iter().map(|&k| stretches[k].powers[frequency]);
        let (sum, freedom) = (powers.sum::<f64>(), 2 * members.len());
        Band {
            log_p: log_chi2_tail(sum / UNEVEN, freedom),
            excess: (sum - freedom as f64).max(0.0),
            speeds: (speeds[members[0]], speeds[members[members.len() - 1]]),
        }
    };
    let each = (bands.iter()).flat_map(|members| (0..frequencies).map(move |f| (members, f)));
    let bands = each.map(|(members, frequency)| loudness(members, frequency));
    let best = bands.min_by(|a, b| a.log_p.total_cmp(&b.log_p))?;
    Some(Band {
        log_p: (best.log_p + price).min(0.0),
        ..best
    })
}

/// Stretches that are neighbours in speed, from the slowest of each band to the fastest. Neighbours in a run overlap by half: every other one
/// is independent.
fn bands(stretches: &[Stretch], speeds: &[f64]) -> Vec<Vec<usize>> {
    /// Stretches of a band at least, and how much larger each next one is.
    const FEWEST: usize = 4;
    const LARGER: f64 = 1.5;
    /// Share of all stretches that a band holds at most: the others say what whitening leaves.
    const MOST: f64 = 0.34;
    let of_parity = |parity: usize| {
        let mut order: Vec<usize> = (0..stretches.len())
            .filter(|&k| stretches[k].slot % 2 == parity && speeds[k] > 0.0)
            .collect();
        order.sort_by(|&a, &b| speeds[a].total_cmp(&speeds[b]));
        let most = (MOST * order.len() as f64) as usize;
        let larger = |size: &usize| Some((*size as f64 * LARGER) as usize);
        let sizes = std::iter::successors(Some(FEWEST), larger);
        sizes
            .take_while(|size| *size <= most)
            .flat_map(|size| order.windows(size).step_by((size / 3).max(1)))
            .map(<[usize]>::to_vec)
            .collect::<Vec<_>>()
    };
    (0..2).flat_map(of_parity).collect()
}

/// cos and sin of 2 pi f j over one stretch, for each frequency that is asked.
fn waves(between: usize) -> Vec<Vec<(f64, f64)>> {
    (SLOWEST * between..between * WINDOW / 2)
        .map(|f| {
            let step = std::f64::consts::TAU * f as f64 / (between * WINDOW) as f64;
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
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    const RUN: usize = 600;

    /// The loudest band of twelve runs that speed up evenly from rest, every second one half as fast, and its least and largest speed. In the speeds from
    /// 0.4 to 0.5 a line of this amplitude is added to noise of unit variance, with a phase of its own in each run.
    fn loudest_of(amplitude: f64, seed: u64) -> (f64, f64, f64) {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        let runs: Vec<Range<usize>> = (0..12).map(|k| RUN * k..RUN * (k + 1)).collect();
        let (mut y, mut sliding) = (DVector::zeros(12 * RUN), Vec::new());
        for k in 0..12 {
            let fastest = if k % 2 == 0 { 1.0 } else { 0.5 };
            let (phase, mut slid) = (generator.random::<f64>(), 0.0);
            for j in 0..RUN {
                let speed = fastest * (j + 1) as f64 / RUN as f64;
                slid += speed;
                sliding.push(slid);
                let noise: f64 = StandardNormal.sample(&mut generator);
                let turns = 0.23 * j as f64 + phase;
                let line = (std::f64::consts::TAU * turns).sin();
                let there = (0.4..0.5).contains(&speed);
                y[k * RUN + j] = noise + if there { amplitude * line } else { 0.0 };
            }
        }
        let stretches = stretches(&y, &runs, &sliding, BETWEEN);
        let speed = |s: &Stretch| s.slid / (WINDOW - 1) as f64;
        let speeds: Vec<f64> = stretches.iter().map(speed).collect();
        let found = loudest_band(&stretches, &speeds).expect("bands");
        (found.log_p, found.speeds.0, found.speeds.1)
    }

    /// A line that no single run shows is found where runs are as fast, and noise has none.
    #[test]
    fn a_resonance_at_one_speed_is_found_in_all_runs_together() {
        const NAMED: f64 = 0.001;
        let there = |seed: &u64| {
            let (log_p, from, to) = loudest_of(0.7, *seed);
            log_p < NAMED.ln() && from < 0.5 && to > 0.4
        };
        let seen = (0..20).filter(there).count();
        assert!(seen >= 18, "{seen} of 20");
        let healthy = (100..140).map(|seed| loudest_of(0.0, seed).0);
        let loudest = healthy.fold(0.0, f64::min);
        assert!(loudest > NAMED.ln(), "{loudest}");
    }

    /// A wave of amplitude A gives P = n A^2 / 2 at its own frequency.
    #[test]
    fn the_power_of_a_wave_is_known() {
        let f = 9;
        let y: Vec<f64> = (0..WINDOW)
            .map(|j| {
                0.7 * (std::f64::consts::TAU * f as f64 * j as f64 / WINDOW as f64 + 0.3).sin()
            })
            .collect();
        let powers = periodogram(&y, &waves(BETWEEN));
        let own = powers[(f - SLOWEST) * BETWEEN];
        assert!((own - 0.5 * WINDOW as f64 * 0.49).abs() < 1e-9, "{own}");
        assert!(powers.iter().all(|p| *p <= own + 1e-9));
    }
}

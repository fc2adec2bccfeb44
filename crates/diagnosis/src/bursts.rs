//! Short bursts of unrest in single runs, such as stick-slip that comes and goes: a stretch that is louder than the same stretch
//! of other runs, one that beats in a rhythm or as a sawtooth does, blows that come in a crowd, a single one, or spikes here and there. The searches pay for one
//! another by Bonferroni's bound.

use std::ops::Range;

use nalgebra::DVector;
use statrs::function::gamma::ln_gamma;

use crate::answer::Place;
use crate::general::Lack;
use crate::rhythm::rhythm;
use crate::samples::Samples;
use crate::sawtooth::sawtooth;
use crate::spikes::spikes;
use crate::tail::log_chi2_tail;

/// Samples of a stretch; neighbours overlap by half.
const WINDOW: usize = 40;
/// Beyond so many standard deviations a sample is a blow and says nothing more about unrest or a rhythm.
const CLIP: f64 = 3.0;
/// The same of a sawtooth, whose jumps are blows; of the waves in a single blow none is strong.
const CLIP_OF_JUMPS: f64 = 5.0;

/// The strongest burst in the whitened residual, sample by sample. Of a channel so coarse that its record is a staircase the residual is what lies `beyond` the
/// rounding: nothing most of the time, and in stretches whatever roughness carries a level over its edge. Unrest and rhythm cannot be
/// told from that; a single blow can.
pub(crate) fn bursts(y: &DVector<f64>, samples: &Samples, names: &[String], beyond: bool) -> Lack {
    let mean_square = y.norm_squared() / y.len().max(1) as f64;
    let y = y.unscale(mean_square.sqrt().max(f64::MIN_POSITIVE));
    let clipped = |at: f64| y.map(|v| v.clamp(-at, at));
    let mut searches = vec![blow(&y, samples, names)];
    if !beyond {
        let calm = clipped(CLIP);
        searches.push(unrest(&calm, samples, names));
        searches.push(rhythm(&calm, samples, names));
        searches.push(sawtooth(&clipped(CLIP_OF_JUMPS), samples, names));
        let level = levelled(y.as_slice(), &samples.runs);
        searches.push(crowd(&level, samples, names));
        searches.push(spikes(&level, samples, names));
    }
    let price = (searches.len() as f64).ln();
    let mut best = searches
        .into_iter()
        .min_by(|a, b| a.log_p.total_cmp(&b.log_p))
        .unwrap_or_else(Lack::nothing);
    best.log_p = (best.log_p + price).min(0.0);
    best
}

/// A stretch of one run, by its first and last sample.
pub(crate) fn in_run(
    samples: &Samples,
    names: &[String],
    run: usize,
    first: usize,
    last: usize,
) -> Place {
    Place {
        axis: "time".into(),
        from: samples.time[first],
        to: samples.time[last],
        unit: "s".into(),
        runs: vec![names[run].clone()],
    }
}

/// The largest single sample beside the others' tails. Of m samples above a level u whose tail falls as x^-alpha the largest
/// exceeds r u with probability m r^-alpha; no healthy noise is taken to have heavier tails than alpha = 4, and where they are
/// lighter only a gross blow is one.
fn blow(y: &DVector<f64>, samples: &Samples, names: &[String]) -> Lack {
    const ALPHA: f64 = 4.0;
    const ABOVE: usize = 10;
    let mut order: Vec<usize> = (0..y.len()).collect();
    order.sort_by(|&a, &b| y[b].abs().total_cmp(&y[a].abs()));
    let (Some(&at), Some(&level)) = (order.first(), order.get(ABOVE)) else {
        return Lack::nothing();
    };
    let ratio = y[at].abs() / y[level].abs().max(1.0);
    let run = samples.owner[at];
    let ends = &samples.runs[run];
    let (first, last) = (at.max(ends.start + 1) - 1, (at + 1).min(ends.end - 1));
    Lack {
        log_p: ((ABOVE as f64).ln() - ALPHA * ratio.ln()).min(0.0),
        place: Some(in_run(samples, names, run, first, last)),
        excess: y[at] * y[at],
    }
}

/// A crowd of blows: a stretch in which more samples lie beyond a level than come together by chance.
fn crowd(y: &[f64], samples: &Samples, names: &[String]) -> Lack {
    let Some(found) = Crowd::thickest(y, &samples.runs) else {
        return Lack::nothing();
    };
    let within = found.first..found.first + WINDOW;
    Lack {
        log_p: found.log_p,
        place: Some(in_run(
            samples,
            names,
            found.run,
            found.first,
            within.end - 1,
        )),
        excess: within.map(|i| y[i] * y[i] - 1.0).sum::<f64>().max(0.0),
    }
}

/// A residual without its level over a window about each sample, of mean square one: the gain of a run is in the whitened residual too, and
/// no blow.
fn levelled(y: &[f64], runs: &[Range<usize>]) -> Vec<f64> {
    let mut level = Vec::with_capacity(y.len());
    for run in runs {
        let own = &y[run.clone()];
        for i in 0..own.len() {
            let about = &own[i.saturating_sub(WINDOW / 2)..(i + WINDOW / 2 + 1).min(own.len())];
            level.push(about.iter().sum::<f64>() / about.len() as f64);
        }
    }
    let left: Vec<f64> = y.iter().zip(level).map(|(y, level)| y - level).collect();
    let mean_square = left.iter().map(|v| v * v).sum::<f64>() / left.len().max(1) as f64;
    let rms = mean_square.sqrt().max(f64::MIN_POSITIVE);
    left.into_iter().map(|v| v / rms).collect()
}

/// The stretch with the least probable number of blows.
struct Crowd {
    run: usize,
    first: usize,
    /// Logarithm of the tail probability, all stretches paid for.
    log_p: f64,
}

impl Crowd {
    /// How many blows to expect is taken from the other runs, from all of their samples and from the same stretch: heavy tails make more of
    /// them, but not together.
    fn thickest(y: &[f64], runs: &[Range<usize>]) -> Option<Self> {
        /// Standard deviations of a blow.
        const BEYOND: f64 = 2.5;
        /// Whitening is not perfect everywhere: blows may be so many times more frequent at some places of a run than at others.
        const UNEVEN: f64 = 2.0;
        let blows = |stretch: Range<usize>| y[stretch].iter().filter(|v| v.abs() > BEYOND).count();
        let all = blows(0..y.len());
        let mut best: Option<Self> = None;
        let mut looked = 0_usize;
        for (k, run) in runs.iter().enumerate() {
            let elsewhere = (y.len() - run.len()).max(1) as f64;
            let general = (all - blows(run.clone()) + 1) as f64 / elsewhere;
            let firsts = (run.start..run.end).step_by(WINDOW / 2);
            for first in firsts.take_while(|first| first + WINDOW <= run.end) {
                looked += 1;
                let same = same_stretch(runs, k, first - run.start);
                let there: usize = same.iter().map(|other| blows(other.clone())).sum();
                let local = there as f64 / (WINDOW * same.len().max(1)) as f64;
                let mean = WINDOW as f64 * (UNEVEN * general).max(local).min(1.0);
                let log_p = log_poisson_tail(mean, blows(first..first + WINDOW));
                if best.as_ref().is_none_or(|b| log_p < b.log_p) {
                    best = Some(Self {
                        run: k,
                        first,
                        log_p,
                    });
                }
            }
        }
        let price = (looked.max(1) as f64).ln();
        best.map(|b| Self {
            log_p: (b.log_p + price).min(0.0),
            ..b
        })
    }
}

/// The same stretch of all other runs that are long enough, by samples from their start.
fn same_stretch(runs: &[Range<usize>], run: usize, from: usize) -> Vec<Range<usize>> {
    let others = runs.iter().enumerate().filter(|(k, _)| *k != run);
    let stretch = others.map(|(_, r)| (r.start + from..r.start + from + WINDOW, r.end));
    let whole = stretch.filter(|(r, end)| r.end <= *end);
    whole.map(|(r, _)| r).collect()
}

/// ln P(X >= count) of a Poisson number X, or a little above: the sum from its first term on is at most that of a geometric series.
pub(crate) fn log_poisson_tail(mean: f64, count: usize) -> f64 {
    let n = count as f64;
    if n <= mean {
        return 0.0;
    }
    let first = n * mean.max(f64::MIN_POSITIVE).ln() - mean - ln_gamma(n + 1.0);
    (first - (1.0 - mean / (n + 1.0)).ln()).min(0.0)
}

/// Unrest: stretches of whitened residual whose mean square is above what the same stretch shows in the calmest quarter
/// of the runs (a burst may come back in every other run), and above what the campaign's own tails allow.
fn unrest(y: &DVector<f64>, samples: &Samples, names: &[String]) -> Lack {
    // Run, first sample, place in the run, mean square.
    let mut windows: Vec<(usize, usize, usize, f64)> = Vec::new();
    for (k, run) in samples.runs.iter().enumerate() {
        let mut start = run.start;
        while start + WINDOW <= run.end {
            let power = y.as_slice()[start..start + WINDOW]
                .iter()
                .map(|x| x * x)
                .sum::<f64>();
            windows.push((
                k,
                start,
                (start - run.start) / (WINDOW / 2),
                power / WINDOW as f64,
            ));
            start += WINDOW / 2;
        }
    }
    let nothing = Lack::nothing();
    if windows.len() < 20 {
        return nothing;
    }
    // The same stretch in all runs: its lower quartile, never below the campaign's.
    let calm = |of: &mut Vec<f64>| -> f64 {
        of.sort_by(f64::total_cmp);
        of[of.len() / 4]
    };
    let mut all: Vec<f64> = windows.iter().map(|w| w.3).collect();
    let typical = calm(&mut all);
    let ratios: Vec<f64> = windows
        .iter()
        .map(|w| {
            let mut same: Vec<f64> = windows.iter().filter(|o| o.2 == w.2).map(|o| o.3).collect();
            let own = if same.len() >= 4 {
                calm(&mut same)
            } else {
                typical
            };
            w.3 / own.max(typical)
        })
        .collect();
    // Spread of the logarithms, robust (quartiles): heavy tails of the noise itself widen it.
    let mut logs: Vec<f64> = ratios.iter().map(|r| r.max(1e-12).ln()).collect();
    logs.sort_by(f64::total_cmp);
    let quartile = |q: f64| logs[((logs.len() - 1) as f64 * q) as usize];
    let spread = ((quartile(0.75) - quartile(0.25)) / 1.349).max((2.0 / WINDOW as f64).sqrt());
    let best = (0..windows.len())
        .max_by(|&a, &b| ratios[a].total_cmp(&ratios[b]))
        .unwrap_or(0);
    // Logarithms of mean squares are nearly normal; their upper tail is a little heavier than that.
    let z = (ratios[best].max(1e-12).ln() - quartile(0.5)) / (1.5 * spread);
    let log_p = log_chi2_tail(z.max(0.0).powi(2), 1) - 2.0_f64.ln() + (windows.len() as f64).ln();
    let (k, start, _, power) = windows[best];
    let end = start + WINDOW - 1;
    Lack {
        log_p: log_p.min(0.0),
        place: Some(in_run(samples, names, k, start, end)),
        excess: ((power - 1.0) * WINDOW as f64).max(0.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal, StudentT};

    const RUN: usize = 600;

    fn runs() -> Vec<Range<usize>> {
        (0..8).map(|k| k * RUN..(k + 1) * RUN).collect()
    }

    /// Normal noise or Student's t of four degrees of freedom with variance one, one run of it raised as by its gain.
    fn noise(heavy: bool, generator: &mut ChaCha8Rng) -> Vec<f64> {
        let t = StudentT::new(4.0).unwrap();
        (0..8 * RUN)
            .map(|i| {
                let level = if i < RUN { 2.0 } else { 0.0 };
                level
                    + match heavy {
                        true => t.sample(generator) / 2.0_f64.sqrt(),
                        false => StandardNormal.sample(generator),
                    }
            })
            .collect()
    }

    /// The tail of a Poisson number of mean 2: P(X >= 6) = 0.016564, P(X >= 12) = 1.363e-6, and below the mean nothing is said.
    #[test]
    fn the_tail_of_a_poisson_number_is_known_from_above() {
        for (count, exact) in [(6, 0.016_564_f64), (12, 1.363e-6)] {
            let ours = log_poisson_tail(2.0, count).exp();
            assert!(ours >= exact && ours < 1.2 * exact, "{ours} {exact}");
        }
        assert_eq!(log_poisson_tail(2.0, 1), 0.0);
    }

    /// Neither heavy tails nor the gain of a run are a crowd; a dozen blows within forty samples of one run are, and it is found where it is.
    #[test]
    fn blows_that_come_together_are_told_from_heavy_tails() {
        let mut generator = ChaCha8Rng::seed_from_u64(5);
        let thickest = |y: &[f64]| Crowd::thickest(&levelled(y, &runs()), &runs()).unwrap();
        const NAMED: f64 = 0.004;
        let (mut alone, mut seen) = (Vec::new(), 0);
        for trial in 0..40 {
            let mut y = noise(trial % 2 == 0, &mut generator);
            let healthy = thickest(&y).log_p;
            alone.push(healthy);
            let first = 3 * RUN + 245;
            for v in &mut y[first..first + 36] {
                if generator.random::<f64>() < 0.4 {
                    *v += if generator.random::<bool>() {
                        4.5
                    } else {
                        -4.5
                    };
                }
            }
            let found = thickest(&y);
            let there = found.run == 3 && found.first.abs_diff(first) <= WINDOW;
            seen += usize::from(there && found.log_p < NAMED.ln());
        }
        assert!(seen >= 36, "{seen} of 40");
        let loudest = alone.iter().copied().fold(0.0, f64::min);
        assert!(loudest > NAMED.ln(), "{alone:?}");
    }
}

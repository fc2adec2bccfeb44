//! Causes that are looked for directly in the numbers: a clipped channel and a coarse one.
//!
//! A clipped channel repeats its extreme value: with white noise alone two samples agree to the last digit only by
//! chance, so that many equal extremes in a row are a flat top. A coarse channel has few distinct values: all
//! differences are multiples of one step that is large against the noise.

use campaign::Campaign;

/// Equal extreme samples in a row that make a flat top.
const FLAT: usize = 6;

/// A value that was read off the numbers, and how far the truth may be from it: they were written with so many digits.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Read {
    pub(crate) value: f64,
    /// Half of the 95 % interval.
    pub(crate) half: f64,
}

/// What was found in the numbers themselves.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Integrity {
    /// Level at which the force clips, N.
    pub(crate) saturation: Option<Read>,
    /// Step of the force channel, N.
    pub(crate) resolution: Option<Read>,
}

/// Looks for a flat top and for a coarse step; `noise` is the white noise of the force channel, N.
pub(crate) fn inspect(campaign: &Campaign, noise: f64) -> Integrity {
    let step = coarse_step(forces(campaign));
    let top = flat_top(campaign, step.map(|s| s.value));
    Integrity {
        saturation: top.map(|value| Read {
            value,
            half: 0.5 * last_digit(&forces(campaign), value),
        }),
        resolution: step.filter(|s| s.value > NAMED * noise),
    }
}

/// Forces of all runs, N.
fn forces(campaign: &Campaign) -> Vec<f64> {
    let runs = campaign.runs.iter();
    runs.flat_map(|r| r.force_n.iter().copied()).collect()
}

/// The last digit in which forces near a level are written, N: 10^-d with the fewest decimals d that leave nothing over.
fn last_digit(forces: &[f64], level: f64) -> f64 {
    const MOST_DECIMALS: i32 = 15;
    let near: Vec<f64> = forces
        .iter()
        .map(|f| f.abs())
        .filter(|f| *f > 0.5 * level)
        .collect();
    let written_in = |digit: f64| {
        near.iter().all(|f| {
            let count = f / digit;
            (count - count.round()).abs() <= 1e-3
        })
    };
    (0..=MOST_DECIMALS)
        .map(|decimals| 10.0_f64.powi(-decimals))
        .find(|digit| written_in(*digit))
        .unwrap_or(f64::EPSILON * level)
}

/// A step of the force channel beyond this share of its white noise is named. It adds step^2/12 to the noise's variance, 5 % from here on:
/// over the 8,000 samples of a campaign four to five times what a test sees that knows what is rounded. Records are mostly written in
/// steps well below it.
const NAMED: f64 = 0.8;

/// Whether a step of the force channel is more than its white noise hides (both N), so that the record is a staircase.
pub(crate) fn is_staircase(step: f64, noise: f64) -> bool {
    step > 1.5 * noise
}

/// The largest |force| where at least two stretches or one long stretch of samples sit on it exactly.
fn flat_top(campaign: &Campaign, step: Option<f64>) -> Option<f64> {
    let top = campaign
        .runs
        .iter()
        .flat_map(|r| r.force_n.iter())
        .fold(0.0_f64, |m, f| m.max(f.abs()));
    if !(top > 0.0) {
        return None;
    }
    let tolerance = 1e-9 * top;
    let (mut on_top, mut longest, mut total) = (0, 0, 0);
    for run in &campaign.runs {
        on_top = 0;
        for f in &run.force_n {
            if (f.abs() - top).abs() <= tolerance {
                on_top += 1;
                total += 1;
                longest = longest.max(on_top);
            } else {
                on_top = 0;
            }
        }
    }
    let _ = on_top;
    // On a coarse channel neighbours agree by rounding: then the top must hold far more samples than its neighbour.
    let crowded = step.is_none_or(|s| {
        let below = campaign
            .runs
            .iter()
            .flat_map(|r| r.force_n.iter())
            .filter(|f| (f.abs() - (top - s)).abs() <= 0.25 * s)
            .count();
        total > 4 * (below + FLAT)
    });
    (longest >= FLAT && crowded).then_some(top)
}

/// Samples on a flat top and those that it picks out: where friction comes near the level, only what the noise took below it is
/// left. How far that reaches is read off the stretches between clipped samples.
pub(crate) fn beside_flat_top(campaign: &Campaign, level: f64) -> Vec<bool> {
    let runs = campaign.runs.iter();
    let tops: Vec<Top> = runs.map(|run| Top::of(&run.force_n, level)).collect();
    let mut dips: Vec<f64> = tops.iter().flat_map(Top::dips).collect();
    dips.sort_by(f64::total_cmp);
    let deepest = match dips.len() {
        0 => 0.0,
        n => dips[(n as f64 * DEEP) as usize],
    };
    tops.iter().flat_map(|top| top.hidden(deepest)).collect()
}

/// Samples to each side in which a flat top is looked for.
const BESIDE: usize = 10;
/// Share of the dips between clipped samples that are no deeper than what counts as reach of the noise.
const DEEP: f64 = 0.95;

/// One run below a level.
struct Top {
    level: f64,
    /// |force|, N.
    sizes: Vec<f64>,
    clipped: Vec<bool>,
}

impl Top {
    fn of(forces: &[f64], level: f64) -> Self {
        let sizes: Vec<f64> = forces.iter().map(|f| f.abs()).collect();
        let clipped = sizes.iter().map(|f| *f >= level * (1.0 - 1e-9)).collect();
        Self {
            level,
            sizes,
            clipped,
        }
    }

    /// Whether clipped samples stand closely before and behind.
    fn is_between(&self, i: usize) -> bool {
        let before = &self.clipped[i.saturating_sub(BESIDE)..i];
        let behind = &self.clipped[i + 1..(i + 1 + BESIDE).min(self.clipped.len())];
        before.contains(&true) && behind.contains(&true)
    }

    /// How far samples between clipped ones lie below the level, N.
    fn dips(&self) -> impl Iterator<Item = f64> {
        let open = (0..self.sizes.len()).filter(|&i| !self.clipped[i] && self.is_between(i));
        open.map(|i| self.level - self.sizes[i])
    }

    /// Samples that are clipped, stand between such, or in whose neighbourhood the force comes within the noise's reach of the level.
    fn hidden(&self, reach: f64) -> Vec<bool> {
        let near = |i: usize| {
            let around = &self.sizes[i.saturating_sub(BESIDE / 2)..];
            let around = &around[..around.len().min(BESIDE + 1)];
            let highest = around.iter().copied().fold(0.0, f64::max);
            reach > 0.0 && highest > self.level - reach
        };
        (0..self.sizes.len())
            .map(|i| self.clipped[i] || self.is_between(i) || near(i))
            .collect()
    }
}

/// The step of which all force values are multiples, where there are few distinct values. Neighbouring values differ by small
/// counts of steps, which rounding to digits cannot hide; the step is the slope of the values over the counts so added up.
fn coarse_step(mut values: Vec<f64>) -> Option<Read> {
    let n = values.len();
    values.sort_by(f64::total_cmp);
    let top = values[0].abs().max(values[n - 1].abs());
    values.dedup_by(|a, b| (*a - *b).abs() <= 1e-9 * top);
    if values.len() < 3 || values.len() > n / 4 {
        return None;
    }
    let differences: Vec<f64> = values.windows(2).map(|w| w[1] - w[0]).collect();
    let smallest = differences.iter().copied().fold(f64::INFINITY, f64::min);
    let is_multiple = |difference: &f64| {
        let k = difference / smallest;
        (k - k.round()).abs() < 0.02 * k.max(1.0)
    };
    if !differences.iter().all(is_multiple) {
        return None;
    }
    // One step each: their mean is nearer to the step than the smallest of them.
    let single: Vec<f64> = differences
        .iter()
        .copied()
        .filter(|d| (d / smallest).round() == 1.0)
        .collect();
    let step = single.iter().sum::<f64>() / single.len() as f64;
    let mut count = 0.0;
    let counts: Vec<f64> = std::iter::once(0.0)
        .chain(differences.iter().map(|d| {
            count += (d / step).round();
            count
        }))
        .collect();
    let read = slope(&counts, &values)?;
    (read.value > 1e-6 * top).then_some(read)
}

/// Slope of y over x with twice its standard error.
fn slope(x: &[f64], y: &[f64]) -> Option<Read> {
    let n = x.len() as f64;
    let mean = |of: &[f64]| of.iter().sum::<f64>() / n;
    let (mx, my) = (mean(x), mean(y));
    let xx: f64 = x.iter().map(|x| (x - mx).powi(2)).sum();
    let xy: f64 = x.iter().zip(y).map(|(x, y)| (x - mx) * (y - my)).sum();
    if !(xx > 0.0) {
        return None;
    }
    let value = xy / xx;
    let left: f64 = x
        .iter()
        .zip(y)
        .map(|(x, y)| (y - my - value * (x - mx)).powi(2))
        .sum();
    let variance = left / (n - 2.0).max(1.0) / xx;
    let half = (2.0 * variance.sqrt()).max(f64::EPSILON * value.abs());
    Some(Read { value, half })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Multiples of a step, written with few digits: the interval holds the step, which the smallest difference misses.
    #[test]
    fn a_step_is_read_to_what_the_digits_allow() {
        let step = 0.004_724_332;
        let written = |x: f64| (x * 1e5).round() / 1e5;
        let values: Vec<f64> = (0..4000)
            .map(|i| written(step * (150.0 * (0.01 * i as f64).sin()).round()))
            .collect();
        let read = coarse_step(values.clone()).expect("few distinct values");
        assert!((read.value - step).abs() <= read.half, "{read:?}");
        assert!(read.half < 1e-4 * step, "{read:?}");
        assert_eq!(last_digit(&values, 0.7), 1e-5);
        // Without a common step there is none.
        let irregular: Vec<f64> = (0..4000).map(|i| (0.37 * i as f64).sin()).collect();
        assert!(coarse_step(irregular).is_none());
    }
}

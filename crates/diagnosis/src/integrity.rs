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
#[derive(Clone, Debug, Default)]
pub(crate) struct Integrity {
    /// Levels at which the force clips, that with the most samples first.
    pub(crate) rails: Vec<Rail>,
    /// Step of the force channel, N.
    pub(crate) resolution: Option<Read>,
}

impl Integrity {
    /// Level at which the force clips, N.
    pub(crate) fn saturation(&self) -> Option<Read> {
        self.rails.first().map(|rail| rail.level)
    }
}

/// Where a channel ends.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rail {
    /// Level, N, its sign left out.
    pub(crate) level: Read,
    side: Side,
}

/// Which forces a rail holds back.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Side {
    Positive,
    Negative,
    Both,
}

impl Side {
    /// How far a force reaches towards the rail, N.
    fn reach(self, force_n: f64) -> f64 {
        match self {
            Self::Positive => force_n,
            Self::Negative => -force_n,
            Self::Both => force_n.abs(),
        }
    }
}

/// Looks for a flat top and for a coarse step; `noise` is the white noise of the force channel, N.
pub(crate) fn inspect(campaign: &Campaign, noise: f64) -> Integrity {
    let runs: Vec<&[f64]> = campaign.runs.iter().map(|r| &r.force_n[..]).collect();
    let step = coarse_step(runs.concat());
    Integrity {
        rails: rails(&runs, step.map(|s| s.value)),
        resolution: step.filter(|s| s.value > NAMED * noise),
    }
}

/// The last digit in which forces near a level are written, N: 10^-d with the fewest decimals d that leave nothing over. Only forces
/// with as many digits before the point tell: where their number in all is fixed, smaller ones have one more behind it.
fn last_digit(forces: &[f64], level: f64) -> f64 {
    const MOST_DECIMALS: i32 = 15;
    let decade = 10.0_f64.powf(level.log10().floor());
    let near: Vec<f64> = forces
        .iter()
        .map(|f| f.abs())
        .filter(|f| *f > 0.5 * level && *f >= decade)
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

/// A rail lower than this share of the largest |force| is none: readings at rest agree by their last digit.
const LOWEST_RAIL: f64 = 0.2;

/// The levels on which the force is clipped: one for both signs where they are equal, or where the other sign does not reach it.
fn rails(runs: &[&[f64]], step: Option<f64>) -> Vec<Rail> {
    let sides = [Side::Positive, Side::Negative];
    let mut flat: Vec<(Side, Flat)> = sides
        .into_iter()
        .filter_map(|side| Some((side, Flat::of(runs, side, step)?)))
        .collect();
    let all = runs.concat();
    let farthest = |side: Side| all.iter().map(|&f| side.reach(f)).fold(0.0, f64::max);
    let most = farthest(Side::Both);
    flat.retain(|(_, flat)| flat.level >= LOWEST_RAIL * most);
    flat.sort_by_key(|(_, flat)| std::cmp::Reverse(flat.samples));
    let level = |k: usize| flat.get(k).map(|(_, flat)| flat.level);
    let is_one = match (level(0), level(1)) {
        (Some(a), Some(b)) => (a - b).abs() <= SAME_LEVEL * a,
        (Some(a), None) => most <= a * (1.0 + SAME_LEVEL),
        _ => false,
    };
    if is_one {
        flat.truncate(1);
    }
    let rail = |(side, Flat { level, .. }): (Side, Flat)| Rail {
        level: Read {
            value: level,
            half: 0.5 * last_digit(&all, level),
        },
        side: if is_one { Side::Both } else { side },
    };
    flat.into_iter().map(rail).collect()
}

/// Relative difference of levels that are one.
const SAME_LEVEL: f64 = 1e-9;

/// An extreme of one side on which stretches of samples sit exactly.
struct Flat {
    level: f64,
    samples: usize,
}

impl Flat {
    fn of(runs: &[&[f64]], side: Side, step: Option<f64>) -> Option<Self> {
        let reaches = |run: &&[f64]| run.iter().map(|&f| side.reach(f)).collect();
        let runs: Vec<Vec<f64>> = runs.iter().map(reaches).collect();
        let level = runs.iter().flatten().copied().fold(0.0, f64::max);
        if !(level > 0.0) {
            return None;
        }
        let is_on = |f: &f64| (f - level).abs() <= SAME_LEVEL * level;
        let longest = runs
            .iter()
            .flat_map(|run| run.split(|f| !is_on(f)).map(<[f64]>::len))
            .max()?;
        let samples = runs.iter().flatten().filter(|f| is_on(f)).count();
        // On a coarse channel neighbours agree by rounding: then the top must hold far more samples than its neighbour.
        let crowded = step.is_none_or(|step| {
            let near = |f: &&f64| (**f - (level - step)).abs() <= 0.25 * step;
            let below = runs.iter().flatten().filter(near).count();
            samples > 4 * (below + FLAT)
        });
        (longest >= FLAT && crowded).then_some(Self { level, samples })
    }
}

/// Samples on a flat top and those that it picks out: where friction comes near the level, only what the noise took below it is
/// left. How far that reaches is read off the stretches between clipped samples.
pub(crate) fn beside_flat_top(campaign: &Campaign, rail: &Rail) -> Vec<bool> {
    let runs = campaign.runs.iter();
    let tops: Vec<Top> = runs.map(|run| Top::of(&run.force_n, rail)).collect();
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
    /// How far the force reaches towards the level, N.
    sizes: Vec<f64>,
    clipped: Vec<bool>,
}

impl Top {
    fn of(forces: &[f64], rail: &Rail) -> Self {
        let level = rail.level.value;
        let sizes: Vec<f64> = forces.iter().map(|&f| rail.side.reach(f)).collect();
        let clipped = sizes
            .iter()
            .map(|f| *f >= level * (1.0 - SAME_LEVEL))
            .collect();
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

    /// A channel that clips both signs, one of them with the other beyond, at two levels, or none.
    #[test]
    fn each_sign_may_end_at_its_own_rail() {
        let swing = |low: f64, high: f64| -> Vec<f64> {
            let force = |i: i32| (0.05 * f64::from(i)).sin() + 1e-3 * (1.7 * f64::from(i)).sin();
            (0..600).map(|i| force(i).clamp(-low, high)).collect()
        };
        let found = |low: f64, high: f64| -> Vec<(Side, f64)> {
            let run = swing(low, high);
            let of = |rail: Rail| (rail.side, rail.level.value);
            rails(&[&run], None).into_iter().map(of).collect()
        };
        assert_eq!(found(0.9, 0.9), [(Side::Both, 0.9)]);
        assert_eq!(found(2.0, 0.9), [(Side::Positive, 0.9)]);
        assert_eq!(found(0.8, 2.0), [(Side::Negative, 0.8)]);
        assert_eq!(
            found(0.7, 0.9),
            [(Side::Negative, 0.7), (Side::Positive, 0.9)]
        );
        assert_eq!(found(2.0, 2.0), []);
        // Where the other sign does not come so far, the rail may hold both.
        let halved = |f: f64| if f < 0.0 { 0.5 * f } else { f };
        let run: Vec<f64> = swing(2.0, 0.9).into_iter().map(halved).collect();
        assert_eq!(rails(&[&run], None)[0].side, Side::Both);
    }

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
        // Written in so many digits: below one they reach a decimal further.
        assert_eq!(
            last_digit(&[1.2346, 1.1111, 0.98765, 0.77777], 1.2346),
            1e-4
        );
        // Without a common step there is none.
        let irregular: Vec<f64> = (0..4000).map(|i| (0.37 * i as f64).sin()).collect();
        assert!(coarse_step(irregular).is_none());
    }
}

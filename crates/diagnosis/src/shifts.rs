//! Shifts of level over a stretch of a single run: an amplifier that drops out for a quarter of a second, a specimen that slips and stays.
//!
//! A factor on the friction force over samples a..b of run k adds the column c = f 1(a..b), and its score at a scatter s is
//!
//! ```text
//! z = c'u / |c|,   u = W'(I - QQ') V(s)^-1 y,   |c|^2 = c~'V(s)^-1 c~                                      (D13)
//! ```
//!
//! with W, Q, V, y and c~ as in (D1). Numerators of all stretches are differences of one sum; lengths |c| are not. So each run's stretches are ranked by their numerators beside
//! others of as many samples in the same run, and the first few are scored in full. What counts of the strongest one is what is left of it whichever of
//! its samples is given up. What noise does that is not as it is reckoned, it does in every run: the
//! largest of a run is held against the others' largest.

use std::ops::Range;

use nalgebra::DMatrix;

use crate::answer::Place;
use crate::bursts::in_run;
use crate::general::{Lack, MOST_RUNS};
use crate::ground::Ground;
use crate::samples::Samples;
use crate::stand::Stand;
use crate::tail::log_chi2_tail;

/// Samples of the shortest stretch; each further length is half as long again, up to half of a run.
const SHORTEST: usize = 4;
/// With fewer runs there are no others to hold one against.
const FEWEST_RUNS: usize = 5;
/// Samples of the longest stretch that one of them alone may be taken for.
const MOST_BY_ONE: usize = 40;
/// Stretches of a run that are scored in full.
const TAKEN: usize = 6;
/// How many times the median of the runs' largest one must be to be no part of them.
const ALONE: f64 = 2.0;
/// Of the strongest: the share from which stretches of other runs at the same time belong to it.
const ALIKE: f64 = 0.4;

/// The strongest stretch of a run beside a stand; `friction`: the force that it multiplies.
pub(crate) fn shifts(
    stand: &Stand,
    ground: &Ground,
    samples: &Samples,
    friction: &[f64],
    names: &[String],
) -> Lack {
    if !(FEWEST_RUNS..=MOST_RUNS).contains(&samples.runs.len()) || !samples.averaged.is_empty() {
        return Lack::nothing();
    }
    let within = ground.residual_within(ground.likeliest_scatter());
    let own = within.rows(0, stand.whitener.rows()).into_owned();
    let unwhitened = stand.whitener.whiten_transposed(&own);
    let sums = running_sums(unwhitened.iter().zip(friction).map(|(u, f)| u * f));
    let mut asked = 0;
    let mut largest = Vec::new();
    for run in &samples.runs {
        let stretches = ranked(&sums, run);
        asked += stretches.asked;
        let scored = scored(stand, ground, &stretches.first, friction);
        largest.extend(scored);
    }
    standing_out(&largest, asked).map_or_else(Lack::nothing, |found| {
        let price = (asked.max(1) as f64).ln();
        let white = stand.whiten_own(&stretch_and_samples(&found.stretch, friction));
        let chi2 = found.z * found.z * share_without_one(ground, &white);
        Lack {
            log_p: (log_chi2_tail(chi2, 1) + price).min(0.0),
            place: Some(place(&largest, &found, samples, names)),
            excess: (chi2 - 2.0 * price).max(0.0),
        }
    })
}

/// The friction of a stretch as a column, and one beside it for each of its samples; for none where one of so many is next to nothing.
fn stretch_and_samples(stretch: &Range<usize>, friction: &[f64]) -> DMatrix<f64> {
    let beside = match stretch.len() <= MOST_BY_ONE {
        true => stretch.len(),
        false => 0,
    };
    let mut columns = DMatrix::zeros(friction.len(), 1 + beside);
    for i in stretch.clone() {
        columns[(i, 0)] = friction[i];
    }
    for (k, i) in stretch.clone().take(beside).enumerate() {
        columns[(i, 1 + k)] = 1.0;
    }
    columns
}

/// Share of what a stretch explains (the first whitened column) that is left whichever single sample (one of the others) is given up: a shift of
/// level is in all of its samples, a blow of heavy tails in one.
fn share_without_one(ground: &Ground, white: &DMatrix<f64>) -> f64 {
    let explained = |columns: &DMatrix<f64>| {
        let direction = ground.direction(columns);
        direction.map_or(0.0, |direction| ground.explained(&direction))
    };
    let whole = explained(&white.columns(0, 1).into_owned());
    let without = (1..white.ncols()).map(|k| {
        let both = explained(&white.select_columns(&[0, k]));
        both - explained(&white.columns(k, 1).into_owned())
    });
    let least = without.fold(whole, f64::min);
    (least / whole.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0)
}

/// A stretch with its deviate.
#[derive(Clone, Debug)]
struct Scored {
    stretch: Range<usize>,
    z: f64,
}

/// s_j: the sum of the first j.
fn running_sums(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut sums = vec![0.0];
    for value in values {
        sums.push(sums[sums.len() - 1] + value);
    }
    sums
}

/// The stretches of a run that stand out of those of as many samples, and how many there were.
struct Ranked {
    first: Vec<Range<usize>>,
    asked: usize,
}

fn ranked(sums: &[f64], run: &Range<usize>) -> Ranked {
    let mut all: Vec<(f64, Range<usize>)> = Vec::new();
    let mut length = SHORTEST;
    while 2 * length <= run.len() {
        let firsts = run.start..=run.end - length;
        let stretches = firsts.map(|first| first..first + length);
        let numerator = |stretch: &Range<usize>| (sums[stretch.end] - sums[stretch.start]).abs();
        let mut sizes: Vec<f64> = stretches.clone().map(|s| numerator(&s)).collect();
        sizes.sort_by(f64::total_cmp);
        let middle = sizes[sizes.len() / 2].max(f64::MIN_POSITIVE);
        all.extend(stretches.map(|s| (numerator(&s) / middle, s)));
        length += length / 2;
    }
    let asked = all.len();
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut first: Vec<Range<usize>> = Vec::new();
    for (_, stretch) in all {
        if first.len() == TAKEN {
            break;
        }
        // One that shares most of its samples with a stronger one says nothing new.
        if !first.iter().any(|known| is_much_the_same(known, &stretch)) {
            first.push(stretch);
        }
    }
    Ranked { first, asked }
}

/// Whether two stretches share more than three quarters of the longer one.
fn is_much_the_same(a: &Range<usize>, b: &Range<usize>) -> bool {
    let shared = a.end.min(b.end).saturating_sub(a.start.max(b.start));
    4 * shared > 3 * a.len().max(b.len())
}

/// The strongest of these stretches of a run, scored in full.
fn scored(
    stand: &Stand,
    ground: &Ground,
    stretches: &[Range<usize>],
    friction: &[f64],
) -> Option<Scored> {
    let mut columns = DMatrix::zeros(friction.len(), stretches.len());
    for (mut column, stretch) in columns.column_iter_mut().zip(stretches) {
        for i in stretch.clone() {
            column[i] = friction[i];
        }
    }
    let white = stand.whiten_own(&columns);
    let scored = stretches.iter().enumerate().filter_map(|(j, stretch)| {
        let score = ground.score(&ground.direction(&white.columns(j, 1).into_owned())?);
        Some(Scored {
            stretch: stretch.clone(),
            z: score.signed_z(),
        })
    });
    scored.max_by(|a, b| a.z.abs().total_cmp(&b.z.abs()))
}

/// The strongest of all, in standard deviations of what runs do; `None` where it is one of many.
fn standing_out(largest: &[Scored], asked: usize) -> Option<Scored> {
    let mut sizes: Vec<f64> = largest.iter().map(|s| s.z.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let middle = *sizes.get(sizes.len().checked_sub(1)? / 2)?;
    let best = largest
        .iter()
        .max_by(|a, b| a.z.abs().total_cmp(&b.z.abs()))?;
    // The largest of m normal deviates is about sqrt(2 ln m).
    let expected = (2.0 * (asked.max(2) as f64 / largest.len() as f64).ln()).sqrt();
    let spread = (middle / expected).max(1.0);
    (best.z.abs() > ALONE * middle).then(|| Scored {
        z: best.z / spread,
        ..best.clone()
    })
}

/// The stretch's place, with the runs that deviate alike at the same time.
fn place(largest: &[Scored], found: &Scored, samples: &Samples, names: &[String]) -> Place {
    let run = samples.owner[found.stretch.start];
    let mut place = in_run(
        samples,
        names,
        run,
        found.stretch.start,
        found.stretch.end - 1,
    );
    let strongest = largest.iter().map(|s| s.z.abs()).fold(0.0, f64::max);
    place.runs = largest
        .iter()
        .filter(|other| {
            let (first, last) = (other.stretch.start, other.stretch.end - 1);
            let overlaps = samples.time[first] <= place.to && samples.time[last] >= place.from;
            overlaps && other.z * found.z.signum() > ALIKE * strongest
        })
        .map(|other| names[samples.owner[other.stretch.start]].clone())
        .collect();
    place
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    /// Four samples that are raised alike keep three quarters of what they explain, whichever is given up; one that is far off keeps nothing.
    #[test]
    fn one_sample_is_no_shift() {
        const SAMPLES: usize = 100;
        let at_start = DMatrix::from_fn(SAMPLES, 1, |i, _| f64::from(u8::from(i == 0)));
        let gains = DMatrix::from_fn(SAMPLES, 2, |i, k| f64::from(u8::from(i / 50 == k)));
        let stretch = 58..62;
        let columns = stretch_and_samples(&stretch, &[1.0; SAMPLES]);
        assert_eq!(columns.ncols(), 5);
        let share = |residual: &dyn Fn(usize) -> f64| {
            let y = nalgebra::DVector::from_fn(SAMPLES, |i, _| residual(i));
            share_without_one(&Ground::new(&at_start, &gains, &y, &[0, 1]), &columns)
        };
        let raised = share(&|i| if stretch.contains(&i) { 6.5 } else { 0.0 });
        assert!((raised - 0.75).abs() < 0.1, "{raised}");
        let blow = share(&|i| if i == 60 { 13.0 } else { 0.0 });
        assert!(blow < 0.05, "{blow}");
        assert_eq!(stretch_and_samples(&(0..41), &[1.0; SAMPLES]).ncols(), 1);
    }

    /// A stretch raised by one standard deviation of a sample, 80 samples long, comes first of its run, and what nearly coincides with it is left out.
    #[test]
    fn the_stretch_that_is_raised_comes_first() {
        let mut generator = ChaCha8Rng::seed_from_u64(11);
        let mut values: Vec<f64> = (0..1200)
            .map(|_| StandardNormal.sample(&mut generator))
            .collect();
        values[700..780].iter_mut().for_each(|v| *v += 1.0);
        let ranked = ranked(&running_sums(values.into_iter()), &(600..1200));
        let first = &ranked.first[0];
        assert!(
            first.start.abs_diff(700) < 20 && first.end.abs_diff(780) < 20,
            "{first:?}"
        );
        let same = |a: &Range<usize>| {
            ranked
                .first
                .iter()
                .filter(|b| is_much_the_same(a, b))
                .count()
        };
        assert!(ranked.first.iter().all(|stretch| same(stretch) == 1));
        assert_eq!(ranked.first.len(), TAKEN);
    }

    /// What all runs do is no shift of one of them; one far beyond the others is, in units of what they do.
    #[test]
    fn a_stretch_stands_out_of_what_other_runs_do() {
        let largest = |sizes: &[f64]| -> Vec<Scored> {
            let numbered = sizes.iter().enumerate();
            let scored = numbered.map(|(k, &z)| Scored {
                stretch: k..k + 4,
                z,
            });
            scored.collect()
        };
        assert!(standing_out(&largest(&[3.4, -3.9, 4.2, 3.1, -11.0, 3.6]), 6000).is_some());
        assert!(standing_out(&largest(&[9.0, -8.0, 10.0, 12.0, -17.0, 8.5]), 6000).is_none());
        let found = standing_out(&largest(&[7.0, -8.0, 7.5, 7.2, -30.0, 7.1]), 6000);
        let z = found.expect("it is four times as large as the others").z;
        assert!(z < -14.0 && z > -18.0, "{z}");
    }
}

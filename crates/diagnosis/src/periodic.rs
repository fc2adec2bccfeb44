//! Searching a residual for periods: in position (texture, a drive's pitch) and in time (an oscillating load).
//!
//! A periodic effect multiplies an envelope e_i (the friction force, or the force's answer to speed, complex where it
//! answers late) by exp(2 pi i f x_i); real and imaginary part are its two columns S. Its score statistic is
//!
//! ```text
//! T(f) = u' A^-1 u,   u = S'W'V^-1 y,   A = S'W'V^-1 W S after projection (2 x 2)
//! ```
//!
//! u needs one pass over the samples a frequency, with the vector g = W'(projection)V^-1 y kept. A is computed exactly at all low
//! frequencies and at some of the others; its trace changes slowly and is interpolated. (Its two directions may be told very
//! unequally: where an effect shows mostly in moments after a start, one phase is all that counts.) Between the grid's frequencies
//! only the peaks that may be among the strongest are looked for; they are tested exactly, the search paid for by its path length.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::comb::Comb;

/// A family of periodic effects that share an envelope and a coordinate.
pub(crate) struct Family<'a> {
    /// Position in m or time in s (of the run, or of the day), a sample.
    pub(crate) coordinate: &'a [f64],
    /// What the period multiplies, in phase with it.
    pub(crate) along: Vec<f64>,
    /// The same a quarter of a period behind: a contact with a memory answers late, the more so the slower it slides.
    pub(crate) across: Vec<f64>,
    /// Lowest and highest frequency, 1/m or Hz.
    pub(crate) band: (f64, f64),
    /// Spacing of frequencies: half a cycle over the longest stretch, or less.
    pub(crate) spacing: f64,
    /// Frequencies below it are slow: A is computed at each of them.
    pub(crate) slow: f64,
    /// Where the phase goes on between the runs: frequencies between those at which each run is looked at.
    pub(crate) comb: Option<Comb>,
}

/// A frequency at which the residual has a line.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Peak {
    /// Frequency, 1/m or Hz.
    pub(crate) frequency: f64,
    /// Approximate statistic (chi-squared with two degrees of freedom).
    pub(crate) statistic: f64,
    /// How many times higher its neighbours stand than noise of the assumed kind would let them: at least 1.
    pub(crate) background: f64,
    /// A at this place of the grid.
    information: Information,
}

/// The symmetric matrix A of one frequency: cosine with cosine, cosine with sine, sine with sine.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Information(pub(crate) [f64; 3]);

impl Information {
    /// At a share `w` of the way from one to another: its size. How its directions turn on the way is not known, both count alike.
    fn between(self, other: Self, w: f64) -> Self {
        let log = |one: Self| (0.5 * (one.0[0] + one.0[2])).max(1e-300).ln();
        let size = (log(self) * (1.0 - w) + log(other) * w).exp();
        Self([size, 0.0, size])
    }

    /// u' A^-1 u; where one direction is all that the data tell, along that one.
    fn statistic(self, (a, b): (f64, f64)) -> f64 {
        const ONE_DIRECTION: f64 = 1e-6;
        let [aa, ab, bb] = self.0;
        let trace = (aa + bb).max(1e-300);
        let determinant = aa * bb - ab * ab;
        if determinant > ONE_DIRECTION * trace * trace {
            (bb * a * a - 2.0 * ab * a * b + aa * b * b) / determinant
        } else {
            (a * a + b * b) / trace
        }
    }
}

impl Peak {
    /// How far it stands above its neighbours.
    pub(crate) fn height(&self) -> f64 {
        self.statistic / self.background
    }
}

impl Family<'_> {
    /// The number of frequencies at which a run is looked at.
    pub(crate) fn count(&self) -> usize {
        let span = self.band.1 - self.band.0;
        if !(span > 0.0) || !(self.spacing > 0.0) {
            return 0;
        }
        ((span / self.spacing) as usize + 1).min(4000)
    }

    /// How many of the frequencies, from the lowest on, are so slow that the law absorbs some of them.
    fn slow(&self) -> usize {
        ((self.slow - self.band.0) / self.spacing).max(0.0) as usize
    }

    /// Frequencies searched for each at which a run is looked at.
    fn teeth(&self) -> usize {
        self.comb.as_ref().map_or(1, |comb| comb.teeth)
    }

    /// Spacing of all frequencies searched.
    pub(crate) fn fine_spacing(&self) -> f64 {
        self.spacing / self.teeth() as f64
    }

    /// u of all frequencies searched.
    fn all_scores(&self, count: usize, g: &DVector<f64>) -> Vec<(f64, f64)> {
        match &self.comb {
            None => self.scores(count, g),
            Some(comb) => comb.scores(self, count, g),
        }
    }

    /// Cosine and sine columns of one frequency.
    pub(crate) fn columns(&self, frequency: f64) -> DMatrix<f64> {
        let n = self.along.len();
        let mut out = DMatrix::zeros(n, 2);
        for i in 0..n {
            let (sin, cos) = (std::f64::consts::TAU * frequency * self.coordinate[i]).sin_cos();
            out[(i, 0)] = self.along[i] * cos - self.across[i] * sin;
            out[(i, 1)] = self.along[i] * sin + self.across[i] * cos;
        }
        out
    }

    /// u of one frequency.
    pub(crate) fn score(&self, frequency: f64, g: &DVector<f64>) -> (f64, f64) {
        let (mut a, mut b) = (0.0, 0.0);
        for i in 0..self.along.len() {
            let (sin, cos) = (std::f64::consts::TAU * frequency * self.coordinate[i]).sin_cos();
            let (x, y) = (self.along[i] * g[i], self.across[i] * g[i]);
            a += x * cos - y * sin;
            b += x * sin + y * cos;
        }
        (a, b)
    }

    /// u of all frequencies: within a stretch of them each sample's phase turns by a fixed angle a frequency.
    pub(crate) fn scores(&self, count: usize, g: &DVector<f64>) -> Vec<(f64, f64)> {
        const STRETCH: usize = 64;
        let weighed = |envelope: &[f64]| -> Vec<f64> {
            envelope.iter().zip(g.iter()).map(|(e, g)| e * g).collect()
        };
        let (x, y) = (weighed(&self.along), weighed(&self.across));
        let turn: Vec<(f64, f64)> = self
            .coordinate
            .iter()
            .map(|c| (std::f64::consts::TAU * self.spacing * c).sin_cos())
            .collect();
        let starts: Vec<usize> = (0..count).step_by(STRETCH).collect();
        let stretches: Vec<Vec<(f64, f64)>> = starts
            .par_iter()
            .map(|&start| {
                let f = self.band.0 + self.spacing * start as f64;
                let mut sin: Vec<f64> = Vec::with_capacity(x.len());
                let mut cos: Vec<f64> = Vec::with_capacity(x.len());
                for c in self.coordinate {
                    let (s, c) = (std::f64::consts::TAU * f * c).sin_cos();
                    sin.push(s);
                    cos.push(c);
                }
                (start..(start + STRETCH).min(count))
                    .map(|_| {
                        let (mut a, mut b) = (0.0, 0.0);
                        for i in 0..x.len() {
                            a += x[i] * cos[i] - y[i] * sin[i];
                            b += x[i] * sin[i] + y[i] * cos[i];
                            let (s, c) = turn[i];
                            (cos[i], sin[i]) = (cos[i] * c - sin[i] * s, sin[i] * c + cos[i] * s);
                        }
                        (a, b)
                    })
                    .collect()
            })
            .collect();
        stretches.into_iter().flatten().collect()
    }

    /// The strongest peaks on the grid of frequencies, strongest first. `information(columns)` is A for each pair of columns.
    pub(crate) fn peaks(
        &self,
        g: &DVector<f64>,
        information: &(dyn Fn(&DMatrix<f64>) -> Vec<Information> + Sync),
        most: usize,
    ) -> Vec<Peak> {
        let count = self.count();
        if count < 3 {
            return Vec::new();
        }
        let at = |i: usize| self.band.0 + self.spacing * i as f64;
        let knots = knots(count, self.slow());
        let known: Vec<Information> = knots
            .par_chunks(TOGETHER)
            .flat_map_iter(|some| {
                let pairs: Vec<DMatrix<f64>> = some.iter().map(|&i| self.columns(at(i))).collect();
                let columns: Vec<_> = pairs.iter().flat_map(|p| p.column_iter()).collect();
                information(&DMatrix::from_columns(&columns))
            })
            .collect();
        let at_grid: Vec<Information> = (0..count)
            .map(|i| {
                let k = knots.partition_point(|&x| x <= i).clamp(1, knots.len() - 1);
                let (a, b) = (knots[k - 1], knots[k]);
                match i {
                    _ if i == a => known[k - 1],
                    _ if i == b => known[k],
                    _ => known[k - 1].between(known[k], (i - a) as f64 / (b - a) as f64),
                }
            })
            .collect();
        let teeth = self.teeth();
        let between = |j: usize| match (j / teeth, j % teeth) {
            (i, 0) => at_grid[i],
            (i, tooth) => at_grid[i].between(at_grid[i + 1], tooth as f64 / teeth as f64),
        };
        let values: Vec<f64> = (self.all_scores(count, g).into_iter().enumerate())
            .map(|(j, u)| between(j).statistic(u))
            .collect();
        let mut order: Vec<usize> = (0..values.len())
            .filter(|&i| {
                (i == 0 || values[i] >= values[i - 1])
                    && (i + 1 == values.len() || values[i] > values[i + 1])
            })
            .collect();
        order.sort_by(|&a, &b| values[b].total_cmp(&values[a]));
        order
            .into_iter()
            .take(most)
            .map(|i| Peak {
                frequency: self.band.0 + self.fine_spacing() * i as f64,
                statistic: values[i],
                background: background(&values, i, teeth),
                information: between(i),
            })
            .collect()
    }

    /// The same peak at its highest: between the grid's frequencies a line may rise further.
    pub(crate) fn sharpened(&self, peak: &Peak, g: &DVector<f64>) -> Peak {
        let height = |f: f64| peak.information.statistic(self.score(f, g));
        let frequency = self.summit(peak.frequency, &height);
        Peak {
            frequency,
            statistic: height(frequency),
            ..*peak
        }
    }

    /// Golden section over one spacing each way, to a hundredth of it: a joint fit goes on from there.
    fn summit(&self, frequency: f64, height: &dyn Fn(f64) -> f64) -> f64 {
        let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
        let spacing = self.fine_spacing();
        let mut lo = (frequency - spacing).max(0.5 * self.band.0);
        let mut hi = frequency + spacing;
        let (mut a, mut b) = (hi - ratio * (hi - lo), lo + ratio * (hi - lo));
        let (mut at_a, mut at_b) = (height(a), height(b));
        while hi - lo > 0.01 * spacing {
            if at_a > at_b {
                (hi, b, at_b) = (b, a, at_a);
                a = hi - ratio * (hi - lo);
                at_a = height(a);
            } else {
                (lo, a, at_a) = (a, b, at_b);
                b = lo + ratio * (hi - lo);
                at_b = height(b);
            }
        }
        0.5 * (lo + hi)
    }

    /// Path length of the search on the unit sphere, from above: a column turns by 2 pi (spread of the coordinate) a
    /// unit of frequency, the spread is at most half of the longest stretch, and one spacing is half a cycle over it.
    pub(crate) fn path(&self) -> f64 {
        (self.count() * self.teeth()) as f64 * std::f64::consts::FRAC_PI_2
    }
}

/// Neighbours on either side that make the background of a line.
const NEIGHBOURS: usize = 64;
/// The median of chi-squared with two degrees of freedom, and how far chance takes the median of so many neighbours.
const MEDIAN: f64 = 1.386;
const CHANCE: f64 = 1.25;

/// The background at a place among statistics. Roughness of another kind than assumed (smoothed by a slow sensor, say) stands high
/// over whole bands, where some line then stands highest of all. Neighbours are `apart` values apart.
fn background(values: &[f64], i: usize, apart: usize) -> f64 {
    let below = (i / apart).min(NEIGHBOURS);
    let near = values[i - below * apart..].iter().step_by(apart);
    let mut near: Vec<f64> = near.take(below + NEIGHBOURS + 1).copied().collect();
    // Among few neighbours a line and its own flanks are the median.
    if near.len() < NEIGHBOURS {
        return 1.0;
    }
    near.sort_by(f64::total_cmp);
    (near[near.len() / 2] / (MEDIAN * CHANCE)).max(1.0)
}

/// Knots whose columns are whitened side by side.
const TOGETHER: usize = 4;
/// Knots above the lowest frequencies, at most.
const MOST_KNOTS: usize = 64;

/// All of the lowest frequencies (the law absorbs some), then every sixteenth, or as many as [`MOST_KNOTS`] leave.
fn knots(count: usize, lowest: usize) -> Vec<usize> {
    let mut out: Vec<usize> = (0..count.min(lowest)).collect();
    let mut i = lowest;
    while i < count {
        out.push(i);
        i += 16.max(count.div_ceil(MOST_KNOTS));
    }
    if out.last() != Some(&(count - 1)) {
        out.push(count - 1);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variances_are_evaluated_at_a_bounded_number_of_frequencies() {
        for count in [3, 13, 540, 1024, 1025, 3960, 4000] {
            let knots = knots(count, 12);
            assert!(
                knots.len() <= 12 + MOST_KNOTS + 1,
                "{count}: {}",
                knots.len()
            );
            assert_eq!((knots[0], knots[knots.len() - 1]), (0, count - 1));
            assert!(knots.windows(2).all(|w| w[0] < w[1]));
        }
        // records of ordinary length: every sixteenth
        assert_eq!(knots(540, 12)[12..15], [12, 28, 44]);
        // a band of higher frequencies has no slow ones
        assert_eq!(knots(40, 0), [0, 16, 32, 39]);
    }
}

//! Lines that go on between the runs: a period by the clock of the day, or one of the plate that runs pass at different places.
//!
//! Over a day of runs with rests between them the score u(f) of [`crate::periodic`] turns by many cycles from one frequency at which a
//! run is looked at to the next. That of one run alone, taken about the run's middle c_k, does not: it is computed at these
//! frequencies, and all runs are put together in between,
//!
//! ```text
//! u(f) = sum_k exp(2 pi i f c_k) u_k(f),   u_k(f) = sum over run k of e_j g_j exp(2 pi i f (t_j - c_k))
//! ```
//!
//! with u_k linear between two of them. A quarter of a cycle apart, as they are, the height of a line halfway is 3 % low, which a
//! peak gets back where it is sharpened.

use std::ops::Range;

use nalgebra::DVector;
use rayon::prelude::*;

use crate::periodic::Family;

/// Frequencies searched in all, at most: a day of nine hours up to 8 Hz.
const MOST_FREQUENCIES: f64 = 5e5;

/// How finely a day is looked at.
pub(crate) struct Comb {
    runs: Vec<Range<usize>>,
    /// Frequencies for each at which a run is looked at: half a cycle over the whole day apart.
    pub(crate) teeth: usize,
}

impl Comb {
    /// The comb of a day or a plate: `clock`, s (or place, m), a sample; `spacing` of the frequencies at which a run is looked at, Hz (or 1/m).
    pub(crate) fn new(runs: &[Range<usize>], clock: &[f64], spacing: f64) -> Self {
        let (first, last) = clock
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), t| {
                (a.min(*t), b.max(*t))
            });
        Self {
            runs: runs.to_vec(),
            teeth: (spacing * 2.0 * (last - first)).ceil().max(1.0) as usize,
        }
    }

    /// u of all frequencies between the first and the last of `count` at which a run is looked at.
    pub(crate) fn scores(
        &self,
        family: &Family<'_>,
        count: usize,
        g: &DVector<f64>,
    ) -> Vec<(f64, f64)> {
        let count = count.min((MOST_FREQUENCIES / self.teeth as f64).ceil() as usize + 1);
        let runs: Vec<(f64, Vec<(f64, f64)>)> = self
            .runs
            .iter()
            .filter(|run| !run.is_empty())
            .map(|run| of_one_run(family, run, count, g))
            .collect();
        let stretches: Vec<Vec<(f64, f64)>> = (0..count - 1)
            .into_par_iter()
            .map(|i| self.stretch(family, &runs, i))
            .collect();
        stretches.into_iter().flatten().collect()
    }

    /// u from the frequency `i` at which runs are looked at up to the next one.
    fn stretch(
        &self,
        family: &Family<'_>,
        runs: &[(f64, Vec<(f64, f64)>)],
        i: usize,
    ) -> Vec<(f64, f64)> {
        let tau = std::f64::consts::TAU;
        let frequency = family.band.0 + family.spacing * i as f64;
        let mut out = vec![(0.0, 0.0); self.teeth];
        for (middle, own) in runs {
            let (mut sin, mut cos) = (tau * frequency * middle).sin_cos();
            let (s, c) = (tau * family.fine_spacing() * middle).sin_cos();
            let (mut a, mut b) = own[i];
            let step = (self.teeth as f64).recip();
            let (da, db) = ((own[i + 1].0 - a) * step, (own[i + 1].1 - b) * step);
            for u in &mut out {
                u.0 += a * cos - b * sin;
                u.1 += a * sin + b * cos;
                (cos, sin) = (cos * c - sin * s, sin * c + cos * s);
                (a, b) = (a + da, b + db);
            }
        }
        out
    }
}

/// Middle of a run, s, and its u_k at all frequencies at which runs are looked at.
fn of_one_run(
    family: &Family<'_>,
    run: &Range<usize>,
    count: usize,
    g: &DVector<f64>,
) -> (f64, Vec<(f64, f64)>) {
    let clock = &family.coordinate[run.clone()];
    let middle = 0.5 * (clock[0] + clock[clock.len() - 1]);
    let about: Vec<f64> = clock.iter().map(|t| t - middle).collect();
    let alone = Family {
        coordinate: &about,
        along: family.along[run.clone()].to_vec(),
        across: family.across[run.clone()].to_vec(),
        comb: None,
        ..*family
    };
    let g = g.rows(run.start, run.len()).into_owned();
    (middle, alone.scores(count, &g))
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;

    use super::*;
    use crate::periodic::Information;

    /// Of a line of 3.21 Hz in three runs of a day the score put together from the runs is that of the sum over all samples, but for
    /// three percent at its height; among the peaks, sharpened, the highest stands at its frequency.
    #[test]
    fn a_line_that_goes_on_between_runs_stands_at_its_frequency() {
        const F: f64 = 3.21;
        let starts = [0.0, 61.3, 400.2];
        let clock: Vec<f64> = starts
            .iter()
            .flat_map(|s| (0..600).map(move |i| s + f64::from(i) / 60.0))
            .collect();
        let runs: Vec<Range<usize>> = (0..3).map(|k| 600 * k..600 * (k + 1)).collect();
        let g = DVector::from_iterator(
            clock.len(),
            clock.iter().map(|t| (std::f64::consts::TAU * F * t).sin()),
        );
        let family = Family {
            coordinate: &clock,
            along: vec![1.0; clock.len()],
            across: vec![0.0; clock.len()],
            band: (0.2, 20.0),
            spacing: 0.025,
            slow: 0.0,
            comb: Some(Comb::new(&runs, &clock, 0.025)),
        };
        let comb = family.comb.as_ref().expect("given");
        let scores = comb.scores(&family, family.count(), &g);
        let at = |j: usize| 0.2 + family.fine_spacing() * j as f64;
        let height = |(a, b): (f64, f64)| a.hypot(b);
        let most = height(family.score(F, &g));
        for j in (0..scores.len()).step_by(97).chain(2515..2535) {
            let exact = family.score(at(j), &g);
            let apart = (scores[j].0 - exact.0, scores[j].1 - exact.1);
            assert!(height(apart) < 0.03 * most, "{}", at(j));
        }
        let even = |columns: &DMatrix<f64>| vec![Information([1.0, 0.0, 1.0]); columns.ncols() / 2];
        let peaks = family.peaks(&g, &even, 10);
        let sharp = peaks.iter().map(|peak| family.sharpened(peak, &g));
        let highest = sharp.max_by(|a, b| a.statistic.total_cmp(&b.statistic));
        let found = highest.expect("some").frequency;
        assert!((found - F).abs() < 0.05 * family.fine_spacing(), "{found}");
    }
}

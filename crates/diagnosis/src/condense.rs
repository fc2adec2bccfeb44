//! Long records: neighbouring samples are averaged for the search wherever the record between them is straight.
//!
//! A row stands for m samples and carries the weight sqrt(m): the weighted mean is an orthonormal projection, so white noise
//! keeps its standard deviation a sample; roughness, which may be shorter than a row, is averaged as the noise model knows
//! ([`fitting::noise::Averaged`]). The law is
//! evaluated at a row's mean time, speed and load, which is the mean of the law over the row where both run straight; what is
//! left between the two at a fit is taken off the rows ([`Bench::allow_for`]), so that it does not look like an effect. The
//! tolerance on the deviation from straight lines is the smallest that brings the record down to [`ROWS`] rows. Starts and
//! reversals bend most and stay as they were recorded; a rest or a steady slide collapses. First and last samples of a run
//! always stand for themselves. Runs of one motion are divided alike.

use campaign::{Campaign, Run};

use fitting::noise::Averaged;

use crate::bench::{Bench, Fitted};
use crate::samples::Samples;

/// Records up to this many samples are searched as they are.
const LONGEST: usize = 24_000;
/// Rows of a condensed record, at most.
pub(crate) const ROWS: usize = 3_000;
/// A row is never longer than this many times the mean row.
const LONGEST_ROW: usize = 4;
/// A run keeps at least this many rows.
const ROWS_OF_A_RUN: usize = 32;

/// A record with fewer rows than samples.
pub(crate) struct Condensed {
    /// The campaign, rows in the place of samples.
    pub(crate) campaign: Campaign,
    /// What each row is the mean of.
    pub(crate) averaged: Vec<Averaged>,
    /// Rows with a sample that says nothing.
    pub(crate) masked: Vec<bool>,
    /// Largest root mean square deviation from a straight line within a row, of the largest speed and of the force's own
    /// root mean square.
    pub(crate) tolerance: f64,
}

impl Condensed {
    /// Means over the rows of a series of all samples.
    pub(crate) fn means(&self, all: &[f64]) -> Vec<f64> {
        let mut at = 0;
        let mean = |row: &Averaged| {
            let from = at;
            at += row.samples as usize;
            all[from..at].iter().sum::<f64>() / (at - from) as f64
        };
        self.averaged.iter().map(mean).collect()
    }

    /// What the reader should know.
    pub(crate) fn note(&self, samples: &Samples) -> String {
        format!(
            "causes were searched on {} rows, means of up to {:.0} neighbouring samples of the {} recorded; within a row the record \
             keeps to a straight line within {:.1e} of its size; faster oscillations were not searched; the last fit and all \
             errors use every sample",
            self.averaged.len(),
            self.averaged
                .iter()
                .fold(1.0_f64, |m, row| m.max(row.samples)),
            samples.len(),
            self.tolerance,
        )
    }
}

/// Condenses a long record; `None` where it is not long, or where nothing moves on the average. `samples` holds the forces that
/// count, `masked` those that do not.
pub(crate) fn condense(
    campaign: &Campaign,
    samples: &Samples,
    masked: &[bool],
) -> Option<Condensed> {
    if samples.len() <= LONGEST {
        return None;
    }
    let trees = trees(campaign, samples);
    let tolerance = tolerance(&trees);
    let mut out = Condensed {
        campaign: campaign.clone(),
        averaged: Vec::new(),
        masked: Vec::new(),
        tolerance,
    };
    for (k, run) in out.campaign.runs.iter_mut().enumerate() {
        let range = samples.runs[k].clone();
        let rows = trees[k].rows(tolerance);
        for row in &rows {
            let slid = &samples.sliding[range.start + row.start..range.start + row.end];
            out.averaged.push(Averaged {
                samples: row.len() as f64,
                step: (slid[row.len() - 1] - slid[0]) / (row.len() - 1).max(1) as f64,
            });
            let hidden = masked[range.start + row.start..range.start + row.end].iter();
            out.masked.push(hidden.into_iter().any(|m| *m));
        }
        average(run, samples, range, &rows);
    }
    let mut speeds = out.campaign.runs.iter().flat_map(|run| &run.velocity_m_s);
    speeds.any(|v| *v != 0.0).then_some(out)
}

impl Bench<'_> {
    /// Takes what a fit says of the rows' samples less what it says of the rows off what was recorded; `all` is what it says of
    /// all samples. How much that changed since the last time comes back, as the largest share of the force's root mean square.
    pub(crate) fn allow_for(&mut self, short: &Condensed, fitted: &Fitted, all: &[f64]) -> f64 {
        let recorded = short.campaign.runs.iter().flat_map(|run| &run.force_n);
        let power = recorded.clone().map(|f| f * f).sum::<f64>() / self.samples.len() as f64;
        let means = short.means(all);
        let mut moved = 0.0_f64;
        for (i, force) in recorded.enumerate() {
            let allowed = force - (means[i] - fitted.prediction[i]);
            moved = moved.max((allowed - self.samples.force[i]).abs());
            self.samples.force[i] = allowed;
            self.experiment.measured_n[i] = allowed;
        }
        moved / power.sqrt().max(f64::MIN_POSITIVE)
    }
}

/// Means over rows in the place of samples.
fn average(
    run: &mut Run,
    samples: &Samples,
    range: std::ops::Range<usize>,
    rows: &[std::ops::Range<usize>],
) {
    let mean = |x: &[f64]| -> Vec<f64> {
        let over =
            |row: &std::ops::Range<usize>| x[row.clone()].iter().sum::<f64>() / row.len() as f64;
        rows.iter().map(over).collect()
    };
    run.time_s = mean(&run.time_s);
    run.velocity_m_s = mean(&run.velocity_m_s);
    run.force_n = mean(&samples.force[range.clone()]);
    run.position_m = Some(mean(&samples.place[range]));
    run.normal_force_n = run.normal_force_n.as_deref().map(mean);
    run.temperature_c = run.temperature_c.as_deref().map(mean);
}

/// How crooked a run's record is over stretches of 2, 4, 8 ... samples.
#[derive(Clone)]
struct Tree {
    samples: usize,
    /// Level l holds blocks of 2^(l + 1) samples from sample 1 on: the largest crookedness of the block and of all in it.
    levels: Vec<Vec<f64>>,
}

impl Tree {
    fn new(depth: usize, samples: usize, crooked: impl Fn(usize, usize) -> f64) -> Self {
        let mut levels: Vec<Vec<f64>> = Vec::with_capacity(depth);
        for level in 0..depth {
            let size = 2 << level;
            let blocks = samples.saturating_sub(2) / size;
            let own = |b: usize| {
                let start = 1 + b * size;
                let inside = levels
                    .last()
                    .map_or(0.0, |below: &Vec<f64>| below[2 * b].max(below[2 * b + 1]));
                inside.max(crooked(start, start + size))
            };
            levels.push((0..blocks).map(own).collect());
        }
        Self { samples, levels }
    }

    /// The rows within a tolerance, in order: the largest blocks that are straight, single samples where none is.
    fn rows(&self, tolerance: f64) -> Vec<std::ops::Range<usize>> {
        let mut rows = Vec::new();
        rows.push(0..1);
        let mut at = 1;
        while at + 1 < self.samples {
            let mut size = 1;
            for (level, blocks) in self.levels.iter().enumerate() {
                let whole = 2 << level;
                let straight = (at - 1) % whole == 0
                    && blocks
                        .get((at - 1) / whole)
                        .is_some_and(|c| *c <= tolerance);
                if !straight {
                    break;
                }
                size = whole;
            }
            rows.push(at..at + size);
            at += size;
        }
        if self.samples > 1 {
            rows.push(self.samples - 1..self.samples);
        }
        rows
    }
}

/// One tree a run; runs of one motion share theirs.
fn trees(campaign: &Campaign, samples: &Samples) -> Vec<Tree> {
    let mean_row = samples.len() as f64 / ROWS as f64;
    let longest = (LONGEST_ROW as f64 * mean_row) as usize;
    let fastest = samples.velocity.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let power = samples.force.iter().map(|f| f * f).sum::<f64>() / samples.len() as f64;
    let (fastest, force) = (
        fastest.max(f64::MIN_POSITIVE),
        power.sqrt().max(f64::MIN_POSITIVE),
    );
    let mut trees: Vec<Tree> = Vec::with_capacity(campaign.runs.len());
    let mut leaders: Vec<usize> = Vec::new();
    let mut leader_of: Vec<usize> = Vec::with_capacity(campaign.runs.len());
    for (k, run) in campaign.runs.iter().enumerate() {
        let range = samples.runs[k].clone();
        let size = longest.min(range.len() / ROWS_OF_A_RUN).max(1);
        let crooked = |a: usize, b: usize| {
            let line = |x: &[f64]| off_line(&run.time_s[a - 1..b + 1], &x[a - 1..b + 1]);
            let speed = line(&samples.velocity[range.clone()]) / fastest;
            speed.max(line(&samples.force[range.clone()]) / force)
        };
        let tree = Tree::new(size.ilog2() as usize, range.len(), crooked);
        let same = |&l: &usize| {
            let other: &Run = &campaign.runs[l];
            other.velocity_m_s == run.velocity_m_s && other.time_s == run.time_s
        };
        match leaders.iter().copied().find(same) {
            Some(leader) => {
                for (own, new) in trees[leader].levels.iter_mut().zip(&tree.levels) {
                    own.iter_mut().zip(new).for_each(|(a, b)| *a = a.max(*b));
                }
                leader_of.push(leader);
            }
            None => {
                leaders.push(k);
                leader_of.push(k);
            }
        }
        trees.push(tree);
    }
    leader_of.into_iter().map(|l| trees[l].clone()).collect()
}

/// Root mean square deviation from the least-squares line.
fn off_line(t: &[f64], x: &[f64]) -> f64 {
    let n = t.len() as f64;
    let (t0, x0) = (t.iter().sum::<f64>() / n, x.iter().sum::<f64>() / n);
    let (mut tt, mut tx, mut xx) = (0.0, 0.0, 0.0);
    for (t, x) in t.iter().zip(x) {
        let (t, x) = (t - t0, x - x0);
        tt += t * t;
        tx += t * x;
        xx += x * x;
    }
    ((xx - tx * tx / tt).max(0.0) / (n - 2.0)).sqrt()
}

/// The smallest tolerance with at most [`ROWS`] rows, to a hundredth; infinite where no tolerance brings so few.
fn tolerance(trees: &[Tree]) -> f64 {
    let count = |tolerance: f64| -> usize { trees.iter().map(|t| t.rows(tolerance).len()).sum() };
    let (mut low, mut high) = (1e-9_f64.ln(), 0.0_f64);
    if count(high.exp()) > ROWS {
        return f64::INFINITY;
    }
    while high - low > 0.01 {
        let middle = 0.5 * (low + high);
        if count(middle.exp()) > ROWS {
            low = middle;
        } else {
            high = middle;
        }
    }
    high.exp()
}

#[cfg(test)]
mod tests {
    use super::*;
    use friction::LawKind;
    use rig::{Experiment, Model};

    /// A shipped campaign, each step of its record cut into `times` by straight lines.
    fn refined(times: usize) -> Campaign {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../../data/campaigns/brush-2x2-aluminium");
        let mut campaign = campaign::open(&folder).expect("a shipped campaign");
        let finer = |x: &[f64]| -> Vec<f64> {
            let steps = (x.len() - 1) * times;
            let at = |i: usize| {
                let (k, w) = (i / times, (i % times) as f64 / times as f64);
                x[k] * (1.0 - w) + x[(k + 1).min(x.len() - 1)] * w
            };
            (0..=steps).map(at).collect()
        };
        for run in &mut campaign.runs {
            run.time_s = finer(&run.time_s);
            run.velocity_m_s = finer(&run.velocity_m_s);
            run.force_n = finer(&run.force_n);
            run.position_m = run.position_m.as_deref().map(finer);
        }
        campaign
    }

    fn condensed(campaign: &Campaign) -> (Samples, Option<Condensed>) {
        let samples = Samples::new(campaign);
        let masked = vec![false; samples.len()];
        let short = condense(campaign, &samples, &masked);
        (samples, short)
    }

    #[test]
    fn an_ordinary_record_stays_as_it_is() {
        assert!(condensed(&refined(1)).1.is_none());
    }

    #[test]
    fn a_long_record_has_few_rows_that_stand_for_every_sample_once() {
        let campaign = refined(10);
        let (samples, short) = condensed(&campaign);
        let short = short.expect("36,000 samples are many");
        assert!(
            short.averaged.len() <= ROWS,
            "{} rows",
            short.averaged.len()
        );
        let counted: f64 = short.averaged.iter().map(|row| row.samples).sum();
        assert!((counted - samples.len() as f64).abs() < 1e-6 * counted);
        let forces = short.campaign.runs.iter().flat_map(|r| &r.force_n);
        let sum: f64 = forces
            .zip(&short.averaged)
            .map(|(f, row)| f * row.samples)
            .sum();
        let all: f64 = samples.force.iter().sum();
        assert!((sum - all).abs() < 1e-9 * all.abs().max(1.0));
        // both ends of a run stand for themselves
        let mut at = 0;
        for run in &short.campaign.runs {
            let end = at + run.time_s.len();
            let ends = [at, end - 1].map(|i| short.averaged[i].samples);
            assert_eq!(ends, [1.0, 1.0]);
            at = end;
        }
    }

    /// With what rows make of a fit taken off, a row misses the fit by the mean of what its samples miss it by.
    #[test]
    fn a_fit_misses_a_row_as_it_misses_its_samples() {
        let campaign = refined(10);
        let (samples, short) = condensed(&campaign);
        let short = short.expect("36,000 samples are many");
        let options = crate::Options::default();
        let recorded = crate::prepare::bench(&campaign, &options).expect("a shipped campaign");
        let mut rows = recorded.condensed(&short);
        let law = [0.5, 0.62, 1.5, 0.1, 0.01, 1.5, -0.3];
        let fitted = |bench: &Bench<'_>| {
            let model = bench.model(&[]).expect("a bristle campaign");
            Fitted {
                effects: Vec::new(),
                prediction: model.predict(&bench.experiment, &law),
                parameters: law.to_vec(),
                model,
                cost: 0.0,
                converged: true,
                beside: crate::bench::Beside::default(),
            }
        };
        let (all, few) = (fitted(&recorded), fitted(&rows));
        assert!(rows.allow_for(&short, &few, &all.prediction) > 0.0);
        let missed: Vec<f64> = (samples.force.iter().zip(&all.prediction))
            .map(|(measured, predicted)| measured - predicted)
            .collect();
        for (i, mean) in short.means(&missed).iter().enumerate() {
            let row = rows.experiment.measured_n[i] - few.prediction[i];
            assert!((row - mean).abs() < 1e-12, "row {i}: {row} against {mean}");
        }
        // The second time nothing is left to allow for.
        assert_eq!(rows.allow_for(&short, &few, &all.prediction), 0.0);
    }

    /// The record is what the law says, so that the two bend at the same places.
    #[test]
    fn the_law_at_a_row_is_the_mean_of_the_law_over_its_samples() {
        let mut campaign = refined(10);
        let predicted = |campaign: &Campaign| {
            let experiment = Experiment::new(campaign).expect("it moves");
            let law = LawKind::AsymmetricBristle;
            let model = Model::new(law, Vec::new(), &experiment).expect("a bristle campaign");
            model.predict(&experiment, &[0.5, 0.62, 1.5, 0.1, 0.01, 1.5, -0.3])
        };
        let fine = predicted(&campaign);
        let mut rest = fine.as_slice();
        for run in &mut campaign.runs {
            let (own, others) = rest.split_at(run.force_n.len());
            run.force_n = own.to_vec();
            rest = others;
        }
        let (_, short) = condensed(&campaign);
        let short = short.expect("36,000 samples are many");
        let coarse = predicted(&short.campaign);
        let size = (fine.iter().map(|f| f * f).sum::<f64>() / fine.len() as f64).sqrt();
        let mut worst = 0.0_f64;
        for (mean, row) in short.means(&fine).iter().zip(&coarse) {
            worst = worst.max((mean - row).abs() / size);
        }
        assert!(
            worst > 0.0 && worst < 1.5 * short.tolerance,
            "{worst:e} against {:e}",
            short.tolerance
        );
    }

    /// A velocity that changes its sign with every sample has no mean that moves.
    #[test]
    fn a_record_that_stands_still_on_the_average_stays_as_it_is() {
        let mut campaign = refined(10);
        for run in &mut campaign.runs {
            let last_pair = (run.velocity_m_s.len() - 2) / 2 * 2;
            for (i, v) in run.velocity_m_s.iter_mut().enumerate() {
                *v = match i {
                    0 => 0.0,
                    _ if i > last_pair => 0.0,
                    _ if i % 2 == 1 => 0.02,
                    _ => -0.02,
                };
            }
        }
        let (samples, short) = condensed(&campaign);
        assert!(samples.len() > LONGEST && short.is_none());
    }
}

//! A gain that some runs share and the others lack: one run, the runs of a stretch of the day, or every second, third or fourth one.
//!
//! A weight that was forgotten or a clamp that was changed looks like scatter between runs. Scatter knows no order, so each
//! such set of runs is one question, answered by Student's t of the runs' gains (the scatter is integrated over), and the
//! questions pay for one another by Bonferroni's bound.

use nalgebra::{DMatrix, DVector};

use crate::answer::Place;
use crate::general::{Lack, MOST_RUNS};
use crate::ground::{Ground, Score};
use crate::samples::Samples;

/// With fewer runs a gain of some is not told from scatter.
const FEWEST_RUNS: usize = 5;
/// Longest period of a pattern, in runs.
const LONGEST_PERIOD: usize = 4;

/// The strongest pattern; `white_gains`: a whitened gain column a run.
pub(crate) fn patterns(
    ground: &Ground,
    white_gains: &DMatrix<f64>,
    samples: &Samples,
    names: &[String],
) -> Lack {
    let began: Vec<f64> = samples
        .runs
        .iter()
        .map(|r| samples.clock[r.start])
        .collect();
    let Some(Pattern { runs, score, asked }) = strongest(ground, white_gains, &began) else {
        return Lack::nothing();
    };
    let ends = runs
        .iter()
        .map(|&run| samples.time[samples.runs[run].end - 1]);
    Lack {
        log_p: (score.log_p + (asked as f64).ln()).min(0.0),
        place: Some(Place {
            axis: "time".into(),
            from: 0.0,
            to: ends.fold(0.0, f64::max),
            unit: "s".into(),
            runs: runs.iter().map(|&run| names[run].clone()).collect(),
        }),
        excess: (score.statistic - 1.0).max(0.0),
    }
}

/// Runs with a gain of their own.
struct Pattern {
    runs: Vec<usize>,
    score: Score,
    /// Sets of runs that were asked.
    asked: usize,
}

/// The set of runs whose common gain is least probable as scatter.
fn strongest(ground: &Ground, white_gains: &DMatrix<f64>, began: &[f64]) -> Option<Pattern> {
    if !(FEWEST_RUNS..=MOST_RUNS).contains(&began.len()) {
        return None;
    }
    let sets = sets(began);
    let asked = sets.len();
    let scored = sets.into_iter().filter_map(|runs| {
        let mut column = DVector::zeros(white_gains.nrows());
        for &run in &runs {
            column += white_gains.column(run);
        }
        let free = ground.project_vector(&column);
        let score = ground.score(&ground.along(free, column.norm())?);
        Some(Pattern { runs, score, asked })
    });
    scored.min_by(|a, b| a.score.log_p.total_cmp(&b.score.log_p))
}

/// The sets of runs that are asked: each run alone and, where the order of the day is known, neighbours (at most half of all, for the
/// others then say the same) and every second, third or fourth run.
fn sets(began: &[f64]) -> Vec<Vec<usize>> {
    let count = began.len();
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by(|&a, &b| began[a].total_cmp(&began[b]));
    if order.windows(2).any(|w| began[w[0]] >= began[w[1]]) {
        return (0..count).map(|run| vec![run]).collect();
    }
    let mut sets = Vec::new();
    for length in 1..=count / 2 {
        sets.extend(order.windows(length).map(<[usize]>::to_vec));
    }
    for period in 2..=LONGEST_PERIOD.min(count / 2) {
        // Of two phases the one says what the other does.
        let phases = if period == 2 { 1 } else { period };
        sets.extend(
            (0..phases).map(|phase| order[phase..].iter().step_by(period).copied().collect()),
        );
    }
    sets
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    const RUNS: usize = 12;
    const EACH: usize = 30;
    /// Standard deviation of a run's gain, in units of what its own noise allows to see.
    const SCATTER: f64 = 1.5;

    fn began(ordered: bool) -> Vec<f64> {
        let day = |k: usize| if ordered { 1e3 * k as f64 } else { 0.0 };
        (0..RUNS).map(day).collect()
    }

    /// What is found where the runs of a set have a gain of `size` scatters beside the scatter, and the logarithm of its probability.
    fn found(set: &[usize], size: f64, ordered: bool, rng: &mut ChaCha8Rng) -> (Vec<usize>, f64) {
        let n = RUNS * EACH;
        let mut normal = || -> f64 { StandardNormal.sample(rng) };
        let own: Vec<f64> = (0..RUNS)
            .map(|k| SCATTER * (normal() + if set.contains(&k) { size } else { 0.0 }))
            .collect();
        let residual = DVector::from_fn(n, |i, _| own[i / EACH] + normal());
        let gains = DMatrix::from_fn(n, RUNS, |i, k| f64::from(u8::from(i / EACH == k)));
        let law = DMatrix::from_element(n, 1, 1.0);
        let ground = Ground::new(&law, &gains, &residual, &[]);
        let pattern = strongest(&ground, &gains, &began(ordered)).expect("asked");
        let log_p = pattern.score.log_p + (pattern.asked as f64).ln();
        (pattern.runs, log_p)
    }

    #[test]
    fn runs_that_share_a_gain_are_told_from_scatter_and_named() {
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        for set in [vec![4, 5, 6, 7], vec![1, 4, 7, 10]] {
            let mut seen = 0;
            for _ in 0..20 {
                let (runs, log_p) = found(&set, 6.0, true, &mut rng);
                seen += usize::from(runs == set && log_p < -6.0);
            }
            assert!(seen >= 18, "{set:?}: {seen} of 20");
        }
    }

    /// 2 % nominal, all questions paid for, so at most 8 of 400 are expected.
    #[test]
    fn scatter_alone_is_no_pattern() {
        let mut rng = ChaCha8Rng::seed_from_u64(12);
        let mut alarms = 0;
        for trial in 0..400 {
            let (_, log_p) = found(&[], 0.0, trial % 2 == 0, &mut rng);
            alarms += usize::from(log_p < 0.02_f64.ln());
        }
        assert!(alarms <= 16, "{alarms} of 400");
    }

    /// Without the order of the day neighbours are not known: a stretch is then asked run by run.
    #[test]
    fn neighbours_need_the_order_of_the_day() {
        assert_eq!(sets(&began(false)).len(), RUNS);
        assert!(sets(&began(true)).contains(&vec![4, 5, 6, 7]));
        assert!(sets(&began(true)).contains(&vec![0, 2, 4, 6, 8, 10]));
    }
}

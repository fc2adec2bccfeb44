//! A gain that some runs share and the others lack (one run, two of them, the runs of a stretch of the day, every second, third or fourth
//! one, those of a range of strokes, speeds or rests), gains that jump and go back or go up and down in the course of the day, by the order of the runs or by the clock, gains of
//! all runs under one load, and gains that follow how far or how fast runs go or how long the rig has rested before them.
//!
//! A weight that was forgotten, a clamp that was changed or a room that cools looks like scatter between runs. Scatter knows no order, so
//! each such question is answered by Student's t of the runs' gains (the scatter is integrated over), and the questions pay for one another
//! by Bonferroni's bound.

use std::f64::consts::{LN_2, PI};
use std::ops::Range;

use nalgebra::{DMatrix, SymmetricEigen};

use crate::general::{Lack, MOST_RUNS};
use crate::ground::{ABSORBED, Ground, Score};
use crate::samples::Samples;

/// With fewer runs a gain of some is not told from scatter.
const FEWEST_RUNS: usize = 5;
/// Longest period of a pattern, in runs.
const LONGEST_PERIOD: usize = 4;
/// Cosines of the day's course.
const COSINES: usize = 4;
/// Times in which a jump of the gain goes back, as shares of the day.
const RELAXATIONS: [f64; 3] = [0.1, 0.2, 0.4];
/// Times over which a gain that wanders by the clock stays what it was, as shares of the day,
const MEMORIES: [f64; 3] = [0.05, 0.1, 0.2];
/// and the share of its variance that the gains hold that are asked for.
const HELD: f64 = 0.95;
/// Shares of what may be spent: of sets, of families, and of manners, which are few.
const OF_SETS: f64 = 0.5;
const OF_FAMILIES: f64 = 0.45;
const OF_MANNERS: f64 = 0.05;
/// Share by which runs that are made in one manner may differ in it.
const ALIKE: f64 = 1e-3;
/// Runs for each cosine that a course needs at least.
const RUNS_A_COSINE: usize = 3;

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
    let manners = manners(samples, &began);
    let asked = questions(&began, &samples.load_levels().of_run, &manners);
    let Some((question, score)) = strongest(ground, white_gains, asked) else {
        return Lack::nothing();
    };
    Lack {
        log_p: (score.log_p + question.price).min(0.0),
        place: Some(samples.place_of_runs(&question.runs(), names)),
        excess: (score.statistic - 1.0).max(0.0),
    }
}

/// Gains of runs: the question whether any combination of them is there.
struct Question {
    /// Runs x gains.
    gains: DMatrix<f64>,
    /// Logarithm of what it pays for its like.
    price: f64,
}

impl Question {
    /// Runs that it moves.
    fn runs(&self) -> Vec<usize> {
        let rows = self.gains.row_iter().enumerate();
        rows.filter(|(_, row)| row.iter().any(|w| *w != 0.0))
            .map(|(run, _)| run)
            .collect()
    }
}

/// The gains that are least probable as scatter.
fn strongest(
    ground: &Ground,
    white_gains: &DMatrix<f64>,
    questions: Vec<Question>,
) -> Option<(Question, Score)> {
    // All questions lie in the span of the gains: they are answered there.
    let (narrow, root) = ground.narrowed(&ground.project(white_gains));
    // Repeats may be few. Where they alone are believed, as whole conditions contradict them, a question that makes up for that is
    // answered by what all runs say of the scatter as well; either answer pays for the other.
    let all_runs = narrow.of_all_runs();
    let both = if all_runs.is_some() { LN_2 } else { 0.0 };
    let full = white_gains.tr_mul(white_gains);
    let scored = questions.into_iter().filter_map(|mut question| {
        let mut columns = &root * &question.gains;
        for (mut free, gains) in columns.column_iter_mut().zip(question.gains.column_iter()) {
            // What the model absorbs is no question.
            if free.norm() <= ABSORBED * gains.dot(&(&full * gains)).sqrt() {
                free.fill(0.0);
            }
        }
        let direction = narrow.direction(&columns)?;
        let by_repeats = narrow.score(&direction);
        let by_all = all_runs.as_ref().map(|ground| ground.score(&direction));
        let score = by_all
            .filter(|all| all.log_p < by_repeats.log_p)
            .unwrap_or(by_repeats);
        question.price += both;
        Some((question, score))
    });
    let log_p = |(question, score): &(Question, Score)| score.log_p + question.price;
    scored.min_by(|a, b| log_p(a).total_cmp(&log_p(b)))
}

/// What is asked: sets of runs that share a gain, in families gains that differ, and gains that follow a manner. `levels`: the load of each run,
/// as a place among the loads; `manners`: how each run was made. Sets, families and manners share what may be spent.
fn questions(began: &[f64], levels: &[usize], manners: &[Vec<f64>]) -> Vec<Question> {
    let count = began.len();
    if !(FEWEST_RUNS..=MOST_RUNS).contains(&count) {
        return Vec::new();
    }
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by(|&a, &b| began[a].total_cmp(&began[b]));
    let ordered = order.windows(2).all(|w| began[w[0]] < began[w[1]]);
    let mut sets: Vec<Vec<usize>> = (0..count).map(|run| vec![run]).collect();
    sets.extend((0..count).flat_map(|a| (0..a).map(move |b| vec![b, a])));
    let mut families: Vec<DMatrix<f64>> = under_each_load(levels);
    if ordered {
        sets.extend(sets_of_the_day(&order));
        families.extend(course(&order));
        families.extend(
            MEMORIES
                .iter()
                .filter_map(|memory| wandering(began, *memory)),
        );
    }
    let priced = |all: Vec<DMatrix<f64>>, share: f64| {
        let price = (all.len() as f64 / share).ln();
        all.into_iter().map(move |gains| Question { gains, price })
    };
    let shared = |runs: Vec<usize>| {
        DMatrix::from_fn(count, 1, |run, _| f64::from(u8::from(runs.contains(&run))))
    };
    sets.extend(manners.iter().flat_map(|manner| sets_of_a_manner(manner)));
    sets.sort_by(|a, b| (a.len(), a).cmp(&(b.len(), b)));
    sets.dedup();
    let mut sets: Vec<DMatrix<f64>> = sets.into_iter().map(shared).collect();
    if ordered {
        sets.extend(jumps(began));
    }
    priced(sets, OF_SETS)
        .chain(priced(families, OF_FAMILIES))
        .chain(following(manners))
        .collect()
}

/// How far and how fast each run goes, and how long the rig has rested before it.
fn manners(samples: &Samples, began: &[f64]) -> Vec<Vec<f64>> {
    let of_runs = |of: &dyn Fn(&Range<usize>) -> f64| samples.runs.iter().map(of).collect();
    let way = |run: &Range<usize>| {
        let places = || samples.place[run.clone()].iter().copied();
        places().fold(f64::MIN, f64::max) - places().fold(f64::MAX, f64::min)
    };
    let speed = |run: &Range<usize>| {
        let speeds = samples.velocity[run.clone()].iter().map(|v| v.abs());
        speeds.sum::<f64>() / run.len().max(1) as f64
    };
    let ended: Vec<f64> = of_runs(&|run| samples.clock[run.end - 1]);
    let rest = |run: &Range<usize>| {
        let began = samples.clock[run.start];
        let before = ended.iter().copied().filter(|&end| end < began);
        began - before.fold(f64::MIN, f64::max)
    };
    let ordered = began.windows(2).any(|w| w[0] != w[1]);
    let mut manners = vec![of_runs(&way), of_runs(&speed)];
    if ordered {
        manners.push(of_runs(&rest));
    }
    manners
}

/// For each manner the question whether gains follow its logarithm; where runs hardly differ in it there is none, and where it is not known of
/// a run (nothing was before the first one) nothing is asked of that run.
fn following(manners: &[Vec<f64>]) -> Vec<Question> {
    /// Spread of the logarithm below which runs do not differ.
    const SPREAD: f64 = 0.05;
    /// Runs of which a manner must be known.
    const FEWEST: usize = 4;
    let price = (manners.len() as f64 / OF_MANNERS).ln();
    let gains = |manner: &Vec<f64>| {
        let logs: Vec<Option<f64>> = (manner.iter())
            .map(|&x| (x > 0.0 && x.is_finite() && x < 1e300).then(|| x.ln()))
            .collect();
        let known: Vec<f64> = logs.iter().flatten().copied().collect();
        let mean = known.iter().sum::<f64>() / known.len().max(1) as f64;
        let spread = known.iter().map(|x| (x - mean).powi(2)).sum::<f64>();
        let differ = known.len() >= FEWEST && (spread / known.len() as f64).sqrt() > SPREAD;
        differ.then(|| {
            let of = |k: usize| logs[k].map_or(0.0, |log| log - mean);
            DMatrix::from_fn(logs.len(), 1, |k, _| of(k))
        })
    };
    let asked = manners.iter().filter_map(gains);
    asked.map(|gains| Question { gains, price }).collect()
}

/// For each load under which at most half of the runs were made, and two at least: each of these with a gain of its own.
fn under_each_load(levels: &[usize]) -> Vec<DMatrix<f64>> {
    let highest = levels.iter().copied().max().unwrap_or(0);
    let under = |level: usize| -> Vec<usize> {
        (0..levels.len()).filter(|&k| levels[k] == level).collect()
    };
    (0..=highest)
        .map(under)
        .filter(|runs| (2..=levels.len() / 2).contains(&runs.len()))
        .map(|runs| {
            DMatrix::from_fn(levels.len(), runs.len(), |k, j| {
                f64::from(u8::from(runs[j] == k))
            })
        })
        .collect()
}

/// Neighbours, three or more and at most half of all (the others then say the same), and every second, third or fourth run.
fn sets_of_the_day(order: &[usize]) -> Vec<Vec<usize>> {
    let count = order.len();
    let mut sets = Vec::new();
    for length in 3..=count / 2 {
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

/// Runs that are next to one another in a manner, three or more and at most half of all, each with all that are as it is: friction may be another
/// within a range of strokes, or after middling rests.
fn sets_of_a_manner(manner: &[f64]) -> Vec<Vec<usize>> {
    let count = manner.len();
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by(|&a, &b| manner[a].total_cmp(&manner[b]));
    let alike = |a: usize, b: usize| (manner[a] - manner[b]).abs() <= ALIKE * manner[b].abs();
    // Places in the order at which a run differs from the one before it.
    let mut edges: Vec<usize> = (1..count)
        .filter(|&k| !alike(order[k - 1], order[k]))
        .collect();
    edges.insert(0, 0);
    edges.push(count);
    let mut sets = Vec::new();
    for (k, &from) in edges.iter().enumerate() {
        for &to in &edges[k + 1..] {
            if (3..=count / 2).contains(&(to - from)) {
                let mut set = order[from..to].to_vec();
                set.sort_unstable();
                sets.push(set);
            }
        }
    }
    sets
}

/// Gains that jump before a run and go back by the clock, exp(-(t - t_j) / tau) of the runs that begin at t >= t_j: a door that is opened.
fn jumps(began: &[f64]) -> Vec<DMatrix<f64>> {
    let (first, last) = (began.iter()).fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &t| {
        (a.min(t), b.max(t))
    });
    let after = |from: f64, tau: f64| {
        DMatrix::from_fn(began.len(), 1, |run, _| match began[run] - from {
            since if since >= 0.0 => (-since / tau).exp(),
            _ => 0.0,
        })
    };
    let later = began.iter().filter(|&&t| t > first);
    later
        .flat_map(|&from| RELAXATIONS.map(|share| after(from, share * (last - first))))
        .collect()
}

/// The first cosines over the runs in their order, cos(pi j (i + 1/2) / n).
fn course(order: &[usize]) -> Option<DMatrix<f64>> {
    let n = order.len();
    let cosines = COSINES.min(n / RUNS_A_COSINE);
    let mut gains = DMatrix::zeros(n, cosines);
    for (i, &run) in order.iter().enumerate() {
        for j in 0..cosines {
            gains[(run, j)] = (PI * (j + 1) as f64 * (i as f64 + 0.5) / n as f64).cos();
        }
    }
    (cosines > 0).then_some(gains)
}

/// The gains of a course that wanders by the clock and remembers for a share of the day: leading eigenvectors of
/// K_ij = exp(-((t_i - t_j) / tau)^2 / 2). Runs that follow one another at once share a gain, and rests are long ways in it, which an
/// order does not know. `None` where more than half of the runs' differences are needed: then scatter does the same.
fn wandering(began: &[f64], memory: f64) -> Option<DMatrix<f64>> {
    let n = began.len();
    let first = began.iter().copied().fold(f64::INFINITY, f64::min);
    let last = began.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let tau = memory * (last - first);
    let alike = |i: usize, j: usize| (-0.5 * ((began[i] - began[j]) / tau).powi(2)).exp();
    let eigen = SymmetricEigen::new(DMatrix::from_fn(n, n, alike));
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    let (mut kept, mut held) = (Vec::new(), 0.0);
    for k in order {
        if held >= HELD * n as f64 {
            break;
        }
        held += eigen.eigenvalues[k];
        kept.push(k);
    }
    (2 * kept.len() <= n).then(|| eigen.eigenvectors.select_columns(&kept))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DVector;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    const RUNS: usize = 12;
    const EACH: usize = 30;
    /// Standard deviation of a run's gain, in units of what its own noise allows to see.
    const SCATTER: f64 = 1.5;

    /// Every fourth run was made under a second load.
    const LEVELS: [usize; RUNS] = [0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0];

    fn began(ordered: bool) -> Vec<f64> {
        let day = |k: usize| if ordered { 1e3 * k as f64 } else { 0.0 };
        (0..RUNS).map(day).collect()
    }

    /// Two clusters of runs and some between them, s.
    const IN_CLUSTERS: [f64; 16] = [
        0.0, 15.0, 48.0, 73.0, 90.0, 159.0, 266.0, 280.0, 296.0, 1144.0, 1187.0, 1734.0, 1829.0,
        1843.0, 1880.0, 1899.0,
    ];

    /// What is found beside scatter where each run has a gain of so many scatters, and the logarithm of its probability.
    fn found(
        gain: impl Fn(usize) -> f64,
        ordered: bool,
        rng: &mut ChaCha8Rng,
    ) -> (Vec<usize>, f64) {
        found_on(&began(ordered), &LEVELS, gain, rng)
    }

    /// The same of runs that began at these times.
    fn found_on(
        began: &[f64],
        levels: &[usize],
        gain: impl Fn(usize) -> f64,
        rng: &mut ChaCha8Rng,
    ) -> (Vec<usize>, f64) {
        answered(began.len(), questions(began, levels, &[]), gain, rng)
    }

    /// What these questions find where each run has a gain of so many scatters beside its own.
    fn answered(
        runs: usize,
        asked: Vec<Question>,
        gain: impl Fn(usize) -> f64,
        rng: &mut ChaCha8Rng,
    ) -> (Vec<usize>, f64) {
        let n = runs * EACH;
        let mut normal = || -> f64 { StandardNormal.sample(rng) };
        let own: Vec<f64> = (0..runs).map(|k| SCATTER * (normal() + gain(k))).collect();
        let residual = DVector::from_fn(n, |i, _| own[i / EACH] + normal());
        let gains = DMatrix::from_fn(n, runs, |i, k| f64::from(u8::from(i / EACH == k)));
        let law = DMatrix::from_element(n, 1, 1.0);
        let ground = Ground::new(&law, &gains, &residual, &[]);
        let (question, score) = strongest(&ground, &gains, asked).expect("asked");
        (question.runs(), score.log_p + question.price)
    }

    #[test]
    fn runs_that_share_a_gain_are_told_from_scatter_and_named() {
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        for set in [vec![4, 5, 6, 7], vec![1, 4, 7, 10], vec![3, 8]] {
            let gain = |k: usize| if set.contains(&k) { 8.0 } else { 0.0 };
            let mut seen = 0;
            for _ in 0..20 {
                let (runs, log_p) = found(gain, true, &mut rng);
                seen += usize::from(runs == set && log_p < -6.0);
            }
            assert!(seen >= 18, "{set:?}: {seen} of 20");
        }
    }

    /// A door that is opened before the sixth run, over a third of the day.
    #[test]
    fn a_jump_that_goes_back_is_seen() {
        let mut rng = ChaCha8Rng::seed_from_u64(14);
        let door = |k: usize| match k.checked_sub(5) {
            Some(since) => 12.0 * (-(since as f64) / 3.7).exp(),
            None => 0.0,
        };
        let seen = (0..20).filter(|_| found(door, true, &mut rng).1 < -6.0);
        assert!(seen.count() >= 18);
    }

    /// A room that cools and is heated again; a load law that changes in the middle of the day.
    #[test]
    fn courses_of_the_day_and_of_a_load_are_seen() {
        let mut rng = ChaCha8Rng::seed_from_u64(13);
        let room = |k: usize| 8.0 * (2.0 * PI * k as f64 / RUNS as f64).cos();
        let load = |k: usize| match (LEVELS[k], k < RUNS / 2) {
            (0, _) => 0.0,
            (_, true) => 12.0,
            (_, false) => -12.0,
        };
        let [mut of_the_room, mut of_the_load] = [0, 0];
        for _ in 0..20 {
            of_the_room += usize::from(found(room, true, &mut rng).1 < -6.0);
            let (runs, log_p) = found(load, true, &mut rng);
            of_the_load += usize::from(runs == [1, 5, 9] && log_p < -6.0);
        }
        assert!(
            of_the_room >= 18 && of_the_load >= 18,
            "{of_the_room}, {of_the_load}"
        );
    }

    /// Friction that is another after middling rests: the runs after them are named, wherever they lie in the day.
    #[test]
    fn a_gain_of_a_range_of_rests_is_seen() {
        let rest = |k: usize| [12.0, 14.0, 55.0, 300.0, 50.0, 410.0][(5 * k) % 6] + 0.1 * k as f64;
        let manner: Vec<f64> = (0..RUNS).map(rest).collect();
        let middling: Vec<usize> = (0..RUNS)
            .filter(|&k| (40.0..70.0).contains(&manner[k]))
            .collect();
        assert_eq!(middling.len(), 4);
        assert!(sets_of_a_manner(&manner).contains(&middling));
        let mut rng = ChaCha8Rng::seed_from_u64(17);
        let mut seen = 0;
        for _ in 0..20 {
            let asked = questions(&began(true), &[0; RUNS], std::slice::from_ref(&manner));
            let gain = |k: usize| if middling.contains(&k) { 8.0 } else { 0.0 };
            let (runs, log_p) = answered(RUNS, asked, gain, &mut rng);
            seen += usize::from(runs == middling && log_p < -6.0);
        }
        assert!(seen >= 18, "{seen} of 20");
        // runs made in one manner are in a set together or not at all
        let strokes = [3.0, 1.0, 1.0, 2.0, 1.0, 3.0, 2.0, 3.0];
        let sets = sets_of_a_manner(&strokes);
        assert_eq!(sets, [vec![1, 2, 4], vec![0, 5, 7]]);
    }

    /// A room's air over a day whose runs come in clusters, in scatters.
    #[test]
    fn what_wanders_by_the_clock_is_seen() {
        const AIR: [f64; 16] = [
            10.6, 10.6, 8.9, 6.8, 6.5, -2.8, -9.6, -11.3, -11.8, -9.9, -12.3, 11.6, 4.0, 3.0, 1.8,
            -5.9,
        ];
        let mut rng = ChaCha8Rng::seed_from_u64(15);
        let mut log_p = |gain: &dyn Fn(usize) -> f64| {
            found_on(&IN_CLUSTERS, &[0; IN_CLUSTERS.len()], gain, &mut rng).1
        };
        let seen = (0..20).filter(|_| log_p(&|k| AIR[k]) < -9.0).count();
        assert!(seen >= 18, "{seen} of 20");
        let alarms = (0..200).filter(|_| log_p(&|_| 0.0) < 0.02_f64.ln());
        assert!(alarms.count() <= 10);
    }

    /// Runs of twelve strokes in no order of the day: gains that follow the stroke are seen, scatter follows nothing.
    #[test]
    fn gains_that_follow_the_stroke_are_seen() {
        let mut rng = ChaCha8Rng::seed_from_u64(16);
        let stroke = |k: usize| 0.01 + 0.005 * ((7 * k) % RUNS) as f64;
        let manners = [(0..RUNS).map(stroke).collect::<Vec<f64>>()];
        let asked = || following(&manners);
        let middle = (0..RUNS).map(|k| stroke(k).ln()).sum::<f64>() / RUNS as f64;
        let mut log_p = |follows: f64| {
            let gain = |k: usize| follows * (stroke(k).ln() - middle);
            answered(RUNS, asked(), gain, &mut rng).1
        };
        let seen = (0..20).filter(|_| log_p(5.0) < -6.0).count();
        assert!(seen >= 18, "{seen} of 20");
        let alarms = (0..200).filter(|_| log_p(0.0) < 0.02_f64.ln()).count();
        assert!(alarms <= 10, "{alarms} of 200");
        assert!(following(&[vec![0.1; RUNS]]).is_empty());
    }

    /// 2 % nominal, all questions paid for, so at most 8 of 400 are expected.
    #[test]
    fn scatter_alone_is_no_pattern() {
        let mut rng = ChaCha8Rng::seed_from_u64(12);
        let mut alarms = 0;
        for trial in 0..400 {
            let (_, log_p) = found(|_| 0.0, trial % 2 == 0, &mut rng);
            alarms += usize::from(log_p < 0.02_f64.ln());
        }
        assert!(alarms <= 16, "{alarms} of 400");
    }

    /// Without the order of the day neighbours are not known: runs are then asked one by one and in twos.
    #[test]
    fn neighbours_need_the_order_of_the_day() {
        let has = |ordered: bool, set: &[usize]| {
            let asked = questions(&began(ordered), &[0; RUNS], &[]);
            asked.iter().any(|question| question.runs() == set)
        };
        assert!(has(false, &[3]) && has(false, &[3, 8]) && !has(false, &[4, 5, 6, 7]));
        assert!(has(true, &[4, 5, 6, 7]) && has(true, &[0, 2, 4, 6, 8, 10]));
    }
}

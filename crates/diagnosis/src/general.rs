//! The general alternative: something is left, whatever it is, and where it sits.
//!
//! Families of hat functions times the friction force, over the plate (the same in both directions, and in each),
//! over speed, over acceleration, and over time within each run; further the first two slopes of the force in time, in each direction and in each run
//! (what is left where a channel's or a start's near twin was named), and a force for each direction and load. Each family is
//! tested as a whole (many small deviations) and column by column (one place); the tests pay for one another by Bonferroni's
//! bound.

use nalgebra::DMatrix;

use crate::answer::Place;
use crate::ground::{Ground, Score};
use crate::samples::{Levels, Samples};
use crate::tail::{equivalent_z, log_chi2_tail};

/// One family of hats.
pub(crate) struct Hats {
    axis: &'static str,
    unit: &'static str,
    /// Raw columns (n x k).
    pub(crate) columns: DMatrix<f64>,
    /// Interval and run (None: all runs) of each column.
    cells: Vec<(f64, f64, Option<usize>)>,
}

/// What the general test says.
#[derive(Clone, Debug)]
pub(crate) struct Lack {
    /// Logarithm of the tail probability over all families.
    pub(crate) log_p: f64,
    /// Where the strongest family's deviations sit.
    pub(crate) place: Option<Place>,
    /// chi-squared beyond its expectation in the strongest family: what is left to explain.
    pub(crate) excess: f64,
}

impl Lack {
    /// Nothing is left.
    pub(crate) fn nothing() -> Self {
        Self {
            log_p: 0.0,
            place: None,
            excess: 0.0,
        }
    }

    /// What is left in units of deviance: no more than it is worth as evidence. (A burst in one run may have much energy and yet
    /// be nothing that the campaign's own tails do not make.)
    pub(crate) fn weight(&self) -> f64 {
        self.excess.min(equivalent_z(self.log_p).powi(2))
    }
}

/// The families that a campaign's samples allow; `recorded`: the force as the model predicts it in the record.
pub(crate) fn families(
    samples: &Samples,
    scale: &[f64],
    recorded: &[f64],
    length: f64,
) -> Vec<Hats> {
    let heading = samples.heading();
    let mut out = Vec::new();
    let (lo, hi) = range(&samples.place);
    let cells = (((hi - lo) / (4.0 * length)) as usize).clamp(4, 36);
    let forward: Vec<bool> = heading.iter().map(|h| *h > 0.0).collect();
    let both = forward.iter().any(|f| *f) && forward.iter().any(|f| !*f);
    let all = |_: usize| true;
    out.push(hats(
        "position",
        "m",
        &samples.place,
        scale,
        (lo, hi),
        cells,
        &all,
    ));
    if both {
        let odd: Vec<f64> = scale.iter().zip(heading).map(|(s, h)| s * h).collect();
        out.push(hats(
            "position",
            "m",
            &samples.place,
            &odd,
            (lo, hi),
            cells,
            &all,
        ));
    }
    let speed: Vec<f64> = samples.velocity.iter().map(|v| v.abs()).collect();
    let (slow, fast) = range(&speed);
    if fast > 1.05 * slow {
        for way in [true, false] {
            if forward.contains(&way) {
                let own = |i: usize| forward[i] == way;
                out.push(hats("speed", "m/s", &speed, scale, (slow, fast), 8, &own));
            }
        }
    }
    if samples.runs.len() <= MOST_RUNS {
        out.push(each_run(samples, scale));
        out.push(zeros(samples));
    }
    // Averages have neither the accelerations of the motion nor the slopes of the force.
    if samples.averaged.is_empty() {
        out.extend(accelerations(samples, scale));
        let [first, second] = slopes(samples, recorded);
        out.push(slope_families(samples, &first, &second, false));
        if samples.runs.len() <= MOST_RUNS {
            out.push(slope_families(samples, &first, &second, true));
        }
    }
    out.extend(loads(samples));
    out
}

/// With more runs than this nothing is asked of each.
pub(crate) const MOST_RUNS: usize = 40;

/// First and second slope in time of a force, within each run.
fn slopes(samples: &Samples, recorded: &[f64]) -> [Vec<f64>; 2] {
    let first = slope_of(samples, recorded);
    let second = slope_of(samples, &first);
    [first, second]
}

/// Slope in time, within each run.
fn slope_of(samples: &Samples, x: &[f64]) -> Vec<f64> {
    let each = samples.runs.iter();
    each.flat_map(|run| rig::signal::slope(&samples.time[run.clone()], &x[run.clone()]))
        .collect()
}

/// Hats over the acceleration along the motion, slowing down below zero; `None` where it is the same everywhere.
fn accelerations(samples: &Samples, scale: &[f64]) -> Option<Hats> {
    const CELLS: usize = 6;
    let along: Vec<f64> = (slope_of(samples, &samples.velocity).iter())
        .zip(samples.heading())
        .map(|(a, heading)| a * heading)
        .collect();
    let (least, most) = range(&along);
    (most > least).then(|| {
        hats(
            "acceleration",
            "m/s^2",
            &along,
            scale,
            (least, most),
            CELLS,
            &|_| true,
        )
    })
}

/// The two slopes, in each direction or in each run.
fn slope_families(samples: &Samples, first: &[f64], second: &[f64], runs: bool) -> Hats {
    let heading = samples.heading();
    let count = if runs { samples.runs.len() } else { 2 };
    let mut columns = DMatrix::zeros(samples.len(), 2 * count);
    for i in 0..samples.len() {
        let group = if runs {
            samples.owner[i]
        } else {
            usize::from(heading[i] < 0.0)
        };
        columns[(i, 2 * group)] = first[i];
        columns[(i, 2 * group + 1)] = second[i];
    }
    let (least, most) = range(first);
    Hats {
        axis: "force rate",
        unit: "N/s",
        columns,
        cells: (0..2 * count)
            .map(|j| (least, most, runs.then_some(j / 2)))
            .collect(),
    }
}

/// A force for each direction and load, where there are two loads.
fn loads(samples: &Samples) -> Option<Hats> {
    if !samples.loaded {
        return None;
    }
    let Levels { levels, of_run } = samples.load_levels();
    if levels.len() < 2 {
        return None;
    }
    let heading = samples.heading();
    let mut columns = DMatrix::zeros(samples.len(), 2 * levels.len());
    for i in 0..samples.len() {
        let way = usize::from(heading[i] < 0.0);
        columns[(i, 2 * of_run[samples.owner[i]] + way)] = 1.0;
    }
    Some(Hats {
        axis: "load",
        unit: "N",
        columns,
        cells: (0..2 * levels.len())
            .map(|j| (levels[j / 2], levels[j / 2], None))
            .collect(),
    })
}

fn range(x: &[f64]) -> (f64, f64) {
    x.iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &v| {
            (a.min(v), b.max(v))
        })
}

/// Triangular hats at equidistant centres, times the scale, on the samples chosen by `own`.
fn hats(
    axis: &'static str,
    unit: &'static str,
    x: &[f64],
    scale: &[f64],
    (lo, hi): (f64, f64),
    cells: usize,
    own: &dyn Fn(usize) -> bool,
) -> Hats {
    let width = (hi - lo) / cells as f64;
    let mut columns = DMatrix::zeros(x.len(), cells + 1);
    for i in 0..x.len() {
        if !own(i) {
            continue;
        }
        let t = (x[i] - lo) / width;
        let j = (t.floor().max(0.0) as usize).min(cells - 1);
        let w = (t - j as f64).clamp(0.0, 1.0);
        columns[(i, j)] += scale[i] * (1.0 - w);
        columns[(i, j + 1)] += scale[i] * w;
    }
    let cells = (0..=cells)
        .map(|j| {
            let centre = lo + width * j as f64;
            ((centre - width).max(lo), (centre + width).min(hi), None)
        })
        .collect();
    Hats {
        axis,
        unit,
        columns,
        cells,
    }
}

/// Six hats over time in each run.
fn each_run(samples: &Samples, scale: &[f64]) -> Hats {
    const CELLS: usize = 6;
    let runs = samples.runs.len();
    let mut columns = DMatrix::zeros(samples.len(), runs * (CELLS + 1));
    let mut cells = Vec::with_capacity(runs * (CELLS + 1));
    for (k, run) in samples.runs.iter().enumerate() {
        let end = samples.time[run.end - 1];
        let width = end / CELLS as f64;
        for i in run.clone() {
            let t = samples.time[i] / width;
            let j = (t.floor().max(0.0) as usize).min(CELLS - 1);
            let w = (t - j as f64).clamp(0.0, 1.0);
            columns[(i, k * (CELLS + 1) + j)] += scale[i] * (1.0 - w);
            columns[(i, k * (CELLS + 1) + j + 1)] += scale[i] * w;
        }
        for j in 0..=CELLS {
            let centre = width * j as f64;
            cells.push((
                (centre - width).max(0.0),
                (centre + width).min(end),
                Some(k),
            ));
        }
    }
    Hats {
        axis: "time",
        unit: "s",
        columns,
        cells,
    }
}

/// A force for each run: the zero of the force wanders over the day.
fn zeros(samples: &Samples) -> Hats {
    let runs = samples.runs.len();
    let mut columns = DMatrix::zeros(samples.len(), runs);
    let mut cells = Vec::with_capacity(runs);
    for (k, run) in samples.runs.iter().enumerate() {
        columns.view_mut((run.start, k), (run.len(), 1)).fill(1.0);
        cells.push((0.0, samples.time[run.end - 1], Some(k)));
    }
    Hats {
        axis: "time",
        unit: "s",
        columns,
        cells,
    }
}

/// Tests whitened families against a ground; `whitened[f]` belongs to `families[f]`.
pub(crate) fn test(
    ground: &Ground,
    families: &[Hats],
    whitened: &[DMatrix<f64>],
    samples: &Samples,
    names: &[String],
) -> Lack {
    let mut best: Option<(f64, usize, Vec<f64>, f64)> = None;
    let scatter = ground.likeliest_scatter();
    let mut log_p = 0.0_f64;
    for (f, (family, white)) in families.iter().zip(whitened).enumerate() {
        let Some(direction) = ground.direction(white) else {
            continue;
        };
        let whole: Score = ground.score(&direction);
        let single: Vec<f64> = (0..white.ncols())
            .map(|j| {
                ground
                    .direction(&white.columns(j, 1).into_owned())
                    .map_or(0.0, |d| ground.score(&d).signed_z())
            })
            .collect();
        let largest = single.iter().fold(0.0_f64, |m, z| m.max(z.abs()));
        let one = log_chi2_tail(largest * largest, 1) + (white.ncols() as f64).ln();
        let own = (whole.log_p.min(one) + 2.0_f64.ln()).min(0.0);
        log_p = log_p.min(own);
        // At the scatter of the model as it stands: what only a smaller scatter would make much of is none.
        let statistic = ground.statistic(&direction, scatter);
        let expected = whole.background * whole.columns as f64;
        let excess = (statistic - expected).max(0.0);
        if best.as_ref().is_none_or(|b| own < b.0) {
            best = Some((own, f, single, excess));
        }
        let _ = family;
    }
    let count = families.len().max(1) as f64;
    let (place, excess) = best.map_or((None, 0.0), |(_, f, single, excess)| {
        (locate(&families[f], &single, samples, names), excess)
    });
    Lack {
        log_p: (log_p + count.ln()).min(0.0),
        place,
        excess,
    }
}

/// The shortest stretch of neighbouring hats that holds four fifths of the squared deviations beyond chance.
fn locate(family: &Hats, z: &[f64], samples: &Samples, names: &[String]) -> Option<Place> {
    let beyond: Vec<f64> = z.iter().map(|z| (z * z - 4.0).max(0.0)).collect();
    let total: f64 = beyond.iter().sum();
    if !(total > 0.0) {
        // Many small deviations, none of which stands out: all over the axis.
        let all = |pick: fn(f64, f64) -> f64, of: fn(&(f64, f64, Option<usize>)) -> f64| {
            family.cells.iter().map(of).reduce(pick)
        };
        return Some(Place {
            axis: family.axis.into(),
            from: all(f64::min, |c| c.0)?,
            to: all(f64::max, |c| c.1)?,
            unit: family.unit.into(),
            runs: names.to_vec(),
        });
    }
    let mut best: Option<(f64, usize, usize)> = None;
    for a in 0..beyond.len() {
        let mut held = 0.0;
        for (b, more) in beyond.iter().enumerate().skip(a) {
            if family.cells[a].2 != family.cells[b].2 {
                break;
            }
            held += more;
            // A stretch is judged by what it holds and how short it is.
            if held >= 0.8 * total {
                let length = family.cells[b].1 - family.cells[a].0;
                if best.is_none_or(|(l, _, _)| length < l) {
                    best = Some((length, a, b));
                }
                break;
            }
        }
    }
    let (a, b) = best.map_or_else(
        || {
            // Spread over several runs: from the first to the last hat that stands out.
            let first = beyond.iter().position(|x| *x > 0.02 * total).unwrap_or(0);
            let last = beyond
                .iter()
                .rposition(|x| *x > 0.02 * total)
                .unwrap_or(first);
            (first, last)
        },
        |(_, a, b)| (a, b),
    );
    let chosen: Vec<usize> = (a..=b).filter(|j| beyond[*j] > 0.02 * total).collect();
    let from = chosen
        .iter()
        .map(|&j| family.cells[j].0)
        .fold(f64::INFINITY, f64::min);
    let to = chosen
        .iter()
        .map(|&j| family.cells[j].1)
        .fold(f64::NEG_INFINITY, f64::max);
    let runs: Vec<String> = match family.cells[a].2 {
        Some(_) => {
            let mut own: Vec<usize> = chosen.iter().filter_map(|&j| family.cells[j].2).collect();
            own.dedup();
            own.into_iter().map(|k| names[k].clone()).collect()
        }
        None => (0..samples.runs.len())
            .filter(|&k| {
                samples.runs[k]
                    .clone()
                    .any(|i| chosen.iter().any(|&j| family.columns[(i, j)] != 0.0))
            })
            .map(|k| names[k].clone())
            .collect(),
    };
    Some(Place {
        axis: family.axis.into(),
        from,
        to,
        unit: family.unit.into(),
        runs,
    })
}

//! Where the residual of the law alone lies: against time, position, speed, order, load, direction and temperature.
//!
//! For each axis the residual (as a coefficient, or a force without a load) is averaged in bins, apart for the two
//! directions where both occur. The share of the axis is what the bins' means explain of the explainable part,
//!
//! ```text
//! share = sum_b n_b (m_b^2 - s_b^2) / (sum r^2 - n floor^2),   s_b^2 = (correlated) variance of a bin's mean      (D2)
//! ```
//!
//! limited to 0..1. Shares of different axes overlap (in a ramp, time, position and speed are one another), so they do
//! not add up to one.

use crate::answer::Share;
use crate::samples::Samples;

/// Bins along a continuous axis.
const BINS: usize = 24;

/// Shares and profiles of all axes that vary in the campaign. `residual` and `floor` share a unit.
pub(crate) fn anatomy(
    samples: &Samples,
    residual: &[f64],
    floor: f64,
    correlation_length: f64,
) -> Vec<Share> {
    let heading = samples.heading();
    let run_value =
        |f: &dyn Fn(usize) -> f64| -> Vec<f64> { samples.owner.iter().map(|&k| f(k)).collect() };
    let order = run_value(&|k| k as f64 + 1.0);
    let load = run_value(&|k| {
        let run = &samples.runs[k];
        samples.load[run.clone()].iter().sum::<f64>() / run.len() as f64
    });
    let speed: Vec<f64> = samples.velocity.iter().map(|v| v.abs()).collect();
    let mut axes: Vec<(&str, &str, &[f64], bool)> = vec![
        ("time", "s", &samples.time, true),
        ("position", "m", &samples.place, true),
        ("speed", "m/s", &speed, true),
        ("order", "run", &order, true),
        ("direction", "sign", heading, false),
    ];
    if samples.loaded {
        axes.push(("load", "N", &load, true));
    }
    if let Some(temperature) = &samples.temperature {
        axes.push(("temperature", "degC", temperature, true));
    }
    let n = residual.len() as f64;
    let total: f64 = residual.iter().map(|r| r * r).sum();
    let explainable = (total - n * floor * floor).max(1e-12 * total).max(1e-300);
    axes.into_iter()
        .filter_map(|(axis, unit, x, split)| {
            let along = Along {
                samples,
                x,
                heading,
                split,
            };
            let (explained, profile) = along.bins(residual, floor, correlation_length)?;
            Some(Share {
                axis: axis.into(),
                share: if total > n * floor * floor {
                    (explained / explainable).clamp(0.0, 1.0)
                } else {
                    0.0
                },
                profile,
                unit: unit.into(),
            })
        })
        .collect()
}

/// One axis.
struct Along<'a> {
    samples: &'a Samples,
    x: &'a [f64],
    heading: &'a [f64],
    split: bool,
}

impl Along<'_> {
    fn bins(&self, residual: &[f64], floor: f64, length: f64) -> Option<(f64, Vec<[f64; 3]>)> {
        let (lo, hi) = self
            .x
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &v| {
                (a.min(v), b.max(v))
            });
        if !(hi - lo > 1e-9 * hi.abs().max(lo.abs())) {
            return None;
        }
        let width = (hi - lo) / BINS as f64;
        // Sum, count, distance slid and passes of each bin, reverse and forward apart.
        let mut cells = vec![[0.0_f64; 4]; 2 * BINS];
        let mut last = (usize::MAX, usize::MAX);
        for i in 0..self.x.len() {
            let bin = (((self.x[i] - lo) / width) as usize).min(BINS - 1);
            let side = usize::from(self.split && self.heading[i] > 0.0);
            let cell = &mut cells[2 * bin + side];
            cell[0] += residual[i];
            cell[1] += 1.0;
            let owner = self.samples.owner[i];
            if i > 0 && self.samples.owner[i - 1] == owner {
                cell[2] += self.samples.sliding[i] - self.samples.sliding[i - 1];
            }
            if last != (owner, bin) {
                cell[3] += 1.0;
                last = (owner, bin);
            }
        }
        let mut explained = 0.0;
        let mut profile = Vec::new();
        for (b, cell) in cells.iter().enumerate() {
            if cell[1] < 1.0 {
                continue;
            }
            let mean = cell[0] / cell[1];
            // Independent pieces in a bin: its samples, or the correlation lengths slid in it, whichever are fewer.
            let pieces = cell[1].min(cell[3] + cell[2] / (2.0 * length).max(1e-12));
            let error = floor / pieces.max(1.0).sqrt();
            explained += cell[1] * (mean * mean - error * error);
            profile.push([lo + width * ((b / 2) as f64 + 0.5), mean, error]);
        }
        Some((explained.max(0.0), profile))
    }
}

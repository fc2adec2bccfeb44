//! How good a fit is, honestly: its residual beside what repeats scatter, and a test of what is left.

use campaign::{Campaign, Run};
use fitting::noise::{Context, EstimateOptions, NoiseModel, Search, Whitener, estimate};
use nalgebra::{DMatrix, DVector};
use rig::Experiment;
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use crate::features::coefficient;

/// Numbers on a fit, in the unit of y = F/N (of the force itself without a load).
#[derive(Clone, Debug, PartialEq)]
pub struct Quality {
    /// Root mean square of the residual.
    pub rmse: f64,
    /// Root mean square of the recorded y.
    pub rms: f64,
    /// Standard deviation within repeats, scatter between runs included; `None` without repeats.
    pub floor_rmse: Option<f64>,
    /// Test of lack of fit; `None` where it was not asked for.
    pub lack_of_fit: Option<LackOfFit>,
}

impl Quality {
    /// Share of the mean square of y that the fit explains.
    pub fn explained(&self) -> f64 {
        1.0 - (self.rmse / self.rms).powi(2)
    }
}

/// Test of the law against smooth departures in speed and displacement that repeat in every run of a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LackOfFit {
    /// F statistic.
    pub statistic: f64,
    /// Number of departures that the law leaves free.
    pub departures: usize,
    /// Degrees of freedom of the noise within runs.
    pub degrees: f64,
    /// Probability of so much structure by noise alone.
    pub p_value: f64,
}

impl LackOfFit {
    /// Whether structure is left at the 1 % level.
    pub fn rejects(&self) -> bool {
        self.p_value < 0.01
    }
}

/// Residual and record in the unit of y.
pub(crate) fn sizes(experiment: &Experiment, predicted: &[f64]) -> (f64, f64) {
    let (mut residual, mut record, mut count) = (0.0, 0.0, 0_usize);
    for run in &experiment.runs {
        for (i, load) in run.samples.clone().zip(&run.load_n) {
            if *load > 0.0 {
                residual += ((predicted[i] - experiment.measured_n[i]) / load).powi(2);
                record += (experiment.measured_n[i] / load).powi(2);
                count += 1;
            }
        }
    }
    let n = count.max(1) as f64;
    ((residual / n).sqrt(), (record / n).sqrt())
}

/// Pooled standard deviation within repeats at equal times, in the unit of y; `None` without repeats.
///
/// ```text
/// s^2 = sum over conditions and samples of (y - mean)^2 / sum of (repeats - 1)
/// ```
pub fn repeat_floor(campaign: &Campaign) -> Option<f64> {
    let (mut sum, mut degrees) = (0.0, 0_usize);
    for condition in campaign.conditions() {
        let runs: Vec<&Run> = condition.iter().map(|&k| &campaign.runs[k]).collect();
        if runs.len() < 2 {
            continue;
        }
        let records: Vec<Vec<f64>> = runs.iter().map(|run| coefficient(run)).collect();
        for &t in &runs[0].time_s {
            let values: Vec<f64> = runs
                .iter()
                .zip(&records)
                .filter_map(|(run, y)| interpolate(&run.time_s, y, t))
                .collect();
            if values.len() < 2 {
                continue;
            }
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            sum += values.iter().map(|y| (y - mean).powi(2)).sum::<f64>();
            degrees += values.len() - 1;
        }
    }
    (degrees > 0).then(|| (sum / degrees as f64).sqrt())
}

/// y at time t between samples; `None` outside the record.
fn interpolate(time_s: &[f64], y: &[f64], t: f64) -> Option<f64> {
    let k = time_s.partition_point(|&s| s < t);
    if k < time_s.len() && time_s[k] == t {
        return Some(y[k]);
    }
    if k == 0 || k >= time_s.len() {
        return None;
    }
    let share = (t - time_s[k - 1]) / (time_s[k] - time_s[k - 1]);
    Some(y[k - 1] + share * (y[k] - y[k - 1]))
}

/// Smooth departures from a law, each multiplying the friction, in each direction of motion by itself: five cosines
/// over speed and three decays over the displacement since rest or reversal.
///
/// **Shape:** samples x (8 a direction that occurs).
fn departures(experiment: &Experiment, scale: &[f64]) -> DMatrix<f64> {
    let top = experiment.scales.speed_m_s;
    let travel = experiment.scales.travel_m;
    let mut columns: Vec<DVector<f64>> = Vec::new();
    for forward in [true, false] {
        let mut block = vec![DVector::zeros(experiment.samples()); 8];
        let mut occurs = false;
        for run in &experiment.runs {
            let mut since = 0.0;
            for (k, i) in run.samples.clone().enumerate() {
                let v = run.velocity_m_s[k];
                if k > 0 {
                    let reversed = v * run.velocity_m_s[k - 1] < 0.0;
                    let step = run.distance_m[k] - run.distance_m[k - 1];
                    since = if reversed { 0.0 } else { since + step };
                }
                if v == 0.0 || (v > 0.0) != forward {
                    continue;
                }
                occurs = true;
                let x = std::f64::consts::PI * v.abs() / top;
                for (m, column) in block.iter_mut().enumerate().take(5) {
                    column[i] = scale[i] * ((m + 1) as f64 * x).cos();
                }
                for (m, share) in [0.005, 0.015, 0.05].into_iter().enumerate() {
                    block[5 + m][i] = scale[i] * (-since / (share * travel)).exp();
                }
            }
        }
        if occurs {
            columns.extend(block);
        }
    }
    DMatrix::from_columns(&columns)
}

/// F test of the departures: the whitened residual, cleared of what the parameters explain, against the departures
/// cleared likewise. The noise is estimated anew with the departures in the mean, so that they do not hide in it.
pub(crate) fn lack_of_fit(
    experiment: &Experiment,
    context: &Context,
    residual: &DVector<f64>,
    jacobian: &DMatrix<f64>,
    noise: &NoiseModel,
    options: &EstimateOptions,
) -> LackOfFit {
    let extra = departures(experiment, &context.scale);
    let options = EstimateOptions {
        search: Search::Again(noise.sizes),
        ..options.clone()
    };
    let mut sizes = estimate(context, residual, jacobian, &extra, &options).sizes;
    // What differs between runs is no departure of the law.
    sizes.scatter = noise.sizes.scatter.max(sizes.scatter);
    let whitener = Whitener::new(context, &sizes);
    let p = jacobian.ncols();
    let q = extra.ncols();
    let mut all = jacobian.clone().resize_horizontally(p + q, 0.0);
    all.view_mut((0, p), (all.nrows(), q)).copy_from(&extra);
    let basis = orthonormal(&whitener.whiten_columns(&all), p);
    let whitened = whitener.whiten(residual);
    let along: Vec<f64> = basis.iter().map(|b| b.dot(&whitened)).collect();
    let departures = along.len();
    let explained: f64 = along.iter().map(|a| a * a).sum();
    let slid: f64 = context
        .runs
        .iter()
        .map(|run| context.sliding[run.end - 1] - context.sliding[run.start])
        .sum();
    let degrees = (slid / (2.0 * sizes.length)).clamp(1.0, (residual.len() - p) as f64);
    let statistic = explained / departures.max(1) as f64;
    let p_value = FisherSnedecor::new(departures.max(1) as f64, degrees)
        .map_or(f64::NAN, |f| f.sf(statistic));
    LackOfFit {
        statistic,
        departures,
        degrees,
        p_value,
    }
}

/// Orthonormal directions of the columns from `first` on, cleared of all columns before; directions below 1e-3 of their
/// column's length are no departure of their own and are dropped.
fn orthonormal(columns: &DMatrix<f64>, first: usize) -> Vec<DVector<f64>> {
    let mut basis: Vec<DVector<f64>> = Vec::new();
    let mut kept = 0;
    for j in 0..columns.ncols() {
        let mut v: DVector<f64> = columns.column(j).into_owned();
        let length = v.norm();
        for _ in 0..2 {
            for b in &basis {
                let along = b.dot(&v);
                v.axpy(-along, b, 1.0);
            }
        }
        let left = v.norm();
        let least = if j < first { 1e-10 } else { 1e-3 };
        if left > least * length && left > 0.0 {
            basis.push(v / left);
            kept += usize::from(j < first);
        }
    }
    basis.split_off(kept)
}

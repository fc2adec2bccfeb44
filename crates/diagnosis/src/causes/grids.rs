//! Places where a search over a shape (a wavelength, a time constant) should look, and bounds that fit a campaign.

use friction::ParameterSpec;
use rig::{Experiment, RunMotion};

/// Most places at which one period is looked for.
const MOST_PERIODS: usize = 1500;

/// `n` values from `low` to `high`, evenly spaced in the logarithm.
pub(super) fn logarithmic(low: f64, high: f64, n: usize) -> Vec<f64> {
    (0..n)
        .map(|i| low * (high / low).powf(i as f64 / (n - 1) as f64))
        .collect()
}

/// The same parameter with bounds and a typical size of this campaign.
pub(super) fn bounded(spec: &ParameterSpec, lower: f64, upper: f64, typical: f64) -> ParameterSpec {
    ParameterSpec {
        lower,
        upper,
        typical,
        ..spec.clone()
    }
}

/// Duration of the longest run, s.
pub(super) fn duration_s(experiment: &Experiment) -> f64 {
    experiment
        .runs
        .iter()
        .map(|run| run.time_s[run.len() - 1] - run.time_s[0])
        .fold(0.0, f64::max)
}

/// Times (s) from a hundredth of the longest run down to about a sample's step, the shortest first: a fit that starts far too slow
/// first bends the law and does not come back.
pub(super) fn delays_s(experiment: &Experiment) -> Vec<f64> {
    const MOST: usize = 4;
    let longest = 0.01 * duration_s(experiment);
    let samples = experiment
        .runs
        .iter()
        .map(|run| run.len())
        .max()
        .unwrap_or(1);
    let step = duration_s(experiment) / samples as f64;
    logarithmic(step.min(0.5 * longest), longest, MOST)
}

/// Steps from sample to sample for a filter or delay of so many seconds: one of a few samples sees how the force went between them.
pub(super) fn steps_within(time_s: f64, run: &RunMotion) -> usize {
    const STEPS: usize = 4;
    const FEW: f64 = 5.0;
    let step = (run.time_s[run.len() - 1] - run.time_s[0]) / (run.len() - 1).max(1) as f64;
    if time_s.abs() < FEW * step { STEPS } else { 1 }
}

/// Time from the first run's start to the last one's end, s; the sum of the runs without a clock.
pub(super) fn day_s(experiment: &Experiment) -> f64 {
    let ends = experiment
        .runs
        .iter()
        .map(|run| run.started_s.map(|s| s + run.time_s[run.len() - 1]));
    match ends.collect::<Option<Vec<f64>>>() {
        Some(ends) => ends.into_iter().fold(0.0, f64::max),
        None => experiment
            .runs
            .iter()
            .map(|run| run.time_s[run.len() - 1] - run.time_s[0])
            .sum(),
    }
}

/// Distance slid in the longest run, and in all of them, m.
pub(super) fn slid_m(experiment: &Experiment) -> (f64, f64) {
    let slid = experiment
        .runs
        .iter()
        .map(|run| run.distance_m[run.len() - 1]);
    (slid.clone().fold(0.0, f64::max), slid.sum())
}

/// Median of the steps of `series` that are not zero, over all runs.
fn median_step<'a>(series: impl Iterator<Item = &'a [f64]>) -> f64 {
    let mut steps: Vec<f64> = series
        .flat_map(|s| s.windows(2).map(|w| (w[1] - w[0]).abs()))
        .filter(|&step| step > 0.0)
        .collect();
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).copied().unwrap_or(1.0)
}

/// Shortest and longest wavelength on the plate that this campaign can show, m.
pub(super) fn wavelengths_m(experiment: &Experiment) -> (f64, f64) {
    let step = median_step(experiment.runs.iter().map(|run| run.position_m.as_slice()));
    let span = plate_span_m(experiment);
    let shortest = (2.5 * step).min(span / 4.0);
    // A period is claimed only where the travel shows it twice: a longer "wave" is a step or a gradient.
    (shortest, span / 2.0)
}

/// Length of the plate that was visited, m.
pub(super) fn plate_span_m(experiment: &Experiment) -> f64 {
    let positions = || {
        experiment
            .runs
            .iter()
            .flat_map(|run| run.position_m.iter().copied())
    };
    let low = positions().fold(f64::INFINITY, f64::min);
    let high = positions().fold(f64::NEG_INFINITY, f64::max);
    (high - low).max(1e-12)
}

/// Lowest and highest frequency that this campaign can show, Hz.
pub(super) fn frequencies_hz(experiment: &Experiment) -> (f64, f64) {
    let step = median_step(experiment.runs.iter().map(|run| run.time_s.as_slice()));
    let duration = duration_s(experiment);
    // As with wavelengths: an oscillation is claimed only where a run shows it twice; a slower one is a drift or a law that
    // misses the speed.
    (2.0 / duration, (0.45 / step).max(4.0 / duration))
}

/// Rates (per metre, per second) from `low` to `high`, spaced at a third of what a record of length `span` resolves.
pub(super) fn rates(low: f64, high: f64, span: f64) -> Vec<f64> {
    let wanted = ((high - low) * span * 3.0).ceil().max(2.0) as usize;
    let n = wanted.min(MOST_PERIODS);
    (0..=n)
        .map(|i| low + (high - low) * i as f64 / n as f64)
        .collect()
}

//! Friction records and predictions as curves for figures, and their errors by direction.
//!
//! mu = F/N in units of 1, speeds in mm/s, times in s: the axes of the paper's figures.

use campaign::{Campaign, Direction, Run};
use report::figure::{Ink, Series};
use rig::Experiment;

/// Points that a record is thinned to: more than the width of a drawing shows.
const POINTS: usize = 200;

/// Both directions with their words and inks.
pub(super) const DIRECTIONS: [(Direction, &str, Ink); 2] = [
    (Direction::Forward, "forward", Ink::FORWARD),
    (Direction::Reverse, "reverse", Ink::REVERSE),
];

/// Every k-th index so that about [`POINTS`] are left.
fn thinned(length: usize) -> impl Iterator<Item = usize> {
    (0..length).step_by(length.div_ceil(POINTS).max(1))
}

/// Indices of the runs in a direction.
pub(super) fn runs_in(campaign: &Campaign, direction: Direction) -> Vec<usize> {
    (0..campaign.runs.len())
        .filter(|&k| campaign.runs[k].direction == direction)
        .collect()
}

/// |F| of a run against time: recorded (`None`) or the given stacked forces.
pub(super) fn force_against_time(
    experiment: &Experiment,
    run: usize,
    force_n: Option<&[f64]>,
) -> Vec<[f64; 2]> {
    let motion = &experiment.runs[run];
    let force = force_n.unwrap_or(&experiment.measured_n);
    thinned(motion.len())
        .map(|k| {
            let sign = motion.velocity_m_s[k].signum();
            [motion.time_s[k], sign * force[motion.samples.start + k]]
        })
        .collect()
}

/// sgn(v) F/N of a run against |v|.
pub(super) fn coefficient_against_speed(
    experiment: &Experiment,
    run: usize,
    force_n: Option<&[f64]>,
) -> Vec<[f64; 2]> {
    let motion = &experiment.runs[run];
    let force = force_n.unwrap_or(&experiment.measured_n);
    thinned(motion.len())
        .filter(|&k| motion.load_n[k] > 0.0)
        .map(|k| {
            let v = motion.velocity_m_s[k];
            let mu = v.signum() * force[motion.samples.start + k] / motion.load_n[k];
            [1e3 * v.abs(), mu]
        })
        .collect()
}

/// Recorded repeats as dots and one prediction a direction as a line, mu against speed.
pub(super) fn speed_series(
    campaign: &Campaign,
    experiment: &Experiment,
    predicted_n: &[f64],
) -> Vec<Series> {
    let mut series = Vec::new();
    for (direction, word, ink) in DIRECTIONS {
        let runs = runs_in(campaign, direction);
        let dots: Vec<[f64; 2]> = runs
            .iter()
            .flat_map(|&k| coefficient_against_speed(experiment, k, None))
            .collect();
        series.push(Series::dots(
            &format!("{word}, {} repeats", runs.len()),
            Ink::DATA,
            dots,
        ));
        if let Some(&first) = runs.first() {
            let line = coefficient_against_speed(experiment, first, Some(predicted_n));
            series.push(Series::line(&format!("{word}, model"), ink, line));
        }
    }
    series
}

/// Root mean square of (prediction - record)/N over the mean of |record|/N in one direction; `None` without such runs.
pub(super) fn relative_error(
    campaign: &Campaign,
    experiment: &Experiment,
    predicted_n: &[f64],
    direction: Direction,
) -> Option<f64> {
    let (mut square, mut sum, mut count) = (0.0, 0.0, 0_usize);
    for k in runs_in(campaign, direction) {
        let motion = &experiment.runs[k];
        for (i, load) in motion.samples.clone().zip(&motion.load_n) {
            if *load > 0.0 {
                square += ((predicted_n[i] - experiment.measured_n[i]) / load).powi(2);
                sum += (experiment.measured_n[i] / load).abs();
                count += 1;
            }
        }
    }
    (count > 0).then(|| (square / count as f64).sqrt() / (sum / count as f64))
}

/// Mean of |F|/N over speeds between two bounds (m/s) in each run of a direction.
pub(super) fn plateaus(campaign: &Campaign, direction: Direction, from: f64, to: f64) -> Vec<f64> {
    runs_in(campaign, direction)
        .into_iter()
        .filter_map(|k| plateau(&campaign.runs[k], from, to))
        .collect()
}

fn plateau(run: &Run, from: f64, to: f64) -> Option<f64> {
    let load = |i: usize| {
        run.normal_force_n
            .as_ref()
            .map_or(run.normal_load_n, |column| Some(column[i]))
    };
    let (mut sum, mut count) = (0.0, 0_usize);
    for (i, v) in run.velocity_m_s.iter().enumerate() {
        let inside = v.abs() >= from && v.abs() <= to * (1.0 + 1e-9);
        if let (true, Some(n)) = (inside, load(i).filter(|n| *n > 0.0)) {
            sum += run.force_n[i].abs() / n;
            count += 1;
        }
    }
    (count > 0).then(|| sum / count as f64)
}

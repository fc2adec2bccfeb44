//! Errors in the unit in which they are stated, and the floor below which they cannot fall.

use fitting::noise::Sizes;

use crate::answer::NoiseFloor;
use crate::bench::Bench;
use crate::samples::Samples;
use crate::selection::Selected;

/// Unit of errors: a coefficient where every run has a load, else newtons or newton metres.
pub(crate) fn unit(bench: &Bench<'_>) -> &'static str {
    if bench.samples.loaded {
        "1"
    } else if bench.experiment.axis == campaign::Axis::Rotary {
        "N m"
    } else {
        "N"
    }
}

/// Root mean square of (measured - prediction), in mu where there is a load; over the given runs, or all.
pub(crate) fn rmse(bench: &Bench<'_>, prediction: &[f64], runs: Option<&[usize]>) -> f64 {
    let (sum, count) = squares(bench, prediction, runs);
    (sum / count.max(1.0)).sqrt()
}

/// Sum of squared errors and number of samples. Samples without contact do not count, nor those at a standstill that the law does not know: a static
/// law's smoothed sign says there how wide it is, and a handful of them would be all that is left.
pub(crate) fn squares(bench: &Bench<'_>, prediction: &[f64], runs: Option<&[usize]>) -> (f64, f64) {
    let samples = &bench.samples;
    match runs {
        Some(runs) => squares_of(samples, prediction, runs),
        None => squares_in(samples, prediction, 0..samples.len()),
    }
}

/// The same over the given runs, as a root mean square.
pub(crate) fn rmse_of(samples: &Samples, prediction: &[f64], runs: &[usize]) -> f64 {
    let (sum, count) = squares_of(samples, prediction, runs);
    (sum / count.max(1.0)).sqrt()
}

fn squares_of(samples: &Samples, prediction: &[f64], runs: &[usize]) -> (f64, f64) {
    let rows = runs.iter().flat_map(|&k| samples.runs[k].clone());
    squares_in(samples, prediction, rows)
}

fn squares_in(
    samples: &Samples,
    prediction: &[f64],
    rows: impl Iterator<Item = usize>,
) -> (f64, f64) {
    let (mut sum, mut count) = (0.0, 0.0);
    for i in rows {
        let load = samples.load[i];
        let still = samples.velocity[i].abs() < samples.least_speed_m_s;
        if still || samples.loaded && !(load > 0.0) {
            continue;
        }
        // A row counts as often as it stands for samples.
        let weight = samples.weight(i);
        sum += (weight * (samples.force[i] - prediction[i]) / load).powi(2);
        count += weight * weight;
    }
    (sum, count)
}

/// Sum over a run's samples of the squared predicted force, in the unit of errors: what relative noise multiplies.
pub(crate) fn force_squares(bench: &Bench<'_>, prediction: &[f64], run: usize) -> f64 {
    let samples = &bench.samples;
    let counted = |i: &usize| !samples.loaded || samples.load[*i] > 0.0;
    samples.runs[run]
        .clone()
        .filter(counted)
        .map(|i| (samples.weight(i) * prediction[i] / samples.load[i]).powi(2))
        .sum()
}

/// Standard deviation within repeats by the noise model.
pub(crate) fn modelled(bench: &Bench<'_>, prediction: &[f64], sizes: &Sizes) -> f64 {
    let relative = sizes.private.powi(2) + sizes.scatter.powi(2);
    let sum: f64 = prediction
        .iter()
        .zip(&bench.samples.load)
        .map(|(f, load)| {
            let unit = if bench.samples.loaded && *load > 0.0 {
                *load
            } else {
                1.0
            };
            (sizes.of_the_channel() + relative * f * f) / (unit * unit)
        })
        .sum();
    (sum / prediction.len().max(1) as f64).sqrt()
}

/// The floor: within repeats where there are some, else by the noise model without what the plate repeats.
pub(crate) fn noise_floor(
    bench: &Bench<'_>,
    selected: &Selected,
    prediction: &[f64],
    condensed: bool,
) -> NoiseFloor {
    let sizes = selected.stand.sizes;
    let measured = identification::repeat_floor(bench.campaign);
    let mut modelled = modelled(bench, prediction, &sizes);
    if condensed {
        // What the law misses is one error over a whole row, and looks like so many times the noise of a sample.
        modelled = modelled.min(rmse(bench, prediction, None));
    }
    let mut caveats = Vec::new();
    if measured.is_none() {
        caveats.push(
            "no condition was repeated: the floor is that of the noise model, and the scatter between runs rests on \
             the law being right"
                .to_owned(),
        );
        if bench.stated_sensor.is_none() {
            caveats.push("the sensor's accuracy is not stated".to_owned());
        }
    }
    if selected.stand.ground.scatter_freedom() < 3 {
        caveats.push(format!(
            "the scatter between runs is known from {} degrees of freedom only",
            selected.stand.ground.scatter_freedom()
        ));
    }
    if sizes.plate == 0.0 {
        caveats.push(
            "no roughness fixed to the plate was seen, or no two runs pass the same place"
                .to_owned(),
        );
    }
    NoiseFloor {
        rmse: measured.unwrap_or(modelled),
        unit: unit(bench).into(),
        source: if measured.is_some() {
            "repeats"
        } else {
            "model"
        }
        .into(),
        sensor: sizes.sensor,
        wander: sizes.wander,
        wander_time_s: (sizes.wander > 0.0).then_some(sizes.wander_time_s),
        roughness_private: sizes.private,
        roughness_plate: sizes.plate,
        roughness_length: sizes.length,
        roughness_smoothing: sizes.smoothing,
        roughness_plate_ratio: sizes.plate_ratio,
        roughness_plate_smoothing: sizes.plate_smoothing,
        scatter: sizes.scatter,
        caveats,
    }
}

#[cfg(test)]
mod tests {
    use friction::LawKind;

    use super::*;
    use crate::Options;
    use crate::prepare::{self, stand_in};

    /// What a static law's smoothed sign misses at a standstill is no error of the law; what a law with a state misses there is.
    #[test]
    fn a_standstill_that_the_law_does_not_know_is_no_error() {
        let campaign = stand_in("brush-2x2-aluminium");
        let bench_of = |law: LawKind| {
            let options = Options {
                law: Some(law),
                ..Options::default()
            };
            prepare::bench(&campaign, &options).expect("a bench")
        };
        let [of_a_sign, of_a_state] = [LawKind::Stribeck, LawKind::Lugre].map(bench_of);
        let samples = &of_a_sign.samples;
        let still = |i: usize| samples.velocity[i].abs() < samples.least_speed_m_s;
        assert!((0..samples.len()).any(still));
        let off = |i: usize| samples.force[i] + f64::from(u8::from(still(i)));
        let prediction: Vec<f64> = (0..samples.len()).map(off).collect();
        assert_eq!(rmse(&of_a_sign, &prediction, None), 0.0);
        assert!(rmse(&of_a_state, &prediction, None) > 0.0);
    }
}

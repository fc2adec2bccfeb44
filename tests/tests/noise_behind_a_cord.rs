//! The noise of a record behind an elastic cord, planted by the independent simulator, is white once the program has whitened it.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::sync::Arc;

use fitting::noise::{Channel, Context, Lag, Ring, Sizes, Spring, Whitener};
use nalgebra::DVector;
use planting::{Base, Case, NoiseKind, Protocol};
use rig::{Experiment, Model};
use whole_program::measured::{campaign, parameters};

/// Bands of equal width up to half of the sampling rate.
const BANDS: usize = 8;
const DAYS: u64 = 6;

/// Adds the power of a series in each band, and the number of frequencies there.
fn add_spectrum(series: &[f64], bands: &mut [(f64, f64); BANDS]) {
    let n = series.len();
    for k in 1..n / 2 {
        let turn = TAU * k as f64 / n as f64;
        let (cos, sin) = series
            .iter()
            .enumerate()
            .fold((0.0, 0.0), |(c, s), (i, x)| {
                let at = turn * i as f64;
                (c + x * at.cos(), s + x * at.sin())
            });
        let (power, count) = &mut bands[(k * 2 * BANDS / n).min(BANDS - 1)];
        *power += (cos * cos + sin * sin) / n as f64;
        *count += 1.0;
    }
}

/// What a day's record leaves of the true model, whitened by the true noise, run by run.
fn whitened(protocol: Protocol, size: f64, seed: u64) -> Vec<(bool, Vec<f64>)> {
    let kind = NoiseKind::FreeRoughness;
    let day = Case::nothing(protocol, kind, seed)
        .on(Base::AsymmetricBristle)
        .with("cord-compliance", size, false)
        .carry_out()
        .expect("a cord");
    let experiment = Experiment::new(&campaign(&day.plan, &day.recordings)).expect("it moves");
    let mut reported: BTreeMap<String, f64> = (day.key.effects[0].sizes().into_iter())
        .map(|(name, value)| (name.to_string(), value))
        .collect();
    reported.entry("mass_kg".into()).or_insert(0.0);
    let cause = diagnosis::causes::find("cord-compliance").expect("in the catalogue");
    let own = cause.from_reported(&reported).expect("its own sizes");
    let (law, mut values) = parameters(&day.key.law);
    let model = Model::new(law, vec![cause], &experiment).expect("the law goes with the rig");
    values.extend(own);
    values.resize(model.parameters().len(), 0.0);

    let (mut sliding, mut place, mut rings) = (Vec::new(), Vec::new(), Vec::new());
    for (k, run) in experiment.runs.iter().enumerate() {
        let held = model.coupling(&experiment, k, &values);
        let spring = Spring {
            mass_kg: held.mass,
            compliance_m_n: held.compliance,
            damping_n_s_m: held.damping,
            friction_n_s_m: model.contact_damping(&experiment, k, &values),
        };
        let ring = Ring::new(&spring, run.time_s[1] - run.time_s[0]).expect("it rings");
        let seen = |(x, v): (&f64, &f64)| x - ring.left_s() * v;
        place.extend(run.position_m.iter().zip(&run.velocity_m_s).map(seen));
        sliding.extend_from_slice(&run.distance_m);
        rings.push((run.samples.clone(), ring));
    }
    let planted = (day.recordings.iter()).flat_map(|run| run.force_n.iter().copied());
    let predicted = model.predict(&experiment, &values);
    let residual: Vec<f64> = planted.zip(&predicted).map(|(a, b)| a - b).collect();
    let context = Context {
        conditions: Vec::new(),
        steps_s: Vec::new(),
        runs: experiment.runs.iter().map(|r| r.samples.clone()).collect(),
        sliding,
        place,
        scale: model.friction(&experiment, &values),
        channel: Arc::new(Channel {
            lag: Lag::default(),
            rings,
        }),
        rows: Vec::new(),
    };
    let noise = kind.noise(
        day.plan.full_scale_n,
        day.plan.accuracy_percent,
        4.0 / 1000.0,
    );
    let sizes = Sizes {
        sensor: noise.sensor_n,
        private: noise.roughness,
        plate: 0.0,
        length: noise.correlation_m,
        scatter: noise.scatter,
        ..Sizes::NONE
    };
    let white = Whitener::new(&context, &sizes).whiten(&DVector::from_vec(residual));
    (experiment.runs.iter())
        .map(|run| {
            let speeds = || run.velocity_m_s.iter();
            let turns = speeds().any(|v| *v > 0.0) && speeds().any(|v| *v < 0.0);
            (turns, white.as_slice()[run.samples.clone()].to_vec())
        })
        .collect()
}

/// Resonances at 22 and 32 Hz (one beyond half of the 60 samples a second), 12 and 17 Hz, 13 Hz. A band of a run holds 36 frequencies
/// on each of six days: one standard deviation is 7 %, so 15 % for the mean over the runs of a protocol are beyond chance, and 45 % for
/// a single run. (Runs that turn bend the bristles anew each time, which no resonance describes.)
#[test]
fn noise_behind_a_cord_is_white_once_it_is_whitened() {
    for (protocol, size) in [
        (Protocol::Rich, 0.14),
        (Protocol::Rich, 0.5),
        (Protocol::PaperAlternating, 0.8),
    ] {
        let mut of_runs: BTreeMap<usize, [(f64, f64); BANDS]> = BTreeMap::new();
        for seed in 40..40 + DAYS {
            for (k, (turns, white)) in whitened(protocol, size, seed).into_iter().enumerate() {
                if !turns {
                    add_spectrum(&white, of_runs.entry(k).or_default());
                }
            }
        }
        for band in 0..BANDS {
            let each: Vec<f64> = (of_runs.values().map(|of| of[band].0 / of[band].1)).collect();
            let mean = each.iter().sum::<f64>() / each.len() as f64;
            println!("{protocol:?} at {size}, band {band}: {mean:.3}");
            assert!((mean - 1.0).abs() < 0.15, "{protocol:?} {band}: {mean}");
            for power in each {
                assert!((power - 1.0).abs() < 0.45, "{protocol:?} {band}: {power}");
            }
        }
    }
}

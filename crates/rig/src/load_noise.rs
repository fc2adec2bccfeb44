//! The noise of a recorded load.
//!
//! A load cell scatters from sample to sample, and friction does not: a prediction mu N with the load as recorded carries the cell's noise,
//! and whatever smooths it or moves it in time (a lag, a delay) then fits better and is no cause. The load z of a run is therefore taken as
//!
//! ```text
//! N <- z + kappa (N - z),   z the smooth course of N (M2)
//! ```
//!
//! kappa is the share of what the cell shows beyond z that friction follows: with x = mu (N - z) in (M3)
//!
//! ```text
//! kappa^2 = sum of squares that the b_k explain, less one a b_k, over that of x
//! ```
//!
//! and zero where that is no more than chance: a rig that truly shakes keeps its load. Nothing is lost where it is zero by mistake but that
//! friction is told a little worse: no cause gains from it. Where the load steps it is taken as recorded; a single wild reading is noise.

use campaign::noise::spread;
use campaign::{Campaign, Protocol, Run};

use crate::followed::{Followed, smooth_force_n};
use crate::whittaker::{SHORTEST, likeliest, smooth};

/// Noise below this share of the mean load is none.
const NONE: f64 = 1e-6;
/// Share of what the cell shows below which friction does not follow it: a small share by mistake would bring noise back.
const LEAST: f64 = 0.3;
/// Standard deviations from which a load runs away from its smooth course.
const FAR: f64 = 4.0;

/// What was taken from the recorded loads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadNoise {
    /// Standard deviation of what the cell shows beside the smooth load, N.
    pub sd_n: f64,
    /// Share of it that friction follows.
    pub kept: f64,
}

/// Loads of all runs without the noise of the cell, and what was taken; `None` where no load is recorded, or without noise.
pub(crate) fn without_noise(campaign: &Campaign) -> Option<(Vec<Option<Vec<f64>>>, LoadNoise)> {
    let recorded: Vec<Option<&[f64]>> = campaign.runs.iter().map(recorded).collect();
    let loads: Vec<&[f64]> = recorded.iter().copied().flatten().collect();
    let samples: usize = loads.iter().map(|n| n.len()).sum();
    let cells: Vec<Option<Cell<'_>>> = campaign
        .runs
        .iter()
        .zip(recorded)
        .map(|(run, n)| n.map(|n| Cell::new(n, &run.force_n)))
        .collect();
    let of_runs = || cells.iter().flatten();
    let beside: Vec<f64> = of_runs().flat_map(Cell::beside).collect();
    let mean = loads.iter().flat_map(|n| n.iter()).sum::<f64>() / samples.max(1) as f64;
    let sd_n = spread(&beside);
    if sd_n <= NONE * mean.abs() {
        return None;
    }
    let kept = share_followed(of_runs());
    let without = |cell: &Option<Cell<'_>>| cell.as_ref().map(|cell| cell.with(kept));
    let loads = cells.iter().map(without).collect();
    Some((loads, LoadNoise { sd_n, kept }))
}

/// A run's load as recorded and along its smooth course, and its force.
struct Cell<'a> {
    n: &'a [f64],
    z: Vec<f64>,
    force_n: &'a [f64],
}

impl<'a> Cell<'a> {
    fn new(n: &'a [f64], force_n: &'a [f64]) -> Self {
        let lambda = likeliest(|lambda| smooth(n, lambda).left_of(n));
        let z = smooth(n, lambda).z;
        Self { n, z, force_n }
    }

    /// N - z.
    fn beside(&self) -> impl Iterator<Item = f64> {
        self.n.iter().zip(&self.z).map(|(n, z)| n - z)
    }

    /// z + kappa (N - z); as recorded where two neighbours lie farther from z than noise hardly does, that of this run (many a cell's noise
    /// grows with its load): there the load steps.
    fn with(&self, kappa: f64) -> Vec<f64> {
        let beside: Vec<f64> = self.beside().collect();
        let far = FAR * spread(&beside);
        let is_far = |i: usize| beside.get(i).is_some_and(|n| n.abs() > far);
        let steps = |i: usize| is_far(i) && (is_far(i + 1) || i > 0 && is_far(i - 1));
        (0..beside.len())
            .map(|i| self.z[i] + if steps(i) { 1.0 } else { kappa } * beside[i])
            .collect()
    }

    /// What friction would follow, mu (N - z), N.
    fn shown_n(&self) -> Vec<f64> {
        let force = smooth_force_n(self.force_n);
        let mu = (force.iter().zip(&self.z)).map(|(f, &z)| if z > 0.0 { f / z } else { 0.0 });
        mu.zip(self.beside()).map(|(mu, n)| mu * n).collect()
    }
}

/// The load that a run in contact records, where it is long enough.
fn recorded(run: &Run) -> Option<&[f64]> {
    let load = run.normal_force_n.as_deref()?;
    (run.protocol != Protocol::Unloaded && load.len() >= SHORTEST).then_some(load)
}

/// kappa: of the power of what the cell shows the share that explains force, as an amplitude; zero where that is no more than chance, one
/// where it is not plainly below.
fn share_followed<'a>(cells: impl Iterator<Item = &'a Cell<'a>>) -> f64 {
    let mut followed = Followed::default();
    for cell in cells {
        followed.add(&cell.shown_n(), cell.force_n);
    }
    let kappa = followed.share();
    if kappa < LEAST {
        0.0
    } else if kappa > 1.0 - 2.0 / followed.power().sqrt() {
        1.0
    } else {
        kappa
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::whittaker::tests::{miss, noise};
    use campaign::{Axis, Direction, InitialState, Provenance, RigData, Specimen};

    /// Four runs of 600 samples that slide at one speed under a load with a slow wave: friction 0.3 of `real`, a sensor's noise of 4 mN.
    pub(crate) fn campaign(
        real: impl Fn(usize) -> Vec<f64>,
        shown: impl Fn(usize) -> Vec<f64>,
    ) -> Campaign {
        let n = 600;
        let runs = (0..4).map(|k| {
            let sensor = noise(90 + k as u64, n);
            let friction = real(k).into_iter().zip(sensor);
            Run {
                name: format!("run-{k}"),
                direction: Direction::Forward,
                protocol: Protocol::Constant,
                repeat: None,
                order: None,
                started_s: None,
                normal_load_n: None,
                start_position_m: 0.0,
                stage_turned: false,
                specimen_turned: false,
                initial_state: InitialState::Relaxed,
                time_s: (0..n).map(|i| 0.01 * i as f64).collect(),
                velocity_m_s: vec![0.01; n],
                force_n: friction.map(|(load, e)| 0.3 * load + 4e-3 * e).collect(),
                position_m: None,
                normal_force_n: Some(shown(k)),
                temperature_c: None,
            }
        });
        Campaign {
            name: "by-hand".to_owned(),
            title: "by hand".to_owned(),
            provenance: Provenance::Synthetic,
            axis: Axis::Linear,
            specimen: Specimen::default(),
            counterface: None,
            rig: RigData::default(),
            runs: runs.collect(),
            input_hashes: Vec::new(),
        }
    }

    fn course(k: usize) -> Vec<f64> {
        let wave = |i: usize| (0.02 * i as f64 + k as f64).sin();
        (0..600).map(|i| 5.0 + 0.1 * wave(i)).collect()
    }

    fn plus(a: Vec<f64>, size: f64, b: &[f64]) -> Vec<f64> {
        a.into_iter().zip(b).map(|(a, b)| a + size * b).collect()
    }

    #[test]
    fn noise_of_the_cell_goes_and_the_course_of_the_load_stays() {
        let cell = |k: usize| plus(course(k), 0.02, &noise(k as u64 + 1, 600));
        let (loads, taken) = without_noise(&campaign(course, cell)).expect("there is noise");
        assert_eq!(taken.kept, 0.0);
        assert!((taken.sd_n / 0.02 - 1.0).abs() < 0.05, "{taken:?}");
        for (k, load) in loads.iter().enumerate() {
            let load = load.as_ref().expect("recorded");
            assert!(miss(load, &course(k)) < 0.3 * miss(&cell(k), &course(k)));
        }
    }

    /// A rig that shakes, and one whose force is read two samples late.
    #[test]
    fn what_friction_follows_stays() {
        let shaken = |k: usize| plus(course(k), 0.02, &noise(k as u64 + 1, 600));
        let late = |k: usize| {
            let load = shaken(k);
            [&load[..2], &load[..598]].concat()
        };
        for real in [&shaken as &dyn Fn(usize) -> Vec<f64>, &late] {
            let (loads, taken) = without_noise(&campaign(real, shaken)).expect("it shakes");
            assert_eq!(taken.kept, 1.0);
            assert!(miss(loads[1].as_ref().expect("recorded"), &shaken(1)) < 1e-15);
        }
    }

    /// A load that shakes at one frequency, eight samples a turn.
    #[test]
    fn a_wave_that_friction_follows_stays() {
        let turn = std::f64::consts::TAU / 8.0;
        let wave: Vec<f64> = (0..600).map(|i| (turn * f64::from(i)).sin()).collect();
        let real = |k: usize| plus(course(k), 0.1, &wave);
        let (_, taken) = without_noise(&campaign(real, real)).expect("it shakes");
        assert_eq!(taken.kept, 1.0);
    }

    #[test]
    fn of_shaking_and_noise_of_one_size_half_stays() {
        let shaken = |k: usize| plus(course(k), 0.02, &noise(k as u64 + 1, 600));
        let read = |k: usize| plus(shaken(k), 0.02, &noise(k as u64 + 50, 600));
        let (_, taken) = without_noise(&campaign(shaken, read)).expect("there is noise");
        assert!((taken.kept - 0.5).abs() < 0.1, "{taken:?}");
    }

    #[test]
    fn a_step_of_the_load_stays_a_step() {
        let step = |_: usize| [[5.0; 300], [8.0; 300]].concat();
        assert!(without_noise(&campaign(step, step)).is_none());
        let cell = |k: usize| plus(step(k), 0.02, &noise(k as u64 + 1, 600));
        let (loads, taken) = without_noise(&campaign(step, cell)).expect("there is noise");
        // Beside the step friction follows what the smooth course misses.
        assert!(taken.kept < 0.1, "{taken:?}");
        let load = loads[2].as_ref().expect("recorded");
        assert!((load[299] - 5.0).abs() < 0.1 && (load[300] - 8.0).abs() < 0.1);
        assert!(miss(load, &step(2)) < miss(&cell(2), &step(2)));
    }

    /// Beside runs whose cell scatters an eighth as much, what is noise here would be taken for steps.
    #[test]
    fn noise_that_grows_with_the_load_goes_in_every_run() {
        let load = |k: usize| if k == 3 { 8.0 } else { 1.0 };
        let real = |k: usize| course(k).into_iter().map(|n| load(k) * n).collect();
        let cell = |k: usize| plus(real(k), 0.02 * load(k), &noise(k as u64 + 1, 600));
        let (loads, taken) = without_noise(&campaign(real, cell)).expect("there is noise");
        assert_eq!(taken.kept, 0.0);
        for (k, load) in loads.iter().enumerate() {
            let load = load.as_ref().expect("recorded");
            assert!(miss(load, &real(k)) < 0.3 * miss(&cell(k), &real(k)), "{k}");
        }
    }

    /// Kept as recorded it would be a spike of friction.
    #[test]
    fn a_single_wild_reading_is_noise() {
        let cell = |k: usize| {
            let mut load = plus(course(k), 0.02, &noise(k as u64 + 1, 600));
            load[400] += 0.2;
            load
        };
        let (loads, taken) = without_noise(&campaign(course, cell)).expect("there is noise");
        assert_eq!(taken.kept, 0.0);
        for (k, load) in loads.iter().enumerate() {
            let load = load.as_ref().expect("recorded");
            assert!((load[400] - course(k)[400]).abs() < 0.03);
        }
    }

    #[test]
    fn a_load_without_noise_is_left_as_recorded() {
        assert!(without_noise(&campaign(course, |_| vec![5.0; 600])).is_none());
        let mut unrecorded = campaign(course, course);
        for run in &mut unrecorded.runs {
            run.normal_force_n = None;
        }
        assert!(without_noise(&unrecorded).is_none());
    }
}

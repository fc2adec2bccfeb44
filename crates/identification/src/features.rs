//! What the eye reads off a friction record before any fit: levels, the stretch before sliding, speeds.
//!
//! With y = F/N (or F where no load is known) and s = sgn(v), s y is positive for a healthy rig. A state that bends
//! exponentially with displacement, as every law here does at low speed, reaches half of its level mu after
//!
//! ```text
//! x_half = (mu / k) ln 2      from rest: mu (1 - exp(-k x/mu)) = mu/2
//!                             from a reversal: mu (1 - 2 exp(-k x/mu)) = 0
//! ```
//!
//! k being the slope dy/dx at the start: so both kinds of start give k = mu ln 2 / x_half.

use campaign::{Campaign, Run};

use crate::sliding::{SlidingCurve, sliding_curves};

/// Rough numbers of a campaign, for starts and scales only: no result depends on their precision.
#[derive(Clone, Debug, PartialEq)]
pub struct Features {
    /// Largest speed, m/s (rad/s).
    pub top_speed: f64,
    /// Median of s y at more than half of the top speed, forward; `None` without forward motion.
    pub forward: Option<f64>,
    /// The same in reverse.
    pub reverse: Option<f64>,
    /// Level between 5 and 20 % of the top speed over the level above half of it.
    pub slow_over_fast: f64,
    /// Slope of s y against |v| above half of the top speed, s/m, never below zero.
    pub viscous_slope: f64,
    /// Displacement from rest to half of the level, or from a reversal to zero force, m (rad).
    pub half_way: f64,
    /// Speed at that place, m/s (rad/s).
    pub half_way_speed: f64,
    /// Stribeck curves near the record where it slides, the nearest first; none where no speed but one is met.
    pub sliding: Vec<SlidingCurve>,
}

impl Features {
    /// Mean of the levels that exist.
    pub fn level(&self) -> f64 {
        match (self.forward, self.reverse) {
            (Some(f), Some(r)) => 0.5 * (f + r),
            (Some(one), None) | (None, Some(one)) => one,
            (None, None) => 0.0,
        }
    }

    /// Slope dy/dx at the start of a motion, k = level ln 2 / x_half.
    pub fn stiffness(&self) -> f64 {
        self.level() * std::f64::consts::LN_2 / self.half_way
    }
}

/// Times the way to half of the level after which a motion counts as sliding: 1 - 2^-5 of the level is reached.
const SLIDES_AFTER: f64 = 5.0;

/// One sample of a run in sliding terms.
struct Sample {
    speed: f64,
    forward: bool,
    resistance: f64,
}

/// Reads the features of a campaign.
pub fn features(campaign: &Campaign) -> Features {
    let loaded: Vec<&Run> = campaign
        .runs
        .iter()
        .filter(|run| run.protocol != campaign::Protocol::Unloaded)
        .collect();
    let top_speed = loaded
        .iter()
        .flat_map(|run| run.velocity_m_s.iter())
        .fold(0.0_f64, |top, v| top.max(v.abs()));
    let samples: Vec<Sample> = loaded.iter().flat_map(|run| samples(run)).collect();
    let level = |low: f64, high: f64, forward: Option<bool>| {
        median(
            samples
                .iter()
                .filter(|s| forward.is_none_or(|f| f == s.forward))
                .filter(|s| s.speed >= low * top_speed && s.speed <= high * top_speed)
                .map(|s| s.resistance)
                .collect(),
        )
    };
    let fast = level(0.5, 1.0, None).unwrap_or(0.0);
    let slow = level(0.05, 0.2, None).unwrap_or(fast);
    let viscous_slope = match (level(0.5, 0.7, None), level(0.8, 1.0, None)) {
        (Some(a), Some(b)) if top_speed > 0.0 => ((b - a) / (0.3 * top_speed)).max(0.0),
        _ => 0.0,
    };
    let mut crossings: Vec<(f64, f64)> = loaded
        .iter()
        .filter_map(|run| half_way(run, fast))
        .collect();
    crossings.sort_by(|a, b| a.0.total_cmp(&b.0));
    let travelled = loaded
        .iter()
        .map(|run| path(run))
        .fold(0.0_f64, f64::max)
        .max(f64::MIN_POSITIVE);
    let (half_way, half_way_speed) = crossings
        .get(crossings.len() / 2)
        .copied()
        .unwrap_or((0.01 * travelled, 0.1 * top_speed));
    let slid: Vec<(f64, f64)> = loaded
        .iter()
        .flat_map(|run| slid(run, SLIDES_AFTER * half_way))
        .collect();
    Features {
        sliding: sliding_curves(&slid, top_speed),
        top_speed,
        forward: level(0.5, 1.0, Some(true)),
        reverse: level(0.5, 1.0, Some(false)),
        slow_over_fast: if fast > 0.0 { slow / fast } else { 1.0 },
        viscous_slope,
        half_way,
        half_way_speed,
    }
}

/// y at every sample: F/N with the recorded load where there is one, else the nominal, else F itself.
pub(crate) fn coefficient(run: &Run) -> Vec<f64> {
    match (&run.normal_force_n, run.normal_load_n) {
        (Some(load), _) => run
            .force_n
            .iter()
            .zip(load)
            .map(|(f, n)| if *n > 0.0 { f / n } else { 0.0 })
            .collect(),
        (None, Some(load)) if load > 0.0 => run.force_n.iter().map(|f| f / load).collect(),
        _ => run.force_n.clone(),
    }
}

fn samples(run: &Run) -> Vec<Sample> {
    coefficient(run)
        .iter()
        .zip(&run.velocity_m_s)
        .map(|(y, v)| Sample {
            speed: v.abs(),
            forward: *v >= 0.0,
            resistance: y * v.signum(),
        })
        .collect()
}

/// Speed and resistance of a run's samples that lie more than `way` after its start or a change of sign.
fn slid(run: &Run, way: f64) -> Vec<(f64, f64)> {
    let mut travelled = 0.0;
    let mut far = Vec::new();
    for (i, sample) in samples(run).into_iter().enumerate() {
        if i > 0 {
            let (before, now) = (run.velocity_m_s[i - 1], run.velocity_m_s[i]);
            if before * now < 0.0 {
                travelled = 0.0;
            }
            travelled += step(run, i);
        }
        if travelled > way {
            far.push((sample.speed, sample.resistance));
        }
    }
    far
}

/// Length of the path from the sample before to the i-th one, by the trapezoid rule.
fn step(run: &Run, i: usize) -> f64 {
    let (t, v) = (&run.time_s, &run.velocity_m_s);
    0.5 * (t[i] - t[i - 1]) * (v[i - 1].abs() + v[i].abs())
}

/// Length of the path.
fn path(run: &Run) -> f64 {
    (1..run.time_s.len()).map(|i| step(run, i)).sum()
}

/// Displacement and speed at the first half-way crossing after the start from rest, or the median over reversals.
fn half_way(run: &Run, level: f64) -> Option<(f64, f64)> {
    let y = coefficient(run);
    let v = &run.velocity_m_s;
    let mut found: Vec<(f64, f64)> = Vec::new();
    let relaxed = run.initial_state == campaign::InitialState::Relaxed;
    // A stretch begins at rest (target: half of the level) or at a change of sign (target: zero).
    let mut target = relaxed.then_some(0.5 * level);
    let mut travelled = 0.0;
    for i in 1..v.len() {
        let reversed = v[i] * v[i - 1] < 0.0 || (v[i - 1] == 0.0 && v[i] != 0.0 && i > 1);
        if reversed && found.len() + 1 > usize::from(relaxed) {
            (travelled, target) = (0.0, Some(0.0));
        }
        travelled += step(run, i);
        if let Some(aim) = target
            && y[i] * v[i].signum() >= aim
            && v[i] != 0.0
        {
            found.push((travelled, v[i].abs()));
            target = None;
        }
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found.get(found.len() / 2).copied().filter(|c| c.0 > 0.0)
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

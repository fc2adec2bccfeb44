//! A campaign prepared for prediction: motions, loads and history of every run, and where its samples stand.

use std::ops::Range;

use campaign::{Axis, Campaign, Direction, InitialState, Protocol};
use friction::linear_stretches;

use crate::Scales;
use crate::bends::{bends, went_straight};
use crate::channel_noise::{ChannelNoise, without_noise};

/// Standard gravity, m/s^2 (exact by definition, 3rd CGPM 1901): turns a load that is a weight into a mass.
pub const GRAVITY_M_S2: f64 = 9.806_65;

/// A velocity record counts as linear where it stays within this share of its largest speed. Times written to 10
/// microseconds make a ramp of ten seconds crooked by half of it; such crookedness averages out over a few samples and
/// moves no prediction by more than the integration error.
const LINEAR_WITHIN: f64 = 1e-6;

/// Share of the largest speed by which a velocity must lie off its chords to be followed between samples.
const STRAIGHT_WITHIN: f64 = 2e-4;

/// Why a campaign cannot be predicted.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ExperimentError {
    /// Nothing ever moves.
    #[error("campaign `{0}`: no run moves, there is no friction to predict")]
    NoMotion(String),
}

/// One run, prepared. Linear rigs in m, m/s, N; rotary ones in rad, rad/s, N m.
#[derive(Clone, Debug, PartialEq)]
pub struct RunMotion {
    /// Name of the run, for captions.
    pub name: String,
    /// Its samples in the stacked record.
    pub samples: Range<usize>,
    /// Direction of the motion.
    pub direction: Direction,
    /// Kind of motion.
    pub protocol: Protocol,
    /// Time since the run's own zero, s.
    pub time_s: Vec<f64>,
    /// Stage velocity, m/s, without the noise of its channel (M2 to M4).
    pub velocity_m_s: Vec<f64>,
    /// dv/dt, m/s^2.
    pub acceleration_m_s2: Vec<f64>,
    /// Stage coordinate, m: as recorded, else the start position plus the integral of the velocity.
    pub position_m: Vec<f64>,
    /// Distance slid since the start of the run, m.
    pub distance_m: Vec<f64>,
    /// Normal load, N, without the noise of its cell (M2, M3); 1 throughout where the campaign has no load channel (then the law gives the
    /// force itself), 0 where there is no contact.
    pub load_n: Vec<f64>,
    /// Load that the run was set to, N; `None` without a load channel.
    pub nominal_load_n: Option<f64>,
    /// Temperature, degrees Celsius.
    pub temperature_c: Option<Vec<f64>>,
    /// Place in the day.
    pub order: Option<f64>,
    /// Start on the campaign's clock, counted from the start of the first run, s.
    pub started_s: Option<f64>,
    /// Rest before the run, s; `None` for the first run and without a clock.
    pub rest_s: Option<f64>,
    /// Distance slid in all runs before this one, m; `None` where the order is not known.
    pub prior_distance_m: Option<f64>,
    /// Direction of the last motion before this run: 1 forward, -1 in reverse, 0 for the first run and where the order is not
    /// known.
    pub heading_before: f64,
    /// Knots of the velocity (see [`friction::linear_stretches`]).
    pub knots: Vec<usize>,
    /// Second derivative of the velocity between samples, m/s^3, where it bends; empty where it nowhere does.
    pub(crate) bends_m_s3: Vec<f64>,
    /// The same motion at two steps a sample, where it bends.
    pub(crate) halved: Option<Box<RunMotion>>,
    /// All samples as knots.
    pub every_sample: Vec<usize>,
    /// Steps of this grid from one recorded sample to the next (1: the samples as recorded).
    pub steps_a_sample: usize,
    /// The rig was turned round.
    pub stage_turned: bool,
    /// The specimen was turned round.
    pub specimen_turned: bool,
    /// The state at the first sample is not known and belongs to the parameters.
    pub initial_state_unknown: bool,
    /// The first run with the same motion under the same load, bit for bit (the run itself where there is none before
    /// it): mechanics without history are computed once for both.
    pub twin: usize,
}

impl RunMotion {
    /// Number of samples.
    pub fn len(&self) -> usize {
        self.time_s.len()
    }

    /// Whether the run has no samples (never the case for a checked campaign).
    pub fn is_empty(&self) -> bool {
        self.time_s.is_empty()
    }

    /// Whether another run goes through the same motion under the same load from the same known state.
    fn repeats(&self, other: &Self) -> bool {
        !self.initial_state_unknown
            && !other.initial_state_unknown
            && self.specimen_turned == other.specimen_turned
            && self.nominal_load_n == other.nominal_load_n
            && self.velocity_m_s == other.velocity_m_s
            && self.time_s == other.time_s
            && self.load_n == other.load_n
    }

    /// Takes over what came before another run.
    pub fn take_past_of(&mut self, other: &Self) {
        self.started_s = other.started_s;
        self.rest_s = other.rest_s;
        self.prior_distance_m = other.prior_distance_m;
        self.heading_before = other.heading_before;
        if let Some(halved) = &mut self.halved {
            halved.take_past_of(other);
        }
    }

    /// Whether the run has contact.
    pub fn in_contact(&self) -> bool {
        self.load_n.iter().any(|&load| load > 0.0)
    }
}

/// A campaign prepared for prediction. Runs stand in the campaign's canonical order, which is the order in time
/// wherever that is known.
#[derive(Clone, Debug, PartialEq)]
pub struct Experiment {
    /// Name of the campaign.
    pub name: String,
    /// Linear or rotary.
    pub axis: Axis,
    /// The runs.
    pub runs: Vec<RunMotion>,
    /// Recorded force of all runs, one after the other, N (rotary N m).
    pub measured_n: Vec<f64>,
    /// What was taken from the recorded velocities and loads as noise of their channels.
    pub channel_noise: ChannelNoise,
    /// Whether loads are recorded: friction is a coefficient times the load. Else the law gives the force itself.
    pub has_load: bool,
    /// Whether the order of the runs is known.
    pub has_order: bool,
    /// Whether the campaign's clock is known.
    pub has_clock: bool,
    /// What the campaign's clock read when the first run began, s; 0 where it is not known or was not set for the campaign.
    pub first_start_s: f64,
    /// Gap h between body and substrate, m.
    pub height_m: Option<f64>,
    /// Mass that moves with the stage between contact and sensor, kg: force = friction + mass x acceleration.
    pub moving_mass_kg: f64,
    /// Geometric mean of the loads in contact, N: the load at which a coefficient is stated.
    pub reference_load_n: f64,
    /// Typical sizes of speed, travel and friction, for bounds and steps.
    pub scales: Scales,
    /// Bends of the velocity were taken out, see [`Experiment::along_chords`].
    goes_along_chords: bool,
}

/// Days of a campaign that its own clock may have run before the first run: one of the wall or of a computer has run for far more.
const OWN_CLOCK: f64 = 5.0;

impl Experiment {
    /// Prepares a campaign.
    ///
    /// # Errors
    /// A campaign in which nothing moves.
    pub fn new(campaign: &Campaign) -> Result<Self, ExperimentError> {
        let (campaign, channel_noise) = without_noise(campaign);
        let fastest = campaign
            .runs
            .iter()
            .flat_map(|run| &run.velocity_m_s)
            .fold(0.0_f64, |a, v| a.max(v.abs()));
        if fastest == 0.0 {
            return Err(ExperimentError::NoMotion(campaign.name.clone()));
        }
        let has_load = campaign.runs.iter().all(|run| {
            run.protocol == Protocol::Unloaded
                || run.normal_load_n.is_some()
                || run.normal_force_n.is_some()
        });
        let has_order = campaign.runs.len() == 1
            || campaign
                .runs
                .iter()
                .all(|run| run.order.is_some() || run.started_s.is_some());
        let has_clock = campaign.runs.iter().all(|run| run.started_s.is_some());
        let clock_zero = campaign
            .runs
            .iter()
            .filter_map(|run| run.started_s)
            .fold(f64::INFINITY, f64::min);
        let mut runs: Vec<RunMotion> = Vec::with_capacity(campaign.runs.len());
        let mut measured_n = Vec::new();
        let (mut slid, mut ended, mut heading) = (0.0, None, 0.0);
        let mut leaders: Vec<usize> = Vec::new();
        for run in &campaign.runs {
            let first = measured_n.len();
            measured_n.extend_from_slice(&run.force_n);
            let started_s = if has_clock {
                run.started_s.map(|s| s - clock_zero)
            } else {
                None
            };
            let mut motion = prepare(run, has_load, fastest);
            motion.samples = first..measured_n.len();
            motion.started_s = started_s;
            motion.rest_s = match (started_s, ended) {
                (Some(start), Some(end)) => Some(f64::max(start - end, 0.0)),
                _ => None,
            };
            motion.prior_distance_m = has_order.then_some(slid);
            motion.heading_before = if has_order { heading } else { 0.0 };
            if let Some(mut halved) = motion.halved.take() {
                halved.take_past_of(&motion);
                motion.halved = Some(halved);
            }
            let moving = run.velocity_m_s.iter().rev().find(|v| **v != 0.0);
            heading = moving.map_or(heading, |v| v.signum());
            if motion.in_contact() {
                slid += motion.distance_m.last().copied().unwrap_or(0.0);
            }
            ended = started_s.map(|start| start + run.time_s.last().copied().unwrap_or(0.0));
            motion.twin = leaders
                .iter()
                .copied()
                .find(|&k| runs[k].repeats(&motion))
                .unwrap_or_else(|| {
                    leaders.push(runs.len());
                    runs.len()
                });
            runs.push(motion);
        }
        let first_start_s = if ended.is_some_and(|day_s| clock_zero.abs() <= OWN_CLOCK * day_s) {
            clock_zero
        } else {
            0.0
        };
        let reference_load_n = reference_load(&runs);
        let scales = Scales::of(&runs, &measured_n, campaign.specimen.contact_height_m);
        Ok(Self {
            name: campaign.name.clone(),
            axis: campaign.axis,
            runs,
            measured_n,
            channel_noise,
            has_load,
            has_order,
            has_clock,
            first_start_s,
            height_m: campaign.specimen.contact_height_m,
            moving_mass_kg: campaign.rig.moving_mass_kg.unwrap_or(0.0),
            reference_load_n,
            scales,
            goes_along_chords: false,
        })
    }

    /// The same campaign, were its motions straight between the samples; `None` where no recorded velocity bends, see (M1).
    pub fn along_chords(&self) -> Option<Self> {
        let bends = self.runs.iter().any(|run| run.halved.is_some());
        bends.then(|| {
            let mut straight = self.clone();
            straight.goes_along_chords = true;
            for run in &mut straight.runs {
                run.bends_m_s3.clear();
                run.halved = None;
            }
            straight
        })
    }

    /// The campaign along chords where another one was taken along them. (That nothing bends there at its own rate says nothing of this one.)
    pub fn moving_as(self, other: &Self) -> Self {
        match other.goes_along_chords {
            true => self.along_chords().unwrap_or(self),
            false => self,
        }
    }

    /// Number of samples of all runs.
    pub fn samples(&self) -> usize {
        self.measured_n.len()
    }

    /// Whether runs have at least two loads that differ by more than a tenth.
    pub fn has_two_loads(&self) -> bool {
        let loads = self.loads();
        let low = loads.iter().copied().fold(f64::INFINITY, f64::min);
        let high = loads.iter().copied().fold(0.0, f64::max);
        high > 1.1 * low
    }

    /// Whether rests before runs differ by more than a factor of two.
    pub fn has_two_rests(&self) -> bool {
        let rests = || self.runs.iter().filter_map(|run| run.rest_s);
        let shortest = rests().fold(f64::INFINITY, f64::min);
        rests().fold(0.0, f64::max) > 2.0 * shortest
    }

    /// Mean load of every run in contact, N.
    fn loads(&self) -> Vec<f64> {
        self.runs
            .iter()
            .filter(|run| run.in_contact())
            .map(mean_load)
            .collect()
    }

    /// Whether some run moves forward and some run moves in reverse.
    pub fn has_both_directions(&self) -> bool {
        let moves = |sign: f64| {
            self.runs
                .iter()
                .any(|run| run.velocity_m_s.iter().any(|v| v * sign > 0.0))
        };
        moves(1.0) && moves(-1.0)
    }

    /// Whether some run reverses.
    pub fn has_reversals(&self) -> bool {
        self.runs.iter().any(|run| {
            run.velocity_m_s.iter().any(|&v| v > 0.0) && run.velocity_m_s.iter().any(|&v| v < 0.0)
        })
    }
}

fn mean_load(run: &RunMotion) -> f64 {
    run.load_n.iter().sum::<f64>() / run.len() as f64
}

fn reference_load(runs: &[RunMotion]) -> f64 {
    let logs: Vec<f64> = runs
        .iter()
        .map(mean_load)
        .filter(|&load| load > 0.0)
        .map(f64::ln)
        .collect();
    if logs.is_empty() {
        1.0
    } else {
        (logs.iter().sum::<f64>() / logs.len() as f64).exp()
    }
}

/// One run without its place among the others.
fn prepare(run: &campaign::Run, has_load: bool, fastest: f64) -> RunMotion {
    let n = run.time_s.len();
    let (t, v) = (&run.time_s, &run.velocity_m_s);
    let mut distance_m = vec![0.0; n];
    let mut travelled = vec![0.0; n];
    for i in 1..n {
        let dt = t[i] - t[i - 1];
        travelled[i] = travelled[i - 1] + 0.5 * (v[i] + v[i - 1]) * dt;
        distance_m[i] = distance_m[i - 1] + path_length(v[i - 1], v[i], dt);
    }
    let position_m = match &run.position_m {
        Some(position) => position.clone(),
        None => travelled.iter().map(|x| run.start_position_m + x).collect(),
    };
    let load_n = if !has_load {
        let contact = if run.protocol == Protocol::Unloaded {
            0.0
        } else {
            1.0
        };
        vec![contact; n]
    } else if run.protocol == Protocol::Unloaded {
        vec![0.0; n]
    } else {
        match &run.normal_force_n {
            Some(force) => force.clone(),
            None => vec![run.normal_load_n.unwrap_or(0.0); n],
        }
    };
    let linear_within = LINEAR_WITHIN * fastest;
    let bends_m_s3 = bends(t, v, STRAIGHT_WITHIN * fastest);
    let recorded = run.position_m.as_ref();
    let is_bent = bends_m_s3.iter().any(|c| *c != 0.0)
        && !recorded.is_some_and(|x| went_straight(x, t, v, &bends_m_s3));
    let mut motion = RunMotion {
        name: run.name.clone(),
        samples: 0..0,
        direction: run.direction,
        protocol: run.protocol,
        time_s: t.clone(),
        velocity_m_s: v.clone(),
        acceleration_m_s2: crate::signal::slope(t, v),
        steps_a_sample: 1,
        position_m,
        distance_m,
        load_n,
        nominal_load_n: if has_load {
            run.normal_load_n.or(Some(0.0))
        } else {
            None
        },
        temperature_c: run.temperature_c.clone(),
        order: run.order,
        started_s: None,
        rest_s: None,
        prior_distance_m: None,
        heading_before: 0.0,
        knots: linear_stretches(t, v, linear_within),
        bends_m_s3: if is_bent { bends_m_s3 } else { Vec::new() },
        halved: None,
        every_sample: (0..n).collect(),
        stage_turned: run.stage_turned,
        specimen_turned: run.specimen_turned,
        initial_state_unknown: run.initial_state == InitialState::Unknown,
        twin: 0,
    };
    if is_bent {
        let mut halved = motion.refined(2);
        halved.knots = linear_stretches(&halved.time_s, &halved.velocity_m_s, linear_within);
        motion.halved = Some(Box::new(halved));
    }
    motion
}

/// Integral of abs(v) over a step with linear v.
fn path_length(v0: f64, v1: f64, dt: f64) -> f64 {
    if v0 * v1 >= 0.0 {
        0.5 * (v0 + v1).abs() * dt
    } else {
        0.5 * (v0 * v0 + v1 * v1) / (v0 - v1).abs() * dt
    }
}

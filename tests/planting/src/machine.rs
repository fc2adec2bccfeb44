//! The rig as a machine: a day of runs, each integrated in time and sampled by the logger.
//!
//! The equations stand in `contact`; here are what passes from run to run (sliding, heat, bend), the random parts of a
//! day, the sampling and the electronics. The integration is far finer than the record.

use crate::contact::{Contact, History, Layout, Rocking};
use crate::effect::{Effect, Opens, Remembers, Settling};
use crate::integrator::Integrator;
use crate::law::Law;
use crate::motion::{Motion, Play};
use crate::plan::{Noise, Plan, RunPlan};
use crate::play::held_after_turns;
use crate::roughness::{Field, Grain, Tails, stream};

/// Standard gravity, m/s^2 (CGPM 1901, exact).
pub const STANDARD_GRAVITY_M_S2: f64 = 9.806_65;

/// What a healthy or unhealthy rig is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct Rig {
    /// The law of friction.
    pub law: Law,
    /// What is wrong with it.
    pub effects: Vec<Effect>,
    /// Load at which the law's coefficients hold, N.
    pub reference_load_n: f64,
}

/// What the logger wrote. SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// Sample times, s.
    pub time_s: Vec<f64>,
    /// Velocity channel, m/s.
    pub velocity_m_s: Vec<f64>,
    /// Stage coordinate, m.
    pub position_m: Vec<f64>,
    /// Force channel, N.
    pub force_n: Vec<f64>,
    /// Load channel, N; `None` where no load is recorded.
    pub load_n: Option<Vec<f64>>,
}

/// Runs the whole day and returns what the logger wrote, one recording a run.
pub fn run_day(rig: &Rig, plan: &Plan, noise: &Noise, seed: u64) -> Vec<Recording> {
    let reach = plan.travel_m.max(0.05);
    let plate_field = Field::new(
        -0.2 * reach,
        1.2 * reach,
        noise.correlation_m,
        (noise.grain, noise.tails),
        &mut stream(seed, 0),
    );
    let mut history = History::default();
    let mut recordings = Vec::new();
    for (index, run) in plan.runs.iter().enumerate() {
        rest_before(rig, run, &mut history);
        recordings.push(record_run(
            &with_its_specimen(rig, index),
            plan,
            run,
            index,
            noise,
            seed,
            &plate_field,
            &mut history,
        ));
    }
    read_velocities(&mut recordings, noise, seed);
    recordings
}

/// What an encoder with noise says of a stage that moves as it was told.
fn read_velocities(recordings: &mut [Recording], noise: &Noise, seed: u64) {
    if noise.encoder == 0.0 {
        return;
    }
    let speeds = recordings.iter().flat_map(|r| &r.velocity_m_s);
    let sd = noise.encoder * speeds.fold(0.0_f64, |a, v| a.max(v.abs()));
    for (index, recording) in (1_u64..).zip(recordings) {
        let mut generator = stream(seed, 16 * index + 7);
        let moving = recording.velocity_m_s.iter_mut().filter(|v| **v != 0.0);
        moving.for_each(|v| *v += sd * Tails::Normal.draw(&mut generator));
    }
}

/// The rig with the specimen of a run.
fn with_its_specimen(rig: &Rig, index: usize) -> Rig {
    let mut rig = rig.clone();
    for effect in &rig.effects {
        if let Effect::OtherSpecimen {
            stiffness_minus_1,
            level_minus_1,
            runs,
        } = *effect
            && runs.contains(&index)
        {
            rig.law = (rig.law).of_another_specimen(stiffness_minus_1, level_minus_1);
        }
    }
    rig
}

/// What time does to the specimen between two runs: it cools.
fn rest_before(rig: &Rig, run: &RunPlan, history: &mut History) {
    let rest_s = history
        .ended_s
        .map_or(0.0, |end| (run.started_s - end).max(0.0));
    for effect in &rig.effects {
        if let Effect::ThermalSoftening {
            time_constant_s, ..
        } = effect
        {
            history.heat_j *= (-rest_s / time_constant_s).exp();
        }
    }
}

/// What a run does to the specimen: reverse sliding bends the bristles lastingly, forward sliding straightens them or leaves the bend. A specimen
/// that was turned round is slid the other way; one that touches nothing stays as it is.
fn bend_after(rig: &Rig, run: &RunPlan, history: &mut History) {
    if run.load_n == Some(0.0) {
        return;
    }
    for effect in &rig.effects {
        if let Effect::BristleSet {
            angle_rad,
            runs,
            settling,
        } = effect
        {
            let share = match settling {
                Settling::ByRuns | Settling::Kept => 1.0 - (-1.0 / runs).exp(),
                Settling::LostWithTheWay(_) => 1.0,
                Settling::WithTheWay(_) => 0.0,
            };
            let kept = *settling != Settling::ByRuns;
            let direction = match settling {
                Settling::LostWithTheWay(_) => last_way(run),
                _ => run.direction,
            };
            let goal = match (direction, run.specimen_turned) {
                ("reverse", false) | ("forward", true) => *angle_rad,
                ("forward", false) | ("reverse", true) if !kept => 0.0,
                _ => history.bend_rad,
            };
            history.bend_rad += (goal - history.bend_rad) * share;
        }
    }
}

/// The way in which a run ends.
fn last_way(run: &RunPlan) -> &'static str {
    let last = run.motion.speed(0.999 * run.motion.duration_s());
    if last < 0.0 { "reverse" } else { "forward" }
}

#[allow(clippy::too_many_arguments)]
fn record_run(
    rig: &Rig,
    plan: &Plan,
    run: &RunPlan,
    index: usize,
    noise: &Noise,
    seed: u64,
    plate_field: &Field,
    history: &mut History,
) -> Recording {
    let purpose = 16 * (index as u64 + 1);
    let layout = Layout::of(&rig.effects);
    let path_m = run.motion.breakpoints().windows(2).fold(0.0, |sum, pair| {
        sum + (run.motion.position(pair[1]) - run.motion.position(pair[0])).abs()
    });
    let plate_motion = behind_play(rig, run, history);
    let mut contact = Contact {
        rig,
        plan: run,
        plate_motion,
        layout,
        history: *history,
        noise,
        plate_field,
        run_field: Field::new(
            0.0,
            path_m * 1.3 + 0.01,
            noise.correlation_m,
            (noise.grain, noise.tails),
            &mut stream(seed, purpose + 1),
        ),
        debris_field: debris_field(rig, path_m, seed, purpose + 2),
        friction_factor: 1.0 + noise.scatter * Tails::Normal.draw(&mut stream(seed, purpose + 3)),
        index,
        rocking: rocking(rig, run, index, seed, purpose + 4),
        load_n: run.load_n.unwrap_or(1.0),
        rest_s: rest_before_s(plan, index),
        known_mass_kg: plan.moving_mass_kg.unwrap_or(0.0),
        half_sample_s: 0.5 / plan.sample_rate_hz,
        inside_s: 0.0,
    };
    let mut recording = integrate(&mut contact, plan, history);
    bend_after(rig, run, history);
    wander(noise, &mut recording, seed, purpose + 8);
    spoil_reading(rig, noise, &mut recording.force_n, seed, purpose + 5);
    recording.load_n = read_load(run, noise, recording.time_s.len(), seed, purpose + 6);
    recording
}

/// What a cell with noise says of the load, which stays as it was set.
fn read_load(
    run: &RunPlan,
    noise: &Noise,
    samples: usize,
    seed: u64,
    purpose: u64,
) -> Option<Vec<f64>> {
    let load_n = run.load_n.filter(|_| noise.load_cell > 0.0)?;
    let mut generator = stream(seed, purpose);
    let mut read = || load_n * (1.0 + noise.load_cell * Tails::Normal.draw(&mut generator));
    Some((0..samples).map(|_| read()).collect())
}

/// The motion of a run behind the rig's play, if it has one.
fn behind_play(rig: &Rig, run: &RunPlan, history: &mut History) -> Motion {
    let play = rig.effects.iter().find_map(|effect| match effect {
        Effect::Backlash { gap_m, opens } => Some((*gap_m, *opens)),
        _ => None,
    });
    let (motion, mut fresh) = (&run.motion, Play::default());
    match play {
        None => motion.clone(),
        Some((gap_m, Opens::WhereItTurns)) => motion.behind_play(gap_m, &[], &mut fresh),
        Some((gap_m, Opens::FromRunToRun)) => motion.behind_play(gap_m, &[], &mut history.play),
        Some((gap_m, Opens::WithoutForce)) => {
            let held = held_after_turns(&rig.law, motion, gap_m);
            motion.behind_play(gap_m, &held, &mut fresh)
        }
    }
}

/// Rest before a run, s; before the first run the specimen rested as long as it usually does between runs.
fn rest_before_s(plan: &Plan, index: usize) -> f64 {
    let mut rests: Vec<f64> = plan
        .runs
        .windows(2)
        .map(|pair| pair[1].started_s - pair[0].started_s - pair[0].motion.duration_s())
        .collect();
    match index {
        0 => {
            rests.sort_by(f64::total_cmp);
            rests.get(rests.len() / 2).copied().unwrap_or(1.0)
        }
        _ => rests[index - 1],
    }
}

fn debris_field(rig: &Rig, path_m: f64, seed: u64, purpose: u64) -> Field {
    let interval = rig
        .effects
        .iter()
        .find_map(|effect| match effect {
            Effect::Debris { interval_m, .. } => Some(*interval_m),
            _ => None,
        })
        .unwrap_or(1.0);
    Field::new(
        0.0,
        path_m * 1.3 + 0.01,
        interval,
        (Grain::Rough, Tails::Normal),
        &mut stream(seed, purpose),
    )
}

fn rocking(rig: &Rig, run: &RunPlan, index: usize, seed: u64, purpose: u64) -> Rocking {
    let mut rocking = Rocking::default();
    let mut generator = stream(seed, purpose);
    for effect in &rig.effects {
        if let Effect::LooseClamp {
            rock_rad,
            mean_dwell_s,
            from_run,
        } = effect
        {
            rocking.rock_rad = *rock_rad;
            let mut moment = 0.0;
            while index >= *from_run && moment < run.motion.duration_s() {
                let draw: f64 = rand_distr::Distribution::sample(&rand_distr::Exp1, &mut generator);
                moment += mean_dwell_s * (0.2 + 0.8 * draw);
                rocking.moments_s.push(moment);
            }
        }
    }
    rocking
}

/// Integrates the run and samples its channels.
fn integrate(contact: &mut Contact<'_>, plan: &Plan, history: &mut History) -> Recording {
    let run = contact.plan;
    let layout = contact.layout;
    let samples = (run.motion.duration_s() * plan.sample_rate_hz).round() as usize + 1;
    let times: Vec<f64> = (0..samples)
        .map(|i| i as f64 / plan.sample_rate_hz)
        .collect();
    let delay_s = contact
        .rig
        .effects
        .iter()
        .find_map(|effect| match effect {
            Effect::ClockOffset { delay_s } => Some(*delay_s),
            _ => None,
        })
        .unwrap_or(0.0);

    let mut state = vec![0.0; layout.size];
    if let Some(place) = layout.heat {
        state[place] = history.heat_j;
    }
    if let Some((place, _)) = layout.bend {
        state[place] = history.bend_rad;
    }
    if run.starts_bent {
        let heading = run.motion.speed(run.motion.duration_s() * 0.1).signum();
        state[0] = -0.6 * contact.rig.law.state_scale() * heading;
    }
    if let Some((place, _)) = layout.velocity {
        state[place] = run.motion.speed(0.0);
        state[place + 1] = run.motion.speed(0.0);
    }
    if let Some(place) = layout.memory {
        let of_magnitude = |effect: &Effect| {
            matches!(
                effect,
                Effect::FrictionalMemory {
                    remembers: Remembers::Magnitude,
                    ..
                }
            )
        };
        let first = run.motion.speed(0.0);
        let unsigned = contact.rig.effects.iter().any(of_magnitude);
        state[place] = if unsigned { first.abs() } else { first };
    }
    if let Some((place, _)) = layout.sensor {
        let resting = contact.sensed(0.0, &state, &contact.instant(0.0, &state));
        state[place] = resting;
        state[place + 1] = resting;
    }

    let mut integrator = integrator_for(contact);
    let outputs: Vec<f64> = times.iter().map(|t| (t - delay_s).max(0.0)).collect();
    let stops = stops(contact, &outputs);
    let mut force = vec![0.0; samples];
    let mut velocity: Vec<f64> = times.iter().map(|t| run.motion.speed(*t)).collect();
    let mut now = 0.0;
    contact.inside_s = stops.first().map_or(0.0, |stop| 0.5 * stop);
    let mut next = 0;
    for stop in std::iter::once(0.0).chain(stops) {
        if stop > now {
            contact.inside_s = 0.5 * (now + stop);
            integrator.advance(&*contact, &mut state, now, stop);
            now = stop;
        }
        while next < samples && outputs[next] <= now {
            force[next] = reading(contact, now, &state);
            if let (Some((place, _)), true) = (layout.velocity, delay_s == 0.0) {
                velocity[next] = state[place + 1];
            }
            next += 1;
        }
    }
    history.slid_m += if run.load_n == Some(0.0) {
        0.0
    } else {
        state[1]
    };
    history.heat_j = layout.heat.map_or(0.0, |place| state[place]);
    if let Some((place, _)) = layout.bend {
        history.bend_rad = state[place];
    }
    history.ended_s = Some(run.started_s + now);
    let position_m = times
        .iter()
        .map(|t| run.start_position_m + run.motion.position(*t))
        .collect();
    Recording {
        time_s: times,
        velocity_m_s: velocity,
        position_m,
        force_n: force,
        load_n: None,
    }
}

fn integrator_for(contact: &Contact<'_>) -> Integrator {
    let layout = contact.layout;
    let mut absolute = vec![1e-10; layout.size];
    absolute[0] = 1e-10 * contact.rig.law.state_scale();
    if let Some(place) = layout.stretch {
        absolute[place] = 1e-12;
        absolute[place + 1] = 1e-9;
    }
    // A feature of the plate must not be stepped over: a twentieth of a second is 3 mm at full speed.
    Integrator::new(1e-9, absolute, 0.02)
}

/// Times at which the integration stops: samples, breakpoints of the motion, sudden events.
fn stops(contact: &Contact<'_>, outputs: &[f64]) -> Vec<f64> {
    let last = outputs.last().copied().unwrap_or(0.0);
    let mut stops: Vec<f64> = outputs.to_vec();
    stops.extend(contact.plan.motion.breakpoints());
    stops.extend(contact.plate_motion.breakpoints());
    stops.extend(&contact.rocking.moments_s);
    stops.retain(|time| *time > 0.0 && *time <= last);
    stops.sort_by(f64::total_cmp);
    stops.dedup();
    stops
}

/// Force channel at this instant, before noise.
fn reading(contact: &Contact<'_>, time_s: f64, state: &[f64]) -> f64 {
    let force_n = match contact.layout.sensor {
        Some((place, _)) => state[place + 1],
        None => contact.sensed(time_s, state, &contact.instant(time_s, state)),
    };
    force_n * amplified(contact, time_s)
}

/// Share of the force that an amplifier that drops out still shows.
fn amplified(contact: &Contact<'_>, time_s: f64) -> f64 {
    let mut amplified = 1.0;
    for effect in &contact.rig.effects {
        if let Effect::Dropout {
            share,
            from_s,
            to_s,
            first_run,
            every,
        } = *effect
            && contact.is_one_of(first_run, every)
            && time_s >= from_s
            && time_s < to_s
        {
            amplified *= 1.0 - share;
        }
    }
    amplified
}

/// Adds what the amplifier's zero wanders by: drawn back to nothing at a steady rate, and pushed at random all the while.
fn wander(noise: &Noise, recording: &mut Recording, seed: u64, purpose: u64) {
    if noise.wander_n == 0.0 {
        return;
    }
    let mut generator = stream(seed, purpose);
    let mut push = |size: f64| size * Tails::Normal.draw(&mut generator);
    let mut zero_n = push(noise.wander_n);
    let mut before_s = recording.time_s.first().copied().unwrap_or_default();
    for (force, &time_s) in recording.force_n.iter_mut().zip(&recording.time_s) {
        let left = (-(time_s - before_s) / noise.wander_s).exp();
        zero_n = left * zero_n + push(noise.wander_n * (1.0 - left * left).sqrt());
        before_s = time_s;
        *force += zero_n;
    }
}

/// What the electronics do to the reading: gain, noise, clipping, rounding.
fn spoil_reading(rig: &Rig, noise: &Noise, force_n: &mut [f64], seed: u64, purpose: u64) {
    let mut generator = stream(seed, purpose);
    for force in force_n {
        let mut value = *force;
        for effect in &rig.effects {
            if let Effect::ForceGain { gain_minus_1 } = effect {
                value *= 1.0 + gain_minus_1;
            }
        }
        value += noise.sensor_n * noise.tails.draw(&mut generator);
        for effect in &rig.effects {
            match *effect {
                Effect::ForceSaturation { level_n } => value = value.clamp(-level_n, level_n),
                Effect::ForceResolution { step_n } => value = (value / step_n).round() * step_n,
                _ => {}
            }
        }
        *force = value;
    }
}

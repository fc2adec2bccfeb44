//! The contact and everything that acts on it: the equations of motion of one run.
//!
//! Chain of motion: command -> drive (ripple) -> play -> plate; the brush slides on the plate at
//! v_slip = v_plate - v_brush, where the brush rests or hangs on a cord. Chain of force: friction (law x surface x
//! history x load) -> cord tension -> sensor (filter, offsets). All of it is one system of ordinary differential
//! equations.

use crate::effect::{Ageing, Clock, Course, Effect, Filter, Remembers, Settling};
use crate::integrator::Dynamics;
use crate::law::{Law, Surroundings};
use crate::machine::{Rig, STANDARD_GRAVITY_M_S2};
use crate::motion::{Motion, Play};
use crate::plan::{Noise, RunPlan};
use crate::roughness::Field;

/// What the day has left behind in the specimen before a run.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct History {
    pub(crate) slid_m: f64,
    pub(crate) heat_j: f64,
    pub(crate) bend_rad: f64,
    pub(crate) ended_s: Option<f64>,
    /// Direction in which the play is taken up, and what of it is not.
    pub(crate) play: Play,
}

/// Places of the optional states in the vector: inner state and slip distance come first.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Layout {
    pub(crate) size: usize,
    pub(crate) stage: usize,
    pub(crate) stretch: Option<usize>,
    pub(crate) sensor: Option<(usize, bool)>,
    pub(crate) velocity: Option<(usize, bool)>,
    pub(crate) memory: Option<usize>,
    pub(crate) heat: Option<usize>,
    pub(crate) second: Option<usize>,
    /// The bend, where it settles within runs, and how.
    pub(crate) bend: Option<(usize, Bend)>,
}

/// How a bend settles within runs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bend {
    /// Where sliding in reverse leads, rad.
    in_reverse_rad: f64,
    /// Over which distance, m.
    distance_m: f64,
}

impl Layout {
    pub(crate) fn of(effects: &[Effect]) -> Self {
        let mut layout = Self {
            size: 3,
            stage: 2,
            ..Self::default()
        };
        let mut take = |count: usize| {
            let place = layout.size;
            layout.size += count;
            place
        };
        for effect in effects {
            match effect {
                Effect::CordCompliance { .. } => layout.stretch = Some(take(2)),
                Effect::SensorLag { filter, .. } => {
                    layout.sensor = Some((take(2), *filter == Filter::SecondOrder))
                }
                Effect::VelocityLag { filter, .. } => {
                    layout.velocity = Some((take(2), *filter == Filter::SecondOrder));
                }
                Effect::FrictionalMemory { .. } => layout.memory = Some(take(1)),
                Effect::ThermalSoftening { .. } => layout.heat = Some(take(1)),
                Effect::BristleSet {
                    angle_rad,
                    settling,
                    ..
                } => {
                    let bend = match *settling {
                        Settling::ByRuns | Settling::Kept => None,
                        Settling::WithTheWay(distance_m) => Some((*angle_rad, distance_m)),
                        Settling::LostWithTheWay(distance_m) => Some((0.0, distance_m)),
                    };
                    layout.bend = bend.map(|(in_reverse_rad, distance_m)| {
                        let bend = Bend {
                            in_reverse_rad,
                            distance_m,
                        };
                        (take(1), bend)
                    });
                }
                Effect::SecondPopulation { .. } => layout.second = Some(take(1)),
                _ => {}
            }
        }
        layout
    }
}

/// Random moments at which a loose fixture rocks: leans alternate between 0 and `rock_rad`.
#[derive(Clone, Debug, Default)]
pub(crate) struct Rocking {
    pub(crate) moments_s: Vec<f64>,
    pub(crate) rock_rad: f64,
}

impl Rocking {
    pub(crate) fn lean_at(&self, time_s: f64) -> f64 {
        let switches = self.moments_s.partition_point(|moment| *moment <= time_s);
        if switches % 2 == 1 {
            self.rock_rad
        } else {
            0.0
        }
    }
}

/// One run in progress.
pub(crate) struct Contact<'a> {
    pub(crate) rig: &'a Rig,
    pub(crate) plan: &'a RunPlan,
    pub(crate) plate_motion: Motion,
    pub(crate) layout: Layout,
    pub(crate) history: History,
    pub(crate) noise: &'a Noise,
    pub(crate) plate_field: &'a Field,
    pub(crate) run_field: Field,
    pub(crate) debris_field: Field,
    pub(crate) friction_factor: f64,
    pub(crate) index: usize,
    pub(crate) rocking: Rocking,
    pub(crate) load_n: f64,
    /// Rest before the run, s.
    pub(crate) rest_s: f64,
    /// Moving mass that the experimenter knows, kg.
    pub(crate) known_mass_kg: f64,
    /// Half the time between samples, s: over it the stage changes its acceleration.
    pub(crate) half_sample_s: f64,
    /// A time within the interval being integrated: picks the side of a jump in speed.
    pub(crate) inside_s: f64,
}

/// What the contact does at one instant.
pub(crate) struct Instant {
    pub(crate) inner_rate: f64,
    pub(crate) second_rate: f64,
    pub(crate) slip_speed: f64,
    pub(crate) friction_n: f64,
    pub(crate) remembered_rate: f64,
}

impl Contact<'_> {
    /// Whether the run is the first of those concerned or one of every so many after it.
    pub(crate) fn is_one_of(&self, first_run: usize, every: usize) -> bool {
        let later = self.index.checked_sub(first_run);
        later.is_some_and(|runs| runs.is_multiple_of(every))
    }

    /// Factor of the drive's ripple on the commanded speed; `stage_m` counts from the start of the run, the ripple from
    /// the drive's own zero.
    fn ripple(&self, stage_m: f64) -> f64 {
        let mut factor = 1.0;
        for effect in &self.rig.effects {
            if let Effect::StageRipple {
                amplitude,
                pitch_m,
                phase_rad,
                wave,
            } = effect
            {
                factor += amplitude
                    * wave.at(
                        std::f64::consts::TAU * (self.plan.start_position_m + stage_m) / pitch_m
                            + phase_rad,
                    );
            }
        }
        factor
    }

    /// Commanded speed with ripple, before the play (what an encoder on the motor would see).
    fn plate_speed(&self, time_s: f64, stage_m: f64) -> f64 {
        self.plate_motion.speed_within(time_s, self.inside_s) * self.ripple(stage_m)
    }

    /// Everything that changes the law itself at this instant.
    fn surroundings(&self, time_s: f64, state: &[f64]) -> Surroundings {
        let slid_m = state[1];
        let remembered = self.layout.memory.map(|place| state[place]);
        // A specimen that was turned round meets the plate the other way.
        let turn = if self.plan.specimen_turned { -1.0 } else { 1.0 };
        let bend = self.layout.bend.map(|(place, _)| state[place]);
        let mut around = Surroundings {
            remembered_speed: remembered,
            ..Surroundings::PLAIN
        };
        around.lean_rad = bend.unwrap_or(self.history.bend_rad) + self.rocking.lean_at(time_s);
        for effect in &self.rig.effects {
            match *effect {
                Effect::StribeckShape { exponent_minus_2 } => {
                    around.exponent_minus_2 += exponent_minus_2
                }
                Effect::LeanAngle { angle_rad } => around.lean_rad += angle_rad,
                Effect::FrictionalMemory {
                    remembers: Remembers::ViscousToo,
                    ..
                } => around.viscous_speed = remembered.map(|speed| turn * speed),
                Effect::DirectionAsymmetry {
                    coulomb_ratio_minus_1,
                    viscous_ratio_minus_1,
                    jumps,
                } => {
                    around.jumps = jumps;
                    around.reverse_factors =
                        (1.0 + coulomb_ratio_minus_1, 1.0 + viscous_ratio_minus_1);
                }
                Effect::DwellAgeing { per_decade, ends } => {
                    // Decades of rest over one second.
                    let rest_s = self.rest_s.max(1.0);
                    let left = match ends {
                        Ageing::WithTheRun => 1.0,
                        Ageing::InTurning if self.inside_s < self.plan.motion.turns_at_s() => 1.0,
                        Ageing::InTurning => 0.0,
                        Ageing::Fading(length_m) | Ageing::Grown(length_m) => {
                            (-slid_m / length_m).exp()
                        }
                    };
                    let factor = match ends {
                        Ageing::Grown(_) => &mut around.grown_factor,
                        _ => &mut around.breakaway_factor,
                    };
                    *factor *= 1.0 + per_decade * rest_s.log10() * left;
                }
                _ => {}
            }
        }
        around
    }

    /// What is added to the coefficient at a slip speed: q v^2 with the sign of v.
    fn added_strengthening(&self, slip_speed: f64) -> f64 {
        let of = |effect: &Effect| match *effect {
            Effect::VelocityStrengthening {
                quadratic_s2_m2,
                added: true,
                cubic_from_m_s,
            } => growth(quadratic_s2_m2, cubic_from_m_s, slip_speed.abs()) * slip_speed.signum(),
            _ => 0.0,
        };
        self.rig.effects.iter().map(of).sum()
    }

    /// Factor on friction from surface, history, speed and load, at a place of the plate.
    pub(crate) fn factor(
        &self,
        time_s: f64,
        slip_speed: f64,
        slid_m: f64,
        plate_m: f64,
        heat_j: f64,
    ) -> f64 {
        let tau = std::f64::consts::TAU;
        let mut factor = 1.0;
        for effect in &self.rig.effects {
            factor *= match *effect {
                Effect::VelocityStrengthening {
                    quadratic_s2_m2,
                    added: false,
                    cubic_from_m_s,
                } => 1.0 + growth(quadratic_s2_m2, cubic_from_m_s, slip_speed.abs()),
                Effect::Wear {
                    amplitude,
                    distance_m,
                    course,
                } => {
                    let travelled = (self.history.slid_m + slid_m) / distance_m;
                    match course {
                        Course::Saturating => 1.0 + amplitude * (1.0 - (-travelled).exp()),
                        Course::Power(power) => 1.0 + amplitude * travelled.max(0.0).powf(power),
                    }
                }
                Effect::ThermalSoftening {
                    strength_per_j,
                    levels_off: false,
                    ..
                } => 1.0 - strength_per_j * heat_j,
                Effect::ThermalSoftening {
                    strength_per_j,
                    levels_off: true,
                    ..
                } => 1.0 / (1.0 + strength_per_j * heat_j),
                Effect::SurfaceTexture {
                    amplitude,
                    wavelength_m,
                    phase_rad,
                    wave,
                } => 1.0 + amplitude * wave.at(tau * plate_m / wavelength_m + phase_rad),
                Effect::SurfaceGradient {
                    slope_per_m,
                    fading_m: None,
                } => 1.0 + slope_per_m * plate_m,
                Effect::SurfaceGradient {
                    slope_per_m,
                    fading_m: Some(fading_m),
                } => 1.0 - slope_per_m * fading_m * (-plate_m / fading_m).exp_m1(),
                Effect::LoadDependence { exponent } => {
                    (self.load_n / self.rig.reference_load_n).powf(-exponent)
                }
                Effect::LoadOscillation {
                    amplitude,
                    frequency_hz,
                    phase_rad,
                    wave,
                    clock,
                } => {
                    let since_s = match clock {
                        Clock::Run => time_s,
                        Clock::Day => self.plan.started_s + time_s,
                    };
                    1.0 + amplitude * wave.at(tau * frequency_hz * since_s + phase_rad)
                }
                Effect::Scratch {
                    depth,
                    edge,
                    at_m,
                    width_m,
                } => {
                    let widths = (plate_m - at_m) / width_m;
                    let bell = |widths: f64| (-0.5 * widths * widths).exp();
                    1.0 + depth * (bell(widths) - edge * bell(widths - 2.0))
                }
                // The brush is a few millimetres wide, so the step is felt over that width.
                Effect::PlateStep { height, at_m } => {
                    1.0 + 0.5 * height * (1.0 + ((plate_m - at_m) / 2e-3).tanh())
                }
                Effect::StickSlipBurst {
                    amplitude,
                    from_s,
                    to_s,
                    frequency_hz,
                    first_run,
                    every,
                } if self.is_one_of(first_run, every) && time_s >= from_s && time_s < to_s => {
                    let phase = ((time_s - from_s) * frequency_hz).fract();
                    1.0 + amplitude
                        * if phase < 0.85 {
                            phase / 0.85 - 0.5
                        } else {
                            0.5 - (phase - 0.85) / 0.15
                        }
                }
                Effect::Debris { amplitude, .. } => {
                    1.0 + amplitude * self.debris_field.at(slid_m).max(0.0)
                }
                _ => 1.0,
            };
        }
        factor
    }

    /// Roughness of friction at a place: the part fixed to the plate and the part of this run.
    fn roughness(&self, slid_m: f64, plate_m: f64) -> f64 {
        let Noise {
            roughness,
            plate_share,
            ..
        } = *self.noise;
        if roughness == 0.0 {
            return 1.0;
        }
        1.0 + roughness
            * (plate_share.sqrt() * self.plate_field.at(plate_m)
                + (1.0 - plate_share).sqrt() * self.run_field.at(slid_m))
    }

    /// State of the contact: rates of the inner states, slip speed and friction force.
    pub(crate) fn instant(&self, time_s: f64, state: &[f64]) -> Instant {
        let layout = &self.layout;
        let brush_speed = layout.stretch.map_or(0.0, |place| state[place + 1]);
        let stretch_m = layout.stretch.map_or(0.0, |place| state[place]);
        let slip_speed = self.plate_speed(time_s, state[layout.stage]) - brush_speed;
        let remembered = layout.memory.map(|place| state[place]);
        let around = self.surroundings(time_s, state);
        // A specimen that was turned round meets the plate the other way.
        let turn = if self.plan.specimen_turned { -1.0 } else { 1.0 };
        let (inner_rate, of_the_law) = self.rig.law.evaluate(state[0], turn * slip_speed, &around);
        let coefficient = of_the_law + self.added_strengthening(turn * slip_speed);
        let (second_rate, second) = self.second_population(state, turn * slip_speed);
        let share = self.second_share();
        let plate_m = self.plan.start_position_m + state[layout.stage] - stretch_m;
        let heat_j = layout.heat.map_or(0.0, |place| state[place]);
        let factor = self.factor(time_s, slip_speed, state[1], plate_m, heat_j)
            * self.roughness(state[1], plate_m)
            * self.friction_factor;
        let friction_n =
            turn * ((1.0 - share) * coefficient + share * second) * factor * self.load_n;
        let remembered_rate = self.memory_rate(remembered.unwrap_or(0.0), slip_speed);
        Instant {
            inner_rate,
            second_rate,
            slip_speed,
            friction_n,
            remembered_rate,
        }
    }

    fn second_share(&self) -> f64 {
        self.rig
            .effects
            .iter()
            .find_map(|effect| match effect {
                Effect::SecondPopulation { share, .. } => Some(*share),
                _ => None,
            })
            .unwrap_or(0.0)
    }

    fn second_population(&self, state: &[f64], slip_speed: f64) -> (f64, f64) {
        for effect in &self.rig.effects {
            if let (
                Effect::SecondPopulation {
                    length_ratio,
                    lean_rad,
                    ..
                },
                Some(place),
            ) = (effect, self.layout.second)
            {
                let mut law = self.rig.law;
                match &mut law {
                    Law::AsymmetricBristle(bristle) => {
                        bristle.height_m *= length_ratio;
                        bristle.theta0_rad += lean_rad;
                    }
                    Law::Lugre(d) | Law::Dahl(d) => d.stiffness /= length_ratio,
                    Law::Stribeck(_) | Law::CoulombViscous(_) => {}
                }
                return law.evaluate(state[place], slip_speed, &Surroundings::PLAIN);
            }
        }
        (0.0, 0.0)
    }

    fn memory_rate(&self, remembered: f64, slip_speed: f64) -> f64 {
        for effect in &self.rig.effects {
            if let Effect::FrictionalMemory {
                time_constant_s,
                distance_m,
                remembers,
            } = effect
            {
                let speed = match remembers {
                    Remembers::Magnitude => slip_speed.abs(),
                    Remembers::Curve | Remembers::ViscousToo => slip_speed,
                };
                if let Some(tau) = time_constant_s {
                    return (speed - remembered) / tau;
                }
                if let Some(distance) = distance_m {
                    return (speed - remembered) * slip_speed.abs() / distance;
                }
            }
        }
        0.0
    }

    /// Tension of the cord at `stretch_m` and its rate; the force that is led to the sensor.
    fn tension(&self, stretch_m: f64, stretch_rate: f64) -> f64 {
        for effect in &self.rig.effects {
            if let Effect::CordCompliance {
                compliance_m_n,
                damping_n_s_m,
                hardening_m,
            } = effect
            {
                let growth =
                    hardening_m.map_or(1.0, |length| 1.0 + (stretch_m / length).powi(2) / 3.0);
                return stretch_m / compliance_m_n * growth + damping_n_s_m * stretch_rate;
            }
        }
        0.0
    }

    /// Mass on the cord: the brush with its fixture, which is also the load.
    fn brush_mass_kg(&self) -> f64 {
        (self.load_n / STANDARD_GRAVITY_M_S2).max(1e-3)
    }

    /// Force led into the sensor at this instant.
    pub(crate) fn sensed(&self, time_s: f64, state: &[f64], instant: &Instant) -> f64 {
        let led = match self.layout.stretch {
            Some(place) => self.tension(state[place], state[place + 1]),
            None => instant.friction_n,
        };
        let loaded_n = self.plan.load_n.unwrap_or(0.0);
        let acceleration = self.plan.motion.acceleration(time_s, self.half_sample_s);
        // The inertia of a drive's stated mass, on the motor's side of any play, is part of every reading.
        let mut force = led + self.known_mass_kg * acceleration;
        for effect in &self.rig.effects {
            force += match *effect {
                Effect::StageTilt { angle_rad } => {
                    loaded_n * angle_rad.sin() * if self.plan.stage_turned { -1.0 } else { 1.0 }
                }
                Effect::LoadCrosstalk { ratio } => ratio * loaded_n,
                Effect::MovingInertia { mass_kg } => mass_kg * acceleration,
                Effect::ForceZeroOffset { force_n } => force_n,
                Effect::ForceZeroDrift { rate_n_s } => rate_n_s * (self.plan.started_s + time_s),
                _ => 0.0,
            };
        }
        force
    }

    fn sensor_time_constant(&self) -> f64 {
        self.time_constant(|effect| match effect {
            Effect::SensorLag {
                time_constant_s, ..
            } => Some(*time_constant_s),
            _ => None,
        })
    }

    fn velocity_time_constant(&self) -> f64 {
        self.time_constant(|effect| match effect {
            Effect::VelocityLag {
                time_constant_s, ..
            } => Some(*time_constant_s),
            _ => None,
        })
    }

    fn time_constant(&self, pick: impl Fn(&Effect) -> Option<f64>) -> f64 {
        self.rig
            .effects
            .iter()
            .find_map(pick)
            .unwrap_or(f64::INFINITY)
    }
}

/// Rate of a filter of one stage or of two equal stages with half the time constant each.
pub(crate) fn filter_rate(state: &[f64], input: f64, tau: f64, two: bool, rate: &mut [f64]) {
    if two {
        rate[0] = (input - state[0]) * 2.0 / tau;
        rate[1] = (state[0] - state[1]) * 2.0 / tau;
    } else {
        rate[0] = 0.0;
        rate[1] = (input - state[1]) / tau;
    }
}

impl Dynamics for Contact<'_> {
    fn rate(&self, time_s: f64, state: &[f64], rate: &mut [f64]) {
        let layout = &self.layout;
        let instant = self.instant(time_s, state);
        rate[0] = instant.inner_rate;
        rate[1] = instant.slip_speed.abs();
        rate[layout.stage] = self.plate_speed(time_s, state[layout.stage]);
        if let Some(place) = layout.stretch {
            // m x'' = friction - tension
            rate[place] = state[place + 1];
            rate[place + 1] = (instant.friction_n - self.tension(state[place], state[place + 1]))
                / self.brush_mass_kg();
        }
        if let Some(place) = layout.heat {
            // E' = F v_slip - E/tau
            let tau = self.time_constant(|effect| match effect {
                Effect::ThermalSoftening {
                    time_constant_s, ..
                } => Some(*time_constant_s),
                _ => None,
            });
            rate[place] = instant.friction_n * instant.slip_speed - state[place] / tau;
        }
        if let Some(place) = layout.memory {
            rate[place] = instant.remembered_rate;
        }
        if let Some((place, bend)) = layout.bend {
            // theta' = (goal - theta) |v| / d, for one that touches the plate
            let turn = if self.plan.specimen_turned { -1.0 } else { 1.0 };
            let back = turn * instant.slip_speed < 0.0;
            let goal = if back { bend.in_reverse_rad } else { 0.0 };
            let touches = if self.load_n == 0.0 { 0.0 } else { 1.0 };
            rate[place] =
                touches * (goal - state[place]) * instant.slip_speed.abs() / bend.distance_m;
        }
        if let Some(place) = layout.second {
            rate[place] = instant.second_rate;
        }
        if let Some((place, two)) = layout.sensor {
            let input = self.sensed(time_s, state, &instant);
            filter_rate(
                &state[place..],
                input,
                self.sensor_time_constant(),
                two,
                &mut rate[place..],
            );
        }
        if let Some((place, two)) = layout.velocity {
            let input = self.plate_speed(time_s, state[layout.stage]);
            filter_rate(
                &state[place..],
                input,
                self.velocity_time_constant(),
                two,
                &mut rate[place..],
            );
        }
    }
}

/// q v^2, or q v^3 / w where it goes with the cube and w is the speed at which both are alike.
fn growth(quadratic_s2_m2: f64, cubic_from_m_s: Option<f64>, speed_m_s: f64) -> f64 {
    let cube = cubic_from_m_s.map_or(1.0, |from| speed_m_s / from);
    quadratic_s2_m2 * speed_m_s * speed_m_s * cube
}

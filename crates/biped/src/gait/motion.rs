//! A stride read back from the solver's vector: states, torques and ground forces over time.

use super::layout::{Layout, Place};
use super::point::{Point, compliant_force};
use super::{PHASES, Problem, STANDING};
use crate::dynamics::{energies, forward_dynamics, momenta};
use crate::kinematics::{COORDINATES, JOINTS, Leg, foot_velocity};
use serde::{Deserialize, Serialize};

/// One collocation point of a stride.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// Phase, 0 to 3.
    pub phase: usize,
    /// Time since the start of the stride, s.
    pub time_s: f64,
    /// Weight of the point in an integral over the stride, s.
    pub weight_s: f64,
    /// Coordinates, m and rad.
    pub q: [f64; COORDINATES],
    /// Their rates, m/s and rad/s.
    pub v: [f64; COORDINATES],
    /// Joint torques, N m.
    pub torques_n_m: [f64; JOINTS],
    /// Ground force on the standing foot (x, y), N; zero in flight.
    pub force_n: [f64; 2],
}

/// A whole stride.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Motion {
    /// State at the start: coordinates and rates.
    pub start: ([f64; COORDINATES], [f64; COORDINATES]),
    /// The points in order of time.
    pub samples: Vec<Sample>,
    /// Durations of the phases, s.
    pub durations_s: [f64; PHASES],
    /// Rates at the start of each phase (after an impact).
    pub phase_starts: [[f64; COORDINATES]; PHASES],
    /// Mean speed, m/s.
    pub speed_m_s: f64,
    /// Mean acceleration, m/s^2 (zero for a periodic stride).
    pub acceleration_m_s2: f64,
    /// Impulses of the touchdowns after flights 1 and 3, N s.
    pub impulses_n_s: [[f64; 2]; 2],
}

fn seven(x: &[f64], at: usize) -> [f64; COORDINATES] {
    std::array::from_fn(|k| x[at + k])
}

impl Motion {
    /// Reads a vector of variables of `problem`.
    pub fn new(problem: &Problem, x: &[f64]) -> Self {
        let layout = Layout::new(problem);
        let durations_s: [f64; PHASES] = std::array::from_fn(|p| x[layout.duration(p)]);
        let interval = |phase: usize| durations_s[phase] / problem.mesh.intervals(phase) as f64;
        let rates = |at: usize, phase: usize| seven(x, at).map(|w| w / interval(phase));
        let samples = layout
            .places()
            .into_iter()
            .map(|place| sample(problem, &layout, x, place))
            .collect();
        let pair = |at: Option<usize>| at.map_or([0.0; 2], |at| [x[at], x[at + 1]]);
        Self {
            start: (
                seven(x, layout.interval_start_q(0, 0)),
                rates(layout.phase_start_w(0), 0),
            ),
            samples,
            durations_s,
            phase_starts: std::array::from_fn(|p| rates(layout.phase_start_w(p), p)),
            speed_m_s: x[layout.speed()],
            acceleration_m_s2: layout.acceleration().map_or(0.0, |at| x[at]),
            impulses_n_s: [pair(layout.impulse(1)), pair(layout.impulse(3))],
        }
    }

    /// Period, s.
    pub fn period_s(&self) -> f64 {
        self.durations_s.iter().sum()
    }

    /// Effort: mean over the period of sum tau^2/tau_max^2.
    pub fn effort(&self, problem: &Problem) -> f64 {
        let limits = [problem.biped.hip_torque_n_m, problem.biped.knee_torque_n_m];
        let integral: f64 = self
            .samples
            .iter()
            .map(|s| {
                let squares = s
                    .torques_n_m
                    .iter()
                    .enumerate()
                    .map(|(k, t)| (t / limits[k % 2]).powi(2));
                s.weight_s * squares.sum::<f64>()
            })
            .sum();
        integral / self.period_s()
    }

    /// Impulse of the ground over the stride (x, y), N s: forces by the method's own
    /// quadrature plus touchdowns.
    pub fn ground_impulse_n_s(&self) -> [f64; 2] {
        std::array::from_fn(|k| {
            let forces: f64 = self.samples.iter().map(|s| s.weight_s * s.force_n[k]).sum();
            forces + self.impulses_n_s[0][k] + self.impulses_n_s[1][k]
        })
    }

    /// Forward and braking parts of the ground's impulse along x, N s, both positive.
    pub fn forward_and_braking_n_s(&self) -> [f64; 2] {
        let touchdowns = self.impulses_n_s.iter().map(|i| i[0]);
        let forces = self.samples.iter().map(|s| s.weight_s * s.force_n[0]);
        forces
            .chain(touchdowns)
            .fold([0.0; 2], |[forward, braking], part| {
                [forward + part.max(0.0), braking + (-part).max(0.0)]
            })
    }

    /// Range of force directions F_x/F_y over the stances: smallest and largest.
    pub fn directions(&self) -> [f64; 2] {
        self.samples
            .iter()
            .filter(|s| s.force_n[1] > 1.0)
            .map(|s| s.force_n[0] / s.force_n[1])
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], d| {
                [low.min(d), high.max(d)]
            })
    }

    /// Change of linear momentum over the stride minus the impulses of ground and gravity, N s:
    /// an error of the mesh, because momentum is not linear in the collocated rates.
    pub fn momentum_gap_n_s(&self, problem: &Problem) -> [f64; 2] {
        let Some(end) = self.samples.last() else {
            return [0.0; 2];
        };
        let biped = &problem.biped;
        let before = momenta(biped, &self.start.0, &self.start.1).0;
        let after = momenta(biped, &end.q, &end.v).0;
        let ground = self.ground_impulse_n_s();
        let last = self.impulses_n_s[1];
        let weight = biped.total_mass_kg() * biped.gravity_m_s2 * self.period_s();
        // The last touchdown lies at the end of the stride, after `end`.
        [
            after[0] - before[0] - (ground[0] - last[0]),
            after[1] - before[1] - (ground[1] - last[1] - weight),
        ]
    }

    /// Work of torques and ground against the change of energy over all phases, J, relative to the
    /// largest kinetic energy: how well the mesh resolves the motion.
    pub fn energy_gap(&self, problem: &Problem) -> f64 {
        let mut gap: f64 = 0.0;
        let mut largest: f64 = 0.0;
        let total = |q: &[f64; COORDINATES], v: &[f64; COORDINATES]| {
            let (kinetic, potential) = energies(&problem.biped, q, v);
            (kinetic + potential, kinetic)
        };
        let mut q = self.start.0;
        for phase in 0..PHASES {
            let samples = self.samples.iter().filter(|s| s.phase == phase);
            let before = total(&q, &self.phase_starts[phase]).0;
            let mut work = 0.0;
            let mut after = before;
            for s in samples {
                let joints: f64 = (0..JOINTS).map(|k| s.torques_n_m[k] * s.v[3 + k]).sum();
                let ground = STANDING[phase].map_or(0.0, |leg| {
                    let foot = foot_velocity(&problem.biped, &s.q, &s.v, leg);
                    foot[0] * s.force_n[0] + foot[1] * s.force_n[1]
                });
                work += s.weight_s * (joints + ground);
                let (energy, kinetic) = total(&s.q, &s.v);
                after = energy;
                largest = largest.max(kinetic);
                q = s.q;
            }
            gap += (after - before - work).abs();
        }
        gap / largest
    }

    /// Integrates the stride again with its torques, in `steps` steps of fourth order per interval. Torques between points
    /// are the line through the two stages of their interval, as in the collocation; a rigid stance is integrated
    /// with the collocated ground forces as a given input.
    ///
    /// Each interval is begun at its collocated state and ends a gap beside the next: what the method misses within
    /// one interval. Begun at the start of the stride and never put back, the same integration drifts by what the
    /// dynamics make of those gaps: the drift measures how unstable the stride is under a fixed course of torques, not the mesh.
    pub fn reintegration(&self, problem: &Problem, steps: usize) -> Reintegration {
        let mut worst = Reintegration::default();
        let mut free: State = self.start;
        let mut end = self.start.0;
        for phase in 0..PHASES {
            let samples: Vec<&Sample> = self.samples.iter().filter(|s| s.phase == phase).collect();
            let mut begin = (end, self.phase_starts[phase]);
            free.1 = if phase == 0 || problem.is_rigid() {
                // An impact is an event of the collocated stride, not of the integration.
                begin.1
            } else {
                free.1
            };
            for (interval, pair) in samples.chunks(Problem::RADAU_C.len()).enumerate() {
                let [.., last] = pair else { continue };
                let h = self.durations_s[phase] * problem.mesh.length(phase, interval);
                let reached = integrate(problem, phase, pair, h, steps, begin);
                free = integrate(problem, phase, pair, h, steps, free);
                worst.gap_m_rad = worst.gap_m_rad.max(distance(&reached.0, &last.q));
                worst.rate_gap_m_s_rad_s =
                    worst.rate_gap_m_s_rad_s.max(distance(&reached.1, &last.v));
                worst.drift_m_rad = worst.drift_m_rad.max(distance(&free.0, &last.q));
                begin = (last.q, last.v);
            }
            end = begin.0;
        }
        worst
    }
}

/// How far a stride integrated again lies from the collocated one, at worst.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Reintegration {
    /// Coordinates at the end of an interval begun at its collocated state, m and rad.
    pub gap_m_rad: f64,
    /// Rates there, m/s and rad/s.
    pub rate_gap_m_s_rad_s: f64,
    /// Coordinates of the integration that is never put back, m and rad.
    pub drift_m_rad: f64,
}

fn distance(a: &[f64; COORDINATES], b: &[f64; COORDINATES]) -> f64 {
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max)
}

fn integrate(
    problem: &Problem,
    phase: usize,
    pair: &[&Sample],
    h: f64,
    steps: usize,
    begin: State,
) -> State {
    let length = h / steps as f64;
    (0..steps).fold(begin, |(q, v), step| {
        let along = |part: f64| (step as f64 + part) / steps as f64;
        let along = [along(0.0), along(0.5), along(1.0)];
        runge_kutta(problem, phase, pair, along, length, q, v)
    })
}

/// Line through the values at the two stages, c = 1/3 and 1.
fn between<const N: usize>(first: [f64; N], second: [f64; N], along: f64) -> [f64; N] {
    let part = (along - Problem::RADAU_C[0]) / (Problem::RADAU_C[1] - Problem::RADAU_C[0]);
    std::array::from_fn(|k| first[k] + part * (second[k] - first[k]))
}

type State = ([f64; COORDINATES], [f64; COORDINATES]);

fn runge_kutta(
    problem: &Problem,
    phase: usize,
    pair: &[&Sample],
    along: [f64; 3],
    h: f64,
    q: [f64; COORDINATES],
    v: [f64; COORDINATES],
) -> State {
    let rate = |(q, v): &State, along: f64| -> State {
        let torques = between(pair[0].torques_n_m, pair[1].torques_n_m, along);
        let force = STANDING[phase].map(|leg| {
            let held = between(pair[0].force_n, pair[1].force_n, along);
            let point = Point {
                q: *q,
                w: *v,
                b: [0.0; COORDINATES],
                torques,
                h: 1.0,
            };
            (leg, compliant_force(problem, &point, leg).unwrap_or(held))
        });
        let contacts: Vec<(Leg, [f64; 2])> = force.into_iter().collect();
        let a = forward_dynamics(&problem.biped, q, v, &torques, &contacts)
            .unwrap_or([f64::NAN; COORDINATES]);
        (*v, a)
    };
    let step = |(q, v): &State, (dq, dv): &State, h: f64| -> State {
        (
            std::array::from_fn(|k| q[k] + h * dq[k]),
            std::array::from_fn(|k| v[k] + h * dv[k]),
        )
    };
    let start = (q, v);
    let k1 = rate(&start, along[0]);
    let k2 = rate(&step(&start, &k1, 0.5 * h), along[1]);
    let k3 = rate(&step(&start, &k2, 0.5 * h), along[1]);
    let k4 = rate(&step(&start, &k3, h), along[2]);
    let mean = |a: f64, b: f64, c: f64, d: f64| (a + 2.0 * b + 2.0 * c + d) / 6.0;
    let slope: State = (
        std::array::from_fn(|k| mean(k1.0[k], k2.0[k], k3.0[k], k4.0[k])),
        std::array::from_fn(|k| mean(k1.1[k], k2.1[k], k3.1[k], k4.1[k])),
    );
    step(&start, &slope, h)
}

fn sample(problem: &Problem, layout: &Layout, x: &[f64], place: Place) -> Sample {
    let phase = place.phase;
    let duration = x[layout.duration(phase)];
    let h = duration / problem.mesh.intervals(phase) as f64;
    let length = duration * problem.mesh.length(phase, place.interval);
    let before: f64 = (0..phase).map(|p| x[layout.duration(p)]).sum();
    let q = seven(x, layout.q(place));
    let w = seven(x, layout.w(place));
    let torques = std::array::from_fn(|k| x[layout.torques(place) + k]);
    let force_n = STANDING[phase].map_or([0.0; 2], |leg| {
        let point = Point {
            q,
            w,
            b: [0.0; COORDINATES],
            torques,
            h,
        };
        let held = layout.force(place).map_or([0.0; 2], |f| [x[f], x[f + 1]]);
        compliant_force(problem, &point, leg).unwrap_or(held)
    });
    Sample {
        phase,
        time_s: before
            + duration * problem.mesh.begin(phase, place.interval)
            + length * Problem::RADAU_C[place.stage],
        weight_s: length * Problem::RADAU_B[place.stage],
        q,
        v: w.map(|w| w / h),
        torques_n_m: torques,
        force_n,
    }
}

//! A first guess of a stride: legs that swing like pendulums under a torso at steady speed.

use super::layout::Layout;
use super::{PHASES, Problem, STANDING};
use crate::kinematics::COORDINATES;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// What the guess is made of.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Guess {
    /// Speed, m/s.
    pub speed_m_s: f64,
    /// Period of the stride, s.
    pub period_s: f64,
    /// Swing of the thighs about their middle, rad.
    pub swing_rad: f64,
    /// How far the knees bend further in the swing, rad.
    pub lift_rad: f64,
    /// Height of the torso, m.
    pub height_m: f64,
}

impl Default for Guess {
    fn default() -> Self {
        Self { speed_m_s: 4.0, period_s: 0.3, swing_rad: 0.4, lift_rad: 0.35, height_m: 0.42 }
    }
}

/// Shares of the phases in the guess.
const SHARES: [f64; PHASES] = [0.3, 0.2, 0.3, 0.2];

impl Guess {
    /// Coordinates and their rates at time t of the stride.
    fn state(&self, t: f64) -> ([f64; COORDINATES], [f64; COORDINATES]) {
        let rate = TAU / self.period_s;
        let mut q = [self.speed_m_s * t, self.height_m, 0.0, 0.0, 0.0, 0.0, 0.0];
        let mut v = [self.speed_m_s, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        // A thigh swings backwards through its middle in the middle of its stance.
        let middles = [0.5 * SHARES[0], SHARES[0] + SHARES[1] + 0.5 * SHARES[2]];
        for (hip, middle) in [3, 5].into_iter().zip(middles) {
            let (sine, cosine) = (rate * (t - middle * self.period_s)).sin_cos();
            q[hip] = -0.25 * PI - self.swing_rad * sine;
            v[hip] = -self.swing_rad * rate * cosine;
            q[hip + 1] = 0.5 * PI + self.lift_rad * (1.0 - cosine);
            v[hip + 1] = self.lift_rad * rate * sine;
        }
        (q, v)
    }

    /// The guess as a start for the solver.
    pub fn variables(&self, problem: &Problem) -> Vec<f64> {
        let layout = Layout::new(problem);
        let mut x = vec![0.0; layout.count()];
        x[layout.period()] = self.period_s;
        x[layout.speed()] = self.speed_m_s;
        let mut start_s = 0.0;
        let mut put = |at: usize, values: &[f64]| x[at..at + values.len()].copy_from_slice(values);
        put(layout.interval_start_q(0, 0), &self.state(0.0).0);
        for phase in 0..PHASES {
            put(layout.share(phase), &SHARES[phase..=phase]);
            let duration = SHARES[phase] * self.period_s;
            put(layout.duration(phase), &[duration]);
            let h = duration / problem.mesh.intervals(phase) as f64;
            put(layout.phase_start_w(phase), &self.state(start_s).1.map(|v| h * v));
            for place in layout.places().into_iter().filter(|place| place.phase == phase) {
                let c = Problem::RADAU_C[place.stage];
                let (q, v) = self.state(start_s + (place.interval as f64 + c) * h);
                put(layout.q(place), &q);
                put(layout.w(place), &v.map(|v| h * v));
                if let Some(force) = layout.force(place).filter(|_| STANDING[phase].is_some()) {
                    // Over a stride the ground carries the weight in the stances alone.
                    let weight = problem.biped.total_mass_kg() * problem.biped.gravity_m_s2;
                    put(force + 1, &[weight / (SHARES[0] + SHARES[2])]);
                }
            }
            start_s += duration;
        }
        x
    }
}

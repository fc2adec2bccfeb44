//! A first guess of a stride: feet that draw closed paths under a torso at steady speed.
//!
//! In its stance a foot moves backwards under its hip at the speed of travel and sinks in as far as
//! the ground needs to carry the weight; in its swing it returns on a smooth curve. The joints follow
//! by inverse kinematics, rates and accelerations by dual numbers, torques by inverse dynamics.

use super::layout::{Layout, Place};
use super::{Contact, PHASES, Problem, STANDING};
use crate::dynamics::residual;
use crate::kinematics::{COORDINATES, JOINTS, Leg, Scalar};
use crate::parameters::Biped;
use num_dual::Dual2_64;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// What the guess is made of.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Guess {
    /// Speed, m/s.
    pub speed_m_s: f64,
    /// Duration of a stance, s.
    pub stance_s: f64,
    /// Duration of a flight, s.
    pub flight_s: f64,
    /// Height of the torso above the ground, m.
    pub height_m: f64,
    /// How far behind its hip the middle of a foot's stance lies, m.
    pub behind_m: f64,
    /// Highest point of a foot in its swing, m.
    pub clearance_m: f64,
}

impl Default for Guess {
    fn default() -> Self {
        Self {
            speed_m_s: 4.0,
            stance_s: 0.06,
            flight_s: 0.04,
            height_m: 0.42,
            behind_m: 0.0,
            clearance_m: 0.08,
        }
    }
}

impl Guess {
    fn durations(&self) -> [f64; PHASES] {
        STANDING.map(|leg| {
            if leg.is_some() {
                self.stance_s
            } else {
                self.flight_s
            }
        })
    }

    fn period_s(&self) -> f64 {
        2.0 * (self.stance_s + self.flight_s)
    }

    /// Largest depth of a compliant foot so that, at k d^1.5, the mean force of a half sine carries
    /// the weight.
    fn depth_m(&self, problem: &Problem) -> f64 {
        let Contact::Compliant(ground) = problem.contact else {
            return 0.0;
        };
        let weight = problem.biped.total_mass_kg() * problem.biped.gravity_m_s2;
        let force = weight * self.period_s() / (2.0 * self.stance_s);
        // Mean of sin^1.5 over half a period.
        const MEAN: f64 = 0.5564;
        let depth = (force / MEAN / ground.stiffness_n_m15).powf(2.0 / 3.0);
        depth.min(0.9 * problem.limits.foot_depth_m)
    }

    /// Foot relative to its hip (x) and to the ground (y) at time t after its touchdown, 0 <= t < period.
    fn foot<D: Scalar>(&self, depth_m: f64, t: D) -> [D; 2] {
        let middle = -self.behind_m;
        let half = 0.5 * self.speed_m_s * self.stance_s;
        if t.re() <= self.stance_s {
            let part = t / self.stance_s;
            return [
                -(t * self.speed_m_s) + (half + middle),
                -(part * PI).sin() * depth_m,
            ];
        }
        // Return with the speed of travel at both ends: a cubic in s from -half to half.
        let swing = self.period_s() - self.stance_s;
        let s = (t - self.stance_s) / swing;
        let slope = -self.speed_m_s * swing;
        let (s2, s3) = (s * s, s * s * s);
        let x = (s3 * 2.0 - s2 * 3.0 + 1.0) * (-half)
            + (s2 * 3.0 - s3 * 2.0) * half
            + (s3 - s2 * 2.0 + s) * slope
            + (s3 - s2) * slope;
        [x + middle, (s * PI).sin() * self.clearance_m]
    }

    /// Coordinates at time t of the stride.
    fn coordinates<D: Scalar>(&self, biped: &Biped, depth_m: f64, t: D) -> [D; COORDINATES] {
        let zero = D::from(0.0);
        let mut q = [
            t * self.speed_m_s,
            zero + self.height_m,
            zero,
            zero,
            zero,
            zero,
            zero,
        ];
        let touchdowns = [0.0, self.stance_s + self.flight_s];
        for (leg, touchdown) in Leg::BOTH.into_iter().zip(touchdowns) {
            let turns = ((t.re() - touchdown) / self.period_s()).floor();
            let [x, y] = self.foot(depth_m, t - (touchdown + turns * self.period_s()));
            let down = -(y - self.height_m);
            let (l1, l2) = (biped.thigh.length_m, biped.shank.length_m);
            // Law of cosines, held away from the stretched leg.
            let squared = x * x + down * down;
            let cosine = (squared - (l1 * l1 + l2 * l2)) / (2.0 * l1 * l2);
            let longest = 0.97;
            let cosine = if cosine.re() > longest {
                zero + longest
            } else {
                cosine
            };
            let knee = cosine.acos();
            let thigh = x.atan2(down) - (knee.sin() * l2).atan2(knee.cos() * l2 + l1);
            q[leg.hip_index()] = thigh;
            q[leg.knee_index()] = knee;
        }
        q
    }

    /// The guess as a start for the solver.
    pub fn variables(&self, problem: &Problem) -> Vec<f64> {
        let layout = Layout::new(problem);
        let depth = self.depth_m(problem);
        let state = |t: f64| self.coordinates(&problem.biped, depth, Dual2_64::new(t, 1.0, 0.0));
        let mut x = vec![0.0; layout.count()];
        x[layout.period()] = self.period_s();
        x[layout.speed()] = self.speed_m_s;
        let mut put = |at: usize, values: &[f64]| x[at..at + values.len()].copy_from_slice(values);
        put(layout.interval_start_q(0, 0), &state(0.0).map(|c| c.re));
        let mut start_s = 0.0;
        for (phase, duration) in self.durations().into_iter().enumerate() {
            put(layout.duration(phase), &[duration]);
            put(layout.share(phase), &[duration / self.period_s()]);
            let h = duration / problem.mesh.intervals(phase) as f64;
            put(
                layout.phase_start_w(phase),
                &state(start_s).map(|c| h * c.v1),
            );
            for place in layout
                .places()
                .into_iter()
                .filter(|place| place.phase == phase)
            {
                let at = state(start_s + problem.mesh.passed(place) * duration);
                put(layout.q(place), &at.map(|c| c.re));
                put(layout.w(place), &at.map(|c| h * c.v1));
                put(layout.b(place), &at.map(|c| h * h * c.v2));
                let (torques, force) = self.efforts(problem, place, &at);
                put(layout.torques(place), &torques);
                if let Some(at) = layout.force(place) {
                    put(at, &force);
                }
            }
            start_s += duration;
        }
        x
    }

    /// Torques within their limits and the ground force that carries the weight.
    fn efforts(
        &self,
        problem: &Problem,
        place: Place,
        at: &[Dual2_64; COORDINATES],
    ) -> ([f64; JOINTS], [f64; 2]) {
        let biped = &problem.biped;
        let weight = biped.total_mass_kg() * biped.gravity_m_s2;
        let force = [0.0, weight * self.period_s() / (2.0 * self.stance_s)];
        let contacts: Vec<(Leg, [f64; 2])> = STANDING[place.phase]
            .map(|leg| (leg, force))
            .into_iter()
            .collect();
        let rows = residual(
            biped,
            &at.map(|c| c.re),
            &at.map(|c| c.v1),
            &at.map(|c| c.v2),
            &[0.0; JOINTS],
            &contacts,
        );
        let limits = [biped.hip_torque_n_m, biped.knee_torque_n_m];
        (
            std::array::from_fn(|k| rows[3 + k].clamp(-limits[k % 2], limits[k % 2])),
            force,
        )
    }
}

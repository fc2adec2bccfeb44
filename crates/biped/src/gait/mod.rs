//! The gait: one stride of the biped as a nonlinear programme.
//!
//! Order of a stride: front stance, flight, rear stance, flight; periodic in everything but x. The
//! paper publishes neither its cost nor its contact nor its limits, so all of them are plain
//! values of [`Problem`]: what follows from them is a map, not one number.
//!
//! Two contacts: a rigid one (the foot sticks, forces are variables, touchdown is an impact) and a
//! compliant one (Hertz with contact loss, friction by the direction of sliding).

pub mod book;
pub mod catalogue;
pub mod chain;
pub mod cold;
pub mod file;
pub mod hopping;
pub mod layout;
mod linear;
pub mod mesh;
pub mod motion;
pub mod passage;
mod point;
pub mod programme;
pub mod refine;
pub mod start;
mod variables;

use crate::contact::{Brush, Ground};
use crate::kinematics::Leg;
use crate::parameters::Biped;
pub use mesh::Mesh;
use serde::{Deserialize, Serialize};

/// Number of phases of a stride.
pub const PHASES: usize = 4;

/// The leg that stands in each phase.
pub const STANDING: [Option<Leg>; PHASES] = [Some(Leg::Front), None, Some(Leg::Rear), None];

/// The leg whose foot is at height zero at the end of each phase: it leaves the ground
/// (after a stance) or touches down (after a flight).
pub const EVENT: [Leg; PHASES] = [Leg::Front, Leg::Rear, Leg::Rear, Leg::Front];

/// How a rigid foot comes to rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Touchdown {
    /// An inelastic impact: M (v+ - v-) = J^T L, J v+ = 0, the impulse L within the friction cone.
    Impact,
    /// The foot arrives with zero speed.
    Still,
}

/// Contact of the standing foot.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Contact {
    /// The foot sticks; the ground force lies within the friction cone.
    Rigid(Touchdown),
    /// The foot sinks in and slides; the force follows from its motion.
    Compliant(Ground),
}

/// What the stride is optimised for; effort, mean of sum tau^2/tau_max^2, is always added.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Goal {
    /// Periodic stride: Q_v (v_mean - v_aim)^2.
    Speed {
        /// Weight Q_v, s^2/m^2.
        weight: f64,
        /// Speed aimed at, m/s.
        aim_m_s: f64,
    },
    /// A stride that ends faster than it began, otherwise periodic: weight times minus the
    /// mean acceleration (v_x,end - v_x,start)/T, from a given torso speed.
    Acceleration {
        /// Weight, s^2/m.
        weight: f64,
        /// Forward speed of the torso at the start, m/s.
        start_m_s: f64,
    },
}

/// Limits of posture, speed and phases. The paper gives none but the torques.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Limits {
    /// Hip angle, lowest and highest, rad.
    pub hip_rad: [f64; 2],
    /// Knee angle, lowest and highest, rad.
    pub knee_rad: [f64; 2],
    /// Largest pitch either way, rad.
    pub pitch_rad: f64,
    /// Largest rate of a joint either way, rad/s.
    pub joint_rate_rad_s: f64,
    /// Shortest stance, s.
    pub stance_s: f64,
    /// Shortest flight, s.
    pub flight_s: f64,
    /// Longest stance, s.
    pub longest_stance_s: f64,
    /// Longest flight, s.
    pub longest_flight_s: f64,
    /// Lowest height of a knee, m.
    pub knee_height_m: f64,
    /// Deepest that a compliant foot may sink in, m.
    pub foot_depth_m: f64,
    /// Largest loss factor 1 - 3/2 c v_y of a compliant foot once the first fifth of its stance has passed ([`Self::STRIKE`]); 2: it sinks in
    /// no faster than it may be drawn out, 2/(3c). A foot that is drawn out until it bears nothing and strikes again makes another stance of the
    /// second half, and does so where the mesh is not fine enough for strikes: between points of the collocation such a strike may give more
    /// than it takes.
    pub late_loss_factor: f64,
}

impl Default for Limits {
    /// Chosen by this project, wide enough that only the torques and the hips bind often.
    fn default() -> Self {
        let degrees = std::f64::consts::PI / 180.0;
        Self {
            hip_rad: [-110.0 * degrees, 70.0 * degrees],
            knee_rad: [10.0 * degrees, 150.0 * degrees],
            pitch_rad: 25.0 * degrees,
            joint_rate_rad_s: 60.0,
            stance_s: 0.02,
            flight_s: 0.01,
            longest_stance_s: 0.1,
            longest_flight_s: 0.1,
            knee_height_m: 0.02,
            foot_depth_m: 0.05,
            late_loss_factor: 2.0,
        }
    }
}

impl Limits {
    /// Part of a stance's time within which the foot may strike.
    pub const STRIKE: f64 = 0.2;
}

/// One gait problem.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Problem {
    /// The machine.
    pub biped: Biped,
    /// Its feet.
    pub brush: Brush,
    /// The contact.
    pub contact: Contact,
    /// What is optimised.
    pub goal: Goal,
    /// Limits.
    pub limits: Limits,
    /// Mesh.
    pub mesh: Mesh,
    /// Weight of the mean squared joint rates, s^2: keeps a minimum isolated, too small to
    /// matter beside the effort.
    pub rate_weight_s2: f64,
}

impl Problem {
    /// Coefficients c of the two-stage Radau IIA method, order three.
    pub const RADAU_C: [f64; 2] = [1.0 / 3.0, 1.0];
    /// Its matrix A.
    pub const RADAU_A: [[f64; 2]; 2] = [[5.0 / 12.0, -1.0 / 12.0], [0.75, 0.25]];
    /// Its weights b: the last row of A.
    pub const RADAU_B: [f64; 2] = Self::RADAU_A[1];

    /// The same machine in a stride that begins at a speed, m/s, and may end faster: the mean acceleration counts in the place of
    /// the speed.
    #[must_use]
    pub fn accelerating(self, start_m_s: f64) -> Self {
        let goal = Goal::Acceleration {
            weight: 1.0,
            start_m_s,
        };
        Self { goal, ..self }
    }

    /// Whether forces of the standing foot are variables.
    pub fn is_rigid(&self) -> bool {
        matches!(self.contact, Contact::Rigid(_))
    }
}

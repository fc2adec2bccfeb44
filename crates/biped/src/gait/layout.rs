//! Where each quantity of a stride stands in the vector of variables.
//!
//! Durations are free. With h = T_p/N_p the mean length of the intervals of phase p, the variables are
//! scaled by time, w = h v and b = h^2 a, so that every defect of the collocation is linear:
//!
//! q_i = q_0 + r sum_j A_ij w_j,   w_i = w_0 + r sum_j A_ij b_j,
//!
//! with r the interval's length over the mean one, and h appears only inside the points and where phases meet.

use super::{Contact, Mesh, PHASES, Problem, STANDING, Touchdown};
use crate::kinematics::{COORDINATES, JOINTS};

/// Stages of the collocation method.
pub const STAGES: usize = 2;

/// Place of one collocation point: phase, interval within it, stage within that.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Place {
    /// Phase, 0 to 3.
    pub phase: usize,
    /// Interval within the phase.
    pub interval: usize,
    /// Stage within the interval.
    pub stage: usize,
}

/// Indices into the vector of variables.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layout {
    mesh: Mesh,
    /// First variable of each phase's points.
    first: [usize; PHASES],
    /// Variables of one point in each phase.
    width: [usize; PHASES],
    impulses: Option<usize>,
    acceleration: Option<usize>,
    count: usize,
}

const SHARES: usize = PHASES;
const PERIOD: usize = 2 * PHASES;
const SPEED: usize = PERIOD + 1;
const START: usize = SPEED + 1;
const PHASE_STARTS: usize = START + COORDINATES;
const POINTS: usize = PHASE_STARTS + PHASES * COORDINATES;
const POINT_WIDTH: usize = 3 * COORDINATES + JOINTS;

impl Layout {
    /// Layout of a problem.
    pub fn new(problem: &Problem) -> Self {
        let mesh = problem.mesh;
        let mut first = [0; PHASES];
        let mut width = [0; PHASES];
        let mut next = POINTS;
        for phase in 0..PHASES {
            first[phase] = next;
            let forces = if problem.is_rigid() && STANDING[phase].is_some() {
                2
            } else {
                0
            };
            width[phase] = POINT_WIDTH + forces;
            next += mesh.intervals(phase) * STAGES * width[phase];
        }
        let mut take = |wanted: bool, n: usize| {
            let at = next;
            next += if wanted { n } else { 0 };
            wanted.then_some(at)
        };
        let impulses = take(problem.contact == Contact::Rigid(Touchdown::Impact), 4);
        let acceleration = take(matches!(problem.goal, super::Goal::Acceleration { .. }), 1);
        Self {
            mesh,
            first,
            width,
            impulses,
            acceleration,
            count: next,
        }
    }

    /// Number of variables.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Duration T_p of a phase, s.
    pub fn duration(&self, phase: usize) -> usize {
        phase
    }

    /// Share f_p = T_p/T of a phase.
    pub fn share(&self, phase: usize) -> usize {
        SHARES + phase
    }

    /// Period T, s.
    pub fn period(&self) -> usize {
        PERIOD
    }

    /// Mean speed, m/s.
    pub fn speed(&self) -> usize {
        SPEED
    }

    /// Mean acceleration, m/s^2, where the goal asks for it.
    pub fn acceleration(&self) -> Option<usize> {
        self.acceleration
    }

    /// Impulse (x, y) of the touchdown that ends a flight, N s; index 0 after phase 1, 1 after phase 3.
    pub fn impulse(&self, flight: usize) -> Option<usize> {
        self.impulses
            .map(|first| first + if flight == 1 { 0 } else { 2 })
    }

    /// Scaled velocity w at the start of a phase (after an impact, if there is one).
    pub fn phase_start_w(&self, phase: usize) -> usize {
        PHASE_STARTS + phase * COORDINATES
    }

    /// Variables of all points.
    pub fn points(&self) -> std::ops::Range<usize> {
        let last = self.last(PHASES - 1);
        self.first[0]..self.point(last) + self.width[last.phase]
    }

    fn point(&self, place: Place) -> usize {
        self.first[place.phase] + (place.interval * STAGES + place.stage) * self.width[place.phase]
    }

    /// Position q of a point.
    pub fn q(&self, place: Place) -> usize {
        self.point(place)
    }

    /// Scaled velocity w = h v of a point.
    pub fn w(&self, place: Place) -> usize {
        self.point(place) + COORDINATES
    }

    /// Scaled acceleration b = h^2 a of a point.
    pub fn b(&self, place: Place) -> usize {
        self.point(place) + 2 * COORDINATES
    }

    /// Torques of a point, N m.
    pub fn torques(&self, place: Place) -> usize {
        self.point(place) + 3 * COORDINATES
    }

    /// Ground force (x, y) of a point in a rigid stance, N.
    pub fn force(&self, place: Place) -> Option<usize> {
        (self.width[place.phase] > POINT_WIDTH).then(|| self.point(place) + POINT_WIDTH)
    }

    /// Position q at the start of an interval.
    pub fn interval_start_q(&self, phase: usize, interval: usize) -> usize {
        match (phase, interval) {
            (0, 0) => START,
            (_, 0) => self.q(self.last(phase - 1)),
            _ => self.q(Place {
                phase,
                interval: interval - 1,
                stage: STAGES - 1,
            }),
        }
    }

    /// Scaled velocity w at the start of an interval.
    pub fn interval_start_w(&self, phase: usize, interval: usize) -> usize {
        if interval == 0 {
            self.phase_start_w(phase)
        } else {
            self.w(Place {
                phase,
                interval: interval - 1,
                stage: STAGES - 1,
            })
        }
    }

    /// Last point of a phase.
    pub fn last(&self, phase: usize) -> Place {
        Place {
            phase,
            interval: self.mesh.intervals(phase) - 1,
            stage: STAGES - 1,
        }
    }

    /// Whether a point ends its phase.
    pub fn is_last(&self, place: Place) -> bool {
        place == self.last(place.phase)
    }

    /// All points in order of time.
    pub fn places(&self) -> Vec<Place> {
        let mut places = Vec::new();
        for phase in 0..PHASES {
            for interval in 0..self.mesh.intervals(phase) {
                places.extend((0..STAGES).map(|stage| Place {
                    phase,
                    interval,
                    stage,
                }));
            }
        }
        places
    }
}

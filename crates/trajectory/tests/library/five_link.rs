//! The walker of five links: one periodic step with the least ∫ Σ torque² dt.
//!
//! Kelly, An introduction to trajectory optimization, SIAM Review 59 (2017), section 7 and appendices E and F:
//! stance shin 1, stance thigh 2, torso 3, swing thigh 4, swing shin 5, with the numbers of the robot RABBIT
//! (Westervelt, Grizzle and Koditschek, Hybrid zero dynamics of planar biped walkers, IEEE Transactions on
//! Automatic Control 48, 2003). Angles q are absolute, zero where a link is upright, positive to the left; the
//! stance foot is the origin and has no ankle torque; the swing foot strikes without slip or rebound at the
//! instant at which the other leaves, and the legs change their names.
//!
//! ```text
//! e_j  = (−sin q_j, cos q_j)            direction of link j
//! G_k  = Σ_j A_kj e_j                   centre of mass of link k, A from the lengths
//! Σ_{k beyond joint i} (G_k − P_i) × m_k (G̈_k + g e_y) + I_k q̈_k = u_i     angular momentum about joint i
//! ```

use super::control::{coordinate, free};
use trajectory::collocation::End;
use trajectory::collocation::{
    EndPoint, Guess, Linkage, OptimalControl, Phase, Point, PointRows, Transcription,
};
use trajectory::{Row, Scalar, Variable};

/// Number of links.
pub const LINKS: usize = 5;
/// Masses in kg (Kelly, table 4).
pub const MASS_KG: [f64; LINKS] = [3.2, 6.8, 20.0, 6.8, 3.2];
/// Moments of inertia about the centres of mass in kg m² (Kelly, table 4).
pub const INERTIA_KG_M2: [f64; LINKS] = [0.93, 1.08, 2.22, 1.08, 0.93];
/// Length of each shin and thigh in m (Kelly, table 4).
pub const LEG_M: f64 = 0.4;
/// Knee to centre of mass of a shin in m (Kelly, table 4).
pub const SHIN_COM_M: f64 = 0.128;
/// Hip to centre of mass of a thigh in m (Kelly, table 4).
pub const THIGH_COM_M: f64 = 0.163;
/// Hip to centre of mass of the torso in m (Kelly, table 4).
pub const TORSO_COM_M: f64 = 0.2;
/// The same in the programme that accompanies the paper: 0.2 m below the shoulders of a torso of 0.625 m.
pub const TORSO_COM_FROM_SHOULDERS_M: f64 = 0.425;
/// Gravity in m/s².
pub const G: f64 = 9.81;
/// How far in m the swing foot may be below its clearance. Both ends of the step lie on the ground already: a
/// limit there would say the same twice, and its multiplier would be arbitrary.
const FOOT_SLACK_M: f64 = 1e-3;

/// A step of the walker.
pub struct FiveLink {
    /// Length of the step in m.
    pub step_m: f64,
    /// Its duration in s.
    pub duration_s: f64,
    /// Hip to centre of mass of the torso in m.
    pub torso_com_m: f64,
    /// Height in m of the parabola from footprint to footprint that the swing foot must clear.
    pub clearance_m: f64,
    /// Largest torque of a joint in N m.
    pub torque_nm: f64,
    /// Are the knees kept from bending forward?
    pub knees: bool,
    /// Intervals of the mesh.
    pub intervals: usize,
}

/// A point of the plane: to the right, up.
type Plane<D> = [D; 2];

impl FiveLink {
    /// The step of the paper: 0.5 m in 0.7 s.
    pub fn published(intervals: usize) -> Self {
        Self {
            step_m: 0.5,
            duration_s: 0.7,
            torso_com_m: TORSO_COM_M,
            clearance_m: 0.0,
            torque_nm: 100.0,
            knees: true,
            intervals,
        }
    }

    /// The step of the log that is published with the paper's programme: 0.4 m in 0.6 s, knees free.
    pub fn logged(intervals: usize) -> Self {
        Self {
            step_m: 0.4,
            duration_s: 0.6,
            torso_com_m: TORSO_COM_FROM_SHOULDERS_M,
            knees: false,
            ..Self::published(intervals)
        }
    }

    /// The step of the paper over an obstacle, with motors too weak for the torques of its free optimum.
    pub fn held(intervals: usize) -> Self {
        Self {
            clearance_m: 0.1,
            torque_nm: 30.0,
            ..Self::published(intervals)
        }
    }

    /// A: the position of the centre of mass of link k is Σ_j A_kj e_j. In m.
    pub fn arms(&self) -> [[f64; LINKS]; LINKS] {
        let (l, shin, thigh) = (LEG_M, SHIN_COM_M, THIGH_COM_M);
        [
            [l - shin, 0.0, 0.0, 0.0, 0.0],
            [l, l - thigh, 0.0, 0.0, 0.0],
            [l, l, self.torso_com_m, 0.0, 0.0],
            [l, l, 0.0, -thigh, 0.0],
            [l, l, 0.0, -l, -shin],
        ]
    }

    /// The paper's start: angles on a straight line from a guessed stance to its mirror image, no torques.
    ///
    /// `shift` in rad moves the angles of both ends (zero for the paper's own).
    pub fn start<P: OptimalControl>(
        &self,
        t: &Transcription<'_, P>,
        shift: [[f64; LINKS]; 2],
    ) -> Vec<f64> {
        let stance = [-0.3, 0.7, 0.0, -0.5, -0.6];
        let from: Vec<f64> = (0..LINKS).map(|j| stance[j] + shift[0][j]).collect();
        let to: Vec<f64> = (0..LINKS)
            .map(|j| stance[LINKS - 1 - j] + shift[1][j])
            .collect();
        t.start(&[], &[self.duration_s], |_, share| Guess {
            q: (0..LINKS)
                .map(|j| from[j] + (to[j] - from[j]) * share)
                .collect(),
            v: (0..LINKS)
                .map(|j| (to[j] - from[j]) / self.duration_s)
                .collect(),
            a: vec![0.0; LINKS],
            u: vec![0.0; LINKS - 1],
            ..Guess::default()
        })
    }

    /// Σ_j row_j d_j for directions (or their derivatives) d.
    fn along<D: Scalar>(row: &[f64; LINKS], d: &[Plane<D>; LINKS]) -> Plane<D> {
        let mut sum = [D::zero(); 2];
        for (&arm, d) in row.iter().zip(d).filter(|(arm, _)| **arm != 0.0) {
            sum = [sum[0] + d[0] * arm, sum[1] + d[1] * arm];
        }
        sum
    }

    /// Moment of the motion of the links `links` about the point `about`: angular momentum if `motion` are
    /// velocities, its rate if they are accelerations. Link k turns at `turn[k]`.
    fn moment<D: Scalar>(
        &self,
        links: std::ops::Range<usize>,
        about: Plane<D>,
        e: &[Plane<D>; LINKS],
        motion: &[Plane<D>; LINKS],
        turn: &[D],
    ) -> D {
        let mut sum = D::zero();
        for k in links {
            let at = Self::along(&self.arms()[k], e);
            let p = motion[k];
            // (G_k − P) × m_k ṗ_k + I_k ω_k
            sum += ((at[0] - about[0]) * p[1] - (at[1] - about[1]) * p[0]) * MASS_KG[k]
                + turn[k] * INERTIA_KG_M2[k];
        }
        sum
    }

    /// Rows of the strike: angular momentum about the new stance foot of the whole, and about every joint of
    /// the links beyond it, is the same before and after (Kelly, appendix F.3). In kg m²/s.
    fn strike<D: Scalar>(&self, before: &EndPoint<'_, D>, after: &EndPoint<'_, D>, rows: &mut [D]) {
        let (e, f) = (directions(before.q), directions(after.q));
        let (old, new) = (self.velocities(before), self.velocities(after));
        let (p, r) = (joints(&e), joints(&f));
        for joint in 0..LINKS {
            // Link k before the strike is link 4 − k after it, point k is point 4 − k.
            let about = p[LINKS - 1 - ROOT[joint]];
            let had = self.moment(0..LINKS - joint, about, &e, &old, before.v);
            let has = self.moment(joint..LINKS, r[ROOT[joint]], &f, &new, after.v);
            rows[joint] = has - had;
        }
    }

    fn velocities<D: Scalar>(&self, end: &EndPoint<'_, D>) -> [Plane<D>; LINKS] {
        let d = turned(end.q, end.v);
        std::array::from_fn(|k| Self::along(&self.arms()[k], &d))
    }
}

/// Which of the points of `joints` is the joint through which torque i acts.
const ROOT: [usize; LINKS] = [0, 1, 2, 2, 3];

/// e_j = (−sin q_j, cos q_j).
fn directions<D: Scalar>(q: &[D]) -> [Plane<D>; LINKS] {
    std::array::from_fn(|j| {
        let (sin, cos) = q[j].sin_cos();
        [-sin, cos]
    })
}

/// ė_j = −(cos q_j, sin q_j) q̇_j.
fn turned<D: Scalar>(q: &[D], v: &[D]) -> [Plane<D>; LINKS] {
    std::array::from_fn(|j| {
        let (sin, cos) = q[j].sin_cos();
        [-cos * v[j], -sin * v[j]]
    })
}

/// Stance foot, stance knee, hip, swing knee and swing foot.
fn joints<D: Scalar>(e: &[Plane<D>; LINKS]) -> [Plane<D>; LINKS] {
    let step = |from: Plane<D>, e: Plane<D>, l: f64| [from[0] + e[0] * l, from[1] + e[1] * l];
    let stance_knee = step([D::zero(); 2], e[0], LEG_M);
    let hip = step(stance_knee, e[1], LEG_M);
    let swing_knee = step(hip, e[3], -LEG_M);
    let swing_foot = step(swing_knee, e[4], -LEG_M);
    [[D::zero(); 2], stance_knee, hip, swing_knee, swing_foot]
}

/// The swing foot in m, or its velocity in m/s if `e` are the rates of the directions.
pub fn swing_foot<D: Scalar>(e: &[Plane<D>; LINKS]) -> Plane<D> {
    joints(e)[4]
}

impl OptimalControl for FiveLink {
    fn phases(&self) -> Vec<Phase> {
        use std::f64::consts::FRAC_PI_2;
        let names = [
            "stance shin",
            "stance thigh",
            "torso",
            "swing thigh",
            "swing shin",
        ];
        let motors = ["stance knee", "stance hip", "swing hip", "swing knee"];
        let mut rows = vec![Row::equal(30.0); LINKS];
        rows.push(Row::between(-FOOT_SLACK_M, f64::INFINITY, 0.1));
        if self.knees {
            rows.extend([Row::at_least(1.0); 2]);
        }
        vec![Phase {
            name: "step".into(),
            coordinates: names
                .map(|name| {
                    coordinate(
                        name,
                        Variable::new("", -FRAC_PI_2, FRAC_PI_2, 1.0),
                        Variable::new("", -10.0, 10.0, 5.0),
                        free(50.0),
                    )
                })
                .into(),
            states: vec![],
            controls: motors
                .map(|name| Variable::new(name, -self.torque_nm, self.torque_nm, 30.0))
                .into(),
            duration: Variable::new("T", self.duration_s, self.duration_s, 1.0),
            intervals: self.intervals,
            rows,
        }]
    }

    fn linkages(&self) -> Vec<Linkage> {
        let mut rows = vec![Row::equal(1.0); LINKS];
        rows.extend([Row::equal(10.0); LINKS]);
        rows.extend([Row::equal(1.0); 2]);
        rows.extend([Row::at_least(1.0), Row::at_most(1.0)]);
        vec![Linkage {
            name: "strike and change of legs".into(),
            ends: vec![End::Finish(0), End::Start(0)],
            rows,
        }]
    }

    fn cost_scale(&self) -> f64 {
        300.0
    }

    fn point<D: Scalar>(&self, _: usize, at: &Point<'_, D>, out: PointRows<'_, D>) {
        let e = directions(at.q);
        // ë_j = (−cos q_j q̈_j + sin q_j q̇_j², −sin q_j q̈_j − cos q_j q̇_j²) = ė_j(q̈) − e_j q̇_j²
        let swing = turned(at.q, at.a);
        let bent: [Plane<D>; LINKS] = std::array::from_fn(|j| {
            let square = at.v[j] * at.v[j];
            [
                swing[j][0] - e[j][0] * square,
                swing[j][1] - e[j][1] * square,
            ]
        });
        // G̈_k + g e_y
        let motion: [Plane<D>; LINKS] = std::array::from_fn(|k| {
            let [x, y] = Self::along(&self.arms()[k], &bent);
            [x, y + G]
        });
        let points = joints(&e);
        for joint in 0..LINKS {
            let moment = self.moment(joint..LINKS, points[ROOT[joint]], &e, &motion, at.a);
            // No torque at the stance foot.
            out.rows[joint] = if joint == 0 {
                moment
            } else {
                moment - at.u[joint - 1]
            };
        }
        // y ≥ h (1 − (x/D)²)
        let foot = points[4];
        let share = foot[0] / self.step_m;
        out.rows[5] = foot[1] + share * share * self.clearance_m - self.clearance_m;
        // A knee does not bend forward.
        if self.knees {
            out.rows[6] = at.q[1] - at.q[0];
            out.rows[7] = at.q[3] - at.q[4];
        }
        // ℓ = Σ u²
        for u in at.u {
            *out.cost += *u * *u;
        }
    }

    fn link<D: Scalar>(
        &self,
        _: usize,
        ends: &[EndPoint<'_, D>],
        _: &[D],
        _: &mut D,
        rows: &mut [D],
    ) {
        let (before, after) = (&ends[0], &ends[1]);
        // Legs change their names: q_j after is q_{4−j} before.
        for j in 0..LINKS {
            rows[j] = after.q[j] - before.q[LINKS - 1 - j];
        }
        self.strike(before, after, &mut rows[5..10]);
        let foot = swing_foot(&directions(before.q));
        rows[10] = foot[0] - self.step_m;
        rows[11] = foot[1];
        // The foot leaves the ground upward and comes down on it.
        rows[12] = swing_foot(&turned(after.q, after.v))[1];
        rows[13] = swing_foot(&turned(before.q, before.v))[1];
    }
}

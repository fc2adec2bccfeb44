//! The stride as a block-separable programme: which block holds what.

use super::layout::{Layout, Place};
use super::point::{Point, compliant_force, impact_rows, motion_rows};
use super::variables::{IntervalScale, scale};
use super::{Contact, EVENT, Goal, PHASES, Problem, STANDING, Touchdown};
use crate::kinematics::{COORDINATES, JOINTS, Leg, foot_velocity, leg_points};
use trajectory::{Block, LinearRow, Programme, Row, Scalar, Variable};

/// What one block of the programme is.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// Equations of motion, contact and clearances at a point, and its share of the effort.
    Point(Place),
    /// f_p T = T_p.
    Share(usize),
    /// v_mean T = x at the end, and the goal's cost.
    Progress,
    /// Velocity continues from the end of this phase into the next.
    Junction(usize),
    /// Impact at the end of this flight.
    Impact(usize),
    /// The rigid foot is at rest at the start of the phase after this one.
    Rest(usize),
}

/// A stride as a programme for the solver.
#[derive(Clone, Debug)]
pub struct Stride {
    /// The problem that it states.
    pub problem: Problem,
    /// Its layout.
    pub layout: Layout,
    kinds: Vec<Kind>,
}

impl Stride {
    /// The programme of a problem.
    pub fn new(problem: Problem) -> Self {
        let layout = Layout::new(&problem);
        let mut kinds: Vec<Kind> = layout.places().into_iter().map(Kind::Point).collect();
        kinds.extend((0..PHASES).map(Kind::Share));
        kinds.push(Kind::Progress);
        for phase in 0..PHASES {
            let lands = STANDING[phase].is_none();
            match problem.contact {
                Contact::Rigid(Touchdown::Impact) if lands => kinds.push(Kind::Impact(phase)),
                _ => kinds.push(Kind::Junction(phase)),
            }
            if problem.is_rigid() && lands {
                kinds.push(Kind::Rest(phase));
            }
        }
        Self {
            problem,
            layout,
            kinds,
        }
    }

    fn interval<D: Scalar>(&self, phase: usize, duration: D) -> D {
        duration / self.problem.mesh.intervals(phase) as f64
    }

    /// Whether the velocity jump at the end of `phase` lets x' free (accelerating stride).
    fn gains_speed(&self, phase: usize) -> bool {
        phase == PHASES - 1 && matches!(self.problem.goal, Goal::Acceleration { .. })
    }

    fn variables_of(&self, kind: Kind) -> Vec<usize> {
        let layout = &self.layout;
        let seven = |first: usize| first..first + COORDINATES;
        match kind {
            Kind::Point(place) => {
                let q = layout.q(place);
                let mut list: Vec<usize> = (q + 1..q + COORDINATES).collect();
                list.extend(seven(layout.w(place)));
                list.extend(seven(layout.b(place)));
                list.extend(layout.torques(place)..layout.torques(place) + JOINTS);
                list.push(layout.duration(place.phase));
                list.push(layout.share(place.phase));
                list.extend(layout.force(place).into_iter().flat_map(|f| [f, f + 1]));
                list
            }
            Kind::Share(phase) => {
                vec![layout.share(phase), layout.period(), layout.duration(phase)]
            }
            Kind::Progress => {
                let mut list = vec![
                    layout.speed(),
                    layout.period(),
                    layout.q(layout.last(PHASES - 1)),
                ];
                list.extend(layout.acceleration());
                list
            }
            Kind::Junction(phase) | Kind::Impact(phase) => {
                let next = (phase + 1) % PHASES;
                let last = layout.last(phase);
                let mut list: Vec<usize> = seven(layout.w(last)).collect();
                list.extend(seven(layout.phase_start_w(next)));
                list.extend([layout.duration(phase), layout.duration(next)]);
                if let Kind::Impact(_) = kind {
                    let q = layout.q(last);
                    list.extend(q + 1..q + COORDINATES);
                    list.extend(layout.impulse(phase).into_iter().flat_map(|l| [l, l + 1]));
                }
                if self.gains_speed(phase) {
                    list.push(layout.period());
                    list.extend(layout.acceleration());
                }
                list
            }
            Kind::Rest(phase) => {
                let q = layout.q(layout.last(phase));
                let mut list: Vec<usize> = (q + 1..q + COORDINATES).collect();
                list.extend(seven(layout.phase_start_w((phase + 1) % PHASES)));
                list
            }
        }
    }

    fn rows_of(&self, kind: Kind) -> Vec<Row> {
        let interval = |phase: usize| IntervalScale::of(self.problem.mesh, phase % PHASES);
        match kind {
            Kind::Point(place) => {
                let interval = interval(place.phase);
                let mut rows = vec![Row::equal(interval.motion()); COORDINATES];
                if STANDING[place.phase].is_some() {
                    if self.problem.is_rigid() {
                        rows.extend([Row::equal(interval.w()); 2]);
                    } else {
                        // The contact only pushes, and strikes at the beginning only.
                        rows.push(Row::at_least(interval.length_s()));
                        if self.is_past_the_strike(place) {
                            rows.push(Row::at_least(interval.length_s()));
                        }
                    }
                }
                rows.extend(
                    Leg::BOTH
                        .iter()
                        .filter_map(|&leg| self.foot_row(place, leg)),
                );
                let knee = self.problem.limits.knee_height_m;
                rows.extend([Row::between(knee, f64::INFINITY, scale::HEIGHT_M); 2]);
                rows
            }
            Kind::Share(_) => vec![Row::equal(scale::PHASE_S)],
            Kind::Progress => vec![Row::equal(scale::LENGTH_M)],
            Kind::Junction(phase) | Kind::Impact(phase) => {
                let momentum = if matches!(kind, Kind::Impact(_)) {
                    2.0
                } else {
                    1.0
                };
                let product = interval(phase).w() * interval(phase + 1).length_s();
                vec![Row::equal(product * momentum); COORDINATES]
            }
            Kind::Rest(phase) => vec![Row::equal(interval(phase + 1).w()); 2],
        }
    }

    /// Whether the strike of a compliant foot has passed ([`super::Limits::late_loss_factor`]).
    fn is_past_the_strike(&self, place: Place) -> bool {
        self.problem.mesh.passed(place) > super::Limits::STRIKE
    }

    /// Limits of a foot's height at a point; none where it follows from the rigid contact.
    fn foot_row(&self, place: Place, leg: Leg) -> Option<Row> {
        let stands = STANDING[place.phase] == Some(leg);
        let event = self.layout.is_last(place) && EVENT[place.phase] == leg;
        if stands && self.problem.is_rigid() {
            None
        } else if event {
            Some(Row::equal(scale::HEIGHT_M))
        } else if stands {
            Some(Row::between(
                -self.problem.limits.foot_depth_m,
                0.0,
                scale::HEIGHT_M,
            ))
        } else {
            Some(Row::at_least(scale::HEIGHT_M))
        }
    }

    fn evaluate_point<D: Scalar>(&self, place: Place, x: &[D], cost: &mut D, rows: &mut [D]) {
        let problem = &self.problem;
        let mut q = [D::from(0.0); COORDINATES];
        q[1..].copy_from_slice(&x[..COORDINATES - 1]);
        let mut take = x[COORDINATES - 1..].iter().copied();
        let mut next = || take.next().unwrap_or_else(|| D::from(0.0));
        let w = std::array::from_fn(|_| next());
        let b = std::array::from_fn(|_| next());
        let torques: [D; JOINTS] = std::array::from_fn(|_| next());
        let (duration, share) = (next(), next());
        let h = self.interval(place.phase, duration);
        let point = Point {
            q,
            w,
            b,
            torques,
            h,
        };
        let force = [next(), next()];

        let standing = STANDING[place.phase]
            .map(|leg| (leg, compliant_force(problem, &point, leg).unwrap_or(force)));
        motion_rows(problem, &point, standing, rows);
        let mut filled = COORDINATES;
        let mut put = |value: D| {
            rows[filled] = value;
            filled += 1;
        };
        if let Some((leg, _)) = standing {
            let speed = foot_velocity(&problem.biped, &q, &w, leg);
            match problem.contact {
                Contact::Rigid(_) => speed.into_iter().for_each(&mut put),
                // Loss factor times h: h - 1.5 c (h v_y).
                Contact::Compliant(ground) => {
                    let factor = h - speed[1] * (1.5 * ground.loss_s_m);
                    put(factor);
                    if self.is_past_the_strike(place) {
                        put(h * problem.limits.late_loss_factor - factor);
                    }
                }
            }
        }
        let points = Leg::BOTH.map(|leg| leg_points(&problem.biped, &q, leg));
        for (leg, points) in Leg::BOTH.into_iter().zip(&points) {
            if self.foot_row(place, leg).is_some() {
                put(points.foot[1]);
            }
        }
        points.iter().for_each(|points| put(points.knee[1]));

        // Mean over the period: sum_p f_p sum_i l_i b_i (|tau|^2/tau_max^2 + eps |joint rates|^2), l_i the interval's part of the phase.
        let length = problem.mesh.length(place.phase, place.interval);
        let weight = Problem::RADAU_B[place.stage] * length;
        let mut effort = D::from(0.0);
        for k in 0..JOINTS {
            let limit = if k % 2 == 0 {
                problem.biped.hip_torque_n_m
            } else {
                problem.biped.knee_torque_n_m
            };
            let relative = torques[k] / limit;
            let rate = w[3 + k] / h;
            effort += relative * relative + rate * rate * problem.rate_weight_s2;
        }
        *cost += share * effort * weight;
    }

    fn evaluate_meeting<D: Scalar>(&self, kind: Kind, phase: usize, x: &[D], rows: &mut [D]) {
        let next = (phase + 1) % PHASES;
        let before: [D; COORDINATES] = std::array::from_fn(|k| x[k]);
        let after: [D; COORDINATES] = std::array::from_fn(|k| x[COORDINATES + k]);
        let h_before = self.interval(phase, x[2 * COORDINATES]);
        let h_after = self.interval(next, x[2 * COORDINATES + 1]);
        let mut rest = 2 * COORDINATES + 2;
        let mut jump_x = D::from(0.0);
        if self.gains_speed(phase) {
            // v_end = v_start + A T in x only.
            let (period, acceleration) = (x[x.len() - 2], x[x.len() - 1]);
            jump_x = period * acceleration * h_before * h_after;
        }
        if let Kind::Impact(_) = kind {
            let mut q = [D::from(0.0); COORDINATES];
            q[1..].copy_from_slice(&x[rest..rest + COORDINATES - 1]);
            rest += COORDINATES - 1;
            let Some(leg) = STANDING[next] else { return };
            let mut shifted = after;
            shifted[0] += jump_x / h_before;
            impact_rows(
                &self.problem,
                &q,
                (&before, h_before),
                (&shifted, h_after),
                leg,
                [x[rest], x[rest + 1]],
                rows,
            );
        } else {
            for k in 0..COORDINATES {
                rows[k] = after[k] * h_before - before[k] * h_after;
            }
            rows[0] += jump_x;
        }
    }
}

impl Programme for Stride {
    fn variables(&self) -> Vec<Variable> {
        super::variables::variables(&self.problem, &self.layout)
    }

    /// An effort of one. The weight of the goal must not enter: it would shrink the curvature that the effort
    /// gives to every torque, and with it the meaning of the optimality error.
    fn cost_scale(&self) -> f64 {
        1.0
    }

    fn blocks(&self) -> Vec<Block> {
        self.kinds
            .iter()
            .map(|&kind| {
                Block::new(
                    format!("{kind:?}"),
                    self.variables_of(kind),
                    self.rows_of(kind),
                )
            })
            .collect()
    }

    fn linear(&self) -> Vec<LinearRow> {
        super::linear::rows(&self.problem, &self.layout)
    }

    fn evaluate<D: Scalar>(&self, block: usize, x: &[D], cost: &mut D, rows: &mut [D]) {
        match self.kinds[block] {
            Kind::Point(place) => self.evaluate_point(place, x, cost, rows),
            Kind::Share(_) => rows[0] = x[0] * x[1] - x[2],
            Kind::Progress => {
                rows[0] = x[0] * x[1] - x[2];
                match self.problem.goal {
                    Goal::Speed { weight, aim_m_s } => {
                        let miss = x[0] - aim_m_s;
                        *cost += miss * miss * weight;
                    }
                    Goal::Acceleration { weight, .. } => *cost -= x[3] * weight,
                }
            }
            kind @ (Kind::Junction(phase) | Kind::Impact(phase)) => {
                self.evaluate_meeting(kind, phase, x, rows);
            }
            Kind::Rest(phase) => {
                let Some(leg) = STANDING[(phase + 1) % PHASES] else {
                    return;
                };
                let mut q = [D::from(0.0); COORDINATES];
                q[1..].copy_from_slice(&x[..COORDINATES - 1]);
                let w = std::array::from_fn(|k| x[COORDINATES - 1 + k]);
                let speed = foot_velocity(&self.problem.biped, &q, &w, leg);
                rows.copy_from_slice(&speed);
            }
        }
    }
}

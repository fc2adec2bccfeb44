//! From the stride of one problem to another problem in parts of the way, each stride a start for the next.
//!
//! Two neighbours may lie so far apart that the solver, started from the one, leaves every stride behind or falls into a dearer one.
//! Where both are ends of one branch of strides, short parts of the way keep to the branch. Where the branch ends or gets dear, hops
//! ([`super::hopping`]) look for another one to go on with.

use super::chain::{Case, Outcome, solve_all};
use super::hopping::hops_from;
use super::{Contact, Goal, Limits, Problem};
use crate::contact::{Brush, Ground};
use trajectory::{Options, ProgrammeError, Start};

/// Between two positive numbers, by ratio.
fn ratio(from: f64, to: f64, part: f64) -> f64 {
    from * (to / from).powf(part)
}

/// Between two numbers, by difference.
fn line(from: f64, to: f64, part: f64) -> f64 {
    from + part * (to - from)
}

impl Problem {
    /// The problem that lies `part` of the way from this one to another: stiffness, slip scale and weight by ratio, all else by
    /// difference. None between two kinds of contact or goal, or two meshes: there is no way between them.
    pub fn towards(&self, other: &Self, part: f64) -> Option<Self> {
        if self.mesh != other.mesh {
            return None;
        }
        if part >= 1.0 {
            return Some(*other);
        }
        let contact = match (self.contact, other.contact) {
            (Contact::Compliant(a), Contact::Compliant(b)) => Contact::Compliant(Ground {
                stiffness_n_m15: ratio(a.stiffness_n_m15, b.stiffness_n_m15, part),
                loss_s_m: line(a.loss_s_m, b.loss_s_m, part),
                slip_scale_m_s: ratio(a.slip_scale_m_s, b.slip_scale_m_s, part),
            }),
            (a, b) if a == b => b,
            _ => return None,
        };
        let goal = match (self.goal, other.goal) {
            (
                Goal::Speed { weight, aim_m_s },
                Goal::Speed {
                    weight: last,
                    aim_m_s: last_m_s,
                },
            ) => Goal::Speed {
                weight: ratio(weight, last, part),
                aim_m_s: line(aim_m_s, last_m_s, part),
            },
            (a, b) if a == b => b,
            _ => return None,
        };
        Some(Self {
            brush: Brush {
                forward: line(self.brush.forward, other.brush.forward, part),
                reverse: line(self.brush.reverse, other.brush.reverse, part),
            },
            contact,
            goal,
            limits: self.limits.towards(&other.limits, part),
            ..*other
        })
    }
}

impl Limits {
    fn towards(&self, other: &Self, part: f64) -> Self {
        let line = |of: fn(&Self) -> f64| line(of(self), of(other), part);
        Self {
            hip_rad: [line(|l| l.hip_rad[0]), line(|l| l.hip_rad[1])],
            knee_rad: [line(|l| l.knee_rad[0]), line(|l| l.knee_rad[1])],
            pitch_rad: line(|l| l.pitch_rad),
            late_loss_factor: line(|l| l.late_loss_factor),
            joint_rate_rad_s: line(|l| l.joint_rate_rad_s),
            stance_s: line(|l| l.stance_s),
            flight_s: line(|l| l.flight_s),
            longest_stance_s: line(|l| l.longest_stance_s),
            longest_flight_s: line(|l| l.longest_flight_s),
            knee_height_m: line(|l| l.knee_height_m),
            foot_depth_m: line(|l| l.foot_depth_m),
        }
    }
}

/// A passage: its solves in their order, each with the part of the way at which it stood.
#[derive(Clone, Debug, Default)]
pub struct Passage {
    /// All solves, those without a certificate included.
    pub solves: Vec<(f64, Outcome)>,
}

impl Passage {
    /// The cheapest certified stride at the end, if it got there.
    pub fn end(self) -> Option<Outcome> {
        let arrived = |(part, found): &(f64, Outcome)| *part >= 1.0 && found.is_certified();
        let ends = self.solves.into_iter().filter(arrived);
        ends.map(|(_, found)| found)
            .min_by(|a, b| a.cost.total_cmp(&b.cost))
    }

    /// Where it ended, with the work of all its solves: the last solve, if that was one of the problem it went to.
    pub fn arrived(self) -> Option<Outcome> {
        let iterations = self.steps();
        let subproblems = self.solves.iter().map(|(_, found)| found.subproblems).sum();
        let (part, last) = self.solves.into_iter().next_back()?;
        (part >= 1.0).then_some(Outcome {
            iterations,
            subproblems,
            ..last
        })
    }

    /// Steps of all solves.
    pub fn steps(&self) -> usize {
        self.solves.iter().map(|(_, found)| found.iterations).sum()
    }
}

/// How a way is gone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    /// Part of the way that is tried first in one step, and at most.
    pub first: f64,
    /// Shortest part that is tried.
    pub shortest: f64,
    /// Hops beside the stride of each part; the cheapest certified stride goes on.
    pub hops: usize,
}

/// Goes from a stride of `from` to `to` in parts that are halved where one ends without a certificate, and doubled where it holds.
///
/// # Errors
/// A start of the wrong length, or a problem that contradicts itself.
pub fn pass(
    from: &Problem,
    mut start: Start,
    to: &Problem,
    pace: Pace,
    options: &Options,
) -> Result<Passage, ProgrammeError> {
    let mut passage = Passage::default();
    let (mut way, mut part) = (0.0, pace.first);
    let mut seed = 0;
    while way < 1.0 && part >= pace.shortest {
        let next = f64::min(way + part, 1.0);
        let Some(problem) = from.towards(to, next) else {
            break;
        };
        let starts = vec![start.clone()];
        let mut ends = solve_all(&[Case { problem, starts }], options)?;
        let seeds = seed..seed + pace.hops as u64;
        ends.extend(hops_from(&problem, &start, seeds.clone(), options)?);
        seed = seeds.end;
        let ends: Vec<Outcome> = ends.into_iter().flatten().collect();
        let certified = ends.iter().filter(|end| end.is_certified());
        if let Some(best) = certified.min_by(|a, b| a.cost.total_cmp(&b.cost)) {
            (way, start) = (next, best.start());
            part = (2.0 * part).min(pace.first).min(1.0 - way);
        } else {
            part /= 2.0;
        }
        passage
            .solves
            .extend(ends.into_iter().map(|end| (next, end)));
    }
    Ok(passage)
}

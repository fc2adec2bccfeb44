//! From the stride of one problem to another problem in parts of the way, each stride a start for the next.
//!
//! Two neighbours may lie so far apart that the solver, started from the one, leaves every stride behind or falls into a dearer one.
//! Where both are ends of one branch of strides, short parts of the way keep to the branch.

use super::chain::{Case, Outcome, solve_all};
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
    /// The certified stride at the end, if it got there.
    pub fn end(self) -> Option<Outcome> {
        let last = self.solves.into_iter().next_back();
        last.filter(|(part, found)| *part >= 1.0 && found.is_certified())
            .map(|(_, found)| found)
    }

    /// Steps of all solves.
    pub fn steps(&self) -> usize {
        self.solves.iter().map(|(_, found)| found.iterations).sum()
    }
}

/// Goes from a stride of `from` to `to`, `first` of the way at once, in parts that are halved where one ends without a certificate,
/// down to `shortest`, and doubled where it holds.
///
/// # Errors
/// A start of the wrong length, or a problem that contradicts itself.
pub fn pass(
    from: &Problem,
    mut start: Start,
    to: &Problem,
    (first, shortest): (f64, f64),
    options: &Options,
) -> Result<Passage, ProgrammeError> {
    let mut passage = Passage::default();
    let (mut way, mut part) = (0.0, first);
    while way < 1.0 && part >= shortest {
        let next = f64::min(way + part, 1.0);
        let Some(problem) = from.towards(to, next) else {
            break;
        };
        let starts = vec![start.clone()];
        let Some(found) = solve_all(&[Case { problem, starts }], options)?
            .pop()
            .flatten()
        else {
            break;
        };
        if found.is_certified() {
            (way, start) = (next, found.start());
            part = (2.0 * part).min(1.0 - way);
        } else {
            part /= 2.0;
        }
        passage.solves.push((next, found));
    }
    Ok(passage)
}

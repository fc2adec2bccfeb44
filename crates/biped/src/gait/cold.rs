//! A stride on a stiff and lossy contact from nothing but a guess.
//!
//! Straight from a guess such a problem leads the solver to places where nothing helps: the feet strike with many times
//! the weight, and rows can only be met by leaving every stride. On a soft ground without loss, on a coarse mesh, a guess is enough.
//! From there the contact is walked to the wanted one,
//!
//! k = k_0 (k_1/k_0)^s,   c = s c_1,   u = u_0 (u_1/u_0)^s,   0 <= s <= 1,
//!
//! each stride a start for the next, in parts that are halved where one ends without a certificate and grow where it holds. Then the
//! stride is read on the wanted mesh; where that does not lead to a stride, it is read there earlier on the way and walked on.

use super::chain::{Case, Outcome, solve_all};
use super::refine::on_mesh;
use super::start::Guess;
use super::{Contact, Mesh, Problem};
use crate::contact::Ground;
use trajectory::{Options, ProgrammeError, Start, Status};

/// Stiffness, N/m^1.5, loss, s/m, and slip scale, m/s, at which the walk begins.
const SOFT: Ground = Ground {
    stiffness_n_m15: 2e4,
    loss_s_m: 0.0,
    slip_scale_m_s: 1.0,
};
/// Steps of a solve on the way: where a stride is near they are enough, where none is more do not help.
const STEPS: usize = 40;
/// Steps of the first solve, and of the first on another mesh.
const FIRST_STEPS: usize = 100;
/// First, largest and smallest part of the way.
const FIRST_PART: f64 = 0.1;
const LARGEST_PART: f64 = 0.25;
const SMALLEST_PART: f64 = 1.0 / 64.0;
/// What a part that held grows by.
const GROWTH: f64 = 1.5;

/// One solve of a walk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tread {
    /// Where on the way, 0 to 1.
    pub part: f64,
    /// The mesh.
    pub mesh: Mesh,
    /// How it ended.
    pub status: Status,
    /// Cost.
    pub cost: f64,
    /// Steps.
    pub iterations: usize,
}

/// A walk: its solves in their order, and the certified stride of the wanted problem, if it got there.
#[derive(Clone, Debug)]
pub struct Walk {
    /// All solves.
    pub treads: Vec<Tread>,
    /// The stride.
    pub stride: Option<Outcome>,
}

/// Walks from a guess to a compliant problem. A rigid problem needs no walk: it is solved from the guess.
///
/// # Errors
/// A problem that contradicts itself.
pub fn walk(problem: &Problem, guess: &Guess) -> Result<Walk, ProgrammeError> {
    let mut way = Way {
        problem: *problem,
        treads: Vec::new(),
    };
    let stride = match problem.contact {
        Contact::Rigid(_) => {
            let start = Start::cold(guess.variables(problem));
            way.tread(1.0, problem.mesh, start, FIRST_STEPS)?
        }
        Contact::Compliant(_) => way.start_at(guess)?,
    };
    Ok(Walk {
        treads: way.treads,
        stride,
    })
}

struct Way {
    problem: Problem,
    treads: Vec<Tread>,
}

impl Way {
    fn start_at(&mut self, guess: &Guess) -> Result<Option<Outcome>, ProgrammeError> {
        let coarse = Mesh::default();
        let start = Start::cold(guess.variables(&self.at(0.0, coarse)));
        let Some(first) = self.tread(0.0, coarse, start, FIRST_STEPS)? else {
            return Ok(None);
        };
        let mut trail = self.on(first, 0.0)?;
        while let Some((part, stride)) = trail.pop() {
            let mesh = self.problem.mesh;
            if mesh == coarse && part < 1.0 {
                return Ok(None);
            }
            let start = if mesh == coarse {
                stride.start()
            } else {
                Start::cold(on_mesh(&stride.problem, &stride.x, mesh))
            };
            let Some(read) = self.tread(part, mesh, start, FIRST_STEPS)? else {
                continue;
            };
            if let Some((1.0, last)) = self.on(read, part)?.pop() {
                return Ok(Some(last));
            }
        }
        Ok(None)
    }

    /// Walks on from a stride at `part`, on its mesh, as far as it gets; the certified strides on the way.
    fn on(&mut self, stride: Outcome, part: f64) -> Result<Vec<(f64, Outcome)>, ProgrammeError> {
        let mesh = stride.problem.mesh;
        let mut trail = vec![(part, stride)];
        let mut step = FIRST_PART;
        while let Some((part, stride)) = trail.last()
            && *part < 1.0
            && step >= SMALLEST_PART
        {
            let next = (part + step).min(1.0);
            match self.tread(next, mesh, stride.start(), STEPS)? {
                Some(found) => {
                    trail.push((next, found));
                    step = (GROWTH * step).min(LARGEST_PART);
                }
                None => step /= 2.0,
            }
        }
        Ok(trail)
    }

    /// Solves at `part` of the way; the stride if it is certified.
    fn tread(
        &mut self,
        part: f64,
        mesh: Mesh,
        start: Start,
        steps: usize,
    ) -> Result<Option<Outcome>, ProgrammeError> {
        let case = Case {
            problem: self.at(part, mesh),
            starts: vec![start],
        };
        let options = Options {
            max_iterations: steps,
            ..Options::default()
        };
        let Some(found) = solve_all(&[case], &options)?.pop().flatten() else {
            return Ok(None);
        };
        self.treads.push(Tread {
            part,
            mesh,
            status: found.status,
            cost: found.cost,
            iterations: found.iterations,
        });
        Ok(Some(found).filter(Outcome::is_certified))
    }

    /// The problem at `part` of the way.
    fn at(&self, part: f64, mesh: Mesh) -> Problem {
        let contact = match self.problem.contact {
            Contact::Compliant(last) => Contact::Compliant(between(&last, part)),
            rigid @ Contact::Rigid(_) => rigid,
        };
        Problem {
            contact,
            mesh,
            ..self.problem
        }
    }
}

/// The ground at `part` of the way from [`SOFT`] to `last`.
fn between(last: &Ground, part: f64) -> Ground {
    if part >= 1.0 {
        return *last;
    }
    let ratio = |first: f64, last: f64| first * (last / first).powf(part);
    Ground {
        stiffness_n_m15: ratio(SOFT.stiffness_n_m15, last.stiffness_n_m15),
        loss_s_m: SOFT.loss_s_m + part * (last.loss_s_m - SOFT.loss_s_m),
        slip_scale_m_s: ratio(SOFT.slip_scale_m_s, last.slip_scale_m_s),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_way_leads_from_the_soft_ground_to_the_wanted_one() {
        let last = Ground {
            stiffness_n_m15: 2e5,
            loss_s_m: 1.0,
            slip_scale_m_s: 0.1,
        };
        assert_eq!(between(&last, 0.0), SOFT);
        assert_eq!(between(&last, 1.0), last);
        let half = between(&last, 0.5);
        let middle = (2e4_f64 * 2e5).sqrt();
        assert!((half.stiffness_n_m15 / middle - 1.0).abs() < 1e-12);
        assert!((half.loss_s_m - 0.5).abs() < 1e-12);
    }
}

//! A law that moves towards another one within a run, by a share S along it.
//!
//! The contact is carried through the run under the law that is left and under the one that is approached, and friction stands between
//! the two,
//!
//! ```text
//! mu(t) = mu_0(t) + S(t) (mu_1(t) - mu_0(t))                                                             (R10)
//! ```
//!
//! exact at both ends, and in between to the second order of what moves. On a cord the law stands still at the run's mean share.

use friction::{IntegrationError, Law};

use crate::chain::{Contact, Pass};
use crate::refined::between;
use crate::{Cause, ChainScalar, Hook, Place, Reach};

/// A law on the way to another one within a run.
pub(crate) struct Move<D> {
    /// The law that is approached.
    towards: Law<D>,
    /// S of (R10) at the samples.
    share: Vec<D>,
}

impl<D: ChainScalar> Pass<'_, D> {
    /// How the law moves within a run. On a cord it is set to where it stands on average, and does not move.
    pub(crate) fn moves(
        &self,
        at: Place<'_>,
        law: &mut Law<D>,
        memories: &mut [Vec<D>],
        corded: bool,
    ) -> Vec<Move<D>> {
        let mut moves = Vec::new();
        let left = *law;
        self.each_with_memory(Reach::Along, memories, |cause, p, memory| {
            let held = memory.len();
            let moved = |law: &mut Law<D>, share: D| {
                let mut at_share = vec![share; held];
                let hook = Hook::Law {
                    law,
                    memory: &mut at_share,
                };
                D::call(cause, p, at, hook);
            };
            let mut towards = left;
            moved(&mut towards, D::constant(1.0));
            let share = shares(cause, p, at, memory);
            if corded {
                let sum = share.iter().fold(D::constant(0.0), |sum, &s| sum + s);
                moved(law, sum / share.len() as f64);
            } else {
                moves.push(Move { towards, share });
            }
        });
        moves
    }

    /// Coefficient of friction on the grid of the run, (R10).
    pub(crate) fn coefficients(
        &self,
        contact: &Contact<'_, D>,
    ) -> Result<Vec<D>, IntegrationError> {
        let record = contact.driven.record();
        let walk = |slot: usize, law: &Law<D>| {
            let run = contact.index + slot * self.experiment.runs.len();
            self.walks
                .coefficients(run, law, &record, contact.initial, self.state_varies)
        };
        let left = walk(0, contact.law)?;
        if contact.moves.is_empty() {
            return Ok(left);
        }
        let mut all = left.clone();
        for (k, way) in contact.moves.iter().enumerate() {
            let towards = walk(k + 1, &way.towards)?;
            let share = between(&way.share, contact.driven.parts);
            for (i, mu) in all.iter_mut().enumerate() {
                *mu += (towards[i] - left[i]) * share[i];
            }
        }
        Ok(all)
    }
}

fn shares<D: ChainScalar>(cause: &dyn Cause, p: &[D], at: Place<'_>, memory: &mut [D]) -> Vec<D> {
    let mut share = vec![D::constant(0.0); at.run.len()];
    let hook = Hook::Along {
        share: &mut share,
        memory,
    };
    D::call(cause, p, at, hook);
    share
}

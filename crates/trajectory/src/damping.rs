//! Levenberg's damping of the convex subproblem.
//!
//! Where the clipped Hessian has (almost) no curvature and no constraint holds
//! the step, the subproblem's minimiser runs far beyond what its linearisation
//! knows. `H + δI` keeps it within reach: δ rises when a step is out of
//! proportion, when the line search cuts it to pieces, or when Clarabel meets a
//! matrix it cannot resolve, and falls tenfold with every full step.

/// Steps longer than this (scaled variables) are not trusted.
const REACH: f64 = 100.0;
/// Length that the damping aims at for a step that was too long.
const AIM: f64 = 10.0;
/// Damping below this is dropped.
const NEGLIGIBLE: f64 = 1e-8;
/// First damping that is tried.
const FIRST: f64 = 1e-3;
/// Largest damping.
const LARGEST: f64 = 1e2;

/// The present damping δ ≥ 0.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Damping(pub f64);

impl Damping {
    /// Is a step of this length within reach?
    pub(crate) fn trusts(length: f64) -> bool {
        length <= REACH
    }

    /// A step of `length` came from curvature `floor + δ`: the same pull is to move `AIM`.
    pub(crate) fn shorten(&mut self, length: f64, floor: f64) {
        self.0 = ((floor + self.0) * length / AIM).min(LARGEST);
    }

    /// The subproblem could not be resolved.
    pub(crate) fn stiffen(&mut self) {
        self.0 = (10.0 * self.0).clamp(FIRST, LARGEST);
    }

    /// A step of length `alpha` was accepted.
    pub(crate) fn learn(&mut self, alpha: f64) {
        if alpha >= 0.9 {
            self.0 *= 0.1;
            if self.0 < NEGLIGIBLE {
                self.0 = 0.0;
            }
        } else if alpha < 0.3 {
            self.0 = (10.0 * self.0).clamp(FIRST, LARGEST);
        }
    }
}

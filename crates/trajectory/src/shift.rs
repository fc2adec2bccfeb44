//! The shift of the Hessian in Newton's step, and how far such a step may reach.
//!
//! Where the reduced Hessian is indefinite, `H + δI` with a δ just above its most negative eigenvalue makes a step of any length
//! along that direction; a larger δ makes it shorter. So δ does two things, and both are asked for: an inertia that makes the step a
//! minimiser, and a length that is neither beyond the reach nor far below it (a trust region, without its exact radius).

/// Longer steps (scaled variables) are never believed: scales make variables of order one, and an active set says
/// nothing about points several of its own sizes away.
const FARTHEST: f64 = 3.0;
/// The reach does not fall below this.
pub(crate) const NEAREST: f64 = 0.05;
/// A step shorter than this share of the reach is tried again with a smaller shift,
const SHORT: f64 = 0.5;
/// unless that lies within this factor of one that failed.
const NARROW: f64 = 2.0;

/// The shift δ of the Hessian's diagonal that makes its reduced form positive definite.
///
/// None is tried first at every point; then a third of the last one that was needed, then larger ones by a
/// constant factor, or by what the step was too long (Wächter and Biegler, Mathematical Programming 106, 2006, algorithm IC, whose numbers these are).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shift {
    /// The last shift that was needed.
    pub last: f64,
    /// The longest step (scaled variables) that is believed.
    pub reach: f64,
}

impl Default for Shift {
    fn default() -> Self {
        Self {
            last: 0.0,
            reach: FARTHEST,
        }
    }
}

impl Shift {
    const FIRST: f64 = 1e-4;
    const LEAST: f64 = 1e-8;
    const LARGEST: f64 = 1e8;
    const FALL: f64 = 1.0 / 3.0;
    const GROWTH: f64 = 8.0;
    const FIRST_GROWTH: f64 = 100.0;

    /// The line search accepted the share `alpha` of a step of this length.
    pub(crate) fn learn(&mut self, alpha: f64, length: f64) {
        if alpha < 0.3 {
            self.reach = (2.0 * alpha * length).max(NEAREST);
        } else if alpha >= 0.9 {
            self.reach = (2.0 * self.reach).min(FARTHEST);
        }
    }

    /// What to try where `failed` left an indefinite Hessian or exchanges without end; `None` if even the largest did not do.
    pub(crate) fn larger(self, failed: f64) -> Option<f64> {
        let next = match (failed == 0.0, self.last == 0.0) {
            (true, true) => Self::FIRST,
            (true, false) => (Self::FALL * self.last).max(Self::LEAST),
            (false, true) => Self::FIRST_GROWTH * failed,
            (false, false) => Self::GROWTH * failed,
        };
        (next <= Self::LARGEST).then_some(next)
    }

    /// What to try where the step with `failed` was as long as this.
    pub(crate) fn shortening(self, failed: f64, length: f64) -> Option<f64> {
        if failed == 0.0 {
            self.larger(failed)
        } else {
            let next = failed * (length / self.reach).clamp(2.0, Self::GROWTH);
            (next <= Self::LARGEST).then_some(next)
        }
    }

    /// What to try after a step of this length with the shift `good`, where `failed` is the largest shift that failed; `None`
    /// if the step is long enough or nothing is left between the two.
    pub(crate) fn smaller(self, good: f64, length: f64, failed: f64) -> Option<f64> {
        if length > SHORT * self.reach || good <= NARROW * failed {
            return None;
        }
        let least = good * (length / self.reach).max(1.0 / Self::GROWTH);
        Some((failed * good).sqrt().max(least))
    }
}

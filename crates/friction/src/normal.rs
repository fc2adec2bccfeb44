//! Normal contact: a Hertz spring with loss.
//!
//! N = k (d^2 + eps)^(3/4) (1 + 3/2 c d') for d > 0, and N >= 0; d is the indentation in m, d' its rate in m/s
//! (d' = -v_y of the foot). The small eps = 1e-8 m^2 keeps the power smooth at touchdown. Loss as in Hunt and Crossley
//! (J. Applied Mechanics 42, 1975).

use crate::Scalar;

/// Hertz contact with loss.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hertz<D> {
    /// Stiffness k, N/m^1.5.
    pub stiffness: D,
    /// Loss c, s/m.
    pub loss: D,
    /// Smoothing eps, m^2.
    pub smoothing: f64,
}

impl<D: Scalar> Hertz<D> {
    /// Contact of stiffness k (N/m^1.5) and loss c (s/m) with the usual smoothing.
    pub fn new(stiffness: D, loss: D) -> Self {
        Self {
            stiffness,
            loss,
            smoothing: 1e-8,
        }
    }

    /// Normal force in N, never below zero, at indentation d (m, positive inside) and rate d' (m/s, positive inward).
    pub fn force(&self, indentation: D, rate: D) -> D {
        if indentation.value() <= 0.0 {
            return D::constant(0.0);
        }
        let force = self.signed_force(indentation, rate);
        if force.value() < 0.0 {
            D::constant(0.0)
        } else {
            force
        }
    }

    /// The same expression without the cut at zero: smooth, for solvers that hold N >= 0 as a constraint.
    pub fn signed_force(&self, indentation: D, rate: D) -> D {
        let radius = indentation * indentation + self.smoothing;
        // (d^2 + eps)^(3/4)
        self.stiffness * radius.powf(0.75) * (self.loss * rate * 1.5 + 1.0)
    }
}

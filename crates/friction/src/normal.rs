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

#[cfg(test)]
mod tests {
    use num_dual::DualSVec64;

    use super::*;

    #[test]
    fn a_sphere_on_a_plane_follows_the_three_halves_power() {
        // k = 4/3 E* sqrt(R) (Hertz 1882); eps = 1e-8 m^2 is felt below a tenth of a millimetre only
        let contact = Hertz::new(2e5, 0.0);
        for depth in [1e-3, 5e-3, 0.02] {
            let exact = 2e5 * f64::powf(depth, 1.5);
            assert!((contact.force(depth, 0.0) / exact - 1.0).abs() < 0.01);
        }
    }

    #[test]
    fn loss_adds_on_the_way_in_and_never_pulls() {
        let contact = Hertz::new(2e5, 1.0);
        assert!(contact.force(0.01, 0.1) > contact.force(0.01, 0.0));
        let ratio: f64 = contact.force(0.01, 0.1) / contact.force(0.01, 0.0);
        assert!((ratio - 1.15).abs() < 1e-12);
        assert_eq!(contact.force(0.01, -5.0), 0.0);
        assert!(contact.signed_force(0.01, -5.0) < 0.0);
        assert_eq!(contact.force(-1e-3, 1.0), 0.0);
    }

    #[test]
    fn a_closed_cycle_costs_energy() {
        let contact = Hertz::new(1e5, 0.5);
        let n = 2000;
        let work: f64 = (0..n)
            .map(|i| {
                let phase = std::f64::consts::TAU * f64::from(i) / f64::from(n);
                let (depth, rate) = (0.01 * (1.0 - phase.cos()), 0.01 * phase.sin());
                contact.force(depth, rate) * rate
            })
            .sum();
        assert!(work > 0.0);
    }

    #[test]
    fn derivatives_agree_with_differences() {
        let depth = DualSVec64::<2>::from_re(0.01).derivative(0);
        let rate = DualSVec64::<2>::from_re(0.2).derivative(1);
        let force =
            Hertz::new(DualSVec64::from_re(1e5), DualSVec64::from_re(0.5)).force(depth, rate);
        let at = |d: f64, r: f64| Hertz::new(1e5, 0.5).force(d, r);
        let slopes = [
            (at(0.01 + 1e-7, 0.2) - at(0.01 - 1e-7, 0.2)) / 2e-7,
            (at(0.01, 0.2 + 1e-6) - at(0.01, 0.2 - 1e-6)) / 2e-6,
        ];
        let eps = force.eps.0.expect("seeded");
        assert!((0..2).all(|i| (eps[i] / slopes[i] - 1.0).abs() < 1e-6));
    }
}

//! E3-E7 in the paper's own seven parameters and units: a path of its own beside crate `friction`, for the audit.
//!
//! ```text
//! w         = (v/h) cos^2(theta + theta0)                              E4
//! theta'    = w - sigma |w| theta / g(w)                               E3
//! g(w)      = theta_c + (theta_s - theta_c) exp(-abs(w/omega_sc)^n)    E5, n = 2
//! mu        = (sigma0 theta + sigma1 theta' + sigma2 w) cos^2          E7
//! ```

use friction::{CosinePlacement, Exponent, Law, LawError, LawKind};

use crate::published::LawNumbers;

/// Where the cosine factor stands in E7.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Placement {
    AllTerms,
    StiffnessOnly,
}

/// The law with its geometry.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bristle {
    pub(super) p: LawNumbers,
    /// Gap h, m.
    pub(super) height_m: f64,
    /// Lean theta0, rad.
    pub(super) lean: f64,
    pub(super) placement: Placement,
    /// Exponent n of E5, which the text that we have does not show.
    pub(super) exponent: Exponent<f64>,
}

/// Terms of E7 at one instant.
#[derive(Clone, Copy, Debug)]
pub(super) struct Terms {
    pub(super) stiffness: f64,
    pub(super) damping: f64,
    pub(super) viscous: f64,
    pub(super) mu: f64,
}

impl Bristle {
    fn cos2(&self, theta: f64) -> f64 {
        (theta + self.lean).cos().powi(2)
    }

    fn level(&self, w: f64) -> f64 {
        let ratio = w / self.p.omega_sc;
        let power = match self.exponent {
            Exponent::Two => ratio.powi(2),
            Exponent::Half => ratio.abs().sqrt(),
            Exponent::General(n) => ratio.abs().powf(n),
        };
        self.p.theta_c + (self.p.theta_s - self.p.theta_c) * (-power).exp()
    }

    fn rate(&self, theta: f64, v: f64) -> f64 {
        let w = v / self.height_m * self.cos2(theta);
        w - self.p.sigma * w.abs() * theta / self.level(w)
    }

    /// The terms of E7, each with its cosine factor.
    pub(super) fn terms(&self, theta: f64, v: f64) -> Terms {
        let cos2 = self.cos2(theta);
        let w = v / self.height_m * cos2;
        let factor = if self.placement == Placement::AllTerms {
            cos2
        } else {
            1.0
        };
        let stiffness = self.p.sigma0 * theta * cos2;
        let damping = self.p.sigma1 * self.rate(theta, v) * factor;
        let viscous = self.p.sigma2 * w * factor;
        Terms {
            stiffness,
            damping,
            viscous,
            mu: stiffness + damping + viscous,
        }
    }

    /// Steady state at speed v: theta = sign(v) g(w(theta))/sigma, by fixed point iteration (g depends weakly on theta).
    pub(super) fn steady(&self, v: f64) -> Terms {
        let mut theta = v.signum() * self.p.theta_c / self.p.sigma;
        for _ in 0..400 {
            let w = v / self.height_m * self.cos2(theta);
            let next = v.signum() * self.level(w) / self.p.sigma;
            if next == theta {
                break;
            }
            theta = next;
        }
        self.terms(theta, v)
    }

    /// Mean of |mu| in steady state between two speeds (both of one sign), by the midpoint rule.
    pub(super) fn mean_steady(&self, from: f64, to: f64) -> f64 {
        const CELLS: usize = 200;
        let speed = |cell: usize| from + (to - from) * (cell as f64 + 0.5) / CELLS as f64;
        (0..CELLS)
            .map(|cell| self.steady(speed(cell)).mu.abs())
            .sum::<f64>()
            / CELLS as f64
    }

    /// The same law as crate `friction` has it.
    pub(super) fn law(&self) -> Result<Law<f64>, LawError> {
        let p = &self.p;
        let numbers = [
            p.theta_c / p.sigma,
            p.theta_s / p.sigma,
            p.sigma0,
            p.sigma1,
            p.sigma2,
            p.omega_sc,
            self.lean,
        ];
        let placement = match self.placement {
            Placement::AllTerms => CosinePlacement::AllTerms,
            Placement::StiffnessOnly => CosinePlacement::StiffnessOnly,
        };
        let law = LawKind::AsymmetricBristle.build(&numbers, Some(self.height_m))?;
        Ok(law.with_placement(placement).with_exponent(self.exponent))
    }

    /// A ramp from rest: v = a t over `duration`, classical Runge-Kutta of order four on `steps` steps.
    pub(super) fn ramp(&self, acceleration: f64, duration: f64, steps: usize) -> Vec<Terms> {
        let dt = duration / steps as f64;
        let mut theta = 0.0;
        let mut record = vec![self.terms(theta, 0.0)];
        for step in 0..steps {
            let t = step as f64 * dt;
            let k1 = self.rate(theta, acceleration * t);
            let k2 = self.rate(theta + 0.5 * dt * k1, acceleration * (t + 0.5 * dt));
            let k3 = self.rate(theta + 0.5 * dt * k2, acceleration * (t + 0.5 * dt));
            let k4 = self.rate(theta + dt * k3, acceleration * (t + dt));
            theta += dt / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
            record.push(self.terms(theta, acceleration * (t + dt)));
        }
        record
    }
}

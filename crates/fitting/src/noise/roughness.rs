//! Roughness smoother than an exponential covariance.
//!
//! A field of correlation length l that has passed a first-order filter of length rho l, 0 <= rho < 1, has
//!
//! ```text
//! cov(s) = [exp(-s / l) - rho exp(-s / (rho l))] / (1 - rho)                                             (N7)
//! ```
//!
//! times its variance: exponential for rho = 0, towards rho = 1 the covariance of Matern's class of order 3/2. Along a run it is the
//! first of two states, u behind its driver v,
//!
//! ```text
//! u' = (v - u) / (rho l),   v' = -v / l + white noise,   var v = (1 + rho) var u,   cov(u, v) = var u
//! ```

use super::context::Sizes;

/// The roughness of a surface, of unit variance.
#[derive(Clone, Copy, Debug)]
pub struct Roughness {
    length: f64,
    share: f64,
}

impl Roughness {
    /// The roughness private to a run.
    pub fn private(sizes: &Sizes) -> Self {
        Self {
            length: sizes.length,
            share: sizes.smoothing,
        }
    }

    /// The roughness fixed to the plate.
    pub fn of_plate(sizes: &Sizes) -> Self {
        Self {
            length: sizes.plate_length(),
            share: if sizes.plate_smoothing > 0.0 {
                sizes.plate_smoothing
            } else {
                sizes.smoothing
            },
        }
    }

    /// l of (N7).
    pub(super) fn length(self) -> f64 {
        self.length
    }

    /// Whether the covariance is exponential.
    pub(super) fn is_exponential(self) -> bool {
        self.share == 0.0
    }

    /// (N7) at distance `s`.
    pub(super) fn correlation(self, s: f64) -> f64 {
        let [fast, slow] = self.decays(s);
        (slow - self.share * fast) / (1.0 - self.share)
    }

    /// exp(-s / (rho l)) and exp(-s / l).
    pub(super) fn decays(self, s: f64) -> [f64; 2] {
        let fast = if self.is_exponential() && s > 0.0 {
            0.0
        } else if s == 0.0 {
            1.0
        } else {
            (-s / (self.share * self.length)).exp()
        };
        [fast, (-s / self.length).exp()]
    }

    /// What a step of `s` hands on: u = `fast` u + `feed` v, v = `slow` v.
    pub(super) fn step(self, s: f64) -> Step {
        let [fast, slow] = self.decays(s);
        Step {
            fast,
            feed: (slow - fast) / (1.0 - self.share),
            slow,
        }
    }

    /// var v over var u.
    pub(super) fn driver(self) -> f64 {
        1.0 + self.share
    }

    /// A path at places that do not decrease, from independent numbers N(0, 1).
    pub fn path(self, places: &[f64], mut draw: impl FnMut() -> f64) -> Vec<f64> {
        let (mut u, mut v) = (0.0, 0.0);
        let mut out = Vec::with_capacity(places.len());
        for (k, place) in places.iter().enumerate() {
            let step = match k {
                0 => Step::fresh(),
                _ => self.step(place - places[k - 1]),
            };
            let [along, across, rest] = self.root_of_noise(step);
            let noise = draw();
            (u, v) = (step.fast * u + step.feed * v, step.slow * v);
            u += along * noise;
            if !self.is_exponential() {
                v += across * noise + rest * draw();
            } else {
                v = u;
            }
            out.push(u);
        }
        out
    }

    /// Lower root of what a step adds to the covariance of (u, v), S - Phi S Phi'.
    fn root_of_noise(self, step: Step) -> [f64; 3] {
        let Step { fast, feed, slow } = step;
        let of_v = self.driver();
        let uu = 1.0 - (fast * fast + 2.0 * fast * feed + feed * feed * of_v);
        let uv = 1.0 - slow * (fast + feed * of_v);
        let vv = of_v * (1.0 - slow * slow);
        let along = uu.max(0.0).sqrt();
        let across = if along > 0.0 { uv / along } else { 0.0 };
        [along, across, (vv - across * across).max(0.0).sqrt()]
    }

    /// Coefficients of the recursion over equidistant nodes that has the field's two decays, q_j = a q_{j+1} + b q_{j+2} + noise:
    /// a, b, the noise's variance over the field's, and the correlation of neighbours.
    pub(super) fn nodes(self, spacing: f64) -> [f64; 4] {
        let [fast, slow] = self.decays(spacing);
        let both = fast * slow;
        let noise = (1.0 - both) * (1.0 - slow * slow) * (1.0 - fast * fast) / (1.0 + both);
        [slow + fast, -both, noise, (slow + fast) / (1.0 + both)]
    }
}

impl Step {
    /// Nothing is left of before.
    fn fresh() -> Self {
        Self {
            fast: 0.0,
            feed: 0.0,
            slow: 0.0,
        }
    }
}

/// One step of the two states.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    pub(super) fast: f64,
    pub(super) feed: f64,
    pub(super) slow: f64,
}

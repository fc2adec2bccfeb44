//! The Stribeck curve g(u): the level towards which friction settles at speed u.
//!
//! E5: g(u) = k + (s - k) exp(-abs(u/u_s)^p), k the kinetic and s the static level. p = 2 is inferred for the bristle
//! laws (the source's equation is lost), p = 1/2 belongs to the tyre form, and a free p is an axis of the multiverse.

use crate::Scalar;

/// Exponent of the Stribeck curve. Two has a branch of its own: `exp(2 ln x)` is not `x * x` bit for bit, and the
/// derivative of a general power is undefined at the rest from which every run starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exponent<D> {
    /// p = 2 (Gauss).
    Two,
    /// p = 1/2 (tyre form), rounded off below u/u_s = 1e-6 so that its slope stays finite.
    Half,
    /// Any p > 0.
    General(D),
}

/// g(u) with its parameters; the levels are deflections (rad, m) in dynamic laws and coefficients in static ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StribeckCurve<D> {
    /// Level at high speed.
    pub kinetic: D,
    /// Level at rest.
    pub at_rest: D,
    /// Speed scale u_s; `None`: no Stribeck effect, g = kinetic.
    pub speed: Option<D>,
    /// Exponent p.
    pub exponent: Exponent<D>,
    /// What rest makes larger.
    pub aged: Aged,
}

/// The part of a Stribeck curve that is multiplied by the gain of an aged contact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Aged {
    /// The static level s.
    #[default]
    StaticLevel,
    /// The curve as a whole, the kinetic level k included.
    Whole,
}

/// Below this ratio of speeds the square root of the tyre form is rounded off.
const ROUNDING: f64 = 1e-6;
/// exp(-40) is below the rounding of the sum it enters.
const NEGLIGIBLE: f64 = 40.0;

impl<D: Scalar> StribeckCurve<D> {
    /// A curve without a Stribeck effect.
    pub fn flat(level: D) -> Self {
        Self {
            kinetic: level,
            at_rest: level,
            speed: None,
            exponent: Exponent::Two,
            aged: Aged::StaticLevel,
        }
    }

    /// (g, dg/du) at speed u >= 0. What has aged is multiplied by `rest_gain` (1 unless the contact has).
    #[inline]
    pub fn level(&self, u: D, rest_gain: Option<D>) -> (D, D) {
        let kinetic = match (self.aged, rest_gain) {
            (Aged::Whole, Some(gain)) => self.kinetic * gain,
            _ => self.kinetic,
        };
        let flat = (kinetic, D::constant(0.0));
        let Some(scale) = self.speed else { return flat };
        let at_rest = rest_gain.map_or(self.at_rest, |gain| self.at_rest * gain);
        let Some((power, slope)) = self.power(u / scale) else {
            return flat;
        };
        // g = k + (s - k) exp(-X)
        let fade = (at_rest - kinetic) * (-power).exp();
        (kinetic + fade, -fade * slope / scale)
    }

    /// X = x^p and dX/dx at a ratio of speeds x; `None` where exp(-X) is nothing.
    #[inline(always)]
    pub(crate) fn power(&self, x: D) -> Option<(D, D)> {
        let (power, slope) = match self.exponent {
            Exponent::Two => (x * x, x * 2.0),
            Exponent::Half => {
                let root = (x * x + ROUNDING * ROUNDING).sqrt();
                let power = root.sqrt();
                (power - ROUNDING.sqrt(), x / (root * power * 2.0))
            }
            Exponent::General(p) => {
                if x.value() <= 0.0 {
                    (D::constant(0.0), D::constant(0.0))
                } else {
                    let power = (p * x.ln()).exp();
                    (power, p * power / x)
                }
            }
        };
        (power.value() <= NEGLIGIBLE).then_some((power, slope))
    }

    /// Only the real parts.
    pub fn real(&self) -> StribeckCurve<f64> {
        StribeckCurve {
            kinetic: self.kinetic.value(),
            at_rest: self.at_rest.value(),
            speed: self.speed.map(|s| s.value()),
            exponent: match self.exponent {
                Exponent::Two => Exponent::Two,
                Exponent::Half => Exponent::Half,
                Exponent::General(p) => Exponent::General(p.value()),
            },
            aged: self.aged,
        }
    }
}

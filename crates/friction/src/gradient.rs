//! Slopes of the state's rate and of the coefficient of friction by everything they depend on, in `f64`: with them a dual number
//! costs one weighted sum of derivatives for each argument (E3 to E5 and E7 differentiated by hand).
//!
//! With G = c/h, y = u G, L = A g(y) the level on this side of zero, w = v G and sgn the side:
//!
//! ```text
//! z'      = w (1 - sgn z/L)
//! dz'/dL  = w sgn z/L^2                  dz'/dG = v (1 - sgn z/L) + dz'/dL dL/dy u
//! dz'/dz  = dz'/dG dG/dz - sgn w/L       dz'/d theta0 = dz'/dG dG/dz
//! mu      = sigma0 z T + (sigma1 z' + sigma2 B w) P          T, P: c or 1 by the place of the cosine (E7)
//! ```

use crate::law::{CosinePlacement, Drive, Law, Lever};
use crate::{Aged, Exponent, Scalar, StribeckCurve};

/// Parameters on which the rate depends: kinetic level, level at rest, speed scale, exponent, lean, Coulomb asymmetry.
const OF_THE_RATE: usize = 6;
/// Those of the coefficient besides: viscous asymmetry, sigma0, sigma1, sigma2.
const OF_THE_COEFFICIENT: usize = 4;

/// A law whose derivatives are taken by slopes: its values, and those of its parameters that carry derivatives.
#[derive(Clone, Debug)]
pub struct Followed<D> {
    whole: Law<D>,
    pub(crate) law: Law<f64>,
    of_the_rate: Vec<(usize, D)>,
    of_the_coefficient: Vec<(usize, D)>,
}

/// A rate z' with its slopes.
#[derive(Clone, Copy)]
pub(crate) struct RateSlopes {
    pub(crate) rate: f64,
    /// By the state.
    pub(crate) z: f64,
    /// By the slip speed, the curve's speed held.
    pub(crate) velocity: f64,
    /// By the speed at which the curve is read.
    pub(crate) curve_speed: f64,
    /// By the factor on the static level.
    pub(crate) rest_gain: f64,
    /// By the law's parameters.
    pub(crate) law: [f64; OF_THE_RATE],
}

/// g(u) with its slopes.
struct LevelSlopes {
    level: f64,
    speed: f64,
    rest_gain: f64,
    /// By kinetic level, level at rest, scale, exponent.
    curve: [f64; 4],
}

impl<D: Scalar> Followed<D> {
    /// Of a law.
    pub fn new(law: &Law<D>) -> Self {
        let none = D::constant(0.0);
        let exponent = match law.curve.exponent {
            Exponent::General(p) => p,
            _ => none,
        };
        let of_the_rate: [D; OF_THE_RATE] = [
            law.curve.kinetic,
            law.curve.at_rest,
            law.curve.speed.unwrap_or(none),
            exponent,
            law.lean.map_or(none, |lean| lean.angle),
            law.asymmetry.map_or(none, |a| a.coulomb),
        ];
        let of_the_coefficient: [D; OF_THE_COEFFICIENT] = [
            law.asymmetry.map_or(none, |a| a.viscous),
            law.stiffness,
            law.damping,
            law.viscous,
        ];
        Self {
            whole: *law,
            law: law.real(),
            of_the_rate: varying(&of_the_rate),
            of_the_coefficient: varying(&of_the_coefficient),
        }
    }

    /// Parameters that move the rate, each with the slope by it.
    #[inline(always)]
    pub(crate) fn of_the_rate<'a>(
        &'a self,
        slopes: &'a [f64; OF_THE_RATE],
    ) -> impl Iterator<Item = (&'a D, f64)> {
        self.of_the_rate.iter().map(|(k, x)| (x, slopes[*k]))
    }

    /// z' with derivatives.
    #[inline(always)]
    fn with_rate<'a>(
        &'a self,
        z: &'a D,
        drive: &'a Drive<D>,
        slopes: &'a RateSlopes,
    ) -> impl Iterator<Item = (&'a D, f64)> {
        [
            (z, slopes.z),
            (&drive.velocity, slopes.velocity),
            (&drive.curve_speed, slopes.curve_speed),
        ]
        .into_iter()
        .chain(drive.rest_gain.iter().map(|gain| (gain, slopes.rest_gain)))
        .chain(self.of_the_rate(&slopes.law))
    }

    /// mu of a law with a state, with derivatives.
    #[inline(always)]
    pub(crate) fn coefficient(&self, z: &D, drive: &Drive<D>) -> D {
        let (_, slopes) = self.law.slopes(z.value(), &drive.real());
        self.follow_coefficient(z, drive, &slopes)
    }

    /// (z', mu), as [`Law::rate_and_coefficient`].
    #[inline]
    pub fn rate_and_coefficient(&self, z: &D, drive: &Drive<D>) -> (D, D) {
        if !self.law.is_dynamic() {
            return self.whole.rate_and_coefficient(*z, drive);
        }
        let (rate, slopes) = self.law.slopes(z.value(), &drive.real());
        (
            D::along(rate.rate, self.with_rate(z, drive, &rate)),
            self.follow_coefficient(z, drive, &slopes),
        )
    }

    #[inline(always)]
    fn follow_coefficient(&self, z: &D, drive: &Drive<D>, slopes: &CoefficientSlopes) -> D {
        let moved = self.with_rate(z, drive, &slopes.along_the_rate);
        let own = (self.of_the_coefficient.iter()).map(|(k, x)| (x, slopes.own[*k]));
        D::along(slopes.along_the_rate.rate, moved.chain(own))
    }
}

fn varying<D: Scalar>(numbers: &[D]) -> Vec<(usize, D)> {
    (numbers.iter().copied().enumerate())
        .filter(|(_, x)| x.varies())
        .collect()
}

/// A coefficient mu with its slopes.
struct CoefficientSlopes {
    /// mu in the place of the rate, with the slopes by all that moves the rate.
    along_the_rate: RateSlopes,
    own: [f64; OF_THE_COEFFICIENT],
}

impl Law<f64> {
    /// z' with all its slopes.
    #[inline(always)]
    pub(crate) fn rate_with_slopes(&self, z: f64, drive: &Drive<f64>) -> RateSlopes {
        self.rate_at(z, drive, &self.lever(z))
    }

    #[inline(always)]
    fn rate_at(&self, z: f64, drive: &Drive<f64>, lever: &Lever<f64>) -> RateSlopes {
        let turned = self.asymmetry.filter(|a| drive.sign < 0.0 && !a.jumps);
        let factor = turned.map_or(1.0, |a| a.coulomb + 1.0);
        let curve = self
            .curve
            .slopes(drive.curve_speed * lever.gear, drive.rest_gain);
        let inverse = 1.0 / (curve.level * factor);
        let w = drive.velocity * lever.gear;
        let signed = drive.sign * z * inverse;
        let left = 1.0 - signed;
        let by_level = w * signed * inverse;
        let by_curve = by_level * factor;
        let by_gear = drive.velocity * left + by_curve * curve.speed * drive.curve_speed;
        let by_angle = by_gear * lever.gear_z;
        RateSlopes {
            rate: w * left,
            z: by_angle - w * drive.sign * inverse,
            velocity: lever.gear * left,
            curve_speed: by_curve * curve.speed * lever.gear,
            rest_gain: by_curve * curve.rest_gain,
            law: [
                by_curve * curve.curve[0],
                by_curve * curve.curve[1],
                by_curve * curve.curve[2],
                by_curve * curve.curve[3],
                if self.lean.is_some() { by_angle } else { 0.0 },
                if turned.is_some() {
                    by_level * curve.level
                } else {
                    0.0
                },
            ],
        }
    }

    #[inline(always)]
    fn slopes(&self, z: f64, drive: &Drive<f64>) -> (RateSlopes, CoefficientSlopes) {
        let lever = self.lever(z);
        let r = self.rate_at(z, drive, &lever);
        let w = drive.velocity * lever.gear;
        let turned = self.asymmetry.filter(|_| drive.sign < 0.0);
        let factor = turned.map_or(1.0, |a| a.viscous + 1.0);
        let viscous = self.viscous * factor;
        // a force that jumps with the direction: sigma0 and sigma1 on this side of zero
        let jumping = turned.filter(|a| a.jumps);
        let bristles = jumping.map_or(1.0, |a| a.coulomb + 1.0);
        let (stiffness, damping) = (self.stiffness * bristles, self.damping * bristles);
        let losses = damping * r.rate + viscous * w;
        let elastic = stiffness * z;
        // T and P of E7, and what turns with the bristle
        let all = self
            .lean
            .is_none_or(|lean| lean.placement == CosinePlacement::AllTerms);
        let (p, turning) = if all {
            (lever.projection, elastic + losses)
        } else {
            (1.0, elastic)
        };
        let by_lever = turning * lever.projection_z + p * viscous * drive.velocity * lever.gear_z;
        let scaled = p * damping;
        let mut law = r.law.map(|slope| scaled * slope);
        if jumping.is_some() {
            law[5] = self.stiffness * z * lever.projection + p * self.damping * r.rate;
        }
        if self.lean.is_some() {
            law[4] += by_lever;
        }
        let along_the_rate = RateSlopes {
            rate: turning * lever.projection + if all { 0.0 } else { losses },
            z: stiffness * lever.projection + scaled * r.z + by_lever,
            velocity: scaled * r.velocity + p * viscous * lever.gear,
            curve_speed: scaled * r.curve_speed,
            rest_gain: scaled * r.rest_gain,
            law,
        };
        let by_asymmetry = turned.map_or(0.0, |_| p * self.viscous * w);
        let own = [
            by_asymmetry,
            bristles * z * lever.projection,
            bristles * p * r.rate,
            p * factor * w,
        ];
        (
            r,
            CoefficientSlopes {
                along_the_rate,
                own,
            },
        )
    }
}

impl StribeckCurve<f64> {
    #[inline(always)]
    fn slopes(&self, u: f64, rest_gain: Option<f64>) -> LevelSlopes {
        let gain = rest_gain.unwrap_or(1.0);
        // what the kinetic level is multiplied by, and its slope by the gain
        let (share, of_gain) = match self.aged {
            Aged::Whole => (gain, self.kinetic),
            Aged::StaticLevel => (1.0, 0.0),
        };
        let kinetic = self.kinetic * share;
        let flat = LevelSlopes {
            level: kinetic,
            speed: 0.0,
            rest_gain: of_gain,
            curve: [share, 0.0, 0.0, 0.0],
        };
        let Some(scale) = self.speed else { return flat };
        let x = u / scale;
        let Some((power, slope)) = self.power(x) else {
            return flat;
        };
        let exp = (-power).exp();
        let fade = (self.at_rest * gain - kinetic) * exp;
        let speed = -fade * slope / scale;
        let exponent = match self.exponent {
            Exponent::General(_) if x > 0.0 => -fade * power * x.ln(),
            _ => 0.0,
        };
        LevelSlopes {
            level: kinetic + fade,
            speed,
            rest_gain: of_gain * (1.0 - exp) + self.at_rest * exp,
            curve: [share * (1.0 - exp), gain * exp, -speed * x, exponent],
        }
    }
}

#[cfg(test)]
mod tests {
    use num_dual::DualSVec64;

    use super::*;
    use crate::LawKind;

    type Dual = DualSVec64<14>;

    fn seeded(value: f64, lane: usize) -> Dual {
        Dual::from_re(value).derivative(lane)
    }

    /// Leaning bristles with every parameter and everything that drives them on a lane of its own; `other`: with the other forms of
    /// asymmetry and ageing.
    fn law(exponent: Exponent<Dual>, placement: CosinePlacement, other: bool) -> Law<Dual> {
        let p: Vec<Dual> = [0.5, 0.62, 1.5, 0.1, 0.01, 1.5, -0.3]
            .iter()
            .enumerate()
            .map(|(k, &x)| seeded(x, k))
            .collect();
        let mut law = LawKind::AsymmetricBristle
            .build(&p, Some(7e-3))
            .expect("complete")
            .with_exponent(exponent)
            .with_placement(placement);
        law.asymmetry = Some(crate::Asymmetry {
            coulomb: seeded(0.2, 8),
            viscous: seeded(-0.1, 9),
            jumps: other,
        });
        law.curve.aged = if other {
            Aged::Whole
        } else {
            Aged::StaticLevel
        };
        law
    }

    /// The slopes taken by hand are those that the law's formula gives in dual numbers.
    #[test]
    fn slopes_are_those_of_the_formula() {
        let exponents = [
            Exponent::Two,
            Exponent::Half,
            Exponent::General(seeded(1.3, 7)),
        ];
        let places = [CosinePlacement::AllTerms, CosinePlacement::StiffnessOnly];
        let largest = |d: &Dual| d.eps.0.map_or(0.0, |e| e.amax());
        let forms = exponents.iter().flat_map(|e| places.map(|p| (*e, p)));
        for (exponent, placement, other) in forms.flat_map(|(e, p)| [(e, p, false), (e, p, true)]) {
            let law = law(exponent, placement, other);
            let followed = Followed::new(&law);
            for (v, u, z) in [(0.004, 0.006, 0.1), (-0.02, 0.01, -0.3), (0.3, 0.3, 0.2)] {
                let drive = Drive {
                    velocity: seeded(v, 10),
                    curve_speed: seeded(u, 11),
                    sign: f64::signum(v),
                    rest_gain: Some(seeded(1.2, 12)),
                };
                let z = seeded(z, 13);
                let (rate, mu) = followed.rate_and_coefficient(&z, &drive);
                let (rate_wanted, mu_wanted) = law.rate_and_coefficient(z, &drive);
                for (ours, theirs) in [(rate, rate_wanted), (mu, mu_wanted)] {
                    let apart = largest(&(ours - theirs)) / largest(&theirs);
                    assert!(apart < 1e-13, "{exponent:?} {placement:?} {v}: {apart:e}");
                    assert!((ours.re - theirs.re).abs() < 1e-13 * theirs.re.abs());
                }
            }
        }
    }
}

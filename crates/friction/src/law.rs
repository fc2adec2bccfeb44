//! A law of friction with its parameters: rate of the inner state and coefficient of friction.
//!
//! All dynamic laws share one form (E3, E4, E7), z being the mean deflection of the bristles (rad for bristle laws, m
//! for LuGre and Dahl) and v the slip speed in m/s:
//!
//! ```text
//! w   = v c(z) / h                        relative rate;  c = cos^2(z + theta0) for bristles, 1 else;  h = 1 else
//! z'  = w - abs(w) z / g(abs(w))          g: Stribeck curve in units of z (E5 divided by sigma)
//! mu  = (sigma0 z + sigma1 z' + sigma2 w) c(z)
//! ```
//!
//! Static laws have no state: mu = g(abs(v)) tanh(v/width) + sigma2 v. Sign: forward positive, friction has the sign
//! of the slip. Where no load is recorded, `mu` is the force itself (N, N m) and the parameters carry its unit.

use crate::gradient::Followed;
use crate::{Exponent, LawKind, Record, Scalar, StribeckCurve};

/// Default width of the regularised sign of static laws, m/s: friction reaches 76 % of its level at this speed.
pub const SIGN_WIDTH: f64 = 1e-5;

/// Where the factor cos^2(theta + theta0) stands in E7: on all terms, or on the stiffness term alone. The source's
/// equation is lost; both readings are kept as an axis of the multiverse.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CosinePlacement {
    /// mu = (sigma0 theta + sigma1 theta' + sigma2 w) cos^2.
    #[default]
    AllTerms,
    /// mu = sigma0 theta cos^2 + sigma1 theta' + sigma2 w.
    StiffnessOnly,
}

/// Geometry of a leaning bristle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lean<D> {
    /// Fixed lean theta0, rad.
    pub angle: D,
    /// Gap h between body and substrate, m.
    pub height: f64,
    /// Place of the cosine factor.
    pub placement: CosinePlacement,
}

/// Reverse friction over forward friction, less one, for the Coulomb and the viscous part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Asymmetry<D> {
    /// Ratio of the levels g, less one; with [`Asymmetry::jumps`] that of the bristles' own force sigma0 z + sigma1 z'.
    pub coulomb: D,
    /// Ratio of the viscous coefficients, less one.
    pub viscous: D,
    /// Whether the force itself differs by direction and jumps where the motion turns, rather than the level to which the bristles bend
    /// (no difference for static laws).
    pub jumps: bool,
}

/// What drives a law at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive<D> {
    /// Slip speed v, m/s (rotary: rad/s), signed.
    pub velocity: D,
    /// Speed at which the Stribeck curve is read, >= 0: abs(v) unless friction has a memory.
    pub curve_speed: D,
    /// +1 or -1: the side of zero on which v counts.
    pub sign: f64,
    /// Factor on the static level (1: `None`).
    pub rest_gain: Option<D>,
}

impl<D: Scalar> Drive<D> {
    /// Slip at speed v without memory or ageing.
    pub fn at(velocity: D) -> Self {
        let sign = if velocity.value() < 0.0 { -1.0 } else { 1.0 };
        Self {
            velocity,
            curve_speed: velocity * sign,
            sign,
            rest_gain: None,
        }
    }

    /// Only the real parts.
    pub(crate) fn real(&self) -> Drive<f64> {
        Drive {
            velocity: self.velocity.value(),
            curve_speed: self.curve_speed.value(),
            sign: self.sign,
            rest_gain: self.rest_gain.map(|gain| gain.value()),
        }
    }
}

/// Slip that changes linearly in time: drive and its slopes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion<D> {
    /// The drive now.
    pub drive: Drive<D>,
    /// dv/dt, m/s^2.
    pub acceleration: D,
    /// d(curve speed)/dt, m/s^2.
    pub curve_acceleration: D,
}

/// Rate and coefficient with their slopes in state and speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evaluation<D> {
    /// z'.
    pub rate: D,
    /// dz'/dz.
    pub rate_z: D,
    /// dz'/dv at fixed curve speed.
    pub rate_v: D,
    /// dz'/d(curve speed).
    pub rate_curve: D,
    /// mu.
    pub coefficient: D,
    /// dmu/dz.
    pub coefficient_z: D,
    /// dmu/dv, the curve speed moving along with abs(v).
    pub coefficient_v: D,
}

/// A law with its parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Law<D> {
    /// Which law.
    pub kind: LawKind,
    /// Stribeck curve: in units of the state for dynamic laws, of mu for static ones.
    pub curve: StribeckCurve<D>,
    /// sigma0: mu per unit of state.
    pub stiffness: D,
    /// sigma1: mu per unit of the state's rate.
    pub damping: D,
    /// sigma2: mu per unit of the relative rate w (static laws: of v).
    pub viscous: D,
    /// Leaning bristles.
    pub lean: Option<Lean<D>>,
    /// Dependence on direction of a symmetric law.
    pub asymmetry: Option<Asymmetry<D>>,
    /// Width of the regularised sign of static laws, m/s.
    pub sign_width: f64,
}

/// c(z) and G = c(z)/h with their slopes by z; ones and zeros for a law without lean.
pub(crate) struct Lever<D> {
    pub(crate) projection: D,
    pub(crate) projection_z: D,
    pub(crate) gear: D,
    pub(crate) gear_z: D,
}

/// What rate and coefficient have in common at one instant.
struct Kinematics<D> {
    lever: Lever<D>,
    /// Relative rate w.
    rate: D,
    /// g, dg/du.
    level: D,
    level_slope: D,
}

/// A rate z' with its slopes by state, slip speed and curve speed.
#[derive(Clone, Copy)]
pub(crate) struct RateSlope {
    pub(crate) rate: f64,
    pub(crate) z: f64,
    velocity: f64,
    curve_speed: f64,
}

impl RateSlope {
    /// z'' along a motion of constant acceleration.
    #[inline(always)]
    pub(crate) fn second(&self, motion: &Motion<f64>) -> f64 {
        self.z * self.rate
            + self.velocity * motion.acceleration
            + self.curve_speed * motion.curve_acceleration
    }

    /// The rate at a state a little further, to first order.
    #[inline(always)]
    pub(crate) fn moved_by(mut self, change: f64) -> Self {
        self.rate += self.z * change;
        self
    }
}

impl Law<f64> {
    /// Whether the other law is this one but for relative differences of its parameters within `rounding`.
    pub fn is_but_for_rounding(&self, other: &Self, rounding: f64) -> bool {
        let close = |a: f64, b: f64| (a - b).abs() <= rounding * a.abs();
        let mut moved = *other;
        let mut pairs = vec![];
        let mut pair = |ours: f64, theirs: &mut f64| {
            pairs.push((ours, *theirs));
            *theirs = ours;
        };
        pair(self.curve.kinetic, &mut moved.curve.kinetic);
        pair(self.curve.at_rest, &mut moved.curve.at_rest);
        pair(self.stiffness, &mut moved.stiffness);
        pair(self.damping, &mut moved.damping);
        pair(self.viscous, &mut moved.viscous);
        if let (Some(ours), Some(theirs)) = (self.curve.speed, &mut moved.curve.speed) {
            pair(ours, theirs);
        }
        if let (Exponent::General(ours), Exponent::General(theirs)) =
            (self.curve.exponent, &mut moved.curve.exponent)
        {
            pair(ours, theirs);
        }
        if let (Some(ours), Some(theirs)) = (self.lean, &mut moved.lean) {
            pair(ours.angle, &mut theirs.angle);
        }
        if let (Some(ours), Some(theirs)) = (self.asymmetry, &mut moved.asymmetry) {
            pair(ours.coulomb, &mut theirs.coulomb);
            pair(ours.viscous, &mut theirs.viscous);
        }
        // what is left of other differences is no rounding: another form
        moved == *self && pairs.iter().all(|&(a, b)| close(a, b))
    }

    /// z' with its slopes by state and motion.
    #[inline(always)]
    pub(crate) fn rate_slope(&self, z: f64, drive: &Drive<f64>) -> RateSlope {
        let k = self.kinematics(z, drive);
        let (rate, z, velocity, curve_speed) = Self::rate_slopes(&k, z, drive);
        RateSlope {
            rate,
            z,
            velocity,
            curve_speed,
        }
    }
}

impl<D: Scalar> Law<D> {
    /// Whether the law has an inner state.
    pub fn is_dynamic(&self) -> bool {
        self.kind.is_dynamic()
    }

    /// Only the real parts.
    pub fn real(&self) -> Law<f64> {
        Law {
            kind: self.kind,
            curve: self.curve.real(),
            stiffness: self.stiffness.value(),
            damping: self.damping.value(),
            viscous: self.viscous.value(),
            lean: self.lean.map(|lean| Lean {
                angle: lean.angle.value(),
                height: lean.height,
                placement: lean.placement,
            }),
            asymmetry: self.asymmetry.map(|a| Asymmetry {
                coulomb: a.coulomb.value(),
                viscous: a.viscous.value(),
                jumps: a.jumps,
            }),
            sign_width: self.sign_width,
        }
    }

    /// How friction on this side of zero differs from that on the other.
    #[inline]
    fn turned(&self, sign: f64) -> Option<Asymmetry<D>> {
        self.asymmetry.filter(|_| sign < 0.0)
    }

    #[inline(always)]
    fn level(&self, u: D, drive: &Drive<D>) -> (D, D) {
        let (level, slope) = self.curve.level(u, drive.rest_gain);
        match self.turned(drive.sign) {
            Some(a) if !(a.jumps && self.is_dynamic()) => {
                let factor = a.coulomb + 1.0;
                (level * factor, slope * factor)
            }
            _ => (level, slope),
        }
    }

    /// sigma0 and sigma1 on this side of zero.
    #[inline(always)]
    fn bristles(&self, sign: f64) -> (D, D) {
        match self.turned(sign) {
            Some(a) if a.jumps => {
                let factor = a.coulomb + 1.0;
                (self.stiffness * factor, self.damping * factor)
            }
            _ => (self.stiffness, self.damping),
        }
    }

    /// The largest that [`Law::gear`] can be.
    pub(crate) fn highest_gear(&self) -> f64 {
        self.lean.as_ref().map_or(1.0, |lean| 1.0 / lean.height)
    }

    /// What the slip speed is multiplied by before the curve is read: cos^2(z + theta0)/h of a leaning bristle (E4), else one.
    pub(crate) fn gear(&self, z: D) -> D {
        self.lean.as_ref().map_or(D::constant(1.0), |lean| {
            let cos = (z + lean.angle).cos();
            cos * cos * (1.0 / lean.height)
        })
    }

    #[inline(always)]
    pub(crate) fn lever(&self, z: D) -> Lever<D> {
        match &self.lean {
            Some(lean) => {
                // c = cos^2(z + theta0), dc/dz = -2 sin cos
                let (sin, cos) = (z + lean.angle).sine_and_cosine();
                let (c, c_z) = (cos * cos, sin * cos * -2.0);
                let inverse = 1.0 / lean.height;
                Lever {
                    projection: c,
                    projection_z: c_z,
                    gear: c * inverse,
                    gear_z: c_z * inverse,
                }
            }
            None => Lever {
                projection: D::constant(1.0),
                projection_z: D::constant(0.0),
                gear: D::constant(1.0),
                gear_z: D::constant(0.0),
            },
        }
    }

    #[inline(always)]
    fn kinematics(&self, z: D, drive: &Drive<D>) -> Kinematics<D> {
        let lever = self.lever(z);
        // E4: w = (v/h) cos^2(z + theta0)
        let rate = drive.velocity * lever.gear;
        let (level, level_slope) = self.level(drive.curve_speed * lever.gear, drive);
        Kinematics {
            lever,
            rate,
            level,
            level_slope,
        }
    }

    /// z' in units of the state per second (E3); zero for static laws.
    #[inline(always)]
    pub fn state_rate(&self, z: D, drive: &Drive<D>) -> D {
        if !self.is_dynamic() {
            return D::constant(0.0);
        }
        let k = self.kinematics(z, drive);
        // E3: z' = w (1 - sgn(w) z / g)
        k.rate * (-(z * drive.sign) / k.level + 1.0)
    }

    /// (z', z'') along a motion of constant acceleration.
    #[inline(always)]
    pub(crate) fn first_two_rates(&self, z: D, motion: &Motion<D>) -> (D, D) {
        let k = self.kinematics(z, &motion.drive);
        let (rate, rate_z, rate_v, rate_curve) = Self::rate_slopes(&k, z, &motion.drive);
        (
            rate,
            rate_z * rate + rate_v * motion.acceleration + rate_curve * motion.curve_acceleration,
        )
    }

    /// z', dz'/dz, dz'/dv, dz'/du with u the speed at which the curve is read.
    #[inline(always)]
    fn rate_slopes(k: &Kinematics<D>, z: D, drive: &Drive<D>) -> (D, D, D, D) {
        let inverse = k.level.recip();
        let signed = z * drive.sign * inverse;
        let left = -signed + 1.0;
        // d(1/g)/du = -g'/g^2
        let by_level = k.rate * signed * k.level_slope * inverse;
        let rate_z = drive.velocity * k.lever.gear_z * left - k.rate * inverse * drive.sign
            + by_level * drive.curve_speed * k.lever.gear_z;
        (
            k.rate * left,
            rate_z,
            k.lever.gear * left,
            by_level * k.lever.gear,
        )
    }

    /// mu (E7), or the force itself where no load is recorded.
    #[inline(always)]
    pub fn coefficient(&self, z: D, drive: &Drive<D>) -> D {
        self.rate_and_coefficient(z, drive).1
    }

    /// mu at every sample of a record whose states are known (E7).
    pub fn coefficients(&self, record: &Record<'_, D>, states: &[D]) -> Vec<D> {
        let samples = 0..states.len();
        let with_lead = |i: usize, mu: D, drive: &Drive<D>| match record.viscous_lead(i) {
            Some(lead) => mu + self.viscous_beyond(states[i], drive.sign, lead).0,
            None => mu,
        };
        let followed = (D::NDERIV > 0 && self.is_dynamic()).then(|| Followed::new(self));
        samples
            .map(|i| {
                let drive = record.drive(i);
                let mu = match &followed {
                    Some(followed) => followed.coefficient(&states[i], &drive),
                    None => self.coefficient(states[i], &drive),
                };
                with_lead(i, mu, &drive)
            })
            .collect()
    }

    /// What the coefficient gains where the viscous part follows a speed that is `lead` m/s faster than the slip, with its slope by the
    /// state: sigma2 lead c(z)/h P (E7), P being c(z) or 1 by the place of the cosine; sigma2 lead for laws without lean.
    pub fn viscous_beyond(&self, z: D, sign: f64, lead: D) -> (D, D) {
        let plain = self.viscous_of(sign) * lead;
        let at = self.lever(z);
        match self.lean.as_ref().map(|lean| lean.placement) {
            Some(CosinePlacement::StiffnessOnly) => (plain * at.gear, plain * at.gear_z),
            _ => (
                plain * at.gear * at.projection,
                plain * (at.gear_z * at.projection + at.gear * at.projection_z),
            ),
        }
    }

    /// (z', mu): both of [`Law::state_rate`] and [`Law::coefficient`] at the cost of one.
    #[inline(always)]
    pub fn rate_and_coefficient(&self, z: D, drive: &Drive<D>) -> (D, D) {
        if !self.is_dynamic() {
            return (D::constant(0.0), self.static_coefficient(drive).0);
        }
        let k = self.kinematics(z, drive);
        let rate = k.rate * (-(z * drive.sign) / k.level + 1.0);
        let (stiffness, damping) = self.bristles(drive.sign);
        let losses = damping * rate + self.viscous_of(drive.sign) * k.rate;
        let elastic = stiffness * z;
        let mu = match &self.lean {
            None => elastic + losses,
            Some(lean) => match lean.placement {
                CosinePlacement::AllTerms => (elastic + losses) * k.lever.projection,
                CosinePlacement::StiffnessOnly => elastic * k.lever.projection + losses,
            },
        };
        (rate, mu)
    }

    #[inline(always)]
    fn viscous_of(&self, sign: f64) -> D {
        match self.turned(sign) {
            Some(a) => self.viscous * (a.viscous + 1.0),
            None => self.viscous,
        }
    }

    /// mu and dmu/dv of a static law.
    fn static_coefficient(&self, drive: &Drive<D>) -> (D, D) {
        let (level, slope) = self.level(drive.curve_speed, drive);
        // mu = g(abs v) tanh(v/width) + sigma2 v
        let sign = hyperbolic_tangent(drive.velocity / self.sign_width);
        let sign_slope = (-(sign * sign) + 1.0) / self.sign_width;
        let viscous = self.viscous_of(drive.sign);
        let mu = level * sign + viscous * drive.velocity;
        let mu_v = slope * drive.sign * sign + level * sign_slope + viscous;
        (mu, mu_v)
    }

    /// Rate and coefficient with all slopes.
    pub fn evaluate(&self, z: D, drive: &Drive<D>) -> Evaluation<D> {
        let zero = D::constant(0.0);
        if !self.is_dynamic() {
            let (coefficient, coefficient_v) = self.static_coefficient(drive);
            return Evaluation {
                rate: zero,
                rate_z: zero,
                rate_v: zero,
                rate_curve: zero,
                coefficient,
                coefficient_z: zero,
                coefficient_v,
            };
        }
        let k = self.kinematics(z, drive);
        let (rate, rate_z, rate_v, rate_curve) = Self::rate_slopes(&k, z, drive);
        let viscous = self.viscous_of(drive.sign);
        let along_v = rate_v + rate_curve * drive.sign;
        let (stiffness, damping) = self.bristles(drive.sign);
        let losses = damping * rate + viscous * k.rate;
        let losses_z = damping * rate_z + viscous * drive.velocity * k.lever.gear_z;
        let losses_v = damping * along_v + viscous * k.lever.gear;
        let elastic = stiffness * z;
        let all = self
            .lean
            .as_ref()
            .is_none_or(|l| l.placement == CosinePlacement::AllTerms);
        let (p, p_z) = (k.lever.projection, k.lever.projection_z);
        let (mu, mu_z, mu_v) = if all {
            (
                (elastic + losses) * p,
                (stiffness + losses_z) * p + (elastic + losses) * p_z,
                losses_v * p,
            )
        } else {
            (
                elastic * p + losses,
                stiffness * p + elastic * p_z + losses_z,
                losses_v,
            )
        };
        Evaluation {
            rate,
            rate_z,
            rate_v,
            rate_curve,
            coefficient: mu,
            coefficient_z: mu_z,
            coefficient_v: mu_v,
        }
    }

    /// Deflection at which the state rests while v is held: z = sgn(v) g(abs(v) c(z)/h).
    ///
    /// Newton's iteration on the real part, then one step that carries the derivatives (implicit function theorem).
    pub fn steady_state(&self, velocity: D) -> D {
        if !self.is_dynamic() {
            return D::constant(0.0);
        }
        let drive = Drive::at(velocity);
        let real = self.real();
        let real_drive = Drive::at(velocity.value());
        let residual = |law: &Law<f64>, z: f64| {
            let k = law.kinematics(z, &real_drive);
            let slope =
                1.0 - real_drive.sign * k.level_slope * real_drive.curve_speed * k.lever.gear_z;
            (z - real_drive.sign * k.level, slope)
        };
        let mut z = real_drive.sign * real.curve.kinetic;
        for _ in 0..50 {
            let (r, slope) = residual(&real, z);
            let step = r / if slope.abs() > 0.2 { slope } else { 1.0 };
            z -= step;
            if step.abs() <= 1e-15 * z.abs() {
                break;
            }
        }
        let (_, slope) = residual(&real, z);
        let lifted = D::constant(z);
        let k = self.kinematics(lifted, &drive);
        lifted - (lifted - k.level * drive.sign) / slope
    }

    /// Coefficient of friction while v is held.
    pub fn steady_coefficient(&self, velocity: D) -> D {
        self.coefficient(self.steady_state(velocity), &Drive::at(velocity))
    }

    /// The same law with another Stribeck exponent.
    pub fn with_exponent(mut self, exponent: Exponent<D>) -> Self {
        self.curve.exponent = exponent;
        self
    }

    /// The same law with the cosine factor in another place; no effect on laws without lean.
    pub fn with_placement(mut self, placement: CosinePlacement) -> Self {
        if let Some(lean) = &mut self.lean {
            lean.placement = placement;
        }
        self
    }
}

/// tanh that stays a number for large arguments, where sinh and cosh of dual numbers overflow.
fn hyperbolic_tangent<D: Scalar>(x: D) -> D {
    // tanh(20) is 1 to the last bit
    if x.value().abs() > 20.0 {
        D::constant(x.value().signum())
    } else {
        x.tanh()
    }
}

//! One stretch of a record: motion between two knots, and a step on it read off between its ends.

use crate::law::{Drive, Motion};
use crate::{Law, Record, Scalar};

/// Linear motion on one stretch, seen from its start.
pub(crate) struct Stretch<D> {
    pub(crate) velocity: D,
    pub(crate) acceleration: D,
    /// Speed at which the curve is read, with its slope in time; `None`: abs(v).
    pub(crate) curve: Option<(D, D)>,
    pub(crate) rest_gain: Option<D>,
    pub(crate) sign: f64,
}

impl<D: Scalar> Stretch<D> {
    /// From knot `a` to knot `b` of a record, on one side of zero.
    pub(crate) fn between(record: &Record<'_, D>, a: usize, b: usize, sign: f64) -> Self {
        let span = record.time_s[b] - record.time_s[a];
        let (v0, v1) = (record.velocity[a], record.velocity[b]);
        Self {
            velocity: v0,
            acceleration: (v1 - v0) / span,
            curve: record.curve_speed.map(|u| (u[a], (u[b] - u[a]) / span)),
            rest_gain: record.rest_gain.map(|g| g[a]),
            sign,
        }
    }

    #[inline(always)]
    pub(crate) fn motion(&self, t: f64) -> Motion<D> {
        let velocity = self.velocity + self.acceleration * t;
        let (curve_speed, curve_acceleration) = match self.curve {
            Some((speed, slope)) => (speed + slope * t, slope),
            None => (velocity * self.sign, self.acceleration * self.sign),
        };
        Motion {
            drive: Drive {
                velocity,
                curve_speed,
                sign: self.sign,
                rest_gain: self.rest_gain,
            },
            acceleration: self.acceleration,
            curve_acceleration,
        }
    }

    pub(crate) fn real(&self) -> Stretch<f64> {
        Stretch {
            velocity: self.velocity.value(),
            acceleration: self.acceleration.value(),
            curve: self.curve.map(|(a, b)| (a.value(), b.value())),
            rest_gain: self.rest_gain.map(|g| g.value()),
            sign: self.sign,
        }
    }
}

/// State with its first two rates.
#[derive(Clone, Copy)]
pub(crate) struct Node<D> {
    pub(crate) z: D,
    pub(crate) rate: D,
    pub(crate) second: D,
}

impl<D: Scalar> Node<D> {
    /// At `t` seconds after the start of a stretch.
    #[inline(always)]
    pub(crate) fn at(law: &Law<D>, stretch: &Stretch<D>, t: f64, z: D) -> Self {
        let (rate, second) = law.first_two_rates(z, &stretch.motion(t));
        Self { z, rate, second }
    }
}

/// Quintic through (z, z', z'') at both ends of a step of size h, at place s (0 and 1: the ends).
#[inline(always)]
pub(crate) fn quintic<D: Scalar>(a: &Node<D>, b: &Node<D>, h: f64, s: f64) -> D {
    let (s2, s3) = (s * s, s * s * s);
    let (s4, s5) = (s3 * s, s3 * s2);
    let h5 = 10.0 * s3 - 15.0 * s4 + 6.0 * s5;
    let weights = [
        1.0 - h5,
        h5,
        h * (s - 6.0 * s3 + 8.0 * s4 - 3.0 * s5),
        h * (-4.0 * s3 + 7.0 * s4 - 3.0 * s5),
        h * h * (0.5 * s2 - 1.5 * s3 + 1.5 * s4 - 0.5 * s5),
        h * h * (0.5 * s3 - s4 + 0.5 * s5),
    ];
    weighted(
        [&a.z, &b.z, &a.rate, &b.rate, &a.second, &b.second],
        &weights,
    )
}

/// Sum of numbers times weights.
#[inline(always)]
pub(crate) fn weighted<D: Scalar, const K: usize>(numbers: [&D; K], weights: &[f64; K]) -> D {
    let mut value = numbers[0].value() * weights[0];
    for k in 1..K {
        value += numbers[k].value() * weights[k];
    }
    D::along(value, numbers.into_iter().zip(weights.iter().copied()))
}

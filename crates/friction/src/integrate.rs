//! The inner state along a recorded motion.
//!
//! The velocity is linear between knots. On every stretch without change of sign the state is carried by Radau IIA
//! (order five, L-stable) with steps chosen by its error estimate; samples inside a step are read off a quintic that
//! matches z, z', z'' at both ends. Steps depend on values only (real parts), never on a clock or a derivative.
//!
//! Derivatives: the stages are found in `f64` by Newton's iteration; one more step of it in dual numbers, with the real
//! matrix, then gives Z_dual = Z - M^-1 R_dual(Z), exact to first order by the implicit function theorem. At a change
//! of sign of v the rate vanishes on both sides, so the crossing time contributes nothing to the first derivative.
//!
//! Accuracy: `TOLERANCE` is set on the estimate of order three; the error of the result, found by halving every
//! step, stays below 1e-8 of the level of the state (tested). Units: s, m/s, state in rad or m.

use crate::Scalar;
use crate::law::{Drive, Law, Motion};
use crate::radau::{A, C, E, GAMMA, collocation_weights, inverse_newton_matrix};

/// Bound on the error estimate of a step, relative to the level of the state.
const TOLERANCE: f64 = 4e-7;
/// Above this product of rate and step the quintic is replaced by the collocation polynomial, which does not overshoot.
const STIFF: f64 = 2.0;
/// The Stribeck curve is flat, as far as stages can see, from so many of its speed scales on: exp(-16) for p = 2.
const BEYOND_THE_PEAK: f64 = 4.0;
/// Stages of a step over so many speed scales still meet the curve wherever the step begins or ends within it.
const MET: f64 = 8.0;
const NEWTON_LIMIT: usize = 12;
const NEWTON_TOLERANCE: f64 = 1e-6;
/// A step is never cut below this share of its stretch.
const SMALLEST: f64 = 1e-9;
/// Steps that a run may try, at hand and for each of its samples: far more than any answer takes that the record can show. Beyond, an
/// error bound below what rounding leaves cuts every step to its smallest.
const STEPS_AT_HAND: usize = 10_000;
const STEPS_A_SAMPLE: usize = 100;

/// A recorded motion at its samples.
#[derive(Clone, Copy, Debug)]
pub struct Record<'a, D> {
    /// Time of the samples, s, increasing.
    pub time_s: &'a [f64],
    /// Slip speed at the samples, m/s.
    pub velocity: &'a [D],
    /// Speed at which the Stribeck curve is read, >= 0; `None`: abs(velocity).
    pub curve_speed: Option<&'a [D]>,
    /// Factor on the static level from each sample to the next; `None`: 1.
    pub rest_gain: Option<&'a [D]>,
    /// Indices of the knots, first and last sample included; between them velocity (and curve speed) is linear.
    pub knots: &'a [usize],
}

/// Why the state could not be carried on.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum IntegrationError {
    /// The state left the numbers, or Newton's iteration found no step.
    #[error("the law's state cannot be carried beyond t = {time_s} s")]
    Diverged {
        /// Where it stopped, s.
        time_s: f64,
    },
    /// The steps that the record's length allows are used up: the answer rings or chatters far faster than it is sampled.
    #[error("too many steps: the state changes far faster than the record at t = {time_s} s")]
    TooManySteps {
        /// Where it stopped, s.
        time_s: f64,
    },
}

/// Knots of a record: indices between which `velocity` is linear within `tolerance` (same unit), ends included.
pub fn linear_stretches(time_s: &[f64], velocity: &[f64], tolerance: f64) -> Vec<usize> {
    let n = time_s.len().min(velocity.len());
    let mut knots = vec![0];
    let mut start = 0;
    let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
    for j in 1..n {
        let span = time_s[j] - time_s[start];
        let slope = (velocity[j] - velocity[start]) / span;
        if slope < low || slope > high {
            // the chord to j misses a sample in between: the stretch ends at the sample before
            start = j - 1;
            knots.push(start);
            (low, high) = (f64::NEG_INFINITY, f64::INFINITY);
        }
        let span = time_s[j] - time_s[start];
        let slope = (velocity[j] - velocity[start]) / span;
        low = low.max(slope - tolerance / span);
        high = high.min(slope + tolerance / span);
    }
    if n > 1 {
        knots.push(n - 1);
    }
    knots
}

/// Linear motion on one stretch, seen from its start.
struct Stretch<D> {
    velocity: D,
    acceleration: D,
    curve: Option<(D, D)>,
    rest_gain: Option<D>,
    sign: f64,
}

impl<D: Scalar> Stretch<D> {
    #[inline(always)]
    fn motion(&self, t: f64) -> Motion<D> {
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

    fn real(&self) -> Stretch<f64> {
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
struct Node<D> {
    z: D,
    rate: D,
    second: D,
}

struct Integrator<'a, D> {
    law: &'a Law<D>,
    real: Law<f64>,
    tolerance: f64,
    /// Step that the estimate last allowed, s.
    step: f64,
    /// Level of the state: the size against which errors count.
    level: f64,
    /// Steps that may still be tried.
    left: usize,
}

/// State z at every sample of the record, from z = `initial` at the first one.
///
/// # Errors
/// [`IntegrationError::Diverged`] where parameters make the state leave the numbers, [`IntegrationError::TooManySteps`] where the
/// steps that the record's length allows do not reach its end.
pub fn integrate<D: Scalar>(
    law: &Law<D>,
    record: &Record<'_, D>,
    initial: D,
) -> Result<Vec<D>, IntegrationError> {
    integrate_within(law, record, initial, TOLERANCE)
}

/// As [`integrate`], with another bound on the error estimate. The estimate is of order four in the step.
fn integrate_within<D: Scalar>(
    law: &Law<D>,
    record: &Record<'_, D>,
    initial: D,
    tolerance: f64,
) -> Result<Vec<D>, IntegrationError> {
    let n = record.time_s.len();
    let mut states = Vec::with_capacity(n);
    if !law.is_dynamic() {
        states.resize(n, D::constant(0.0));
        return Ok(states);
    }
    let real = law.real();
    let level = real.curve.kinetic.abs().max(real.curve.at_rest.abs());
    let mut integrator = Integrator {
        law,
        real,
        tolerance: tolerance * level,
        step: f64::INFINITY,
        level,
        left: STEPS_AT_HAND + STEPS_A_SAMPLE * n,
    };
    states.push(initial);
    let mut z = initial;
    for pair in record.knots.windows(2) {
        z = integrator.stretch(record, pair[0], pair[1], z, &mut states)?;
    }
    Ok(states)
}

impl<D: Scalar> Integrator<'_, D> {
    /// From knot `a` to knot `b`, split where the velocity changes sign; pushes the states of samples a+1..=b.
    fn stretch(
        &mut self,
        record: &Record<'_, D>,
        a: usize,
        b: usize,
        mut z: D,
        states: &mut Vec<D>,
    ) -> Result<D, IntegrationError> {
        let t0 = record.time_s[a];
        let span = record.time_s[b] - t0;
        let (v0, v1) = (record.velocity[a], record.velocity[b]);
        let acceleration = (v1 - v0) / span;
        let curve = record.curve_speed.map(|u| (u[a], (u[b] - u[a]) / span));
        let (start, end) = (v0.value(), v1.value());
        let crossing = if start * end < 0.0 {
            start / (start - end) * span
        } else {
            span
        };
        let mut part = Stretch {
            velocity: v0,
            acceleration,
            curve,
            rest_gain: record.rest_gain.map(|g| g[a]),
            sign: if start < 0.0 || (start == 0.0 && end < 0.0) {
                -1.0
            } else {
                1.0
            },
        };
        let times = &record.time_s[a + 1..=b];
        let done = states.len();
        z = self.part(&part, 0.0, crossing, z, t0, times, states)?;
        if crossing < span {
            part.sign = -part.sign;
            let rest = &times[states.len() - done..];
            z = self.part(&part, crossing, span, z, t0, rest, states)?;
        }
        // rounding of the end time must not lose the last sample
        while states.len() - done < times.len() {
            states.push(z);
        }
        Ok(z)
    }

    /// From `from` to `to` (seconds after `t0`) with one sign of v.
    #[allow(clippy::too_many_arguments)]
    fn part(
        &mut self,
        stretch: &Stretch<D>,
        from: f64,
        to: f64,
        z: D,
        t0: f64,
        times: &[f64],
        states: &mut Vec<D>,
    ) -> Result<D, IntegrationError> {
        if stretch.velocity.value() == 0.0 && stretch.acceleration.value() == 0.0 && D::NDERIV == 0
        {
            // at rest: z' = 0
            return Ok(z);
        }
        let real_stretch = stretch.real();
        let (mut t, mut z, mut taken) = (from, z, 0);
        let mut real = node(&self.real, &real_stretch, t, z.value());
        // with derivatives only where samples inside a step need it
        let mut dual: Option<Node<D>> = None;
        while t < to {
            let (h, stages, inverse, slope) =
                self.step(&real_stretch, t, to, &real, to - from, t0)?;
            let end = if to - (t + h) <= 1e-12 * to {
                to
            } else {
                t + h
            };
            let stages = self.lift(stretch, t, h, z, stages, &inverse);
            let next = stages[2];
            if !next.value().is_finite() {
                return Err(IntegrationError::Diverged { time_s: t0 + t });
            }
            let place = |time_s: f64| (time_s - t0 - t) / h;
            let stiff = slope.abs() * h > STIFF;
            let inside = times.get(taken).is_some_and(|&time| place(time) < 1.0);
            let mut ends = None;
            if inside && !stiff {
                let start = dual.unwrap_or_else(|| node(self.law, stretch, t, z));
                ends = Some((start, node(self.law, stretch, end, next)));
            }
            while taken < times.len() && times[taken] - t0 <= end {
                let s = place(times[taken]);
                states.push(match &ends {
                    _ if s >= 1.0 => next,
                    Some((start, finish)) => quintic(start, finish, h, s),
                    None => {
                        let w = collocation_weights(s);
                        z * w[0] + stages[0] * w[1] + stages[1] * w[2] + stages[2] * w[3]
                    }
                });
                taken += 1;
            }
            dual = ends.map(|(_, finish)| finish);
            (z, t) = (next, end);
            real = node(&self.real, &real_stretch, t, z.value());
        }
        Ok(z)
    }

    /// One accepted step in `f64`: (h, stages, inverse Newton matrix, slope dz'/dz at the end).
    #[allow(clippy::type_complexity)]
    fn step(
        &mut self,
        stretch: &Stretch<f64>,
        t: f64,
        to: f64,
        node: &Node<f64>,
        span: f64,
        t0: f64,
    ) -> Result<(f64, [f64; 3], [[f64; 3]; 3], f64), IntegrationError> {
        let (_, slope) = self.real.rate_and_slope(node.z, &stretch.motion(t).drive);
        loop {
            let Some(left) = self.left.checked_sub(1) else {
                return Err(IntegrationError::TooManySteps { time_s: t0 + t });
            };
            self.left = left;
            let allowed = self.step.max(SMALLEST * span);
            let free = if t + allowed * 1.000_001 >= to {
                to - t
            } else {
                allowed
            };
            let h = self.up_to_the_peak(stretch, t, free, node.z);
            let smallest = h <= SMALLEST * span * 1.01;
            match self.stages(stretch, t, h, node, slope) {
                Some((stages, inverse, end_slope)) => {
                    let sum: f64 = (0..3).map(|i| E[i] * (stages[i] - node.z)).sum();
                    let estimate =
                        ((h * GAMMA * node.rate + sum) / (1.0 - h * GAMMA * slope)).abs();
                    let factor = 0.9 * (self.tolerance / estimate.max(1e-300)).sqrt().sqrt();
                    if estimate <= self.tolerance || smallest {
                        let cut_by_stretch = (t + h >= to || h < free) && h < self.step;
                        let next = h * factor.clamp(0.2, 4.0);
                        self.step = if cut_by_stretch {
                            self.step.max(next)
                        } else {
                            next
                        };
                        return Ok((h, stages, inverse, end_slope));
                    }
                    self.step = h * factor.clamp(0.1, 0.9);
                }
                None if smallest => return Err(IntegrationError::Diverged { time_s: t0 + t }),
                None => self.step = 0.25 * h,
            }
        }
    }

    /// A step that would leap from far above the Stribeck curve's speeds into them, or out of them, ends where they begin. Its three stages
    /// could all lie where the curve is flat: neither the state nor the error estimate would know that there is a peak.
    fn up_to_the_peak(&self, stretch: &Stretch<f64>, t: f64, h: f64, z: f64) -> f64 {
        let Some(scale) = self.real.curve.speed else {
            return h;
        };
        let (edge, gear) = (BEYOND_THE_PEAK * scale, self.real.gear(z));
        let from = stretch.motion(t).drive.curve_speed * gear;
        let to = stretch.motion(t + h).drive.curve_speed * gear;
        let leaps = (to - from).abs() > MET * scale && (from - edge) * (to - edge) < 0.0;
        if !leaps || (from - edge).abs() <= 1e-6 * edge {
            return h;
        }
        h * (edge - from) / (to - from)
    }

    /// Newton's iteration for the three stages; `None` where it does not settle.
    #[inline(always)]
    fn stages(
        &self,
        stretch: &Stretch<f64>,
        t: f64,
        h: f64,
        node: &Node<f64>,
        slope: f64,
    ) -> Option<([f64; 3], [[f64; 3]; 3], f64)> {
        let drives = C.map(|c| stretch.motion(t + c * h).drive);
        // predictor: Taylor where the step is not stiff, the old value where it is
        let mut z = if (h * slope).abs() < STIFF {
            C.map(|c| node.z + c * h * (node.rate + 0.5 * c * h * node.second))
        } else {
            [node.z; 3]
        };
        let scale = self.level + node.z.abs();
        for _ in 0..NEWTON_LIMIT {
            let mut rates = [0.0; 3];
            let mut slopes = [0.0; 3];
            for i in 0..3 {
                (rates[i], slopes[i]) = self.real.rate_and_slope(z[i], &drives[i]);
            }
            let inverse = inverse_newton_matrix(h, &slopes)?;
            let mut residual = [0.0; 3];
            for i in 0..3 {
                let sum = A[i][0] * rates[0] + A[i][1] * rates[1] + A[i][2] * rates[2];
                residual[i] = z[i] - node.z - h * sum;
            }
            let mut largest: f64 = 0.0;
            for i in 0..3 {
                let change = inverse[i][0] * residual[0]
                    + inverse[i][1] * residual[1]
                    + inverse[i][2] * residual[2];
                z[i] -= change;
                largest = largest.max(change.abs());
            }
            if !largest.is_finite() {
                return None;
            }
            // convergence is quadratic: what is left after a change this small is rounding
            if largest <= NEWTON_TOLERANCE * scale {
                return Some((z, inverse, slopes[2]));
            }
        }
        None
    }

    /// The stages with their derivatives: one Newton step in dual numbers with the real matrix.
    #[inline(always)]
    fn lift(
        &self,
        stretch: &Stretch<D>,
        t: f64,
        h: f64,
        z: D,
        stages: [f64; 3],
        inverse: &[[f64; 3]; 3],
    ) -> [D; 3] {
        let mut lifted = stages.map(D::constant);
        if D::NDERIV == 0 {
            return lifted;
        }
        let mut rates = [D::constant(0.0); 3];
        for i in 0..3 {
            rates[i] = self
                .law
                .state_rate(lifted[i], &stretch.motion(t + C[i] * h).drive)
                * h;
        }
        let mut residual = [D::constant(0.0); 3];
        for i in 0..3 {
            let sum = rates[0] * A[i][0] + rates[1] * A[i][1] + rates[2] * A[i][2];
            residual[i] = lifted[i] - z - sum;
        }
        for i in 0..3 {
            let change = residual[0] * inverse[i][0]
                + residual[1] * inverse[i][1]
                + residual[2] * inverse[i][2];
            // the value stays that of the iteration: only derivatives are taken over
            lifted[i] -= change - change.value();
        }
        lifted
    }
}

/// State with its rates at a moment of a stretch.
#[inline(always)]
fn node<D: Scalar>(law: &Law<D>, stretch: &Stretch<D>, t: f64, z: D) -> Node<D> {
    let (rate, second) = law.first_two_rates(z, &stretch.motion(t));
    Node { z, rate, second }
}

/// Quintic through (z, z', z'') at both ends of a step of size h, at place s in [0, 1].
#[inline(always)]
fn quintic<D: Scalar>(a: &Node<D>, b: &Node<D>, h: f64, s: f64) -> D {
    let (s2, s3) = (s * s, s * s * s);
    let (s4, s5) = (s3 * s, s3 * s2);
    let h5 = 10.0 * s3 - 15.0 * s4 + 6.0 * s5;
    a.z * (1.0 - h5)
        + b.z * h5
        + a.rate * (h * (s - 6.0 * s3 + 8.0 * s4 - 3.0 * s5))
        + b.rate * (h * (-4.0 * s3 + 7.0 * s4 - 3.0 * s5))
        + a.second * (h * h * (0.5 * s2 - 1.5 * s3 + 1.5 * s4 - 0.5 * s5))
        + b.second * (h * h * (0.5 * s3 - s4 + 0.5 * s5))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::LawKind;

    #[test]
    fn halving_the_steps_changes_no_reported_digit() {
        let time: Vec<f64> = (0..600).map(|i| f64::from(i) / 60.0).collect();
        for (lean, sign) in [(-0.3, 1.0), (-0.3, -1.0), (0.0, 1.0)] {
            let law = LawKind::AsymmetricBristle
                .build(&[0.5, 0.62, 1.5, 0.1, 0.01, 1.5, lean], Some(7e-3))
                .expect("complete");
            let velocity: Vec<f64> = time.iter().map(|t| sign * 0.006 * t).collect();
            let record = Record {
                time_s: &time,
                velocity: &velocity,
                curve_speed: None,
                rest_gain: None,
                knots: &[0, 599],
            };
            let whole = integrate(&law, &record, 0.0).expect("finite");
            let halved = integrate_within(&law, &record, 0.0, TOLERANCE / 16.0).expect("finite");
            let change = whole
                .iter()
                .zip(&halved)
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f64::max);
            assert!(change > 0.0 && change < 1e-7, "{change:e}");
        }
    }

    /// A state far above its level: what rounding leaves of it is beyond the bound on the error, whatever the step.
    #[test]
    fn a_bound_below_rounding_ends_in_an_error() {
        let time: Vec<f64> = (0..200).map(|i| f64::from(i) / 100.0).collect();
        let velocity: Vec<f64> = time.iter().map(|t| 0.1 * (7.0 * t).sin()).collect();
        let knots: Vec<usize> = (0..time.len()).collect();
        let record = Record {
            time_s: &time,
            velocity: &velocity,
            curve_speed: None,
            rest_gain: None,
            knots: &knots,
        };
        let law = LawKind::Lugre
            .build(&[1e-14, 1.1e-14, 0.01, 1e-3, 0.0, 0.0], None)
            .expect("complete");
        let ended = integrate(&law, &record, 1.0);
        assert!(
            matches!(ended, Err(IntegrationError::TooManySteps { .. })),
            "{ended:?}"
        );
    }
}

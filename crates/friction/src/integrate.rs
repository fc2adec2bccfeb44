//! The inner state along a recorded motion.
//!
//! The velocity is linear between knots. The state is carried along it once, in `f64` ([`Path`]); derivatives are then taken along
//! the steps of that path. Steps depend on values only, never on a clock or a derivative, and a path may be
//! kept for any number of derivatives.
//!
//! Accuracy: `TOLERANCE` is set on the estimate of order three; the error of the result, found by halving every
//! step, stays below 1e-8 of the level of the state (tested). Units: s, m/s, state in rad or m.

use crate::law::Drive;
use crate::path::Path;
use crate::{Law, Scalar};

/// Bound on the error estimate of a step, relative to the level of the state.
pub(crate) const TOLERANCE: f64 = 4e-7;

/// A recorded motion at its samples.
#[derive(Clone, Copy, Debug)]
pub struct Record<'a, D> {
    /// Time of the samples, s, increasing.
    pub time_s: &'a [f64],
    /// Slip speed at the samples, m/s.
    pub velocity: &'a [D],
    /// Speed at which the Stribeck curve is read, >= 0; `None`: abs(velocity).
    pub curve_speed: Option<&'a [D]>,
    /// Signed speed that the viscous part follows, m/s; `None`: the slip speed.
    pub viscous_speed: Option<&'a [D]>,
    /// Factor on the static level from each sample to the next; `None`: 1.
    pub rest_gain: Option<&'a [D]>,
    /// Indices of the knots, first and last sample included; between them velocity (and curve speed) is linear.
    pub knots: &'a [usize],
}

impl<'a, D> Record<'a, D> {
    /// A motion of which nothing but the slip drives the law.
    pub fn of_slip(time_s: &'a [f64], velocity: &'a [D], knots: &'a [usize]) -> Self {
        Self {
            time_s,
            velocity,
            curve_speed: None,
            viscous_speed: None,
            rest_gain: None,
            knots,
        }
    }
}

impl<D: Scalar> Record<'_, D> {
    /// What drives the law at sample `i`.
    #[inline]
    pub fn drive(&self, i: usize) -> Drive<D> {
        let mut drive = Drive::at(self.velocity[i]);
        if let Some(speed) = self.curve_speed {
            drive.curve_speed = speed[i];
        }
        drive.rest_gain = self.rest_gain.map(|gain| gain[i]);
        drive
    }

    /// How much faster than the slip the speed is that the viscous part follows at sample `i`, m/s; `None` where it follows the slip.
    #[inline]
    pub fn viscous_lead(&self, i: usize) -> Option<D> {
        self.viscous_speed.map(|speed| speed[i] - self.velocity[i])
    }

    /// The record in numbers.
    pub fn real(&self) -> Reals<'_> {
        Reals {
            time_s: self.time_s,
            velocity: values(self.velocity),
            curve_speed: self.curve_speed.map(values),
            viscous_speed: self.viscous_speed.map(values),
            rest_gain: self.rest_gain.map(values),
            knots: self.knots,
        }
    }
}

fn values<D: Scalar>(series: &[D]) -> Vec<f64> {
    series.iter().map(Scalar::value).collect()
}

/// The real parts of a [`Record`].
#[derive(Clone, Debug)]
pub struct Reals<'a> {
    time_s: &'a [f64],
    velocity: Vec<f64>,
    curve_speed: Option<Vec<f64>>,
    viscous_speed: Option<Vec<f64>>,
    rest_gain: Option<Vec<f64>>,
    knots: &'a [usize],
}

impl Reals<'_> {
    /// The record.
    pub fn record(&self) -> Record<'_, f64> {
        Record {
            time_s: self.time_s,
            velocity: &self.velocity,
            curve_speed: self.curve_speed.as_deref(),
            viscous_speed: self.viscous_speed.as_deref(),
            rest_gain: self.rest_gain.as_deref(),
            knots: self.knots,
        }
    }
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
    let real = record.real();
    let path = Path::within(
        &law.real(),
        &real.record(),
        initial.value(),
        tolerance,
        D::NDERIV > 0,
    )?;
    if D::NDERIV == 0 {
        return Ok(path.into_states().into_iter().map(D::constant).collect());
    }
    path.lift(law, record, initial)
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
            let record = Record::of_slip(&time, &velocity, &[0, 599]);
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

    /// A state so stiff that it follows its level g(v) / sigma0, along a motion that slows down to rest in one stretch: at rest nothing moves
    /// the state, but the step that ends there is as stiff as its start.
    #[test]
    fn a_stiff_state_follows_its_level_to_rest() {
        let time: Vec<f64> = (0..420).map(|i| f64::from(i) / 70.0).collect();
        let up_and_down = |i: i32| f64::from(if i < 210 { i } else { 419 - i });
        for (fastest, sigma0) in [(0.07, 1e7), (0.3, 1e7), (0.07, 1e10)] {
            let velocity: Vec<f64> = (0..420).map(|i| fastest / 209.0 * up_and_down(i)).collect();
            let record = Record::of_slip(&time, &velocity, &[0, 209, 210, 419]);
            let law = LawKind::Lugre
                .build(&[0.3, 0.4, 0.008, sigma0, 80.0, 2.0], None)
                .expect("complete");
            let states = integrate(&law, &record, 0.0).expect("finite");
            // the first sample is at rest and the second within reach of it
            for (z, v) in states.iter().zip(&velocity).skip(2) {
                let level = 0.3 + 0.1 * (-(v / 0.008_f64).powi(2)).exp();
                let off = sigma0 * z - level;
                assert!(off.abs() < 1e-4, "{off:e} at {v} m/s");
            }
        }
    }

    /// A state far above its level: what rounding leaves of it is beyond the bound on the error, whatever the step.
    #[test]
    fn a_bound_below_rounding_ends_in_an_error() {
        let time: Vec<f64> = (0..200).map(|i| f64::from(i) / 100.0).collect();
        let velocity: Vec<f64> = time.iter().map(|t| 0.1 * (7.0 * t).sin()).collect();
        let knots: Vec<usize> = (0..time.len()).collect();
        let record = Record::of_slip(&time, &velocity, &knots);
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

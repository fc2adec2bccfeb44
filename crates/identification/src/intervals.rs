//! Intervals by profile likelihood, each at the quantile of the noise that drives its parameter.

use fitting::{Bounds, Fit, Limit, Profile, ProfileOptions, Side, profile};
use rayon::prelude::*;

use crate::problem::Problem;

/// Nominal level of every interval.
pub const LEVEL: f64 = 0.95;

/// A 95 % interval.
#[derive(Clone, Debug, PartialEq)]
pub struct Interval {
    /// Lower end.
    pub lower: Limit,
    /// Upper end.
    pub upper: Limit,
}

impl Interval {
    /// Lower end as a number, minus infinity where it is open.
    pub fn low(&self) -> f64 {
        self.lower.value(Side::Lower)
    }

    /// Upper end as a number, infinity where it is open.
    pub fn high(&self) -> f64 {
        self.upper.value(Side::Upper)
    }

    /// Whether the interval holds a value.
    pub fn contains(&self, value: f64) -> bool {
        self.low() <= value && value <= self.high()
    }

    /// Larger distance of the two ends from `value`, over |value|.
    pub fn relative_half_width(&self, value: f64) -> f64 {
        (self.high() - value).max(value - self.low()) / value.abs()
    }
}

/// Profiles of the named columns, in order; `options` holds each parameter's quantile and first step. `None` for held
/// parameters.
pub(crate) fn profiles(
    problem: &Problem<'_>,
    fit: &Fit,
    bounds: &Bounds,
    columns: &[usize],
    options: &[(f64, f64)],
) -> Vec<Option<Profile>> {
    columns
        .par_iter()
        .map(|&j| {
            if bounds.is_fixed(j) {
                return None;
            }
            let (quantile, step) = options[j];
            let options = ProfileOptions::new(quantile * quantile, quantile * step);
            profile(problem, fit, j, bounds, &options).ok()
        })
        .collect()
}

//! Whether friction follows what a channel shows beside its smooth course.
//!
//! ```text
//! F_i - (smoothed F)_i = sum_k b_k x_{i-k} + noise,   k = -4 to 12 samples                                  (M3)
//! ```
//!
//! x: what the channel shows there, less its own smooth course, the force being recorded early or late; both in standard deviations of the noise of a run. What is true of
//! the rig is in the force, too; the channel's own noise is not.

use campaign::noise::spread;
use nalgebra::{DMatrix, DVector};

use crate::whittaker::smooth;

/// Samples by which the force may be recorded early or late.
const SHIFTS: std::ops::RangeInclusive<isize> = -4..=12;
/// Standard deviations of a chi-squared from which friction plainly follows.
const PLAIN: f64 = 12.0;
/// Smoothness of a course, which takes waves longer than some 18 samples: a smoother one rings at the corners.
const SLOW: f64 = 64.0;
/// Standard deviations from which a force runs away from the smooth one: a start, a reversal.
const FAR: f64 = 4.0;

/// The course that a force is seen beside, N.
pub(crate) fn smooth_force_n(force_n: &[f64]) -> Vec<f64> {
    smooth(force_n, SLOW).z
}

/// A series beside its smooth course.
fn quick(series: &[f64]) -> Vec<f64> {
    let course = smooth(series, SLOW).z;
    series.iter().zip(&course).map(|(y, z)| y - z).collect()
}

/// The normal equations of (M3) over all runs.
pub(crate) struct Followed {
    normal: DMatrix<f64>,
    right: DVector<f64>,
}

impl Default for Followed {
    fn default() -> Self {
        let shifts = SHIFTS.count();
        Self {
            normal: DMatrix::zeros(shifts, shifts),
            right: DVector::zeros(shifts),
        }
    }
}

impl Followed {
    /// A run: x, and its force. Samples in which the force runs away from its course are left out.
    pub(crate) fn add(&mut self, shown: &[f64], force_n: &[f64]) {
        let rest = quick(force_n);
        let shown = quick(shown);
        let sd = spread(&rest);
        if sd == 0.0 {
            return;
        }
        let first = *SHIFTS.end() as usize;
        let last = shown.len().saturating_add_signed(*SHIFTS.start());
        for i in (first..last).filter(|&i| rest[i].abs() < FAR * sd) {
            let row = SHIFTS.map(|k| shown[(i as isize - k) as usize] / sd);
            let row = DVector::from_iterator(SHIFTS.count(), row);
            self.normal.ger(1.0, &row, &row, 1.0);
            self.right.axpy(rest[i] / sd, &row, 1.0);
        }
    }

    /// Sum of squares of x.
    pub(crate) fn power(&self) -> f64 {
        self.normal.trace() / SHIFTS.count() as f64
    }

    /// What x explains of the force over what there is of x, as an amplitude; zero where that is no more than chance.
    pub(crate) fn share(&self) -> f64 {
        let (explained, directions) = self.explained();
        let chance = directions + PLAIN * (2.0 * directions).sqrt();
        if explained <= chance {
            return 0.0;
        }
        ((explained - directions) / self.power()).sqrt()
    }

    /// What the b_k explain, and how many directions of theirs the record knows: a channel that shakes at one frequency has two.
    fn explained(&self) -> (f64, f64) {
        let eigen = self.normal.clone().symmetric_eigen();
        let largest = eigen.eigenvalues.max();
        let known = (0..self.right.len()).filter(|&k| eigen.eigenvalues[k] > 1e-9 * largest);
        known.fold((0.0, 0.0), |(sum, count), k| {
            let along = eigen.eigenvectors.column(k).dot(&self.right);
            (sum + along * along / eigen.eigenvalues[k], count + 1.0)
        })
    }
}

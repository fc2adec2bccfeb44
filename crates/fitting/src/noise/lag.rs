//! A low-pass filter between what makes the noise and what records it.
//!
//! Roughness reaches the record m through the force channel's filter, white noise e does not. The filter is undone at the samples,
//! a = exp(-step/tau) from the sample before and none before the first of a run:
//!
//! ```text
//! z = L m,   L = lead (1 - a B) / (1 + c B),   B the sample before                                           (N6)
//! ```
//!
//! Roughness goes on between the samples, and the filter takes the mean over what it passes there. For roughness of unit size that is
//! x lengths further with each sample, (1 - exp(-x) B)(1 - a B) m is a moving average 1 + c B of white noise, by the covariance that
//! a field behind a filter has, with kappa = x tau / step its lengths within one tau,
//!
//! ```text
//! cov(k) = [exp(-k x) - kappa a^k] / (1 - kappa^2)
//! ```
//!
//! and lead makes z what (N1) says of a record without a filter, of unit size and with neighbours alike to exp(-x). Undone so, an input
//! that moves on between the samples comes out late by [`left_s`].

use super::ring::FURTHER;

/// The filter of a record that has one, a sample; empty: none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lag {
    /// Time since the sample before over the time constant; zero at the first sample of a run.
    steps: Vec<f64>,
}

/// What L is at a sample: z_i = lead (y_i - fade y_{i-1}) - zero z_{i-1}.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct UndoneLag {
    pub(super) lead: f64,
    /// a, and c; none at the first sample of a run.
    pub(super) fade: f64,
    pub(super) zero: f64,
}

impl Lag {
    /// From the time since the sample before (zero at the first of a run), s, and the time constant, s.
    pub fn new(steps_s: impl Iterator<Item = f64>, time_constant_s: f64) -> Self {
        if !(time_constant_s > 0.0) {
            return Self::default();
        }
        Self {
            steps: steps_s
                .map(|step| step.max(0.0) / time_constant_s)
                .collect(),
        }
    }

    /// Whether there is no filter.
    pub fn is_empty(&self) -> bool {
        self.steps.is_empty()
    }

    /// The filter as it is undone where samples lie at these distances slid and the roughness has this length.
    pub(super) fn undone(&self, sliding: &[f64], length: f64) -> Vec<UndoneLag> {
        let at = |i: usize| UndoneLag::at(self.steps[i], (sliding[i] - sliding[i - 1]) / length);
        (0..self.steps.len())
            .map(|i| match (self.steps[i] > 0.0, self.steps.get(i + 1)) {
                (true, _) => at(i),
                // what was before the first sample, the second says best
                (false, Some(&next)) if next > 0.0 => at(i + 1).at_rest(),
                (false, _) => UndoneLag::NONE,
            })
            .collect()
    }

    /// What the record shows of a force that goes straight from sample to sample and has stood still before the first.
    pub(super) fn put_in(&self, record: &mut [f64]) {
        let mut before = record.first().copied().unwrap_or(0.0);
        for (i, &step) in self.steps.iter().enumerate() {
            let force = record[i];
            if step > 0.0 {
                let (fade, gone) = ((-step).exp(), -(-step).exp_m1());
                record[i] =
                    force - (force - before) * gone / step + (record[i - 1] - before) * fade;
            }
            before = force;
        }
    }
}

impl UndoneLag {
    /// Nothing is undone.
    pub(super) const NONE: Self = Self {
        lead: 1.0,
        fade: 0.0,
        zero: 0.0,
    };

    /// Of a sample so many time constants and so many lengths of roughness after the one before.
    fn at(step: f64, further: f64) -> Self {
        let x = match further.clamp(FURTHER.0, FURTHER.1) {
            // there the covariance is 0 / 0; so near it is the same
            near if (near / step - 1.0).abs() < 1e-4 => step * (1.0 + 1e-4),
            other => other,
        };
        let (a, kappa) = ((-step).exp(), x / step);
        let rho = (-x).exp();
        let cov = [0, 1, 2, 3].map(|k| (rho.powi(k) - kappa * a.powi(k)) / (1.0 - kappa * kappa));
        // (1 - rho B)(1 - a B) = 1 - sum B + product B^2, its products with itself, and what they make of the covariance
        let (sum, product) = (rho + a, rho * a);
        let own = [
            1.0 + sum * sum + product * product,
            -sum * (1.0 + product),
            product,
        ];
        let none = own[0] * cov[0] + 2.0 * (own[1] * cov[1] + own[2] * cov[2]);
        let one = own[0] * cov[1] + own[1] * (cov[0] + cov[2]) + own[2] * (cov[1] + cov[3]);
        // variance (1 + c^2) = none, variance c = one
        let root = (none * none - 4.0 * one * one).max(0.0).sqrt();
        let variance = 0.5 * (none + root);
        Self {
            lead: ((1.0 - rho * rho) / variance).sqrt(),
            fade: a,
            zero: one / variance,
        }
    }

    /// The first sample of a run, before which all has rested.
    fn at_rest(self) -> Self {
        Self {
            lead: self.lead * (1.0 - self.fade) / (1.0 + self.zero),
            ..Self::NONE
        }
    }
}

/// z from m.
pub(super) fn take_out(undone: &[UndoneLag], record: &mut [f64]) {
    let (mut y, mut z) = (0.0, 0.0);
    for (at, x) in undone.iter().zip(record) {
        z = at.lead * (*x - at.fade * y) - at.zero * z;
        y = *x;
        *x = z;
    }
}

/// The transposed map.
pub(super) fn take_out_transposed(undone: &[UndoneLag], record: &mut [f64]) {
    // adjoints of y and z of the sample before
    let (mut of_y, mut of_z) = (0.0, 0.0);
    for (at, x) in undone.iter().zip(record).rev() {
        let z = *x + of_z;
        *x = of_y + at.lead * z;
        (of_y, of_z) = (-at.lead * at.fade * z, -at.zero * z);
    }
}

/// log |det| of the map from m to z.
pub(super) fn log_det(undone: &[UndoneLag]) -> f64 {
    undone.iter().map(|at| at.lead.ln()).sum()
}

/// How late what (N6) gives back still is where a sample is far beyond the one before, s: tau less the delay step a / (1 - a) that it
/// takes out. Where samples are near each other it is less, and matters less.
pub fn left_s(step_s: f64, time_constant_s: f64) -> f64 {
    if !(step_s > 0.0 && time_constant_s > 0.0) {
        return 0.0;
    }
    time_constant_s - step_s / (step_s / time_constant_s).exp_m1()
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use super::super::tests::assert_is_rough;
    use super::*;

    fn lag() -> Lag {
        Lag::new([0.0, 0.1, 0.2, 0.1, 0.0, 0.1, 0.3].into_iter(), 0.25)
    }

    fn undone() -> Vec<UndoneLag> {
        lag().undone(&[0.0, 0.01, 0.3, 0.9, 0.0, 0.0, 1.1], 0.2)
    }

    /// Roughness that has passed a filter is roughness again: of its size, and neighbours as alike as they were.
    #[test]
    fn roughness_behind_a_filter_becomes_roughness_again() {
        const FINE: usize = 100;
        const SAMPLES: usize = 6000;
        for (step, further) in [
            (0.3_f64, 0.1_f64),
            (0.3, 2.0),
            (2.5, 0.1),
            (2.5, 1.0),
            (2.5, 4.0),
            (1.0, 1.0),
            (12.0, 3.0),
        ] {
            let mut rng = ChaCha8Rng::seed_from_u64(5);
            let alike = (-further / FINE as f64).exp();
            let (mut rough, mut y) = (0.0, 0.0);
            let mut record = Vec::new();
            for _ in 0..SAMPLES {
                record.push(y);
                for _ in 0..FINE {
                    let noise: f64 = StandardNormal.sample(&mut rng);
                    let before = rough;
                    rough = alike * rough + (1.0 - alike * alike).sqrt() * noise;
                    // the mean over the short step
                    y += (0.5 * (before + rough) - y) * -(-step / FINE as f64).exp_m1();
                }
            }
            let lag = Lag::new((0..SAMPLES).map(|i| if i > 0 { step } else { 0.0 }), 1.0);
            let sliding: Vec<f64> = (0..SAMPLES).map(|i| i as f64 * further).collect();
            take_out(&lag.undone(&sliding, 1.0), &mut record);
            // 5950 numbers: 1.8 % for the variance, 1.3 % for the correlations
            assert_is_rough(&record, further, (0.07, 0.05), &format!("{step}"));
        }
    }

    /// What stands still is shown as it is, and taken out as it is.
    #[test]
    fn a_force_that_stands_still_is_no_other_behind_the_filter() {
        let mut force = vec![2.0; 7];
        lag().put_in(&mut force);
        assert_eq!(force, vec![2.0; 7]);
        let near = lag().undone(&[0.0; 7], 1.0);
        take_out(&near, &mut force);
        for z in force {
            assert!((z / 2.0 - 1.0).abs() < 2e-3, "{z}");
        }
    }

    /// A straight line comes out late by tau once the start is forgotten.
    #[test]
    fn a_straight_line_comes_late_by_the_time_constant() {
        let steps = (0..200).map(|i| if i > 0 { 0.1 } else { 0.0 });
        let mut line: Vec<f64> = (0..200).map(|i| 0.1 * f64::from(i)).collect();
        Lag::new(steps, 0.25).put_in(&mut line);
        assert!((line[199] - (19.9 - 0.25)).abs() < 1e-9);
    }

    /// The change of variables has the determinant that it says.
    #[test]
    fn the_determinant_is_that_of_the_matrix() {
        let undone = undone();
        let matrix = nalgebra::DMatrix::from_columns(
            &(0..7)
                .map(|k| {
                    let mut unit = nalgebra::DVector::zeros(7);
                    unit[k] = 1.0;
                    take_out(&undone, unit.as_mut_slice());
                    unit
                })
                .collect::<Vec<_>>(),
        );
        assert!((matrix.determinant().ln() - log_det(&undone)).abs() < 1e-12);
    }

    #[test]
    fn the_transposed_map_is_the_transposed_matrix() {
        let x = [0.3, -1.0, 2.0, 0.7, -0.2, 1.1, 0.4];
        let y = [1.0, 0.5, -0.3, 2.0, 0.1, -1.2, 0.8];
        let (mut a, mut b) = (x, y);
        take_out(&undone(), &mut a);
        take_out_transposed(&undone(), &mut b);
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        assert!((dot(&a, &y) - dot(&x, &b)).abs() < 1e-12);
    }

    #[test]
    fn a_slow_filter_leaves_half_a_step_and_a_fast_one_all() {
        assert!((left_s(0.01, 1.0) - 0.005).abs() < 1e-4);
        assert!((left_s(1.0, 0.01) - 0.01).abs() < 1e-12);
        assert_eq!(left_s(0.1, 0.0), 0.0);
    }
}

//! A low-pass filter between what makes the noise and what records it.
//!
//! Roughness reaches the record m through the force channel's filter, white noise e does not. The filter is undone at the samples,
//! a = exp(-step/tau) from the sample before and none before the first of a run:
//!
//! ```text
//! z_i = (m_i - a_i m_{i-1}) / (1 - a_i) = f_i (1 + u + q) + (e_i - a_i e_{i-1}) / (1 - a_i)                 (N6)
//! ```
//!
//! so that z has the roughness of (N1) and a moving average of the white noise, which the filter along the runs carries as a state.
//! Undone so, an input that moves on between the samples comes out late by [`left_s`].

/// The filter of a record that has one, a sample; empty: none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lag {
    /// a of (N6); zero at the first sample of a run.
    fade: Vec<f64>,
}

impl Lag {
    /// From the time since the sample before (zero at the first of a run), s, and the time constant, s.
    pub fn new(steps_s: impl Iterator<Item = f64>, time_constant_s: f64) -> Self {
        if !(time_constant_s > 0.0) {
            return Self::default();
        }
        let fade = |step: f64| {
            if step > 0.0 {
                (-step / time_constant_s).exp()
            } else {
                0.0
            }
        };
        Self {
            fade: steps_s.map(fade).collect(),
        }
    }

    /// Whether there is no filter.
    pub fn is_empty(&self) -> bool {
        self.fade.is_empty()
    }

    /// Shares of the white noise in (N6): of the sample's own and of the one before.
    pub(super) fn noise(&self, i: usize) -> (f64, f64) {
        let a = self.fade.get(i).copied().unwrap_or(0.0);
        (1.0 / (1.0 - a), -a / (1.0 - a))
    }

    /// log |det| of the map from m to z.
    pub(super) fn log_det(&self) -> f64 {
        -self.fade.iter().map(|a| (1.0 - a).ln()).sum::<f64>()
    }

    /// z from m.
    pub(super) fn take_out(&self, record: &mut [f64]) {
        for i in (1..self.fade.len()).rev() {
            let a = self.fade[i];
            record[i] = (record[i] - a * record[i - 1]) / (1.0 - a);
        }
    }

    /// The transposed map.
    pub(super) fn take_out_transposed(&self, record: &mut [f64]) {
        for i in 1..self.fade.len() {
            let a = self.fade[i];
            record[i] /= 1.0 - a;
            record[i - 1] -= a * record[i];
        }
    }

    /// m from z.
    pub(super) fn put_in(&self, record: &mut [f64]) {
        for i in 1..self.fade.len() {
            let a = self.fade[i];
            record[i] = a * record[i - 1] + (1.0 - a) * record[i];
        }
    }
}

/// How late what (N6) gives back still is, s: tau less the delay step a / (1 - a) that it takes out.
pub fn left_s(step_s: f64, time_constant_s: f64) -> f64 {
    if !(step_s > 0.0 && time_constant_s > 0.0) {
        return 0.0;
    }
    time_constant_s - step_s / (step_s / time_constant_s).exp_m1()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lag() -> Lag {
        Lag::new([0.0, 0.1, 0.2, 0.1, 0.0, 0.1, 0.3].into_iter(), 0.25)
    }

    #[test]
    fn what_was_put_in_is_taken_out() {
        let force = [1.0, -2.0, 0.5, 3.0, 4.0, 4.0, -1.0];
        let mut record = force;
        lag().put_in(&mut record);
        assert!(record != force);
        lag().take_out(&mut record);
        for (a, b) in record.iter().zip(&force) {
            assert!((a - b).abs() < 1e-14);
        }
    }

    #[test]
    fn the_transposed_map_is_the_transposed_matrix() {
        let x = [0.3, -1.0, 2.0, 0.7, -0.2, 1.1, 0.4];
        let y = [1.0, 0.5, -0.3, 2.0, 0.1, -1.2, 0.8];
        let (mut a, mut b) = (x, y);
        lag().take_out(&mut a);
        lag().take_out_transposed(&mut b);
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

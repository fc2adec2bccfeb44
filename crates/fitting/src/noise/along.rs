//! Whitening along one run: private roughness plus white noise, by a scalar Kalman filter.
//!
//! State u (relative roughness), observation r_i = f_i u(s_i) + w_i:
//!
//! ```text
//! phi_i = exp(-(s_i - s_{i-1}) / length),   u-, P- = phi u, phi^2 P + private^2 (1 - phi^2)
//! S_i = f_i^2 P- + R_i,   gain = P- f_i / S_i,   e_i = r_i - f_i u-,   u = u- + gain e_i,   whitened = e_i / sqrt(S_i)
//! ```
//!
//! The coefficients do not depend on the data: they are kept, and a column costs five operations a sample.

use super::context::{Context, Sizes};

/// The stored filter of all runs.
pub(super) struct Along {
    /// phi_i, and zero at the first sample of a run.
    pub(super) decay: Vec<f64>,
    pub(super) scale: Vec<f64>,
    pub(super) gain: Vec<f64>,
    pub(super) inverse_sd: Vec<f64>,
    /// log det of the covariance of private roughness and white noise.
    pub(super) log_det: f64,
}

impl Along {
    /// Runs the filter's covariance recursion; `extra_variance` is added to the white noise of each sample.
    pub(super) fn new(context: &Context, sizes: &Sizes, extra_variance: &[f64]) -> Self {
        let n = context.samples();
        let private = sizes.private * sizes.private;
        let white = sizes.sensor * sizes.sensor;
        let mut filter = Self {
            decay: vec![0.0; n],
            scale: context.scale.clone(),
            gain: vec![0.0; n],
            inverse_sd: vec![0.0; n],
            log_det: 0.0,
        };
        for run in &context.runs {
            let mut variance = private;
            for i in run.clone() {
                if i > run.start {
                    let step = context.sliding[i] - context.sliding[i - 1];
                    let phi = (-step / sizes.length).exp();
                    filter.decay[i] = phi;
                    variance = phi * phi * variance + private * (1.0 - phi * phi);
                }
                let f = context.scale[i];
                let total = f * f * variance + white + extra_variance[i];
                let gain = variance * f / total;
                variance -= gain * f * variance;
                filter.gain[i] = gain;
                filter.inverse_sd[i] = 1.0 / total.sqrt();
                filter.log_det += total.ln();
            }
        }
        filter
    }

    /// Replaces a stacked column by its whitened innovations.
    pub(super) fn whiten(&self, column: &mut [f64]) {
        let mut state = 0.0;
        for (i, x) in column.iter_mut().enumerate() {
            state *= self.decay[i];
            let innovation = *x - self.scale[i] * state;
            state += self.gain[i] * innovation;
            *x = innovation * self.inverse_sd[i];
        }
    }
}

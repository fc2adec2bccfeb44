//! Whitening along one run: private roughness, what the plate's grid leaves between its nodes, and white noise, by a
//! Kalman filter of two states.
//!
//! State x = (u, w): relative roughness private to the run, and the part of the plate's field that its grid does not
//! resolve (variance and length such that its steps over short distances are those of the field). Observation
//! r_i = f_i (u + w) + e_i. With phi = exp(-step/length) of each state,
//!
//! ```text
//! x- = phi x,   P- = phi P phi' + stationary variance (1 - phi^2)
//! S_i = f_i^2 1'P-1 + sensor^2,   gain = f_i P-1 / S_i,   e_i = r_i - f_i 1'x-,   x = x- + gain e_i,
//! whitened = e_i / sqrt(S_i)
//! ```
//!
//! Behind a filter of the channel (N6) the white noise is b e_i + h e_{i-1}: e is a third state, of which nothing but the last
//! sample's innovation tells.
//!
//! The coefficients do not depend on the data: they are kept, and a column costs ten operations a sample.

use super::context::{Context, Sizes};
use super::vectors::wide;

/// Columns that are swept together.
pub(super) const TOGETHER: usize = 8;

/// The stored filter of all runs.
pub(super) struct Along {
    /// phi of both states, and zero at the first sample of a run.
    pub(super) decay: Vec<[f64; 2]>,
    /// Friction force that roughness multiplies, less where a row is the mean of several samples.
    pub(super) scale: Vec<f64>,
    pub(super) gain: Vec<[f64; 2]>,
    /// Gain of the white noise and h; empty where there is no filter.
    pub(super) white: Vec<[f64; 2]>,
    pub(super) inverse_sd: Vec<f64>,
    /// log det of the covariance of private roughness, unresolved field and white noise.
    pub(super) log_det: f64,
}

impl Along {
    /// Runs the filter's covariance recursion; `unresolved` is the share of the plate field's variance between nodes.
    pub(super) fn new(context: &Context, sizes: &Sizes, unresolved: f64) -> Self {
        let n = context.samples();
        let private = sizes.private * sizes.private;
        let between = sizes.plate * sizes.plate * unresolved;
        let lengths = [sizes.length, sizes.length * unresolved.max(1e-6)];
        let white = sizes.sensor * sizes.sensor;
        let mut filter = Self {
            decay: vec![[0.0; 2]; n],
            scale: context.scale.clone(),
            gain: vec![[0.0; 2]; n],
            white: Vec::new(),
            inverse_sd: vec![0.0; n],
            log_det: 0.0,
        };
        let means: Vec<(f64, f64)> = (context.rows.iter())
            .map(|row| row.in_chain(sizes.length))
            .collect();
        for (scale, (root, _)) in filter.scale.iter_mut().zip(&means) {
            *scale *= root;
        }
        for run in &context.runs {
            // Covariance [[p, c], [c, q]] of the two states.
            let (mut p, mut c, mut q) = (private, 0.0, between);
            // Variance of the last white noise and its covariances with the two.
            let (mut e, mut pe, mut qe) = (0.0, 0.0, 0.0);
            for i in run.clone() {
                if i > run.start {
                    let mut step = context.sliding[i] - context.sliding[i - 1];
                    if !means.is_empty() {
                        step = (step + sizes.length * (means[i - 1].1 + means[i].1)).max(0.0);
                    }
                    let phi = lengths.map(|l| (-step / l).exp());
                    filter.decay[i] = phi;
                    p = phi[0] * phi[0] * p + private * (1.0 - phi[0] * phi[0]);
                    q = phi[1] * phi[1] * q + between * (1.0 - phi[1] * phi[1]);
                    c *= phi[0] * phi[1];
                    pe *= phi[0];
                    qe *= phi[1];
                }
                let f = filter.scale[i];
                let (b, h) = match context.lag.is_empty() {
                    true => (1.0, 0.0),
                    false => context.lag.noise(i),
                };
                let of_white = b * b * white + h * h * e + 2.0 * f * h * (pe + qe);
                let total = f * f * (p + 2.0 * c + q) + of_white;
                let seen = [f * (p + c) + h * pe, f * (c + q) + h * qe];
                let gain = seen.map(|s| s / total);
                if !context.lag.is_empty() {
                    let own = b * white / total;
                    e = white - own * own * total;
                    (pe, qe) = (-gain[0] * own * total, -gain[1] * own * total);
                    filter.white.push([own, h]);
                }
                p -= gain[0] * seen[0];
                q -= gain[1] * seen[1];
                c -= gain[0] * seen[1];
                filter.gain[i] = gain;
                filter.inverse_sd[i] = 1.0 / total.sqrt();
                filter.log_det += total.ln();
            }
        }
        filter
    }

    /// Replaces stacked columns by their whitened innovations. The recursion of a column waits for its own last sample:
    /// several columns side by side keep the processor busy, and no column's arithmetic changes.
    pub(super) fn whiten(&self, columns: &mut [&mut [f64]]) {
        wide(
            #[inline(always)]
            || {
                if self.white.is_empty() {
                    self.innovations::<false>(columns);
                } else {
                    self.innovations::<true>(columns);
                }
            },
        );
    }

    #[inline(always)]
    fn innovations<const LAGGED: bool>(&self, columns: &mut [&mut [f64]]) {
        for block in columns.chunks_mut(TOGETHER) {
            let (mut u, mut w) = ([0.0; TOGETHER], [0.0; TOGETHER]);
            let mut e = [0.0; TOGETHER];
            for i in 0..self.scale.len() {
                let (decay, gain) = (self.decay[i], self.gain[i]);
                let white = if LAGGED { self.white[i] } else { [0.0; 2] };
                let mut x = [0.0; TOGETHER];
                for (x, column) in x.iter_mut().zip(block.iter()) {
                    *x = column[i];
                }
                for k in 0..TOGETHER {
                    u[k] *= decay[0];
                    w[k] *= decay[1];
                    let mut innovation = x[k] - self.scale[i] * (u[k] + w[k]);
                    if LAGGED {
                        innovation -= white[1] * e[k];
                        e[k] = white[0] * innovation;
                    }
                    u[k] += gain[0] * innovation;
                    w[k] += gain[1] * innovation;
                    x[k] = innovation * self.inverse_sd[i];
                }
                for (x, column) in x.iter().zip(block.iter_mut()) {
                    column[i] = *x;
                }
            }
        }
    }

    /// Replaces a stacked column x by (the filter)' x: the same recursion run backwards on the adjoint states.
    pub(super) fn whiten_transposed(&self, column: &mut [f64]) {
        let (mut u, mut w, mut e) = (0.0, 0.0, 0.0);
        for (i, x) in column.iter_mut().enumerate().rev() {
            let mut innovation =
                *x * self.inverse_sd[i] + self.gain[i][0] * u + self.gain[i][1] * w;
            if let Some([own, h]) = self.white.get(i) {
                innovation += own * e;
                e = -h * innovation;
            }
            u = (u - self.scale[i] * innovation) * self.decay[i][0];
            w = (w - self.scale[i] * innovation) * self.decay[i][1];
            *x = innovation;
        }
    }
}

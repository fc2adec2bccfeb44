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
//! Smooth roughness (N7) has its driver v as a further state, which is not observed.
//!
//! The coefficients do not depend on the data: they are kept, and a column costs ten operations a sample.

use super::context::{Context, Sizes};
use super::roughness::{Roughness, Step};
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
    /// The driver of smooth roughness; empty where it is exponential.
    driver: Vec<Driver>,
    /// Gain of the white noise and h; empty where there is no filter.
    pub(super) white: Vec<[f64; 2]>,
    pub(super) inverse_sd: Vec<f64>,
    /// log det of the covariance of private roughness, unresolved field and white noise.
    pub(super) log_det: f64,
}

/// What the driver v of smooth roughness does at a sample.
#[derive(Clone, Copy, Default)]
pub(super) struct Driver {
    /// Share of v that has gone into u since the sample before.
    pub(super) feed: f64,
    /// phi of v.
    pub(super) decay: f64,
    pub(super) gain: f64,
}

/// Covariance of the states: u, its driver v, the field between the nodes w, the last white noise e.
struct Covariance {
    uu: f64,
    uv: f64,
    vv: f64,
    uw: f64,
    vw: f64,
    ww: f64,
    ee: f64,
    ue: f64,
    ve: f64,
    we: f64,
}

impl Covariance {
    /// At the first sample of a run.
    fn stationary(private: f64, between: f64, roughness: Roughness) -> Self {
        Self {
            uu: private,
            uv: private,
            vv: private * roughness.driver(),
            uw: 0.0,
            vw: 0.0,
            ww: between,
            ee: 0.0,
            ue: 0.0,
            ve: 0.0,
            we: 0.0,
        }
    }

    /// One step on: x = Phi x, and the stationary covariance S less what of it is left, S - Phi (S - P) Phi'.
    fn advance(&mut self, stationary: &Self, step: Step, w: f64) {
        let Step { fast, feed, slow } = step;
        let (uu, uv, vv) = (
            stationary.uu - self.uu,
            stationary.uv - self.uv,
            stationary.vv - self.vv,
        );
        self.uu = stationary.uu - (fast * fast * uu + 2.0 * fast * feed * uv + feed * feed * vv);
        self.uv = stationary.uv - slow * (fast * uv + feed * vv);
        self.vv = stationary.vv - slow * slow * vv;
        self.uw = w * (fast * self.uw + feed * self.vw);
        self.vw *= slow * w;
        self.ue = fast * self.ue + feed * self.ve;
        self.ve *= slow;
        self.advance_field(stationary.ww, w);
    }

    /// The same where the roughness is exponential and has no driver.
    fn advance_exponential(&mut self, stationary: &Self, u: f64, w: f64) {
        self.uu = u * u * self.uu + stationary.uu * (1.0 - u * u);
        self.uw *= u * w;
        self.ue *= u;
        self.advance_field(stationary.ww, w);
    }

    fn advance_field(&mut self, stationary: f64, w: f64) {
        self.ww = w * w * self.ww + stationary * (1.0 - w * w);
        self.we *= w;
    }

    /// What a sample f (u + w) + b e + h e_before tells: its variance and the gains of u, v, w and e.
    fn observe(&mut self, f: f64, (b, h): (f64, f64), white: f64) -> (f64, [f64; 4]) {
        let of_white = b * b * white + h * h * self.ee + 2.0 * f * h * (self.ue + self.we);
        let total = f * f * (self.uu + 2.0 * self.uw + self.ww) + of_white;
        let seen = [
            f * (self.uu + self.uw) + h * self.ue,
            f * (self.uv + self.vw) + h * self.ve,
            f * (self.uw + self.ww) + h * self.we,
        ];
        let [u, v, w] = seen.map(|s| s / total);
        let e = b * white / total;
        self.uu -= u * seen[0];
        self.uv -= u * seen[1];
        self.vv -= v * seen[1];
        self.uw -= u * seen[2];
        self.vw -= v * seen[2];
        self.ww -= w * seen[2];
        self.ee = white - e * e * total;
        (self.ue, self.ve, self.we) = (-u * e * total, -v * e * total, -w * e * total);
        (total, [u, v, w, e])
    }
}

impl Along {
    /// Runs the filter's covariance recursion; `unresolved` is the share of the plate field's variance between nodes.
    pub(super) fn new(context: &Context, sizes: &Sizes, unresolved: f64) -> Self {
        let n = context.samples();
        let roughness = Roughness::new(sizes);
        let stationary = Covariance::stationary(
            sizes.private * sizes.private,
            sizes.plate * sizes.plate * unresolved,
            roughness,
        );
        let between = sizes.length * unresolved.max(1e-6);
        let white = sizes.sensor * sizes.sensor;
        let mut filter = Self {
            decay: vec![[0.0; 2]; n],
            scale: context.scale.clone(),
            gain: vec![[0.0; 2]; n],
            driver: Vec::new(),
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
            let mut state = Covariance { ..stationary };
            for i in run.clone() {
                let mut driver = Driver::default();
                if i > run.start {
                    let mut way = context.sliding[i] - context.sliding[i - 1];
                    if !means.is_empty() {
                        way = (way + sizes.length * (means[i - 1].1 + means[i].1)).max(0.0);
                    }
                    let w = (-way / between).exp();
                    if roughness.is_exponential() {
                        let u = (-way / sizes.length).exp();
                        state.advance_exponential(&stationary, u, w);
                        filter.decay[i] = [u, w];
                    } else {
                        let step = roughness.step(way);
                        state.advance(&stationary, step, w);
                        filter.decay[i] = [step.fast, w];
                        (driver.feed, driver.decay) = (step.feed, step.slow);
                    }
                }
                let shares = match context.lag.is_empty() {
                    true => (1.0, 0.0),
                    false => context.lag.noise(i),
                };
                let (total, [u, v, w, e]) = state.observe(filter.scale[i], shares, white);
                if !context.lag.is_empty() {
                    filter.white.push([e, shares.1]);
                }
                if !roughness.is_exponential() {
                    filter.driver.push(Driver { gain: v, ..driver });
                }
                filter.gain[i] = [u, w];
                filter.inverse_sd[i] = 1.0 / total.sqrt();
                filter.log_det += total.ln();
            }
        }
        filter
    }

    /// The driver at a sample; of exponential roughness none.
    pub(super) fn driver(&self, i: usize) -> Driver {
        self.driver.get(i).copied().unwrap_or_default()
    }

    /// Replaces stacked columns by their whitened innovations. The recursion of a column waits for its own last sample:
    /// several columns side by side keep the processor busy, and no column's arithmetic changes.
    pub(super) fn whiten(&self, columns: &mut [&mut [f64]]) {
        wide(
            #[inline(always)]
            || match (self.white.is_empty(), self.driver.is_empty()) {
                (true, true) => self.innovations::<false, false>(columns),
                (false, true) => self.innovations::<true, false>(columns),
                (true, false) => self.innovations::<false, true>(columns),
                (false, false) => self.innovations::<true, true>(columns),
            },
        );
    }

    #[inline(always)]
    fn innovations<const LAGGED: bool, const SMOOTH: bool>(&self, columns: &mut [&mut [f64]]) {
        for block in columns.chunks_mut(TOGETHER) {
            let (mut u, mut w) = ([0.0; TOGETHER], [0.0; TOGETHER]);
            let (mut v, mut e) = ([0.0; TOGETHER], [0.0; TOGETHER]);
            for i in 0..self.scale.len() {
                let (decay, gain) = (self.decay[i], self.gain[i]);
                let white = if LAGGED { self.white[i] } else { [0.0; 2] };
                let driver = if SMOOTH {
                    self.driver[i]
                } else {
                    Driver::default()
                };
                let mut x = [0.0; TOGETHER];
                for (x, column) in x.iter_mut().zip(block.iter()) {
                    *x = column[i];
                }
                for k in 0..TOGETHER {
                    u[k] *= decay[0];
                    w[k] *= decay[1];
                    if SMOOTH {
                        u[k] += driver.feed * v[k];
                        v[k] *= driver.decay;
                    }
                    let mut innovation = x[k] - self.scale[i] * (u[k] + w[k]);
                    if LAGGED {
                        innovation -= white[1] * e[k];
                        e[k] = white[0] * innovation;
                    }
                    u[k] += gain[0] * innovation;
                    w[k] += gain[1] * innovation;
                    if SMOOTH {
                        v[k] += driver.gain * innovation;
                    }
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
        let (mut u, mut v, mut w, mut e) = (0.0, 0.0, 0.0, 0.0);
        for (i, x) in column.iter_mut().enumerate().rev() {
            let driver = self.driver(i);
            let mut innovation = *x * self.inverse_sd[i]
                + self.gain[i][0] * u
                + self.gain[i][1] * w
                + driver.gain * v;
            if let Some([own, h]) = self.white.get(i) {
                innovation += own * e;
                e = -h * innovation;
            }
            let after = u - self.scale[i] * innovation;
            u = after * self.decay[i][0];
            v = v * driver.decay + after * driver.feed;
            w = (w - self.scale[i] * innovation) * self.decay[i][1];
            *x = innovation;
        }
    }
}

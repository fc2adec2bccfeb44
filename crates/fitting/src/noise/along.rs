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
//! Behind a filter or a resonance the white noise is coloured (N8): its recursion's states s join, and r_i = f_i (u + w) + s_1 + c_0 e_i.
//!
//! Smooth roughness (N7) has its driver v as a further state, which is not observed. Where the force channel wanders its wander a is one that
//! decays with time and not with the way, and r_i = f_i (u + w) + a + ....
//!
//! The coefficients do not depend on the data: they are kept, and a column costs ten operations a sample.

use super::channel::{Colour, MOST_STATES, Undone};
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
    /// The wander of the force channel; empty where there is none.
    wander: Vec<Wander>,
    /// States of the coloured noise.
    pub(super) states: usize,
    /// The coloured noise; empty where it is white.
    coloured: Vec<Coloured>,
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

/// What the force channel's wander does at a sample.
#[derive(Clone, Copy, Default)]
pub(super) struct Wander {
    /// exp(-step/time), and zero at the first sample of a run.
    pub(super) decay: f64,
    pub(super) gain: f64,
}

/// What the coloured noise does at a sample.
#[derive(Clone, Copy, Default)]
pub(super) struct Coloured {
    pub(super) colour: Colour,
    /// Gain of e.
    gain: f64,
    /// Gains of the recursion's states.
    gains: [f64; MOST_STATES],
}

impl Coloured {
    /// The estimated states and e one sample on.
    #[inline(always)]
    pub(super) fn advance<const N: usize>(&self, states: &mut [f64; N], e: f64) {
        let first = states.first().copied().unwrap_or_default();
        for j in 0..N {
            let next = states.get(j + 1).copied().unwrap_or_default();
            states[j] =
                self.colour.keep * next - self.colour.back[j] * first + self.colour.feed[j] * e;
        }
    }

    /// The estimated states and e after an innovation.
    #[inline(always)]
    pub(super) fn update<const N: usize>(&self, states: &mut [f64; N], innovation: f64) -> f64 {
        for (s, gain) in states.iter_mut().zip(&self.gains) {
            *s += gain * innovation;
        }
        self.gain * innovation
    }

    /// Adjoints of the states and of e before the innovation, from those after the advance that follows.
    fn advance_adjoint<const N: usize>(&self, states: &mut [f64; N]) -> f64 {
        let after = *states;
        let sum = |of: &[f64]| after.iter().zip(of).map(|(s, x)| s * x).sum::<f64>();
        for j in 1..N {
            states[j] = self.colour.keep * after[j - 1];
        }
        if let Some(first) = states.first_mut() {
            *first = -sum(&self.colour.back);
        }
        sum(&self.colour.feed)
    }
}

/// Covariance of the states: u, its driver v, the field between the nodes w, the wander a, those of the coloured noise s and the last e.
#[derive(Clone)]
struct Covariance<const N: usize> {
    uu: f64,
    uv: f64,
    vv: f64,
    uw: f64,
    vw: f64,
    ww: f64,
    /// Of a with u, v, w and itself.
    au: f64,
    av: f64,
    aw: f64,
    aa: f64,
    us: [f64; N],
    vs: [f64; N],
    ws: [f64; N],
    as_: [f64; N],
    ss: [[f64; N]; N],
    /// Of e with u, v, w, a, the states s and itself.
    eu: f64,
    ev: f64,
    ew: f64,
    ea: f64,
    es: [f64; N],
    ee: f64,
}

/// What a sample tells: its variance and the gains of u, v, w, a, e and s.
struct Told<const N: usize> {
    variance: f64,
    roughness: [f64; 3],
    wander: f64,
    e: f64,
    states: [f64; N],
}

impl<const N: usize> Covariance<N> {
    /// At the first sample of a run.
    fn stationary(private: f64, between: f64, wander: f64, roughness: Roughness) -> Self {
        Self {
            uu: private,
            uv: private,
            vv: private * roughness.driver(),
            uw: 0.0,
            vw: 0.0,
            ww: between,
            au: 0.0,
            av: 0.0,
            aw: 0.0,
            aa: wander,
            us: [0.0; N],
            vs: [0.0; N],
            ws: [0.0; N],
            as_: [0.0; N],
            ss: [[0.0; N]; N],
            eu: 0.0,
            ev: 0.0,
            ew: 0.0,
            ea: 0.0,
            es: [0.0; N],
            ee: 0.0,
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
        self.au = fast * self.au + feed * self.av;
        self.av *= slow;
        for (us, vs) in self.us.iter_mut().zip(&mut self.vs) {
            *us = fast * *us + feed * *vs;
            *vs *= slow;
        }
        self.advance_field(stationary.ww, w);
    }

    /// The same where the roughness is exponential and has no driver.
    fn advance_exponential(&mut self, stationary: &Self, u: f64, w: f64) {
        self.uu = u * u * self.uu + stationary.uu * (1.0 - u * u);
        self.uw *= u * w;
        self.au *= u;
        self.us.iter_mut().for_each(|us| *us *= u);
        self.advance_field(stationary.ww, w);
    }

    fn advance_field(&mut self, stationary: f64, w: f64) {
        self.ww = w * w * self.ww + stationary * (1.0 - w * w);
        self.aw *= w;
        self.ws.iter_mut().for_each(|ws| *ws *= w);
    }

    /// The wander one step in time on.
    fn advance_wander(&mut self, stationary: f64, decay: f64) {
        self.aa = decay * decay * self.aa + stationary * (1.0 - decay * decay);
        for with in [&mut self.au, &mut self.av, &mut self.aw] {
            *with *= decay;
        }
        self.as_.iter_mut().for_each(|with| *with *= decay);
    }

    /// The coloured noise one sample on, s = M s + feed e; before u, v, w and a move.
    fn advance_noise(&mut self, colour: &Colour) {
        // covariances with the states after, from those with the states and with e before
        let after = |with: &[f64; N], with_e: f64| -> [f64; N] {
            std::array::from_fn(|j| {
                let next = with.get(j + 1).copied().unwrap_or_default();
                next - colour.back[j] * with[0] + colour.feed[j] * with_e
            })
        };
        if N == 0 {
            return;
        }
        self.us = after(&self.us, self.eu);
        self.vs = after(&self.vs, self.ev);
        self.ws = after(&self.ws, self.ew);
        self.as_ = after(&self.as_, self.ea);
        let rows: [[f64; N]; N] = std::array::from_fn(|i| after(&self.ss[i], self.es[i]));
        let of_e = after(&self.es, self.ee);
        self.ss = std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let next = rows.get(i + 1).map_or(0.0, |row| row[j]);
                next - colour.back[i] * rows[0][j] + colour.feed[i] * of_e[j]
            })
        });
    }

    /// What a sample f (u + w) + a + s_1 + c_0 e tells.
    fn observe(&mut self, f: f64, own: f64, white: f64) -> Told<N> {
        let first = |of: &[f64; N]| of.first().copied().unwrap_or_default();
        // covariances of a state with what of a sample does not scale with f
        let (us, vs, ws) = (
            first(&self.us) + self.au,
            first(&self.vs) + self.av,
            first(&self.ws) + self.aw,
        );
        let (sa, ss) = (first(&self.as_), self.ss.first().map_or(0.0, |row| row[0]));
        let of_white = own * own * white + ss + 2.0 * sa + self.aa + 2.0 * f * (us + ws);
        let variance = f * f * (self.uu + 2.0 * self.uw + self.ww) + of_white;
        let seen = [
            f * (self.uu + self.uw) + us,
            f * (self.uv + self.vw) + vs,
            f * (self.uw + self.ww) + ws,
            f * (self.au + self.aw) + self.aa + sa,
        ];
        let seen_states: [f64; N] =
            std::array::from_fn(|j| f * (self.us[j] + self.ws[j]) + self.as_[j] + self.ss[0][j]);
        let [u, v, w, a] = seen.map(|s| s / variance);
        let states = seen_states.map(|s| s / variance);
        let seen_e = own * white;
        let e = seen_e / variance;
        self.uu -= u * seen[0];
        self.uv -= u * seen[1];
        self.vv -= v * seen[1];
        self.uw -= u * seen[2];
        self.vw -= v * seen[2];
        self.ww -= w * seen[2];
        self.au -= u * seen[3];
        self.av -= v * seen[3];
        self.aw -= w * seen[3];
        self.aa -= a * seen[3];
        for j in 0..N {
            self.us[j] -= u * seen_states[j];
            self.vs[j] -= v * seen_states[j];
            self.ws[j] -= w * seen_states[j];
            self.as_[j] -= a * seen_states[j];
            self.es[j] = -e * seen_states[j];
            for i in 0..N {
                self.ss[i][j] -= states[i] * seen_states[j];
            }
        }
        self.ee = white - e * seen_e;
        [self.eu, self.ev, self.ew, self.ea] = [u, v, w, a].map(|gain| -gain * seen_e);
        Told {
            variance,
            roughness: [u, v, w],
            wander: a,
            e,
            states,
        }
    }
}

impl Along {
    /// Runs the filter's covariance recursion; `unresolved` is the share of the plate field's variance between nodes.
    pub(super) fn new(context: &Context, sizes: &Sizes, undone: &Undone, unresolved: f64) -> Self {
        match undone.states() {
            0 => Self::recursion::<0>(context, sizes, undone, unresolved),
            1 => Self::recursion::<1>(context, sizes, undone, unresolved),
            _ => Self::recursion::<MOST_STATES>(context, sizes, undone, unresolved),
        }
    }

    fn recursion<const N: usize>(
        context: &Context,
        sizes: &Sizes,
        undone: &Undone,
        unresolved: f64,
    ) -> Self {
        let n = context.samples();
        let roughness = Roughness::private(sizes);
        let stationary = Covariance::<N>::stationary(
            sizes.private * sizes.private,
            sizes.plate * sizes.plate * unresolved,
            sizes.wander * sizes.wander,
            roughness,
        );
        let wanders = sizes.wander > 0.0;
        let between = sizes.plate_length() * unresolved.max(1e-6);
        let white = sizes.sensor * sizes.sensor;
        let colours = undone.colours(&context.runs);
        let mut filter = Self {
            decay: vec![[0.0; 2]; n],
            scale: context.scale.clone(),
            gain: vec![[0.0; 2]; n],
            driver: Vec::new(),
            wander: Vec::new(),
            states: N,
            coloured: Vec::new(),
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
            let mut state = stationary.clone();
            for i in run.clone() {
                let (mut driver, mut fading) = (Driver::default(), 0.0);
                let colour = colours.get(i).copied();
                if i > run.start {
                    if let Some(colour) = &colour {
                        state.advance_noise(colour);
                    }
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
                    if wanders {
                        fading = (-context.steps_s[i] / sizes.wander_time_s).exp();
                        state.advance_wander(stationary.aa, fading);
                    }
                }
                let own = colour.map_or(1.0, |colour| colour.own);
                let told = state.observe(filter.scale[i], own, white);
                let [u, v, w] = told.roughness;
                if let Some(colour) = colour {
                    let mut gains = [0.0; MOST_STATES];
                    gains[..N].copy_from_slice(&told.states);
                    filter.coloured.push(Coloured {
                        colour,
                        gain: told.e,
                        gains,
                    });
                }
                if !roughness.is_exponential() {
                    filter.driver.push(Driver { gain: v, ..driver });
                }
                if wanders {
                    let (decay, gain) = (fading, told.wander);
                    filter.wander.push(Wander { decay, gain });
                }
                filter.gain[i] = [u, w];
                filter.inverse_sd[i] = 1.0 / told.variance.sqrt();
                filter.log_det += told.variance.ln();
            }
        }
        filter
    }

    /// Whether the roughness is smoother than exponential.
    pub(super) fn is_smooth(&self) -> bool {
        !self.driver.is_empty()
    }

    /// Whether the force channel wanders.
    pub(super) fn wanders(&self) -> bool {
        !self.wander.is_empty()
    }

    /// The driver at a sample; of exponential roughness none.
    pub(super) fn driver(&self, i: usize) -> Driver {
        self.driver.get(i).copied().unwrap_or_default()
    }

    /// The wander at a sample; nothing where there is none.
    pub(super) fn wander(&self, i: usize) -> Wander {
        self.wander.get(i).copied().unwrap_or_default()
    }

    /// The coloured noise at a sample; nothing where it is white.
    pub(super) fn coloured(&self, i: usize) -> Coloured {
        self.coloured.get(i).copied().unwrap_or_default()
    }

    /// Replaces stacked columns by their whitened innovations. The recursion of a column waits for its own last sample:
    /// several columns side by side keep the processor busy, and no column's arithmetic changes.
    pub(super) fn whiten(&self, columns: &mut [&mut [f64]]) {
        wide(
            #[inline(always)]
            || match (self.is_smooth(), self.wanders()) {
                (false, false) => self.innovations_of::<false, false>(columns),
                (true, false) => self.innovations_of::<true, false>(columns),
                (false, true) => self.innovations_of::<false, true>(columns),
                (true, true) => self.innovations_of::<true, true>(columns),
            },
        );
    }

    #[inline(always)]
    fn innovations_of<const SMOOTH: bool, const WANDERS: bool>(&self, columns: &mut [&mut [f64]]) {
        match self.states {
            0 => self.innovations::<0, SMOOTH, WANDERS>(columns),
            1 => self.innovations::<1, SMOOTH, WANDERS>(columns),
            _ => self.innovations::<MOST_STATES, SMOOTH, WANDERS>(columns),
        }
    }

    #[inline(always)]
    fn innovations<const N: usize, const SMOOTH: bool, const WANDERS: bool>(
        &self,
        columns: &mut [&mut [f64]],
    ) {
        for block in columns.chunks_mut(TOGETHER) {
            let (mut u, mut w) = ([0.0; TOGETHER], [0.0; TOGETHER]);
            let (mut v, mut e) = ([0.0; TOGETHER], [0.0; TOGETHER]);
            let mut a = [0.0; TOGETHER];
            let mut states = [[0.0; N]; TOGETHER];
            for i in 0..self.scale.len() {
                let (decay, gain) = (self.decay[i], self.gain[i]);
                let coloured = if N > 0 {
                    self.coloured[i]
                } else {
                    Coloured::default()
                };
                let driver = if SMOOTH {
                    self.driver[i]
                } else {
                    Driver::default()
                };
                let wander = if WANDERS {
                    self.wander[i]
                } else {
                    Wander::default()
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
                    if WANDERS {
                        a[k] *= wander.decay;
                        innovation -= a[k];
                    }
                    if N > 0 {
                        coloured.advance(&mut states[k], e[k]);
                        innovation -= states[k][0];
                        e[k] = coloured.update(&mut states[k], innovation);
                    }
                    u[k] += gain[0] * innovation;
                    w[k] += gain[1] * innovation;
                    if WANDERS {
                        a[k] += wander.gain * innovation;
                    }
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
        let (mut u, mut v, mut w, mut a, mut e) = (0.0, 0.0, 0.0, 0.0, 0.0);
        let mut states = [0.0; MOST_STATES];
        for (i, x) in column.iter_mut().enumerate().rev() {
            let driver = self.driver(i);
            let (coloured, wander) = (self.coloured(i), self.wander(i));
            let of_noise = (states.iter().zip(&coloured.gains)).map(|(s, gain)| s * gain);
            let innovation = *x * self.inverse_sd[i]
                + self.gain[i][0] * u
                + self.gain[i][1] * w
                + driver.gain * v
                + wander.gain * a
                + coloured.gain * e
                + of_noise.sum::<f64>();
            if self.states > 0 {
                states[0] -= innovation;
                e = coloured.advance_adjoint(&mut states);
            }
            let after = u - self.scale[i] * innovation;
            u = after * self.decay[i][0];
            v = v * driver.decay + after * driver.feed;
            w = (w - self.scale[i] * innovation) * self.decay[i][1];
            a = (a - innovation) * wander.decay;
            *x = innovation;
        }
    }
}

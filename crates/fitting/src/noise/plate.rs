//! The roughness that is fixed to the plate, on a grid of nodes.
//!
//! Between two nodes at distances a and b (a + b = h) an Ornstein-Uhlenbeck field is, given the nodes,
//!
//! ```text
//! q(x) = q_j sinh(b/l)/sinh(h/l) + q_{j+1} sinh(a/l)/sinh(h/l) + bridge,
//! var bridge = plate^2 (1 - w_j exp(-a/l) - w_{j+1} exp(-b/l))
//! ```
//!
//! The bridge (h / 3 l of the field's variance) joins the filter along the run. The nodes have a bidiagonal
//! precision root; seen through the filter along the run, a sample's dependence on the nodes forgets older nodes, so
//! that its row is short and the nodes' information matrix is banded.

use std::ops::Range;

use super::along::{Along, TOGETHER};
use super::channel::MOST_STATES;
use super::context::{Context, Sizes};
use super::roughness::Roughness;
use super::vectors::wide;

/// Entries of a row below this (relative to one) are dropped.
const FORGOTTEN: f64 = 1e-5;
/// Never more nodes than this; a finer plate is then resolved only coarsely.
const MOST_NODES: usize = 4000;
/// Never longer rows than this.
const LONGEST_ROW: usize = 96;

/// Equidistant nodes over the plate.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    origin: f64,
    pub(super) spacing: f64,
    pub(super) nodes: usize,
}

impl Grid {
    /// A grid of at most the wished spacing over the campaign's plate.
    pub(super) fn new(context: &Context, spacing: f64) -> Self {
        let (lo, hi) = context.extent();
        let span = (hi - lo).max(1e-12);
        let cells = ((span / spacing).ceil() as usize).clamp(1, MOST_NODES - 1);
        Self {
            origin: lo,
            spacing: span / cells as f64,
            nodes: cells + 1,
        }
    }

    /// Left node, its weight and the right node's weight.
    fn weights(&self, place: f64, length: f64) -> (usize, f64, f64) {
        let t = (place - self.origin) / self.spacing;
        let j = (t.floor().max(0.0) as usize).min(self.nodes - 2);
        let a = (place - self.origin - j as f64 * self.spacing).clamp(0.0, self.spacing);
        let whole = (self.spacing / length).sinh();
        let left = ((self.spacing - a) / length).sinh() / whole;
        (j, left, (a / length).sinh() / whole)
    }

    /// The nodes that sample i of a context sees; the mean over its places where it is the mean of several.
    fn seen(&self, context: &Context, i: usize, length: f64, seen: &mut Seen) {
        let row = context.rows.get(i);
        let (count, step) = row.map_or((1, 0.0), |r| (r.samples as usize, r.step));
        let count = count.max(1);
        let from = context.place[i] - 0.5 * step * (count - 1) as f64;
        seen.weights.clear();
        for k in 0..count {
            let (node, left, right) = self.weights(from + step * k as f64, length);
            if seen.weights.is_empty() {
                seen.first = node;
            }
            let own = node - seen.first;
            if seen.weights.len() < own + 2 {
                seen.weights.resize(own + 2, 0.0);
            }
            seen.weights[own] += left / count as f64;
            seen.weights[own + 1] += right / count as f64;
        }
    }

    /// Share of the field's variance that lies between the nodes, the mean over a cell.
    pub(super) fn unresolved(&self, sizes: &Sizes) -> f64 {
        const POINTS: usize = 32;
        let h = self.spacing / sizes.plate_length();
        let roughness = Roughness::of_plate(sizes);
        let beside = roughness.correlation(self.spacing);
        let sum: f64 = (0..POINTS)
            .map(|k| {
                let a = h * (k as f64 + 0.5) / POINTS as f64;
                let b = h - a;
                let (left, right) = (b.sinh() / h.sinh(), a.sinh() / h.sinh());
                if roughness.is_exponential() {
                    return 1.0 - (left * (-a).exp() + right * (-b).exp());
                }
                let seen = left * roughness.correlation(a * sizes.plate_length())
                    + right * roughness.correlation(b * sizes.plate_length());
                1.0 - 2.0 * seen + left * left + right * right + 2.0 * left * right * beside
            })
            .sum();
        (sum / POINTS as f64).clamp(0.0, 1.0)
    }

    /// The upper triangular root of the nodes' precision, as far as it is not zero: in general
    /// (q_j - a q_{j+1} - b q_{j+2}) / (plate sqrt(noise)), then the last but one beside the last, then the last (see
    /// [`Roughness::nodes`]; b is zero where the roughness is exponential).
    pub(super) fn precision_root(&self, sizes: &Sizes) -> PrecisionRoot {
        let [a, b, noise, beside] = Roughness::of_plate(sizes).nodes(self.spacing);
        let inner = 1.0 / (sizes.plate * noise.sqrt());
        let last_but_one = 1.0 / (sizes.plate * (1.0 - beside * beside).sqrt());
        PrecisionRoot {
            inner: [inner, -a * inner, -b * inner],
            last_but_one: [last_but_one, -beside * last_but_one],
            last: 1.0 / sizes.plate,
        }
    }
}

/// Rows of the root of the nodes' precision, from the diagonal on.
pub(super) struct PrecisionRoot {
    inner: [f64; 3],
    last_but_one: [f64; 2],
    last: f64,
}

impl PrecisionRoot {
    /// Entries that a row may have.
    pub(super) fn width(&self) -> usize {
        if self.inner[2] == 0.0 { 2 } else { 3 }
    }

    /// Row j of so many nodes.
    pub(super) fn row(&self, j: usize, nodes: usize) -> &[f64] {
        match nodes - 1 - j {
            0 => std::slice::from_ref(&self.last),
            1 => &self.last_but_one,
            _ => &self.inner[..self.width()],
        }
    }

    /// Sum of the logarithms of the diagonal.
    pub(super) fn log_diagonal(&self, nodes: usize) -> f64 {
        (0..nodes).map(|j| self.row(j, nodes)[0].ln()).sum()
    }

    /// Size of a node's own entry.
    pub(super) fn size(&self) -> f64 {
        self.inner[0]
    }
}

/// What one sample sees of the nodes, from node `first` on.
#[derive(Default)]
struct Seen {
    first: usize,
    weights: Vec<f64>,
}

/// The state of the filter along a run as a function of one node: private roughness, field between the nodes, driver, wander, white noise
/// and the states of its colour.
#[derive(Clone, Copy)]
struct Sent<const N: usize> {
    u: f64,
    w: f64,
    v: f64,
    a: f64,
    e: f64,
    noise: [f64; N],
}

impl<const N: usize> Default for Sent<N> {
    fn default() -> Self {
        Self {
            u: 0.0,
            w: 0.0,
            v: 0.0,
            a: 0.0,
            e: 0.0,
            noise: [0.0; N],
        }
    }
}

impl<const N: usize> Sent<N> {
    /// Whether nothing is left of the node where the force is f. (e is in the noise's states by then.)
    fn is_forgotten(&self, f: f64) -> bool {
        let noise = self.noise.iter().chain([&self.a]).filter(|s| **s != 0.0);
        let noise: f64 = noise.map(|s| (s / f).abs()).sum();
        self.u.abs() + self.w.abs() + self.v.abs() + noise < FORGOTTEN
    }
}

/// Rows of the whitened design of the nodes: row i is the response of innovation i to the nodes.
pub(super) struct Rows {
    pub(super) first: Vec<usize>,
    offset: Vec<usize>,
    values: Vec<f64>,
    /// Longest row.
    pub(super) width: usize,
}

impl Rows {
    /// Sends the nodes' design through the filter along each run.
    pub(super) fn new(context: &Context, sizes: &Sizes, grid: &Grid, along: &Along) -> Self {
        match along.states {
            0 => Self::sent::<0>(context, sizes, grid, along),
            1 => Self::sent::<1>(context, sizes, grid, along),
            _ => Self::sent::<MOST_STATES>(context, sizes, grid, along),
        }
    }

    fn sent<const N: usize>(context: &Context, sizes: &Sizes, grid: &Grid, along: &Along) -> Self {
        let n = context.samples();
        let mut rows = Self {
            first: Vec::with_capacity(n),
            offset: Vec::with_capacity(n + 1),
            values: Vec::with_capacity(n * 16),
            width: 0,
        };
        rows.offset.push(0);
        // The filter's state as a function of the nodes lo..hi.
        let nothing = Sent::<N>::default();
        let mut state = vec![nothing; grid.nodes];
        let mut seen = Seen::default();
        for run in &context.runs {
            state.fill(nothing);
            let (mut lo, mut hi) = (0, 0);
            for i in run.clone() {
                grid.seen(context, i, sizes.plate_length(), &mut seen);
                let ends = (seen.first, seen.first + seen.weights.len());
                let decay = along.decay[i];
                let driver = along.driver(i);
                let (coloured, wander) = (along.coloured(i), along.wander(i));
                for Sent {
                    u,
                    w,
                    v,
                    a,
                    e,
                    noise,
                } in &mut state[lo..hi]
                {
                    *u = *u * decay[0] + driver.feed * *v;
                    *w *= decay[1];
                    *v *= driver.decay;
                    *a *= wander.decay;
                    coloured.advance(noise, *e);
                }
                let (f, along_scale) = (context.scale[i], along.scale[i]);
                while lo < hi && state[lo].is_forgotten(f) {
                    state[lo] = nothing;
                    lo += 1;
                }
                while lo < hi && state[hi - 1].is_forgotten(f) {
                    hi -= 1;
                    state[hi] = nothing;
                }
                (lo, hi) = if lo == hi {
                    ends
                } else {
                    (lo.min(ends.0), hi.max(ends.1))
                };
                while hi - lo > LONGEST_ROW {
                    if ends.0 as isize - lo as isize > hi as isize - ends.1 as isize {
                        state[lo] = nothing;
                        lo += 1;
                    } else {
                        hi -= 1;
                        state[hi] = nothing;
                    }
                }
                let (gain, weight) = (along.gain[i], along.inverse_sd[i]);
                for (j, state) in state.iter_mut().enumerate().take(hi).skip(lo) {
                    let direct = j.checked_sub(seen.first).and_then(|k| seen.weights.get(k));
                    let direct = direct.map_or(0.0, |w| f * w);
                    let noise = state.noise.first().copied().unwrap_or_default();
                    let innovation = direct - along_scale * (state.u + state.w) - state.a - noise;
                    state.e = coloured.update(&mut state.noise, innovation);
                    state.u += gain[0] * innovation;
                    state.w += gain[1] * innovation;
                    state.v += driver.gain * innovation;
                    state.a += wander.gain * innovation;
                    rows.values.push(innovation * weight);
                }
                rows.first.push(lo);
                rows.offset.push(rows.values.len());
                rows.width = rows.width.max(hi - lo);
            }
        }
        rows
    }

    /// Entries of row i, from node `first[i]` on.
    pub(super) fn row(&self, i: usize) -> &[f64] {
        &self.values[self.offset[i]..self.offset[i + 1]]
    }

    /// A^T x for up to [`TOGETHER`] whitened columns, node by node.
    pub(super) fn transpose_times(&self, columns: &[&[f64]], nodes: usize) -> Vec<[f64; TOGETHER]> {
        wide(
            #[inline(always)]
            || self.gathered(columns, nodes),
        )
    }

    /// A^T of one whitened column, of up to [`TOGETHER`] of its runs apart from one another, node by node.
    pub(super) fn transpose_times_runs(
        &self,
        column: &[f64],
        runs: &[Range<usize>],
        nodes: usize,
    ) -> Vec<[f64; TOGETHER]> {
        wide(
            #[inline(always)]
            || self.gathered_by_run(column, runs, nodes),
        )
    }

    #[inline(always)]
    fn gathered_by_run(
        &self,
        column: &[f64],
        runs: &[Range<usize>],
        nodes: usize,
    ) -> Vec<[f64; TOGETHER]> {
        let mut out = vec![[0.0; TOGETHER]; nodes];
        for (k, run) in runs.iter().enumerate() {
            for i in run.clone() {
                let x = column[i];
                for (o, &a) in out[self.first[i]..].iter_mut().zip(self.row(i)) {
                    o[k] = a.mul_add(x, o[k]);
                }
            }
        }
        out
    }

    #[inline(always)]
    fn gathered(&self, columns: &[&[f64]], nodes: usize) -> Vec<[f64; TOGETHER]> {
        let mut out = vec![[0.0; TOGETHER]; nodes];
        let at = |i: usize| {
            let mut x = [0.0; TOGETHER];
            for (x, column) in x.iter_mut().zip(columns) {
                *x = column[i];
            }
            x
        };
        let n = self.first.len();
        for i in (0..n - n % 2).step_by(2) {
            let (x, y) = (at(i), at(i + 1));
            let (own, next) = (self.row(i), self.row(i + 1));
            let before = self.first[i + 1].checked_sub(self.first[i]);
            let Some(before) = before.filter(|&before| before < own.len()) else {
                add(&mut out[self.first[i]..], own, &x);
                add(&mut out[self.first[i + 1]..], next, &y);
                continue;
            };
            // nodes that both samples see are loaded and stored once
            let (alone, own) = own.split_at(before);
            let both = own.len().min(next.len());
            add(&mut out[self.first[i]..], alone, &x);
            let (shared, after) = out[self.first[i + 1]..].split_at_mut(both);
            for ((o, &a), &b) in shared.iter_mut().zip(own).zip(next) {
                for k in 0..TOGETHER {
                    o[k] = b.mul_add(y[k], a.mul_add(x[k], o[k]));
                }
            }
            add(after, &own[both..], &x);
            add(after, &next[both..], &y);
        }
        if n % 2 == 1 {
            add(&mut out[self.first[n - 1]..], self.row(n - 1), &at(n - 1));
        }
        out
    }
}

/// out_j += a_j x.
#[inline(always)]
fn add(out: &mut [[f64; TOGETHER]], row: &[f64], x: &[f64; TOGETHER]) {
    for (o, &a) in out.iter_mut().zip(row) {
        for k in 0..TOGETHER {
            o[k] = a.mul_add(x[k], o[k]);
        }
    }
}

/// Banded Cholesky factor of the nodes' posterior information, Q^-1 + A^T A = L L^T.
pub(super) struct Information {
    band: usize,
    /// Row j holds L[j, j - band ..= j].
    factor: Vec<f64>,
    nodes: usize,
    /// log det(I + A Q A^T).
    pub(super) log_det: f64,
}

/// Adds A'A to a band that holds M[j + d, j] at j stride + d.
#[inline(always)]
fn add_gram(m: &mut [f64], stride: usize, rows: &Rows) {
    for (i, &first) in rows.first.iter().enumerate() {
        let row = rows.row(i);
        for (a, (&x, column)) in row
            .iter()
            .zip(m[first * stride..].chunks_exact_mut(stride))
            .enumerate()
        {
            for (slot, &y) in column.iter_mut().zip(&row[a..]) {
                *slot = x.mul_add(y, *slot);
            }
        }
    }
}

/// Right-looking Cholesky of the band, in its place.
#[inline(always)]
fn factor_band(m: &mut [f64], stride: usize) {
    let nodes = m.len() / stride;
    for j in 0..nodes {
        let (own, later) = m[j * stride..].split_at_mut(stride);
        let pivot = own[0].max(f64::MIN_POSITIVE).sqrt();
        own[0] = pivot;
        let below = &mut own[1..stride.min(nodes - j)];
        below.iter_mut().for_each(|x| *x /= pivot);
        for (d, column) in (0..below.len()).zip(later.chunks_exact_mut(stride)) {
            let x = below[d];
            for (slot, &y) in column.iter_mut().zip(&below[d..]) {
                *slot = (-x).mul_add(y, *slot);
            }
        }
    }
}

impl Information {
    /// Adds the rows' Gram matrix to the prior precision and factors the sum.
    pub(super) fn new(rows: &Rows, grid: &Grid, sizes: &Sizes) -> Self {
        let nodes = grid.nodes;
        let root = grid.precision_root(sizes);
        let band = rows.width.max(root.width()).min(nodes) - 1;
        let stride = band + 1;
        // m[j * stride + d] = M[j + d, j]
        let mut m = vec![0.0; nodes * stride];
        for j in 0..nodes {
            let row = root.row(j, nodes);
            for (a, x) in row.iter().enumerate() {
                for (d, y) in row[a..].iter().enumerate() {
                    m[(j + a) * stride + d] += x * y;
                }
            }
        }
        wide(
            #[inline(always)]
            || {
                add_gram(&mut m, stride, rows);
                factor_band(&mut m, stride);
            },
        );
        let log_factor: f64 = m.iter().step_by(stride).map(|pivot| pivot.ln()).sum();
        let log_prior = root.log_diagonal(nodes);
        Self {
            band,
            factor: m,
            nodes,
            log_det: 2.0 * (log_factor - log_prior),
        }
    }

    pub(super) fn nodes(&self) -> usize {
        self.nodes
    }

    /// L^-1 b for [`TOGETHER`] columns, node by node.
    pub(super) fn solve_lower(&self, b: &mut [[f64; TOGETHER]]) {
        wide(
            #[inline(always)]
            || self.substitute(b),
        );
    }

    #[inline(always)]
    fn substitute(&self, b: &mut [[f64; TOGETHER]]) {
        let stride = self.band + 1;
        for j in 0..self.nodes {
            let own = &self.factor[j * stride..(j + 1) * stride];
            let reach = self.band.min(self.nodes - 1 - j);
            let (head, rest) = b[j..].split_at_mut(1);
            for x in &mut head[0] {
                *x /= own[0];
            }
            for (b, &l) in rest[..reach].iter_mut().zip(&own[1..]) {
                for k in 0..TOGETHER {
                    b[k] = (-l).mul_add(head[0][k], b[k]);
                }
            }
        }
    }
}

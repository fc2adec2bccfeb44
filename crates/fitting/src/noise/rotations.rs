//! The plate's field removed from the innovations by a square-root information filter.
//!
//! The field's nodes q and the whitened residual r obey, in the least-squares sense, [R; a_i] q = [z; r_i] for each new
//! row a_i. A sweep of Givens rotations folds the row into the triangle R (which keeps its band) and leaves one
//! number: r_i less what all rows before it, and the field's prior, predict, in units of its standard deviation. The
//! numbers so left are the whitened residual, W^T W = (I + A Q A^T)^-1. The rotations do not depend on the data: they
//! are kept and applied to any column.

use super::along::TOGETHER;
use super::context::Sizes;
use super::plate::{Grid, Rows};
use super::vectors::wide;

/// Remaining entries of a row below this, relative to the triangle's diagonal, end its sweep.
const NEGLIGIBLE: f64 = 1e-5;

/// The stored rotations of all rows.
pub(super) struct Rotations {
    nodes: usize,
    first: Vec<usize>,
    offset: Vec<usize>,
    /// Cosine and sine.
    pairs: Vec<(f64, f64)>,
    /// log det(I + A Q A^T).
    pub(super) log_det: f64,
}

impl Rotations {
    /// Folds all rows into the prior's triangle.
    pub(super) fn new(rows: &Rows, grid: &Grid, sizes: &Sizes) -> Self {
        let nodes = grid.nodes;
        let stride = rows.width.max(2).min(nodes);
        let (inner, off, last) = grid.precision_root(sizes);
        let log_prior = (nodes - 1) as f64 * inner.ln() + last.ln();
        let mut triangle = vec![0.0; nodes * stride];
        for j in 0..nodes {
            triangle[j * stride] = if j + 1 < nodes { inner } else { last };
            if j + 1 < nodes {
                triangle[j * stride + 1] = off;
            }
        }
        let n = rows.first.len();
        let mut kept = Self {
            nodes,
            first: rows.first.clone(),
            offset: Vec::with_capacity(n + 1),
            pairs: Vec::with_capacity(n * 24),
            log_det: 0.0,
        };
        kept.offset.push(0);
        let mut line = vec![0.0; nodes + stride];
        for i in 0..n {
            let first = rows.first[i];
            let row = rows.row(i);
            line[first..first + row.len()].copy_from_slice(row);
            let mut end = first + row.len();
            let mut j = first;
            while j < end.min(nodes) {
                let reach = stride.min(nodes - j);
                let own = &mut triangle[j * stride..j * stride + reach];
                let (d, x) = (own[0], line[j]);
                let radius = (d * d + x * x).sqrt();
                let (c, s) = (d / radius, x / radius);
                own[0] = radius;
                line[j] = 0.0;
                kept.pairs.push((c, s));
                j += 1;
                // The triangle's row reaches at least as far as the line does.
                end = end.max((j - 1 + reach).min(nodes));
                let mut left = 0.0_f64;
                for (t, l) in own[1..].iter_mut().zip(&mut line[j..j - 1 + reach]) {
                    (*t, *l) = (c * *t + s * *l, c * *l - s * *t);
                    left = left.max(l.abs());
                }
                if left < NEGLIGIBLE * inner {
                    break;
                }
            }
            line[j..end.max(j)].fill(0.0);
            kept.offset.push(kept.pairs.len());
        }
        let log_after: f64 = (0..nodes).map(|j| triangle[j * stride].abs().ln()).sum();
        kept.log_det = 2.0 * (log_after - log_prior);
        kept
    }

    /// Applies the rotations to up to [`TOGETHER`] columns at once.
    pub(super) fn whiten(&self, columns: &mut [&mut [f64]]) {
        wide(
            #[inline(always)]
            || self.sweep(columns),
        );
    }

    #[inline(always)]
    fn sweep(&self, columns: &mut [&mut [f64]]) {
        for block in columns.chunks_mut(TOGETHER) {
            let mut field = vec![[0.0; TOGETHER]; self.nodes];
            for i in 0..self.first.len() {
                let mut y = [0.0; TOGETHER];
                for (v, column) in y.iter_mut().zip(block.iter()) {
                    *v = column[i];
                }
                let pairs = &self.pairs[self.offset[i]..self.offset[i + 1]];
                for (z, &(c, s)) in field[self.first[i]..].iter_mut().zip(pairs) {
                    for k in 0..TOGETHER {
                        (z[k], y[k]) = (c * z[k] + s * y[k], c * y[k] - s * z[k]);
                    }
                }
                for (v, column) in y.iter().zip(block.iter_mut()) {
                    column[i] = *v;
                }
            }
        }
    }

    /// Applies the transposed rotations, last first, to one column.
    pub(super) fn whiten_transposed(&self, column: &mut [f64]) {
        let mut field = vec![0.0; self.nodes];
        for (i, x) in column.iter_mut().enumerate().rev() {
            let pairs = &self.pairs[self.offset[i]..self.offset[i + 1]];
            let first = self.first[i];
            for (z, &(c, s)) in field[first..first + pairs.len()]
                .iter_mut()
                .zip(pairs)
                .rev()
            {
                (*z, *x) = (c * *z - s * *x, s * *z + c * *x);
            }
        }
    }
}

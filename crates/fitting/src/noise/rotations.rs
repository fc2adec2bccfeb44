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
        wide(
            #[inline(always)]
            || Self::fold(rows, grid, sizes),
        )
    }

    #[inline(always)]
    fn fold(rows: &Rows, grid: &Grid, sizes: &Sizes) -> Self {
        let nodes = grid.nodes;
        let root = grid.precision_root(sizes);
        // Beside the diagonal whole lanes, the last rows reaching beyond the last node, where all is zero.
        let beside = (rows.width.max(root.width()) - 1).next_multiple_of(LANES);
        let stride = 1 + beside;
        let mut triangle = vec![0.0; nodes * stride];
        for (j, own) in triangle.chunks_exact_mut(stride).enumerate() {
            let row = root.row(j, nodes);
            own[..row.len()].copy_from_slice(row);
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
                let (diagonal, own) = triangle[j * stride..(j + 1) * stride].split_at_mut(1);
                let (d, x) = (diagonal[0], line[j]);
                let radius = (d * d + x * x).sqrt();
                let (c, s) = (d / radius, x / radius);
                diagonal[0] = radius;
                line[j] = 0.0;
                kept.pairs.push((c, s));
                j += 1;
                // The triangle's row reaches at least as far as the line does.
                end = end.max(j + beside);
                let left = turn(c, s, own, &mut line[j..j + beside]);
                if left < NEGLIGIBLE * root.size() {
                    break;
                }
            }
            line[j..end.max(j)].fill(0.0);
            kept.offset.push(kept.pairs.len());
        }
        let log_after: f64 = (0..nodes).map(|j| triangle[j * stride].abs().ln()).sum();
        kept.log_det = 2.0 * (log_after - root.log_diagonal(nodes));
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
                        (z[k], y[k]) = (c.mul_add(z[k], s * y[k]), c.mul_add(y[k], -s * z[k]));
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

/// Entries of a row that are turned side by side.
const LANES: usize = 8;

/// (t, l) = (c t + s l, c l - s t) entry by entry; the largest |l| that is left, taken lane by lane so that the loop stays wide. Both are
/// whole lanes long.
#[inline(always)]
fn turn(c: f64, s: f64, triangle: &mut [f64], line: &mut [f64]) -> f64 {
    let larger = |a: f64, b: f64| if a > b { a } else { b };
    let mut largest = [0.0_f64; LANES];
    let lanes = triangle.as_chunks_mut::<LANES>().0.iter_mut();
    for (t, l) in lanes.zip(line.as_chunks_mut::<LANES>().0) {
        // Taken out of memory first: the two might overlap for all that the compiler knows.
        let (own, other) = (*t, *l);
        for k in 0..LANES {
            t[k] = c * own[k] + s * other[k];
        }
        for k in 0..LANES {
            l[k] = c * other[k] - s * own[k];
        }
        for k in 0..LANES {
            largest[k] = larger(l[k].abs(), largest[k]);
        }
    }
    largest.into_iter().fold(0.0, larger)
}

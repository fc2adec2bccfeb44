//! The plate's field removed from the innovations by a square-root information filter.
//!
//! The field's nodes q and the whitened residual r obey, in the least-squares sense, [R; a_i] q = [z; r_i] for each new
//! row a_i. A sweep of Givens rotations folds the row into the triangle R (which keeps its band) and leaves one
//! number: r_i less what all rows before it, and the field's prior, predict, in units of its standard deviation. The
//! numbers so left are the whitened residual, W^T W = (I + A Q A^T)^-1. The rotations do not depend on the data: they
//! are kept and applied to any column.
//!
//! They are free of roots (Gentleman 1973): R = D^(1/2) U with a unit diagonal of U, z = D^(1/2) u, and a row of weight w, one at first.
//! At node j, with x the row's entry there,
//!
//! ```text
//! d' = d + w x^2,   s = w x / d',   w' = w d / d'
//! y' = y - x u,     u' = u + s y'                 for the row's other entries beside those of U, and for the data
//! ```
//!
//! so that a number costs two fused operations instead of four; what is left counts as sqrt(w) y.

use super::along::TOGETHER;
use super::context::Sizes;
use super::grid::Grid;
use super::rows::Rows;
use super::vectors::wide;

/// Remaining entries of a row below this, relative to the triangle's diagonal, end its sweep.
const NEGLIGIBLE: f64 = 1e-5;

/// The stored rotations of all rows.
pub(super) struct Rotations {
    nodes: usize,
    first: Vec<usize>,
    offset: Vec<usize>,
    turns: Vec<Turn>,
    /// sqrt(w) of each row in the end.
    root_weight: Vec<f64>,
    /// log det(I + A Q A^T).
    pub(super) log_det: f64,
}

/// The rotation of a row at one node.
#[derive(Clone, Copy)]
struct Turn {
    x: f64,
    s: f64,
}

impl Turn {
    /// (u, y) -> (u + s y', y'),  y' = y - x u.
    #[inline(always)]
    fn apply(self, u: &mut [f64; TOGETHER], y: &mut [f64; TOGETHER]) {
        for k in 0..TOGETHER {
            y[k] = (-self.x).mul_add(u[k], y[k]);
            u[k] = self.s.mul_add(y[k], u[k]);
        }
    }
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
        let (mut diagonal, mut unit) = (vec![0.0; nodes], vec![0.0; nodes * beside]);
        for j in 0..nodes {
            let row = root.row(j, nodes);
            diagonal[j] = row[0] * row[0];
            let own = unit[j * beside..].iter_mut().zip(&row[1..]);
            own.for_each(|(u, r)| *u = r / row[0]);
        }
        let n = rows.first.len();
        let mut kept = Self {
            nodes,
            first: rows.first.clone(),
            offset: Vec::with_capacity(n + 1),
            turns: Vec::with_capacity(n * 24),
            root_weight: Vec::with_capacity(n),
            log_det: 0.0,
        };
        kept.offset.push(0);
        let negligible = (NEGLIGIBLE * root.size()).powi(2);
        let mut line = vec![0.0; nodes + 1 + beside];
        for i in 0..n {
            let first = rows.first[i];
            let row = rows.row(i);
            line[first..first + row.len()].copy_from_slice(row);
            let mut end = first + row.len();
            let (mut j, mut weight) = (first, 1.0);
            while j < end.min(nodes) {
                let x = line[j];
                let sum = (weight * x).mul_add(x, diagonal[j]);
                let turn = Turn {
                    x,
                    s: weight * x / sum,
                };
                weight *= diagonal[j] / sum;
                diagonal[j] = sum;
                line[j] = 0.0;
                kept.turns.push(turn);
                let own = &mut unit[j * beside..(j + 1) * beside];
                j += 1;
                // The triangle's row reaches at least as far as the line does.
                end = end.max(j + beside);
                let left = fold_beside(turn, own, &mut line[j..j + beside]);
                if weight * left * left < negligible {
                    break;
                }
            }
            line[j..end.max(j)].fill(0.0);
            kept.offset.push(kept.turns.len());
            kept.root_weight.push(weight.sqrt());
        }
        let log_after: f64 = diagonal.iter().map(|d| d.ln()).sum();
        kept.log_det = log_after - 2.0 * root.log_diagonal(nodes);
        kept
    }

    fn turns(&self, row: usize) -> &[Turn] {
        &self.turns[self.offset[row]..self.offset[row + 1]]
    }

    /// Applies the rotations.
    pub(super) fn whiten(&self, columns: &mut [&mut [f64]]) {
        wide(
            #[inline(always)]
            || {
                for block in columns.chunks_mut(TOGETHER) {
                    self.sweep(block);
                }
            },
        );
    }

    /// Row by row, all columns at once.
    #[inline(always)]
    fn sweep(&self, columns: &mut [&mut [f64]]) {
        let mut field = vec![[0.0; TOGETHER]; self.nodes];
        for (i, weight) in self.root_weight.iter().enumerate() {
            let mut y = [0.0; TOGETHER];
            for (v, column) in y.iter_mut().zip(columns.iter()) {
                *v = column[i];
            }
            for (u, turn) in field[self.first[i]..].iter_mut().zip(self.turns(i)) {
                turn.apply(u, &mut y);
            }
            for (v, column) in y.iter().zip(columns.iter_mut()) {
                column[i] = weight * v;
            }
        }
    }

    /// Applies the transposed rotations, last first, to one column.
    pub(super) fn whiten_transposed(&self, column: &mut [f64]) {
        let mut field = vec![0.0; self.nodes];
        for (i, x) in column.iter_mut().enumerate().rev() {
            let turns = self.turns(i);
            let first = self.first[i];
            let mut y = self.root_weight[i] * *x;
            let nodes = field[first..first + turns.len()].iter_mut();
            for (u, turn) in nodes.zip(turns).rev() {
                y = turn.s.mul_add(*u, y);
                *u = (-turn.x).mul_add(y, *u);
            }
            *x = y;
        }
    }
}

/// Entries of a row that are turned side by side.
const LANES: usize = 8;

/// A turn at the entries of a row beside its node; the largest |y'| that is left, taken lane by lane so that the loop stays wide. Both are
/// whole lanes long.
#[inline(always)]
fn fold_beside(turn: Turn, unit: &mut [f64], line: &mut [f64]) -> f64 {
    let larger = |a: f64, b: f64| if a > b { a } else { b };
    let mut largest = [0.0_f64; LANES];
    let lanes = unit.as_chunks_mut::<LANES>().0.iter_mut();
    for (u, y) in lanes.zip(line.as_chunks_mut::<LANES>().0) {
        // Taken out of memory first: the two might overlap for all that the compiler knows.
        let (own, mut left) = (*u, *y);
        for k in 0..LANES {
            left[k] = (-turn.x).mul_add(own[k], left[k]);
        }
        for k in 0..LANES {
            u[k] = turn.s.mul_add(left[k], own[k]);
        }
        for k in 0..LANES {
            largest[k] = larger(left[k].abs(), largest[k]);
        }
        *y = left;
    }
    largest.into_iter().fold(0.0, larger)
}

//! The plate's field taken out of innovations, all samples at once.
//!
//! With A the nodes' whitened design and Q their prior covariance, Q^-1 = R'R, the innovations r have the precision
//! (I + A Q A')^-1, and what is likeliest of the nodes is
//!
//! ```text
//! q = N^-1 A' r,   N = Q^-1 + A'A,   r' (I + A Q A')^-1 r = |r - A q|^2 + |R q|^2                          (N10)
//! ```
//!
//! The two parts of the sum, one below the other, are a root of the precision with more rows than columns: inner products of columns
//! that went through it are those of the noise. It costs a fraction of the square root that goes from sample to sample
//! ([`super::rotations`]), whose rows are innovations.

use super::context::Sizes;
use super::grid::{Grid, PrecisionRoot};
use super::information::Information;
use super::panels::Panels;
use super::rows::Rows;
use super::tiles::{SIDE, Tile};

/// The nodes with all that is known of them.
pub(super) struct Field {
    panels: Panels,
    information: Information,
    root: PrecisionRoot,
    /// Rows that the root has beside those of the samples.
    pub(super) nodes: usize,
    /// log det(I + A Q A').
    pub(super) log_det: f64,
}

impl Field {
    pub(super) fn new(rows: &Rows, grid: &Grid, sizes: &Sizes) -> Self {
        let panels = Panels::of(rows, grid.nodes);
        let root = grid.precision_root(sizes);
        let information = Information::new(&panels, &root, grid.nodes);
        Self {
            root,
            nodes: grid.nodes,
            log_det: information.log_det,
            panels,
            information,
        }
    }

    /// U'^-1 A' X for eight columns: r' (I + A Q A')^-1 r is r'r less the square of it.
    pub(super) fn seen(&self, at: impl Fn(usize) -> [f64; SIDE]) -> Vec<Tile> {
        let mut seen = self.panels.transpose_times(at);
        self.information.solve_transposed(&mut seen);
        seen
    }

    /// The same of columns that are zero outside of their own samples ([`Panels::transpose_times_owned`]).
    pub(super) fn seen_owned(
        &self,
        columns: usize,
        owner: &[usize],
        values: &[f64],
    ) -> Vec<Vec<Tile>> {
        let mut seen = self.panels.transpose_times_owned(columns, owner, values);
        (seen.iter_mut()).for_each(|block| self.information.solve_transposed(block));
        seen
    }

    /// Columns of samples and nodes: innovations become r - A q, the nodes' rows R q.
    pub(super) fn whiten(&self, columns: &mut [&mut [f64]]) {
        for block in columns.chunks_mut(SIDE) {
            let mut q = self.seen(|i| lanes(block, i));
            self.information.solve(&mut q);
            self.panels.take_out(&q, block);
            let samples = block.first().map_or(0, |column| column.len() - self.nodes);
            for j in 0..self.nodes {
                let mut out = [0.0; SIDE];
                for (r, j) in self.root.row(j, self.nodes).iter().zip(j..) {
                    let q = &q[j / SIDE][j % SIDE];
                    (0..SIDE).for_each(|l| out[l] += r * q[l]);
                }
                for (column, out) in block.iter_mut().zip(out) {
                    column[samples + j] = out;
                }
            }
        }
    }

    /// The transposed map: x - A N^-1 (A'x - R'y) of samples x and nodes y, in the place of x.
    pub(super) fn whiten_transposed(&self, column: &mut [f64]) {
        let samples = column.len() - self.nodes;
        let (x, y) = column.split_at_mut(samples);
        let mut parts = [x];
        let mut q = self.panels.transpose_times(|i| lanes(&parts, i));
        for (j, y) in y.iter().enumerate() {
            for (r, j) in self.root.row(j, self.nodes).iter().zip(j..) {
                q[j / SIDE][j % SIDE][0] -= r * y;
            }
        }
        self.information.solve_transposed(&mut q);
        self.information.solve(&mut q);
        self.panels.take_out(&q, &mut parts);
    }
}

/// Columns at a sample, side by side.
#[inline(always)]
fn lanes(columns: &[&mut [f64]], i: usize) -> [f64; SIDE] {
    let mut out = [0.0; SIDE];
    for (out, column) in out.iter_mut().zip(columns) {
        *out = column[i];
    }
    out
}

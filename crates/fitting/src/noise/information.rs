//! What all samples together say of the plate's nodes.

use super::grid::PrecisionRoot;
use super::panels::Panels;
use super::tiles::{self, SIDE, Tile};
use super::vectors::wide;

/// Banded Cholesky factor of the nodes' posterior information, Q^-1 + A'A = U'U, in tiles.
pub(super) struct Information {
    blocks: usize,
    /// Tiles in a row of blocks, from the diagonal on.
    width: usize,
    factor: Vec<Tile>,
    /// log det(I + A Q A').
    pub(super) log_det: f64,
}

impl Information {
    /// Adds the rows' Gram matrix to the prior precision, R'R of so many nodes, and factors the sum.
    pub(super) fn new(panels: &Panels, root: &PrecisionRoot, nodes: usize) -> Self {
        let blocks = panels.blocks;
        // The prior reaches into the next block of nodes.
        let width = panels.width.max(2).min(blocks);
        let mut factor = vec![[[0.0; SIDE]; SIDE]; blocks * width];
        for j in 0..nodes {
            let row = root.row(j, nodes);
            for (a, x) in (j..).zip(row) {
                for (b, y) in (j..).zip(row).skip(a - j) {
                    let tile = &mut factor[a / SIDE * width + b / SIDE - a / SIDE];
                    tile[a % SIDE][b % SIDE] += x * y;
                }
            }
        }
        // Nodes that there are not, so that the last block is full.
        for j in nodes..blocks * SIDE {
            factor[j / SIDE * width][j % SIDE][j % SIDE] = 1.0;
        }
        wide(
            #[inline(always)]
            || {
                panels.add_gram(&mut factor, width);
                factor_band(&mut factor, width);
            },
        );
        let diagonal = factor.iter().step_by(width);
        let pivots = diagonal.flat_map(|tile| (0..SIDE).map(|k| tile[k][k]));
        let log_factor: f64 = pivots.map(f64::ln).sum();
        Self {
            blocks,
            width,
            factor,
            log_det: 2.0 * (log_factor - root.log_diagonal(nodes)),
        }
    }

    /// U'^-1 B for eight columns, in the place of B.
    pub(super) fn solve_transposed(&self, b: &mut [Tile]) {
        wide(
            #[inline(always)]
            || {
                for i in 0..self.blocks {
                    let (own, later) = self.row(i);
                    let (head, rest) = b[i..].split_at_mut(1);
                    tiles::solve_transposed(own, &mut head[0]);
                    for (b, u) in rest.iter_mut().zip(later) {
                        tiles::add_transposed_product::<false>(b, u, &head[0]);
                    }
                }
            },
        );
    }

    /// U^-1 B for eight columns, in the place of B.
    pub(super) fn solve(&self, b: &mut [Tile]) {
        wide(
            #[inline(always)]
            || {
                for i in (0..self.blocks).rev() {
                    let (own, later) = self.row(i);
                    let (head, rest) = b[i..].split_at_mut(1);
                    for (b, u) in rest.iter().zip(later) {
                        tiles::subtract_product(&mut head[0], u, b);
                    }
                    tiles::solve(own, &mut head[0]);
                }
            },
        );
    }

    /// The diagonal's tile and those beside it.
    #[inline(always)]
    fn row(&self, i: usize) -> (&Tile, &[Tile]) {
        let row = &self.factor[i * self.width..(i + 1) * self.width];
        (&row[0], &row[1..])
    }
}

/// Right-looking Cholesky of a band of tiles, in its place.
#[inline(always)]
fn factor_band(m: &mut [Tile], width: usize) {
    let blocks = m.len() / width;
    for i in 0..blocks {
        let (own, below) = m[i * width..].split_at_mut(width);
        let (diagonal, beside) = own.split_at_mut(1);
        tiles::root(&mut diagonal[0]);
        let beside = &mut beside[..(width - 1).min(blocks - 1 - i)];
        for tile in beside.iter_mut() {
            tiles::solve_transposed(&diagonal[0], tile);
        }
        for (a, left) in beside.iter().enumerate() {
            let row = below[a * width..].iter_mut();
            for (slot, right) in row.zip(&beside[a..]) {
                tiles::add_transposed_product::<false>(slot, left, right);
            }
        }
    }
}

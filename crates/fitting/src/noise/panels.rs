//! The nodes' whitened design in panels: samples that see nearly the same nodes, eight by eight.

use super::rows::Rows;
use super::tiles::{self, SIDE, Tile};
use super::vectors::wide;

/// Blocks of nodes that a panel may be wider than the longest row: few samples on a long plate see nodes far from one another's.
const SLACK: usize = 2;

/// Eight samples, or fewer, that see nearly the same nodes.
struct Panel {
    samples: [usize; SIDE],
    count: usize,
    /// Block of nodes that the first tile belongs to, and the panel's tiles.
    first: usize,
    tiles: std::ops::Range<usize>,
}

/// A matrix of samples x nodes, A, the samples in the order of the first nodes that they see: panels of eight of them are full where they
/// are not zero.
pub(super) struct Panels {
    panels: Vec<Panel>,
    tiles: Vec<Tile>,
    /// Blocks of eight nodes.
    pub(super) blocks: usize,
    /// Tiles of the widest panel.
    pub(super) width: usize,
}

impl Panels {
    pub(super) fn of(rows: &Rows, nodes: usize) -> Self {
        let blocks = nodes.div_ceil(SIDE);
        let order = by_first_node(&rows.first, nodes);
        let widest = order.iter().map(|&i| rows.blocks(i).len()).max();
        let most = widest.unwrap_or(0) + SLACK;
        let panels = order.len().div_ceil(SIDE);
        let mut all = Self {
            panels: Vec::with_capacity(panels),
            tiles: Vec::with_capacity(panels * most),
            blocks,
            width: 0,
        };
        let end = |i: usize| rows.first[i] / SIDE + rows.blocks(i).len();
        let mut order = &order[..];
        while let [i, ..] = order {
            let first = rows.first[*i] / SIDE;
            let near = order.iter().take(SIDE);
            let count = near.take_while(|&&i| end(i) <= first + most).count();
            let (group, later) = order.split_at(count);
            order = later;
            let width = group.iter().map(|&i| end(i)).max().unwrap_or(first) - first;
            let begun = all.tiles.len();
            all.tiles.resize(begun + width, [[0.0; SIDE]; SIDE]);
            let mut samples = [0; SIDE];
            for (k, &i) in group.iter().enumerate() {
                samples[k] = i;
                let own = &mut all.tiles[begun + rows.first[i] / SIDE - first..];
                for (tile, row) in own.iter_mut().zip(rows.blocks(i)) {
                    tile[k] = *row;
                }
            }
            all.panels.push(Panel {
                samples,
                count: group.len(),
                first,
                tiles: begun..begun + width,
            });
            all.width = all.width.max(width);
        }
        all
    }

    /// A'A, added to a band whose block row I holds the tiles I, I + 1, ... of as many columns of blocks as the widest panel has at least.
    #[inline(always)]
    pub(super) fn add_gram(&self, band: &mut [Tile], width: usize) {
        for panel in &self.panels {
            let own = &self.tiles[panel.tiles.clone()];
            for (a, left) in own.iter().enumerate() {
                let row = &mut band[(panel.first + a) * width..];
                for (slot, right) in row.iter_mut().zip(&own[a..]) {
                    tiles::add_transposed_product::<true>(slot, left, right);
                }
            }
        }
    }

    /// A'X for eight columns, block by block of nodes; `at` gives the columns at a sample.
    pub(super) fn transpose_times(&self, at: impl Fn(usize) -> [f64; SIDE]) -> Vec<Tile> {
        wide(
            #[inline(always)]
            || {
                let mut out = vec![[[0.0; SIDE]; SIDE]; self.blocks];
                for panel in &self.panels {
                    let mut x = [[0.0; SIDE]; SIDE];
                    for (x, &i) in x.iter_mut().zip(&panel.samples[..panel.count]) {
                        *x = at(i);
                    }
                    let own = &self.tiles[panel.tiles.clone()];
                    for (out, a) in out[panel.first..].iter_mut().zip(own) {
                        tiles::add_transposed_product::<true>(out, a, &x);
                    }
                }
                out
            },
        )
    }

    /// A'G for columns that are zero outside of their own samples, eight by eight: sample i holds `values[i]` of column `owner[i]`, of none where there are
    /// fewer. The same bits as [`Self::transpose_times`] with the zeros, at a fraction of its price.
    pub(super) fn transpose_times_owned(
        &self,
        columns: usize,
        owner: &[usize],
        values: &[f64],
    ) -> Vec<Vec<Tile>> {
        let mut out = vec![vec![[[0.0; SIDE]; SIDE]; self.blocks]; columns.div_ceil(SIDE)];
        wide(
            #[inline(always)]
            || {
                for panel in &self.panels {
                    let own = &self.tiles[panel.tiles.clone()];
                    for (k, &i) in panel.samples[..panel.count].iter().enumerate() {
                        let Some(&column) = owner.get(i).filter(|&&own| own < columns) else {
                            continue;
                        };
                        // A column's nodes lie side by side until all is summed up.
                        let (group, lane) = (column / SIDE, column % SIDE);
                        for (out, a) in out[group][panel.first..].iter_mut().zip(own) {
                            for l in 0..SIDE {
                                out[lane][l] = a[k][l].mul_add(values[i], out[lane][l]);
                            }
                        }
                    }
                }
            },
        );
        out.iter_mut().flatten().for_each(tiles::transpose);
        out
    }

    /// X - A Q in the place of X, for as many columns.
    pub(super) fn take_out(&self, nodes: &[Tile], columns: &mut [&mut [f64]]) {
        wide(
            #[inline(always)]
            || {
                for panel in &self.panels {
                    let samples = &panel.samples[..panel.count];
                    let mut x = [[0.0; SIDE]; SIDE];
                    for (x, &i) in x.iter_mut().zip(samples) {
                        for (x, column) in x.iter_mut().zip(columns.iter()) {
                            *x = column[i];
                        }
                    }
                    let own = &self.tiles[panel.tiles.clone()];
                    for (q, a) in nodes[panel.first..].iter().zip(own) {
                        tiles::subtract_product(&mut x, a, q);
                    }
                    for (x, &i) in x.iter().zip(samples) {
                        for (x, column) in x.iter().zip(columns.iter_mut()) {
                            column[i] = *x;
                        }
                    }
                }
            },
        );
    }
}

/// The rows in the order of their first nodes, those of one node as they were.
fn by_first_node(first: &[usize], nodes: usize) -> Vec<usize> {
    let mut begins = vec![0; nodes + 1];
    first.iter().for_each(|&j| begins[j + 1] += 1);
    for j in 0..nodes {
        begins[j + 1] += begins[j];
    }
    let mut order = vec![0; first.len()];
    for (i, &j) in first.iter().enumerate() {
        order[begins[j]] = i;
        begins[j] += 1;
    }
    order
}

//! What each whitened sample sees of the plate's nodes: the nodes' design, sent through the filter along each run.

use std::ops::Range;

use super::along::{Along, Coloured, Driver, Wander};
use super::channel::MOST_STATES;
use super::context::{Context, Sizes};
use super::grid::{Grid, Seen, Sight};
use super::tiles::SIDE;
use super::vectors::wide;

/// Entries of a row below this (relative to one) are dropped.
const FORGOTTEN: f64 = 1e-5;
/// Blocks of nodes that most rows have at most: room for them is made at once.
const BLOCKS: usize = 8;
/// Never longer rows than this.
const LONGEST_ROW: usize = 96;

/// Rows of the whitened design of the nodes: row i is the response of innovation i to the nodes.
pub(super) struct Rows {
    /// First node of each row, and how many there are from it on.
    pub(super) first: Vec<usize>,
    count: Vec<usize>,
    /// Where the blocks of nodes of each row begin.
    offset: Vec<usize>,
    /// Block by block of nodes, zero beyond the row's ends.
    values: Vec<[f64; SIDE]>,
    /// Longest row.
    pub(super) width: usize,
}

impl Rows {
    /// Sends the nodes' design through the filter along each run.
    pub(super) fn new(context: &Context, sizes: &Sizes, grid: &Grid, along: &Along) -> Self {
        wide(
            #[inline(always)]
            || match along.states {
                0 => Self::of::<0>(context, sizes, grid, along),
                1 => Self::of::<1>(context, sizes, grid, along),
                _ => Self::of::<MOST_STATES>(context, sizes, grid, along),
            },
        )
    }

    #[inline(always)]
    fn of<const N: usize>(context: &Context, sizes: &Sizes, grid: &Grid, along: &Along) -> Self {
        match (along.is_smooth(), along.wanders()) {
            (false, false) => Self::sent::<N, false, false>(context, sizes, grid, along),
            (true, false) => Self::sent::<N, true, false>(context, sizes, grid, along),
            (false, true) => Self::sent::<N, false, true>(context, sizes, grid, along),
            (true, true) => Self::sent::<N, true, true>(context, sizes, grid, along),
        }
    }

    #[inline(always)]
    fn sent<const N: usize, const SMOOTH: bool, const WANDERS: bool>(
        context: &Context,
        sizes: &Sizes,
        grid: &Grid,
        along: &Along,
    ) -> Self {
        let n = context.samples();
        let mut rows = Self {
            first: Vec::with_capacity(n),
            count: Vec::with_capacity(n),
            offset: Vec::with_capacity(n + 1),
            values: Vec::with_capacity(n * BLOCKS),
            width: 0,
        };
        rows.offset.push(0);
        // The filter's state as a function of the nodes within `span`.
        let mut state = vec![Sent::<N>::NOTHING; grid.nodes.div_ceil(SIDE)];
        let sight = Sight::new(grid, sizes.plate_length());
        let mut seen = Seen::default();
        for run in &context.runs {
            let mut span = 0..0;
            for i in run.clone() {
                sight.of(context, i, &mut seen);
                let step = Step::at(context, along, i);
                for sent in &mut state[blocks(&span)] {
                    sent.advance::<SMOOTH, WANDERS>(&step);
                }
                forget(&mut state, &mut span, step.force);
                let own = seen.first..seen.first + seen.weights.len();
                span = match span.start < span.end {
                    true => span.start.min(own.start)..span.end.max(own.end),
                    false => own.clone(),
                };
                shorten(&mut state, &mut span, &own);
                let begun = rows.values.len();
                let seen_from = blocks(&span);
                rows.values.resize(begun + seen_from.len(), [0.0; SIDE]);
                let row = &mut rows.values[begun..];
                for j in own.start.max(span.start)..own.end.min(span.end) {
                    let weight = seen.weights[j - own.start];
                    row[j / SIDE - seen_from.start][j % SIDE] = step.force * weight;
                }
                for (sent, row) in state[seen_from].iter_mut().zip(row) {
                    sent.observe::<SMOOTH, WANDERS>(&step, row);
                }
                rows.first.push(span.start);
                rows.count.push(span.len());
                rows.offset.push(rows.values.len());
                rows.width = rows.width.max(span.len());
            }
            state[blocks(&span)].fill(Sent::NOTHING);
        }
        rows
    }

    /// Entries of row i, from node `first[i]` on.
    pub(super) fn row(&self, i: usize) -> &[f64] {
        let own = self.blocks(i).as_flattened();
        &own[self.first[i] % SIDE..][..self.count[i]]
    }

    /// The same in whole blocks of nodes.
    pub(super) fn blocks(&self, i: usize) -> &[[f64; SIDE]] {
        &self.values[self.offset[i]..self.offset[i + 1]]
    }
}

/// The blocks in which nodes lie.
fn blocks(nodes: &Range<usize>) -> Range<usize> {
    nodes.start / SIDE..nodes.end.div_ceil(SIDE)
}

/// What the filter along the runs does at one sample.
struct Step {
    /// The force that roughness multiplies, and the same where the sample is a mean of several.
    force: f64,
    scale: f64,
    decay: [f64; 2],
    gain: [f64; 2],
    driver: Driver,
    wander: Wander,
    coloured: Coloured,
    inverse_sd: f64,
}

impl Step {
    fn at(context: &Context, along: &Along, i: usize) -> Self {
        Self {
            force: context.scale[i],
            scale: along.scale[i],
            decay: along.decay[i],
            gain: along.gain[i],
            driver: along.driver(i),
            wander: along.wander(i),
            coloured: along.coloured(i),
            inverse_sd: along.inverse_sd[i],
        }
    }
}

/// The state of the filter along a run as a function of eight nodes: private roughness, field between the nodes, driver, wander, white noise
/// and the states of its colour. All of it is zero beyond the nodes that are remembered.
#[derive(Clone, Copy)]
struct Sent<const N: usize> {
    u: [f64; SIDE],
    w: [f64; SIDE],
    v: [f64; SIDE],
    a: [f64; SIDE],
    e: [f64; SIDE],
    noise: [[f64; SIDE]; N],
}

impl<const N: usize> Sent<N> {
    const NOTHING: Self = Self {
        u: [0.0; SIDE],
        w: [0.0; SIDE],
        v: [0.0; SIDE],
        a: [0.0; SIDE],
        e: [0.0; SIDE],
        noise: [[0.0; SIDE]; N],
    };

    /// To the next sample.
    #[inline(always)]
    fn advance<const SMOOTH: bool, const WANDERS: bool>(&mut self, step: &Step) {
        for l in 0..SIDE {
            self.u[l] *= step.decay[0];
            self.w[l] *= step.decay[1];
            if SMOOTH {
                self.u[l] += step.driver.feed * self.v[l];
                self.v[l] *= step.driver.decay;
            }
            if WANDERS {
                self.a[l] *= step.wander.decay;
            }
            let mut states: [f64; N] = std::array::from_fn(|k| self.noise[k][l]);
            step.coloured.advance(&mut states, self.e[l]);
            (0..N).for_each(|k| self.noise[k][l] = states[k]);
        }
    }

    /// Innovations: `row` holds what the sample sees of the nodes itself, and then what it shows of them, in standard deviations.
    #[inline(always)]
    fn observe<const SMOOTH: bool, const WANDERS: bool>(
        &mut self,
        step: &Step,
        row: &mut [f64; SIDE],
    ) {
        for l in 0..SIDE {
            let mut innovation = row[l] - step.scale * (self.u[l] + self.w[l]);
            if WANDERS {
                innovation -= self.a[l];
            }
            if let Some(first) = self.noise.first() {
                innovation -= first[l];
                let mut states: [f64; N] = std::array::from_fn(|k| self.noise[k][l]);
                self.e[l] = step.coloured.update(&mut states, innovation);
                (0..N).for_each(|k| self.noise[k][l] = states[k]);
            }
            self.u[l] += step.gain[0] * innovation;
            self.w[l] += step.gain[1] * innovation;
            if WANDERS {
                self.a[l] += step.wander.gain * innovation;
            }
            if SMOOTH {
                self.v[l] += step.driver.gain * innovation;
            }
            row[l] = innovation * step.inverse_sd;
        }
    }

    /// Whether nothing is left of a node where the force is f. (e is in the noise's states by then.)
    fn is_forgotten(&self, l: usize, f: f64) -> bool {
        let noise = self.noise.iter().chain([&self.a]).map(|state| state[l]);
        let noise = noise.filter(|s| *s != 0.0).map(|s| (s / f).abs());
        self.u[l].abs() + self.w[l].abs() + self.v[l].abs() + noise.sum::<f64>() < FORGOTTEN
    }

    fn clear(&mut self, l: usize) {
        let own = [
            &mut self.u,
            &mut self.w,
            &mut self.v,
            &mut self.a,
            &mut self.e,
        ];
        for state in own.into_iter().chain(&mut self.noise) {
            state[l] = 0.0;
        }
    }
}

/// Leaves nodes of which nothing is left.
fn forget<const N: usize>(state: &mut [Sent<N>], span: &mut Range<usize>, f: f64) {
    let forgotten = |state: &[Sent<N>], j: usize| state[j / SIDE].is_forgotten(j % SIDE, f);
    while span.start < span.end && forgotten(state, span.start) {
        leave_first(state, span);
    }
    while span.start < span.end && forgotten(state, span.end - 1) {
        leave_last(state, span);
    }
}

/// Leaves nodes far from the sample's `own` where a row would be too long.
fn shorten<const N: usize>(state: &mut [Sent<N>], span: &mut Range<usize>, own: &Range<usize>) {
    while span.len() > LONGEST_ROW {
        let below = own.start as isize - span.start as isize;
        let above = span.end as isize - own.end as isize;
        if below > above {
            leave_first(state, span);
        } else {
            leave_last(state, span);
        }
    }
}

fn leave_first<const N: usize>(state: &mut [Sent<N>], span: &mut Range<usize>) {
    state[span.start / SIDE].clear(span.start % SIDE);
    span.start += 1;
}

fn leave_last<const N: usize>(state: &mut [Sent<N>], span: &mut Range<usize>) {
    span.end -= 1;
    state[span.end / SIDE].clear(span.end % SIDE);
}

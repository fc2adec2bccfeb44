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

use super::context::{Context, Sizes};
use super::roughness::Roughness;

/// Never more nodes than this; a finer plate is then resolved only coarsely.
const MOST_NODES: usize = 4000;

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

/// What places see of the nodes about them.
pub(super) struct Sight<'a> {
    grid: &'a Grid,
    length: f64,
    /// exp(h/l) and 2 sinh(h/l).
    growth: f64,
    whole: f64,
}

impl<'a> Sight<'a> {
    /// Of a field with this correlation length.
    pub(super) fn new(grid: &'a Grid, length: f64) -> Self {
        let growth = (grid.spacing / length).exp();
        Self {
            grid,
            length,
            growth,
            whole: growth - growth.recip(),
        }
    }

    /// Left node, its weight and the right node's weight, sinh(b/l)/sinh(h/l) and sinh(a/l)/sinh(h/l).
    fn weights(&self, place: f64) -> (usize, f64, f64) {
        let Grid {
            origin,
            spacing,
            nodes,
        } = *self.grid;
        let t = (place - origin) / spacing;
        let j = (t.floor().max(0.0) as usize).min(nodes - 2);
        let a = (place - origin - j as f64 * spacing).clamp(0.0, spacing);
        let near = (a / self.length).exp();
        let far = self.growth / near;
        let twice_sinh = |e: f64| e - e.recip();
        let (left, right) = (twice_sinh(far), twice_sinh(near));
        (j, left / self.whole, right / self.whole)
    }

    /// The nodes that sample i of a context sees; the mean over its places where it is the mean of several.
    pub(super) fn of(&self, context: &Context, i: usize, seen: &mut Seen) {
        let row = context.rows.get(i);
        let (count, step) = row.map_or((1, 0.0), |r| (r.samples as usize, r.step));
        let count = count.max(1);
        let from = context.place[i] - 0.5 * step * (count - 1) as f64;
        seen.weights.clear();
        for k in 0..count {
            let (node, left, right) = self.weights(from + step * k as f64);
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
}

/// What one sample sees of the nodes, from node `first` on.
#[derive(Default)]
pub(super) struct Seen {
    pub(super) first: usize,
    pub(super) weights: Vec<f64>,
}

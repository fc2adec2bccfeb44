//! The sweeps over a recorded block: Jacobian rows, and the Hessian of a
//! weighted sum of rows.
//!
//! ```text
//! adjoints     w̄_a += w̄ ∂φ/∂a,  w̄_b += w̄ ∂φ/∂b                       backward
//! tangents     ẇ = ∂φ/∂a ȧ + ∂φ/∂b ḃ                                  forward
//! curvature    dw̄_a += dw̄ ∂φ/∂a + w̄ (∂²φ/∂a² ȧ + ∂²φ/∂a∂b ḃ), …       backward
//! ```
//!
//! Several rows or directions are swept side by side, `LANES` at a time.
//! Derivatives come out with respect to the scaled variables: `seeds` are the
//! variables' scales.

use super::{CONSTANT, Node, Var, record, recycle};
use crate::Programme;

/// Rows or directions swept side by side.
const LANES: usize = 8;

type Lanes = [f64; LANES];

/// Value and first derivatives of a block.
#[derive(Default)]
pub(crate) struct BlockFirst {
    /// Cost share.
    pub cost: f64,
    /// Gradient of the cost share.
    pub gradient: Vec<f64>,
    /// Row values.
    pub rows: Vec<f64>,
    /// Row-major Jacobian.
    pub jacobian: Vec<f64>,
}

/// Memory of the sweeps, reused from block to block.
#[derive(Default)]
pub(crate) struct Sweeper {
    inputs: Vec<Var>,
    outputs: Vec<Var>,
    adjoint: Vec<f64>,
    lanes: Vec<Lanes>,
    tangent: Vec<Lanes>,
    reaches: Vec<u64>,
}

impl Sweeper {
    /// Records a block at the physical point `x`; the outputs are the rows, then the cost.
    fn record<P: Programme>(
        &mut self,
        programme: &P,
        block: usize,
        x: &[f64],
        rows: usize,
    ) -> Vec<Node> {
        self.outputs.clear();
        self.outputs.resize(rows, Var::constant(0.0));
        let outputs = &mut self.outputs;
        let mut cost = Var::constant(0.0);
        let tape = record(x, &mut self.inputs, |inputs| {
            programme.evaluate(block, inputs, &mut cost, outputs)
        });
        self.outputs.push(cost);
        tape
    }

    /// Values and first derivatives of one block.
    pub(crate) fn first<P: Programme>(
        &mut self,
        programme: &P,
        block: usize,
        x: &[f64],
        seeds: &[f64],
        rows: usize,
        out: &mut BlockFirst,
    ) {
        let n = x.len();
        let tape = self.record(programme, block, x, rows);
        out.rows.clear();
        out.rows
            .extend(self.outputs[..rows].iter().map(|v| v.value));
        out.cost = self.outputs[rows].value;
        out.gradient.clear();
        out.gradient.resize(n, 0.0);
        out.jacobian.clear();
        out.jacobian.resize(rows * n, 0.0);
        for first in (0..=rows).step_by(LANES) {
            let count = LANES.min(rows + 1 - first);
            self.lanes.clear();
            self.lanes.resize(tape.len(), [0.0; LANES]);
            for lane in 0..count {
                let output = self.outputs[first + lane];
                if output.index != CONSTANT {
                    self.lanes[output.index as usize][lane] = 1.0;
                }
            }
            for k in (n..tape.len()).rev() {
                let node = &tape[k];
                let adjoint = self.lanes[k];
                add(&mut self.lanes[node.a as usize], node.da, &adjoint);
                if node.b != CONSTANT {
                    add(&mut self.lanes[node.b as usize], node.db, &adjoint);
                }
            }
            for lane in 0..count {
                let row = first + lane;
                let target = if row == rows {
                    &mut out.gradient[..]
                } else {
                    &mut out.jacobian[row * n..(row + 1) * n]
                };
                for (j, value) in target.iter_mut().enumerate() {
                    *value = self.lanes[j][lane] * seeds[j];
                }
            }
        }
        recycle(tape);
    }

    /// Adds the Hessian of `weight·cost + Σ weights[r]·rows[r]` to `hessian` (row-major, both triangles).
    #[allow(clippy::too_many_arguments)]
    pub(crate) fn second<P: Programme>(
        &mut self,
        programme: &P,
        block: usize,
        x: &[f64],
        seeds: &[f64],
        weight: f64,
        weights: &[f64],
        hessian: &mut [f64],
    ) {
        let n = x.len();
        let tape = self.record(programme, block, x, weights.len());
        self.adjoint.clear();
        self.adjoint.resize(tape.len(), 0.0);
        for (output, w) in self
            .outputs
            .iter()
            .zip(weights.iter().chain(std::iter::once(&weight)))
        {
            if output.index != CONSTANT {
                self.adjoint[output.index as usize] += w;
            }
        }
        for k in (n..tape.len()).rev() {
            let (node, adjoint) = (&tape[k], self.adjoint[k]);
            self.adjoint[node.a as usize] += adjoint * node.da;
            if node.b != CONSTANT {
                self.adjoint[node.b as usize] += adjoint * node.db;
            }
        }
        let directions = self.curved_inputs(&tape, n);
        for chunk in directions.chunks(LANES) {
            self.sweep_directions(&tape, n, chunk);
            for (lane, &i) in chunk.iter().enumerate() {
                for &j in &directions {
                    hessian[i * n + j] += self.lanes[j][lane] * seeds[i] * seeds[j];
                }
            }
        }
        recycle(tape);
    }

    /// Second-order sweep for up to `LANES` directions; the answer is in the inputs' lanes.
    fn sweep_directions(&mut self, tape: &[Node], n: usize, directions: &[usize]) {
        self.tangent.clear();
        self.tangent.resize(tape.len(), [0.0; LANES]);
        for (lane, &input) in directions.iter().enumerate() {
            self.tangent[input][lane] = 1.0;
        }
        for k in n..tape.len() {
            let node = &tape[k];
            let mut tangent = [0.0; LANES];
            add(&mut tangent, node.da, &self.tangent[node.a as usize]);
            if node.b != CONSTANT {
                add(&mut tangent, node.db, &self.tangent[node.b as usize]);
            }
            self.tangent[k] = tangent;
        }
        self.lanes.clear();
        self.lanes.resize(tape.len(), [0.0; LANES]);
        for k in (n..tape.len()).rev() {
            let node = &tape[k];
            let (bent, adjoint) = (self.lanes[k], self.adjoint[k]);
            let a = node.a as usize;
            add(&mut self.lanes[a], node.da, &bent);
            if node.b == CONSTANT {
                if node.curved {
                    add(&mut self.lanes[a], adjoint * node.daa, &self.tangent[a]);
                }
                continue;
            }
            let b = node.b as usize;
            add(&mut self.lanes[b], node.db, &bent);
            if node.curved {
                let (ta, tb) = (self.tangent[a], self.tangent[b]);
                add(&mut self.lanes[a], adjoint * node.daa, &ta);
                add(&mut self.lanes[a], adjoint * node.dab, &tb);
                add(&mut self.lanes[b], adjoint * node.dab, &ta);
                add(&mut self.lanes[b], adjoint * node.dbb, &tb);
            }
        }
    }

    /// Inputs that enter some operation with curvature; the others have no second derivatives.
    fn curved_inputs(&mut self, tape: &[Node], n: usize) -> Vec<usize> {
        if n > 64 {
            return (0..n).collect();
        }
        let mut curved = 0_u64;
        self.reaches.clear();
        self.reaches.extend((0..n).map(|k| 1_u64 << k));
        for node in &tape[n..] {
            let mut reach = self.reaches[node.a as usize];
            if node.b != CONSTANT {
                reach |= self.reaches[node.b as usize];
            }
            if node.curved {
                curved |= reach;
            }
            self.reaches.push(reach);
        }
        (0..n).filter(|k| curved >> k & 1 == 1).collect()
    }
}

/// `target += factor · source`, lane by lane.
#[inline(always)]
fn add(target: &mut Lanes, factor: f64, source: &Lanes) {
    for lane in 0..LANES {
        target[lane] += factor * source[lane];
    }
}

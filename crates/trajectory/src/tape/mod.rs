//! Reverse-mode derivatives of a block: a function is recorded once as it runs.
//!
//! A block has many variables and a few rows, and what the solver needs of its
//! second derivatives is one weighted sum. Carrying full Hessians through every
//! operation costs O(n²) per operation; recording the operations and sweeping
//! back costs O(1) per operation and row for first derivatives and O(n) for the
//! Hessian of the sum. The recorded number [`Var`] implements the same trait as
//! the dual numbers of `num-dual`, so user functions do not know the difference;
//! tests compare the two.
//!
//! Every recorded operation `w = φ(a, b)` keeps its first and second partial
//! derivatives. (Griewank and Walther, Evaluating Derivatives, 2nd edition,
//! sections 3.2 and 5.)

mod arithmetic;
mod functions;
mod sweeps;
#[cfg(test)]
mod tests;

pub(crate) use sweeps::{BlockFirst, Sweeper};

use std::cell::RefCell;

/// Index of a number that does not depend on the inputs.
const CONSTANT: u32 = u32::MAX;

/// One recorded operation `w = φ(a, b)`; `b` is [`CONSTANT`] for one operand.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Node {
    a: u32,
    b: u32,
    /// ∂φ/∂a, ∂φ/∂b.
    da: f64,
    db: f64,
    /// ∂²φ/∂a², ∂²φ/∂a∂b, ∂²φ/∂b².
    daa: f64,
    dab: f64,
    dbb: f64,
    /// Some second derivative may be non-zero.
    curved: bool,
}

thread_local! {
    static TAPE: RefCell<Vec<Node>> = const { RefCell::new(Vec::new()) };
}

/// A number whose operations are recorded on the thread's tape.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Var {
    value: f64,
    index: u32,
}

impl Var {
    pub(crate) fn constant(value: f64) -> Self {
        Self {
            value,
            index: CONSTANT,
        }
    }

    /// `φ(x)` with its derivatives.
    fn unary(self, value: f64, d: f64, dd: f64) -> Self {
        if self.index == CONSTANT {
            return Self::constant(value);
        }
        let node = Node {
            a: self.index,
            b: CONSTANT,
            da: d,
            db: 0.0,
            daa: dd,
            dab: 0.0,
            dbb: 0.0,
            curved: dd != 0.0,
        };
        Self {
            value,
            index: push(node),
        }
    }

    /// `φ(x, y)` with its gradient and Hessian `[xx, xy, yy]`.
    fn binary(self, other: Self, value: f64, d: [f64; 2], dd: [f64; 3]) -> Self {
        if other.index == CONSTANT {
            return self.unary(value, d[0], dd[0]);
        }
        if self.index == CONSTANT {
            return other.unary(value, d[1], dd[2]);
        }
        let node = Node {
            a: self.index,
            b: other.index,
            da: d[0],
            db: d[1],
            daa: dd[0],
            dab: dd[1],
            dbb: dd[2],
            curved: dd != [0.0; 3],
        };
        Self {
            value,
            index: push(node),
        }
    }
}

fn push(node: Node) -> u32 {
    TAPE.with_borrow_mut(|tape| {
        let index = tape.len();
        assert!(
            index < CONSTANT as usize,
            "a block records more operations than an index can count"
        );
        tape.push(node);
        index as u32
    })
}

/// Runs `f` on recorded inputs and returns the tape; the first `x.len()` nodes are the inputs.
fn record(x: &[f64], inputs: &mut Vec<Var>, f: impl FnOnce(&[Var])) -> Vec<Node> {
    TAPE.with_borrow_mut(|tape| {
        tape.clear();
        let input = Node {
            a: CONSTANT,
            b: CONSTANT,
            da: 0.0,
            db: 0.0,
            daa: 0.0,
            dab: 0.0,
            dbb: 0.0,
            curved: false,
        };
        tape.resize(x.len(), input);
    });
    inputs.clear();
    inputs.extend(x.iter().enumerate().map(|(k, &value)| Var {
        value,
        index: k as u32,
    }));
    f(inputs);
    TAPE.take()
}

/// Gives a tape back, so that its memory serves the next recording.
fn recycle(tape: Vec<Node>) {
    TAPE.set(tape);
}

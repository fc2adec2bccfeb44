//! Small problems that are there for one difficulty each.

use trajectory::{Block, Programme, Row, Scalar, Variable};

fn variables(n: usize) -> Vec<Variable> {
    (1..=n)
        .map(|k| Variable::free(format!("x{k}"), 1.0))
        .collect()
}

/// Maratos' effect: every full step from the circle raises both cost and violation.
///
/// min 2(x₁² + x₂² − 1) − x₁ on the unit circle; minimum −1 at (1, 0). N. Maratos,
/// thesis, Imperial College 1978; as example 15.4 of Nocedal and Wright.
pub struct Maratos;

impl Programme for Maratos {
    fn variables(&self) -> Vec<Variable> {
        variables(2)
    }

    fn blocks(&self) -> Vec<Block> {
        vec![Block::new("circle", vec![0, 1], vec![Row::equal(1.0)])]
    }

    fn evaluate<D: Scalar>(&self, _: usize, x: &[D], f: &mut D, c: &mut [D]) {
        c[0] = x[0] * x[0] + x[1] * x[1] - 1.0;
        *f = c[0] * 2.0 - x[0];
    }
}

/// Linearised rows and bounds that contradict each other at the start, though
/// the problem itself is harmless: min x₁, x₁² − x₂ − 1 = 0, x₁ − x₃ − 2 = 0,
/// x₂, x₃ ≥ 0; minimum 2 at (2, 3, 0). A. Wächter and L. Biegler, Failure of global
/// convergence for a class of interior point methods, Mathematical Programming 88, 2000.
pub struct ContradictingLinearisation;

impl Programme for ContradictingLinearisation {
    fn variables(&self) -> Vec<Variable> {
        let positive = |name: &str| Variable::new(name, 0.0, f64::INFINITY, 1.0);
        vec![Variable::free("x1", 1.0), positive("x2"), positive("x3")]
    }

    fn blocks(&self) -> Vec<Block> {
        vec![Block::new("rows", vec![0, 1, 2], vec![Row::equal(1.0); 2])]
    }

    fn evaluate<D: Scalar>(&self, _: usize, x: &[D], f: &mut D, c: &mut [D]) {
        *f = x[0];
        c[0] = x[0] * x[0] - x[1] - 1.0;
        c[1] = x[0] - x[2] - 2.0;
    }
}

/// Rows that no point meets: x₁² + x₂² = 1 and x₁ = 3. The violation has a
/// minimum at (3, 0) or nearby, and the status must say so.
pub struct Impossible;

impl Programme for Impossible {
    fn variables(&self) -> Vec<Variable> {
        variables(2)
    }

    fn blocks(&self) -> Vec<Block> {
        vec![Block::new("rows", vec![0, 1], vec![Row::equal(1.0); 2])]
    }

    fn evaluate<D: Scalar>(&self, _: usize, x: &[D], f: &mut D, c: &mut [D]) {
        *f = x[1];
        c[0] = x[0] * x[0] + x[1] * x[1] - 1.0;
        c[1] = x[0] - 3.0;
    }
}

/// A saddle: min x₁² − x₂² has a stationary point at 0 that is no minimum.
/// With x₂ in bounds the minima sit on the bounds.
pub struct Saddle {
    pub bounded: bool,
}

impl Programme for Saddle {
    fn variables(&self) -> Vec<Variable> {
        let limit = if self.bounded { 2.0 } else { f64::INFINITY };
        vec![
            Variable::free("x1", 1.0),
            Variable::new("x2", -limit, limit, 1.0),
        ]
    }

    fn blocks(&self) -> Vec<Block> {
        vec![Block::new("saddle", vec![0, 1], vec![])]
    }

    fn evaluate<D: Scalar>(&self, _: usize, x: &[D], f: &mut D, _: &mut [D]) {
        *f = x[0] * x[0] - x[1] * x[1];
    }
}

/// One row written twice: the minimum is the same, the gradients are dependent.
pub struct DoubledRow;

impl Programme for DoubledRow {
    fn variables(&self) -> Vec<Variable> {
        variables(2)
    }

    fn blocks(&self) -> Vec<Block> {
        vec![Block::new("rows", vec![0, 1], vec![Row::equal(1.0); 2])]
    }

    fn evaluate<D: Scalar>(&self, _: usize, x: &[D], f: &mut D, c: &mut [D]) {
        *f = x[0] * x[0] + x[1] * x[1];
        c[0] = x[0] + x[1] - 1.0;
        c[1] = (x[0] + x[1] - 1.0) * 2.0;
    }
}

/// ln x₁ + x₂² started where the logarithm has no value.
pub struct OutsideDomain;

impl Programme for OutsideDomain {
    fn variables(&self) -> Vec<Variable> {
        variables(2)
    }

    fn blocks(&self) -> Vec<Block> {
        vec![Block::new("logarithm", vec![0, 1], vec![])]
    }

    fn evaluate<D: Scalar>(&self, _: usize, x: &[D], f: &mut D, _: &mut [D]) {
        *f = x[0].ln() + x[1] * x[1];
    }
}

/// A long flat valley between steep rows: min ½ κ Σ (xₖ − k)² over four variables with
/// 300 (x₁ + x₂) = 300 and 300 (x₃ − x₄) = 300; minimum at (0, 1, 4, 3), reduced Hessian κ I.
pub struct FlatValley {
    pub curvature: f64,
}

impl Programme for FlatValley {
    fn variables(&self) -> Vec<Variable> {
        variables(4)
    }

    fn blocks(&self) -> Vec<Block> {
        vec![Block::new(
            "valley",
            vec![0, 1, 2, 3],
            vec![Row::equal(1.0); 2],
        )]
    }

    fn evaluate<D: Scalar>(&self, _: usize, x: &[D], f: &mut D, c: &mut [D]) {
        for (k, &x) in x.iter().enumerate() {
            let miss = x - (k + 1) as f64;
            *f += miss * miss * (0.5 * self.curvature);
        }
        c[0] = (x[0] + x[1] - 1.0) * 300.0;
        c[1] = (x[2] - x[3] - 1.0) * 300.0;
    }
}

/// A limit that has to be left beside one with a multiplier of thousands: min 5000 x₁ + (x₂ − 2·10⁻⁶)²/2, x₁ ≥ 0 as a row, x₂ ≥ 0;
/// minimum at (0, 2·10⁻⁶). At x₂ = 0 the multiplier of the wrong sign is 2·10⁻⁶.
pub struct LightLimit;

impl LightLimit {
    /// Where x₂ has its minimum.
    pub const LIGHT: f64 = 2e-6;
    /// Slope of the cost along x₁.
    pub const HEAVY: f64 = 5e3;
}

impl Programme for LightLimit {
    fn variables(&self) -> Vec<Variable> {
        let positive = Variable::new("x2", 0.0, f64::INFINITY, 1.0);
        vec![Variable::free("x1", 1.0), positive]
    }

    fn blocks(&self) -> Vec<Block> {
        let above = Row::between(0.0, f64::INFINITY, 1.0);
        vec![Block::new("heavy", vec![0, 1], vec![above])]
    }

    fn evaluate<D: Scalar>(&self, _: usize, x: &[D], f: &mut D, c: &mut [D]) {
        let off = x[1] - Self::LIGHT;
        *f = x[0] * Self::HEAVY + off * off * 0.5;
        c[0] = x[0];
    }
}

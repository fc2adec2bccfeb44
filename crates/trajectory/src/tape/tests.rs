//! Recorded derivatives against dual numbers, function by function, and
//! against differences of lower derivatives by Taylor ratios.

use super::{BlockFirst, Sweeper};
use crate::{Block, Programme, Row, Scalar, Variable};
use nalgebra::DVector;
use num_dual::{Dual2DVec64, DualNum};

const FUNCTIONS: usize = 27;

/// Every function of the trait, each of a positive argument below one.
fn function<D: DualNum<Primitive = f64> + Clone>(k: usize, x: D, y: D) -> D {
    match k {
        0 => x.recip() * y,
        1 => x.powi(3) - y.powi(-2),
        2 => x.powf(1.7) * y.powf(-0.3),
        3 => (x * y).sqrt(),
        4 => x.cbrt() + y,
        5 => (x * y).exp(),
        6 => x.exp2() * y.exp_m1(),
        7 => x.ln() * y.log(3.0),
        8 => x.log2() / y.log10(),
        9 => (x * y).ln_1p(),
        10 => x.sin() * y.cos(),
        11 => (x * y).tan(),
        12 => (x.sin_cos().0 + y.sin_cos().1).powi(2),
        13 => x.asin() * y.acos(),
        14 => (x / y).atan(),
        15 => x.atan2(y),
        16 => x.sinh() * y.cosh(),
        17 => (x + y).tanh(),
        18 => (x * y).asinh(),
        19 => (x + y + 1.0).acosh(),
        20 => (x * y).atanh(),
        21 => x.sph_j0() + y.sph_j1(),
        22 => (x + y).sph_j2(),
        23 => (x - y).abs() * 2.0,
        24 => -(x / y) * 3.0 - 1.0,
        25 => x.mul_add(y.clone(), y) / 7.0,
        _ => x.powd(y),
    }
}

struct Everything;

impl Programme for Everything {
    fn variables(&self) -> Vec<Variable> {
        vec![Variable::free("x", 1.0), Variable::free("y", 1.0)]
    }

    fn blocks(&self) -> Vec<Block> {
        vec![Block::new(
            "all",
            vec![0, 1],
            vec![Row::equal(1.0); FUNCTIONS],
        )]
    }

    fn evaluate<D: Scalar>(&self, _: usize, x: &[D], cost: &mut D, rows: &mut [D]) {
        for (k, row) in rows.iter_mut().enumerate() {
            *row = function(k, x[0], x[1]);
        }
        *cost = x.iter().copied().sum::<D>() * [x[0], x[1]].into_iter().product::<D>();
    }
}

#[test]
fn every_function_agrees_with_dual_numbers() {
    let (x, y) = (0.37, 0.61);
    let mut sweeper = Sweeper::default();
    let mut first = BlockFirst::default();
    sweeper.first(&Everything, 0, &[x, y], &[1.0, 1.0], FUNCTIONS, &mut first);
    for k in 0..FUNCTIONS {
        let (value, gradient, hessian) = num_dual::hessian(
            |v: DVector<Dual2DVec64>| function(k, v[0].clone(), v[1].clone()),
            &DVector::from_vec(vec![x, y]),
        );
        let close = |a: f64, b: f64| (a - b).abs() <= 1e-12 * (1.0 + b.abs());
        assert!(
            close(first.rows[k], value),
            "value of function {k}: {} and {value}",
            first.rows[k]
        );
        for j in 0..2 {
            assert!(
                close(first.jacobian[2 * k + j], gradient[j]),
                "gradient of function {k}"
            );
        }
        let mut weights = vec![0.0; FUNCTIONS];
        weights[k] = 1.0;
        let mut dense = vec![0.0; 4];
        sweeper.second(
            &Everything,
            0,
            &[x, y],
            &[1.0, 1.0],
            0.0,
            &weights,
            &mut dense,
        );
        for (a, b) in dense.iter().zip(hessian.iter()) {
            assert!(close(*a, *b), "Hessian of function {k}: {a} and {b}");
        }
    }
}

/// f(x + εp) − f(x) − ε∇fᵀp − ½ε²pᵀHp falls by the third power of ε.
#[test]
fn taylor_remainders_fall_with_the_third_power() {
    let (x, p) = ([0.41, 0.57], [0.3, -0.2]);
    let seeds = [2.0, 0.5];
    let mut sweeper = Sweeper::default();
    let mut first = BlockFirst::default();
    sweeper.first(&Everything, 0, &x, &seeds, FUNCTIONS, &mut first);
    let mut weights = vec![1.0; FUNCTIONS];
    weights[23] = 0.0; // |x − y| has a kink
    let mut hessian = vec![0.0; 4];
    sweeper.second(&Everything, 0, &x, &seeds, 1.0, &weights, &mut hessian);
    let value = |at: [f64; 2]| {
        let mut rows = vec![0.0; FUNCTIONS];
        let mut cost = 0.0;
        Everything.evaluate(0, &at, &mut cost, &mut rows);
        cost + rows.iter().zip(&weights).map(|(r, w)| r * w).sum::<f64>()
    };
    let slope: f64 = (0..2)
        .map(|j| {
            let rows: f64 = weights
                .iter()
                .enumerate()
                .map(|(k, w)| w * first.jacobian[2 * k + j])
                .sum();
            (rows + first.gradient[j]) * p[j]
        })
        .sum();
    let bend: f64 = (0..4).map(|k| hessian[k] * p[k / 2] * p[k % 2]).sum();
    assert!(
        slope.abs() > 0.1 && bend.abs() > 0.1,
        "nothing to compare: {slope}, {bend}"
    );
    let remainder = |ε: f64| {
        let at = [x[0] + ε * seeds[0] * p[0], x[1] + ε * seeds[1] * p[1]];
        (value(at) - value(x) - ε * slope - 0.5 * ε * ε * bend).abs()
    };
    for ε in [1e-2, 5e-3, 2.5e-3] {
        let ratio = remainder(ε) / remainder(ε / 2.0);
        assert!(
            (ratio - 8.0).abs() < 1.0,
            "remainder falls by {ratio} when the step is halved"
        );
    }
}

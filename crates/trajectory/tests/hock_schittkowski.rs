//! Problems of Hock and Schittkowski (1981) with the published answers.

use trajectory::{Block, Options, Programme, Row, Scalar, Start, Variable, solve};

struct Hs071;

impl Programme for Hs071 {
    fn variables(&self) -> Vec<Variable> {
        (1..=4)
            .map(|k| Variable::new(format!("x{k}"), 1.0, 5.0, 1.0))
            .collect()
    }

    fn blocks(&self) -> Vec<Block> {
        vec![Block::new(
            "hs071",
            vec![0, 1, 2, 3],
            vec![
                Row::between(25.0, f64::INFINITY, 1.0),
                Row::between(40.0, 40.0, 1.0),
            ],
        )]
    }

    fn evaluate<D: Scalar>(&self, _: usize, x: &[D], cost: &mut D, rows: &mut [D]) {
        *cost = x[0] * x[3] * (x[0] + x[1] + x[2]) + x[2];
        rows[0] = x[0] * x[1] * x[2] * x[3];
        rows[1] = x[0] * x[0] + x[1] * x[1] + x[2] * x[2] + x[3] * x[3];
    }
}

#[test]
fn hs071() {
    let options = Options {
        history: true,
        ..Options::default()
    };
    let solution = solve(&Hs071, &Start::cold(vec![1.0, 5.0, 5.0, 1.0]), &options).unwrap();
    assert!(solution.status.is_solved());
    assert!((solution.cost - 17.0140173).abs() < 1e-6);
}

//! Cost and error of one ramp of 600 samples, with and without derivatives. `cargo run --release -p friction --example ramp_cost`
use std::hint::black_box;
use std::time::Instant;

use friction::{LawKind, Record, Scalar, integrate, linear_stretches};
use num_dual::DualSVec64;

const PARAMETERS: [f64; 7] = [0.5, 0.6, 1.5, 0.1, 0.01, 1.5, -0.3];

fn coefficients<D: Scalar>(
    parameters: &[D],
    time: &[f64],
    velocity: &[D],
    knots: &[usize],
) -> Vec<D> {
    let law = LawKind::AsymmetricBristle
        .build(parameters, Some(7e-3))
        .expect("complete");
    let record = Record::of_slip(time, velocity, knots);
    let states = integrate(&law, &record, D::constant(0.0)).expect("finite");
    law.coefficients(&record, &states)
}

fn best_of<T>(repeats: usize, mut work: impl FnMut() -> T) -> f64 {
    (0..repeats)
        .map(|_| {
            let start = Instant::now();
            black_box(work());
            start.elapsed().as_secs_f64() * 1e6
        })
        .fold(f64::INFINITY, f64::min)
}

fn main() {
    let time: Vec<f64> = (0..600).map(|i| f64::from(i) / 60.0).collect();
    let velocity: Vec<f64> = time.iter().map(|t| 0.006 * t).collect();
    let knots = linear_stretches(&time, &velocity, 1e-12);
    let every: Vec<usize> = (0..600).collect();
    let merged = coefficients(&PARAMETERS, &time, &velocity, &knots);
    let fine = coefficients(&PARAMETERS, &time, &velocity, &every);
    let error = merged
        .iter()
        .zip(&fine)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max);
    println!("one stretch against 599: largest difference {error:.1e}");
    println!(
        "values, one stretch   {:8.1} us",
        best_of(300, || coefficients(&PARAMETERS, &time, &velocity, &knots))
    );
    println!(
        "values, 599 stretches {:8.1} us",
        best_of(300, || coefficients(&PARAMETERS, &time, &velocity, &every))
    );
    let dual: Vec<DualSVec64<8>> = PARAMETERS
        .iter()
        .enumerate()
        .map(|(i, &p)| DualSVec64::from_re(p).derivative(i))
        .collect();
    let speeds: Vec<DualSVec64<8>> = velocity.iter().map(|&v| DualSVec64::from_re(v)).collect();
    println!(
        "8 derivatives, one stretch   {:8.1} us",
        best_of(300, || coefficients(&dual, &time, &speeds, &knots))
    );
    println!(
        "8 derivatives, 599 stretches {:8.1} us",
        best_of(300, || coefficients(&dual, &time, &speeds, &every))
    );
}

//! Cost of predictions and Jacobians of the whole chain. `cargo run --release -p diagnosis --example chain_cost`
#[path = "../tests/rigs/mod.rs"]
mod rigs;

use std::time::Instant;

use friction::LawKind;
use rig::{Experiment, Model};

fn best_ms<T>(mut work: impl FnMut() -> T) -> f64 {
    (0..10)
        .map(|_| {
            let start = Instant::now();
            std::hint::black_box(work());
            start.elapsed().as_secs_f64() * 1e3
        })
        .fold(f64::INFINITY, f64::min)
}

fn main() {
    for (name, campaign) in [
        ("14 ramps x 600", rigs::ramps(14)),
        ("rich, 8 runs x 600", rigs::rich(600)),
    ] {
        let experiment = Experiment::new(&campaign).expect("moves");
        let baseline = Model::new(LawKind::AsymmetricBristle, vec![], &experiment).expect("model");
        println!("{name}");
        println!(
            "  baseline: predict {:.2} ms, Jacobian {:.2} ms",
            best_ms(|| baseline.predict(&experiment, &rigs::BRISTLE)),
            best_ms(|| baseline.predict_with_jacobian(&experiment, &rigs::BRISTLE, None))
        );
        for cause in diagnosis::causes::catalogue() {
            let model = Model::new(LawKind::AsymmetricBristle, vec![cause.boxed()], &experiment)
                .expect("model");
            let p = |fitted: &[f64]| [&rigs::BRISTLE[..], fitted].concat();
            let start = &cause.starts(&experiment)[0];
            let null = &cause.shape_grid(&experiment)[0];
            let columns: Vec<usize> = cause.sizes().iter().map(|i| 7 + i).collect();
            println!(
                "  {:24} predict {:6.2} ms, Jacobian {:6.2} ms, score columns {:6.2} ms",
                cause.id(),
                best_ms(|| model.predict(&experiment, &p(start))),
                best_ms(|| model.predict_with_jacobian(&experiment, &p(start), None)),
                best_ms(|| model.predict_with_jacobian(&experiment, &p(null), Some(&columns)))
            );
        }
    }
}

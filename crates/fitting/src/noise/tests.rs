//! Campaigns and dense covariances that the tests of the noise share.

mod covariance;
mod estimates;

use std::sync::Arc;

use nalgebra::{Cholesky, DMatrix, DVector};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::*;

/// Three forward and three reverse uniformly accelerated runs over a plate of 0.1 m, force rising from zero.
fn ramps(samples: usize, pairs: usize) -> Context {
    let mut context = Context {
        conditions: Vec::new(),
        runs: Vec::new(),
        steps_s: Vec::new(),
        sliding: Vec::new(),
        place: Vec::new(),
        scale: Vec::new(),
        channel: Arc::default(),
        rows: Vec::new(),
    };
    for k in 0..2 * pairs {
        let start = context.scale.len();
        for i in 0..samples {
            let t = i as f64 / samples as f64;
            let s = 0.1 * t * t;
            let force = 1.8 * (1.0 - (-20.0 * t).exp());
            context.steps_s.push(if i == 0 { 0.0 } else { 0.01 });
            context.sliding.push(s);
            context.place.push(if k % 2 == 0 { s } else { 0.1 - s });
            context
                .scale
                .push(if k % 2 == 0 { force } else { -0.5 * force });
        }
        context.runs.push(start..context.scale.len());
    }
    context
}

fn dense(context: &Context, sizes: &Sizes) -> DMatrix<f64> {
    let n = context.samples();
    let mut owner = vec![0; n];
    for (k, run) in context.runs.iter().enumerate() {
        run.clone().for_each(|i| owner[i] = k);
    }
    DMatrix::from_fn(n, n, |i, j| {
        // (N7), written out once more.
        let near = |a: f64, b: f64, length: f64, share: f64| {
            let far = (a - b).abs() / length;
            if share == 0.0 {
                (-far).exp()
            } else {
                ((-far).exp() - share * (-far / share).exp()) / (1.0 - share)
            }
        };
        let (x, s) = (&context.place, &context.sliding);
        let own = sizes.length * sizes.plate_ratio;
        let of_plate = if sizes.plate_smoothing > 0.0 {
            sizes.plate_smoothing
        } else {
            sizes.smoothing
        };
        let mut relative = sizes.plate.powi(2) * near(x[i], x[j], own, of_plate);
        if owner[i] == owner[j] {
            let private = near(s[i], s[j], sizes.length, sizes.smoothing);
            relative += sizes.private.powi(2) * private + sizes.scatter.powi(2);
        }
        let mut additive = if i == j { sizes.sensor.powi(2) } else { 0.0 };
        if owner[i] == owner[j] {
            let apart_s: f64 = context.steps_s[i.min(j) + 1..=i.max(j)].iter().sum();
            additive += sizes.wander.powi(2) * (-apart_s / sizes.wander_time_s).exp();
        }
        context.scale[i] * context.scale[j] * relative + additive
    })
}

const SIZES: Sizes = Sizes {
    sensor: 1e-3,
    private: 5.6e-3,
    plate: 5.6e-3,
    length: 1.5e-3,
    scatter: 0.01,
    ..Sizes::NONE
};

fn draw(context: &Context, sizes: &Sizes, seed: u64) -> DVector<f64> {
    let root = Cholesky::new(dense(context, sizes))
        .expect("a covariance")
        .l();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let white = DVector::from_fn(context.samples(), |_, _| StandardNormal.sample(&mut rng));
    root * white
}

/// Roughness that has passed a filter.
const SMOOTH: Sizes = Sizes {
    smoothing: 0.7,
    ..SIZES
};

/// Exponential roughness in a record whose force channel wanders, over twelve samples.
const WANDERING: Sizes = Sizes {
    wander: 4e-3,
    wander_time_s: 0.12,
    ..SIZES
};

/// Roughness of the plate that is longer than that of the runs.
const APART: Sizes = Sizes {
    length: 0.5e-3,
    plate_ratio: 4.0,
    ..SIZES
};

/// Roughness of the plate that is longer than that of the runs, both smooth.
const SMOOTH_APART: Sizes = Sizes {
    smoothing: 0.7,
    ..APART
};

/// Roughness that is smooth, that of the plate still more so.
const SMOOTH_PLATE: Sizes = Sizes {
    smoothing: 0.15,
    plate_smoothing: 0.7,
    ..SIZES
};

/// Samples that lie `further` lengths apart are those of roughness of unit size: its steps are white, to these bounds of the variance and
/// of the correlations.
pub(super) fn assert_is_rough(
    samples: &[f64],
    further: f64,
    (of_variance, of_correlations): (f64, f64),
    what: &str,
) {
    /// Samples after which the start is forgotten.
    const BEGUN: usize = 50;
    let fade = (-further).exp();
    let size = (1.0 - fade * fade).sqrt();
    let pairs = samples.windows(2);
    let white: Vec<f64> = pairs.map(|p| (p[1] - fade * p[0]) / size).collect();
    let mean = |k: usize| {
        let products = white[BEGUN..].iter().zip(&white[BEGUN + k..]);
        products.map(|(a, b)| a * b).sum::<f64>() / (white.len() - BEGUN - k) as f64
    };
    let variance = mean(0);
    assert!(
        (variance - 1.0).abs() < of_variance,
        "{what} {further}: {variance}"
    );
    for k in 1..5 {
        assert!(
            mean(k).abs() < of_correlations,
            "{what} {further}, {k}: {}",
            mean(k)
        );
    }
}

//! The linear-time recursions against the dense covariance, and recovery of known sizes.

use std::sync::Arc;

use nalgebra::{Cholesky, DMatrix, DVector};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::restricted::Criterion;
use super::scatter::{gain_columns, orthonormal_basis};
use super::*;

/// Three forward and three reverse uniformly accelerated runs over a plate of 0.1 m, force rising from zero.
fn ramps(samples: usize, pairs: usize) -> Context {
    let mut context = Context {
        runs: Vec::new(),
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
        let near = |a: f64, b: f64, length: f64| {
            let (far, share) = ((a - b).abs() / length, sizes.smoothing);
            if share == 0.0 {
                (-far).exp()
            } else {
                ((-far).exp() - share * (-far / share).exp()) / (1.0 - share)
            }
        };
        let (x, s) = (&context.place, &context.sliding);
        let own = sizes.length * sizes.plate_ratio;
        let mut relative = sizes.plate.powi(2) * near(x[i], x[j], own);
        if owner[i] == owner[j] {
            relative +=
                sizes.private.powi(2) * near(s[i], s[j], sizes.length) + sizes.scatter.powi(2);
        }
        let white = if i == j { sizes.sensor.powi(2) } else { 0.0 };
        context.scale[i] * context.scale[j] * relative + white
    })
}

const SIZES: Sizes = Sizes {
    sensor: 1e-3,
    private: 5.6e-3,
    plate: 5.6e-3,
    length: 1.5e-3,
    smoothing: 0.0,
    plate_ratio: 1.0,
    scatter: 0.01,
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

/// Roughness of the plate that is longer than that of the runs.
const APART: Sizes = Sizes {
    length: 0.5e-3,
    plate_ratio: 4.0,
    ..SIZES
};

/// Without the plate's field the recursions are exact.
#[test]
fn filter_and_scatter_equal_the_dense_covariance() {
    let context = ramps(60, 2);
    for sizes in [SIZES, SMOOTH] {
        let sizes = Sizes {
            plate: 0.0,
            ..sizes
        };
        let covariance = dense(&context, &sizes);
        let factor = Cholesky::new(covariance).expect("a covariance");
        let whitener = Whitener::new(&context, &sizes);
        let r = draw(&context, &sizes, 1);
        let exact = r.dot(&factor.solve(&r));
        let ours = whitener.whiten(&r).norm_squared();
        assert!((exact - ours).abs() < 1e-8 * exact, "{exact} {ours}");
        let log_det: f64 = 2.0 * factor.l().diagonal().iter().map(|x| x.ln()).sum::<f64>();
        assert!((log_det - whitener.log_det()).abs() < 1e-7 * log_det.abs());
    }
}

/// The covariance behind a filter of the channel: L V L' with the white noise beyond it.
fn behind_filter(context: &Context, sizes: &Sizes) -> DMatrix<f64> {
    let quiet = Sizes {
        sensor: 0.0,
        ..*sizes
    };
    let n = context.samples();
    let mut covariance = dense(context, &quiet);
    for _ in 0..2 {
        for mut column in covariance.column_iter_mut() {
            context.recorded(column.as_mut_slice());
        }
        covariance.transpose_mut();
    }
    covariance + DMatrix::identity(n, n) * sizes.sensor.powi(2)
}

/// The same runs behind a filter of 3.3 and of 0.2 samples.
fn filtered(context: &Context) -> [Context; 2] {
    [3.3, 0.2].map(|samples| {
        let first = |i: usize| context.runs.iter().any(|run| run.start == i);
        let steps = (0..context.samples()).map(|i| if first(i) { 0.0 } else { 1.0 });
        Context {
            channel: Arc::new(Channel {
                lag: Lag::new(steps, samples),
                ..Channel::default()
            }),
            ..context.clone()
        }
    })
}

/// A filter of the channel changes the noise as the dense covariance says: exactly without the plate's field.
#[test]
fn filtered_noise_equals_the_dense_covariance() {
    let plain = ramps(60, 2);
    let both = [SIZES, SMOOTH].map(|sizes| Sizes {
        plate: 0.0,
        ..sizes
    });
    for (context, sizes) in filtered(&plain)
        .into_iter()
        .flat_map(|c| both.map(|sizes| (c.clone(), sizes)))
    {
        let factor = Cholesky::new(behind_filter(&context, &sizes)).expect("a covariance");
        let whitener = Whitener::new(&context, &sizes);
        let r = draw(&plain, &sizes, 1);
        let exact = r.dot(&factor.solve(&r));
        let ours = whitener.whiten(&r).norm_squared();
        assert!((exact - ours).abs() < 1e-8 * exact, "{exact} {ours}");
        let log_det: f64 = 2.0 * factor.l().diagonal().iter().map(|x| x.ln()).sum::<f64>();
        assert!((log_det - whitener.log_det()).abs() < 1e-7 * log_det.abs());
        let (x, y) = (draw(&plain, &sizes, 2), whitener.whiten(&r));
        let other = whitener.whiten_transposed(&x).dot(&r);
        assert!((x.dot(&y) - other).abs() < 1e-9 * other.abs());
    }
}

/// The same runs on a cord, the last without; with and without a filter beside it.
fn on_a_cord(context: &Context) -> Vec<Context> {
    let spring = Spring {
        mass_kg: 0.2,
        compliance_m_n: 1e-3,
        damping_n_s_m: 3.0,
        friction_n_s_m: 0.5,
    };
    let ring = Ring::new(&spring, 0.02).expect("visible");
    let held = &context.runs[..context.runs.len() - 1];
    let rings: Vec<_> = held.iter().map(|run| (run.clone(), ring.clone())).collect();
    let lags = filtered(context).map(|filtered| filtered.channel.lag.clone());
    (std::iter::once(Lag::default()).chain(lags))
        .map(|lag| Context {
            channel: Arc::new(Channel {
                lag,
                rings: rings.clone(),
            }),
            ..context.clone()
        })
        .collect()
}

/// L^-1 V L^-1' + sensor^2 I, L being the dense matrix of what takes the channel out.
fn behind_channel(context: &Context, sizes: &Sizes) -> DMatrix<f64> {
    let n = context.samples();
    let mut out = DMatrix::identity(n, n);
    for mut column in out.column_iter_mut() {
        context.undone(sizes).take_out(column.as_mut_slice());
    }
    let back = out.try_inverse().expect("it can be taken out");
    let quiet = Sizes {
        sensor: 0.0,
        ..*sizes
    };
    &back * dense(context, &quiet) * back.transpose()
        + DMatrix::identity(n, n) * sizes.sensor.powi(2)
}

/// On a cord the noise is what the dense covariance says, exactly without the plate's field, the scatter and a filter (behind both a
/// resonance that changes with the speed and a filter the colour of the white noise is that of the last sample).
#[test]
fn noise_behind_a_cord_equals_the_dense_covariance() {
    let plain = ramps(60, 2);
    for context in on_a_cord(&plain) {
        let tolerance = if context.channel.lag.is_empty() {
            1e-7
        } else {
            2e-3
        };
        for sizes in [SIZES, SMOOTH] {
            let sizes = Sizes {
                plate: 0.0,
                scatter: 0.0,
                ..sizes
            };
            let factor = Cholesky::new(behind_channel(&context, &sizes)).expect("a covariance");
            let whitener = Whitener::new(&context, &sizes);
            let r = draw(&plain, &sizes, 1);
            let exact = r.dot(&factor.solve(&r));
            let ours = whitener.whiten(&r).norm_squared();
            assert!((exact - ours).abs() < tolerance * exact, "{exact} {ours}");
            let log_det: f64 = 2.0 * factor.l().diagonal().iter().map(|x| x.ln()).sum::<f64>();
            assert!((log_det - whitener.log_det()).abs() < tolerance * log_det.abs());
            let (x, y) = (draw(&plain, &sizes, 2), whitener.whiten(&r));
            let other = whitener.whiten_transposed(&x).dot(&r);
            assert!((x.dot(&y) - other).abs() < 1e-9 * other.abs());
        }
    }
}

/// With the plate's field too, as far as its grid resolves it.
#[test]
fn plate_field_behind_a_cord_agrees_with_the_dense_covariance() {
    let sizes = Sizes {
        scatter: 0.0,
        ..SIZES
    };
    for context in on_a_cord(&ramps(120, 2)) {
        let factor = Cholesky::new(behind_channel(&context, &sizes)).expect("a covariance");
        let whitener = Whitener::new(&context, &sizes);
        for wave in [0.0, 30.0, 60.0] {
            let smooth = DVector::from_fn(context.samples(), |i, _| {
                context.scale[i] * (wave * context.place[i]).cos()
            });
            let ours = whitener.whiten(&smooth).norm_squared();
            let ratio = ours / smooth.dot(&factor.solve(&smooth));
            assert!((ratio - 1.0).abs() < 0.02, "wave {wave}: ratio {ratio}");
        }
    }
}

/// With the plate's field too, as far as its grid resolves it.
#[test]
fn filtered_plate_field_agrees_with_the_dense_covariance() {
    for context in filtered(&ramps(120, 2)) {
        let factor = Cholesky::new(behind_filter(&context, &SIZES)).expect("a covariance");
        let whitener = Whitener::new(&context, &SIZES);
        for wave in [0.0, 30.0, 60.0] {
            let mut smooth = DVector::from_fn(context.samples(), |i, _| {
                context.scale[i] * (wave * context.place[i]).cos()
            });
            context.recorded(smooth.as_mut_slice());
            let ours = whitener.whiten(&smooth).norm_squared();
            let ratio = ours / smooth.dot(&factor.solve(&smooth));
            assert!((ratio - 1.0).abs() < 0.02, "wave {wave}: ratio {ratio}");
        }
    }
}

/// With it they agree within the grid's resolution: forms of smooth columns to 2 %; the determinant to 0.08 a sample,
/// because what the field does between nodes (a tenth of its variance) counts as private to each run.
#[test]
fn plate_field_agrees_with_the_dense_covariance() {
    let context = ramps(120, 2);
    for sizes in [SIZES, SMOOTH, APART] {
        let factor = Cholesky::new(dense(&context, &sizes)).expect("a covariance");
        let whitener = Whitener::new(&context, &sizes);
        let waves = DMatrix::from_fn(context.samples(), 3, |i, c| {
            context.scale[i] * (30.0 * c as f64 * context.place[i]).cos()
        });
        let white = whitener.whiten_columns(&waves);
        let ours = white.tr_mul(&white);
        let exact = waves.tr_mul(&factor.solve(&waves));
        for c in 0..3 {
            let ratio = ours[(c, c)] / exact[(c, c)];
            assert!((ratio - 1.0).abs() < 0.02, "form {c}: ratio {ratio}");
        }
        let log_det: f64 = 2.0 * factor.l().diagonal().iter().map(|x| x.ln()).sum::<f64>();
        let gap = (log_det - whitener.log_det()).abs() / context.samples() as f64;
        assert!(gap < 0.08, "log det differs by {gap} a sample");
    }
}

/// Whether roughness is smooth is seen: its share is found, and exponential roughness stays exponential (or nearly so).
#[test]
fn smooth_roughness_is_told_from_exponential_roughness() {
    let context = ramps(240, 3);
    let none = DMatrix::zeros(context.samples(), 0);
    let mean = DMatrix::from_column_slice(context.samples(), 1, &context.scale);
    let options = EstimateOptions {
        repeats: true,
        smooth: true,
        ..EstimateOptions::default()
    };
    let estimates = |sizes: &Sizes| -> Vec<Sizes> {
        (0..8)
            .map(|seed| draw(&context, sizes, 40 + seed))
            .map(|r| estimate(&context, &r, &mean, &none, &options).sizes)
            .collect()
    };
    let (plain, smooth) = (estimates(&SIZES), estimates(&SMOOTH));
    assert!(plain.iter().all(|s| s.smoothing < 0.3), "{plain:?}");
    assert!(smooth.iter().all(|s| s.smoothing > 0.4), "{smooth:?}");
    // The length over which the roughness is alike, l (1 + rho), and its size.
    let alike = |s: &Sizes| (s.length * (1.0 + s.smoothing)).ln();
    let size = |s: &Sizes| 0.5 * (s.private.powi(2) + s.plate.powi(2)).ln();
    for of in [alike, size] {
        let mean = smooth.iter().map(of).sum::<f64>() / 8.0;
        assert!((mean - of(&SMOOTH)).abs() < 0.12, "{mean} {smooth:?}");
    }
}

/// A plate whose roughness is longer than that of the runs is told from one where both are alike.
#[test]
fn a_length_of_the_plates_own_is_told_from_one_for_both() {
    let context = ramps(240, 3);
    let none = DMatrix::zeros(context.samples(), 0);
    let mean = DMatrix::from_column_slice(context.samples(), 1, &context.scale);
    let options = EstimateOptions {
        repeats: true,
        smooth: true,
        ..EstimateOptions::default()
    };
    let estimates = |sizes: &Sizes| -> Vec<f64> {
        (0..8)
            .map(|seed| draw(&context, sizes, 60 + seed))
            .map(|r| estimate(&context, &r, &mean, &none, &options).sizes)
            .map(|s| s.plate_ratio)
            .collect()
    };
    let (one, two) = (estimates(&SIZES), estimates(&APART));
    assert!(
        one.iter().filter(|&&ratio| ratio != 1.0).count() <= 1,
        "{one:?}"
    );
    assert!(
        two.iter().filter(|&&ratio| ratio > 2.0).count() >= 7,
        "{two:?}"
    );
    // One step of the plate is neither.
    let short = Sizes {
        plate_ratio: 1.0,
        ..APART
    };
    let stepped: Vec<f64> = (0..8)
        .map(|seed| {
            let mut r = draw(&context, &short, 60 + seed);
            let (lo, hi) = context.extent();
            for (i, r) in r.iter_mut().enumerate() {
                if context.place[i] > lo + 0.6 * (hi - lo) {
                    *r += 0.04 * context.scale[i];
                }
            }
            estimate(&context, &r, &mean, &none, &options)
                .sizes
                .plate_ratio
        })
        .collect();
    assert!(
        stepped.iter().filter(|&&ratio| ratio != 1.0).count() <= 1,
        "{stepped:?}"
    );
    let mean = two.iter().map(|ratio| ratio.ln()).sum::<f64>() / 8.0;
    assert!(
        (mean - APART.plate_ratio.ln()).abs() < 0.35,
        "{mean} {two:?}"
    );
}

/// Six runs that go back and forth on a plate of 0.1 m, each over a stretch and with a period of its own.
fn oscillations(samples: usize) -> Context {
    let mut context = ramps(samples, 3);
    for (k, run) in context.runs.clone().into_iter().enumerate() {
        let (reach, turns) = (0.05 - 0.006 * k as f64, 2.5 + 0.7 * k as f64);
        let place = |t: f64| 0.05 + reach * (std::f64::consts::TAU * turns * t).sin();
        let mut slid = 0.0;
        for (i, row) in run.enumerate() {
            let (now, before) = (i as f64, (i as f64 - 1.0).max(0.0));
            let moved = place(now / samples as f64) - place(before / samples as f64);
            slid += moved.abs();
            context.sliding[row] = slid;
            context.place[row] = place(now / samples as f64);
            context.scale[row] = if moved < 0.0 { -1.6 } else { 1.6 };
        }
    }
    context
}

/// Roughness of a ninth of the plate is found where runs go back and forth, so that no law looks like it; not on ramps.
#[test]
fn long_roughness_is_found_where_runs_go_back_and_forth() {
    let none = |context: &Context| DMatrix::zeros(context.samples(), 0);
    let options = EstimateOptions {
        repeats: true,
        smooth: true,
        ..EstimateOptions::default()
    };
    let long = Sizes {
        length: 0.011,
        ..SIZES
    };
    let lengths = |context: &Context| -> Vec<f64> {
        let mean = DMatrix::from_column_slice(context.samples(), 1, &context.scale);
        let draws = (0..8).map(|seed| draw(context, &long, 80 + seed));
        let estimates = draws.map(|r| estimate(context, &r, &mean, &none(context), &options));
        estimates.map(|noise| noise.sizes.length).collect()
    };
    let to_and_fro = oscillations(300);
    assert!(to_and_fro.goes_back_and_forth());
    assert!(!ramps(300, 3).goes_back_and_forth());
    let twentieth = 0.1 / 20.0;
    let found = lengths(&to_and_fro);
    assert!(
        found.iter().filter(|&&l| l > 1.2 * twentieth).count() >= 7,
        "{found:?}"
    );
    let mean = found.iter().map(|l| l.ln()).sum::<f64>() / 8.0;
    assert!((mean - long.length.ln()).abs() < 0.3, "{mean} {found:?}");
    let on_ramps = lengths(&ramps(300, 3));
    assert!(
        on_ramps.iter().all(|&l| l < 1.01 * twentieth),
        "{on_ramps:?}"
    );
}

/// The two linear-time paths (rotations; banded information matrix) are the same covariance.
#[test]
fn rotations_and_information_agree() {
    for sizes in [SIZES, SMOOTH, APART] {
        agree(&Sizes {
            scatter: 0.0,
            ..sizes
        });
    }
}

fn agree(sizes: &Sizes) {
    let context = ramps(150, 3);
    let r = draw(&context, sizes, 2);
    let mean = gain_columns(&context);
    let value = Criterion::new(&context, mean.clone(), &r).value(sizes, sizes.node_spacing());
    let whitener = Whitener::new(&context, sizes);
    let basis = orthonormal_basis(&mean);
    let x = whitener.whiten_columns(&basis);
    let y = whitener.whiten(&(&r - &basis * basis.tr_mul(&r)));
    let gram = Cholesky::new(x.tr_mul(&x)).expect("full rank");
    let cross = x.tr_mul(&y);
    let other = whitener.log_det()
        + 2.0 * gram.l().diagonal().iter().map(|v| v.ln()).sum::<f64>()
        + y.norm_squared()
        - cross.dot(&gram.solve(&cross));
    assert!((value - other).abs() < 1e-2, "{value} {other}");
}

/// Sizes are recovered without bias from simulated campaigns.
#[test]
fn known_sizes_are_recovered() {
    let context = ramps(240, 3);
    let none = DMatrix::zeros(context.samples(), 0);
    let mean = DMatrix::from_fn(context.samples(), 2, |i, c| {
        let forward = context.scale[i] > 0.0;
        if forward == (c == 0) {
            context.scale[i]
        } else {
            0.0
        }
    });
    let options = EstimateOptions {
        repeats: true,
        uncertainty: true,
        ..EstimateOptions::default()
    };
    let (mut sums, mut variances, seeds) = ([0.0; 5], [0.0; 4], 24_u32);
    for seed in 0..seeds {
        let model = estimate(
            &context,
            &draw(&context, &SIZES, 10 + u64::from(seed)),
            &mean,
            &none,
            &options,
        );
        assert!(model.plate_separable);
        assert_eq!(model.scatter.degrees_of_freedom(), 4);
        assert!(
            model.log_sd.iter().all(|s| s.is_finite()),
            "{:?}",
            model.log_sd
        );
        for (variance, sd) in variances.iter_mut().zip(&model.log_sd) {
            *variance += sd.powi(2) / f64::from(seeds).powi(2);
        }
        let s = model.sizes;
        for (sum, x) in sums.iter_mut().zip([
            (s.sensor / SIZES.sensor).ln(),
            (s.private / SIZES.private).ln(),
            (s.plate / SIZES.plate).ln(),
            (s.length / SIZES.length).ln(),
            (s.scatter / SIZES.scatter).powi(2),
        ]) {
            *sum += x / f64::from(seeds);
        }
    }
    // The mean over the seeds, within three standard errors as the estimates themselves state them and what the
    // grid of the plate's field costs: what lies between its nodes is taken as private to each run, so the sensor's noise comes
    // out some 7 % small, the private roughness 5 %, the length 6 %.
    for (k, bias) in [0.08, 0.06, 0.05, 0.1].into_iter().enumerate() {
        let standard_error = variances[k].sqrt();
        assert!(
            sums[k].abs() < bias + 3.0 * standard_error && standard_error < 0.08,
            "size {k}: mean log ratio {} with a standard error of {standard_error}",
            sums[k]
        );
    }
    // chi-squared with 4 degrees of freedom over 24 seeds: mean 1, standard deviation 0.14.
    assert!(
        (sums[4] - 1.0).abs() < 0.43,
        "scatter: mean square ratio {}",
        sums[4]
    );
}

/// White noise alone: the roughness comes out as nothing, and the sensor noise right.
#[test]
fn absent_roughness_is_not_invented() {
    let context = ramps(240, 2);
    let none = DMatrix::zeros(context.samples(), 0);
    let sizes = Sizes {
        private: 0.0,
        plate: 0.0,
        scatter: 0.0,
        ..SIZES
    };
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let r = DVector::from_fn(context.samples(), |_, _| {
        let white: f64 = StandardNormal.sample(&mut rng);
        sizes.sensor * white
    });
    let model = estimate(
        &context,
        &r,
        &DMatrix::from_column_slice(context.samples(), 1, &context.scale),
        &none,
        &EstimateOptions::default(),
    );
    assert!((model.sizes.sensor / sizes.sensor - 1.0).abs() < 0.1);
    assert!(
        model.sizes.private < 3e-4 && model.sizes.plate < 3e-4,
        "{:?}",
        model.sizes
    );
}

/// A single pass over the plate cannot tell the two roughnesses apart, and says so.
#[test]
fn a_single_pass_is_not_separable() {
    let mut context = ramps(240, 1);
    context.runs.truncate(1);
    context.sliding.truncate(240);
    context.place.truncate(240);
    context.scale.truncate(240);
    let sizes = Sizes {
        scatter: 0.0,
        ..SIZES
    };
    let none = DMatrix::zeros(240, 0);
    let model = estimate(
        &context,
        &draw(&context, &sizes, 3),
        &none,
        &none,
        &EstimateOptions::default(),
    );
    assert!(!model.plate_separable);
    assert_eq!(model.sizes.plate, 0.0);
    let total = (sizes.private.powi(2) + sizes.plate.powi(2)).sqrt();
    assert!((model.sizes.private / total).ln().abs() < 0.5);
}

/// (W a)'b = a'(W'b).
#[test]
fn transposed_whitening_is_the_adjoint() {
    let context = ramps(80, 2);
    for sizes in [SIZES, SMOOTH] {
        let whitener = Whitener::new(&context, &sizes);
        let (a, b) = (draw(&context, &sizes, 6), draw(&context, &sizes, 7));
        let left = whitener.whiten(&a).dot(&b);
        let right = a.dot(&whitener.whiten_transposed(&b));
        let size = whitener.whiten(&a).norm() * b.norm();
        assert!((left - right).abs() < 1e-10 * size, "{left} {right}");
    }
}

/// A mean that absorbs the gain common to all runs but for a thousandth of it, and misses the record there: that is an error of the mean,
/// and no scatter of many hundred percent.
#[test]
fn what_the_mean_leaves_of_a_gain_is_no_scatter() {
    let context = ramps(60, 3);
    let gains = gain_columns(&context).scale(1e3);
    let common: DVector<f64> = gains.column_sum();
    let bend = DVector::from_fn(common.len(), |i, _| common[i] * (i as f64).sin());
    let mean = DMatrix::from_columns(&[&common + 1e-3 * &bend]);
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut noise = |n: usize| DVector::from_fn(n, |_, _| StandardNormal.sample(&mut rng));
    let runs: DVector<f64> = noise(gains.ncols());
    let scattered = &gains * runs.scale(0.01) + noise(common.len());
    let right = ScatterEvidence::new(&gains, &mean, &scattered);
    let missed = ScatterEvidence::new(&gains, &mean, &(&scattered + 0.05 * &bend));
    assert_eq!(right.degrees_of_freedom(), 5);
    assert!(
        (right.estimate() - 0.01).abs() < 0.005,
        "{}",
        right.estimate()
    );
    assert!(
        (missed.estimate() / right.estimate() - 1.0).abs() < 0.2,
        "{}",
        missed.estimate()
    );
}

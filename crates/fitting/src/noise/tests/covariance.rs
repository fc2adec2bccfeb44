//! The linear-time recursions against the dense covariance and against one another.

use super::super::restricted::Criterion;
use super::super::scatter::{gain_columns, orthonormal_basis};
use super::*;

/// Without the plate's field the recursions are exact.
#[test]
fn filter_and_scatter_equal_the_dense_covariance() {
    let context = ramps(60, 2);
    let smooth_and_wandering = Sizes {
        smoothing: SMOOTH.smoothing,
        ..WANDERING
    };
    for sizes in [SIZES, SMOOTH, WANDERING, smooth_and_wandering] {
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
        let (x, y) = (draw(&context, &sizes, 2), whitener.whiten(&r));
        let other = whitener.whiten_transposed(&x).dot(&r);
        assert!((x.dot(&y) - other).abs() < 1e-9 * other.abs());
    }
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

/// L^-1 V L^-1' + scatter^2 H H' + sensor^2 I, L being the dense matrix of what takes the channel out, H the gains as recorded.
fn behind_channel(context: &Context, sizes: &Sizes) -> DMatrix<f64> {
    let n = context.samples();
    let mut out = DMatrix::identity(n, n);
    for mut column in out.column_iter_mut() {
        context.undone(sizes).take_out(column.as_mut_slice());
    }
    let back = out.try_inverse().expect("it can be taken out");
    let quiet = Sizes {
        sensor: 0.0,
        scatter: 0.0,
        ..*sizes
    };
    let gains = gain_columns(context) * sizes.scatter;
    &back * dense(context, &quiet) * back.transpose()
        + &gains * gains.transpose()
        + DMatrix::identity(n, n) * sizes.sensor.powi(2)
}

/// Behind a filter, on a cord, and behind both the noise is what the dense covariance says, without the plate's field: exactly but for both (there, while the speed changes, the colour of the white noise is that of the last sample).
#[test]
fn noise_behind_a_channel_equals_the_dense_covariance() {
    let plain = ramps(60, 2);
    for context in filtered(&plain).into_iter().chain(on_a_cord(&plain)) {
        let channel = &context.channel;
        let (of_form, of_determinant) = match (channel.lag.is_empty(), channel.rings.is_empty()) {
            (false, true) => (1e-8, 1e-7),
            (true, _) => (1e-7, 1e-7),
            (false, false) => (2e-3, 2e-3),
        };
        for sizes in [SIZES, SMOOTH] {
            let sizes = Sizes {
                plate: 0.0,
                ..sizes
            };
            let factor = Cholesky::new(behind_channel(&context, &sizes)).expect("a covariance");
            let whitener = Whitener::new(&context, &sizes);
            let r = draw(&plain, &sizes, 1);
            let exact = r.dot(&factor.solve(&r));
            let ours = whitener.whiten(&r).norm_squared();
            assert!((exact - ours).abs() < of_form * exact, "{exact} {ours}");
            let log_det: f64 = 2.0 * factor.l().diagonal().iter().map(|x| x.ln()).sum::<f64>();
            assert!((log_det - whitener.log_det()).abs() < of_determinant * log_det.abs());
            let (x, y) = (draw(&plain, &sizes, 2), whitener.whiten(&r));
            let other = whitener.whiten_transposed(&x).dot(&r);
            assert!((x.dot(&y) - other).abs() < 1e-9 * other.abs());
        }
    }
}

/// With the plate's field too, as far as its grid resolves it.
#[test]
fn plate_field_behind_a_channel_agrees_with_the_dense_covariance() {
    let plain = ramps(120, 2);
    for context in filtered(&plain).into_iter().chain(on_a_cord(&plain)) {
        let factor = Cholesky::new(behind_channel(&context, &SIZES)).expect("a covariance");
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
    for sizes in [SIZES, SMOOTH, APART, SMOOTH_PLATE] {
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

/// The three linear-time paths (the field taken out at once, sample by sample, and not at all but in inner products) are the same covariance.
#[test]
fn the_ways_to_take_the_field_out_agree() {
    for sizes in [SIZES, SMOOTH, APART, SMOOTH_APART, SMOOTH_PLATE, WANDERING] {
        agree(&Sizes {
            scatter: 0.0,
            ..sizes
        });
    }
}

fn agree(sizes: &Sizes) {
    // more runs than columns go through the plate side by side
    let context = ramps(90, 5);
    let r = draw(&context, sizes, 2);
    let wave = DMatrix::from_fn(context.samples(), 1, |i, _| (30.0 * context.place[i]).cos());
    let gains = gain_columns(&context);
    let mut mean = gains.clone().resize_horizontally(gains.ncols() + 1, 0.0);
    mean.set_column(gains.ncols(), &wave.column(0));
    let spacing = sizes.node_spacing(context.sampling());
    let value_of = |mean: &DMatrix<f64>, own_gains: bool| {
        Criterion::new(&context, mean, own_gains, &r).value(sizes, spacing)
    };
    let value = value_of(&wave, true);
    let as_columns = value_of(&mean, false);
    assert!((value - as_columns).abs() < 1e-8, "{value} {as_columns}");
    let basis = orthonormal_basis(&mean);
    let of = |whitener: &Whitener| {
        let x = whitener.whiten_columns(&basis);
        let y = whitener.whiten(&(&r - &basis * basis.tr_mul(&r)));
        let gram = Cholesky::new(x.tr_mul(&x)).expect("full rank");
        let cross = x.tr_mul(&y);
        whitener.log_det()
            + 2.0 * gram.l().diagonal().iter().map(|v| v.ln()).sum::<f64>()
            + y.norm_squared()
            - cross.dot(&gram.solve(&cross))
    };
    let (at_once, by_sample) = (
        Whitener::new(&context, sizes),
        Whitener::by_sample(&context, sizes),
    );
    assert_eq!(by_sample.rows(), context.samples());
    assert!(at_once.rows() > context.samples());
    let (at_once, by_sample) = (of(&at_once), of(&by_sample));
    assert!((value - at_once).abs() < 1e-6, "{value} {at_once}");
    assert!((value - by_sample).abs() < 1e-2, "{value} {by_sample}");
}

/// Where all standard deviations grow by one factor the criterion changes as (N11) says.
#[test]
fn what_a_common_factor_does_is_known() {
    let context = ramps(150, 3);
    let wave = DMatrix::from_fn(context.samples(), 1, |i, _| (30.0 * context.place[i]).cos());
    for sizes in [SIZES, SMOOTH_APART, WANDERING] {
        let r = draw(&context, &sizes, 2);
        let criterion = Criterion::new(&context, &wave, true, &r);
        let spacing = sizes.node_spacing(context.sampling());
        let level = criterion.level(&sizes, spacing);
        let t = 0.3_f64;
        let larger = |size: f64| size * t.exp();
        let grown = Sizes {
            sensor: larger(sizes.sensor),
            wander: larger(sizes.wander),
            private: larger(sizes.private),
            plate: larger(sizes.plate),
            ..sizes
        };
        let freedom = criterion.degrees_of_freedom() as f64;
        let known = level.value + 2.0 * freedom * t + (-2.0 * t).exp_m1() * level.squares;
        let value = criterion.value(&grown, spacing);
        assert!((value - known).abs() < 1e-6, "{value} {known}");
    }
}

/// (W a)'b = a'(W'b).
#[test]
fn transposed_whitening_is_the_adjoint() {
    let context = ramps(80, 2);
    for sizes in [SIZES, SMOOTH] {
        for whitener in [
            Whitener::new(&context, &sizes),
            Whitener::by_sample(&context, &sizes),
        ] {
            let a = draw(&context, &sizes, 6);
            let b = DVector::from_fn(whitener.rows(), |i, _| (i as f64).sin());
            let left = whitener.whiten(&a).dot(&b);
            let right = a.dot(&whitener.whiten_transposed(&b));
            let size = whitener.whiten(&a).norm() * b.norm();
            assert!((left - right).abs() < 1e-10 * size, "{left} {right}");
        }
    }
}

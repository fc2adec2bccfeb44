//! What estimates make of known sizes: recovered without bias, told apart where the record tells them, refused where it does not.

use super::super::scatter::gain_columns;
use super::*;

/// What a residual makes of the sizes, where roughness may be smooth or of two lengths.
fn estimated(context: &Context, residual: &DVector<f64>) -> Sizes {
    let none = DMatrix::zeros(context.samples(), 0);
    let mean = DMatrix::from_column_slice(context.samples(), 1, &context.scale);
    let options = EstimateOptions {
        repeats: true,
        smooth: true,
        wanders: true,
        ..EstimateOptions::default()
    };
    estimate(context, residual, &mean, &none, &options).sizes
}

/// The same of eight fields drawn with known sizes.
fn estimates(context: &Context, sizes: &Sizes, first_seed: u64) -> Vec<Sizes> {
    let draws = (0..8).map(|seed| draw(context, sizes, first_seed + seed));
    draws.map(|r| estimated(context, &r)).collect()
}

/// Whether roughness is smooth is seen: exponential roughness stays exponential (or nearly so), and smooth roughness does not.
#[test]
fn smooth_roughness_is_told_from_exponential_roughness() {
    let context = ramps(240, 3);
    let [plain, smooth] = [SIZES, SMOOTH].map(|sizes| estimates(&context, &sizes, 40));
    assert!(plain.iter().all(|s| s.smoothing < 0.05), "{plain:?}");
    // Of both lengths little but their product and their sum is known: 0.21 to 0.82 of these fields.
    assert!(smooth.iter().all(|s| s.smoothing > 0.15), "{smooth:?}");
    // Sizes have no bias: of eight fields the mean length is known to some four percent.
    let length = plain.iter().map(|s| s.length.ln()).sum::<f64>() / 8.0;
    assert!((length - SIZES.length.ln()).abs() < 0.06, "{plain:?}");
    // The length over which the roughness is alike, l (1 + rho), and its size.
    let alike = |s: &Sizes| (s.length * (1.0 + s.smoothing)).ln();
    let size = |s: &Sizes| 0.5 * (s.private.powi(2) + s.plate.powi(2)).ln();
    for of in [alike, size] {
        let mean = smooth.iter().map(of).sum::<f64>() / 8.0;
        assert!((mean - of(&SMOOTH)).abs() < 0.12, "{mean} {smooth:?}");
    }
}

/// A force channel that wanders is told from one that does not, whether the rig slides or stands, and its sizes come back.
#[test]
fn a_wander_is_told_from_white_noise() {
    let context = ramps(240, 3);
    let [still, wandering] = [SIZES, WANDERING].map(|sizes| estimates(&context, &sizes, 80));
    let seen = |all: &[Sizes]| all.iter().filter(|s| s.wander > 0.0).count();
    assert!(seen(&still) <= 1, "{still:?}");
    assert_eq!(seen(&wandering), 8, "{wandering:?}");
    // 1440 samples over twelve each: the size is known to some 6 % of each field, the time to 25 %.
    let mean = |of: fn(&Sizes) -> f64| wandering.iter().map(of).sum::<f64>() / 8.0;
    let (size, time) = (mean(|s| s.wander.ln()), mean(|s| s.wander_time_s.ln()));
    assert!((size - WANDERING.wander.ln()).abs() < 0.1, "{wandering:?}");
    assert!(
        (time - WANDERING.wander_time_s.ln()).abs() < 0.25,
        "{wandering:?}"
    );
    let private = mean(|s| s.private.ln());
    assert!((private - SIZES.private.ln()).abs() < 0.15, "{wandering:?}");
}

/// A plate whose roughness is longer than that of the runs is told from one where both are alike.
#[test]
fn a_length_of_the_plates_own_is_told_from_one_for_both() {
    let context = ramps(240, 3);
    let [one, two] = [SIZES, APART].map(|sizes| -> Vec<f64> {
        let estimates = estimates(&context, &sizes, 60);
        estimates.iter().map(|s| s.plate_ratio).collect()
    });
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
            estimated(&context, &r).plate_ratio
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

/// Of eight records of each at most one of `alike` and at least `seen` of `apart` are said to have a plate whose smoothing is its own, beyond
/// `beyond`, and the size of `apart`'s plate is not taken for less.
fn assert_a_smooth_plate_is_told(
    (alike, apart): (Sizes, Sizes),
    first_seed: u64,
    beyond: f64,
    seen: usize,
) {
    let context = ramps(300, 3);
    let planted = apart.plate.ln();
    let [alike, apart] = [alike, apart].map(|sizes| estimates(&context, &sizes, first_seed));
    let own = |all: &[Sizes]| all.iter().filter(|s| s.plate_smoothing > beyond).count();
    assert!(own(&alike) <= 1, "{alike:?}");
    assert!(own(&apart) >= seen, "{apart:?}");
    let plate = apart.iter().map(|s| s.plate.ln()).sum::<f64>() / 8.0;
    assert!((plate - planted).abs() < 0.25, "{apart:?}");
}

/// A plate that is smoother than the runs' own roughness is told from one where both are alike, and its roughness is not taken for less.
#[test]
fn a_plate_smoother_than_the_runs_is_told_from_one_that_is_alike() {
    assert_a_smooth_plate_is_told((SMOOTH, SMOOTH_PLATE), 160, 0.0, 5);
}

/// A ground plate under runs whose own roughness is exponential is smooth, and exponential plates are not.
#[test]
fn a_smooth_plate_is_told_beside_exponential_runs() {
    let ground = Sizes {
        plate_smoothing: 0.7,
        ..SIZES
    };
    assert_a_smooth_plate_is_told((SIZES, ground), 360, 0.1, 6);
}

/// Smooth roughness of two lengths is told from smooth roughness of one.
#[test]
fn smooth_roughness_may_have_two_lengths() {
    let context = ramps(300, 3);
    let [one, two] = [SMOOTH, SMOOTH_APART].map(|sizes| estimates(&context, &sizes, 260));
    let of_two = |s: &&Sizes| s.plate_ratio > 1.5;
    assert!(one.iter().filter(of_two).count() <= 1, "{one:?}");
    let smooth = two.iter().filter(of_two).filter(|s| s.smoothing > 0.1);
    assert!(smooth.count() >= 5, "{two:?}");
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

/// Three runs each way with a scatter of 1 %, and a mean that misses what the two ways differ by: 2 % may be scatter, 30 % is none, and
/// repeats alone say how large the scatter is.
#[test]
fn what_a_mean_misses_of_whole_conditions_is_no_scatter() {
    let context = ramps(60, 3);
    let gains = gain_columns(&context).scale(1e3);
    let conditions = [0, 1, 0, 1, 0, 1];
    let ways = DVector::from_fn(6, |k, _| if conditions[k] == 0 { 1.0 } else { -1.0 });
    let nothing = DMatrix::zeros(gains.nrows(), 0);
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut noise = |n: usize| DVector::from_fn(n, |_, _| StandardNormal.sample(&mut rng));
    let scattered = &gains * noise(6).scale(0.01) + noise(gains.nrows());
    let evidence = |missed: f64, conditions: &[usize]| {
        let record = &scattered + &gains * ways.scale(missed);
        ScatterEvidence::of_repeats(&gains, &nothing, &record, conditions)
    };
    let little = evidence(0.02, &conditions);
    assert_eq!(little.degrees_of_freedom(), 6);
    let much = evidence(0.3, &conditions);
    assert_eq!(much.degrees_of_freedom(), 4);
    assert!(
        (much.estimate() / 0.01).ln().abs() < 0.7,
        "{}",
        much.estimate()
    );
    // Without repeats there is nothing to hold it against.
    let told_apart = evidence(0.3, &[0, 1, 2, 3, 4, 5]);
    assert!(told_apart.estimate() > 0.2, "{}", told_apart.estimate());
}

/// Healthy scatter, whatever its size, is called an error of the mean once in a thousand: 4,000 draws of three runs each way.
#[test]
fn healthy_scatter_seldom_contradicts_its_repeats() {
    let context = ramps(20, 3);
    let gains = gain_columns(&context).scale(1e3);
    let nothing = DMatrix::zeros(gains.nrows(), 0);
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let mut noise = |n: usize| DVector::from_fn(n, |_, _| StandardNormal.sample(&mut rng));
    let draws = 4000;
    let contradicted = (0..draws).filter(|draw| {
        let scatter = [0.0, 0.003, 0.01, 0.1][draw % 4];
        let record = &gains * noise(6).scale(scatter) + noise(gains.nrows());
        let found = ScatterEvidence::of_repeats(&gains, &nothing, &record, &[0, 1, 0, 1, 0, 1]);
        found.degrees_of_freedom() < 6
    });
    // 4 expected.
    let contradicted = contradicted.count();
    assert!(contradicted <= 11, "{contradicted} of {draws}");
}

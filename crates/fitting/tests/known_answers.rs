//! Problems whose answers are known in closed form: valleys, bounds, flat directions, intervals.

use fitting::criteria::t_quantile;
use fitting::{
    Bounds, Limit, Options, ProfileOptions, Residuals, Side, Status, Verdict, identifiability,
    minimise, multi_start, profile, profile_curve, spread_starts,
};
use nalgebra::{DMatrix, DVector};

/// A problem from two closures.
struct Closures<R, J>(R, J);

impl<R, J> Residuals for Closures<R, J>
where
    R: Fn(&[f64]) -> Vec<f64> + Sync,
    J: Fn(&[f64]) -> DMatrix<f64> + Sync,
{
    fn residuals(&self, p: &[f64]) -> DVector<f64> {
        DVector::from_vec((self.0)(p))
    }

    fn jacobian(&self, p: &[f64]) -> (DVector<f64>, DMatrix<f64>) {
        (self.residuals(p), (self.1)(p))
    }
}

/// Rosenbrock 1960: r = (10 (p1 - p0^2), 1 - p0), minimum 0 at (1, 1).
fn rosenbrock() -> impl Residuals {
    Closures(
        |p: &[f64]| vec![10.0 * (p[1] - p[0] * p[0]), 1.0 - p[0]],
        |p: &[f64]| DMatrix::from_row_slice(2, 2, &[-20.0 * p[0], 10.0, -1.0, 0.0]),
    )
}

/// A straight line a + b t through scattered points, with unit noise.
fn line(n: usize) -> (impl Residuals, f64, f64) {
    let t: Vec<f64> = (0..n).map(|i| i as f64 / (n - 1) as f64).collect();
    let y: Vec<f64> = t
        .iter()
        .enumerate()
        .map(|(i, t)| 2.0 + 3.0 * t + if i % 2 == 0 { 0.7 } else { -0.7 })
        .collect();
    let mean = 0.5;
    let sxx: f64 = t.iter().map(|t| (t - mean) * (t - mean)).sum();
    let slope: f64 = t.iter().zip(&y).map(|(t, y)| (t - mean) * y).sum::<f64>() / sxx;
    let jacobian = DMatrix::from_fn(n, 2, |i, j| if j == 0 { 1.0 } else { t[i] });
    let problem = Closures(
        {
            let (t, y) = (t.clone(), y);
            move |p: &[f64]| {
                t.iter()
                    .zip(&y)
                    .map(|(t, y)| p[0] + p[1] * t - y)
                    .collect::<Vec<f64>>()
            }
        },
        move |_: &[f64]| jacobian.clone(),
    );
    (problem, slope, sxx)
}

#[test]
fn rosenbrock_valley_from_the_classic_start() {
    let fit = minimise(
        &rosenbrock(),
        &[-1.2, 1.0],
        &Bounds::free(2),
        &Options::default(),
    )
    .unwrap();
    assert!(fit.status.converged(), "{}", fit.status);
    assert!((fit.parameters[0] - 1.0).abs() < 1e-9 && (fit.parameters[1] - 1.0).abs() < 1e-9);
    // Work counters are part of the behaviour: a change is to be seen.
    assert!(fit.iterations <= 30, "{} steps", fit.iterations);
    assert_eq!(fit.jacobians, fit.iterations + 1);
}

/// With p0 <= 0.5 the minimum is (0.5, 0.25): the inactive residual stays at zero, the bound carries a multiplier.
#[test]
fn rosenbrock_against_a_bound() {
    let bounds = Bounds::new(vec![-2.0, -2.0], vec![0.5, 2.0]).unwrap();
    let fit = minimise(&rosenbrock(), &[-1.2, 1.0], &bounds, &Options::default()).unwrap();
    assert!(fit.status.converged(), "{}", fit.status);
    assert_eq!(fit.parameters[0], 0.5);
    assert!((fit.parameters[1] - 0.25).abs() < 1e-9);
    assert_eq!(fit.at_bound, vec![(0, Side::Upper)]);
    // The covariance is that of the parameter inside: 1/100.
    let covariance = fit.covariance.unwrap();
    assert!((covariance[(1, 1)] - 0.01).abs() < 1e-12);
    assert_eq!(covariance[(0, 0)], 0.0);
}

/// A start on a bound that is not active at the solution must leave it.
#[test]
fn a_bound_that_does_not_belong_is_left_again() {
    let bounds = Bounds::new(vec![-1.2, 0.0], vec![3.0, 3.0]).unwrap();
    let fit = minimise(&rosenbrock(), &[-1.2, 0.0], &bounds, &Options::default()).unwrap();
    assert!(fit.status.converged());
    assert!((fit.parameters[0] - 1.0).abs() < 1e-8);
    assert!(fit.at_bound.is_empty());
}

#[test]
fn units_change_nothing() {
    let plain = minimise(
        &rosenbrock(),
        &[-1.2, 1.0],
        &Bounds::free(2),
        &Options::default(),
    )
    .unwrap();
    // The same valley with p1 counted in units of 2^-20 (an exact change of scale).
    let unit = f64::powi(2.0, -20);
    let scaled = Closures(
        move |p: &[f64]| vec![10.0 * (p[1] * unit - p[0] * p[0]), 1.0 - p[0]],
        move |p: &[f64]| DMatrix::from_row_slice(2, 2, &[-20.0 * p[0], 10.0 * unit, -1.0, 0.0]),
    );
    let fit = minimise(
        &scaled,
        &[-1.2, 1.0 / unit],
        &Bounds::free(2),
        &Options::default(),
    )
    .unwrap();
    assert_eq!(fit.iterations, plain.iterations);
    assert!((fit.parameters[1] * unit - plain.parameters[1]).abs() < 1e-9);
}

#[test]
fn bad_starts_have_names() {
    let nowhere = Closures(
        |p: &[f64]| vec![p[0].ln()],
        |p: &[f64]| DMatrix::from_element(1, 1, 1.0 / p[0]),
    );
    let fit = minimise(&nowhere, &[-1.0], &Bounds::free(1), &Options::default()).unwrap();
    assert_eq!(fit.status, Status::NonFiniteStart);
    assert!(!fit.status.converged());
    let wrong_length = minimise(&nowhere, &[1.0, 2.0], &Bounds::free(1), &Options::default());
    assert!(wrong_length.is_err());
}

/// A Jacobian of the wrong sign promises descent where there is none: stalled, never converged.
#[test]
fn wrong_derivatives_are_not_called_convergence() {
    let wrong = Closures(
        |p: &[f64]| vec![p[0] - 3.0, 0.1],
        |_: &[f64]| DMatrix::from_row_slice(2, 1, &[-1.0, 0.0]),
    );
    let fit = minimise(&wrong, &[0.0], &Bounds::free(1), &Options::default()).unwrap();
    assert_eq!(fit.status, Status::Stalled);
}

#[test]
fn few_iterations_are_named_as_such() {
    let options = Options {
        iteration_limit: 2,
        ..Options::default()
    };
    let fit = minimise(&rosenbrock(), &[-1.2, 1.0], &Bounds::free(2), &options).unwrap();
    assert_eq!(fit.status, Status::IterationLimit);
    assert_eq!(fit.iterations, 2);
}

/// The same valley on a floor of 4.5. Where the fit must come below 5 it ends where it would have ended, bit for bit; where it must come below 1 it
/// is given up on the way, for fewer evaluations.
#[test]
fn a_fit_that_will_not_come_below_what_it_must_is_given_up() {
    let on_a_floor = Closures(
        |p: &[f64]| vec![10.0 * (p[1] - p[0] * p[0]), 1.0 - p[0], 3.0],
        |p: &[f64]| DMatrix::from_row_slice(3, 2, &[-20.0 * p[0], 10.0, -1.0, 0.0, 0.0, 0.0]),
    );
    let [unbounded, reached, hopeless] = [None, Some(5.0), Some(1.0)].map(|below| {
        let options = Options {
            below,
            ..Options::default()
        };
        minimise(&on_a_floor, &[-1.2, 1.0], &Bounds::free(2), &options).unwrap()
    });
    assert!(unbounded.status.converged() && (unbounded.cost - 4.5).abs() < 1e-12);
    assert_eq!(reached.parameters, unbounded.parameters);
    assert_eq!(reached.evaluations, unbounded.evaluations);
    assert_eq!(hopeless.status, Status::Hopeless);
    assert!(!hopeless.status.converged());
    assert!(hopeless.cost > 4.5 && hopeless.evaluations < unbounded.evaluations);
}

/// r = a exp(-b t) c - y: the ray (s a, b, c / s) is flat. The solver ends on it, says that there is no covariance, and the
/// profile of `a` stays at zero on both sides.
#[test]
fn a_flat_ray_is_seen_by_rank_and_by_profile() {
    let t: Vec<f64> = (0..30).map(|i| 0.1 * f64::from(i)).collect();
    let y: Vec<f64> = t
        .iter()
        .enumerate()
        .map(|(i, t)| 6.0 * (-0.7 * t).exp() + 0.05 * f64::from(i as u32 % 3) - 0.05)
        .collect();
    let problem = Closures(
        {
            let (t, y) = (t.clone(), y);
            move |p: &[f64]| {
                t.iter()
                    .zip(&y)
                    .map(|(t, y)| 20.0 * (p[0] * p[2] * (-p[1] * t).exp() - y))
                    .collect::<Vec<f64>>()
            }
        },
        {
            let t = t.clone();
            move |p: &[f64]| {
                DMatrix::from_fn(t.len(), 3, |i, j| {
                    let e = 20.0 * (-p[1] * t[i]).exp();
                    match j {
                        0 => p[2] * e,
                        1 => -t[i] * p[0] * p[2] * e,
                        _ => p[0] * e,
                    }
                })
            }
        },
    );
    let bounds = Bounds::new(vec![0.01, 0.0, 1e-6], vec![1e3, 10.0, 1e6]).unwrap();
    let fit = minimise(&problem, &[1.0, 1.0, 1.0], &bounds, &Options::default()).unwrap();
    assert!(fit.status.converged(), "{}", fit.status);
    assert!(fit.covariance.is_none());
    let (_, jacobian) = problem.jacobian(&fit.parameters);
    let found = identifiability(&jacobian, &fit.parameters);
    assert_eq!(found.rank, 2);
    assert_eq!(found.verdicts[0], Verdict::StructurallyNonIdentifiable);
    assert_eq!(found.verdicts[1], Verdict::Identifiable);
    let flat = profile(&problem, &fit, 0, &bounds, &ProfileOptions::new(4.0, 0.5)).unwrap();
    assert!(flat.is_flat());
    assert!(flat.points.iter().all(|p| p.deviance.abs() < 1e-6));
    let rate = profile(&problem, &fit, 1, &bounds, &ProfileOptions::new(4.0, 0.05)).unwrap();
    assert!(!rate.is_flat());
}

/// In a linear model the profile interval is slope -+ t / sqrt(Sxx) exactly.
#[test]
fn profile_interval_of_a_line_is_the_textbook_one() {
    let (problem, slope, sxx) = line(21);
    let bounds = Bounds::free(2);
    let fit = minimise(&problem, &[0.0, 0.0], &bounds, &Options::default()).unwrap();
    assert!((fit.parameters[1] - slope).abs() < 1e-6);
    let t = t_quantile(0.95, 4.0);
    let options = ProfileOptions::new(t * t, 0.1);
    let found = profile(&problem, &fit, 1, &bounds, &options).unwrap();
    let half = t / sxx.sqrt();
    assert!((found.lower.value(Side::Lower) - (slope - half)).abs() < 2e-3 * half);
    assert!((found.upper.value(Side::Upper) - (slope + half)).abs() < 2e-3 * half);
    assert!(found.better.is_none());
}

/// y = exp(-k) measured once with unit noise as y = 1e-2 * 100: D(k) = (100 (exp(-k) - 0.2))^2, so the ends for a
/// threshold of 4 are -ln(0.22) and -ln(0.18): not symmetric, and found as such.
#[test]
fn a_nonlinear_profile_finds_its_unequal_ends() {
    let problem = Closures(
        |p: &[f64]| vec![100.0 * ((-p[0]).exp() - 0.2)],
        |p: &[f64]| DMatrix::from_element(1, 1, -100.0 * (-p[0]).exp()),
    );
    let bounds = Bounds::free(1);
    let fit = minimise(&problem, &[0.5], &bounds, &Options::default()).unwrap();
    let found = profile(&problem, &fit, 0, &bounds, &ProfileOptions::new(4.0, 0.1)).unwrap();
    let (low, high) = (-(0.22_f64.ln()), -(0.18_f64.ln()));
    let width = high - low;
    assert!((found.lower.value(Side::Lower) - low).abs() < 2e-3 * width);
    assert!((found.upper.value(Side::Upper) - high).abs() < 2e-3 * width);
}

/// Beyond the largest deviance that exists the interval is open, and says how far it was looked:
/// r = exp(-k) - 1 with threshold 4 is open above (D < 1) and closed below.
#[test]
fn an_open_side_is_called_open() {
    let problem = Closures(
        |p: &[f64]| vec![(-p[0]).exp() - 1.0],
        |p: &[f64]| DMatrix::from_element(1, 1, -(-p[0]).exp()),
    );
    let bounds = Bounds::free(1);
    let fit = minimise(&problem, &[0.3], &bounds, &Options::default()).unwrap();
    let found = profile(&problem, &fit, 0, &bounds, &ProfileOptions::new(4.0, 0.1)).unwrap();
    assert!(matches!(found.lower, Limit::Crossed { .. }));
    assert!(matches!(found.upper, Limit::Open { deviance, .. } if deviance < 1.0 + 1e-9));
    assert_eq!(found.upper.value(Side::Upper), f64::INFINITY);
}

/// Slope held at or above 4 although the data want 3: one-sided, and the intercept's profile names the slope's bound.
#[test]
fn bounds_make_one_sided_intervals_and_are_named() {
    let (problem, _, _) = line(21);
    let bounds = Bounds::new(vec![-10.0, 4.0], vec![10.0, 10.0]).unwrap();
    let fit = minimise(&problem, &[0.0, 5.0], &bounds, &Options::default()).unwrap();
    assert_eq!(fit.at_bound, vec![(1, Side::Lower)]);
    let options = ProfileOptions::new(4.0, 0.1);
    let slope = profile(&problem, &fit, 1, &bounds, &options).unwrap();
    assert_eq!(slope.lower, Limit::OwnBound { value: 4.0 });
    assert!(matches!(slope.upper, Limit::Crossed { .. }));
    let intercept = profile(&problem, &fit, 0, &bounds, &options).unwrap();
    match intercept.upper {
        Limit::Crossed { at_bound, .. } => assert_eq!(at_bound, vec![(1, Side::Lower)]),
        other => panic!("{other:?}"),
    }
}

/// r = sin-like landscape with many minima; only the spread of starts finds the lowest one.
#[test]
fn many_starts_find_the_lowest_of_many_minima() {
    // r = (p - 4, 3 sin(2 p) + 3): local minima wherever sin(2p) = -1, the lowest near p = 3 pi/4 + pi = 5.50 or 2.36.
    let problem = Closures(
        |p: &[f64]| vec![p[0] - 4.0, 3.0 * (2.0 * p[0]).sin() + 3.0],
        |p: &[f64]| DMatrix::from_row_slice(2, 1, &[1.0, 6.0 * (2.0 * p[0]).cos()]),
    );
    let bounds = Bounds::new(vec![-20.0], vec![20.0]).unwrap();
    let starts = spread_starts(&[-20.0], &[20.0], 24);
    let found = multi_start(&problem, &starts, &bounds, &Options::default()).unwrap();
    // Second path: a fine scan of the same function.
    let scan = (0..400_000)
        .map(|i| -20.0 + 1e-4 * f64::from(i))
        .map(|p: f64| 0.5 * ((p - 4.0).powi(2) + (3.0 * (2.0 * p).sin() + 3.0).powi(2)))
        .fold(f64::INFINITY, f64::min);
    assert!(
        (found.best.cost - scan).abs() < 1e-6,
        "{} {scan}",
        found.best.cost
    );
    assert!(found.converged > found.agreeing, "other minima exist");
    let again = multi_start(&problem, &starts, &bounds, &Options::default()).unwrap();
    assert_eq!(found.best.parameters, again.best.parameters);
    assert_eq!(found.work, again.work);
}

#[test]
fn a_curve_is_ordered_and_contains_the_best_fit() {
    let (problem, slope, sxx) = line(21);
    let bounds = Bounds::free(2);
    let fit = minimise(&problem, &[0.0, 0.0], &bounds, &Options::default()).unwrap();
    let values: Vec<f64> = (-4..=4)
        .map(|k| slope + 0.3 * f64::from(k) + 0.01)
        .collect();
    let curve = profile_curve(
        &problem,
        &fit,
        1,
        &bounds,
        &values,
        &ProfileOptions::new(4.0, 0.1),
    )
    .unwrap();
    assert_eq!(curve.len(), 10);
    for point in &curve {
        let exact = (point.value - slope).powi(2) * sxx;
        assert!(
            (point.deviance - exact).abs() < 1e-6 * (1.0 + exact),
            "{point:?}"
        );
    }
    assert!(curve.windows(2).all(|w| w[0].value < w[1].value));
}

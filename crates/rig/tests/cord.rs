//! The specimen on a cord: against a fine explicit integration of the same mechanics, and its limits.

mod campaigns;

use campaigns::{BRISTLE, HEIGHT, LUGRE, Spring, campaign, ramp, run, time, wave};
use friction::{Drive, Law, LawKind};
use rig::{Experiment, Model};

const LOAD: f64 = 2.0;

/// z' = f, x' = u, m u' = N mu(z, V - u) - x/C - d u by classical Runge-Kutta with `n` steps between samples.
fn explicit(law: &Law<f64>, t: &[f64], v: &[f64], c: f64, d: f64, m: f64, n: usize) -> Vec<f64> {
    let mut y = [0.0, 0.0, 0.0];
    let mut out = vec![0.0];
    for i in 1..t.len() {
        let h = (t[i] - t[i - 1]) / n as f64;
        for k in 0..n {
            let rate = |s: f64, y: [f64; 3]| {
                let stage = v[i - 1] + (v[i] - v[i - 1]) * (k as f64 + s) / n as f64;
                let drive = Drive::at(stage - y[2]);
                let friction = LOAD * law.coefficient(y[0], &drive);
                [
                    law.state_rate(y[0], &drive),
                    y[2],
                    (friction - y[1] / c - d * y[2]) / m,
                ]
            };
            let step = |y: [f64; 3], r: [f64; 3], h: f64| {
                [y[0] + h * r[0], y[1] + h * r[1], y[2] + h * r[2]]
            };
            let k1 = rate(0.0, y);
            let k2 = rate(0.5, step(y, k1, 0.5 * h));
            let k3 = rate(0.5, step(y, k2, 0.5 * h));
            let k4 = rate(1.0, step(y, k3, h));
            for j in 0..3 {
                y[j] += h / 6.0 * (k1[j] + 2.0 * k2[j] + 2.0 * k3[j] + k4[j]);
            }
        }
        out.push(y[1] / c + d * y[2]);
    }
    out
}

fn predicted(
    kind: LawKind,
    law: &[f64],
    v: &[f64],
    t: &[f64],
    c: f64,
    d: f64,
    mass_kg: f64,
) -> Vec<f64> {
    let experiment =
        Experiment::new(&campaign(vec![run(t, v.to_vec(), Some(LOAD), 1)])).expect("moves");
    let model = Model::new(kind, vec![Box::new(Spring { mass_kg })], &experiment).expect("model");
    model.predict(&experiment, &[law, &[c, d]].concat())
}

fn largest(a: &[f64], b: &[f64]) -> f64 {
    a.iter()
        .zip(b)
        .map(|(x, y)| (x - y).abs())
        .fold(0.0, f64::max)
}

#[test]
fn a_mass_on_a_cord_agrees_with_an_explicit_integration() {
    let t = time(300, 1.0 / 60.0);
    for (v, name) in [(ramp(&t, 0.006), "ramp"), (wave(&t), "wave")] {
        for (c, d) in [(1e-3, 0.5), (1e-3, 0.0), (5e-3, 2.0), (1e-4, 1.0)] {
            let law = LawKind::AsymmetricBristle
                .build(&BRISTLE, Some(HEIGHT))
                .expect("complete");
            let fine = explicit(&law, &t, &v, c, d, 0.2, 200);
            let ours = predicted(LawKind::AsymmetricBristle, &BRISTLE, &v, &t, c, d, 0.2);
            let error = largest(&ours, &fine);
            assert!(error < 2e-5, "{name}, C = {c}, d = {d}: {error:e} N");
        }
    }
}

/// From so many speed scales of the Stribeck curve to a stop and up again: the cord is stiff and damped, so that steps may be long.
#[test]
fn a_stop_on_a_cord_does_not_leap_over_the_stribeck_curve() {
    const LAW: [f64; 6] = [0.13, 0.218, 0.0138, 280.0, 0.31, 0.81];
    let law = LawKind::Lugre.build(&LAW, None).expect("complete");
    let t = time(1500, 1.0 / 500.0);
    let mut worst: f64 = 0.0;
    for half_scales in 2..=20 {
        let top = 0.5 * f64::from(half_scales) * LAW[2];
        let away = |t: f64| (t - 1.5).abs() / 1.0;
        let v: Vec<f64> = (t.iter())
            .map(|t| top * away(*t).min(t / 0.2).min(1.0))
            .collect();
        let fine = explicit(&law, &t, &v, 1e-6, 200.0, 0.01, 100);
        let ours = predicted(LawKind::Lugre, &LAW, &v, &t, 1e-6, 200.0, 0.01);
        worst = worst.max(largest(&ours, &fine) / (LOAD * LAW[0]));
    }
    // Between the stages of a step the record is read off the collocation polynomial.
    assert!(worst < 1e-3, "{worst} of the level");
}

#[test]
fn a_soft_cord_delays_the_start_and_a_stiff_one_is_the_rigid_chain() {
    let t = time(300, 1.0 / 60.0);
    let v = ramp(&t, 0.006);
    let rigid = predicted(LawKind::AsymmetricBristle, &BRISTLE, &v, &t, 0.0, 0.0, 0.2);
    let distance = |c: f64| {
        largest(
            &predicted(LawKind::AsymmetricBristle, &BRISTLE, &v, &t, c, 0.0, 0.0),
            &rigid,
        )
    };
    assert!(distance(1e-3) > 0.05);
    // without a mass the rigid chain is approached in proportion to the compliance
    let order = (distance(2e-6) / distance(1e-6)).log2();
    assert!((order - 1.0).abs() < 0.05, "order {order}");
    assert!(distance(1e-12) < 1e-5);
    let soft = predicted(LawKind::AsymmetricBristle, &BRISTLE, &v, &t, 5e-3, 0.0, 0.2);
    assert!(soft[60] < rigid[60]);
}

#[test]
fn the_steady_pull_of_a_cord_is_the_friction() {
    let t = time(2000, 0.01);
    let v = vec![0.02; t.len()];
    for (kind, p) in [
        (LawKind::AsymmetricBristle, &BRISTLE[..]),
        (LawKind::Lugre, &LUGRE[..]),
    ] {
        let law = kind.build(p, Some(HEIGHT)).expect("complete");
        let end = *predicted(kind, p, &v, &t, 2e-3, 1.0, 0.2)
            .last()
            .expect("samples");
        assert!(
            (end - LOAD * law.steady_coefficient(0.02)).abs() < 1e-6,
            "{}",
            kind.id()
        );
    }
}

#[test]
fn static_laws_slip_and_stick_on_a_cord_without_leaving_the_numbers() {
    let t = time(600, 1.0 / 60.0);
    for (kind, p) in [
        (LawKind::CoulombViscous, vec![0.4, 0.5]),
        (LawKind::Stribeck, vec![0.4, 0.6, 0.004, 0.5]),
        (LawKind::Dahl, vec![0.4, 400.0]),
    ] {
        for v in [ramp(&t, 0.006), wave(&t)] {
            for (c, d, m) in [(1e-3, 0.5, 0.2), (1e-2, 0.0, 0.2), (1e-5, 0.0, 0.2)] {
                // stick-slip swings the mass by at most the stage's speed about the largest friction
                let most = 1.3 * (LOAD * 0.65 + 0.06 * f64::sqrt(m / c));
                let f = predicted(kind, &p, &v, &t, c, d, m);
                assert!(
                    f.iter().all(|f| f.abs() < most),
                    "{} C = {c}: {:?}",
                    kind.id(),
                    f.iter()
                        .enumerate()
                        .find(|(_, f)| f.is_nan() || f.abs() >= most)
                );
            }
        }
    }
}

#[test]
fn a_cord_without_mass_has_a_derivative_at_the_null() {
    let t = time(300, 1.0 / 60.0);
    let experiment =
        Experiment::new(&campaign(vec![run(&t, wave(&t), Some(LOAD), 1)])).expect("moves");
    let spring = Box::new(Spring { mass_kg: 0.0 });
    let model = Model::new(LawKind::AsymmetricBristle, vec![spring], &experiment).expect("model");
    let p = |c: f64| [&BRISTLE[..], &[c, 0.0]].concat();
    let (_, jacobian) = model.predict_with_jacobian(&experiment, &p(0.0), Some(&[7]));
    let error = |e: f64| {
        let (near, far) = (
            model.predict(&experiment, &p(e)),
            model.predict(&experiment, &p(2.0 * e)),
        );
        let differences: Vec<f64> = near.iter().zip(&far).map(|(a, b)| (b - a) / e).collect();
        let whole: f64 = jacobian.column(0).norm();
        differences
            .iter()
            .zip(jacobian.column(0).iter())
            .map(|(a, b)| (a - b).powi(2))
            .sum::<f64>()
            .sqrt()
            / whole
    };
    let (coarse, fine) = (error(1e-4), error(1e-5));
    assert!(fine < 0.02 && fine < 0.3 * coarse, "{coarse} {fine}");
}

/// While the stage stands the specimen moves by nothing but rounding, and the sign of rounding must not decide on a slope.
#[test]
fn derivatives_outlast_a_stand_of_the_stage() {
    let t = time(600, 1.0 / 60.0);
    let v: Vec<f64> = (t.iter())
        .map(|&t| match t {
            t if t < 4.0 => 0.03 * (t / 0.5).min(1.0) * ((4.0 - t) / 0.1).min(1.0),
            t if t < 7.0 => 0.0,
            t => 0.02 * (t - 7.0).min(1.0),
        })
        .collect();
    let experiment = Experiment::new(&campaign(vec![run(&t, v, Some(LOAD), 1)])).expect("moves");
    let spring = || Box::new(Spring { mass_kg: 0.2 });
    let model = Model::new(LawKind::AsymmetricBristle, vec![spring()], &experiment).expect("model");
    let p = [&BRISTLE[..], &[7.6e-5, 190.0]].concat();
    let columns: Vec<usize> = (0..BRISTLE.len()).collect();
    let (_, jacobian) = model.predict_with_jacobian(&experiment, &p, Some(&columns));
    for k in columns {
        let step = 1e-3 * p[k].abs();
        let moved = |by: f64| {
            let mut p = p.clone();
            p[k] += by;
            model.predict(&experiment, &p)
        };
        let (less, more) = (moved(-step), moved(step));
        let differences: Vec<f64> = (less.iter().zip(&more))
            .map(|(a, b)| (b - a) / (2.0 * step))
            .collect();
        let column: Vec<f64> = jacobian.column(k).iter().copied().collect();
        let size = differences.iter().fold(0.0_f64, |a, x| a.max(x.abs()));
        let apart = largest(&column, &differences) / size;
        println!("parameter {k}: {apart:.1e}");
        assert!(apart < 5e-3, "parameter {k}: {apart}");
    }
}

#[test]
fn repeats_share_their_mechanics_and_runs_between_them_do_not() {
    let t = time(120, 1.0 / 60.0);
    let (slow, fast) = (ramp(&t, 0.006), ramp(&t, 0.012));
    let spring = || Box::new(Spring { mass_kg: 0.2 });
    let p = [&BRISTLE[..], &[1e-3, 0.5]].concat();
    let record = |velocities: &[&Vec<f64>]| {
        let runs = velocities
            .iter()
            .enumerate()
            .map(|(k, v)| run(&t, (*v).clone(), Some(LOAD), k + 1))
            .collect();
        let experiment = Experiment::new(&campaign(runs)).expect("moves");
        let model =
            Model::new(LawKind::AsymmetricBristle, vec![spring()], &experiment).expect("model");
        let twins: Vec<usize> = experiment.runs.iter().map(|run| run.twin).collect();
        (twins, model.predict(&experiment, &p))
    };
    let (twins, together) = record(&[&slow, &fast, &slow]);
    assert_eq!(twins, [0, 1, 0]);
    let (alone, other) = (record(&[&slow]).1, record(&[&fast]).1);
    let n = t.len();
    assert_eq!(together[..n], together[2 * n..]);
    assert!(largest(&together[2 * n..], &alone) < 1e-5);
    assert!(largest(&together[n..2 * n], &other) < 1e-5);
    assert!(largest(&alone, &other) > 1e-2);
}

#[test]
fn what_rings_far_faster_than_the_record_is_given_up_at_a_bounded_price() {
    let t = time(600, 1.0 / 60.0);
    let v = wave(&t);
    let experiment =
        Experiment::new(&campaign(vec![run(&t, v.clone(), Some(LOAD), 1)])).expect("moves");
    let force = |steps: usize, c: f64| {
        let spring = Box::new(Spring { mass_kg: 0.2 });
        let model = Model::new(LawKind::Stribeck, vec![spring], &experiment)
            .expect("model")
            .with_steps_a_sample(steps);
        model.predict(&experiment, &[0.4, 0.6, 0.004, 0.5, c, 0.0])
    };
    assert!(force(200, 1e-5).iter().all(|f| f.is_finite()));
    assert!(force(20, 1e-5).iter().all(|f| f.is_nan()));
    // a slow cord never comes near the price
    assert_eq!(force(20, 1e-2), force(200, 1e-2));
}

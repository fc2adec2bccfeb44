//! The specimen on a cord: against a fine explicit integration of the same mechanics, and its limits.

mod campaigns;

use campaigns::{BRISTLE, HEIGHT, LUGRE, Spring, campaign, ramp, run, time, wave};
use friction::{Drive, Law, LawKind, ParameterSpec, Scalar};
use rig::{Cause, Coupling, Experiment, Model, Place, Reach, Station};

const LOAD: f64 = 2.0;

/// A cord of any stiffness, whose tension bends with h.
#[derive(Clone, Copy, Debug)]
struct BentCord {
    mass_kg: f64,
}

const BENT_CORD: &[ParameterSpec] = &[
    ParameterSpec::new("compliance_m_n", "m/N", "compliance", 0.0, 1.0, 1e-3),
    ParameterSpec::new("damping_n_s_m", "N s/m", "damping", 0.0, 1e3, 1.0),
    ParameterSpec::new("hardening_1_n2", "1/N^2", "hardening", -1.0, 1e3, 0.0),
];

impl Cause for BentCord {
    fn id(&self) -> &'static str {
        "bent-cord"
    }

    fn station(&self) -> Station {
        Station::Coupling
    }

    fn reach(&self) -> Reach {
        Reach::Coupling
    }

    fn describe(&self) -> &'static str {
        "A cord whose stiffness changes with its tension holds the specimen."
    }

    fn parameters(&self) -> &'static [ParameterSpec] {
        BENT_CORD
    }

    fn coupling<D: Scalar>(&self, p: &[D], at: Place<'_>, coupling: &mut Coupling<D>) {
        let spring = Spring {
            mass_kg: self.mass_kg,
        };
        spring.coupling(p, at, coupling);
        coupling.hardening = p[2];
    }
}

/// Numbers of a cord: C, d, m, and the stretch L at which its stiffness has doubled.
#[derive(Clone, Copy)]
struct Cord {
    c: f64,
    d: f64,
    m: f64,
    doubling_m: f64,
}

impl Cord {
    fn straight(c: f64, d: f64, m: f64) -> Self {
        let doubling_m = f64::INFINITY;
        Self {
            c,
            d,
            m,
            doubling_m,
        }
    }

    /// Tension at a stretch x that grows by u: x/C (1 + (x/L)^2/3) + d u.
    fn tension(&self, x: f64, u: f64) -> f64 {
        x / self.c * (1.0 + (x / self.doubling_m).powi(2) / 3.0) + self.d * u
    }

    /// h of the same cord: (x/L)^2 = h w^2 with x = C w.
    fn hardening(&self) -> f64 {
        (self.c / self.doubling_m).powi(2)
    }
}

/// z' = f, x' = u, m u' = N mu(z, V - u) - T(x, u) by classical Runge-Kutta with `n` steps between samples.
fn explicit(law: &Law<f64>, t: &[f64], v: &[f64], cord: Cord, n: usize) -> Vec<f64> {
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
                    (friction - cord.tension(y[1], y[2])) / cord.m,
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
        out.push(cord.tension(y[1], y[2]));
    }
    out
}

fn predicted(kind: LawKind, law: &[f64], v: &[f64], t: &[f64], cord: Cord) -> Vec<f64> {
    let experiment =
        Experiment::new(&campaign(vec![run(t, v.to_vec(), Some(LOAD), 1)])).expect("moves");
    let model = Model::new(
        kind,
        vec![Box::new(BentCord { mass_kg: cord.m })],
        &experiment,
    )
    .expect("model");
    model.predict(
        &experiment,
        &[law, &[cord.c, cord.d, cord.hardening()]].concat(),
    )
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
            let fine = explicit(&law, &t, &v, Cord::straight(c, d, 0.2), 200);
            let ours = predicted(
                LawKind::AsymmetricBristle,
                &BRISTLE,
                &v,
                &t,
                Cord::straight(c, d, 0.2),
            );
            let error = largest(&ours, &fine);
            assert!(error < 2e-5, "{name}, C = {c}, d = {d}: {error:e} N");
        }
    }
}

/// A cord that hardens: its tension is that of the same mechanics in the stretch itself.
#[test]
fn a_cord_that_hardens_agrees_with_an_explicit_integration() {
    let t = time(300, 1.0 / 60.0);
    let law = LawKind::AsymmetricBristle
        .build(&BRISTLE, Some(HEIGHT))
        .expect("complete");
    for (v, name) in [(ramp(&t, 0.006), "ramp"), (wave(&t), "wave")] {
        for (c, d, doubling_m) in [(1e-3, 0.5, 1e-3), (5e-3, 2.0, 2e-3), (5e-3, 0.2, 8e-3)] {
            let cord = Cord {
                doubling_m,
                ..Cord::straight(c, d, 0.2)
            };
            let ours = |cord| predicted(LawKind::AsymmetricBristle, &BRISTLE, &v, &t, cord);
            let error = largest(&ours(cord), &explicit(&law, &t, &v, cord, 200));
            assert!(error < 2e-5, "{name}, C = {c}, d = {d}: {error:e} N");
            // What hardening does is far more than that.
            let bend = largest(&ours(cord), &ours(Cord::straight(c, d, 0.2)));
            assert!(bend > 1e-3, "{name}, C = {c}: {bend:e} N");
        }
    }
}

#[test]
fn derivatives_by_hardening_are_those_of_differences() {
    let t = time(300, 1.0 / 60.0);
    let moving = campaign(vec![run(&t, wave(&t), Some(LOAD), 1)]);
    let experiment = Experiment::new(&moving).expect("moves");
    let cord = Box::new(BentCord { mass_kg: 0.2 });
    let model = Model::new(LawKind::AsymmetricBristle, vec![cord], &experiment).expect("model");
    let p = |h: f64| [&BRISTLE[..], &[5e-3, 0.5, h]].concat();
    // Straight, hardening and softening.
    for h in [0.0, 2.0, -0.05] {
        let column = BRISTLE.len() + 2;
        let (_, jacobian) = model.predict_with_jacobian(&experiment, &p(h), Some(&[column]));
        let off = |by: f64| model.predict(&experiment, &p(h + by));
        let by = 1e-3;
        let differences = off(by).into_iter().zip(off(-by));
        let differences: Vec<f64> = differences.map(|(a, b)| (a - b) / (2.0 * by)).collect();
        let exact = jacobian.column(0);
        let apart = largest(&differences, exact.as_slice()) / exact.amax();
        assert!(exact.amax() > 1e-3 && apart < 2e-3, "h = {h}: {apart:e}");
    }
}

/// Compliance for small swings about a tension: that of the tension's own slope.
#[test]
fn a_tense_cord_swings_as_its_slope_says() {
    let cord = Cord {
        doubling_m: 2e-3,
        ..Cord::straight(1e-3, 0.0, 0.2)
    };
    let coupling = Coupling {
        compliance: cord.c,
        damping: cord.d,
        mass: cord.m,
        hardening: cord.hardening(),
    };
    for x in [0.0, 1e-3, 5e-3] {
        let slope = (cord.tension(x + 1e-9, 0.0) - cord.tension(x - 1e-9, 0.0)) / 2e-9;
        let ours = coupling.compliance_at(cord.tension(x, 0.0));
        assert!((ours * slope - 1.0).abs() < 1e-5, "{ours} {slope}");
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
        let fine = explicit(&law, &t, &v, Cord::straight(1e-6, 200.0, 0.01), 100);
        let ours = predicted(
            LawKind::Lugre,
            &LAW,
            &v,
            &t,
            Cord::straight(1e-6, 200.0, 0.01),
        );
        worst = worst.max(largest(&ours, &fine) / (LOAD * LAW[0]));
    }
    // Between the stages of a step the record is read off the collocation polynomial.
    assert!(worst < 1e-3, "{worst} of the level");
}

#[test]
fn a_soft_cord_delays_the_start_and_a_stiff_one_is_the_rigid_chain() {
    let t = time(300, 1.0 / 60.0);
    let v = ramp(&t, 0.006);
    let rigid = predicted(
        LawKind::AsymmetricBristle,
        &BRISTLE,
        &v,
        &t,
        Cord::straight(0.0, 0.0, 0.2),
    );
    let distance = |c: f64| {
        largest(
            &predicted(
                LawKind::AsymmetricBristle,
                &BRISTLE,
                &v,
                &t,
                Cord::straight(c, 0.0, 0.0),
            ),
            &rigid,
        )
    };
    assert!(distance(1e-3) > 0.05);
    // without a mass the rigid chain is approached in proportion to the compliance
    let order = (distance(2e-6) / distance(1e-6)).log2();
    assert!((order - 1.0).abs() < 0.05, "order {order}");
    assert!(distance(1e-12) < 1e-5);
    let soft = predicted(
        LawKind::AsymmetricBristle,
        &BRISTLE,
        &v,
        &t,
        Cord::straight(5e-3, 0.0, 0.2),
    );
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
        let end = *predicted(kind, p, &v, &t, Cord::straight(2e-3, 1.0, 0.2))
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
                let f = predicted(kind, &p, &v, &t, Cord::straight(c, d, m));
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

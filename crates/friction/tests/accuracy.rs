//! Accuracy of the integration: against closed forms and a fine classical method, orders by slope, stiff corners,
//! derivatives by Taylor ratios.

use friction::{Drive, Exponent, Law, LawKind, Record, Scalar, integrate, linear_stretches};
use num_dual::DualSVec64;

const BRISTLE: [f64; 7] = [0.5, 0.62, 1.5, 0.1, 0.01, 1.5, -0.3];
const HEIGHT: f64 = 7e-3;

fn states<D: Scalar>(
    law: &Law<D>,
    time: &[f64],
    velocity: &[D],
    knots: &[usize],
    initial: f64,
) -> Vec<D> {
    let record = Record::of_slip(time, velocity, knots);
    integrate(law, &record, D::constant(initial)).expect("finite")
}

/// An independent second path: classical Runge-Kutta with `n` steps between samples, v linear between them.
fn runge_kutta(law: &Law<f64>, time: &[f64], velocity: &[f64], initial: f64, n: usize) -> Vec<f64> {
    let mut z = initial;
    let mut out = vec![z];
    for i in 1..time.len() {
        let (dt, dv) = (time[i] - time[i - 1], velocity[i] - velocity[i - 1]);
        let h = dt / n as f64;
        for k in 0..n {
            let rate = |s: f64, z: f64| {
                law.state_rate(
                    z,
                    &Drive::at(velocity[i - 1] + dv * (k as f64 + s) / n as f64),
                )
            };
            let k1 = rate(0.0, z);
            let k2 = rate(0.5, z + 0.5 * h * k1);
            let k3 = rate(0.5, z + 0.5 * h * k2);
            let k4 = rate(1.0, z + h * k3);
            z += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
        }
        out.push(z);
    }
    out
}

fn largest(a: &[f64], b: &[f64]) -> f64 {
    a.iter()
        .zip(b)
        .map(|(x, y)| (x - y).abs())
        .fold(0.0, f64::max)
}

/// A body that is moved back and forth at many times the Stribeck speed is within its curve for a moment only, at every turn.
#[test]
fn a_fast_reversal_does_not_leap_over_the_stribeck_curve() {
    for (kind, parameters) in [
        (
            LawKind::Lugre,
            vec![13.0, 18.5, 0.0175, 25_900.0, 150.0, 12.0],
        ),
        (
            LawKind::LugreTyre,
            vec![13.0, 18.5, 0.0175, 25_900.0, 150.0, 12.0],
        ),
        (LawKind::Lugre, vec![0.3, 0.4, 1e-4, 1e4, 10.0, 0.1]),
    ] {
        let law = kind.build(&parameters, None).expect("a law");
        let time: Vec<f64> = (0..301).map(|i| 0.005 * f64::from(i)).collect();
        // Up to 0.48 m/s, through zero to -0.48 m/s, and back to rest: three straight lines.
        let velocity: Vec<f64> = time
            .iter()
            .map(|t| {
                let phase = t / 1.5 * 4.0;
                let wave = if phase < 1.0 {
                    phase
                } else if phase < 3.0 {
                    2.0 - phase
                } else {
                    phase - 4.0
                };
                0.48 * wave
            })
            .collect();
        let knots = linear_stretches(&time, &velocity, 1e-12);
        let level = parameters[0] / parameters[3];
        let ours = states(&law, &time, &velocity, &knots, 0.0);
        let theirs = runge_kutta(&law, &time, &velocity, 0.0, 2_000);
        let error = largest(&ours, &theirs) / level;
        assert!(error < 1e-5, "{kind:?}: {error} of the level");
    }
}

/// A step to a stop meets the curve's peak although nothing moves at its end: from so many speed scales to rest and up again within
/// `ramp_s`, with flat and steep curves.
#[test]
fn a_stop_does_not_leap_over_the_stribeck_curve() {
    const SCALE_M_S: f64 = 0.0138;
    let mut worst: f64 = 0.0;
    for exponent in [1.0, 2.0, 2.5, 4.4] {
        let parameters = [0.13, 0.218, SCALE_M_S, 280.0, 0.31, 0.81];
        let mut law = LawKind::Lugre.build(&parameters, None).expect("a law");
        law.curve.exponent = Exponent::General(exponent);
        for ramp_s in [0.03, 0.14, 1.0] {
            for half_scales in 1..=40 {
                let top = 0.5 * f64::from(half_scales) * SCALE_M_S;
                let time: Vec<f64> = (0..=300).map(|i| ramp_s * f64::from(i) / 100.0).collect();
                let velocity: Vec<f64> = (time.iter())
                    .map(|t| top * (1.0 - t / ramp_s).abs().min(1.0))
                    .collect();
                let knots = linear_stretches(&time, &velocity, 1e-12);
                let level = parameters[0] / parameters[3];
                let ours = states(&law, &time, &velocity, &knots, level);
                let theirs = runge_kutta(&law, &time, &velocity, level, 40);
                worst = worst.max(largest(&ours, &theirs) / level);
            }
        }
    }
    assert!(worst < 1e-4, "{worst} of the level");
}

#[test]
fn a_ramp_agrees_with_a_fine_classical_method_in_every_reported_digit() {
    let time: Vec<f64> = (0..600).map(|i| f64::from(i) / 60.0).collect();
    for (sign, lean) in [(1.0, -0.3), (-1.0, -0.3), (1.0, 0.0), (-1.0, 0.8)] {
        let mut p = BRISTLE;
        p[6] = lean;
        let law = LawKind::AsymmetricBristle
            .build(&p, Some(HEIGHT))
            .expect("complete");
        let velocity: Vec<f64> = time.iter().map(|t| sign * 0.006 * t).collect();
        let knots = linear_stretches(&time, &velocity, 1e-12);
        let fine = runge_kutta(&law, &time, &velocity, 0.0, 8);
        let ours = states(&law, &time, &velocity, &knots, 0.0);
        assert!(largest(&ours, &fine) < 1e-7, "{}", largest(&ours, &fine));
        let every: Vec<usize> = (0..600).collect();
        assert!(largest(&states(&law, &time, &velocity, &every, 0.0), &fine) < 1e-9);
    }
}

#[test]
fn reversals_inside_a_sample_are_split() {
    // coarse samples: the sign changes between them
    let time: Vec<f64> = (0..80).map(|i| f64::from(i) * 0.1).collect();
    let velocity: Vec<f64> = time.iter().map(|t| 0.03 * (2.3 * t + 0.2).sin()).collect();
    let law = LawKind::AsymmetricBristle
        .build(&BRISTLE, Some(HEIGHT))
        .expect("complete");
    let knots: Vec<usize> = (0..time.len()).collect();
    let ours = states(&law, &time, &velocity, &knots, 0.0);
    assert!(largest(&ours, &runge_kutta(&law, &time, &velocity, 0.0, 4000)) < 2e-7);
}

#[test]
fn error_falls_with_the_fifth_power_of_the_step() {
    // knots at every m-th sample of a ramp force steps of m samples where the estimate would allow more
    let law = LawKind::Lugre
        .build(&[0.4, 0.4, 0.01, 1.0, 0.0, 0.0], None)
        .expect("complete");
    // constant level: z' = v - v z/g, v = a t + b: closed form through s = integral of v
    let error = |n: usize| {
        let time: Vec<f64> = (0..=n).map(|i| i as f64 / n as f64).collect();
        let velocity: Vec<f64> = time.iter().map(|t| 1.0 + t).collect();
        let knots: Vec<usize> = (0..=n).collect();
        let z = *states(&law, &time, &velocity, &knots, 0.0)
            .last()
            .expect("samples");
        (z - 0.4 * (1.0 - (-1.5_f64 / 0.4).exp())).abs()
    };
    // at these sizes every step is the sample interval itself
    let (coarse, fine) = (error(24), error(48));
    let order = (coarse / fine).log2();
    assert!(
        (order - 5.0).abs() < 0.3,
        "order {order}, errors {coarse:e} {fine:e}"
    );
}

#[test]
fn stiff_corners_of_the_bounds_stay_stable() {
    let time: Vec<f64> = (0..600).map(|i| f64::from(i) / 60.0).collect();
    let velocity: Vec<f64> = time.iter().map(|t| 0.06 * (1.1 * t).sin()).collect();
    let knots: Vec<usize> = (0..600).collect();
    for stiffness in [1e3, 1e5, 1e8] {
        let law = LawKind::Lugre
            .build(&[0.4, 0.5, 0.01, stiffness, 0.0, 0.0], None)
            .expect("complete");
        let z = states(&law, &time, &velocity, &knots, 0.0);
        assert!(
            z.iter()
                .all(|z| (z * stiffness).abs() <= 0.5 * (1.0 + 1e-6)),
            "sigma0 = {stiffness}"
        );
    }
    for lean in [-1.3, 0.0, 1.3] {
        for level in [1e-3, 0.3, 3.0] {
            let p = [level, 1.2 * level, 1.0, 0.0, 0.0, 1e-3, lean];
            let law = LawKind::AsymmetricBristle
                .build(&p, Some(HEIGHT))
                .expect("complete");
            let z = states(&law, &time, &velocity, &knots, 0.0);
            assert!(
                z.iter()
                    .all(|z| z.is_finite() && z.abs() <= 1.2 * level * (1.0 + 1e-6)),
                "{lean} {level}"
            );
        }
    }
}

#[test]
fn a_closed_form_holds_where_relaxation_is_far_faster_than_the_samples() {
    // z' = v - sigma0 abs(v) z/mu_c, v = 0.01: mu after one sample is mu_c to rounding when sigma0 v dt/mu_c >> 1
    let time: Vec<f64> = (0..40).map(|i| f64::from(i) * 0.02).collect();
    let velocity = vec![0.01; 40];
    let every: Vec<usize> = (0..40).collect();
    for stiffness in [1e3, 1e4, 1e6] {
        let law = LawKind::Dahl
            .build(&[0.4, stiffness], None)
            .expect("complete");
        for (t, z) in time.iter().zip(states(&law, &time, &velocity, &every, 0.0)) {
            let exact = 0.4 * (1.0 - (-stiffness * 0.01 * t / 0.4).exp());
            assert!(
                (z * stiffness - exact).abs() < 2e-7,
                "sigma0 {stiffness}, t {t}"
            );
        }
    }
}

fn coefficients<D: Scalar>(
    kind: LawKind,
    p: &[D],
    time: &[f64],
    velocity: &[f64],
    knots: &[usize],
) -> Vec<D> {
    let law = kind.build(p, Some(HEIGHT)).expect("complete");
    let velocity: Vec<D> = velocity.iter().map(|&v| D::constant(v)).collect();
    let z = states(&law, time, &velocity, knots, 0.0);
    z.iter()
        .zip(&velocity)
        .map(|(&z, &v)| law.coefficient(z, &Drive::at(v)))
        .collect()
}

#[test]
fn derivatives_pass_the_taylor_test_for_every_law_and_parameter() {
    let time: Vec<f64> = (0..300).map(|i| f64::from(i) * 0.03).collect();
    let wave: Vec<f64> = time.iter().map(|t| 0.03 * (0.9 * t).sin()).collect();
    let ramp: Vec<f64> = time.iter().map(|t| 0.006 * t).collect();
    for kind in LawKind::ALL {
        let p: Vec<f64> = match kind {
            LawKind::AsymmetricBristle => BRISTLE.to_vec(),
            LawKind::SymmetricBristle => BRISTLE[..6].to_vec(),
            LawKind::Dahl => vec![0.4, 250.0],
            LawKind::CoulombViscous => vec![0.4, 0.6],
            LawKind::Stribeck => vec![0.4, 0.55, 0.008, 0.6],
            LawKind::Lugre | LawKind::LugreTyre => vec![0.4, 0.55, 0.008, 250.0, 0.4, 0.6],
        };
        for velocity in [&ramp, &wave] {
            let knots = linear_stretches(&time, velocity, 1e-12);
            for k in 0..p.len() {
                let mut seeded: Vec<DualSVec64<1>> =
                    p.iter().map(|&x| DualSVec64::from_re(x)).collect();
                seeded[k] = seeded[k].derivative(0);
                let dual = coefficients(kind, &seeded, &time, velocity, &knots);
                let slope: Vec<f64> = dual.iter().map(|d| d.eps.0.map_or(0.0, |e| e[0])).collect();
                let value = coefficients(kind, &p, &time, velocity, &knots);
                for (d, v) in dual.iter().zip(&value) {
                    let apart = (d.re - v).abs();
                    assert!(
                        apart < 1e-12 * (1.0 + v.abs()),
                        "{} {k}: {apart:e}",
                        kind.id()
                    );
                }
                let remainder = |e: f64| {
                    let mut moved = p.clone();
                    moved[k] += e * p[k];
                    let f = coefficients(kind, &moved, &time, velocity, &knots);
                    (0..f.len())
                        .map(|i| (f[i] - value[i] - e * p[k] * slope[i]).powi(2))
                        .sum::<f64>()
                        .sqrt()
                };
                let size = slope.iter().map(|s| (p[k] * s).powi(2)).sum::<f64>().sqrt();
                assert!(size > 1e-4, "{} {k}: nothing to compare", kind.id());
                if remainder(0.02) < 1e-7 * size {
                    continue; // linear parameter: no second-order term
                }
                let ratio = remainder(0.02) / remainder(0.01);
                assert!(
                    (3.4..4.8).contains(&ratio),
                    "{} parameter {k}: ratio {ratio}",
                    kind.id()
                );
            }
        }
    }
}

#[test]
fn values_do_not_depend_on_what_is_differentiated() {
    let time: Vec<f64> = (0..300).map(|i| f64::from(i) * 0.03).collect();
    let ramp: Vec<f64> = time.iter().map(|t| 0.006 * t).collect();
    let knots = linear_stretches(&time, &ramp, 1e-12);
    let seeded: Vec<DualSVec64<8>> = BRISTLE
        .iter()
        .enumerate()
        .map(|(i, &x)| DualSVec64::from_re(x).derivative(i))
        .collect();
    let dual = coefficients(LawKind::AsymmetricBristle, &seeded, &time, &ramp, &knots);
    let value = coefficients(LawKind::AsymmetricBristle, &BRISTLE, &time, &ramp, &knots);
    assert!(
        dual.iter()
            .zip(&value)
            .all(|(d, v)| (d.re - v).abs() <= 4.0 * f64::EPSILON * v.abs())
    );
}

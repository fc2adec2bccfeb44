//! Exact limits of the laws: theta0 = 0, small rotation, steady state, exchange of direction, the redundant ray.

use friction::{
    CosinePlacement, Drive, Exponent, Law, LawKind, Record, SIGN_WIDTH, integrate,
    linear_stretches, paper_form,
};

/// Round numbers, no published value.
const BRISTLE: [f64; 7] = [0.5, 0.62, 1.5, 0.1, 0.01, 1.5, -0.3];
const LUGRE: [f64; 6] = [0.4, 0.55, 0.008, 250.0, 0.4, 0.6];
const HEIGHT: f64 = 7e-3;

fn time() -> Vec<f64> {
    (0..400).map(|i| f64::from(i) * 0.02).collect()
}

/// A motion with rests, reversals and two speeds of change.
fn motion() -> Vec<f64> {
    time()
        .iter()
        .map(|t| 0.03 * (0.9 * t).sin() + 0.01 * (4.0 * t).sin() * (0.9 * t).sin())
        .collect()
}

fn coefficients(law: &Law<f64>, velocity: &[f64], initial: f64) -> Vec<f64> {
    let time = time();
    let knots: Vec<usize> = (0..time.len()).collect();
    let record = Record::of_slip(&time, velocity, &knots);
    let states = integrate(law, &record, initial).expect("finite");
    states
        .iter()
        .zip(velocity)
        .map(|(&z, &v)| law.coefficient(z, &Drive::at(v)))
        .collect()
}

fn bristle(parameters: &[f64; 7]) -> Law<f64> {
    LawKind::AsymmetricBristle
        .build(parameters, Some(HEIGHT))
        .expect("complete")
}

#[test]
fn no_lean_is_the_symmetric_law_bit_for_bit() {
    let mut upright = BRISTLE;
    upright[6] = 0.0;
    let asymmetric = coefficients(&bristle(&upright), &motion(), 0.0);
    let symmetric = LawKind::SymmetricBristle
        .build(&upright[..6], Some(HEIGHT))
        .expect("complete");
    assert_eq!(asymmetric, coefficients(&symmetric, &motion(), 0.0));
}

#[test]
fn small_rotation_is_lugre_with_an_error_of_second_order() {
    // levels e, stiffness 1/e: the friction stays, the rotation shrinks; LuGre in z = h theta is the limit
    let difference = |e: f64| {
        let p = [0.5 * e, 0.62 * e, 1.5 / e, 0.1, 0.01, 1.5];
        let upright = LawKind::SymmetricBristle
            .build(&p, Some(HEIGHT))
            .expect("complete");
        let lugre = LawKind::Lugre
            .build(
                &[
                    0.75,
                    0.93,
                    1.5 * HEIGHT,
                    1.5 / e / HEIGHT,
                    0.1 / HEIGHT,
                    0.01 / HEIGHT,
                ],
                None,
            )
            .expect("complete");
        let (a, b) = (
            coefficients(&upright, &motion(), 0.0),
            coefficients(&lugre, &motion(), 0.0),
        );
        a.iter()
            .zip(&b)
            .map(|(x, y)| (x - y).abs())
            .fold(0.0, f64::max)
    };
    let (coarse, fine) = (difference(0.1), difference(0.05));
    assert!(coarse > 1e-4, "{coarse}");
    let order = (coarse / fine).log2();
    assert!((order - 2.0).abs() < 0.15, "order {order}");
}

#[test]
fn steady_state_is_the_level_of_the_curve() {
    let law = bristle(&BRISTLE);
    for v in [1e-4, 1e-3, 5e-3, 0.02, 0.06, -1e-3, -0.02, -0.06] {
        let theta: f64 = law.steady_state(v);
        // z = sgn(v) g(w)/sigma, w = v/h cos^2(theta + theta0), g with exponent two: written out independently
        let w = v.abs() / HEIGHT * (theta + BRISTLE[6]).cos().powi(2);
        let level = BRISTLE[0] + (BRISTLE[1] - BRISTLE[0]) * (-(w / BRISTLE[5]).powi(2)).exp();
        assert!((theta - v.signum() * level).abs() < 1e-13, "v = {v}");
        assert!(law.state_rate(theta, &Drive::at(v)).abs() < 1e-10);
        // and it is where a long slide ends
        let time = time();
        let knots = [0, time.len() - 1];
        let slow = time.iter().map(|t| t * 10.0).collect::<Vec<_>>();
        let velocity = vec![v; time.len()];
        let record = Record::of_slip(
            if v.abs() < 0.05 { &slow } else { &time },
            &velocity,
            &knots,
        );
        let end = *integrate(&law, &record, 0.0)
            .expect("finite")
            .last()
            .expect("samples");
        if v.abs() >= 5e-3 {
            assert!((end - theta).abs() < 1e-7, "v = {v}: {end} {theta}");
        }
        let mu = law.steady_coefficient(v);
        let by_hand = (BRISTLE[2] * theta
            + BRISTLE[4] * v / HEIGHT * (theta + BRISTLE[6]).cos().powi(2))
            * (theta + BRISTLE[6]).cos().powi(2);
        assert!((mu - by_hand).abs() < 1e-12);
    }
}

#[test]
fn direction_and_sign_of_the_lean_exchange() {
    let mut mirrored = BRISTLE;
    mirrored[6] = -mirrored[6];
    let reversed: Vec<f64> = motion().iter().map(|v| -v).collect();
    let here = coefficients(&bristle(&BRISTLE), &motion(), 0.1);
    let there = coefficients(&bristle(&mirrored), &reversed, -0.1);
    assert!(here.iter().zip(&there).all(|(a, b)| (a + b).abs() < 1e-12));
    // while the same law driven the other way differs: the lean alone makes friction directional
    let other = coefficients(&bristle(&BRISTLE), &reversed, -0.1);
    assert!(here.iter().zip(&other).any(|(a, b)| (a + b).abs() > 0.1));
    for kind in LawKind::ALL {
        let p: Vec<f64> = kind.parameters().iter().map(|s| s.typical).collect();
        let law = kind.build(&p, Some(HEIGHT)).expect("complete");
        let odd = (law.steady_coefficient(0.02) + law.steady_coefficient(-0.02)).abs();
        assert_eq!(odd > 1e-9, kind.is_directional(), "{}", kind.id());
    }
}

#[test]
fn the_papers_three_numbers_are_one_too_many() {
    let paper = [200.0, 1.5, 0.1, 0.01, 100.0, 124.0, 1.5, -0.3];
    let scaled = [
        paper[0] * 3.7,
        1.5,
        0.1,
        0.01,
        paper[4] * 3.7,
        paper[5] * 3.7,
        1.5,
        -0.3,
    ];
    let a = coefficients(&bristle(&paper_form::identifiable(&paper)), &motion(), 0.0);
    let b = coefficients(&bristle(&paper_form::identifiable(&scaled)), &motion(), 0.0);
    assert!(a.iter().zip(&b).all(|(x, y)| (x - y).abs() < 1e-12));
}

#[test]
fn placements_differ_by_the_cosine_on_the_losses() {
    let law = bristle(&BRISTLE);
    let only = law.with_placement(CosinePlacement::StiffnessOnly);
    let (theta, drive) = (0.2, Drive::at(0.03));
    let c = (theta + BRISTLE[6]).cos().powi(2);
    let losses = BRISTLE[3] * law.state_rate(theta, &drive) + BRISTLE[4] * 0.03 / HEIGHT * c;
    let difference = only.coefficient(theta, &drive) - law.coefficient(theta, &drive);
    assert!((difference - losses * (1.0 - c)).abs() < 1e-14);
}

#[test]
fn exponent_two_has_a_branch_of_its_own_next_to_the_general_one() {
    let two = LawKind::Lugre.build(&LUGRE, None).expect("complete");
    let general = two.with_exponent(Exponent::General(2.0));
    let rate = |law: &Law<f64>, v: f64| law.state_rate(5e-4, &Drive::at(v));
    assert_eq!(rate(&two, 0.0), rate(&general, 0.0));
    assert!((rate(&two, 0.004) / rate(&general, 0.004) - 1.0).abs() < 1e-14);
    assert!(
        (rate(&two, 0.004) / rate(&two.with_exponent(Exponent::General(2.2)), 0.004) - 1.0).abs()
            > 1e-3
    );
}

#[test]
fn dahl_closes_its_hysteresis_as_its_author_wrote_it() {
    // constant v from rest: mu = mu_c (1 - exp(-sigma0 v t/mu_c)); P. R. Dahl, AIAA Journal 14 (1976), exponent one
    let law = LawKind::Dahl.build(&[0.4, 250.0], None).expect("complete");
    let velocity = vec![0.01; time().len()];
    for (t, mu) in time().iter().zip(coefficients(&law, &velocity, 0.0)) {
        let exact = 0.4 * (1.0 - (-250.0 * 0.01 * t / 0.4).exp());
        assert!((mu - exact).abs() < 1e-8, "t = {t}");
    }
}

#[test]
fn static_laws_reach_their_level_at_the_stated_width() {
    let law = LawKind::Stribeck
        .build(&[0.4, 0.55, 0.008, 0.6], None)
        .expect("complete");
    let at = |v: f64| law.coefficient(0.0, &Drive::at(v));
    assert_eq!(at(0.0), 0.0);
    assert!((at(SIGN_WIDTH) / 0.55 - 1.0_f64.tanh()).abs() < 1e-3);
    let exact = 0.4 + 0.15 * (-(0.01_f64 / 0.008).powi(2)).exp() + 0.6 * 0.01;
    assert!((at(0.01) - exact).abs() < 1e-12 && (at(-0.01) + exact).abs() < 1e-12);
}

#[test]
fn stretches_are_found_where_velocity_is_linear() {
    let t = time();
    let ramp: Vec<f64> = t.iter().map(|t| 0.006 * t).collect();
    assert_eq!(linear_stretches(&t, &ramp, 1e-12), vec![0, t.len() - 1]);
    let tent: Vec<f64> = t.iter().map(|t| 0.01 - (t - 4.0).abs() * 1e-3).collect();
    assert_eq!(
        linear_stretches(&t, &tent, 1e-12),
        vec![0, 200, t.len() - 1]
    );
    let knots = linear_stretches(&t, &motion(), 1e-5);
    for pair in knots.windows(2) {
        for i in pair[0]..=pair[1] {
            let share = (t[i] - t[pair[0]]) / (t[pair[1]] - t[pair[0]]);
            let chord = motion()[pair[0]] * (1.0 - share) + motion()[pair[1]] * share;
            assert!((chord - motion()[i]).abs() < 2e-5);
        }
    }
}

#[test]
fn unknown_and_incomplete_laws_are_refused_by_name() {
    assert!(
        LawKind::from_id("lugree")
            .unwrap_err()
            .to_string()
            .contains("lugree")
    );
    assert!(
        LawKind::ALL
            .iter()
            .all(|k| LawKind::from_id(k.id()) == Ok(*k))
    );
    assert!(
        LawKind::AsymmetricBristle
            .build(&BRISTLE, None)
            .unwrap_err()
            .to_string()
            .contains("contact_height_mm")
    );
    assert!(
        LawKind::Lugre
            .build(&[1.0], None)
            .unwrap_err()
            .to_string()
            .contains("6 parameters, 1")
    );
    assert!(LawKind::Dahl.check(&[f64::NAN, 1.0]).is_err());
}

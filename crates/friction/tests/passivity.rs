//! Passivity: the work that sliding feeds in is at least what the bristles store, h sigma0 z^2/2 per unit of load.
//!
//! Power per load is mu v. For bristles v = w h/cos^2, so (all terms of E7 geared alike) mu v = h (sigma0 z + sigma1 z' +
//! sigma2 w) w with w = z' + abs(w) z/g. The elastic part stores or loses for every lean and every g > 0. With losses the
//! rate of loss is the quadratic form sigma1 z'^2 + sigma1 abs(w) z z'/g + sigma0 abs(w) z^2/g (+ sigma2 w^2), which is
//! never negative while sigma1 <= 4 sigma0 g/abs(w), the condition of Barabanov and Ortega (IEEE Trans. Automatic Control
//! 45, 2000) for LuGre. Beyond that speed LuGre and the leaning law alike can give energy back: the leaning law is not
//! passive there. In terms of the slip speed the bound is sigma1 <= 4 sigma0 g h/(abs(v) cos^2); with the cosine on the
//! stiffness term alone the factor 1/cos^2 is lost.

use friction::{CosinePlacement, Drive, Law, LawKind, Record, integrate};
use proptest::prelude::*;

const HEIGHT: f64 = 7e-3;

/// Work fed in per unit of load by the elastic part of mu, along a motion of many fine samples.
fn elastic_work(law: &Law<f64>, amplitudes: &[f64], initial: f64) -> (f64, f64, f64) {
    let n = 4000;
    let time: Vec<f64> = (0..n).map(|i| f64::from(i) * 1e-3).collect();
    let velocity: Vec<f64> = time
        .iter()
        .map(|t| {
            amplitudes
                .iter()
                .zip([1.7, 4.1, 9.3])
                .map(|(a, f)| a * (f * t).sin())
                .sum()
        })
        .collect();
    let knots: Vec<usize> = (0..time.len()).collect();
    let record = Record::of_slip(&time, &velocity, &knots);
    let states = integrate(law, &record, initial).expect("finite");
    let mut elastic = *law;
    (elastic.damping, elastic.viscous) = (0.0, 0.0);
    let power: Vec<f64> = states
        .iter()
        .zip(&velocity)
        .map(|(&z, &v)| elastic.coefficient(z, &Drive::at(v)) * v)
        .collect();
    let work = power.windows(2).map(|w| 0.5e-3 * (w[0] + w[1])).sum();
    (work, states[0], states[states.len() - 1])
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn lugre_stores_no_more_than_it_is_fed(
        a in prop::array::uniform3(-0.05..0.05_f64), start in -1.0..1.0_f64, ratio in 1.0..2.0_f64,
    ) {
        // storage sigma0 z^2/2; holds for any g > 0, the falling Stribeck curve included
        let law = LawKind::Lugre.build(&[0.4, 0.4 * ratio, 0.008, 250.0, 0.0, 0.0], None).unwrap();
        let (work, z0, z1) = elastic_work(&law, &a, start * 0.4 / 250.0);
        let stored = 0.5 * 250.0 * (z1 * z1 - z0 * z0);
        prop_assert!(work >= stored - 1e-7, "fed {work}, stored {stored}");
    }

    #[test]
    fn upright_bristles_store_no_more_than_they_are_fed(
        a in prop::array::uniform3(-0.05..0.05_f64), start in -1.0..1.0_f64, ratio in 1.0..1.3_f64,
    ) {
        // E1 and E2: mu v = sigma0 theta w h with w = v cos^2/h, so storage h sigma0 theta^2/2
        let law = LawKind::SymmetricBristle.build(&[0.5, 0.5 * ratio, 1.5, 0.0, 0.0, 1.5], Some(HEIGHT)).unwrap();
        let (work, z0, z1) = elastic_work(&law, &a, 0.5 * start);
        let stored = 0.5 * HEIGHT * 1.5 * (z1 * z1 - z0 * z0);
        prop_assert!(work >= stored - 1e-7, "fed {work}, stored {stored}");
    }

    #[test]
    fn leaning_bristles_store_no_more_than_they_are_fed(
        a in prop::array::uniform3(-0.05..0.05_f64), start in -1.0..1.0_f64, lean in -0.6..0.6_f64,
    ) {
        // the same storage: the lean changes the gearing from v to w, not the balance theta w >= theta theta'
        let law = LawKind::AsymmetricBristle.build(&[0.5, 0.6, 1.5, 0.0, 0.0, 1.5, lean], Some(HEIGHT)).unwrap();
        let (work, z0, z1) = elastic_work(&law, &a, 0.5 * start);
        let stored = 0.5 * HEIGHT * 1.5 * (z1 * z1 - z0 * z0);
        prop_assert!(work >= stored - 1e-7, "fed {work}, stored {stored}");
    }
}

/// Power per load less the rate of storage, at one instant.
fn loss(law: &Law<f64>, z: f64, v: f64, store: f64) -> f64 {
    let drive = Drive::at(v);
    law.coefficient(z, &drive) * v - store * z * law.state_rate(z, &drive)
}

#[test]
fn losses_are_passive_up_to_the_bound_on_damping_and_not_beyond() {
    // worst deflection of the quadratic form: z' = -abs(w) z/(2 g), so z = 2 g (where w (1 - z/g) = -w): scan it all
    let least = |sigma1: f64, v: f64, placement: CosinePlacement| {
        let law = LawKind::AsymmetricBristle
            .build(&[0.5, 0.5, 1.5, sigma1, 0.0, 1.5, -0.3], Some(HEIGHT))
            .unwrap()
            .with_placement(placement);
        (-400..=400)
            .map(|i| loss(&law, f64::from(i) * 0.003, v, HEIGHT * 1.5))
            .fold(f64::INFINITY, f64::min)
    };
    let bound = |v: f64| 4.0 * 1.5 * 0.5 / (v / HEIGHT); // cos^2 <= 1: the bound at the largest w
    for v in [0.06, -0.06, 1.0, -1.0] {
        let v: f64 = v;
        assert!(
            least(0.99 * bound(v.abs()), v, CosinePlacement::AllTerms) >= -1e-15,
            "v = {v}"
        );
        assert!(
            least(8.0 * bound(v.abs()), v, CosinePlacement::AllTerms) < -1e-4,
            "v = {v}"
        );
    }
    // in reverse cos^2 is small where the form is worst: on all terms it forgives more damping, on the stiffness alone not
    assert!(least(1.5 * bound(0.06), -0.06, CosinePlacement::AllTerms) >= -1e-15);
    assert!(least(1.5 * bound(0.06), -0.06, CosinePlacement::StiffnessOnly) < -1e-6);
    assert!(least(0.99 * bound(0.06), -0.06, CosinePlacement::StiffnessOnly) >= -1e-15);
}

//! The force envelope: two paths to the same numbers, and the gains of the natural variant.

mod sample;

use biped::contact::Brush;
use biped::envelope::{Body, ForceMap, Hip, Posture, Variant, family, gain, polygon, programme};
use nalgebra::Vector2;
use proptest::prelude::*;

fn posture(pitch_deg: f64) -> Posture {
    Posture {
        pitch_rad: pitch_deg.to_radians(),
        hip_rad: (-45.0_f64).to_radians(),
        knee_rad: 90.0_f64.to_radians(),
    }
}

/// Gains of an independent prototype (another language, dynamics checked against Pinocchio);
/// pitch here counter-clockwise, so nose up is +5 degrees.
#[test]
fn the_natural_variant_has_the_gains_of_an_independent_computation() {
    let biped = sample::biped();
    for (pitch, expected) in [(5.0, 12.73), (0.0, 18.60), (-5.0, 17.04)] {
        let ours = gain(&biped, Variant::NATURAL, posture(pitch), sample::brush()).unwrap();
        assert!(
            (ours.forward_percent - expected).abs() < 0.02,
            "pitch {pitch}: {} instead of {expected}",
            ours.forward_percent
        );
    }
    let fixed = Variant {
        body: Body::FixedTorso,
        ..Variant::NATURAL
    };
    for (pitch, expected) in [(5.0, 11.98), (0.0, 18.60), (-5.0, 17.04)] {
        let ours = gain(&biped, fixed, posture(pitch), sample::brush()).unwrap();
        assert!(
            (ours.forward_percent - expected).abs() < 0.02,
            "{pitch}: {ours:?}"
        );
    }
}

#[test]
fn a_symmetric_brush_gains_nothing() {
    let ours = gain(
        &sample::biped(),
        Variant::NATURAL,
        posture(3.0),
        sample::brush().symmetric(),
    )
    .unwrap();
    assert_eq!((ours.forward_percent, ours.vertical_percent), (0.0, 0.0));
}

/// Statics of a massless two-link leg at a fixed torso: tau = -J^T F of the leg alone.
#[test]
fn without_weight_a_fixed_torso_obeys_the_lever_rule() {
    let biped = sample::biped();
    let variant = Variant {
        body: Body::FixedTorso,
        hip: Hip::Centre,
        weight: false,
    };
    let map = ForceMap::new(&biped, variant, posture(0.0)).unwrap();
    let torques = [3.0, -7.0];
    let force = map.force_n(&torques);
    // Foot straight below the hip at height h, knee behind by h/2: hip lever (0, -h).
    let h = 2.0 * biped.thigh.length_m * 45.0_f64.to_radians().cos();
    let hip = -h * force[0].abs() * -force[0].signum();
    let knee_to_foot = Vector2::new(h / 2.0, -h / 2.0);
    let knee = knee_to_foot[0] * force[1] - knee_to_foot[1] * force[0];
    assert!((hip + torques[0]).abs() < 1e-9, "{hip}");
    assert!((knee + torques[1]).abs() < 1e-9, "{knee}");
}

#[test]
fn the_binding_limits_are_those_at_which_more_torque_gives_more_force() {
    let biped = sample::biped();
    for pitch in [5.0, 0.0, -5.0] {
        let map = ForceMap::new(&biped, Variant::NATURAL, posture(pitch)).unwrap();
        let best = programme::largest(&map, sample::brush(), Vector2::x()).unwrap();
        for k in 0..2 {
            let mut wider = map.clone();
            wider.limits_n_m[k] *= 1.01;
            let more = programme::largest(&wider, sample::brush(), Vector2::x())
                .unwrap()
                .force_n[0];
            let bound = best
                .binding
                .iter()
                .any(|b| matches!(b, programme::Binding::Torque { joint, .. } if *joint == k));
            assert_eq!(
                more > best.force_n[0] + 1e-6,
                bound,
                "pitch {pitch}, joint {k}: {best:?}"
            );
        }
    }
}

#[test]
fn every_reading_of_the_family_keeps_the_order_of_the_brushes() {
    let postures = [5.0, 0.0, -5.0].map(posture);
    let readings = family::readings(&sample::biped(), &postures, sample::brush()).unwrap();
    assert_eq!(readings[0].variant, Variant::NATURAL);
    for reading in &readings {
        for gain in &reading.gains {
            assert!(gain.forward_percent > 0.0, "{reading:?}");
        }
    }
}

#[test]
fn a_stretched_leg_is_refused() {
    let straight = Posture {
        pitch_rad: 0.0,
        hip_rad: 0.1,
        knee_rad: 0.0,
    };
    let fixed = Variant {
        body: Body::FixedTorso,
        ..Variant::NATURAL
    };
    assert!(ForceMap::new(&sample::biped(), fixed, straight).is_err());
}

proptest! {
    /// Polygon and linear programme agree to 1e-9 over postures, variants and brushes.
    #[test]
    fn polygon_and_programme_agree(
        pitch in -0.3_f64..0.3, hip in -1.2_f64..0.2, knee in 0.4_f64..2.2,
        forward in 0.2_f64..1.5, reverse in 0.2_f64..1.5, which in 0_usize..4,
    ) {
        let body = [Body::FloatingOneLeg, Body::FixedTorso, Body::OtherLegLimp, Body::OtherLegDriven][which];
        let variant = Variant { body, hip: Hip::FrontEnd, weight: true };
        let posture = Posture { pitch_rad: pitch, hip_rad: hip, knee_rad: knee };
        let brush = Brush { forward, reverse };
        let map = ForceMap::new(&sample::biped(), variant, posture).unwrap();
        let region = polygon::cut_by_friction(&polygon::zonogon(&map), brush);
        prop_assume!(polygon::largest(&region, 1) > 5.0);
        for component in 0..2 {
            let mut direction = Vector2::zeros();
            direction[component] = 1.0;
            let exact = polygon::largest(&region, component);
            let solved = programme::largest(&map, brush, direction).unwrap().force_n[component];
            prop_assert!((exact - solved).abs() <= 1e-9 * exact.abs().max(1.0), "{exact} against {solved}");
        }
    }
}

//! Every effect can be planted, does something of a plausible size, and leaves no name in the package.

use planting::species::{ALIENS, CAUSES, SECOND_SHAPES};
use planting::{Base, Case, NoiseKind, Protocol};

fn force(case: &Case) -> Vec<f64> {
    case.carry_out()
        .expect("a known effect")
        .recordings
        .into_iter()
        .flat_map(|run| run.force_n)
        .collect()
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| {
        (sum + value * value, count + 1.0)
    });
    (sum / count).sqrt()
}

/// Each cause at its plausible size moves some protocol's record by between 0.05 % and 60 % of the friction.
#[test]
fn every_effect_does_something_plausible() {
    for id in CAUSES.iter().chain(&ALIENS) {
        let protocol = match *id {
            "direction-asymmetry" | "moving-inertia" | "backlash" | "velocity-lag" => {
                Protocol::Drive
            }
            "load-dependence" | "load-crosstalk" | "stage-tilt" | "force-zero-offset" => {
                Protocol::Loads
            }
            _ => Protocol::Rich,
        };
        let healthy = Case {
            noise: NoiseKind::None,
            ..Case::nothing(protocol, NoiseKind::None, 7)
        };
        let without = force(&healthy);
        for second in [false, true] {
            if second && !SECOND_SHAPES.contains(id) {
                continue;
            }
            let case = healthy.clone().with(id, 1.0, second);
            if *id == "velocity-lag" {
                let run = &case.carry_out().expect("known").recordings[0];
                let expected = healthy.carry_out().expect("known").recordings[0]
                    .velocity_m_s
                    .clone();
                let change = rms(run.velocity_m_s.iter().zip(&expected).map(|(a, b)| a - b));
                assert!(change > 1e-4, "{id}");
                continue;
            }
            let with = force(&case);
            let change =
                rms(with.iter().zip(&without).map(|(a, b)| a - b)) / rms(without.iter().copied());
            println!("{id} {second} {protocol:?} {change}");
            assert!(
                (5e-4..0.6).contains(&change),
                "{id} (second shape: {second}) changes friction by {change}"
            );
        }
    }
}

/// The package of a case names neither the effect nor the law, and the same case makes the same bytes.
#[test]
fn packages_leak_nothing_and_repeat() {
    let case = Case::one("sensor-lag", 2.0, Protocol::PaperBlocked, 11);
    let files = case.carry_out().expect("known").files;
    assert_eq!(files, case.carry_out().expect("known").files);
    for (path, text) in &files {
        for word in CAUSES
            .iter()
            .chain(&ALIENS)
            .chain(&["lag", "planted", "case", "seed"])
        {
            assert!(
                !path.contains(word) && !text.contains(word),
                "{path} holds {word:?}"
            );
        }
    }
}

/// Without noise and effects the same motion gives the same force on every repeat.
#[test]
fn noise_free_repeats_are_equal() {
    let day = Case::nothing(Protocol::PaperBlocked, NoiseKind::None, 3)
        .carry_out()
        .expect("nothing is known");
    assert_eq!(day.recordings[0].force_n, day.recordings[1].force_n);
}

/// Every law runs on every protocol and gives finite friction.
#[test]
fn every_law_runs_on_every_protocol() {
    for base in [
        Base::AsymmetricBristle,
        Base::SymmetricBristle,
        Base::Lugre,
        Base::Dahl,
        Base::Stribeck,
        Base::CoulombViscous,
    ] {
        for protocol in Protocol::ALL {
            if !protocol.is_brush()
                && matches!(base, Base::AsymmetricBristle | Base::SymmetricBristle)
            {
                continue;
            }
            let values = force(&Case::nothing(protocol, NoiseKind::Usual, 5).on(base));
            assert!(
                values.iter().all(|value| value.is_finite()),
                "{base:?} {protocol:?}"
            );
        }
    }
}

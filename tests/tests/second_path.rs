//! The measurement chain against an independent simulator: other equations on paper, other integrator, other code.

use std::collections::BTreeMap;

use planting::effect::{Ageing, Effect, Filter, Settling};
use planting::{Base, Case, NoiseKind, Outcome, Protocol};
use rig::{Experiment, Model};
use whole_program::measured::{campaign, parameters};

/// Largest difference between planted and predicted force as a share of the largest force, and how many samples
/// differ by more than `tolerance`.
fn disagreement(base: Base, protocol: Protocol, tolerance: f64) -> (f64, usize) {
    let case = Case::nothing(protocol, NoiseKind::None, 21).on(base);
    let day = case.carry_out().expect("nothing is known");
    let (law, values) = parameters(&day.key.law);
    let experiment = Experiment::new(&campaign(&day.plan, &day.recordings)).expect("it moves");
    let model = Model::new(law, Vec::new(), &experiment).expect("the law goes with the rig");
    let predicted = model.predict(&experiment, &values);
    let planted: Vec<f64> = day
        .recordings
        .iter()
        .flat_map(|run| run.force_n.iter().copied())
        .collect();
    let largest = planted.iter().fold(0.0_f64, |a, f| a.max(f.abs()));
    assert_eq!(planted.len(), predicted.len());
    let shares: Vec<f64> = planted
        .iter()
        .zip(&predicted)
        .map(|(a, b)| (a - b).abs() / largest)
        .collect();
    (
        shares.iter().copied().fold(0.0, f64::max),
        shares.iter().filter(|share| **share > tolerance).count(),
    )
}

/// Laws with an inner state agree to 1e-6 of the largest force on every protocol: an order above the integration
/// errors of both sides (1e-7), four orders below the noise of a careful rig.
#[test]
fn laws_with_a_state_agree() {
    for protocol in Protocol::ALL {
        let mut bases = vec![Base::Lugre, Base::Dahl];
        if protocol.is_brush() {
            bases.extend([Base::AsymmetricBristle, Base::SymmetricBristle]);
        }
        for base in bases {
            let (worst, _) = disagreement(base, protocol, 1e-6);
            println!("{base:?} {protocol:?}: {worst:.2e}");
            // A drive's inertia is differentiated from the recorded speed, by other differences at a record's ends.
            let tolerance = if protocol.is_brush() { 1e-6 } else { 5e-4 };
            assert!(
                worst < tolerance,
                "{base:?} on {protocol:?}: {worst:.2e} of the largest force"
            );
        }
    }
}

/// Static laws agree except in the few samples of slowest motion, where the program widens the sign of the speed and
/// the planted law jumps (drives, which creep into motion, have too many of these for a comparison).
#[test]
fn static_laws_agree_off_standstill() {
    for base in [Base::Stribeck, Base::CoulombViscous] {
        for protocol in Protocol::ALL
            .into_iter()
            .filter(|protocol| protocol.is_brush())
        {
            let (worst, outside) = disagreement(base, protocol, 1e-4);
            println!("{base:?} {protocol:?}: {worst:.2e}, {outside} samples");
            assert!(
                outside <= 30,
                "{base:?} on {protocol:?}: {outside} samples differ, worst {worst:.2e}"
            );
        }
    }
}

/// Every cause of the catalogue against the planted mechanism of the same name and shape, at a strong and at a weak size: what the
/// two leave between them is a small part of the effect. (They are different code at different depth.)
#[test]
fn catalogue_and_planted_mechanisms_agree() {
    let mut disagreements: Vec<String> = Vec::new();
    for id in planting::species::CAUSES {
        for (protocol, size) in [
            (Protocol::Rich, 0.5),
            (Protocol::Rich, 0.05),
            (Protocol::Drive, 0.5),
            (Protocol::Drive, 0.05),
            (Protocol::Rotary, 0.5),
            (Protocol::Rotary, 0.05),
        ] {
            let healthy = Case::nothing(protocol, NoiseKind::None, 21);
            let day = healthy.clone().with(id, size, false).carry_out();
            let Some(share) = disagreement_of(&healthy, &day.expect("a cause"), id) else {
                // What a brush under loads does not show, no test here compares.
                let compared_elsewhere = protocol != Protocol::Rich || is_of_the_numbers(id);
                assert!(compared_elsewhere, "{id} is not compared at all");
                println!("{id} on {protocol:?}: not there");
                continue;
            };
            println!("{id} on {protocol:?} at {size}: {share:.4}");
            // The moment between two samples at which a gap is crossed, the program can only guess. A ripple is carried along chords of a twelfth of its pitch.
            let tolerance = match (id, protocol) {
                ("backlash", Protocol::Drive | Protocol::Rotary) => 0.05,
                // Not understood yet (docs/known-gaps.md).
                ("cord-compliance", Protocol::Rotary) => 0.07,
                ("stage-ripple", _) => 0.02,
                _ if size < 0.1 => 0.02,
                _ => 0.01,
            };
            if share.is_nan() || share >= tolerance {
                disagreements.push(format!(
                    "{id} on {protocol:?} at {size}: the two differ by {share:.3} of the effect"
                ));
            }
        }
    }
    assert!(disagreements.is_empty(), "{}", disagreements.join("\n"));
}

/// Second forms that the catalogue knows: bends in each of their ways to settle, an asymmetry that jumps, ageing in each of its ways to end, and channels of two stages.
#[test]
fn second_forms_agree_too() {
    let mut seen = std::collections::BTreeSet::new();
    for (id, seeds) in [
        ("direction-asymmetry", 21..23),
        ("bristle-set", 21..33),
        ("dwell-ageing", 21..29),
        ("sensor-lag", 21..22),
        ("velocity-lag", 21..22),
    ] {
        for (protocol, seed) in [Protocol::Rich, Protocol::Drive]
            .into_iter()
            .flat_map(|protocol| seeds.clone().map(move |seed| (protocol, seed)))
        {
            let healthy = Case::nothing(protocol, NoiseKind::None, seed);
            let planted = healthy.clone().with(id, 0.3, true).carry_out();
            let day = planted.expect("a cause");
            let form = further_names(&day.key.effects[0]);
            let Some(share) = disagreement_of(&healthy, &day, id) else {
                continue;
            };
            println!("{id} {form:?} on {protocol:?}, seed {seed}: {share:.4}");
            assert!(share < 0.02, "{id} {form:?} on {protocol:?}: {share:.3}");
            seen.extend(form.last().map(|(name, _)| (id, *name)));
        }
    }
    let wanted = [
        ("direction-asymmetry", "jumps_in_turning"),
        ("bristle-set", "distance_m"),
        ("bristle-set", "kept"),
        ("bristle-set", "left_by_runs"),
        ("dwell-ageing", "fading_distance_m"),
        ("dwell-ageing", "lost_in_turning"),
        ("dwell-ageing", "of_the_whole_curve"),
        ("sensor-lag", "second_order"),
        ("velocity-lag", "second_order"),
    ];
    assert!(wanted.iter().all(|form| seen.contains(form)), "{seen:?}");
}

/// What a file of the program says beside the sizes, so that it means this second form.
fn further_names(effect: &Effect) -> Vec<(&'static str, f64)> {
    match *effect {
        Effect::DirectionAsymmetry { jumps: true, .. } => vec![("jumps_in_turning", 1.0)],
        Effect::BristleSet { settling, .. } => match settling {
            Settling::ByRuns => Vec::new(),
            Settling::Kept => vec![("kept", 1.0)],
            Settling::WithTheWay(distance_m) => vec![("distance_m", distance_m)],
            Settling::LostWithTheWay(distance_m) => {
                vec![("distance_m", distance_m), ("left_by_runs", 1.0)]
            }
        },
        Effect::DwellAgeing { ends, .. } => match ends {
            Ageing::WithTheRun => Vec::new(),
            Ageing::InTurning => vec![("lost_in_turning", 1.0)],
            Ageing::Fading(length_m) => vec![("fading_distance_m", length_m)],
            Ageing::Grown(length_m) => {
                vec![("fading_distance_m", length_m), ("of_the_whole_curve", 1.0)]
            }
        },
        Effect::SensorLag { filter, .. } | Effect::VelocityLag { filter, .. } => match filter {
            Filter::FirstOrder => Vec::new(),
            Filter::SecondOrder => vec![("second_order", 0.25)],
        },
        _ => Vec::new(),
    }
}

/// Whether a cause is read off the numbers and predicts nothing.
fn is_of_the_numbers(id: &str) -> bool {
    diagnosis::causes::find(id)
        .expect("in the catalogue")
        .is_data_integrity()
}

/// Distance between a day's planted record and the catalogue's prediction over the size of the effect; `None` where the protocol does not have the cause.
fn disagreement_of(healthy: &Case, day: &Outcome, id: &str) -> Option<f64> {
    let without = healthy.carry_out().expect("nothing");
    let effect = day.key.effects[0];
    let mut reported: BTreeMap<String, f64> = effect
        .sizes()
        .into_iter()
        .chain(further_names(&effect))
        .map(|(name, value)| (name.to_string(), value))
        .collect();
    if let Some(phase) = effect.phase_rad() {
        reported.insert("phase_rad".into(), phase);
    }
    let experiment = Experiment::new(&campaign(&day.plan, &day.recordings)).expect("it moves");
    let (law, law_values) = parameters(&day.key.law);
    let predictions: Vec<Vec<f64>> = diagnosis::causes::catalogue()
        .into_iter()
        .filter(|cause| cause.id() == id && !cause.is_data_integrity())
        .filter(|cause| cause.lack(&experiment).is_none())
        .filter_map(|cause| {
            if cause
                .reported(&cause.starts(&experiment).first()?.clone())
                .iter()
                .any(|r| r.name == "mass_kg")
            {
                reported.entry("mass_kg".into()).or_insert(0.0);
            }
            let fitted = cause.from_reported(&reported).ok()?;
            let model = Model::new(law, vec![cause], &experiment).ok()?;
            let mut values = law_values.clone();
            values.extend(fitted);
            values.resize(model.parameters().len(), 0.0);
            let mut predicted = model.predict(&experiment, &values);
            if let Effect::LoadDependence { exponent } = effect {
                // The load at which the coefficients are stated is a convention: first load here, mean load there.
                let first_n = day.plan.runs[0].load_n?;
                let factor = (first_n / experiment.reference_load_n).powf(exponent);
                predicted.iter_mut().for_each(|force| *force *= factor);
            }
            Some(predicted)
        })
        .collect();
    let stack = |recordings: &[planting::machine::Recording]| -> Vec<f64> {
        recordings
            .iter()
            .flat_map(|run| run.force_n.iter().copied())
            .collect()
    };
    let (planted, clean) = (stack(&day.recordings), stack(&without.recordings));
    // A filtered velocity channel changes the prediction, not the force.
    let clean = if id == "velocity-lag" {
        let plain = Model::new(law, Vec::new(), &experiment).expect("plain");
        let mut bare = law_values.clone();
        bare.resize(plain.parameters().len(), 0.0);
        plain.predict(&experiment, &bare)
    } else {
        clean
    };
    // How long the stage took to change its acceleration at the ends of a run is in no record; the diagnosis does not look there.
    let ends = usize::from(id == "moving-inertia");
    let looked_at: Vec<usize> = experiment
        .runs
        .iter()
        .flat_map(|run| run.samples.start + ends..run.samples.end - ends)
        .collect();
    let norm = |a: &[f64], b: &[f64]| {
        let squares = looked_at.iter().map(|&i| (a[i] - b[i]).powi(2));
        squares.sum::<f64>().sqrt()
    };
    let share = |predicted: &Vec<f64>| norm(&planted, predicted) / norm(&planted, &clean);
    predictions.iter().map(share).reduce(f64::min)
}

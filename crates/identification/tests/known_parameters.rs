//! Records made by the chain itself with known parameters, noise of stated size on top: the answers are known.

use campaign::{
    Axis, Campaign, Direction, InitialState, Protocol, Provenance, RigData, Run, Specimen,
};
use fitting::noise::Sizes;
use friction::LawKind;
use identification::{
    IdentificationError, Question, Simulation, Truth, Weighting, folds, identify, in_paper_form,
};
use rig::{Experiment, Model};

/// An arbitrary bristle: theta_c/sigma, theta_s/sigma, sigma0, sigma1, sigma2, w_sc, theta0.
const TRUTH: [f64; 7] = [0.45, 0.55, 1.2, 0.05, 0.01, 1.5, -0.2];
/// Gains of the runs, less one.
const GAINS: [f64; 6] = [0.004, -0.009, 0.011, 0.002, -0.006, 0.008];

fn ramp(direction: Direction, order: usize) -> Run {
    let sign = if direction == Direction::Forward {
        1.0
    } else {
        -1.0
    };
    let time_s: Vec<f64> = (0..300).map(|i| f64::from(i) / 30.0).collect();
    Run {
        name: format!("run {order}"),
        direction,
        protocol: Protocol::Ramp,
        repeat: None,
        order: Some(order as f64),
        started_s: Some(60.0 * order as f64),
        normal_load_n: Some(2.0),
        start_position_m: if sign > 0.0 { 0.0 } else { 0.3 },
        stage_turned: false,
        specimen_turned: false,
        initial_state: InitialState::Relaxed,
        velocity_m_s: time_s.iter().map(|t| sign * 0.006 * t).collect(),
        force_n: vec![0.0; time_s.len()],
        time_s,
        position_m: None,
        normal_force_n: None,
        temperature_c: None,
    }
}

/// Three ramps each way with the gains above and white noise of 0.1 % of the load, by a fixed recurrence.
fn made() -> Campaign {
    let runs = (0..6)
        .map(|k| {
            let direction = if k % 2 == 0 {
                Direction::Forward
            } else {
                Direction::Reverse
            };
            ramp(direction, k)
        })
        .collect();
    let mut campaign = Campaign {
        name: "made".into(),
        title: "made".into(),
        provenance: Provenance::Synthetic,
        axis: Axis::Linear,
        specimen: Specimen {
            layout: Some("2x2".into()),
            contact_height_m: Some(7e-3),
            ..Specimen::default()
        },
        counterface: None,
        rig: RigData::default(),
        runs,
        input_hashes: Vec::new(),
    };
    let experiment = Experiment::new(&campaign).unwrap();
    let model = Model::new(LawKind::AsymmetricBristle, Vec::new(), &experiment).unwrap();
    let force = model.predict(&experiment, &TRUTH);
    let mut seed = 12345_u64;
    // Sum of twelve even numbers less six: nearly normal, unit variance.
    let mut noise = move || {
        let mut sum = -6.0;
        for _ in 0..12 {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            sum += (seed >> 33) as f64 / f64::from(1_u32 << 31);
        }
        sum
    };
    for (k, run) in campaign.runs.iter_mut().enumerate() {
        let first = experiment.runs[k].samples.start;
        for (i, f) in run.force_n.iter_mut().enumerate() {
            *f = force[first + i] * (1.0 + GAINS[k]) + 0.002 * noise();
        }
    }
    campaign
}

fn bristle() -> Question {
    Question::of(LawKind::AsymmetricBristle)
}

#[test]
fn parameters_come_back_inside_their_intervals() {
    let found = identify(&made(), &bristle()).unwrap();
    assert!(found.status.converged(), "{}", found.status);
    assert_eq!(found.weighting, Weighting::Noise);
    assert!(!found.better_found);
    for (estimate, truth) in found.estimates.iter().zip(TRUTH) {
        let interval = estimate.interval.as_ref().unwrap();
        let (low, high) = (interval.low(), interval.high());
        assert!(
            interval.contains(truth),
            "{}: [{low}, {high}] misses {truth}",
            estimate.name
        );
        assert!(
            (estimate.value / truth - 1.0).abs() < 0.25,
            "{} = {}",
            estimate.name,
            estimate.value
        );
    }
    // sigma0 hangs on the gains of six runs, the Stribeck rate on the shape within runs.
    let degrees = |name: &str| found.estimate(name).unwrap().drivers.unwrap().degrees;
    assert!(degrees("sigma0") < 15.0, "{}", degrees("sigma0"));
    assert!(degrees("omega_sc") > 5.0 * degrees("sigma0"));
    let test = found.quality.lack_of_fit.unwrap();
    assert!(!test.rejects(), "{test:?}");
}

#[test]
fn the_same_record_gives_the_same_bits() {
    let one = identify(&made(), &bristle().values_only()).unwrap();
    let other = identify(&made(), &bristle().values_only()).unwrap();
    assert_eq!(one.parameters, other.parameters);
    assert_eq!(one.work, other.work);
}

/// A symmetric law on a record with two levels misses it by far more than the repeats scatter, and says so.
#[test]
fn a_law_without_direction_is_fitted_plainly() {
    let found = identify(&made(), &Question::of(LawKind::Lugre).values_only()).unwrap();
    assert_eq!(found.weighting, Weighting::Plain);
    assert!(found.quality.rmse > 5.0 * found.quality.floor_rmse.unwrap());
}

#[test]
fn the_scale_ray_is_flat_and_one_singular_value_is_zero() {
    let campaign = made();
    let found = identify(&campaign, &bristle().values_only()).unwrap();
    let paper = in_paper_form(&campaign, &found, 50.0, &[0.2, 1.0, 5.0]).unwrap();
    assert_eq!(paper.identifiability.rank, 7);
    assert_eq!(paper.names.len(), 8);
    for (name, points) in &paper.profiles {
        for point in points {
            assert!(point.deviance.abs() < 1e-3, "{name}: {}", point.deviance);
        }
    }
    let highest = paper
        .contrast
        .1
        .iter()
        .map(|p| p.deviance)
        .fold(0.0, f64::max);
    assert!(highest > 4.0, "sigma0 is no flat direction: {highest}");
}

#[test]
fn a_held_lean_stays_and_wrong_questions_are_refused() {
    let campaign = made();
    let held = identify(&campaign, &bristle().values_only().holding("theta0", -0.25)).unwrap();
    let lean = held.estimate("theta0").unwrap();
    assert_eq!(lean.value, -0.25);
    assert!(lean.held && lean.sd.is_none());
    let unknown = identify(
        &campaign,
        &Question::of(LawKind::Lugre).holding("theta0", 0.0),
    );
    assert!(matches!(
        unknown.map(|_| ()),
        Err(IdentificationError::UnknownParameter { name, .. }) if name == "theta0"
    ));
    let outside = identify(&campaign, &bristle().holding("theta0", 9.0));
    assert!(matches!(
        outside.map(|_| ()),
        Err(IdentificationError::OutOfBounds { .. })
    ));
}

#[test]
fn folds_leave_out_one_run_of_each_condition() {
    assert_eq!(folds(&made()), vec![vec![0, 1], vec![2, 3], vec![4, 5]]);
    let mut single = made();
    single.runs.truncate(2);
    assert!(folds(&single).is_empty());
}

/// Bands predicted from one campaign hold 95 % of the samples of others, as a mean over campaigns: with a scatter that six
/// runs tell badly, and noise within runs that they tell well. Half the width would hold some 75 %.
#[test]
fn a_prediction_band_holds_its_share_of_new_campaigns() {
    let template = made();
    let truth = Truth {
        law: LawKind::AsymmetricBristle,
        parameters: TRUTH.to_vec(),
        noise: Sizes {
            sensor: 0.002,
            private: 0.004,
            plate: 0.004,
            length: 2e-3,
            scatter: 0.006,
            ..Sizes::NONE
        },
    };
    let simulation = Simulation::new(&template, &truth, 3, 0).unwrap();
    let shares: Vec<f64> = (0..60)
        .filter_map(|k| simulation.share_in_band(k))
        .collect();
    assert!(shares.len() >= 54, "{}", shares.len());
    let n = shares.len() as f64;
    let mean = shares.iter().sum::<f64>() / n;
    let variance = shares.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / (n - 1.0);
    let miss = (mean - 0.95).abs();
    println!(
        "mean share {mean}, standard error {}",
        (variance / n).sqrt()
    );
    assert!(miss < 0.01 + 3.0 * (variance / n).sqrt(), "{mean}");
}

//! The chain without effects: what each kind of campaign means for the prediction.

mod campaigns;

use campaign::{Axis, InitialState, Protocol};
use campaigns::{BRISTLE, HEIGHT, LUGRE, campaign, ramp, run, time, wave};
use friction::{Drive, LawKind, Record, integrate};
use rig::{Experiment, Model, Paths};

fn coefficients(kind: LawKind, p: &[f64], t: &[f64], v: &[f64], initial: f64) -> Vec<f64> {
    let law = kind.build(p, Some(HEIGHT)).expect("complete");
    let knots: Vec<usize> = (0..t.len()).collect();
    let record = Record::of_slip(t, v, &knots);
    let z = integrate(&law, &record, initial).expect("finite");
    z.iter()
        .zip(v)
        .map(|(&z, &v)| law.coefficient(z, &Drive::at(v)))
        .collect()
}

fn close(a: &[f64], b: &[f64], tolerance: f64) {
    assert_eq!(a.len(), b.len());
    for (i, (x, y)) in a.iter().zip(b).enumerate() {
        assert!((x - y).abs() < tolerance, "sample {i}: {x} {y}");
    }
}

#[test]
fn force_is_load_times_coefficient() {
    let t = time(200, 0.02);
    let v = ramp(&t, 0.01);
    let mut loaded = run(&t, v.clone(), Some(3.0), 1);
    let experiment = Experiment::new(&campaign(vec![loaded.clone()])).expect("moves");
    let model = Model::new(LawKind::AsymmetricBristle, vec![], &experiment).expect("model");
    let mu = coefficients(LawKind::AsymmetricBristle, &BRISTLE, &t, &v, 0.0);
    let expected: Vec<f64> = mu.iter().map(|m| 3.0 * m).collect();
    close(&model.predict(&experiment, &BRISTLE), &expected, 1e-6);

    // a recorded load counts, the stated one is nominal
    let recorded: Vec<f64> = t.iter().map(|t| 3.0 + 0.1 * t.sin()).collect();
    loaded.normal_force_n = Some(recorded.clone());
    let experiment = Experiment::new(&campaign(vec![loaded])).expect("moves");
    let expected: Vec<f64> = mu.iter().zip(&recorded).map(|(m, n)| m * n).collect();
    close(&model.predict(&experiment, &BRISTLE), &expected, 1e-6);
}

#[test]
fn without_a_load_the_law_is_in_newtons_and_says_so() {
    let t = time(200, 0.02);
    let v = wave(&t);
    let experiment = Experiment::new(&campaign(vec![run(&t, v.clone(), None, 1)])).expect("moves");
    assert!(!experiment.has_load);
    let model = Model::new(LawKind::Lugre, vec![], &experiment).expect("model");
    close(
        &model.predict(&experiment, &LUGRE),
        &coefficients(LawKind::Lugre, &LUGRE, &t, &v, 0.0),
        1e-9,
    );
    let units: Vec<&str> = model.parameters().iter().map(|s| s.unit.as_ref()).collect();
    assert_eq!(units, ["N", "N", "m/s", "N/m", "N s/m", "N s/m"]);
    let mut rotary = campaign(vec![run(&t, v, None, 1)]);
    rotary.axis = Axis::Rotary;
    let experiment = Experiment::new(&rotary).expect("moves");
    let model = Model::new(LawKind::Lugre, vec![], &experiment).expect("model");
    let units: Vec<&str> = model.parameters().iter().map(|s| s.unit.as_ref()).collect();
    assert_eq!(
        units,
        ["N m", "N m", "rad/s", "N m/rad", "N m s/rad", "N m s/rad"]
    );
}

#[test]
fn moving_mass_adds_inertia_and_an_unloaded_run_shows_nothing_else() {
    let t = time(200, 0.02);
    let v = wave(&t);
    let mut unloaded = run(&t, v.clone(), None, 2);
    unloaded.protocol = Protocol::Unloaded;
    unloaded.normal_load_n = Some(0.0);
    let mut both = campaign(vec![run(&t, v.clone(), Some(2.0), 1), unloaded]);
    let without = Experiment::new(&both).expect("moves");
    both.rig.moving_mass_kg = Some(1.5);
    let with = Experiment::new(&both).expect("moves");
    let model = Model::new(LawKind::Lugre, vec![], &with).expect("model");
    let inertia: Vec<f64> = model
        .predict(&with, &LUGRE)
        .iter()
        .zip(model.predict(&without, &LUGRE))
        .map(|(a, b)| a - b)
        .collect();
    let exact: Vec<f64> = t
        .iter()
        .map(|t| 1.5 * 0.03 * 1.1 * (1.1 * t).cos())
        .collect();
    for part in [&inertia[..200], &inertia[200..]] {
        close(&part[1..199], &exact[1..199], 1e-4);
    }
    close(&model.predict(&without, &LUGRE)[200..], &[0.0; 200], 1e-15);
}

/// Runs that are asked for come out as among all, bit for bit; the others are no numbers.
#[test]
fn some_runs_alone_are_predicted_as_among_all() {
    let t = time(200, 0.02);
    let runs = [0.01, 0.02, 0.03, 0.04].map(|speed| run(&t, ramp(&t, speed), Some(3.0), 1));
    let experiment = Experiment::new(&campaign(runs.to_vec())).expect("moves");
    let model = Model::new(LawKind::AsymmetricBristle, vec![], &experiment).expect("model");
    let all = model.predict(&experiment, &BRISTLE);
    let some = model.predict_of(&experiment, &BRISTLE, Paths::NONE, |run| run % 2 == 1);
    assert_eq!(some.len(), all.len());
    for (i, (own, among_all)) in some.iter().zip(&all).enumerate() {
        match i / t.len() % 2 {
            1 => assert_eq!(own.to_bits(), among_all.to_bits(), "{i}"),
            _ => assert!(own.is_nan(), "{i}"),
        }
    }
}

#[test]
fn a_turned_specimen_meets_the_plate_the_other_way() {
    let t = time(200, 0.02);
    let v = ramp(&t, 0.01);
    let mut turned = run(&t, v.iter().map(|v| -v).collect(), Some(2.0), 1);
    turned.specimen_turned = true;
    let straight = Experiment::new(&campaign(vec![run(&t, v, Some(2.0), 1)])).expect("moves");
    let turned = Experiment::new(&campaign(vec![turned])).expect("moves");
    let model = Model::new(LawKind::AsymmetricBristle, vec![], &straight).expect("model");
    let mirrored: Vec<f64> = model
        .predict(&turned, &BRISTLE)
        .iter()
        .map(|f| -f)
        .collect();
    close(&mirrored, &model.predict(&straight, &BRISTLE), 1e-12);
}

#[test]
fn an_unknown_start_is_a_parameter_of_its_run() {
    let t = time(100, 0.02);
    let v = ramp(&t, 0.01);
    let mut bent = run(&t, v.clone(), Some(1.0), 2);
    bent.initial_state = InitialState::Unknown;
    let mut third = bent.clone();
    third.order = Some(3.0);
    let experiment = Experiment::new(&campaign(vec![
        run(&t, v.clone(), Some(1.0), 1),
        bent,
        third,
    ]))
    .expect("moves");
    let model = Model::new(LawKind::AsymmetricBristle, vec![], &experiment).expect("model");
    let names: Vec<&str> = model
        .parameters()
        .iter()
        .skip(7)
        .map(|s| s.name.as_ref())
        .collect();
    assert_eq!(names, ["initial_state_2", "initial_state_3"]);
    let p = [&BRISTLE[..], &[0.2, -0.1]].concat();
    let f = model.predict(&experiment, &p);
    for (i, start) in [0.0, 0.2, -0.1].into_iter().enumerate() {
        let mu = coefficients(LawKind::AsymmetricBristle, &BRISTLE, &t, &v, start);
        close(&f[100 * i..100 * (i + 1)], &mu, 1e-6);
    }
    // initial states share one lane; each column must stay within its run and agree with differences
    let (_, jacobian) = model.predict_with_jacobian(&experiment, &p, Some(&[8, 0, 7]));
    assert!(jacobian.rows(0, 200).column(0).iter().all(|x| *x == 0.0));
    assert!(jacobian.rows(200, 100).column(2).iter().all(|x| *x == 0.0));
    for (j, column) in [8, 0, 7].into_iter().enumerate() {
        let at = |e: f64| {
            let mut q = p.clone();
            q[column] += e;
            model.predict(&experiment, &q)
        };
        let (up, down) = (at(1e-5), at(-1e-5));
        for i in 0..f.len() {
            let slope = (up[i] - down[i]) / 2e-5;
            assert!(
                (slope - jacobian[(i, j)]).abs() < 2e-3 * (1.0 + slope.abs()),
                "column {column}, sample {i}"
            );
        }
    }
}

#[test]
fn a_subset_of_columns_is_the_same_as_all_of_them() {
    let t = time(100, 0.02);
    let experiment =
        Experiment::new(&campaign(vec![run(&t, wave(&t), Some(1.0), 1)])).expect("moves");
    let model = Model::new(LawKind::AsymmetricBristle, vec![], &experiment).expect("model");
    let (f, all) = model.predict_with_jacobian(&experiment, &BRISTLE, None);
    assert_eq!(f, model.predict(&experiment, &BRISTLE));
    for column in 0..7 {
        let (_, one) = model.predict_with_jacobian(&experiment, &BRISTLE, Some(&[column]));
        for i in 0..f.len() {
            assert!(
                (one[(i, 0)] - all[(i, column)]).abs() <= 1e-12 * (1.0 + all[(i, column)].abs())
            );
        }
    }
}

#[test]
fn distances_positions_and_rests_are_counted_as_stated() {
    let t = time(101, 0.1);
    let mut back = run(&t, vec![-0.01; 101], Some(1.0), 2);
    back.start_position_m = 0.3;
    let experiment = Experiment::new(&campaign(vec![
        run(&t, vec![0.02; 101], Some(1.0), 1),
        back,
    ]))
    .expect("moves");
    let (a, b) = (&experiment.runs[0], &experiment.runs[1]);
    assert!((a.position_m[100] - 0.2).abs() < 1e-12 && (b.position_m[100] - 0.2).abs() < 1e-12);
    assert!((a.distance_m[100] - 0.2).abs() < 1e-12 && (b.distance_m[100] - 0.1).abs() < 1e-12);
    assert_eq!(a.prior_distance_m, Some(0.0));
    assert!((b.prior_distance_m.expect("ordered") - 0.2).abs() < 1e-12);
    assert_eq!((a.rest_s, a.started_s), (None, Some(0.0)));
    assert!((b.rest_s.expect("clock") - 50.0).abs() < 1e-9);
    assert_eq!(a.knots, vec![0, 100]);
}

#[test]
fn what_cannot_be_predicted_is_refused() {
    let t = time(50, 0.02);
    let still = campaign(vec![run(&t, vec![0.0; 50], Some(1.0), 1)]);
    assert!(
        Experiment::new(&still)
            .unwrap_err()
            .to_string()
            .contains("no run moves")
    );
    let mut unknown_height = campaign(vec![run(&t, ramp(&t, 0.01), Some(1.0), 1)]);
    unknown_height.specimen.contact_height_m = None;
    let experiment = Experiment::new(&unknown_height).expect("moves");
    let refusal = Model::new(LawKind::AsymmetricBristle, vec![], &experiment).unwrap_err();
    assert!(refusal.to_string().contains("contact_height_mm"));
    assert!(Model::new(LawKind::Lugre, vec![], &experiment).is_ok());
}

#[test]
fn a_run_that_leaves_the_numbers_is_not_a_number_and_takes_no_other_with_it() {
    let t = time(100, 0.02);
    let mut first = run(&t, ramp(&t, 0.01), Some(1.0), 1);
    first.initial_state = InitialState::Unknown;
    let experiment = Experiment::new(&campaign(vec![
        first,
        run(&t, ramp(&t, 0.01), Some(1.0), 2),
    ]))
    .expect("moves");
    let model = Model::new(LawKind::AsymmetricBristle, vec![], &experiment).expect("model");
    let f = model.predict(&experiment, &[&BRISTLE[..], &[f64::NAN]].concat());
    assert!(f[50].is_nan() && f[150].is_finite());
}

#[test]
fn rounded_times_leave_a_ramp_one_stretch_and_the_prediction_alone() {
    let exact = time(600, 1.0 / 60.0);
    let rounded: Vec<f64> = exact.iter().map(|t| (t * 1e5).round() / 1e5).collect();
    let v = ramp(&exact, 0.006);
    let experiment =
        Experiment::new(&campaign(vec![run(&rounded, v.clone(), Some(1.0), 1)])).expect("moves");
    assert_eq!(experiment.runs[0].knots, vec![0, 599]);
    let model = Model::new(LawKind::AsymmetricBristle, vec![], &experiment).expect("model");
    let sample_by_sample = coefficients(LawKind::AsymmetricBristle, &BRISTLE, &rounded, &v, 0.0);
    close(
        &model.predict(&experiment, &BRISTLE),
        &sample_by_sample,
        2e-7,
    );
}

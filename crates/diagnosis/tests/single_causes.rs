//! What single causes do to a prediction, beside what is asked of all of them.

mod rigs;

use diagnosis::causes::catalogue;
use friction::LawKind;
use rig::{Experiment, Model};
use rigs::{BRISTLE, rich};

/// Ageing follows the rest before the run on a motion that bends between its samples too, which is carried in half steps.
#[test]
fn ageing_knows_the_rest_where_the_motion_bends() {
    let forces = |rest_s: f64| {
        let mut campaign = rich(200);
        campaign.runs.truncate(4);
        for run in &mut campaign.runs {
            let bent = |t: &f64| 0.011 - 0.01 * (2.5 * t).cos();
            run.velocity_m_s = run.time_s.iter().map(bent).collect();
            run.direction = campaign::Direction::Forward;
        }
        let starts = [0.0, 20.0, 40.0, 50.0 + rest_s];
        for (run, start) in campaign.runs.iter_mut().zip(starts) {
            run.started_s = Some(start);
        }
        let experiment = Experiment::new(&campaign).expect("moves");
        let ageing = catalogue().into_iter().find(|c| c.id() == "dwell-ageing");
        let causes = vec![ageing.expect("in the catalogue")];
        let model = Model::new(LawKind::AsymmetricBristle, causes, &experiment).expect("model");
        let mut p = BRISTLE.to_vec();
        p.push(0.1);
        model.predict(&experiment, &p)
    };
    let (short, long) = (forces(2.0), forces(2000.0));
    let n = short.len() / 4;
    let most = |range: std::ops::Range<usize>| {
        range.fold(0.0_f64, |most, i| most.max((short[i] - long[i]).abs()))
    };
    assert_eq!(most(0..3 * n), 0.0);
    assert!(most(3 * n..4 * n) > 0.01);
}

/// How long the specimen had rested before the first run moves that run's force, and no other's.
#[test]
fn a_free_first_rest_is_that_of_the_first_run() {
    let mut campaign = rich(200);
    for (run, start) in campaign
        .runs
        .iter_mut()
        .zip((0..).map(|k| 60.0 * f64::from(k)))
    {
        run.started_s = Some(start);
    }
    let experiment = Experiment::new(&campaign).expect("moves");
    let free = |name: &str| {
        let mut forms = catalogue().into_iter();
        let form = forms.find(|c| c.parameters().iter().any(|p| p.name == name));
        Model::new(
            LawKind::Lugre,
            vec![form.expect("in the catalogue")],
            &experiment,
        )
        .expect("model")
    };
    let model = free("decades_before_first_run");
    let law: Vec<f64> = (LawKind::Lugre.parameters().iter())
        .map(|p| p.typical)
        .collect();
    let forces = |decades: f64| {
        let mut p = law.clone();
        p.extend([0.3, decades]);
        model.predict(&experiment, &p)
    };
    let (fresh, rested) = (forces(0.0), forces(4.0));
    let first = experiment.runs[0].len();
    let apart = |range: std::ops::Range<usize>| {
        range.fold(0.0_f64, |most, i| most.max((fresh[i] - rested[i]).abs()))
    };
    assert!(apart(0..first) > 1e-3);
    assert_eq!(apart(first..fresh.len()), 0.0);
}

/// A mass on the stage feels what the ripple does to the speed, M dv/dt with v = dx/dt = c (1 + A sin(2 pi x/p)) and so
/// dv/dt = v c A (2 pi/p) cos(2 pi x/p), x by Runge and Kutta's steps; in the plain form it follows the motor, at c all along.
#[test]
fn a_mass_on_a_rippling_stage_has_inertia() {
    const MASS_KG: f64 = 0.4;
    const AMPLITUDE: f64 = 0.05;
    const PITCH_M: f64 = 0.01;
    let mut campaign = rich(400);
    campaign.rig.moving_mass_kg = Some(MASS_KG);
    for run in &mut campaign.runs {
        run.normal_load_n = None;
    }
    let experiment = Experiment::new(&campaign).expect("moves");
    let law: Vec<f64> = (LawKind::Dahl.parameters().iter())
        .map(|p| p.typical)
        .collect();
    let forces = |variant: Option<&str>| {
        let mut forms = catalogue().into_iter();
        let form = forms.find(|c| c.id() == "stage-ripple" && c.variant() == variant);
        let effects = vec![form.expect("in the catalogue")];
        let model = Model::new(LawKind::Dahl, effects, &experiment).expect("model");
        let p: Vec<f64> = (law.iter().copied())
            .chain([AMPLITUDE, 0.0, PITCH_M])
            .collect();
        model.predict(&experiment, &p)
    };
    let (carried, plain) = (
        forces(Some("of a stage that carries the mass")),
        forces(None),
    );

    let before: usize = experiment.runs[..5].iter().map(|run| run.len()).sum();
    let run = &experiment.runs[5];
    let speed = run.velocity_m_s[0];
    let wave = std::f64::consts::TAU / PITCH_M;
    let rate = |x: f64| speed * (1.0 + AMPLITUDE * (wave * x).sin());
    let mut x = run.position_m[0];
    let mut exact = Vec::new();
    for i in 0..run.len() {
        if i > 0 {
            let h = (run.time_s[i] - run.time_s[i - 1]) / 8.0;
            for _ in 0..8 {
                let a = rate(x);
                let b = rate(x + 0.5 * h * a);
                let c = rate(x + 0.5 * h * b);
                x += h / 6.0 * (a + 2.0 * b + 2.0 * c + rate(x + h * c));
            }
        }
        exact.push(MASS_KG * rate(x) * speed * AMPLITUDE * wave * (wave * x).cos());
    }
    let largest = exact.iter().fold(0.0_f64, |most, f| most.max(f.abs()));
    assert!(largest > 0.004, "{largest}");
    for (i, exact) in exact.iter().enumerate().take(run.len() - 1).skip(1) {
        let added = carried[before + i] - plain[before + i];
        assert!(
            (added - exact).abs() < 0.05 * largest,
            "{i}: {added} {exact}"
        );
    }
}

/// Under a steady law with a viscous slope the force shows the speed, v = c (1 + A sin(2 pi x/p)). With x as recorded, c t, that is a sine; with x
/// where the stage is, dx/dt = v, there is a second harmonic of A/2 of the first.
#[test]
fn a_ripple_of_a_recorded_screw_has_no_second_harmonic() {
    const AMPLITUDE: f64 = 0.2;
    let experiment = Experiment::new(&rich(400)).expect("moves");
    let run = &experiment.runs[5];
    let before: usize = experiment.runs[..5].iter().map(|run| run.len()).sum();
    let way = run.position_m.last().expect("samples") - run.position_m[0];
    // whole pitches of the record
    let pitch_m = way.abs() / 4.0;
    let forces = |variant: Option<&str>| {
        let mut forms = catalogue().into_iter();
        let form = forms.find(|c| c.id() == "stage-ripple" && c.variant() == variant);
        let effects = vec![form.expect("in the catalogue")];
        let model = Model::new(LawKind::CoulombViscous, effects, &experiment).expect("model");
        let mut p: Vec<f64> = (LawKind::CoulombViscous.parameters().iter())
            .map(|p| p.typical)
            .collect();
        p.extend([AMPLITUDE, 0.0, pitch_m]);
        model.predict(&experiment, &p)[before..before + run.len()].to_vec()
    };
    // Fourier's coefficients over the record, its last sample being the first of the next pitch
    let harmonic = |force: &[f64], order: f64| {
        let n = force.len() - 1;
        let (mut sin, mut cos) = (0.0, 0.0);
        for (i, f) in force[..n].iter().enumerate() {
            let x =
                std::f64::consts::TAU * order * (run.position_m[i] - run.position_m[0]) / pitch_m;
            sin += f * x.sin();
            cos += f * x.cos();
        }
        2.0 * sin.hypot(cos) / n as f64
    };
    let screw = forces(Some("of a screw whose turns are recorded"));
    let plain = forces(None);
    let (first, second) = (harmonic(&screw, 1.0), harmonic(&screw, 2.0));
    assert!(second < 1e-3 * first, "{first} {second}");
    let share = harmonic(&plain, 2.0) / first;
    assert!((share / (0.5 * AMPLITUDE) - 1.0).abs() < 0.3, "{share}");
}

//! What the door lets in: units, gaps, reversals, canonical order, repeats, and the way back through `write`.

use std::fs;
use std::path::Path;

use campaign::{Axis, Campaign, Direction, InitialState, Protocol, Provenance};
use serde_json::{Value, json};
use tempfile::TempDir;

/// A package as a laboratory would leave it: odd units, a reversal, gaps, no load on one run, a column of remarks.
fn measured_style() -> TempDir {
    let folder = TempDir::new().unwrap();
    let cycles: String = (0..60)
        .filter(|i| ![17, 18, 40].contains(i))
        .map(|i| {
            let t = f64::from(i) * 0.05;
            let v = 0.012 * (2.0 * t).sin();
            format!(
                "{};ok;{v};{};{}\n",
                t * 1000.0,
                1800.0 * v.signum(),
                21.5 + 0.01 * t
            )
        })
        .collect();
    fs::write(
        folder.path().join("cycles.csv"),
        format!("clock;remark;stage;cell;temperature_c\n{cycles}")
            .replace("clock", "time_ms")
            .replace("stage", "velocity_m_s")
            .replace("cell", "force_mn"),
    )
    .unwrap();
    let steps: String = (0..25)
        .map(|i| format!("{},{},{}\n", i, 5 * (1 + i / 9), 0.3 + 0.01 * f64::from(i)))
        .collect();
    fs::write(
        folder.path().join("steps.csv"),
        format!("time_s,velocity_mm_s,force_n\n{steps}"),
    )
    .unwrap();
    let description = json!({
        "profile": "tabular-data-package", "name": "drive", "licenses": [{"name": "CC0-1.0"}],
        "campaign": {"provenance": "measured", "operator": "somebody"},
        "resources": [
            {"name": "second", "path": "steps.csv", "profile": "tabular-data-resource",
             "schema": {"fields": [{"name": "time_s", "type": "number", "unit": "s"},
                {"name": "velocity_mm_s", "type": "number", "unit": "mm/s"},
                {"name": "force_n", "type": "number", "unit": "N"}]},
             "run": {"direction": "forward", "protocol": "steps", "order": 2}},
            {"name": "first", "path": "cycles.csv", "profile": "tabular-data-resource", "dialect": {"delimiter": ";"},
             "schema": {"fields": [{"name": "time_ms", "type": "number", "unit": "ms"},
                {"name": "remark", "type": "string"},
                {"name": "velocity_m_s", "type": "number", "unit": "m/s"},
                {"name": "force_mn", "type": "number", "unit": "mN"},
                {"name": "temperature_c", "type": "number", "unit": "degC"}]},
             "run": {"direction": "both", "protocol": "cycles", "order": 1, "initial_state": "unknown", "normal_load_n": 5}}]
    });
    fs::write(
        folder.path().join("datapackage.json"),
        description.to_string(),
    )
    .unwrap();
    folder
}

#[test]
fn a_laboratory_package_comes_in_with_its_units_gaps_and_reversals() {
    let folder = measured_style();
    let campaign = campaign::open(folder.path()).unwrap();
    assert_eq!(campaign.axis, Axis::Linear);
    assert_eq!(campaign.provenance, Provenance::Measured);
    let [cycles, steps] = campaign.runs.as_slice() else {
        panic!("two runs")
    };
    assert_eq!(
        (cycles.name.as_str(), steps.name.as_str()),
        ("first", "second")
    );
    assert_eq!(
        (cycles.direction, cycles.protocol),
        (Direction::Both, Protocol::Cycles)
    );
    assert_eq!(cycles.initial_state, InitialState::Unknown);
    assert_eq!(cycles.time_s.len(), 57);
    assert!(
        (cycles.time_s[17] - 0.95).abs() < 1e-12,
        "rows 17 and 18 are missing"
    );
    assert_eq!(cycles.force_n[1], 1.8);
    assert_eq!(cycles.velocity_m_s[1], 0.012 * (2.0 * 0.05_f64).sin());
    assert_eq!(cycles.temperature_c.as_ref().unwrap()[0], 21.5);
    assert_eq!(steps.velocity_m_s[0], 0.005);
    assert_eq!(steps.normal_load_n, None);
    assert_eq!(campaign.conditions(), [vec![0], vec![1]]);
    let frame = campaign.frame().unwrap();
    assert_eq!(frame.height(), 82);
    assert_eq!(
        frame.column("mu").unwrap().null_count(),
        25,
        "no load, no coefficient"
    );
    assert_eq!(campaign.condition_summary().unwrap().height(), 2);
}

/// Everything of a campaign but what names its runs and files.
fn content(mut campaign: Campaign) -> Campaign {
    campaign.name.clear();
    campaign.title.clear();
    campaign.input_hashes.clear();
    for run in &mut campaign.runs {
        run.name.clear();
        run.repeat = None;
    }
    campaign
}

#[test]
fn names_order_of_resources_and_extra_metadata_change_nothing() {
    let folder = measured_style();
    let before = campaign::open(folder.path()).unwrap();
    let path = folder.path().join("datapackage.json");
    let mut description: Value = serde_json::from_str(&fs::read_to_string(&path).unwrap()).unwrap();
    let resources = description["resources"].as_array_mut().unwrap();
    resources.reverse();
    resources[0]["name"] = json!("zebra");
    resources[1]["name"] = json!("aardvark");
    resources[1]["run"]["repeat"] = json!(9);
    description["name"] = json!("another");
    description["campaign"]["weather"] = json!({"rain": true});
    fs::write(&path, serde_json::to_string_pretty(&description).unwrap()).unwrap();
    let after = campaign::open(folder.path()).unwrap();
    assert_eq!(content(before), content(after));
}

#[test]
fn what_is_written_is_read_again() {
    let folder = measured_style();
    let before = campaign::open(folder.path()).unwrap();
    let copy = TempDir::new().unwrap();
    campaign::write(copy.path(), &before).unwrap();
    let after = campaign::open(copy.path()).unwrap();
    let (before, after) = (content(before), content(after));
    for (one, other) in before.runs.iter().zip(&after.runs) {
        assert_eq!(one.time_s, other.time_s);
        assert_eq!(one.force_n, other.force_n);
        for (v, w) in one.velocity_m_s.iter().zip(&other.velocity_m_s) {
            assert!((v - w).abs() <= 2.0 * f64::EPSILON * v.abs());
        }
        assert_eq!(
            (one.direction, one.protocol, one.initial_state),
            (other.direction, other.protocol, other.initial_state)
        );
        assert_eq!(
            (one.order, one.normal_load_n),
            (other.order, other.normal_load_n)
        );
    }
    assert_eq!(
        (before.provenance, before.axis),
        (after.provenance, after.axis)
    );
}

/// A run by its samples, everything else equal.
fn ramp(times: impl Iterator<Item = f64>, noise: f64) -> campaign::Run {
    let time_s: Vec<f64> = times.collect();
    let velocity_m_s = time_s
        .iter()
        .enumerate()
        .map(|(i, t)| 0.006 * t + noise * if i % 2 == 0 { 1.0 } else { -1.0 })
        .collect();
    campaign::Run {
        name: String::new(),
        direction: Direction::Forward,
        protocol: Protocol::Ramp,
        repeat: None,
        order: None,
        started_s: None,
        normal_load_n: Some(2.0),
        start_position_m: 0.0,
        stage_turned: false,
        specimen_turned: false,
        initial_state: InitialState::Relaxed,
        force_n: vec![1.0; time_s.len()],
        velocity_m_s,
        time_s,
        position_m: None,
        normal_force_n: None,
        temperature_c: None,
    }
}

fn of(runs: Vec<campaign::Run>) -> Campaign {
    let folder = measured_style();
    Campaign {
        runs,
        ..campaign::open(folder.path()).unwrap()
    }
}

#[test]
fn repeats_are_told_by_what_was_commanded() {
    let sixty_hertz = || (0..=600).map(|i| f64::from(i) / 60.0);
    let shifted = (0..=490).map(|i| 0.003 + f64::from(i) / 50.0);
    let with_gaps = sixty_hertz()
        .enumerate()
        .filter(|(i, _)| i % 7 != 3)
        .map(|(_, t)| t);
    let same = of(vec![
        ramp(sixty_hertz(), 0.0),
        ramp(shifted, 0.0),
        ramp(with_gaps, 0.0002),
    ]);
    assert_eq!(same.conditions(), [vec![0, 1, 2]]);

    let mut slower = ramp(sixty_hertz(), 0.0);
    slower.velocity_m_s.iter_mut().for_each(|v| *v *= 0.97);
    let mut loaded = ramp(sixty_hertz(), 0.0);
    loaded.normal_load_n = Some(4.0);
    let mut turned = ramp(sixty_hertz(), 0.0);
    turned.stage_turned = true;
    let other = of(vec![ramp(sixty_hertz(), 0.0), slower, loaded, turned]);
    assert_eq!(other.conditions(), [vec![0], vec![1], vec![2], vec![3]]);
}

#[test]
fn steps_repeat_though_a_step_falls_between_samples() {
    let staircase = |shift: f64| {
        let mut run = ramp((0..400).map(|i| shift + f64::from(i) * 0.02), 0.0);
        let level = |t: &f64| if *t < 3.999 { 0.01 } else { 0.05 };
        run.velocity_m_s = run.time_s.iter().map(level).collect();
        run
    };
    assert_eq!(
        of(vec![staircase(0.0), staircase(0.011)]).conditions(),
        [vec![0, 1]]
    );
}

#[test]
fn plain_files_become_a_package() {
    let folder = TempDir::new().unwrap();
    let rows: String = (0..40)
        .map(|i| format!("{};{};{};x\n", f64::from(i) / 10.0, -3 * i, -1.2))
        .collect::<String>()
        .replace('.', ",");
    let csv = folder.path().join("Messung 1.csv");
    fs::write(
        &csv,
        format!("Time (s);velocity [mm/s];force (mN);note\n{rows}"),
    )
    .unwrap();
    let package = folder.path().join("package");
    let made = campaign::init(&package, std::slice::from_ref(&csv)).unwrap();
    assert!(made.fill_in.is_empty(), "{:?}", made.fill_in);
    let campaign = campaign::open(&package).unwrap();
    let run = &campaign.runs[0];
    assert_eq!(
        (run.direction, run.protocol),
        (Direction::Reverse, Protocol::Ramp)
    );
    assert_eq!(run.force_n[3], -1.2 / 1000.0);
    assert!(
        campaign::init(&package, &[csv])
            .unwrap_err()
            .to_string()
            .ends_with("there is a package already")
    );
}

#[test]
fn a_unit_that_the_file_does_not_say_is_left_to_the_reader() {
    let folder = TempDir::new().unwrap();
    let rows: String = (0..30).map(|i| format!("{i},5.0,1.5\n")).collect();
    let csv = folder.path().join("run.csv");
    fs::write(&csv, format!("t,v,force\n{rows}")).unwrap();
    let package = folder.path().join("package");
    let made = campaign::init(&package, &[csv]).unwrap();
    assert_eq!(
        made.fill_in,
        [
            "01-run: the unit of column time",
            "01-run: the unit of column velocity",
            "01-run: the unit of column force"
        ]
    );
    let message = campaign::open(&package).unwrap_err().to_string();
    assert!(
        message.ends_with("01-run.csv, column time: `` is not a unit of time (s, ms)"),
        "{message}"
    );
}

#[test]
fn a_rotary_rig_comes_in_by_its_columns() {
    let folder = TempDir::new().unwrap();
    let rows: String = (0..30)
        .map(|i| format!("{i},{},{}\n", -0.1 * f64::from(i), -0.02))
        .collect();
    fs::write(
        folder.path().join("a.csv"),
        format!("time_s,velocity_rad_s,torque_n_m\n{rows}"),
    )
    .unwrap();
    let description = json!({"campaign": {"provenance": "measured", "rig": {"moving_inertia_kg_m2": 0.02}},
        "resources": [{"name": "a", "path": "a.csv", "schema": {"fields": [{"name": "time_s", "unit": "s"},
            {"name": "velocity_rad_s", "unit": "rad/s"}, {"name": "torque_n_m", "unit": "N m"}]},
            "run": {"direction": "reverse", "protocol": "ramp"}}]});
    fs::write(
        folder.path().join("datapackage.json"),
        description.to_string(),
    )
    .unwrap();
    let campaign = campaign::open(folder.path()).unwrap();
    assert_eq!(campaign.axis, Axis::Rotary);
    assert_eq!(campaign.rig.moving_mass_kg, Some(0.02));
    assert_eq!(campaign.runs[0].velocity_m_s[2], -0.2);
    // The description itself names the package as well.
    assert!(campaign::open(Path::new(&folder.path().join("datapackage.json"))).is_ok());
}

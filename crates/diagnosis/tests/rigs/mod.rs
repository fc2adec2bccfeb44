//! Campaigns made by hand for the tests of the catalogue: commanded motions, loads and a clock, forces of zero.

#![allow(dead_code, unreachable_pub)]

use campaign::{
    Axis, Campaign, Direction, InitialState, Protocol, Provenance, RigData, Run, Specimen,
};

/// Leaning bristles of round numbers (no published value).
pub const BRISTLE: [f64; 7] = [0.5, 0.6, 1.5, 0.08, 0.006, 1.5, -0.3];
/// A LuGre contact of round numbers.
pub const LUGRE: [f64; 6] = [0.4, 0.55, 0.008, 250.0, 0.4, 0.6];

fn run(
    name: &str,
    direction: Direction,
    protocol: Protocol,
    order: usize,
    load: f64,
    time: Vec<f64>,
    velocity: Vec<f64>,
) -> Run {
    let start = if direction == Direction::Reverse {
        0.3
    } else {
        0.0
    };
    Run {
        name: name.to_owned(),
        direction,
        protocol,
        repeat: None,
        order: Some(order as f64),
        started_s: Some(40.0 * order as f64 + 7.0 * ((order * order) % 5) as f64),
        normal_load_n: Some(load),
        start_position_m: start,
        stage_turned: false,
        specimen_turned: false,
        initial_state: InitialState::Relaxed,
        force_n: velocity.iter().map(|v| v.signum()).collect(),
        time_s: time,
        velocity_m_s: velocity,
        position_m: None,
        normal_force_n: None,
        temperature_c: None,
    }
}

fn clock(samples: usize, rate: f64) -> Vec<f64> {
    (0..samples).map(|i| i as f64 / rate).collect()
}

/// The paper's protocol in miniature plus constant speeds, steps, reversals and a second load.
pub fn rich(samples: usize) -> Campaign {
    let time = clock(samples, samples as f64 / 10.0);
    let ramp = |sign: f64| time.iter().map(|t| sign * 0.006 * t).collect::<Vec<f64>>();
    let constant = |v: f64| time.iter().map(|_| v).collect::<Vec<f64>>();
    let steps = |sign: f64| {
        time.iter()
            .map(|t| sign * [0.004, 0.03, 0.01, 0.05, 0.02][((t / 2.0) as usize).min(4)])
            .collect::<Vec<f64>>()
    };
    let cycles = || {
        time.iter()
            .map(|t| 0.02 * (1.3 * t).sin())
            .collect::<Vec<f64>>()
    };
    let (f, r) = (Direction::Forward, Direction::Reverse);
    let plan: Vec<(&str, Direction, Protocol, f64, Vec<f64>)> = vec![
        ("a", f, Protocol::Ramp, 2.0, ramp(1.0)),
        ("b", r, Protocol::Ramp, 2.0, ramp(-1.0)),
        ("c", f, Protocol::Steps, 2.0, steps(1.0)),
        ("d", r, Protocol::Steps, 4.0, steps(-1.0)),
        ("e", Direction::Both, Protocol::Cycles, 2.0, cycles()),
        ("f", f, Protocol::Constant, 4.0, constant(0.02)),
        ("g", r, Protocol::Ramp, 4.0, ramp(-1.0)),
        ("h", f, Protocol::Ramp, 4.0, ramp(1.0)),
    ];
    let runs = plan
        .into_iter()
        .enumerate()
        .map(|(i, (name, direction, protocol, load, velocity))| {
            run(
                name,
                direction,
                protocol,
                i + 1,
                load,
                time.clone(),
                velocity,
            )
        })
        .collect();
    campaign(runs)
}

/// `n` ramps of 600 samples, alternating, at one load: the size of the performance target.
pub fn ramps(n: usize) -> Campaign {
    let time = clock(600, 60.0);
    let runs = (0..n)
        .map(|i| {
            let (sign, direction) = if i % 2 == 0 {
                (1.0, Direction::Forward)
            } else {
                (-1.0, Direction::Reverse)
            };
            let velocity = time.iter().map(|t| sign * 0.006 * t).collect();
            run(
                "ramp",
                direction,
                Protocol::Ramp,
                i + 1,
                2.0,
                time.clone(),
                velocity,
            )
        })
        .collect();
    campaign(runs)
}

fn campaign(runs: Vec<Run>) -> Campaign {
    Campaign {
        name: "bench".to_owned(),
        title: "bench".to_owned(),
        provenance: Provenance::Synthetic,
        axis: Axis::Linear,
        specimen: Specimen {
            layout: Some("2x2".to_owned()),
            bristle_length_m: Some(7e-3),
            bristle_diameter_m: Some(1e-4),
            contact_height_m: Some(7e-3),
        },
        counterface: None,
        rig: RigData::default(),
        runs,
        input_hashes: Vec::new(),
    }
}

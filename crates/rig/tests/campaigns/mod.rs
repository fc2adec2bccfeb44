//! Small campaigns made by hand, and a spring that holds the specimen: a cause written outside the crate.

#![allow(dead_code, unreachable_pub)]

use campaign::{
    Axis, Campaign, Direction, InitialState, Protocol, Provenance, RigData, Run, Specimen,
};
use friction::{ParameterSpec, Scalar};
use rig::{Cause, Coupling, Place, Reach, Station};

pub const BRISTLE: [f64; 7] = [0.5, 0.62, 1.5, 0.1, 0.01, 1.5, -0.3];
pub const LUGRE: [f64; 6] = [0.4, 0.55, 0.008, 250.0, 0.4, 0.6];
pub const HEIGHT: f64 = 7e-3;

pub fn run(time: &[f64], velocity: Vec<f64>, load: Option<f64>, order: usize) -> Run {
    let forward = velocity.iter().all(|v| *v >= 0.0);
    let reverse = velocity.iter().all(|v| *v <= 0.0);
    Run {
        name: format!("run-{order}"),
        direction: if forward {
            Direction::Forward
        } else if reverse {
            Direction::Reverse
        } else {
            Direction::Both
        },
        protocol: Protocol::Free,
        repeat: None,
        order: Some(order as f64),
        started_s: Some(60.0 * order as f64),
        normal_load_n: load,
        start_position_m: 0.0,
        stage_turned: false,
        specimen_turned: false,
        initial_state: InitialState::Relaxed,
        time_s: time.to_vec(),
        force_n: velocity.iter().map(|v| v.signum()).collect(),
        velocity_m_s: velocity,
        position_m: None,
        normal_force_n: None,
        temperature_c: None,
    }
}

pub fn campaign(runs: Vec<Run>) -> Campaign {
    Campaign {
        name: "by-hand".to_owned(),
        title: "by hand".to_owned(),
        provenance: Provenance::Synthetic,
        axis: Axis::Linear,
        specimen: Specimen {
            contact_height_m: Some(HEIGHT),
            ..Specimen::default()
        },
        counterface: None,
        rig: RigData::default(),
        runs,
        input_hashes: Vec::new(),
    }
}

pub fn time(n: usize, dt: f64) -> Vec<f64> {
    (0..n).map(|i| i as f64 * dt).collect()
}

pub fn ramp(time: &[f64], acceleration: f64) -> Vec<f64> {
    time.iter().map(|t| acceleration * t).collect()
}

pub fn wave(time: &[f64]) -> Vec<f64> {
    time.iter().map(|t| 0.03 * (1.1 * t).sin()).collect()
}

/// A spring with a dashpot and a stated mass between specimen and sensor.
#[derive(Clone, Copy, Debug)]
pub struct Spring {
    pub mass_kg: f64,
}

const SPRING: &[ParameterSpec] = &[
    ParameterSpec::new("compliance_m_n", "m/N", "compliance", 0.0, 1.0, 1e-3),
    ParameterSpec::new("damping_n_s_m", "N s/m", "damping", 0.0, 1e3, 1.0),
];

impl Cause for Spring {
    fn id(&self) -> &'static str {
        "spring"
    }

    fn station(&self) -> Station {
        Station::Coupling
    }

    fn reach(&self) -> Reach {
        Reach::Coupling
    }

    fn describe(&self) -> &'static str {
        "A spring holds the specimen."
    }

    fn parameters(&self) -> &'static [ParameterSpec] {
        SPRING
    }

    fn coupling<D: Scalar>(&self, p: &[D], _at: Place<'_>, coupling: &mut Coupling<D>) {
        coupling.compliance = p[0];
        coupling.damping = p[1];
        coupling.mass = D::constant(self.mass_kg);
    }
}

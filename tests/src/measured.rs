//! A planted day as a checked campaign in memory, without the rounding of a file.

use campaign::{
    Axis, Campaign, Direction, InitialState, Protocol, Provenance, RigData, Run, Specimen,
};
use friction::LawKind;
use planting::law::Law;
use planting::machine::Recording;
use planting::plan::{Axis as PlannedAxis, Plan, RunPlan};

/// Height of the bristle roots in planted brushes, m, for [`campaign()`].
pub const HEIGHT_M: f64 = 7.2e-3;

/// Parameters of a planted law in the program's order and names.
pub fn parameters(law: &Law) -> (LawKind, Vec<f64>) {
    match law {
        Law::AsymmetricBristle(b) => {
            let common = vec![
                b.theta_c / b.sigma,
                b.theta_s / b.sigma,
                b.sigma0,
                b.sigma1,
                b.sigma2,
                b.w_sc,
            ];
            if b.theta0_rad == 0.0 {
                (LawKind::SymmetricBristle, common)
            } else {
                (
                    LawKind::AsymmetricBristle,
                    [common, vec![b.theta0_rad]].concat(),
                )
            }
        }
        Law::Lugre(d) => (
            LawKind::Lugre,
            vec![
                d.coulomb,
                d.breakaway,
                d.stribeck_speed,
                d.stiffness,
                d.damping,
                d.viscous,
            ],
        ),
        Law::Dahl(d) => (LawKind::Dahl, vec![d.coulomb, d.stiffness]),
        Law::Stribeck(d) => (
            LawKind::Stribeck,
            vec![d.coulomb, d.breakaway, d.stribeck_speed, d.viscous],
        ),
        Law::CoulombViscous(d) => (LawKind::CoulombViscous, vec![d.coulomb, d.viscous]),
    }
}

/// The campaign that a loss-free logger would have written.
pub fn campaign(plan: &Plan, recordings: &[Recording]) -> Campaign {
    Campaign {
        name: "campaign".into(),
        title: "campaign".into(),
        provenance: Provenance::Synthetic,
        axis: match plan.axis {
            PlannedAxis::Linear => Axis::Linear,
            PlannedAxis::Rotary => Axis::Rotary,
        },
        specimen: Specimen {
            contact_height_m: Some(HEIGHT_M),
            ..Specimen::default()
        },
        counterface: None,
        rig: RigData {
            sensor_full_scale_n: Some(plan.full_scale_n),
            sensor_accuracy_percent_fs: Some(plan.accuracy_percent),
            sample_rate_hz: Some(plan.sample_rate_hz),
            travel_m: Some(plan.travel_m),
            moving_mass_kg: plan.moving_mass_kg,
        },
        runs: plan
            .runs
            .iter()
            .zip(recordings)
            .enumerate()
            .map(|(i, (run, record))| one(plan, i, run, record))
            .collect(),
        input_hashes: Vec::new(),
    }
}

fn one(plan: &Plan, index: usize, run: &RunPlan, record: &Recording) -> Run {
    Run {
        name: format!("run-{index:02}"),
        direction: match run.direction {
            "forward" => Direction::Forward,
            "reverse" => Direction::Reverse,
            _ => Direction::Both,
        },
        protocol: match run.protocol {
            "ramp" => Protocol::Ramp,
            "constant" => Protocol::Constant,
            "steps" => Protocol::Steps,
            "cycles" => Protocol::Cycles,
            "unloaded" => Protocol::Unloaded,
            _ => Protocol::Free,
        },
        repeat: None,
        order: Some(index as f64 + 1.0),
        started_s: Some(run.started_s),
        normal_load_n: run.load_n,
        start_position_m: run.start_position_m,
        stage_turned: run.stage_turned,
        specimen_turned: run.specimen_turned,
        initial_state: if run.starts_bent {
            InitialState::Unknown
        } else {
            InitialState::Relaxed
        },
        time_s: record.time_s.clone(),
        velocity_m_s: record.velocity_m_s.clone(),
        force_n: record.force_n.clone(),
        position_m: plan.records_position.then(|| record.position_m.clone()),
        normal_force_n: None,
        temperature_c: None,
    }
}

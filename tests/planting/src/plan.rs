//! What is to be run on the rig: runs with their motions, loads and places in the day.

use crate::motion::Motion;
use serde::{Deserialize, Serialize};

/// Line or axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Axis {
    /// m, N.
    Linear,
    /// rad, N m.
    Rotary,
}

/// One run as planned. SI units (rotary: rad for m, N m for N).
#[derive(Clone, Debug, PartialEq)]
pub struct RunPlan {
    /// `forward`, `reverse` or `both`.
    pub direction: &'static str,
    /// `ramp`, `constant`, `steps`, `cycles`, `free` or `unloaded`.
    pub protocol: &'static str,
    /// Normal load, N; `None` on a rig without a load channel.
    pub load_n: Option<f64>,
    /// Start on the campaign's clock, s.
    pub started_s: f64,
    /// Stage coordinate at the start, m.
    pub start_position_m: f64,
    /// Motion of the stage.
    pub motion: Motion,
    /// The rig was turned round.
    pub stage_turned: bool,
    /// The specimen was turned round.
    pub specimen_turned: bool,
    /// Whether the run starts bent by a slow slide that came before the first sample.
    pub starts_bent: bool,
}

/// A whole day at the rig.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Line or axis.
    pub axis: Axis,
    /// Samples a second.
    pub sample_rate_hz: f64,
    /// Length of the travel, m.
    pub travel_m: f64,
    /// Full scale of the sensor, N.
    pub full_scale_n: f64,
    /// Stated accuracy of the sensor, percent of full scale.
    pub accuracy_percent: f64,
    /// Mass of a drive's moving part that is known to the experimenter, kg.
    pub moving_mass_kg: Option<f64>,
    /// Whether the stage coordinate is recorded.
    pub records_position: bool,
    /// Runs in the order of the day.
    pub runs: Vec<RunPlan>,
}

/// Imperfections of a healthy rig.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Noise {
    /// Standard deviation of friction roughness as a share of the friction force.
    pub roughness: f64,
    /// Distance of sliding over which roughness is correlated (to 1/e), m.
    pub correlation_m: f64,
    /// Share of the variance of roughness that is fixed to the plate.
    pub plate_share: f64,
    /// Standard deviation of the sensor's white noise, N.
    pub sensor_n: f64,
    /// Standard deviation of what the amplifier's zero wanders by while it measures, N.
    pub wander_n: f64,
    /// Time over which that is correlated (to 1/e), s.
    pub wander_s: f64,
    /// Standard deviation of the factor by which friction differs from run to run.
    pub scatter: f64,
    /// Standard deviation of the white noise of the cell that records the load, as a share of the load; zero: no load is recorded.
    pub load_cell: f64,
    /// Standard deviation of the white noise of the velocity channel while the stage moves, as a share of the day's largest speed.
    pub encoder: f64,
    /// Tails of roughness and sensor noise.
    pub tails: crate::roughness::Tails,
    /// How smooth the roughness is.
    pub grain: crate::roughness::Grain,
}

impl Noise {
    /// None at all.
    pub const NONE: Self = Self {
        roughness: 0.0,
        correlation_m: 1.5e-3,
        plate_share: 0.5,
        sensor_n: 0.0,
        wander_n: 0.0,
        wander_s: 0.2,
        scatter: 0.0,
        load_cell: 0.0,
        encoder: 0.0,
        tails: crate::roughness::Tails::Normal,
        grain: crate::roughness::Grain::Rough,
    };
}

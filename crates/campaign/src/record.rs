//! The checked record of a campaign, in SI units.
//!
//! Invariants (kept by the door, relied on everywhere else): at least one run; every run has at least 20 samples;
//! all columns of a run have equal length and hold finite numbers; time increases strictly; runs stand in canonical
//! order (place in the day, start on the campaign's clock, then content), so that names and the order of resources
//! influence no answer.

/// Whether motion is along a line (m, N) or about an axis (rad, N m).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// Velocity in m/s, position in m, force in N, mass in kg.
    Linear,
    /// Velocity in rad/s, position in rad, torque in N m, inertia in kg m^2.
    Rotary,
}

/// Where the numbers come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Provenance {
    /// Read off an instrument.
    Measured,
    /// Made by a program: every figure that shows it says so.
    Synthetic,
}

/// Direction of a run's motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Direction {
    /// Velocity is never below zero by more than 1 % of the run's largest speed (an encoder's noise at rest).
    Forward,
    /// Velocity is never above zero by more than 1 % of the run's largest speed.
    Reverse,
    /// The run reverses.
    Both,
}

/// What kind of motion was commanded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Protocol {
    /// Uniform acceleration.
    Ramp,
    /// One constant speed.
    Constant,
    /// A staircase of speeds.
    Steps,
    /// Back and forth.
    Cycles,
    /// Anything else.
    Free,
    /// Load zero: the reading without contact.
    Unloaded,
}

/// State of the bristle (or of the law's inner state) at the first sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum InitialState {
    /// At rest, no deflection.
    Relaxed,
    /// Bent by what went before: estimated with the run.
    Unknown,
}

/// One motion, from rest or steady. SI units; for a rotary rig read rad, rad/s, N m for m, m/s, N.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// Name of the resource: for messages and captions only, never for an answer.
    pub name: String,
    /// Direction of the motion.
    pub direction: Direction,
    /// Kind of motion.
    pub protocol: Protocol,
    /// Repeat number as stated (repeats are told by condition, never by this number).
    pub repeat: Option<u32>,
    /// Place of the run in the day.
    pub order: Option<f64>,
    /// Start of the run on the campaign's clock, s.
    pub started_s: Option<f64>,
    /// Nominal normal load, N; `None` where the rig has no load channel.
    pub normal_load_n: Option<f64>,
    /// Stage coordinate of the first sample, m, forward positive.
    pub start_position_m: f64,
    /// The rig was turned round (breaks the tie between tilt and crosstalk).
    pub stage_turned: bool,
    /// The specimen was turned round.
    pub specimen_turned: bool,
    /// State at the first sample.
    pub initial_state: InitialState,
    /// Time since the run's own zero, s, strictly increasing.
    pub time_s: Vec<f64>,
    /// Commanded or encoder velocity of the stage, m/s, forward positive.
    pub velocity_m_s: Vec<f64>,
    /// Recorded friction force, N, with the sign of the velocity for a healthy rig.
    pub force_n: Vec<f64>,
    /// Recorded stage coordinate, m, forward positive.
    pub position_m: Option<Vec<f64>>,
    /// Recorded normal force, N; where present it counts and `normal_load_n` is nominal.
    pub normal_force_n: Option<Vec<f64>>,
    /// Recorded temperature, degrees Celsius.
    pub temperature_c: Option<Vec<f64>>,
}

/// The specimen under test.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Specimen {
    /// Layout of the brushes, such as `2x2`; its presence makes the asymmetric bristle the default law.
    pub layout: Option<String>,
    /// Bristle length, m.
    pub bristle_length_m: Option<f64>,
    /// Bristle diameter, m.
    pub bristle_diameter_m: Option<f64>,
    /// Gap h between body and substrate, m.
    pub contact_height_m: Option<f64>,
}

/// What is known of the rig.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RigData {
    /// Full scale of the force sensor, N.
    pub sensor_full_scale_n: Option<f64>,
    /// Accuracy of the force sensor, percent of full scale.
    pub sensor_accuracy_percent_fs: Option<f64>,
    /// Nominal sample rate, Hz.
    pub sample_rate_hz: Option<f64>,
    /// Length of the stage's travel, m.
    pub travel_m: Option<f64>,
    /// Mass that moves between contact and sensor, kg (rotary: inertia, kg m^2).
    pub moving_mass_kg: Option<f64>,
}

/// A checked campaign.
#[derive(Clone, Debug, PartialEq)]
pub struct Campaign {
    /// Name of the package.
    pub name: String,
    /// Title of the package, or its name.
    pub title: String,
    /// Measured or synthetic.
    pub provenance: Provenance,
    /// Linear or rotary.
    pub axis: Axis,
    /// The specimen.
    pub specimen: Specimen,
    /// Counterface material as stated.
    pub counterface: Option<String>,
    /// The rig.
    pub rig: RigData,
    /// Runs in canonical order.
    pub runs: Vec<Run>,
    /// Files that were read, relative to the package, with their blake3 hashes, in canonical order.
    pub input_hashes: Vec<(String, String)>,
}

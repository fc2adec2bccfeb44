//! Days at the rig: the paper's and richer ones.
//!
//! All motions have their kinks on sample times, as a controller that clocks its logger has.

use crate::motion::Motion;
use crate::plan::{Axis, Plan, RunPlan};
use serde::{Deserialize, Serialize};

/// A day at the rig by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Protocol {
    /// Three ramps forward, then three in reverse, one load.
    PaperBlocked,
    /// Three ramps each way, alternating, one load.
    PaperAlternating,
    /// Fourteen runs: ramps, steps, constant speeds, reversals; two loads, mixed order, uneven rests.
    Rich,
    /// `Rich` with the stage coordinate recorded, an unloaded run, runs with the stage and with the specimen turned.
    RichTurned,
    /// Ramps each way at three loads, twice, mixed order.
    Loads,
    /// Constant speeds each way, with two ramps, one load.
    Speeds,
    /// A linear drive without a load channel: back and forth at several rates, 200 samples a second.
    Drive,
    /// The same about an axis, in rad and N m.
    Rotary,
}

impl Protocol {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::PaperBlocked,
        Self::PaperAlternating,
        Self::Rich,
        Self::RichTurned,
        Self::Loads,
        Self::Speeds,
        Self::Drive,
        Self::Rotary,
    ];

    /// Short name.
    pub fn id(self) -> &'static str {
        match self {
            Self::PaperBlocked => "paper-blocked",
            Self::PaperAlternating => "paper-alternating",
            Self::Rich => "rich",
            Self::RichTurned => "rich-turned",
            Self::Loads => "loads",
            Self::Speeds => "speeds",
            Self::Drive => "drive",
            Self::Rotary => "rotary",
        }
    }

    /// Whether the specimen is a brush on a plate under a load.
    pub fn is_brush(self) -> bool {
        !matches!(self, Self::Drive | Self::Rotary)
    }

    /// Whether rests between runs differ.
    pub fn has_uneven_rests(self) -> bool {
        !matches!(self, Self::PaperBlocked | Self::PaperAlternating)
    }

    /// The day's plan.
    pub fn plan(self) -> Plan {
        match self {
            Self::Drive => drive(Axis::Linear),
            Self::Rotary => drive(Axis::Rotary),
            _ => brush_day(self),
        }
    }
}

/// Load of the light brush and speed range of its stage; the plate is 0.3 m long.
const LIGHT_LOAD_N: f64 = 2.08;
const TOP_SPEED_M_S: f64 = 0.06;
const TRAVEL_M: f64 = 0.3;
/// Samples a second of the slow logger.
const RATE_HZ: f64 = 60.0;

/// A run before it has a place in the day.
#[derive(Clone)]
struct Draft(RunPlan);

impl Draft {
    fn new(protocol: &'static str, sign: f64, points: &[(f64, f64)]) -> Self {
        let motion = Motion::through(
            &points
                .iter()
                .map(|(t, v)| (*t, sign * v))
                .collect::<Vec<_>>(),
        );
        Self(RunPlan {
            direction: if sign > 0.0 { "forward" } else { "reverse" },
            protocol,
            load_n: Some(LIGHT_LOAD_N),
            started_s: 0.0,
            start_position_m: if sign > 0.0 { 0.0 } else { TRAVEL_M },
            motion,
            stage_turned: false,
            specimen_turned: false,
            starts_bent: false,
        })
    }

    fn load(mut self, factor: f64) -> Self {
        self.0.load_n = Some(factor * LIGHT_LOAD_N);
        self
    }
}

fn ramp(sign: f64) -> Draft {
    Draft::new("ramp", sign, &[(0.0, 0.0), (10.0, TOP_SPEED_M_S)])
}

fn constant(sign: f64, speed: f64) -> Draft {
    Draft::new("constant", sign, &[(0.0, 0.0), (0.5, speed), (10.0, speed)])
}

/// A staircase: each speed held for two seconds less the tenth of a second that the stage needs to change it.
fn steps(sign: f64, speeds: &[f64]) -> Draft {
    let mut points = vec![(0.0, 0.0)];
    for (index, speed) in speeds.iter().enumerate() {
        points.push((2.0 * index as f64 + 0.1, *speed));
        points.push((2.0 * (index + 1) as f64, *speed));
    }
    Draft::new("steps", sign, &points)
}

/// Back and forth in the middle of the plate, speed as a triangle of two seconds up and two down.
fn cycles(speed: f64) -> Draft {
    let mut draft = Draft::new(
        "cycles",
        1.0,
        &[
            (0.0, 0.0),
            (1.0, speed),
            (3.0, -speed),
            (5.0, speed),
            (7.0, -speed),
            (9.0, speed),
            (10.0, 0.0),
        ],
    );
    draft.0.direction = "both";
    draft.0.start_position_m = 0.12;
    draft
}

fn brush_day(protocol: Protocol) -> Plan {
    let up = [0.005, 0.01, 0.02, 0.04, 0.06];
    let mixed = [0.02, 0.05, 0.005, 0.04, 0.01];
    let drafts: Vec<Draft> = match protocol {
        Protocol::PaperBlocked => [1.0, 1.0, 1.0, -1.0, -1.0, -1.0].map(ramp).to_vec(),
        Protocol::PaperAlternating => [1.0, -1.0, 1.0, -1.0, 1.0, -1.0].map(ramp).to_vec(),
        Protocol::Loads => [1.0, 1.5, 2.0, 1.5, 1.0, 2.0]
            .into_iter()
            .flat_map(|factor| [ramp(1.0).load(factor), ramp(-1.0).load(factor)])
            .collect(),
        Protocol::Speeds => [0.005, 0.02, 0.01, 0.028, 0.003]
            .into_iter()
            .flat_map(|speed| [constant(1.0, speed), constant(-1.0, speed)])
            .chain([ramp(1.0), ramp(-1.0), ramp(1.0), ramp(-1.0)])
            .collect(),
        _ => rich(&up, &mixed),
    };
    let mut runs: Vec<RunPlan> = drafts.into_iter().map(|draft| draft.0).collect();
    if protocol == Protocol::RichTurned {
        turned_runs(&mut runs);
    }
    // A minute from start to start in the paper's days.
    let rests: &[f64] = if protocol.has_uneven_rests() {
        &[30.0, 300.0, 20.0, 60.0, 900.0, 15.0, 120.0]
    } else {
        &[50.0]
    };
    place_in_the_day(&mut runs, rests);
    Plan {
        axis: Axis::Linear,
        sample_rate_hz: RATE_HZ,
        travel_m: TRAVEL_M,
        full_scale_n: 5.0,
        accuracy_percent: 0.02,
        moving_mass_kg: None,
        records_position: protocol == Protocol::RichTurned,
        runs,
    }
}

fn rich(up: &[f64], mixed: &[f64]) -> Vec<Draft> {
    vec![
        ramp(1.0),
        ramp(-1.0),
        steps(1.0, up),
        ramp(1.0).load(2.0),
        steps(-1.0, mixed),
        cycles(0.03),
        ramp(-1.0).load(2.0),
        ramp(1.0),
        ramp(-1.0),
        constant(1.0, 0.028),
        steps(1.0, up),
        cycles(0.03),
        ramp(-1.0).load(2.0),
        ramp(1.0),
    ]
}

fn turned_runs(runs: &mut Vec<RunPlan>) {
    let mut unloaded = ramp(1.0).0;
    unloaded.protocol = "unloaded";
    unloaded.load_n = Some(0.0);
    runs.insert(3, unloaded);
    for (index, sign) in [(6, 1.0), (9, -1.0)] {
        let mut turned = ramp(sign).0;
        turned.stage_turned = true;
        runs.insert(index, turned);
    }
    for sign in [1.0, -1.0] {
        let mut turned = ramp(sign).0;
        turned.specimen_turned = true;
        runs.push(turned);
    }
}

fn place_in_the_day(runs: &mut [RunPlan], rests: &[f64]) {
    let mut clock = 0.0;
    for (index, run) in runs.iter_mut().enumerate() {
        run.started_s = clock;
        clock += run.motion.duration_s() + rests[index % rests.len()];
    }
}

/// Ten runs of reversing motion of a drive: three amplitudes of speed at three rates of change, most of them twice.
fn drive(axis: Axis) -> Plan {
    let scale = if axis == Axis::Rotary { 10.0 } else { 1.0 };
    // (top speed m/s, period s)
    let kinds: [(f64, f64); 4] = [(0.05, 4.0), (0.02, 2.0), (0.1, 4.0), (0.05, 1.0)];
    let mut runs = Vec::new();
    for index in [0, 1, 2, 3, 0, 2, 1, 3, 0, 2] {
        let (speed, period) = kinds[index];
        let points: Vec<(f64, f64)> = (0..=DRIVE_SAMPLES)
            .map(|i| {
                let time = f64::from(i) / DRIVE_RATE_HZ;
                let duration = f64::from(DRIVE_SAMPLES) / DRIVE_RATE_HZ;
                // The swing grows and dies within a quarter of a period, so that it starts and ends without a jerk.
                let rise =
                    smooth(time / (0.25 * period)) * smooth((duration - time) / (0.25 * period));
                (
                    time,
                    scale * speed * rise * (std::f64::consts::TAU * time / period).sin(),
                )
            })
            .collect();
        let mut run = Draft::new("cycles", 1.0, &points).0;
        run.direction = "both";
        run.load_n = None;
        run.start_position_m = 0.1 * scale;
        runs.push(run);
    }
    place_in_the_day(&mut runs, &[20.0, 5.0, 60.0, 300.0]);
    Plan {
        axis,
        sample_rate_hz: DRIVE_RATE_HZ,
        travel_m: 0.4 * scale,
        full_scale_n: 50.0,
        accuracy_percent: 0.02,
        moving_mass_kg: Some(if axis == Axis::Rotary { 0.05 } else { 2.0 }),
        records_position: true,
        runs,
    }
}

const DRIVE_RATE_HZ: f64 = 200.0;
/// Eight seconds.
const DRIVE_SAMPLES: i32 = 1600;

/// Rises smoothly from 0 at 0 to 1 at 1.
fn smooth(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// No run leaves the plate, no two runs overlap, and all motions end on a sample.
    #[test]
    fn runs_stay_on_the_plate_and_in_their_turn() {
        for protocol in Protocol::ALL {
            let plan = protocol.plan();
            let mut clock = -1.0;
            for run in &plan.runs {
                assert!(run.started_s > clock, "{protocol:?}");
                clock = run.started_s + run.motion.duration_s();
                let samples = run.motion.duration_s() * plan.sample_rate_hz;
                assert!((samples - samples.round()).abs() < 1e-9, "{protocol:?}");
                for time in run.motion.breakpoints() {
                    let x = run.start_position_m + run.motion.position(time);
                    assert!(
                        x > -1e-9 && x < plan.travel_m + 1e-9,
                        "{protocol:?}: {x} m at {time} s"
                    );
                }
            }
        }
    }
}

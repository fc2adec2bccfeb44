//! Draws an effect of a named kind: its size as a multiple of a physically plausible one, its other parameters
//! (periods, phases, time constants) at random within what such rigs show.

use crate::effect::{Ageing, Clock, Course, Effect, Filter, Opens, Remembers, Settling, Wave};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

/// The causes of the catalogue.
pub const CAUSES: [&str; 27] = [
    "stage-ripple",
    "cord-compliance",
    "stribeck-shape",
    "velocity-strengthening",
    "lean-angle",
    "bristle-set",
    "wear",
    "thermal-softening",
    "surface-texture",
    "surface-gradient",
    "load-dependence",
    "load-oscillation",
    "force-zero-offset",
    "stage-tilt",
    "force-zero-drift",
    "force-gain",
    "sensor-lag",
    "force-saturation",
    "force-resolution",
    "clock-offset",
    "direction-asymmetry",
    "frictional-memory",
    "dwell-ageing",
    "backlash",
    "velocity-lag",
    "load-crosstalk",
    "moving-inertia",
];

/// Effects outside the catalogue.
pub const ALIENS: [&str; 8] = [
    "alien-scratch",
    "alien-plate-step",
    "alien-stick-slip-burst",
    "alien-loose-clamp",
    "alien-second-population",
    "alien-debris",
    "alien-other-specimen",
    "alien-dropout",
];

/// Causes that can be planted in a second shape.
pub const SECOND_SHAPES: [&str; 15] = [
    "stage-ripple",
    "cord-compliance",
    "velocity-strengthening",
    "bristle-set",
    "wear",
    "thermal-softening",
    "surface-texture",
    "surface-gradient",
    "load-oscillation",
    "sensor-lag",
    "direction-asymmetry",
    "frictional-memory",
    "dwell-ageing",
    "backlash",
    "velocity-lag",
];

/// Scales of the rig that sizes refer to.
#[derive(Clone, Copy, Debug)]
pub struct Scales {
    /// Whether the load is in the record, so that friction has a coefficient.
    pub loaded: bool,
    /// Largest friction force of a healthy day at its lightest load, N.
    pub force_n: f64,
    /// Largest reading of the healthy day, N (only computed where something clips).
    pub largest_force_n: f64,
    /// Top speed, m/s.
    pub speed_m_s: f64,
    /// Length of the plate, m.
    pub travel_m: f64,
    /// Path of the whole day, m.
    pub path_m: f64,
    /// Duration of the whole day, s.
    pub day_s: f64,
    /// Highest acceleration, m/s^2.
    pub acceleration_m_s2: f64,
    /// Distance over which the inner state builds up, m.
    pub build_up_m: f64,
}

/// An effect of the kind `id`, `size` times the plausible one; `second` chooses another mechanism where there is one.
/// Returns `None` for an unknown id.
pub fn draw(
    id: &str,
    size: f64,
    second: bool,
    scales: &Scales,
    generator: &mut ChaCha8Rng,
) -> Option<Effect> {
    let mut between = |low: f64, high: f64| low + (high - low) * generator.random::<f64>();
    let phase_rad = between(0.0, TAU);
    let share = between(0.0, 1.0);
    let sign = if between(0.0, 1.0) < 0.5 { -1.0 } else { 1.0 };
    // A length between a sixtieth and a twelfth of the plate, evenly in its logarithm.
    let length_m = scales.travel_m / 60.0 * 5.0_f64.powf(share);
    let wave = match (second, sign > 0.0) {
        (false, _) => Wave::Sine,
        (true, true) => Wave::Square,
        (true, false) => Wave::Saw,
    };
    let filter = if second {
        Filter::SecondOrder
    } else {
        Filter::FirstOrder
    };
    let duration_s = scales.travel_m / scales.speed_m_s;
    let effect = match id {
        "stage-ripple" => Effect::StageRipple {
            amplitude: 0.10 * size,
            pitch_m: length_m,
            phase_rad,
            wave: if second { Wave::Triangle } else { Wave::Sine },
        },
        "cord-compliance" => {
            // Stretch of a two-hundredth of the plate under the full force; damping a tenth of critical.
            let compliance_m_n = size * 5e-3 * scales.travel_m / scales.force_n;
            let mass = 0.2;
            Effect::CordCompliance {
                compliance_m_n,
                damping_n_s_m: 0.2 * (mass / compliance_m_n).sqrt(),
                hardening_m: second.then_some(1.2 * compliance_m_n * scales.force_n),
            }
        }
        "stribeck-shape" => Effect::StribeckShape {
            exponent_minus_2: (sign * size).clamp(-1.6, 6.0),
        },
        // Only a recorded load tells what is added to the coefficient from what multiplies it.
        "velocity-strengthening" => Effect::VelocityStrengthening {
            quadratic_s2_m2: 0.08 * size / scales.speed_m_s.powi(2),
            added: scales.loaded != (second && share < 0.5),
            cubic_from_m_s: (second && share >= 0.5).then_some(scales.speed_m_s),
        },
        "lean-angle" => Effect::LeanAngle {
            angle_rad: 0.05 * size * sign,
        },
        "bristle-set" => Effect::BristleSet {
            angle_rad: 0.04 * size * sign,
            runs: between(0.7, 2.5),
            settling: match (second, share) {
                (false, _) => Settling::ByRuns,
                (true, share) if share < 0.4 => Settling::Kept,
                (true, share) if share < 0.7 => {
                    Settling::WithTheWay(scales.travel_m * between(0.2, 0.8))
                }
                (true, _) => Settling::LostWithTheWay(scales.travel_m * between(0.2, 0.8)),
            },
        },
        "wear" => Effect::Wear {
            amplitude: 0.08 * size * sign,
            distance_m: scales.path_m * between(0.15, 0.6),
            course: if second {
                Course::Power(0.4)
            } else {
                Course::Saturating
            },
        },
        "thermal-softening" => Effect::ThermalSoftening {
            strength_per_j: 0.08 * size / (scales.force_n * scales.travel_m),
            time_constant_s: duration_s * between(3.0, 15.0),
            levels_off: second,
        },
        "surface-texture" => Effect::SurfaceTexture {
            amplitude: 0.02 * size,
            wavelength_m: length_m,
            phase_rad,
            wave,
        },
        "surface-gradient" => Effect::SurfaceGradient {
            slope_per_m: sign * 0.06 * size / scales.travel_m,
            fading_m: second.then_some(0.3 * scales.travel_m),
        },
        "load-dependence" => Effect::LoadDependence {
            exponent: sign * 0.1 * size,
        },
        "load-oscillation" => Effect::LoadOscillation {
            amplitude: 0.02 * size,
            frequency_hz: 0.4 * 12.0_f64.powf(share),
            phase_rad,
            wave: if second { Wave::Triangle } else { Wave::Sine },
            clock: if second { Clock::Day } else { Clock::Run },
        },
        "force-zero-offset" => Effect::ForceZeroOffset {
            force_n: sign * 0.03 * size * scales.force_n,
        },
        "stage-tilt" => Effect::StageTilt {
            angle_rad: sign * 0.025 * size,
        },
        "force-zero-drift" => Effect::ForceZeroDrift {
            rate_n_s: sign * 0.05 * size * scales.force_n / scales.day_s,
        },
        "force-gain" => Effect::ForceGain {
            gain_minus_1: sign * 0.05 * size,
        },
        "sensor-lag" => Effect::SensorLag {
            time_constant_s: 0.1 * size,
            filter,
        },
        "force-saturation" => Effect::ForceSaturation {
            level_n: scales.largest_force_n * (1.0 - 0.08 * size).max(0.3),
        },
        "force-resolution" => Effect::ForceResolution {
            step_n: 0.02 * size * scales.force_n,
        },
        "clock-offset" => Effect::ClockOffset {
            delay_s: sign * 0.08 * size,
        },
        // Twice the friction in one direction is half of it in the other; no ratio turns friction round.
        "direction-asymmetry" => Effect::DirectionAsymmetry {
            coulomb_ratio_minus_1: (1.0 + 0.1 * size).powf(sign) - 1.0,
            viscous_ratio_minus_1: (1.0 + 0.2 * size).powf(sign) - 1.0,
            jumps: second,
        },
        "frictional-memory" => {
            if second {
                Effect::FrictionalMemory {
                    time_constant_s: None,
                    distance_m: Some(0.5 * size * scales.build_up_m),
                    remembers: match (sign > 0.0, share < 0.5) {
                        (true, _) => Remembers::Magnitude,
                        (false, true) => Remembers::ViscousToo,
                        (false, false) => Remembers::Curve,
                    },
                }
            } else {
                Effect::FrictionalMemory {
                    time_constant_s: Some(0.2 * size),
                    distance_m: None,
                    remembers: Remembers::Curve,
                }
            }
        }
        "dwell-ageing" => Effect::DwellAgeing {
            per_decade: 0.06 * size,
            ends: match (second, sign > 0.0) {
                (false, _) => Ageing::WithTheRun,
                (true, true) if share < 0.5 => Ageing::Grown(5.0 * scales.build_up_m),
                (true, true) => Ageing::Fading(5.0 * scales.build_up_m),
                (true, false) => Ageing::InTurning,
            },
        },
        "backlash" => Effect::Backlash {
            gap_m: 0.15 * size * scales.build_up_m,
            opens: match (second, share < 0.5) {
                (false, _) => Opens::WhereItTurns,
                (true, true) => Opens::FromRunToRun,
                (true, false) => Opens::WithoutForce,
            },
        },
        "velocity-lag" => Effect::VelocityLag {
            time_constant_s: 0.1 * size,
            filter,
        },
        "load-crosstalk" => Effect::LoadCrosstalk {
            ratio: sign * 0.025 * size,
        },
        "moving-inertia" => Effect::MovingInertia {
            mass_kg: 0.05 * size * scales.force_n / scales.acceleration_m_s2,
        },
        "alien-scratch" => Effect::Scratch {
            depth: 0.15 * size,
            edge: if second { 0.6 } else { 0.0 },
            at_m: scales.travel_m * between(0.3, 0.8),
            width_m: scales.travel_m / 100.0,
        },
        "alien-plate-step" => Effect::PlateStep {
            height: sign * 0.08 * size,
            at_m: scales.travel_m * between(0.35, 0.7),
        },
        "alien-stick-slip-burst" => {
            let from_s = duration_s * between(0.5, 1.0);
            Effect::StickSlipBurst {
                amplitude: 0.2 * size,
                from_s,
                to_s: from_s + 0.3 * duration_s,
                frequency_hz: between(3.0, 9.0),
                first_run: (3.0 * share) as usize,
                every: 2,
            }
        }
        "alien-loose-clamp" => Effect::LooseClamp {
            rock_rad: 0.06 * size * sign,
            mean_dwell_s: 0.25 * duration_s,
            from_run: 1 + (2.0 * share) as usize,
        },
        "alien-second-population" => Effect::SecondPopulation {
            share: (0.3 * size).min(0.8),
            length_ratio: 6.0,
            lean_rad: 0.5,
        },
        "alien-debris" => Effect::Debris {
            amplitude: 0.1 * size,
            interval_m: scales.travel_m / 8.0,
        },
        "alien-other-specimen" => {
            let first = 1 + (3.0 * share) as usize;
            Effect::OtherSpecimen {
                stiffness_minus_1: 0.04 * size,
                level_minus_1: -0.05 * size,
                runs: [first, first + 5],
            }
        }
        "alien-dropout" => {
            let from_s = duration_s * between(0.5, 1.0);
            Effect::Dropout {
                share: 0.1 * size,
                from_s,
                to_s: from_s + duration_s / 15.0,
                first_run: (4.0 * share) as usize,
                every: 4,
            }
        }
        _ => return None,
    };
    Some(effect)
}

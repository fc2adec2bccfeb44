//! What can be hidden in a rig: one variant for each mechanism, in physical terms and SI units.
//!
//! The first group are the causes of the catalogue; a variant's `shape` field chooses another mechanism of the same
//! cause (a second-order sensor, wear by a power law). The last group lies outside the catalogue.

use serde::{Deserialize, Serialize};

/// How a quantity saturates or grows along a distance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Course {
    /// 1 - exp(-s/d).
    Saturating,
    /// (s/d)^p.
    Power(f64),
}

/// Waveform of a periodic effect.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Wave {
    /// sin.
    Sine,
    /// Smooth-edged square, amplitude one.
    Square,
    /// Triangle, amplitude one.
    Triangle,
    /// Teeth of a saw, amplitude one: an even rise, and the fall within a twentieth of the period.
    Saw,
}

impl Wave {
    /// Value at `phase` (rad).
    pub fn at(self, phase: f64) -> f64 {
        match self {
            Self::Sine => phase.sin(),
            // Edges a twelfth of a period wide: a ground groove, not a mathematical jump.
            Self::Square => (6.0 * phase.sin()).tanh(),
            Self::Triangle => phase.sin().asin() * std::f64::consts::FRAC_2_PI,
            Self::Saw => {
                let place = (phase / std::f64::consts::TAU).rem_euclid(1.0);
                if place < 0.95 {
                    2.0 * place / 0.95 - 1.0
                } else {
                    1.0 - 2.0 * (place - 0.95) / 0.05
                }
            }
        }
    }
}

/// Which clock an oscillation follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Clock {
    /// It begins anew with every run.
    Run,
    /// It goes on between the runs.
    Day,
}

/// How a lasting bend settles.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Settling {
    /// From run to run, towards the bend in reverse and straight forward.
    ByRuns,
    /// From run to run, and forward runs leave it as it is.
    Kept,
    /// While the contact slides, over this distance, m, towards the bend in reverse and straight forward.
    WithTheWay(f64),
    /// A run that ends in reverse leaves the whole bend, and sliding over this distance, m, leaves a share of 1/e.
    LostWithTheWay(f64),
}

/// How long what rest has added to the level at rest is there.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Ageing {
    /// As long as the run.
    WithTheRun,
    /// Until the motion turns.
    InTurning,
    /// Sliding over this distance, m, leaves a share of 1/e.
    Fading(f64),
    /// The same, and the levels at all speeds have gained.
    Grown(f64),
}

/// What of friction has a memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Remembers {
    /// The Stribeck curve.
    Curve,
    /// The Stribeck curve, of the speed's magnitude.
    Magnitude,
    /// The curve and the viscous part.
    ViscousToo,
}

/// Where a play opens.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Opens {
    /// Where the motion turns within a run.
    WhereItTurns,
    /// There, and before a run that goes against the one before it.
    FromRunToRun,
    /// Where the contact has no force left after a turn.
    WithoutForce,
}

/// Which filter a channel has.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Filter {
    /// y' = (u - y)/tau.
    FirstOrder,
    /// Two equal stages of tau/2: the same delay, another shape.
    SecondOrder,
}

/// One thing that differs from the healthy rig.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "mechanism")]
#[allow(missing_docs)]
pub enum Effect {
    /// The drive's true speed ripples with its pitch: v = v_cmd (1 + a sin(2 pi x/p + phase)).
    StageRipple {
        amplitude: f64,
        pitch_m: f64,
        phase_rad: f64,
        wave: Wave,
    },
    /// The brush (its own mass) hangs on a spring and a dashpot; `hardening_m`: stretch at which the stiffness doubles.
    CordCompliance {
        compliance_m_n: f64,
        damping_n_s_m: f64,
        hardening_m: Option<f64>,
    },
    /// Exponent of the Stribeck curve.
    StribeckShape { exponent_minus_2: f64 },
    /// Friction grows with the square of speed: factor 1 + q v^2, or `added` to the coefficient, q v^2. With a `cubic_from_m_s`
    /// it grows with the cube and is as large as the square at that speed.
    VelocityStrengthening {
        quadratic_s2_m2: f64,
        added: bool,
        cubic_from_m_s: Option<f64>,
    },
    /// Another lean.
    LeanAngle { angle_rad: f64 },
    /// A bend that stays after reverse runs and settles over runs.
    BristleSet {
        angle_rad: f64,
        runs: f64,
        settling: Settling,
    },
    /// Friction changes with the distance slid since the campaign began.
    Wear {
        amplitude: f64,
        distance_m: f64,
        course: Course,
    },
    /// Frictional energy heats the contact, which cools with a time constant; friction falls with the energy held.
    ThermalSoftening {
        strength_per_j: f64,
        time_constant_s: f64,
        /// Falls as 1/(1 + k E) instead of 1 - k E.
        levels_off: bool,
    },
    /// Friction ripples along the plate.
    SurfaceTexture {
        amplitude: f64,
        wavelength_m: f64,
        phase_rad: f64,
        wave: Wave,
    },
    /// Friction changes along the plate, linearly or as an exponential that has fallen to 1/e of its slope over `fading_m`.
    SurfaceGradient {
        slope_per_m: f64,
        fading_m: Option<f64>,
    },
    /// mu ~ N^-a.
    LoadDependence { exponent: f64 },
    /// The load swings in time.
    LoadOscillation {
        amplitude: f64,
        frequency_hz: f64,
        phase_rad: f64,
        wave: Wave,
        clock: Clock,
    },
    /// A constant force is added to the reading.
    ForceZeroOffset { force_n: f64 },
    /// The stage leans: a share of the weight acts along it.
    StageTilt { angle_rad: f64 },
    /// The zero moves with the clock.
    ForceZeroDrift { rate_n_s: f64 },
    /// The force reads too large.
    ForceGain { gain_minus_1: f64 },
    /// The force channel is filtered.
    SensorLag {
        time_constant_s: f64,
        filter: Filter,
    },
    /// The force clips.
    ForceSaturation { level_n: f64 },
    /// The force is rounded to steps.
    ForceResolution { step_n: f64 },
    /// The force channel lags by a pure delay.
    ClockOffset { delay_s: f64 },
    /// Friction in reverse differs from forward by these ratios; `jumps`: the bristles' force itself does, rather than the level to
    /// which they bend.
    DirectionAsymmetry {
        coulomb_ratio_minus_1: f64,
        viscous_ratio_minus_1: f64,
        jumps: bool,
    },
    /// Friction sees the speed of a while ago (time) or of a distance ago.
    FrictionalMemory {
        time_constant_s: Option<f64>,
        distance_m: Option<f64>,
        remembers: Remembers,
    },
    /// The level at rest grows with the logarithm of the rest before the run.
    DwellAgeing { per_decade: f64, ends: Ageing },
    /// Play between stage and contact.
    Backlash { gap_m: f64, opens: Opens },
    /// The velocity channel is filtered.
    VelocityLag {
        time_constant_s: f64,
        filter: Filter,
    },
    /// The force channel reads a part of the load.
    LoadCrosstalk { ratio: f64 },
    /// A mass moves between contact and sensor.
    MovingInertia { mass_kg: f64 },

    // Outside the catalogue.
    /// A scratch across the plate: a narrow rise of friction at one place, and a fall of `edge` times its depth beside it, two
    /// widths further on.
    Scratch {
        depth: f64,
        edge: f64,
        at_m: f64,
        width_m: f64,
    },
    /// Two plates butted: friction steps at one place.
    PlateStep { height: f64, at_m: f64 },
    /// Stick-slip breaks out for a while in some runs: a sawtooth on friction.
    StickSlipBurst {
        amplitude: f64,
        from_s: f64,
        to_s: f64,
        frequency_hz: f64,
        first_run: usize,
        every: usize,
    },
    /// A clamp works loose: the fixture rocks between two leans at random moments.
    LooseClamp {
        rock_rad: f64,
        mean_dwell_s: f64,
        from_run: usize,
    },
    /// A second population of bristles, longer in its relaxation and leaning the other way, carries a share.
    SecondPopulation {
        share: f64,
        length_ratio: f64,
        lean_rad: f64,
    },
    /// Dust gathers before the brush and is shed: friction rises and falls irregularly along each run.
    Debris { amplitude: f64, interval_m: f64 },
    /// Two runs (by their place in the day) were made with another specimen: stiffer bristles, and another level of friction.
    OtherSpecimen {
        stiffness_minus_1: f64,
        level_minus_1: f64,
        runs: [usize; 2],
    },
    /// An amplifier drops out for a moment in some runs: the force reads too small by a share.
    Dropout {
        share: f64,
        from_s: f64,
        to_s: f64,
        first_run: usize,
        every: usize,
    },
}

impl Effect {
    /// Id of the cause in the catalogue, or of the alien.
    pub fn id(&self) -> &'static str {
        match self {
            Self::StageRipple { .. } => "stage-ripple",
            Self::CordCompliance { .. } => "cord-compliance",
            Self::StribeckShape { .. } => "stribeck-shape",
            Self::VelocityStrengthening { .. } => "velocity-strengthening",
            Self::LeanAngle { .. } => "lean-angle",
            Self::BristleSet { .. } => "bristle-set",
            Self::Wear { .. } => "wear",
            Self::ThermalSoftening { .. } => "thermal-softening",
            Self::SurfaceTexture { .. } => "surface-texture",
            Self::SurfaceGradient { .. } => "surface-gradient",
            Self::LoadDependence { .. } => "load-dependence",
            Self::LoadOscillation { .. } => "load-oscillation",
            Self::ForceZeroOffset { .. } => "force-zero-offset",
            Self::StageTilt { .. } => "stage-tilt",
            Self::ForceZeroDrift { .. } => "force-zero-drift",
            Self::ForceGain { .. } => "force-gain",
            Self::SensorLag { .. } => "sensor-lag",
            Self::ForceSaturation { .. } => "force-saturation",
            Self::ForceResolution { .. } => "force-resolution",
            Self::ClockOffset { .. } => "clock-offset",
            Self::DirectionAsymmetry { .. } => "direction-asymmetry",
            Self::FrictionalMemory { .. } => "frictional-memory",
            Self::DwellAgeing { .. } => "dwell-ageing",
            Self::Backlash { .. } => "backlash",
            Self::VelocityLag { .. } => "velocity-lag",
            Self::LoadCrosstalk { .. } => "load-crosstalk",
            Self::MovingInertia { .. } => "moving-inertia",
            Self::Scratch { .. } => "alien-scratch",
            Self::PlateStep { .. } => "alien-plate-step",
            Self::StickSlipBurst { .. } => "alien-stick-slip-burst",
            Self::LooseClamp { .. } => "alien-loose-clamp",
            Self::SecondPopulation { .. } => "alien-second-population",
            Self::Debris { .. } => "alien-debris",
            Self::OtherSpecimen { .. } => "alien-other-specimen",
            Self::Dropout { .. } => "alien-dropout",
        }
    }

    /// Whether the effect lies outside the catalogue.
    pub fn is_alien(&self) -> bool {
        self.id().starts_with("alien-")
    }

    /// Whether the mechanism has the very shape that the catalogue describes, so that its parameters can be compared.
    pub fn has_catalogue_shape(&self) -> bool {
        match self {
            Self::StageRipple { wave, .. }
            | Self::SurfaceTexture { wave, .. }
            | Self::LoadOscillation { wave, .. } => *wave == Wave::Sine,
            Self::DwellAgeing { ends, .. } => *ends == Ageing::WithTheRun,
            Self::DirectionAsymmetry { jumps, .. } => !jumps,
            Self::CordCompliance { hardening_m, .. } => hardening_m.is_none(),
            Self::Wear { course, .. } => *course == Course::Saturating,
            Self::ThermalSoftening { levels_off, .. } => !levels_off,
            Self::BristleSet { settling, .. } => *settling == Settling::ByRuns,
            Self::SensorLag { filter, .. } | Self::VelocityLag { filter, .. } => {
                *filter == Filter::FirstOrder
            }
            _ => !self.is_alien(),
        }
    }

    /// Phase of a periodic effect, rad.
    pub fn phase_rad(&self) -> Option<f64> {
        match *self {
            Self::StageRipple { phase_rad, .. }
            | Self::SurfaceTexture { phase_rad, .. }
            | Self::LoadOscillation { phase_rad, .. } => Some(phase_rad),
            _ => None,
        }
    }

    /// Size parameters under the catalogue's names, for the coverage of reported intervals.
    pub fn sizes(&self) -> Vec<(&'static str, f64)> {
        match *self {
            Self::StageRipple {
                amplitude, pitch_m, ..
            } => vec![("amplitude", amplitude), ("pitch_m", pitch_m)],
            Self::CordCompliance {
                compliance_m_n,
                damping_n_s_m,
                ..
            } => {
                vec![
                    ("compliance_m_n", compliance_m_n),
                    ("damping_n_s_m", damping_n_s_m),
                ]
            }
            Self::StribeckShape { exponent_minus_2 } => {
                vec![("exponent_minus_2", exponent_minus_2)]
            }
            Self::VelocityStrengthening {
                quadratic_s2_m2, ..
            } => {
                vec![("quadratic_s2_m2", quadratic_s2_m2)]
            }
            Self::LeanAngle { angle_rad } => vec![("angle_rad", angle_rad)],
            Self::BristleSet {
                angle_rad, runs, ..
            } => vec![("angle_rad", angle_rad), ("runs", runs)],
            Self::Wear {
                amplitude,
                distance_m,
                ..
            } => vec![("amplitude", amplitude), ("distance_m", distance_m)],
            Self::ThermalSoftening {
                strength_per_j,
                time_constant_s,
                ..
            } => {
                vec![
                    ("strength_per_j", strength_per_j),
                    ("time_constant_s", time_constant_s),
                ]
            }
            Self::SurfaceTexture {
                amplitude,
                wavelength_m,
                ..
            } => {
                vec![("amplitude", amplitude), ("wavelength_m", wavelength_m)]
            }
            Self::SurfaceGradient { slope_per_m, .. } => vec![("slope_per_m", slope_per_m)],
            Self::LoadDependence { exponent } => vec![("exponent", exponent)],
            Self::LoadOscillation {
                amplitude,
                frequency_hz,
                ..
            } => {
                vec![("amplitude", amplitude), ("frequency_hz", frequency_hz)]
            }
            Self::ForceZeroOffset { force_n } => vec![("force_n", force_n)],
            Self::StageTilt { angle_rad } => vec![("angle_rad", angle_rad)],
            Self::ForceZeroDrift { rate_n_s } => vec![("rate_n_s", rate_n_s)],
            Self::ForceGain { gain_minus_1 } => vec![("gain_minus_1", gain_minus_1)],
            Self::SensorLag {
                time_constant_s, ..
            }
            | Self::VelocityLag {
                time_constant_s, ..
            } => {
                vec![("time_constant_s", time_constant_s)]
            }
            Self::ForceSaturation { level_n } => vec![("level_n", level_n)],
            Self::ForceResolution { step_n } => vec![("step_n", step_n)],
            Self::ClockOffset { delay_s } => vec![("delay_s", delay_s)],
            Self::DirectionAsymmetry {
                coulomb_ratio_minus_1,
                viscous_ratio_minus_1,
                ..
            } => {
                vec![
                    ("coulomb_ratio_minus_1", coulomb_ratio_minus_1),
                    ("viscous_ratio_minus_1", viscous_ratio_minus_1),
                ]
            }
            Self::FrictionalMemory {
                time_constant_s,
                distance_m,
                ..
            } => time_constant_s
                .map(|value| ("time_constant_s", value))
                .into_iter()
                .chain(distance_m.map(|value| ("distance_m", value)))
                .collect(),
            Self::DwellAgeing { per_decade, .. } => vec![("per_decade", per_decade)],
            Self::Backlash { gap_m, .. } => vec![("gap_m", gap_m)],
            Self::LoadCrosstalk { ratio } => vec![("ratio", ratio)],
            Self::MovingInertia { mass_kg } => vec![("mass_kg", mass_kg)],
            _ => Vec::new(),
        }
    }
}

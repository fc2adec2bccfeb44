//! A hidden-effect case: what is planted, on which day, how large, with which noise; written as a package that leaks
//! nothing, with the key kept apart.

use crate::effect::Effect;
use crate::law::{Bristle, Deflection, Law};
use crate::machine::{Recording, Rig, run_day};
use crate::package::{Label, files};
use crate::plan::{Noise, Plan};
use crate::protocols::Protocol;
use crate::roughness::{Grain, Tails, stream};
use crate::species::{Scales, draw};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// One thing to hide.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Planted {
    /// Cause or alien.
    pub id: String,
    /// Size as a multiple of a plausible one.
    pub size: f64,
    /// Another mechanism than the catalogue's.
    pub second_shape: bool,
}

/// The law that the rig obeys.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Base {
    /// Leaning bristles.
    AsymmetricBristle,
    /// Upright bristles.
    SymmetricBristle,
    /// LuGre.
    Lugre,
    /// Dahl.
    Dahl,
    /// Static Stribeck curve.
    Stribeck,
    /// Coulomb and viscous.
    CoulombViscous,
}

/// Imperfections of the healthy rig.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum NoiseKind {
    /// As in the stand-ins: half of the roughness fixed to the plate, 1 % scatter.
    Usual,
    /// Student t with four degrees of freedom.
    HeavyTails,
    /// Correlated over four times the distance.
    StrongCorrelation,
    /// 2 % scatter between runs.
    WideScatter,
    /// None of the roughness fixed to the plate.
    FreeRoughness,
    /// Nine tenths of the roughness fixed to the plate.
    PlateRoughness,
    /// Roughness without corners: white noise behind a Gaussian.
    SmoothRoughness,
    /// As usual; the load is recorded, by a cell with noise.
    LoadCell,
    /// As usual; the velocity channel has noise.
    Encoder,
    /// As usual; the amplifier's zero wanders by twice the sensor's noise.
    Amplifier,
    /// None at all, for comparisons of simulators.
    None,
}

impl NoiseKind {
    /// The kinds that "nothing planted" is tried with.
    pub const HEALTHY: [Self; 6] = [
        Self::Usual,
        Self::HeavyTails,
        Self::StrongCorrelation,
        Self::WideScatter,
        Self::FreeRoughness,
        Self::PlateRoughness,
    ];

    /// Short name.
    pub fn id(self) -> &'static str {
        match self {
            Self::Usual => "usual",
            Self::HeavyTails => "heavy-tails",
            Self::StrongCorrelation => "strong-correlation",
            Self::WideScatter => "wide-scatter",
            Self::FreeRoughness => "free-roughness",
            Self::PlateRoughness => "plate-roughness",
            Self::SmoothRoughness => "smooth-roughness",
            Self::LoadCell => "load-cell",
            Self::Encoder => "encoder",
            Self::Amplifier => "amplifier",
            Self::None => "none",
        }
    }

    /// Its numbers on a rig with this full scale and build-up distance.
    pub fn noise(self, full_scale_n: f64, accuracy_percent: f64, build_up_m: f64) -> Noise {
        let usual = Noise {
            roughness: 0.008,
            // 1.5 mm on the brush, whose bristles bend over 4 mm; a drive's is shorter in the same ratio.
            correlation_m: 0.375 * build_up_m,
            plate_share: 0.5,
            sensor_n: accuracy_percent / 100.0 * full_scale_n,
            scatter: 0.01,
            ..Noise::NONE
        };
        match self {
            Self::Usual => usual,
            Self::HeavyTails => Noise {
                tails: Tails::StudentT(4.0),
                ..usual
            },
            Self::StrongCorrelation => Noise {
                correlation_m: 4.0 * usual.correlation_m,
                ..usual
            },
            Self::WideScatter => Noise {
                scatter: 0.02,
                ..usual
            },
            Self::FreeRoughness => Noise {
                plate_share: 0.0,
                ..usual
            },
            Self::PlateRoughness => Noise {
                plate_share: 0.9,
                ..usual
            },
            Self::SmoothRoughness => Noise {
                grain: Grain::Smooth,
                ..usual
            },
            Self::LoadCell => Noise {
                load_cell: 0.005,
                ..usual
            },
            Self::Encoder => Noise {
                encoder: 0.001,
                ..usual
            },
            Self::Amplifier => Noise {
                wander_n: 2.0 * usual.sensor_n,
                ..usual
            },
            Self::None => Noise {
                correlation_m: usual.correlation_m,
                ..Noise::NONE
            },
        }
    }
}

/// A case, complete: the same case always makes the same files.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Case {
    /// What is hidden: nothing, one thing, or several.
    pub planted: Vec<Planted>,
    /// The law underneath.
    pub base: Base,
    /// The day at the rig.
    pub protocol: Protocol,
    /// Imperfections.
    pub noise: NoiseKind,
    /// Seed of the specimen: the law's parameters, and periods, phases and time constants of what is planted.
    pub specimen: u64,
    /// Seed of the noise and of the names in the package.
    pub seed: u64,
}

/// The answer, to be opened after the diagnosis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Key {
    /// Law with its parameters.
    pub law: Law,
    /// Effects with theirs.
    pub effects: Vec<Effect>,
}

/// A case carried out.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The answer.
    pub key: Key,
    /// The plan of the day.
    pub plan: Plan,
    /// What the logger wrote, in the order of the day.
    pub recordings: Vec<Recording>,
    /// Files of the package.
    pub files: Vec<(String, String)>,
}

impl Case {
    /// A case with nothing planted.
    pub fn nothing(protocol: Protocol, noise: NoiseKind, seed: u64) -> Self {
        let base = if protocol.is_brush() {
            Base::AsymmetricBristle
        } else {
            Base::Lugre
        };
        Self {
            planted: Vec::new(),
            base,
            protocol,
            noise,
            specimen: seed,
            seed,
        }
    }

    /// A case with one effect of `size` times the plausible one.
    /// Its specimen is the one that the seed gives.
    pub fn one(id: &str, size: f64, protocol: Protocol, seed: u64) -> Self {
        Self::nothing(protocol, NoiseKind::Usual, seed).with(id, size, false)
    }

    /// The same with another effect added.
    #[must_use]
    pub fn with(mut self, id: &str, size: f64, second_shape: bool) -> Self {
        self.planted.push(Planted {
            id: id.into(),
            size,
            second_shape,
        });
        self
    }

    /// The same on another specimen.
    #[must_use]
    pub fn of_specimen(mut self, specimen: u64) -> Self {
        self.specimen = specimen;
        self
    }

    /// The same on another law.
    #[must_use]
    pub fn on(mut self, base: Base) -> Self {
        self.base = base;
        self
    }

    /// The key alone.
    ///
    /// # Errors
    /// If a planted id is unknown.
    pub fn key(&self) -> Result<Key, String> {
        let plan = self.protocol.plan();
        let mut generator = stream(self.specimen, 1);
        let law = draw_law(self.base, &plan, &mut generator);
        let mut scales = scales(&law, &plan);
        if self
            .planted
            .iter()
            .any(|planted| planted.id == "force-saturation")
        {
            scales.largest_force_n = peak_force(law, &plan);
        }
        let mut effects = Vec::new();
        for (index, planted) in self.planted.iter().enumerate() {
            let mut generator = stream(self.specimen, 100 + index as u64);
            let effect = draw(
                &planted.id,
                planted.size,
                planted.second_shape,
                &scales,
                &mut generator,
            )
            .ok_or_else(|| format!("nothing of the name {:?} can be planted", planted.id))?;
            effects.push(effect);
        }
        Ok(Key { law, effects })
    }

    /// The rig of this case with its key's effects, its plan, and its imperfections.
    ///
    /// # Errors
    /// If a planted id is unknown.
    pub fn set_up(&self) -> Result<(Rig, Plan, Noise), String> {
        let plan = self.protocol.plan();
        let key = self.key()?;
        let build_up_m = scales(&key.law, &plan).build_up_m;
        let noise = self
            .noise
            .noise(plan.full_scale_n, plan.accuracy_percent, build_up_m);
        let reference_load_n = reference_load(&plan);
        Ok((
            Rig {
                law: key.law,
                effects: key.effects,
                reference_load_n,
            },
            plan,
            noise,
        ))
    }

    /// Carries the case out.
    ///
    /// # Errors
    /// If a planted id is unknown.
    pub fn carry_out(&self) -> Result<Outcome, String> {
        let (rig, plan, noise) = self.set_up()?;
        let recordings = run_day(&rig, &plan, &noise, self.seed.wrapping_add(0x9e37_79b9));
        let files = self.neutral_files(&plan, &recordings);
        let key = Key {
            law: rig.law,
            effects: rig.effects,
        };
        Ok(Outcome {
            key,
            plan,
            recordings,
            files,
        })
    }

    /// The package: names, numbering and listing of the runs are shuffled and say nothing.
    fn neutral_files(&self, plan: &Plan, recordings: &[Recording]) -> Vec<(String, String)> {
        let mut generator = stream(self.seed, 2);
        let count = plan.runs.len();
        let shuffled = |generator: &mut ChaCha8Rng| {
            let mut order: Vec<usize> = (0..count).collect();
            for i in (1..count).rev() {
                order.swap(i, generator.random_range(0..=i));
            }
            order
        };
        let numbers = shuffled(&mut generator);
        let listing = shuffled(&mut generator);
        let names: Vec<String> = numbers
            .iter()
            .map(|number| format!("run-{:02}", number + 1))
            .collect();
        let specimen = self.protocol.is_brush().then(|| {
            serde_json::json!({
                "layout": "2x2",
                "bristle_length_mm": 1e3 * HEIGHT_M,
                "bristle_diameter_mm": 0.1,
                "contact_height_mm": 1e3 * HEIGHT_M,
            })
        });
        let brush_law = matches!(self.base, Base::AsymmetricBristle | Base::SymmetricBristle);
        let label = Label {
            name: "campaign".into(),
            title: "Friction campaign".into(),
            description: None,
            specimen: specimen.filter(|_| brush_law),
            counterface: None,
        };
        files(&label, plan, recordings, &names, &listing)
    }
}

/// Speed at which a drawn law's viscous share is stated, m/s.
const TOP_SPEED_M_S: f64 = 0.06;

/// Height of the bristle roots above the plate, m.
const HEIGHT_M: f64 = 7.2e-3;

/// A plausible law: a brush of some hundred wires, or the friction of a small drive.
fn draw_law(base: Base, plan: &Plan, generator: &mut ChaCha8Rng) -> Law {
    let mut between = |low: f64, high: f64| low + (high - low) * generator.random::<f64>();
    let sigma = 200.0;
    let level = between(0.42, 0.60);
    let theta_c = sigma * level;
    let bristle = Bristle {
        sigma,
        theta_c,
        theta_s: theta_c * between(1.08, 1.3),
        w_sc: between(1.0, 2.4),
        sigma0: between(1.2, 1.9),
        sigma1: between(0.02, 0.12),
        sigma2: between(0.002, 0.012),
        theta0_rad: between(-0.34, -0.2),
        height_m: HEIGHT_M,
    };
    let with_load = plan.runs.iter().any(|run| run.load_n.is_some());
    // Without a load channel the law is in newtons (or N m): a drive with some newtons of friction.
    let force = if with_load {
        between(0.3, 0.6)
    } else {
        between(2.0, 5.0)
    };
    let top_speed = TOP_SPEED_M_S;
    let build_up_m = if with_load {
        between(0.5e-3, 1.5e-3)
    } else {
        between(1e-4, 4e-4) * rotary_scale(plan)
    };
    let stiffness = force / build_up_m;
    let deflection = Deflection {
        stiffness,
        damping: stiffness * between(0.001, 0.004),
        viscous: force * between(0.1, 0.5) / (top_speed * rotary_scale(plan)),
        coulomb: force,
        breakaway: force * between(1.1, 1.4),
        stribeck_speed: between(0.004, 0.012) * rotary_scale(plan),
    };
    match base {
        Base::AsymmetricBristle => Law::AsymmetricBristle(bristle),
        Base::SymmetricBristle => Law::AsymmetricBristle(Bristle {
            theta0_rad: 0.0,
            ..bristle
        }),
        Base::Lugre => Law::Lugre(deflection),
        Base::Dahl => Law::Dahl(deflection),
        Base::Stribeck => Law::Stribeck(deflection),
        Base::CoulombViscous => Law::CoulombViscous(deflection),
    }
}

/// Radians of the rotary protocols for a metre of the linear ones.
fn rotary_scale(plan: &Plan) -> f64 {
    if plan.axis == crate::plan::Axis::Rotary {
        10.0
    } else {
        1.0
    }
}

/// Scales of a healthy day, from the plan and the law.
fn scales(law: &Law, plan: &Plan) -> Scales {
    let mut scales = Scales {
        loaded: plan.runs.iter().all(|run| run.load_n.is_some()),
        force_n: 0.0,
        largest_force_n: 0.0,
        speed_m_s: 0.0,
        travel_m: plan.travel_m,
        path_m: 0.0,
        day_s: 1.0,
        acceleration_m_s2: 1e-9,
        build_up_m: match law {
            Law::AsymmetricBristle(bristle) => bristle.height_m * bristle.theta_c / bristle.sigma,
            Law::Lugre(d) | Law::Dahl(d) => d.coulomb / d.stiffness,
            Law::Stribeck(_) | Law::CoulombViscous(_) => 1e-3 * rotary_scale(plan),
        },
    };
    for run in &plan.runs {
        let edges = run.motion.breakpoints();
        for pair in edges.windows(2) {
            let inside = 0.5 * (pair[0] + pair[1]);
            scales.path_m += (run.motion.position(pair[1]) - run.motion.position(pair[0])).abs();
            scales.speed_m_s = scales
                .speed_m_s
                .max(run.motion.speed_within(pair[1], inside).abs());
            scales.acceleration_m_s2 = scales
                .acceleration_m_s2
                .max(run.motion.acceleration(inside, 0.01).abs());
        }
        scales.day_s = scales.day_s.max(run.started_s + run.motion.duration_s());
    }
    // Largest friction: slide at top speed until the inner state is steady, at the smallest load of a loaded run.
    let load_n = plan
        .runs
        .iter()
        .filter_map(|run| run.load_n.filter(|load| *load > 0.0))
        .fold(f64::INFINITY, f64::min);
    let steady = law.steady_coefficient(scales.speed_m_s);
    scales.force_n = steady * if load_n.is_finite() { load_n } else { 1.0 };
    scales.largest_force_n = scales.force_n;
    scales
}

/// Largest reading of the healthy day without noise, N: what an amplifier must not clip.
fn peak_force(law: Law, plan: &Plan) -> f64 {
    let reference_load_n = reference_load(plan);
    let rig = Rig {
        law,
        effects: Vec::new(),
        reference_load_n,
    };
    let day = run_day(&rig, plan, &Noise::NONE, 0);
    day.iter()
        .flat_map(|run| &run.force_n)
        .fold(0.0, |peak, force| peak.max(force.abs()))
}

/// Load at which the law's coefficients hold: that of the first loaded run, N.
fn reference_load(plan: &Plan) -> f64 {
    plan.runs
        .iter()
        .find_map(|run| run.load_n.filter(|load| *load > 0.0))
        .unwrap_or(1.0)
}

//! The stand-in campaigns: what the paper's rig would have recorded if its model were the whole truth.
//!
//! Everything comes from the recipe beside the campaigns; the lean of the bristles, which the paper does not give, is
//! computed here from its published steady coefficients.

use crate::effect::Effect;
use crate::law::{Bristle, Law};
use crate::machine::{Rig, STANDARD_GRAVITY_M_S2, run_day};
use crate::motion::Motion;
use crate::package::{Label, files};
use crate::plan::{Axis, Noise, Plan, RunPlan};
use crate::published::Published;
use serde::Deserialize;
use std::path::Path;

/// The recipe as it stands in `data/campaigns/recipe.toml`: our choices; the paper's numbers come from the published
/// ones.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Choices {
    #[serde(rename = "schema")]
    _schema: String,
    lean: Lean,
    protocol: Ramps,
    noise: Imperfections,
    campaign: Vec<Entry>,
}

/// The recipe together with the published numbers that it draws on.
#[derive(Clone, Debug)]
pub struct Recipe {
    choices: Choices,
    published: Published,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Lean {
    window_mm_s: [f64; 2],
    bracket_rad: [f64; 2],
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Ramps {
    order: String,
    interval_s: f64,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Imperfections {
    roughness_percent: f64,
    correlation_mm: f64,
    plate_share: f64,
    sensor_full_scale_n: f64,
    scatter_percent: f64,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    name: String,
    title: String,
    material: String,
    layout: String,
    seed: u64,
    cord_stiffness_n_m: Option<f64>,
    cord_damping_ratio: Option<f64>,
}

/// Why stand-ins could not be made.
pub type Failure = Box<dyn std::error::Error>;

impl Recipe {
    /// Reads the recipe in `folder` and the published numbers beside that folder.
    ///
    /// # Errors
    /// If a file cannot be read or is not what it should be.
    pub fn read(folder: &Path) -> Result<Self, Failure> {
        let path = folder.join("recipe.toml");
        let text = std::fs::read_to_string(&path)
            .map_err(|error| format!("{}: {error}", path.display()))?;
        let choices =
            toml::from_str(&text).map_err(|error| format!("{}: {error}", path.display()))?;
        let published = Published::read(&folder.join("../published.toml"))?;
        Ok(Self { choices, published })
    }

    /// The law on a counterface, with a lean.
    ///
    /// # Errors
    /// If a number is not published.
    pub fn law(&self, material: &str, theta0_rad: f64) -> Result<Law, Failure> {
        let row = |name: &str| self.published.number(&format!("table2.{material}.{name}"));
        Ok(Law::AsymmetricBristle(Bristle {
            sigma: row("sigma")?,
            theta_c: row("theta_c")?,
            theta_s: row("theta_s")?,
            w_sc: row("omega_sc")?,
            sigma0: row("sigma0")?,
            sigma1: row("sigma1")?,
            sigma2: row("sigma2")?,
            theta0_rad,
            height_m: self.published.number("brush.contact_height")? * 1e-3,
        }))
    }

    /// The day at the rig: ramps from rest, in both directions, at one load.
    fn plan(&self, load_n: f64) -> Result<Plan, Failure> {
        let ramps = &self.choices.protocol;
        let travel_m = self.published.number("protocol.travel")? * 1e-3;
        let end_m_s = self.published.number("protocol.end_speed")? * 1e-3;
        let repeats = self.published.number("protocol.repeats")? as usize;
        // Uniform acceleration from rest covers x = v t / 2.
        let duration_s = 2.0 * travel_m / end_m_s;
        let directions: Vec<&'static str> = match ramps.order.as_str() {
            "alternating" => (0..repeats).flat_map(|_| ["forward", "reverse"]).collect(),
            "blocked" => {
                let block = |direction| std::iter::repeat_n(direction, repeats);
                block("forward").chain(block("reverse")).collect()
            }
            other => {
                return Err(format!(
                    "the recipe's order {other:?} is neither alternating nor blocked"
                )
                .into());
            }
        };
        let runs = directions
            .into_iter()
            .enumerate()
            .map(|(index, direction)| {
                let reverse = direction == "reverse";
                RunPlan {
                    direction,
                    protocol: "ramp",
                    load_n: Some(load_n),
                    started_s: index as f64 * ramps.interval_s,
                    start_position_m: if reverse { travel_m } else { 0.0 },
                    motion: Motion::through(&[
                        (0.0, 0.0),
                        (duration_s, if reverse { -end_m_s } else { end_m_s }),
                    ]),
                    stage_turned: false,
                    specimen_turned: false,
                    starts_bent: false,
                }
            })
            .collect();
        Ok(Plan {
            axis: Axis::Linear,
            sample_rate_hz: self.published.number("rig.sample_rate")?,
            travel_m,
            full_scale_n: self.choices.noise.sensor_full_scale_n,
            accuracy_percent: self.published.number("rig.sensor_accuracy")?,
            moving_mass_kg: None,
            records_position: false,
            runs,
        })
    }

    /// The imperfections of the rig.
    ///
    /// # Errors
    /// If a number is not published.
    pub fn noise(&self) -> Result<Noise, Failure> {
        Ok(Noise {
            roughness: self.choices.noise.roughness_percent / 100.0,
            correlation_m: self.choices.noise.correlation_mm * 1e-3,
            plate_share: self.choices.noise.plate_share,
            sensor_n: self.published.number("rig.sensor_accuracy")? / 100.0
                * self.choices.noise.sensor_full_scale_n,
            scatter: self.choices.noise.scatter_percent / 100.0,
            ..Noise::NONE
        })
    }

    /// Mean of |mu| over the window of speeds on noise-free ramps: (forward, reverse).
    fn steady(&self, theta0_rad: f64) -> Result<(f64, f64), Failure> {
        let load_n = 1.0;
        let rig = Rig {
            law: self.law("aluminium", theta0_rad)?,
            effects: Vec::new(),
            reference_load_n: load_n,
        };
        let mut plan = self.plan(load_n)?;
        plan.runs.dedup_by_key(|run| run.direction);
        plan.runs.truncate(2);
        let [low, high] = self.choices.lean.window_mm_s.map(|speed| speed * 1e-3);
        let means: Vec<f64> = run_day(&rig, &plan, &Noise::NONE, 0)
            .iter()
            .map(|recording| {
                let window: Vec<f64> = recording
                    .velocity_m_s
                    .iter()
                    .zip(&recording.force_n)
                    .filter(|(v, _)| v.abs() >= low && v.abs() <= high + 1e-12)
                    .map(|(_, force)| force.abs() / load_n)
                    .collect();
                window.iter().sum::<f64>() / window.len() as f64
            })
            .collect();
        Ok((means[0], means[1]))
    }

    /// The lean for which both steady coefficients come nearest to the published ones, rad (golden-section search).
    ///
    /// # Errors
    /// If the recipe lacks aluminium or has an unknown order of runs.
    pub fn lean_rad(&self) -> Result<f64, Failure> {
        let misfit = |theta0: f64| -> Result<f64, Failure> {
            let (forward, reverse) = self.steady(theta0)?;
            Ok((forward - self.published.number("steady.forward")?).powi(2)
                + (reverse - self.published.number("steady.reverse")?).powi(2))
        };
        let golden = (5.0_f64.sqrt() - 1.0) / 2.0;
        let [mut low, mut high] = self.choices.lean.bracket_rad;
        // 1e-6 rad moves the steady coefficients by less than 1e-6: two orders below their last published digit.
        while high - low > 1e-6 {
            let (left, right) = (high - golden * (high - low), low + golden * (high - low));
            if misfit(left)? < misfit(right)? {
                high = right;
            } else {
                low = left;
            }
        }
        Ok((0.5 * (low + high) * 1e5).round() / 1e5)
    }

    /// All files of all campaigns, paths relative to the folder of the recipe.
    ///
    /// # Errors
    /// If an entry names a material or an order that the recipe does not have.
    pub fn campaigns(&self) -> Result<Vec<(String, String)>, Failure> {
        let theta0_rad = self.lean_rad()?;
        let mut all = Vec::new();
        for entry in &self.choices.campaign {
            for (path, text) in self.campaign_files(entry, theta0_rad)? {
                all.push((format!("{}/{path}", entry.name), text));
            }
        }
        Ok(all)
    }

    fn campaign_files(
        &self,
        entry: &Entry,
        theta0_rad: f64,
    ) -> Result<Vec<(String, String)>, Failure> {
        let mass_kg = self
            .published
            .number(&format!("brush.mass_{}", entry.layout))?
            * 1e-3;
        let load_n = mass_kg * STANDARD_GRAVITY_M_S2;
        let mut effects = Vec::new();
        if let Some(stiffness) = entry.cord_stiffness_n_m {
            // Critical damping of a mass on a spring is 2 sqrt(k m).
            let damping_n_s_m =
                entry.cord_damping_ratio.unwrap_or(0.0) * 2.0 * (stiffness * mass_kg).sqrt();
            effects.push(Effect::CordCompliance {
                compliance_m_n: 1.0 / stiffness,
                damping_n_s_m,
                hardening_m: None,
            });
        }
        let rig = Rig {
            law: self.law(&entry.material, theta0_rad)?,
            effects,
            reference_load_n: load_n,
        };
        let plan = self.plan(load_n)?;
        let recordings = run_day(&rig, &plan, &self.noise()?, entry.seed);
        let names: Vec<String> = plan
            .runs
            .iter()
            .enumerate()
            .map(|(i, run)| format!("{:02}-{}-ramp", i + 1, run.direction))
            .collect();
        let listing: Vec<usize> = (0..names.len()).collect();
        let label = Label {
            name: entry.name.clone(),
            title: entry.title.clone(),
            description: Some(
                "Synthetic: simulated from the published parameters and protocol by the recipe beside this folder; \
                 not a measurement."
                    .into(),
            ),
            specimen: Some(serde_json::json!({
                "layout": entry.layout,
                "bristle_length_mm": self.published.number("brush.bristle_length")?,
                "bristle_diameter_mm": self.published.number("brush.bristle_diameter")?,
                "contact_height_mm": self.published.number("brush.contact_height")?,
            })),
            counterface: Some(entry.material.clone()),
        };
        Ok(files(&label, &plan, &recordings, &names, &listing))
    }
}

/// Writes the campaigns beside the recipe; returns how many files were written.
///
/// # Errors
/// Whatever reading the recipe or writing the files reports.
pub fn regenerate(folder: &Path) -> Result<usize, Failure> {
    let all = Recipe::read(folder)?.campaigns()?;
    for (path, text) in &all {
        let target = folder.join(path);
        if let Some(parent) = target.parent() {
            std::fs::create_dir_all(parent)?;
        }
        std::fs::write(target, text)?;
    }
    Ok(all.len())
}

/// Compares the campaigns on disk with what the recipe makes; returns the paths that differ, lack or are too many.
///
/// # Errors
/// Whatever reading the recipe reports.
pub fn check(folder: &Path) -> Result<Vec<String>, Failure> {
    let recipe = Recipe::read(folder)?;
    let all = recipe.campaigns()?;
    let mut complaints = Vec::new();
    for (path, text) in &all {
        match std::fs::read_to_string(folder.join(path)) {
            Ok(found) if found == *text => {}
            Ok(_) => complaints.push(format!("{path} is not what the recipe makes")),
            Err(error) => complaints.push(format!("{path}: {error}")),
        }
    }
    for entry in &recipe.choices.campaign {
        if let Ok(listing) = std::fs::read_dir(folder.join(&entry.name).join("runs")) {
            for file in listing.flatten() {
                let path = format!("{}/runs/{}", entry.name, file.file_name().to_string_lossy());
                if !all.iter().any(|(known, _)| *known == path) {
                    complaints.push(format!("{path} is not in the recipe"));
                }
            }
        }
    }
    Ok(complaints)
}

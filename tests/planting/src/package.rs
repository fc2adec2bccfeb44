//! Writes recordings as a tabular data package (Frictionless v1) with one CSV a run.

use crate::machine::Recording;
use crate::plan::{Axis, Plan};
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::path::Path;

/// What a package says about itself beyond the runs.
#[derive(Clone, Debug)]
pub struct Label {
    /// Name of the package.
    pub name: String,
    /// Title of the package.
    pub title: String,
    /// Optional description.
    pub description: Option<String>,
    /// `campaign.specimen`, if it is a brush.
    pub specimen: Option<Value>,
    /// Counterface material.
    pub counterface: Option<String>,
}

/// A number with at most `decimals` decimals and no trailing zeros.
fn number(value: f64, decimals: usize) -> String {
    let mut text = format!("{value:.decimals$}");
    if text.contains('.') {
        text.truncate(text.trim_end_matches('0').trim_end_matches('.').len());
    }
    if text == "-0" { "0".into() } else { text }
}

impl Plan {
    /// Step in which the stage coordinate is written, m (rad); `None` where it is not recorded.
    #[must_use]
    pub fn position_step_m(&self) -> Option<f64> {
        let decimals = i32::try_from(Digits::of(self.axis).place).expect("a few");
        self.records_position
            .then(|| 10_f64.powi(-decimals) / file_scale(self.axis))
    }
}

/// Units of the files in one of SI: linear rigs in mm, rotary rigs in rad.
fn file_scale(axis: Axis) -> f64 {
    match axis {
        Axis::Rotary => 1.0,
        Axis::Linear => 1e3,
    }
}

/// Resolution of the logger: far below every noise. Decimals of time, speed, position and force columns.
struct Digits {
    time: usize,
    speed: usize,
    place: usize,
    force: usize,
}

impl Digits {
    fn of(axis: Axis) -> Self {
        let place = match axis {
            Axis::Rotary => 6,
            Axis::Linear => 4,
        };
        Self {
            time: 5,
            speed: place,
            place,
            force: 5,
        }
    }
}

/// One run as CSV; linear rigs in mm and N, rotary rigs in rad and N m.
fn table(recording: &Recording, plan: &Plan) -> String {
    let rotary = plan.axis == Axis::Rotary;
    let scale = file_scale(plan.axis);
    let digits = Digits::of(plan.axis);
    let mut text = String::from(if rotary {
        "time_s,velocity_rad_s"
    } else {
        "time_s,velocity_mm_s"
    });
    if plan.records_position {
        text.push_str(if rotary {
            ",position_rad"
        } else {
            ",position_mm"
        });
    }
    text.push_str(if rotary { ",torque_n_m" } else { ",force_n" });
    if recording.load_n.is_some() {
        text.push_str(",normal_force_n");
    }
    text.push('\n');
    for i in 0..recording.time_s.len() {
        let _ = write!(
            text,
            "{},{}",
            number(recording.time_s[i], digits.time),
            number(scale * recording.velocity_m_s[i], digits.speed)
        );
        if plan.records_position {
            let _ = write!(
                text,
                ",{}",
                number(scale * recording.position_m[i], digits.place)
            );
        }
        let _ = write!(text, ",{}", number(recording.force_n[i], digits.force));
        if let Some(load_n) = &recording.load_n {
            let _ = write!(text, ",{}", number(load_n[i], digits.force));
        }
        text.push('\n');
    }
    text
}

fn fields(plan: &Plan, recording: &Recording) -> Value {
    let field = |name: &str, unit: &str| json!({"name": name, "type": "number", "unit": unit});
    let rotary = plan.axis == Axis::Rotary;
    let mut fields = vec![field("time_s", "s")];
    fields.push(if rotary {
        field("velocity_rad_s", "rad/s")
    } else {
        field("velocity_mm_s", "mm/s")
    });
    if plan.records_position {
        fields.push(if rotary {
            field("position_rad", "rad")
        } else {
            field("position_mm", "mm")
        });
    }
    fields.push(if rotary {
        field("torque_n_m", "N m")
    } else {
        field("force_n", "N")
    });
    if recording.load_n.is_some() {
        fields.push(field("normal_force_n", "N"));
    }
    Value::Array(fields)
}

/// Metadata of run `index`, repeats counted over runs of the same condition.
fn run_metadata(plan: &Plan, index: usize) -> Value {
    let run = &plan.runs[index];
    let same = |other: &crate::plan::RunPlan| {
        other.direction == run.direction
            && other.protocol == run.protocol
            && other.load_n == run.load_n
            && other.motion == run.motion
    };
    let repeat = 1 + plan.runs[..index]
        .iter()
        .filter(|other| same(other))
        .count();
    let mut metadata = json!({
        "direction": run.direction,
        "protocol": run.protocol,
        "repeat": repeat,
        "order": index + 1,
        "started_s": run.started_s,
    });
    if let Some(load_n) = run.load_n {
        metadata["normal_load_n"] = json!((load_n * 1e5).round() / 1e5);
    }
    let usual = if run.direction == "reverse" {
        plan.travel_m
    } else {
        0.0
    };
    if (run.start_position_m - usual).abs() > 1e-12 {
        let key = if plan.axis == Axis::Rotary {
            "start_position_rad"
        } else {
            "start_position_mm"
        };
        let scale = file_scale(plan.axis);
        metadata[key] = json!((scale * run.start_position_m * 1e6).round() / 1e6);
    }
    for (key, value) in [
        ("stage_turned", run.stage_turned),
        ("specimen_turned", run.specimen_turned),
    ] {
        if value {
            metadata[key] = json!(true);
        }
    }
    if run.starts_bent {
        metadata["initial_state"] = json!("unknown");
    }
    metadata
}

/// The files of a package: relative paths and contents. `names` gives each run its resource name; `listing` is the
/// order in which resources are listed.
pub fn files(
    label: &Label,
    plan: &Plan,
    recordings: &[Recording],
    names: &[String],
    listing: &[usize],
) -> Vec<(String, String)> {
    let mut files = Vec::new();
    let mut resources = Vec::new();
    for &index in listing {
        let path = format!("runs/{}.csv", names[index]);
        resources.push(json!({
            "name": names[index],
            "path": path,
            "profile": "tabular-data-resource",
            "schema": {"fields": fields(plan, &recordings[index])},
            "run": run_metadata(plan, index),
        }));
        files.push((path, table(&recordings[index], plan)));
    }
    let mut rig = json!({
        "sensor_accuracy_percent_fs": plan.accuracy_percent,
        "sample_rate_hz": plan.sample_rate_hz,
    });
    if plan.axis == Axis::Linear {
        rig["sensor_full_scale_n"] = json!(plan.full_scale_n);
        rig["travel_mm"] = json!((1e9 * plan.travel_m).round() / 1e6);
    }
    if let Some(mass) = plan.moving_mass_kg {
        rig[if plan.axis == Axis::Rotary {
            "moving_inertia_kg_m2"
        } else {
            "moving_mass_kg"
        }] = json!(mass);
    }
    let mut campaign = json!({"provenance": "synthetic", "rig": rig});
    if let Some(specimen) = &label.specimen {
        campaign["specimen"] = specimen.clone();
    }
    if let Some(counterface) = &label.counterface {
        campaign["counterface"] = json!(counterface);
    }
    let mut package = json!({
        "profile": "tabular-data-package",
        "name": label.name,
        "title": label.title,
        "campaign": campaign,
        "resources": resources,
    });
    if let Some(description) = &label.description {
        package["description"] = json!(description);
    }
    let mut text = serde_json::to_string_pretty(&package).expect("a JSON value prints");
    text.push('\n');
    files.push(("datapackage.json".into(), text));
    files
}

/// Writes the files of a package below `folder`.
///
/// # Errors
/// Whatever the file system reports.
pub fn write(folder: &Path, files: &[(String, String)]) -> std::io::Result<()> {
    std::fs::create_dir_all(folder.join("runs"))?;
    for (path, text) in files {
        std::fs::write(folder.join(path), text)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::number;

    #[test]
    fn numbers_carry_no_idle_zeros() {
        assert_eq!(number(1.25, 4), "1.25");
        assert_eq!(number(-0.000_001, 3), "0");
        assert_eq!(number(10.0, 3), "10");
    }
}

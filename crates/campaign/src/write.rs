//! Writing a package: what [`open`](crate::open) reads, and `frictionless validate` accepts.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use serde_json::{Map, Value, json};

use crate::frame::{direction_word, protocol_word};
use crate::open::DESCRIPTION;
use crate::record::{Axis, Campaign, Direction, InitialState, Provenance, Run};
use crate::units::Quantity;

/// A file or folder could not be written.
#[derive(Debug, thiserror::Error)]
#[error("{}: cannot be written: {source}", path.display())]
pub struct WriteError {
    /// Which.
    pub path: PathBuf,
    /// Why.
    pub source: std::io::Error,
}

/// Writes the campaign as a package into `folder`, which is made if need be. Runs are named by their place in the
/// canonical order, direction and protocol. The description is written last, so that a folder that has one is whole.
///
/// Numbers are written with the shortest text that reads back as the same double; lengths pass through millimetres, so a
/// package that is written and opened again may differ by one unit in the last place.
///
/// # Errors
/// Where a file cannot be written.
pub fn write(folder: &Path, campaign: &Campaign) -> Result<(), WriteError> {
    let digits = campaign.runs.len().to_string().len().max(2);
    let names: Vec<String> = (1..)
        .zip(&campaign.runs)
        .map(|(place, run)| {
            let (direction, protocol) =
                (direction_word(run.direction), protocol_word(run.protocol));
            format!("{place:0digits$}-{direction}-{protocol}")
        })
        .collect();
    for (name, run) in names.iter().zip(&campaign.runs) {
        let path = folder.join("runs").join(format!("{name}.csv"));
        write_atomically(&path, table(campaign.axis, run).as_bytes())?;
    }
    let description = description(campaign, &names);
    // Serialising a `Value` cannot fail: its keys are strings.
    let text = format!("{description:#}\n");
    write_atomically(&folder.join(DESCRIPTION), text.as_bytes())
}

/// Writes a file under a temporary name in the same folder and then renames it, so that no half-written file ever bears
/// the final name. Makes the folder if need be.
///
/// # Errors
/// Where the file cannot be written.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), WriteError> {
    let refuse = |source| WriteError {
        path: path.to_owned(),
        source,
    };
    let folder = path
        .parent()
        .filter(|parent| *parent != Path::new(""))
        .unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder).map_err(refuse)?;
    let mut draft = draft_file().tempfile_in(folder).map_err(refuse)?;
    draft.write_all(bytes).map_err(refuse)?;
    draft.as_file().sync_all().map_err(refuse)?;
    draft.persist(path).map_err(|error| refuse(error.error))?;
    Ok(())
}

/// A temporary file that, once it has its name, may be read as any other new file may (not by its owner alone).
fn draft_file() -> tempfile::Builder<'static, 'static> {
    let builder = tempfile::Builder::new();
    #[cfg(unix)]
    let builder = {
        use std::os::unix::fs::PermissionsExt;
        let mut builder = builder;
        // What the process's mask leaves of this is what any new file gets.
        builder.permissions(std::fs::Permissions::from_mode(0o666));
        builder
    };
    builder
}

/// Columns of a run in the package's units: quantity, factor from SI, samples.
fn columns(axis: Axis, run: &Run) -> Vec<(Quantity, f64, &[f64])> {
    let (position, velocity, force, length) = match axis {
        Axis::Linear => (
            Quantity::Position,
            Quantity::Velocity,
            Quantity::Force,
            1000.0,
        ),
        Axis::Rotary => (
            Quantity::Angle,
            Quantity::AngularVelocity,
            Quantity::Torque,
            1.0,
        ),
    };
    let mut columns = vec![(Quantity::Time, 1.0, run.time_s.as_slice())];
    columns.extend(
        run.position_m
            .as_deref()
            .map(|samples| (position, length, samples)),
    );
    columns.push((velocity, length, &run.velocity_m_s));
    columns.push((force, 1.0, &run.force_n));
    columns.extend(
        run.normal_force_n
            .as_deref()
            .map(|samples| (Quantity::NormalForce, 1.0, samples)),
    );
    columns.extend(
        run.temperature_c
            .as_deref()
            .map(|samples| (Quantity::Temperature, 1.0, samples)),
    );
    columns
}

/// The CSV of a run.
fn table(axis: Axis, run: &Run) -> String {
    let columns = columns(axis, run);
    let names: Vec<&str> = columns
        .iter()
        .map(|(quantity, ..)| quantity.column().0)
        .collect();
    let mut text = names.join(",") + "\n";
    for sample in 0..run.time_s.len() {
        for (place, (_, factor, samples)) in columns.iter().enumerate() {
            let separator = if place == 0 { "" } else { "," };
            // Writing to a string cannot fail.
            let _ = write!(text, "{separator}{}", samples[sample] * factor);
        }
        text.push('\n');
    }
    text
}

/// `datapackage.json`.
fn description(campaign: &Campaign, names: &[String]) -> Value {
    let runs = names.iter().zip(&campaign.runs);
    let resources: Vec<Value> = runs
        .map(|(name, run)| resource(campaign.axis, name, run))
        .collect();
    json!({
        "profile": "tabular-data-package",
        "name": slug(&campaign.name),
        "title": campaign.title,
        "campaign": campaign_entry(campaign),
        "resources": resources,
    })
}

/// `campaign`: what is known, and nothing for what is not.
fn campaign_entry(campaign: &Campaign) -> Value {
    let millimetres = |metres: Option<f64>| metres.map(|length| length * 1000.0);
    let specimen = object([
        ("layout", campaign.specimen.layout.clone().map(Value::from)),
        (
            "bristle_length_mm",
            millimetres(campaign.specimen.bristle_length_m).map(Value::from),
        ),
        (
            "bristle_diameter_mm",
            millimetres(campaign.specimen.bristle_diameter_m).map(Value::from),
        ),
        (
            "contact_height_mm",
            millimetres(campaign.specimen.contact_height_m).map(Value::from),
        ),
    ]);
    let rig = &campaign.rig;
    let (travel, mass) = match campaign.axis {
        Axis::Linear => (("travel_mm", millimetres(rig.travel_m)), "moving_mass_kg"),
        Axis::Rotary => (("travel_rad", rig.travel_m), "moving_inertia_kg_m2"),
    };
    let rig = object([
        (
            "sensor_full_scale_n",
            rig.sensor_full_scale_n.map(Value::from),
        ),
        (
            "sensor_accuracy_percent_fs",
            rig.sensor_accuracy_percent_fs.map(Value::from),
        ),
        ("sample_rate_hz", rig.sample_rate_hz.map(Value::from)),
        (travel.0, travel.1.map(Value::from)),
        (mass, rig.moving_mass_kg.map(Value::from)),
    ]);
    let provenance = match campaign.provenance {
        Provenance::Measured => "measured",
        Provenance::Synthetic => "synthetic",
    };
    object([
        ("provenance", Some(Value::from(provenance))),
        ("specimen", filled(specimen)),
        ("counterface", campaign.counterface.clone().map(Value::from)),
        ("rig", filled(rig)),
    ])
}

/// One element of `resources`.
fn resource(axis: Axis, name: &str, run: &Run) -> Value {
    let fields: Vec<Value> = columns(axis, run)
        .iter()
        .map(|(quantity, ..)| {
            let (name, unit) = quantity.column();
            json!({"name": name, "type": "number", "unit": unit})
        })
        .collect();
    let at_default = run.start_position_m == 0.0 && run.direction != Direction::Reverse;
    let start = (run.position_m.is_none() && !at_default).then_some(run.start_position_m);
    let start = match axis {
        Axis::Linear => (
            "start_position_mm",
            start.map(|start| Value::from(start * 1000.0)),
        ),
        Axis::Rotary => ("start_position_rad", start.map(Value::from)),
    };
    let unknown = run.initial_state == InitialState::Unknown;
    let entry = object([
        (
            "direction",
            Some(Value::from(direction_word(run.direction))),
        ),
        ("protocol", Some(Value::from(protocol_word(run.protocol)))),
        ("repeat", run.repeat.map(Value::from)),
        ("order", run.order.map(Value::from)),
        ("started_s", run.started_s.map(Value::from)),
        ("normal_load_n", run.normal_load_n.map(Value::from)),
        start,
        (
            "stage_turned",
            run.stage_turned.then_some(Value::from(true)),
        ),
        (
            "specimen_turned",
            run.specimen_turned.then_some(Value::from(true)),
        ),
        ("initial_state", unknown.then_some(Value::from("unknown"))),
    ]);
    json!({
        "name": name,
        "path": format!("runs/{name}.csv"),
        "profile": "tabular-data-resource",
        "schema": {"fields": fields},
        "run": entry,
    })
}

/// An object of the entries that have a value.
fn object<const N: usize>(entries: [(&str, Option<Value>); N]) -> Value {
    let known = entries
        .into_iter()
        .filter_map(|(key, value)| Some((key.to_owned(), value?)));
    Value::Object(known.collect::<Map<String, Value>>())
}

/// The object, if it holds anything.
fn filled(object: Value) -> Option<Value> {
    object
        .as_object()
        .is_some_and(|entries| !entries.is_empty())
        .then_some(object)
}

/// A name as the Frictionless specification wants it: lower case letters, digits, `.`, `_`, `-`.
pub(crate) fn slug(name: &str) -> String {
    let mut slug = String::new();
    for character in name.to_lowercase().chars() {
        match character {
            'a'..='z' | '0'..='9' | '.' | '_' => slug.push(character),
            _ if slug.ends_with('-') || slug.is_empty() => {}
            _ => slug.push('-'),
        }
    }
    let slug = slug.trim_end_matches('-').to_owned();
    if slug.is_empty() {
        "campaign".to_owned()
    } else {
        slug
    }
}

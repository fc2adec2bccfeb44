//! Opening a package: description, files, columns, checks, canonical order.

use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::{Component, Path, PathBuf};

use crate::assemble::run;
use crate::cells;
use crate::description::{Description, Resource, RigDescription, describe};
use crate::record::{Axis, Campaign, RigData, Run};
use crate::refusal::{Problem, Refusal, quoted};

/// Name of the description inside a package.
pub(crate) const DESCRIPTION: &str = "datapackage.json";

/// Largest description and largest run that the door takes, MiB.
const LARGEST_DESCRIPTION_MIB: u64 = 16;
const LARGEST_RUN_MIB: u64 = 512;

/// Opens the package in the folder `path` (or the one whose `datapackage.json` it is), checks it and converts it to SI
/// units. What comes out keeps every invariant of [`Campaign`].
///
/// # Errors
/// The first thing that is wrong with it, as one line that names file, row and column. Nothing is ever repaired.
pub fn open(path: &Path) -> Result<Campaign, Refusal> {
    let folder = match path.file_name() {
        Some(name) if name == DESCRIPTION && !path.is_dir() => path
            .parent()
            .filter(|parent| *parent != Path::new(""))
            .unwrap_or(Path::new(".")),
        _ => path,
    };
    if !folder.is_dir() {
        let why = if folder.exists() {
            "is not a folder"
        } else {
            "there is no such folder"
        };
        return Err(Refusal::of(
            &folder.display().to_string(),
            Problem::Unreadable(why.to_owned()),
        ));
    }
    let file = folder.join(DESCRIPTION).display().to_string();
    let text = read(&folder.join(DESCRIPTION), &file, LARGEST_DESCRIPTION_MIB)?;
    let json = crate::json::parse(&file, &text)?;
    let description = describe(&file, &json)?;
    let mut hashes = vec![(
        DESCRIPTION.to_owned(),
        blake3::hash(&text).to_hex().to_string(),
    )];
    let places = places(folder, &file, &description.resources)?;
    let mut runs = Vec::new();
    for (resource, place) in description.resources.iter().zip(&places) {
        let shown = folder.join(&resource.path).display().to_string();
        let text = read(place, &shown, LARGEST_RUN_MIB)?;
        hashes.push((
            resource.path.clone(),
            blake3::hash(&text).to_hex().to_string(),
        ));
        runs.push(read_run(&shown, &text, resource, &description.rig)?);
    }
    hashes.sort();
    finish(&file, folder, description, runs, hashes)
}

/// The files of the resources, each inside the folder and each used once: a doubled file would pass for a perfect repeat.
fn places(folder: &Path, file: &str, resources: &[Resource]) -> Result<Vec<PathBuf>, Refusal> {
    let mut seen = BTreeMap::new();
    let mut places = Vec::new();
    for resource in resources {
        let place = inside(folder, file, resource)?;
        if let Some(first) = seen.insert(place.clone(), resource.name.as_str()) {
            let problem = Problem::DuplicateFile {
                first: quoted(first, 60),
                second: quoted(&resource.name, 60),
            };
            return Err(Refusal::at_field(file, &resource.field, problem));
        }
        places.push(place);
    }
    Ok(places)
}

/// One run from the text of its file.
fn read_run(
    file: &str,
    text: &[u8],
    resource: &Resource,
    rig: &RigDescription,
) -> Result<(Axis, Run), Refusal> {
    let schema: Vec<String> = resource
        .fields
        .iter()
        .map(|field| field.name.clone())
        .collect();
    let names = cells::header(file, text, resource.delimiter, &schema)?;
    run(file, text, &names, resource, rig)
}

/// One axis for all runs, and the runs in canonical order.
fn finish(
    file: &str,
    folder: &Path,
    description: Description,
    mut runs: Vec<(Axis, Run)>,
    input_hashes: Vec<(String, String)>,
) -> Result<Campaign, Refusal> {
    let axis = runs[0].0;
    if let Some((_, other)) = runs.iter().find(|(other, _)| *other != axis) {
        let problem = Problem::MixedAxes(format!("{} and {}", runs[0].1.name, other.name));
        return Err(Refusal::of(file, problem));
    }
    runs.sort_by(|(_, one), (_, other)| canonical(one, other));
    let rig = &description.rig;
    let (travel_m, moving_mass_kg) = match axis {
        Axis::Linear => (
            rig.travel_mm.map(|travel| travel / 1000.0),
            rig.moving_mass_kg,
        ),
        Axis::Rotary => (rig.travel_rad, rig.moving_inertia_kg_m2),
    };
    let folder_name = || {
        folder
            .file_name()
            .map(|name| name.to_string_lossy().into_owned())
    };
    let name = description
        .name
        .or_else(folder_name)
        .unwrap_or_else(|| "campaign".to_owned());
    Ok(Campaign {
        title: description.title.unwrap_or_else(|| name.clone()),
        name,
        provenance: description.provenance,
        axis,
        specimen: description.specimen,
        counterface: description.counterface,
        rig: RigData {
            travel_m,
            moving_mass_kg,
            ..description.rig.common
        },
        runs: runs.into_iter().map(|(_, run)| run).collect(),
        input_hashes,
    })
}

/// Canonical order: place in the day, then start on the campaign's clock (what is not stated comes last), then content.
/// Names take no part.
fn canonical(one: &Run, other: &Run) -> Ordering {
    let stated = |a: Option<f64>, b: Option<f64>| match (a, b) {
        (Some(a), Some(b)) => a.total_cmp(&b),
        (Some(_), None) => Ordering::Less,
        (None, Some(_)) => Ordering::Greater,
        (None, None) => Ordering::Equal,
    };
    stated(one.order, other.order)
        .then_with(|| stated(one.started_s, other.started_s))
        .then_with(|| one.direction.cmp(&other.direction))
        .then_with(|| one.protocol.cmp(&other.protocol))
        .then_with(|| stated(one.normal_load_n, other.normal_load_n))
        .then_with(|| one.start_position_m.total_cmp(&other.start_position_m))
        .then_with(|| {
            (one.stage_turned, one.specimen_turned)
                .cmp(&(other.stage_turned, other.specimen_turned))
        })
        .then_with(|| one.initial_state.cmp(&other.initial_state))
        .then_with(|| samples(&one.time_s, &other.time_s))
        .then_with(|| samples(&one.velocity_m_s, &other.velocity_m_s))
        .then_with(|| samples(&one.force_n, &other.force_n))
}

/// Lexicographic order of two columns.
fn samples(one: &[f64], other: &[f64]) -> Ordering {
    one.iter()
        .zip(other)
        .map(|(a, b)| a.total_cmp(b))
        .find(|order| order.is_ne())
        .unwrap_or_else(|| one.len().cmp(&other.len()))
}

/// The file of a resource, if it lies inside the folder, links followed.
fn inside(folder: &Path, description: &str, resource: &Resource) -> Result<PathBuf, Refusal> {
    let leaves = || {
        let problem = Problem::PathLeaves(quoted(&resource.path, 120));
        Refusal::at_field(description, &format!("{}.path", resource.field), problem)
    };
    let relative = Path::new(&resource.path);
    let plain = relative
        .components()
        .all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
    if !plain || resource.path.contains("://") || resource.path.contains('\\') {
        return Err(leaves());
    }
    let shown = folder.join(relative).display().to_string();
    let unreadable =
        |file: &str, error: &std::io::Error| Refusal::of(file, Problem::Unreadable(reason(error)));
    let home = folder
        .canonicalize()
        .map_err(|error| unreadable(&folder.display().to_string(), &error))?;
    let place = folder
        .join(relative)
        .canonicalize()
        .map_err(|error| unreadable(&shown, &error))?;
    if place.starts_with(&home) {
        Ok(place)
    } else {
        Err(leaves())
    }
}

/// A whole file, if it is a regular one of reasonable size.
fn read(path: &Path, shown: &str, limit_mib: u64) -> Result<Vec<u8>, Refusal> {
    let refuse = |error: std::io::Error| Refusal::of(shown, Problem::Unreadable(reason(&error)));
    // Looked at before it is opened: opening a pipe would wait for its writer.
    let metadata = std::fs::metadata(path).map_err(refuse)?;
    if !metadata.is_file() {
        return Err(Refusal::of(shown, Problem::NotAFile));
    }
    let limit = limit_mib * 1024 * 1024;
    let mut text = Vec::new();
    let file = File::open(path).map_err(refuse)?;
    // One byte more than the limit tells a file that grew meanwhile.
    file.take(limit + 1)
        .read_to_end(&mut text)
        .map_err(refuse)?;
    if text.len() as u64 > limit {
        return Err(Refusal::of(shown, Problem::TooLarge { limit_mib }));
    }
    Ok(text)
}

/// Why the system refused, in words that are the same everywhere.
fn reason(error: &std::io::Error) -> String {
    match error.kind() {
        std::io::ErrorKind::NotFound => "there is no such file".to_owned(),
        std::io::ErrorKind::PermissionDenied => "permission denied".to_owned(),
        kind => kind.to_string(),
    }
}

//! What `datapackage.json` says: the campaign and its runs, before any CSV is read.

use std::collections::BTreeMap;

use serde_json::Value;

use crate::json::Node;
use crate::record::{Direction, InitialState, Protocol, Provenance, RigData, Specimen};
use crate::refusal::{Problem, Refusal};

/// The words of `direction`.
pub(crate) const DIRECTIONS: [(&str, Direction); 3] = [
    ("forward", Direction::Forward),
    ("reverse", Direction::Reverse),
    ("both", Direction::Both),
];

/// The words of `protocol`.
pub(crate) const PROTOCOLS: [(&str, Protocol); 6] = [
    ("ramp", Protocol::Ramp),
    ("constant", Protocol::Constant),
    ("steps", Protocol::Steps),
    ("cycles", Protocol::Cycles),
    ("free", Protocol::Free),
    ("unloaded", Protocol::Unloaded),
];

/// The words of `initial_state`.
pub(crate) const STATES: [(&str, InitialState); 2] = [
    ("relaxed", InitialState::Relaxed),
    ("unknown", InitialState::Unknown),
];

/// The words of `provenance`.
pub(crate) const PROVENANCES: [(&str, Provenance); 2] = [
    ("measured", Provenance::Measured),
    ("synthetic", Provenance::Synthetic),
];

/// A package as described.
pub(crate) struct Description {
    pub(crate) name: Option<String>,
    pub(crate) title: Option<String>,
    pub(crate) provenance: Provenance,
    pub(crate) specimen: Specimen,
    pub(crate) counterface: Option<String>,
    pub(crate) rig: RigDescription,
    pub(crate) resources: Vec<Resource>,
}

/// What is said of the rig; which numbers count depends on whether the columns are linear or rotary.
pub(crate) struct RigDescription {
    pub(crate) common: RigData,
    pub(crate) travel_mm: Option<f64>,
    pub(crate) travel_rad: Option<f64>,
    pub(crate) moving_mass_kg: Option<f64>,
    pub(crate) moving_inertia_kg_m2: Option<f64>,
}

/// A run as described.
pub(crate) struct Resource {
    pub(crate) name: String,
    /// Place of the resource in the JSON file, for messages.
    pub(crate) field: String,
    pub(crate) path: String,
    pub(crate) delimiter: u8,
    pub(crate) fields: Vec<Field>,
    pub(crate) direction: Direction,
    pub(crate) protocol: Protocol,
    pub(crate) repeat: Option<u32>,
    pub(crate) order: Option<f64>,
    pub(crate) started_s: Option<f64>,
    pub(crate) normal_load_n: Option<f64>,
    pub(crate) start_position_mm: Option<f64>,
    pub(crate) start_position_rad: Option<f64>,
    pub(crate) stage_turned: bool,
    pub(crate) specimen_turned: bool,
    pub(crate) initial_state: InitialState,
}

/// A column as described.
pub(crate) struct Field {
    pub(crate) name: String,
    pub(crate) unit: Option<String>,
}

/// Reads the description.
pub(crate) fn describe(file: &str, json: &Value) -> Result<Description, Refusal> {
    let root = Node::root(file, json).object()?;
    if let Some(profile) = root.get("profile") {
        profile.word(&[("tabular-data-package", ())])?;
    }
    let campaign = root.need("campaign")?.object()?;
    let resources = root.need("resources")?.array()?;
    if resources.is_empty() {
        return Err(root.refuse(Problem::NoRuns));
    }
    let resources = resources
        .into_iter()
        .enumerate()
        .map(|(index, node)| resource(&node.object()?, index))
        .collect::<Result<Vec<_>, _>>()?;
    refuse_doubles(file, &resources)?;
    let text = |node: &Node<'_>, key| {
        node.get(key)
            .map(|node| node.text().map(str::to_owned))
            .transpose()
    };
    Ok(Description {
        name: text(&root, "name")?,
        title: text(&root, "title")?,
        provenance: campaign.need("provenance")?.word(&PROVENANCES)?,
        specimen: specimen(&campaign)?,
        counterface: text(&campaign, "counterface")?,
        rig: rig(&campaign)?,
        resources,
    })
}

/// Two runs may not share a name.
fn refuse_doubles(file: &str, resources: &[Resource]) -> Result<(), Refusal> {
    let mut names = BTreeMap::new();
    for resource in resources {
        if names.insert(&resource.name, ()).is_some() {
            let problem = Problem::DuplicateRun(crate::refusal::quoted(&resource.name, 60));
            return Err(Refusal::at_field(file, &resource.field, problem));
        }
    }
    Ok(())
}

/// `campaign.specimen`, lengths in metres.
fn specimen(campaign: &Node<'_>) -> Result<Specimen, Refusal> {
    let Some(node) = campaign.get("specimen") else {
        return Ok(Specimen::default());
    };
    let node = node.object()?;
    let metres = |key| -> Result<Option<f64>, Refusal> {
        Ok(positive(&node, key)?.map(|millimetres| millimetres / 1000.0))
    };
    Ok(Specimen {
        layout: node
            .get("layout")
            .map(|node| node.text().map(str::to_owned))
            .transpose()?,
        bristle_length_m: metres("bristle_length_mm")?,
        bristle_diameter_m: metres("bristle_diameter_mm")?,
        contact_height_m: metres("contact_height_mm")?,
    })
}

/// `campaign.rig`.
fn rig(campaign: &Node<'_>) -> Result<RigDescription, Refusal> {
    let empty = Value::Object(serde_json::Map::new());
    let node = match campaign.get("rig") {
        Some(node) => node.object()?,
        None => Node::root("", &empty),
    };
    Ok(RigDescription {
        common: RigData {
            sensor_full_scale_n: positive(&node, "sensor_full_scale_n")?,
            sensor_accuracy_percent_fs: positive(&node, "sensor_accuracy_percent_fs")?,
            sample_rate_hz: positive(&node, "sample_rate_hz")?,
            travel_m: None,
            moving_mass_kg: None,
        },
        travel_mm: positive(&node, "travel_mm")?,
        travel_rad: positive(&node, "travel_rad")?,
        moving_mass_kg: positive(&node, "moving_mass_kg")?,
        moving_inertia_kg_m2: positive(&node, "moving_inertia_kg_m2")?,
    })
}

/// One element of `resources`.
fn resource(node: &Node<'_>, index: usize) -> Result<Resource, Refusal> {
    let path = node.need("path")?;
    if let Some(encoding) = node.get("encoding") {
        let text = encoding.text()?;
        if !text.eq_ignore_ascii_case("utf-8") && !text.eq_ignore_ascii_case("utf8") {
            return Err(encoding.refuse(Problem::Unsupported("an encoding other than utf-8")));
        }
    }
    let run = node.need("run")?.object()?;
    let protocol = run.need("protocol")?.word(&PROTOCOLS)?;
    let number = |key| run.get(key).map(|node| node.number()).transpose();
    let truth = |key| run.get(key).map_or(Ok(false), |node| node.truth());
    Ok(Resource {
        name: node.need("name")?.text()?.to_owned(),
        field: format!("resources[{index}]"),
        path: path.text()?.to_owned(),
        delimiter: delimiter(node)?,
        fields: fields(node)?,
        direction: run.need("direction")?.word(&DIRECTIONS)?,
        protocol,
        repeat: run.get("repeat").map(|node| node.count()).transpose()?,
        order: number("order")?,
        started_s: number("started_s")?,
        normal_load_n: load(&run, protocol)?,
        start_position_mm: number("start_position_mm")?,
        start_position_rad: number("start_position_rad")?,
        stage_turned: truth("stage_turned")?,
        specimen_turned: truth("specimen_turned")?,
        initial_state: run
            .get("initial_state")
            .map_or(Ok(InitialState::Relaxed), |node| node.word(&STATES))?,
    })
}

/// `normal_load_n`: above zero, or zero exactly where the protocol is `unloaded`.
fn load(run: &Node<'_>, protocol: Protocol) -> Result<Option<f64>, Refusal> {
    let unloaded = protocol == Protocol::Unloaded;
    let Some(node) = run.get("normal_load_n") else {
        return Ok(unloaded.then_some(0.0));
    };
    let load = node.number()?;
    if load < 0.0 {
        return Err(node.refuse(Problem::NegativeLoad(load)));
    }
    match (unloaded, load == 0.0) {
        (true, false) => Err(node.refuse(Problem::LoadedUnloaded(load))),
        (false, true) => Err(node.refuse(Problem::ZeroLoad)),
        _ => Ok(Some(load)),
    }
}

/// `schema.fields`.
fn fields(resource: &Node<'_>) -> Result<Vec<Field>, Refusal> {
    let mut fields = Vec::new();
    for node in resource.need("schema")?.object()?.need("fields")?.array()? {
        let node = node.object()?;
        if let Some(mark) = node.get("decimalChar")
            && mark.text()? != "."
        {
            return Err(mark.refuse(Problem::Unsupported("a decimal mark other than a point")));
        }
        fields.push(Field {
            name: node.need("name")?.text()?.to_owned(),
            unit: node
                .get("unit")
                .map(|node| node.text().map(str::to_owned))
                .transpose()?,
        });
    }
    Ok(fields)
}

/// `dialect.delimiter`: one ASCII character, a comma where nothing is said. Other dialects are not read.
fn delimiter(resource: &Node<'_>) -> Result<u8, Refusal> {
    let Some(dialect) = resource.get("dialect") else {
        return Ok(b',');
    };
    let dialect = dialect.object()?;
    if let Some(header) = dialect.get("header")
        && !header.truth()?
    {
        return Err(header.refuse(Problem::Unsupported("a file without a header")));
    }
    let Some(delimiter) = dialect.get("delimiter") else {
        return Ok(b',');
    };
    match delimiter.text()?.as_bytes() {
        [byte @ (b',' | b';' | b'\t' | b'|')] => Ok(*byte),
        _ => Err(delimiter.refuse(Problem::Unsupported("this delimiter"))),
    }
}

/// An optional number that must be above zero.
fn positive(node: &Node<'_>, key: &str) -> Result<Option<f64>, Refusal> {
    node.get(key).map(|node| node.positive()).transpose()
}

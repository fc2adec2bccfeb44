//! A package from plain CSV files: whatever the files say is read, the rest is listed for the reader to fill in.

use std::path::{Path, PathBuf};

use serde_json::{Map, Value, json};

use crate::frame::{direction_word, protocol_word};
use crate::guess::{Guess, Writing, column, writing};
use crate::open::DESCRIPTION;
use crate::record::{Direction, Protocol};
use crate::refusal::quoted;
use crate::units::Quantity;
use crate::write::{WriteError, slug, write_atomically};

/// What is left to do after a package was made.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Initiated {
    /// What was read off the files, a line each.
    pub read: Vec<String>,
    /// What the reader must write before the package can be opened.
    pub fill_in: Vec<String>,
    /// What may stay away, and what then cannot be told.
    pub optional: Vec<String>,
}

/// Why no package could be made.
#[derive(Debug, thiserror::Error)]
pub enum InitError {
    /// The folder holds a package already.
    #[error("{}: there is a package already", path.display())]
    Exists {
        /// The description that is there.
        path: PathBuf,
    },
    /// A file cannot be read as text.
    #[error("{}: cannot be read: {problem}", path.display())]
    Read {
        /// Which.
        path: PathBuf,
        /// Why.
        problem: String,
    },
    /// A file has no column that could be time, or a like lack.
    #[error("{}: {problem}; its columns are {columns}", path.display())]
    Columns {
        /// Which.
        path: PathBuf,
        /// What is missing.
        problem: String,
        /// What there is.
        columns: String,
    },
    /// A cell is no number, or a row has another width.
    #[error("{}, row {row}: {problem}", path.display())]
    Row {
        /// Which.
        path: PathBuf,
        /// Line of the file.
        row: usize,
        /// What is wrong.
        problem: String,
    },
    /// The package could not be written.
    #[error(transparent)]
    Write(#[from] WriteError),
}

/// A plain file as understood.
struct Plain {
    path: PathBuf,
    /// Columns that are kept: name in the package, guess.
    columns: Vec<(String, Guess)>,
    /// The CSV with the package's header, cells as they were written (decimal points for commas).
    text: String,
    direction: Direction,
    protocol: Protocol,
    /// Headers that hold nothing known.
    ignored: Vec<String>,
}

/// Makes a package in `folder` from plain CSV files, one run each, in the order given.
///
/// # Errors
/// Where a file cannot be understood, or `folder` holds a package already.
pub fn init(folder: &Path, files: &[PathBuf]) -> Result<Initiated, InitError> {
    let description = folder.join(DESCRIPTION);
    if description.exists() {
        return Err(InitError::Exists { path: description });
    }
    let plain = files
        .iter()
        .map(|path| understand(path))
        .collect::<Result<Vec<_>, _>>()?;
    let mut result = Initiated::default();
    let mut resources = Vec::new();
    let digits = plain.len().to_string().len().max(2);
    for (place, file) in (1..).zip(&plain) {
        let stem = file
            .path
            .file_stem()
            .map(|stem| stem.to_string_lossy().into_owned());
        let name = format!("{place:0digits$}-{}", slug(&stem.unwrap_or_default()));
        write_atomically(
            &folder.join("runs").join(format!("{name}.csv")),
            file.text.as_bytes(),
        )?;
        tell(&mut result, &name, file);
        resources.push(resource(&name, file));
    }
    let name = folder
        .file_name()
        .map(|name| name.to_string_lossy().into_owned())
        .unwrap_or_default();
    let package = json!({
        "profile": "tabular-data-package",
        "name": slug(&name),
        "title": quoted(&name, 200),
        "campaign": {"provenance": "measured"},
        "resources": resources,
    });
    write_atomically(&description, format!("{package:#}\n").as_bytes())?;
    result.optional.extend([
        "campaign.provenance: `measured` is assumed; write `synthetic` if a program made the data".to_owned(),
        "run.normal_load_n of each run: without it friction is fitted as a force and load causes are undecidable".to_owned(),
        "run.order, run.started_s of each run: without them wear, heat and set cannot be told".to_owned(),
        "campaign.specimen.layout: with it the asymmetric bristle is the default law".to_owned(),
        "campaign.specimen.contact_height_mm: the bristle laws need it".to_owned(),
        "campaign.rig.moving_mass_kg (rotary: moving_inertia_kg_m2): without it inertia counts as friction".to_owned(),
        "campaign.rig.sensor_full_scale_n, sensor_accuracy_percent_fs: the noise floor where there are no repeats".to_owned(),
    ]);
    Ok(result)
}

/// What the reader should know about one file.
fn tell(result: &mut Initiated, name: &str, file: &Plain) {
    let columns: Vec<String> = file
        .columns
        .iter()
        .map(|(column, guess)| {
            format!(
                "{column} = {} [{}]",
                guess.quantity.word(),
                guess.unit.unwrap_or("?")
            )
        })
        .collect();
    result.read.push(format!(
        "{name}: {}, direction {}, protocol {}",
        columns.join(", "),
        direction_word(file.direction),
        protocol_word(file.protocol)
    ));
    if !file.ignored.is_empty() {
        result
            .read
            .push(format!("{name}: left out {}", file.ignored.join(", ")));
    }
    for (column, _) in file
        .columns
        .iter()
        .filter(|(_, guess)| guess.unit.is_none())
    {
        result
            .fill_in
            .push(format!("{name}: the unit of column {column}"));
    }
}

/// One element of `resources`.
fn resource(name: &str, file: &Plain) -> Value {
    let fields: Vec<Value> = file
        .columns
        .iter()
        .map(|(column, guess)| {
            let mut field = Map::new();
            field.insert("name".to_owned(), json!(column));
            field.insert("type".to_owned(), json!("number"));
            // An empty unit is refused at the door: nothing is assumed that the file does not say.
            field.insert("unit".to_owned(), json!(guess.unit.unwrap_or("")));
            Value::Object(field)
        })
        .collect();
    json!({
        "name": name,
        "path": format!("runs/{name}.csv"),
        "profile": "tabular-data-resource",
        "schema": {"fields": fields},
        "run": {"direction": direction_word(file.direction), "protocol": protocol_word(file.protocol)},
    })
}

/// Reads a plain file.
fn understand(path: &Path) -> Result<Plain, InitError> {
    let read = |problem: String| InitError::Read {
        path: path.to_owned(),
        problem,
    };
    let bytes = std::fs::read(path).map_err(|error| read(error.to_string()))?;
    let text = String::from_utf8(bytes).map_err(|_| read("it is not UTF-8 text".to_owned()))?;
    let writing = writing(&text);
    let mut reader = csv::ReaderBuilder::new()
        .delimiter(writing.delimiter)
        .has_headers(false)
        .flexible(true)
        .from_reader(text.as_bytes());
    let mut records = reader.records();
    let header = match records.next() {
        Some(Ok(header)) => header,
        _ => return Err(read("it has no header".to_owned())),
    };
    let headers: Vec<String> = header.iter().map(|name| quoted(name.trim(), 60)).collect();
    let kept = kept(path, &headers)?;
    let mut body = String::new();
    let mut velocity = Vec::new();
    let mut time = Vec::new();
    for (row, record) in (2..).zip(records) {
        let refuse = |problem: String| InitError::Row {
            path: path.to_owned(),
            row,
            problem,
        };
        let record = record.map_err(|error| refuse(quoted(&error.to_string(), 200)))?;
        if record.len() != headers.len() {
            let problem = format!(
                "has {} cells, but the header has {}",
                record.len(),
                headers.len()
            );
            return Err(refuse(problem));
        }
        let mut cells = Vec::new();
        for (index, _, guess) in &kept {
            let (cell, number) = number(&record[*index], writing).map_err(refuse)?;
            match guess.quantity {
                Quantity::Time => time.push(number),
                Quantity::Velocity | Quantity::AngularVelocity => velocity.push(number),
                _ => {}
            }
            cells.push(cell);
        }
        body += &(cells.join(",") + "\n");
    }
    let columns: Vec<(String, Guess)> = kept
        .iter()
        .map(|(_, name, guess)| (name.clone(), guess.clone()))
        .collect();
    let names: Vec<&str> = columns.iter().map(|(name, _)| name.as_str()).collect();
    let direction = direction(&velocity);
    Ok(Plain {
        path: path.to_owned(),
        text: names.join(",") + "\n" + &body,
        direction,
        protocol: protocol(&time, &velocity, direction),
        ignored: ignored(&headers, &kept),
        columns,
    })
}

/// Columns to keep: index, name in the package, guess. Time, velocity and force (or torque) must be among them.
fn kept(path: &Path, headers: &[String]) -> Result<Vec<(usize, String, Guess)>, InitError> {
    let refuse = |problem: String| InitError::Columns {
        path: path.to_owned(),
        problem,
        columns: headers.join(", "),
    };
    let mut kept: Vec<(usize, String, Guess)> = Vec::new();
    for (index, header) in headers.iter().enumerate() {
        let Some(guess) = column(header) else {
            continue;
        };
        if kept
            .iter()
            .any(|(.., known)| known.quantity == guess.quantity)
        {
            return Err(refuse(format!(
                "two columns look like {}",
                guess.quantity.word()
            )));
        }
        kept.push((index, column_name(&guess), guess));
    }
    let has = |quantities: &[Quantity]| {
        kept.iter()
            .any(|(.., guess)| quantities.contains(&guess.quantity))
    };
    let needed: [(&[Quantity], &str); 3] = [
        (&[Quantity::Time], "time"),
        (&[Quantity::Velocity, Quantity::AngularVelocity], "velocity"),
        (&[Quantity::Force, Quantity::Torque], "force or torque"),
    ];
    match needed.iter().find(|(quantities, _)| !has(quantities)) {
        Some((_, word)) => Err(refuse(format!("no column looks like {word}"))),
        None => Ok(kept),
    }
}

/// The package's name for a column: the contract's own where the unit is the contract's, else the quantity with its unit.
fn column_name(guess: &Guess) -> String {
    let (name, unit) = guess.quantity.column();
    match guess.unit {
        Some(stated) if stated == unit => name.to_owned(),
        Some(stated) => {
            let written = stated.to_lowercase().replace(['/', ' '], "_");
            let stem = name.strip_suffix(&format!(
                "_{}",
                unit.to_lowercase().replace(['/', ' '], "_")
            ));
            format!(
                "{}_{written}",
                stem.unwrap_or_else(|| name.trim_end_matches("_c"))
            )
        }
        // The unit is to be filled in: the name must not state one.
        None => guess.quantity.word().replace(' ', "_"),
    }
}

fn ignored(headers: &[String], kept: &[(usize, String, Guess)]) -> Vec<String> {
    let unused = |index: &usize| !kept.iter().any(|(used, ..)| used == index);
    (0..headers.len())
        .filter(unused)
        .map(|index| headers[index].clone())
        .collect()
}

/// A cell with a decimal point, and its number.
fn number(cell: &str, writing: Writing) -> Result<(String, f64), String> {
    let cell = cell.trim();
    let text = if writing.decimal_comma {
        cell.replace(',', ".")
    } else {
        cell.to_owned()
    };
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok((text, number)),
        _ => Err(format!("`{}` is not a number", quoted(cell, 40))),
    }
}

/// A sign counts where it exceeds 1 % of the largest speed.
fn direction(velocity: &[f64]) -> Direction {
    let largest = velocity
        .iter()
        .fold(0.0_f64, |largest, v| largest.max(v.abs()));
    let beyond = |sign: f64| velocity.iter().any(|v| sign * v > 0.01 * largest);
    match (beyond(1.0), beyond(-1.0)) {
        (true, true) => Direction::Both,
        (false, true) => Direction::Reverse,
        _ => Direction::Forward,
    }
}

/// `constant` where the speed stays within 1 % of its mean; `ramp` where it grows from rest along a straight line within
/// 1 % of its maximum; `cycles` where it reverses at least twice; else `free`.
fn protocol(time: &[f64], velocity: &[f64], direction: Direction) -> Protocol {
    let largest = velocity
        .iter()
        .fold(0.0_f64, |largest, v| largest.max(v.abs()));
    let within = |model: &dyn Fn(f64) -> f64| {
        time.iter()
            .zip(velocity)
            .all(|(t, v)| (v - model(*t)).abs() <= 0.01 * largest)
    };
    let count = velocity.len().max(1) as f64;
    let mean = velocity.iter().sum::<f64>() / count;
    let (first, last) = match (velocity.first(), velocity.last(), time.first(), time.last()) {
        (Some(v0), Some(v1), Some(t0), Some(t1)) if t1 > t0 => ((*t0, *v0), (*t1, *v1)),
        _ => return Protocol::Free,
    };
    let line = |t: f64| first.1 + (last.1 - first.1) * (t - first.0) / (last.0 - first.0);
    let reversals = velocity
        .windows(2)
        .filter(|pair| pair[0] * pair[1] < 0.0)
        .count();
    if within(&|_| mean) {
        Protocol::Constant
    } else if direction != Direction::Both && first.1.abs() <= 0.02 * largest && within(&line) {
        Protocol::Ramp
    } else if reversals >= 2 {
        Protocol::Cycles
    } else {
        Protocol::Free
    }
}

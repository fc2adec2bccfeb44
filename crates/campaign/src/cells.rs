//! A CSV file as columns of numbers: every cell is read as text with its row and column, then checked.
//!
//! Whatever is wrong is refused, never repaired: a short row, a blank line, an empty cell, `nan`, `inf`, `1e400`.

use crate::refusal::{Problem, Refusal, quoted};

/// A run needs at least so many samples.
pub(crate) const LEAST_SAMPLES: usize = 20;

/// The numeric columns that were asked for, in the order asked, each as long as the file has rows.
pub(crate) struct Columns {
    pub(crate) values: Vec<Vec<f64>>,
    /// The file's line of each sample.
    pub(crate) lines: Vec<usize>,
}

/// Names in the header, checked against the schema: both must hold the same names, each once, in any order.
pub(crate) fn header(
    file: &str,
    text: &[u8],
    delimiter: u8,
    schema: &[String],
) -> Result<Vec<String>, Refusal> {
    let mut reader = reader(text, delimiter);
    let mut record = csv::ByteRecord::new();
    reader
        .read_byte_record(&mut record)
        .map_err(|error| Refusal::at_row(file, 1, Problem::Csv(one_line(&error))))?;
    let names: Vec<String> = record
        .iter()
        .map(|name| String::from_utf8_lossy(name).trim().to_owned())
        .collect();
    let doubled = |names: &[String]| {
        names
            .iter()
            .enumerate()
            .find(|(index, name)| names[..*index].contains(name))
            .map(|(_, name)| name.clone())
    };
    if let Some(name) = doubled(&names) {
        return Err(Refusal::at_cell(file, 1, &name, Problem::DoubledColumn));
    }
    if let Some(name) = doubled(schema) {
        return Err(Refusal::at_column(file, &name, Problem::DoubledColumn));
    }
    if let Some(name) = schema.iter().find(|name| !names.contains(name)) {
        return Err(Refusal::at_column(file, name, Problem::MissingColumn));
    }
    if let Some(name) = names.iter().find(|name| !schema.contains(name)) {
        return Err(Refusal::at_cell(file, 1, name, Problem::UnknownColumn));
    }
    Ok(names)
}

/// Reads the columns `wanted` (indices into the header `names`) of the file's text.
pub(crate) fn columns(
    file: &str,
    text: &[u8],
    delimiter: u8,
    names: &[String],
    wanted: &[usize],
) -> Result<Columns, Refusal> {
    refuse_blank_lines(file, text)?;
    let mut reader = reader(text, delimiter);
    let mut record = csv::ByteRecord::new();
    let mut values = vec![Vec::new(); wanted.len()];
    let mut lines = Vec::new();
    // The header was read and checked before.
    reader
        .read_byte_record(&mut record)
        .map_err(|error| Refusal::at_row(file, 1, Problem::Csv(one_line(&error))))?;
    loop {
        let line = lines.len() + 2;
        let more = reader
            .read_byte_record(&mut record)
            .map_err(|error| Refusal::at_row(file, line, Problem::Csv(one_line(&error))))?;
        if !more {
            break;
        }
        if record.len() != names.len() {
            let problem = Problem::Width {
                found: record.len(),
                expected: names.len(),
            };
            return Err(Refusal::at_row(file, line, problem));
        }
        for (column, &index) in values.iter_mut().zip(wanted) {
            let number = cell(&record[index])
                .map_err(|problem| Refusal::at_cell(file, line, &names[index], problem))?;
            column.push(number);
        }
        lines.push(line);
    }
    if lines.len() < LEAST_SAMPLES {
        let problem = Problem::TooFewSamples {
            found: lines.len(),
            needed: LEAST_SAMPLES,
        };
        return Err(Refusal::of(file, problem));
    }
    Ok(Columns { values, lines })
}

/// A reader that hands out every row as it stands, the header included.
fn reader(text: &[u8], delimiter: u8) -> csv::Reader<&[u8]> {
    csv::ReaderBuilder::new()
        .delimiter(delimiter)
        .has_headers(false)
        .flexible(true)
        .from_reader(text)
}

/// One cell as a finite number; spaces around it do not count.
fn cell(bytes: &[u8]) -> Result<f64, Problem> {
    let text = String::from_utf8_lossy(bytes);
    let text = text.trim();
    if text.is_empty() {
        return Err(Problem::EmptyCell);
    }
    let number: f64 = text
        .parse()
        .map_err(|_| Problem::NotANumber(quoted(text, 40)))?;
    // `1e400` reads as infinity.
    if number.is_finite() {
        Ok(number)
    } else {
        Err(Problem::NotFinite(quoted(text, 40)))
    }
}

/// The csv reader skips blank lines; a missing row must not vanish so.
fn refuse_blank_lines(file: &str, text: &[u8]) -> Result<(), Refusal> {
    let body = text.strip_suffix(b"\n").unwrap_or(text);
    let blank = body
        .split(|byte| *byte == b'\n')
        .position(|line| line.trim_ascii().is_empty());
    match blank {
        Some(0) if body.is_empty() => Err(Refusal::of(
            file,
            Problem::TooFewSamples {
                found: 0,
                needed: LEAST_SAMPLES,
            },
        )),
        Some(index) => Err(Refusal::at_row(file, index + 1, Problem::EmptyRow)),
        None => Ok(()),
    }
}

/// An error of the csv reader without line breaks.
fn one_line(error: &csv::Error) -> String {
    quoted(&error.to_string(), 200)
}

//! Tables: plain cells, numbers with their rounding, values by id; also from polars frames.

use polars::prelude::{AnyValue, DataFrame};
use serde::{Deserialize, Serialize};

use crate::figure::Provenance;
use crate::{Error, Evidence, Prose, Verdict};

/// How a column is set.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Align {
    /// Words.
    #[default]
    Left,
    /// Numbers, with tabular figures.
    Right,
    /// Marks.
    Centre,
}

/// One column.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Column {
    /// Heading; may hold inline mathematics.
    pub name: Prose,
    /// Unit; empty or `1` is not shown.
    pub unit: String,
    /// How it is set.
    pub align: Align,
}

impl Column {
    /// A column of words.
    pub fn text(name: impl Into<Prose>) -> Self {
        Self {
            name: name.into(),
            unit: String::new(),
            align: Align::Left,
        }
    }

    /// A column of numbers.
    pub fn number(name: impl Into<Prose>, unit: &str) -> Self {
        Self {
            name: name.into(),
            unit: unit.into(),
            align: Align::Right,
        }
    }
}

/// One cell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Cell {
    /// Words, shown as they are.
    Text(String),
    /// Words with mark-up and values by id.
    Prose(Prose),
    /// A number, to four significant digits.
    Number(f64),
    /// A number to so many significant digits.
    Digits(f64, u8),
    /// A number with its 95 % interval.
    Interval(f64, [f64; 2]),
    /// A value of the results, by id, with its interval.
    Value(String),
    /// A verdict chip.
    Verdict(Verdict),
    /// Nothing, and why.
    Missing(String),
}

impl From<f64> for Cell {
    fn from(number: f64) -> Self {
        if number.is_finite() {
            Self::Number(number)
        } else {
            Self::Missing("not a finite number".into())
        }
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.into())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

/// A table card: shown with its caption, downloadable as CSV.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Table {
    /// Id, unique on the page: its address, and the name of its file.
    pub id: String,
    /// Heading of the card.
    pub title: String,
    /// What it shows and what to read from it.
    pub caption: Prose,
    /// Columns; the first one heads the rows.
    pub columns: Vec<Column>,
    /// Rows, each as wide as the columns.
    pub rows: Vec<Vec<Cell>>,
    /// What it rests on; `synthetic` is stamped on the card.
    pub evidence: Option<Evidence>,
    /// Counterpart in the paper, such as `Table 1`.
    pub paper: Option<String>,
    /// Who made it, from what.
    pub provenance: Option<Provenance>,
    /// Claims that use it.
    pub claims: Vec<String>,
}

impl Table {
    /// A table from a polars frame; numbers get right alignment, nulls are shown as missing.
    ///
    /// `units` has one entry a column of the frame (`""` or `1` for none).
    ///
    /// # Errors
    /// [`Error::Table`] where the number of units is not that of the columns.
    pub fn from_frame(
        id: &str,
        title: &str,
        frame: &DataFrame,
        units: &[&str],
    ) -> Result<Self, Error> {
        if units.len() != frame.width() {
            return Err(Error::Table {
                id: id.into(),
                why: format!("{} units for {} columns", units.len(), frame.width()),
            });
        }
        let columns = frame
            .columns()
            .iter()
            .zip(units)
            .map(|(column, unit)| Column {
                name: Prose(crate::typeset(column.name())),
                unit: (*unit).into(),
                align: if column.dtype().is_primitive_numeric() {
                    Align::Right
                } else {
                    Align::Left
                },
            })
            .collect();
        let rows = (0..frame.height())
            .map(|row| {
                frame
                    .columns()
                    .iter()
                    .map(|column| {
                        column
                            .get(row)
                            .map_or_else(|_| missing(), |value| cell(&value))
                    })
                    .collect()
            })
            .collect();
        Ok(Self {
            id: id.into(),
            title: title.into(),
            columns,
            rows,
            ..Self::default()
        })
    }
}

fn missing() -> Cell {
    Cell::Missing("no value".into())
}

fn cell(value: &AnyValue<'_>) -> Cell {
    match value {
        AnyValue::Null => missing(),
        AnyValue::String(text) => Cell::Text((*text).to_string()),
        AnyValue::StringOwned(text) => Cell::Text(text.to_string()),
        other => other
            .extract::<f64>()
            .map_or_else(|| Cell::Text(other.to_string()), Cell::from),
    }
}

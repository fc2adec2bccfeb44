//! The published numbers, read from where they stand once: `data/published.toml`.

use std::path::Path;
use toml::{Table, Value};

/// The paper's printed numbers, by dotted path.
#[derive(Clone, Debug)]
pub struct Published {
    table: Table,
}

impl Published {
    /// Reads the file.
    ///
    /// # Errors
    /// If it cannot be read or is not TOML.
    pub fn read(path: &Path) -> Result<Self, Box<dyn std::error::Error>> {
        let text = std::fs::read_to_string(path)
            .map_err(|error| format!("{}: {error}", path.display()))?;
        let table = text
            .parse::<Table>()
            .map_err(|error| format!("{}: {error}", path.display()))?;
        Ok(Self { table })
    }

    /// The number at a path such as `table1.sigma0`: `value` where the paper prints a word, else `printed`.
    ///
    /// # Errors
    /// If there is no such entry or it holds no number.
    pub fn number(&self, path: &str) -> Result<f64, Box<dyn std::error::Error>> {
        let missing = || format!("published.toml has no number {path}");
        let mut entry = &self.table;
        for part in path.split('.') {
            entry = entry
                .get(part)
                .and_then(Value::as_table)
                .ok_or_else(missing)?;
        }
        match (
            entry.get("value"),
            entry.get("printed").and_then(Value::as_str),
        ) {
            (Some(Value::Float(value)), _) => Ok(*value),
            #[allow(clippy::cast_precision_loss)]
            (Some(Value::Integer(value)), _) => Ok(*value as f64),
            (_, Some(printed)) => Ok(printed.parse::<f64>().map_err(|_| missing())?),
            _ => Err(missing().into()),
        }
    }
}

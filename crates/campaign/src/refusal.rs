//! What the door says when it does not let a package in: one line that names the file, the row and the column.

/// Why a package is refused. Its `Display` is one line: `FILE, row R, column C: what is wrong`.
///
/// Rows are lines of the file, the header being row 1.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{}: {problem}", place(file, field.as_deref(), *row, column.as_deref()))]
pub struct Refusal {
    /// The file, as the path was given.
    pub file: String,
    /// The entry of a JSON file, such as `resources[0].run.direction`.
    pub field: Option<String>,
    /// The line of a CSV file.
    pub row: Option<usize>,
    /// The column of a CSV file.
    pub column: Option<String>,
    /// What is wrong (boxed: a refusal travels through every `Result` of the door).
    pub problem: Box<Problem>,
}

/// What can be wrong with a package.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Problem {
    /// The file or folder is not there or cannot be read.
    #[error("cannot be read: {0}")]
    Unreadable(String),
    /// A device, a pipe, a folder where a file should be.
    #[error("is not a regular file")]
    NotAFile,
    /// More bytes than the door takes.
    #[error("is larger than {limit_mib} MiB")]
    TooLarge {
        /// The limit.
        limit_mib: u64,
    },
    /// Not JSON.
    #[error("is not JSON: {0}")]
    Json(String),
    /// An object has a key twice: key and place.
    #[error("the key {0}")]
    DoubledKey(String),
    /// A required entry is not there.
    #[error("is missing")]
    Missing,
    /// An entry has the wrong JSON type.
    #[error("must be {expected}")]
    WrongType {
        /// What it must be.
        expected: &'static str,
    },
    /// A word that is none of the known ones.
    #[error("`{found}` is not one of {known}")]
    UnknownWord {
        /// The word.
        found: String,
        /// The known ones.
        known: String,
    },
    /// A number that must be above zero is not.
    #[error("must be above zero, but is {0}")]
    NotPositive(f64),
    /// The path is absolute, climbs out of the folder or leads out of it through a link.
    #[error("the path `{0}` leaves the folder of the package")]
    PathLeaves(String),
    /// Two resources have one name.
    #[error("two runs are called `{0}`")]
    DuplicateRun(String),
    /// Two resources read one file.
    #[error("the runs `{first}` and `{second}` read the same file")]
    DuplicateFile {
        /// The first.
        first: String,
        /// The second.
        second: String,
    },
    /// There is no run.
    #[error("the package holds no run")]
    NoRuns,
    /// A unit that is not known for this quantity.
    #[error("`{unit}` is not a unit of {quantity} ({known})")]
    UnknownUnit {
        /// The unit.
        unit: String,
        /// The quantity.
        quantity: &'static str,
        /// Its units.
        known: String,
    },
    /// A column has no unit.
    #[error("has no unit")]
    NoUnit,
    /// A needed column is not there.
    #[error("the column is missing")]
    MissingColumn,
    /// A needed quantity has no column.
    #[error("no column holds {0}")]
    MissingQuantity(&'static str),
    /// A column stands twice.
    #[error("the column stands twice")]
    DoubledColumn,
    /// Two columns hold one quantity.
    #[error("`{first}` and `{second}` both hold {quantity}")]
    DoubledQuantity {
        /// The quantity.
        quantity: &'static str,
        /// One column.
        first: String,
        /// The other.
        second: String,
    },
    /// A column of the file is not in the schema.
    #[error("the column is not in the schema")]
    UnknownColumn,
    /// Columns of a linear and of a rotary rig together.
    #[error("linear and rotary columns are mixed ({0})")]
    MixedAxes(String),
    /// A row of another width.
    #[error("has {found} cells, but the header has {expected}")]
    Width {
        /// Cells in the row.
        found: usize,
        /// Cells in the header.
        expected: usize,
    },
    /// A line without cells.
    #[error("the row is empty")]
    EmptyRow,
    /// A cell without text.
    #[error("the cell is empty")]
    EmptyCell,
    /// A cell that is no number.
    #[error("`{0}` is not a number")]
    NotANumber(String),
    /// A cell that is no finite number.
    #[error("`{0}` is not a finite number")]
    NotFinite(String),
    /// Time stands still or runs backwards.
    #[error("time does not increase: {now} s after {before} s")]
    TimeOrder {
        /// The time before.
        before: f64,
        /// This time.
        now: f64,
    },
    /// Too few rows.
    #[error("has {found} samples, but at least {needed} are needed")]
    TooFewSamples {
        /// Rows of the file.
        found: usize,
        /// The least number.
        needed: usize,
    },
    /// A load below zero.
    #[error("the normal load is {0} N, below zero")]
    NegativeLoad(f64),
    /// A load of zero under a protocol that needs one.
    #[error("the normal load is zero, which only the protocol `unloaded` may have")]
    ZeroLoad,
    /// An unloaded run with a load.
    #[error("the protocol is `unloaded`, but the normal load is {0} N")]
    LoadedUnloaded(f64),
    /// The velocity has a sign that the direction excludes.
    #[error("the direction is `{direction}`, but the velocity is {velocity}")]
    Direction {
        /// The stated direction.
        direction: &'static str,
        /// The velocity in SI units, with its unit.
        velocity: String,
    },
    /// A CSV dialect that the door does not read.
    #[error("{0} is not supported")]
    Unsupported(&'static str),
    /// The file is not a table that can be read at all.
    #[error("is not CSV: {0}")]
    Csv(String),
}

/// `FILE, FIELD, row R, column C`, leaving out what does not apply.
fn place(file: &str, field: Option<&str>, row: Option<usize>, column: Option<&str>) -> String {
    let mut place = quoted(file, usize::MAX);
    if let Some(field) = field {
        place += &format!(", {field}");
    }
    if let Some(row) = row {
        place += &format!(", row {row}");
    }
    if let Some(column) = column {
        place += &format!(", column {}", quoted(column, 60));
    }
    place
}

/// Foreign text on one line and of bounded length, so that no content can forge or break a message.
pub(crate) fn quoted(text: &str, longest: usize) -> String {
    let mut short: String = text
        .chars()
        .take(longest)
        .flat_map(char::escape_debug)
        .collect();
    if text.chars().count() > longest {
        short.push_str("...");
    }
    // Quotation marks need no escape between backticks.
    short.replace("\\'", "'").replace("\\\"", "\"")
}

impl Refusal {
    /// About a whole file.
    pub(crate) fn of(file: &str, problem: Problem) -> Self {
        Self {
            file: file.to_owned(),
            field: None,
            row: None,
            column: None,
            problem: Box::new(problem),
        }
    }

    /// About an entry of a JSON file.
    pub(crate) fn at_field(file: &str, field: &str, problem: Problem) -> Self {
        Self {
            field: Some(field.to_owned()),
            ..Self::of(file, problem)
        }
    }

    /// About a row of a CSV file.
    pub(crate) fn at_row(file: &str, row: usize, problem: Problem) -> Self {
        Self {
            row: Some(row),
            ..Self::of(file, problem)
        }
    }

    /// About a column of a CSV file.
    pub(crate) fn at_column(file: &str, column: &str, problem: Problem) -> Self {
        Self {
            column: Some(column.to_owned()),
            ..Self::of(file, problem)
        }
    }

    /// About a cell of a CSV file.
    pub(crate) fn at_cell(file: &str, row: usize, column: &str, problem: Problem) -> Self {
        Self {
            row: Some(row),
            ..Self::at_column(file, column, problem)
        }
    }
}

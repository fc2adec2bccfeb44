//! The paper's numbers as printed, with the interval that the printed digits leave open.
//!
//! A number printed with d digits after its point and exponent e stands for the interval
//! value +- 0.5 10^(e - d): "12.61" for [12.605, 12.615], "6.96e-3" for [6.955e-3, 6.965e-3].

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;

/// A closed interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Lower end.
    pub lower: f64,
    /// Upper end.
    pub upper: f64,
}

impl Interval {
    /// From two ends in either order.
    #[must_use]
    pub fn between(a: f64, b: f64) -> Self {
        Self {
            lower: a.min(b),
            upper: a.max(b),
        }
    }

    /// Smallest interval that holds f over the ends of `self` and `other`: exact for f monotone in both.
    #[must_use]
    pub fn combine(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let corners = [
            f(self.lower, other.lower),
            f(self.lower, other.upper),
            f(self.upper, other.lower),
            f(self.upper, other.upper),
        ];
        Self {
            lower: corners.iter().copied().fold(f64::INFINITY, f64::min),
            upper: corners.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        }
    }

    /// Whether the two intervals share a point.
    #[must_use]
    pub fn meets(self, other: Self) -> bool {
        self.lower <= other.upper && other.lower <= self.upper
    }

    /// Whether `x` lies inside, ends included.
    #[must_use]
    pub fn contains(self, x: f64) -> bool {
        self.lower <= x && x <= self.upper
    }

    /// Distance from `x` to the interval, 0 inside.
    #[must_use]
    pub fn distance(self, x: f64) -> f64 {
        (self.lower - x).max(x - self.upper).max(0.0)
    }

    /// Half of the length.
    #[must_use]
    pub fn half_width(self) -> f64 {
        0.5 * (self.upper - self.lower)
    }
}

/// One number of the paper.
#[derive(Clone, Debug, PartialEq)]
pub struct Printed {
    /// As it stands in the paper.
    pub printed: String,
    /// The number.
    pub value: f64,
    /// What the printed digits leave open.
    pub interval: Interval,
    /// The paper's own unit.
    pub unit: String,
    /// Where it stands.
    pub locator: String,
    /// What it is.
    pub meaning: String,
}

/// Why the published numbers could not be read.
#[derive(Debug, thiserror::Error)]
pub enum PublishedError {
    /// The file could not be read.
    #[error("{}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The file is not TOML.
    #[error("published numbers: {0}")]
    Toml(#[from] Box<toml::de::Error>),
    /// An entry lacks a field or is not a number.
    #[error("published number `{id}`: {problem}")]
    Entry {
        /// Which.
        id: String,
        /// What is wrong with it.
        problem: String,
    },
}

/// All published numbers by their dotted id.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Published {
    numbers: BTreeMap<String, Printed>,
}

/// The seven numbers of a row of Table 1 or 2, in the paper's units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LawNumbers {
    /// sigma, printed with the unit 1/m.
    pub sigma: f64,
    /// sigma0.
    pub sigma0: f64,
    /// sigma1.
    pub sigma1: f64,
    /// sigma2, s.
    pub sigma2: f64,
    /// theta_c, printed with the unit 1/m.
    pub theta_c: f64,
    /// theta_s, printed with the unit 1/m.
    pub theta_s: f64,
    /// omega_sc, rad/s.
    pub omega_sc: f64,
}

/// An entry as it stands in the file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    printed: String,
    unit: String,
    locator: String,
    meaning: String,
    value: Option<f64>,
    #[serde(default)]
    exact: bool,
}

impl Published {
    /// Reads the file.
    ///
    /// # Errors
    /// Where it cannot be read or an entry is not a number with unit, locator and meaning.
    pub fn read(path: &Path) -> Result<Self, PublishedError> {
        let text = std::fs::read_to_string(path).map_err(|source| PublishedError::Read {
            path: path.to_owned(),
            source,
        })?;
        Self::parse(&text)
    }

    /// Reads the text of the file: every table with a key `printed` is a number, named by its dotted path.
    ///
    /// # Errors
    /// As for [`Published::read`].
    pub fn parse(text: &str) -> Result<Self, PublishedError> {
        let root: toml::Table = toml::from_str(text).map_err(Box::new)?;
        let mut numbers = BTreeMap::new();
        collect(&mut numbers, "", root)?;
        Ok(Self { numbers })
    }

    /// The number with this id.
    #[must_use]
    pub fn get(&self, id: &str) -> Option<&Printed> {
        self.numbers.get(id)
    }

    /// The number with this id; the ids are the program's own, so a missing one is a broken installation.
    ///
    /// # Errors
    /// Where the file holds no such number.
    pub fn number(&self, id: &str) -> Result<&Printed, PublishedError> {
        self.get(id).ok_or_else(|| PublishedError::Entry {
            id: id.to_owned(),
            problem: "is missing from data/published.toml".to_owned(),
        })
    }

    /// The value with this id, in the paper's unit.
    ///
    /// # Errors
    /// Where the file holds no such number.
    pub fn value(&self, id: &str) -> Result<f64, PublishedError> {
        Ok(self.number(id)?.value)
    }

    /// The rounding interval with this id, in the paper's unit.
    ///
    /// # Errors
    /// Where the file holds no such number.
    pub fn interval(&self, id: &str) -> Result<Interval, PublishedError> {
        Ok(self.number(id)?.interval)
    }

    /// A row of parameters: `table1`, `table2.aluminium`, `table2.nylon` or `table2.ceramic`.
    ///
    /// # Errors
    /// Where a number of the row is missing.
    pub fn law(&self, row: &str) -> Result<LawNumbers, PublishedError> {
        let number = |name: &str| self.value(&format!("{row}.{name}"));
        Ok(LawNumbers {
            sigma: number("sigma")?,
            sigma0: number("sigma0")?,
            sigma1: number("sigma1")?,
            sigma2: number("sigma2")?,
            theta_c: number("theta_c")?,
            theta_s: number("theta_s")?,
            omega_sc: number("omega_sc")?,
        })
    }

    /// All numbers in the order of their ids.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &Printed)> {
        self.numbers
            .iter()
            .map(|(id, number)| (id.as_str(), number))
    }

    /// The same numbers with one printed differently: for negative controls and tests.
    ///
    /// # Errors
    /// Where there is no such number or the new text is none.
    pub fn altered(&self, id: &str, printed: &str) -> Result<Self, PublishedError> {
        let mut altered = self.clone();
        let old = self.number(id)?;
        let (value, interval) = read_printed(printed).ok_or_else(|| PublishedError::Entry {
            id: id.to_owned(),
            problem: format!("`{printed}` is not a number"),
        })?;
        let exact = old.interval.half_width() == 0.0;
        let interval = if exact {
            Interval {
                lower: value,
                upper: value,
            }
        } else {
            interval
        };
        altered.numbers.insert(
            id.to_owned(),
            Printed {
                printed: printed.to_owned(),
                value,
                interval,
                ..old.clone()
            },
        );
        Ok(altered)
    }
}

/// Walks the tables; a table with the key `printed` is a number.
fn collect(
    numbers: &mut BTreeMap<String, Printed>,
    prefix: &str,
    table: toml::Table,
) -> Result<(), PublishedError> {
    for (key, value) in table {
        let id = if prefix.is_empty() {
            key
        } else {
            format!("{prefix}.{key}")
        };
        let refuse = |problem: String| PublishedError::Entry {
            id: id.clone(),
            problem,
        };
        match value {
            toml::Value::Table(inner) if inner.contains_key("printed") => {
                let entry: Entry = inner
                    .try_into()
                    .map_err(|error: toml::de::Error| refuse(error.message().to_owned()))?;
                numbers.insert(id.clone(), checked(entry).map_err(refuse)?);
            }
            toml::Value::Table(inner) => collect(numbers, &id, inner)?,
            _ => return Err(refuse("is not a table with the key `printed`".to_owned())),
        }
    }
    Ok(())
}

/// An entry with its value and interval.
fn checked(entry: Entry) -> Result<Printed, String> {
    let (value, interval) = match (read_printed(&entry.printed), entry.value) {
        (_, Some(value)) => (
            value,
            Interval {
                lower: value,
                upper: value,
            },
        ),
        (Some((value, _)), None) if entry.exact => (
            value,
            Interval {
                lower: value,
                upper: value,
            },
        ),
        (Some(read), None) => read,
        (None, None) => {
            return Err(format!(
                "`{}` is not a number and no `value` is given",
                entry.printed
            ));
        }
    };
    Ok(Printed {
        printed: entry.printed,
        value,
        interval,
        unit: entry.unit,
        locator: entry.locator,
        meaning: entry.meaning,
    })
}

/// Value and rounding interval of a printed decimal number, with or without exponent.
///
/// Both ends are read from decimal text again, so that "0.6682" gives the doubles nearest to 0.66815 and 0.66825.
fn read_printed(printed: &str) -> Option<(f64, Interval)> {
    let value: f64 = printed
        .parse()
        .ok()
        .filter(|value: &f64| value.is_finite())?;
    let (mantissa, exponent) = printed.split_once(['e', 'E']).unwrap_or((printed, "0"));
    let exponent: i32 = exponent.parse().ok()?;
    let (whole, decimals) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    // The mantissa as an integer in units of a tenth of its last digit: half a unit is then 5.
    let scaled: i64 = format!("{whole}{decimals}0").parse().ok()?;
    let power = exponent - i32::try_from(decimals.len()).ok()? - 1;
    let end = |shift: i64| {
        format!("{}e{power}", scaled.checked_add(shift)?)
            .parse::<f64>()
            .ok()
    };
    Some((
        value,
        Interval {
            lower: end(-5)?,
            upper: end(5)?,
        },
    ))
}

#[cfg(test)]
impl Published {
    /// The numbers that the repository ships.
    pub(crate) fn shipped() -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/published.toml");
        Self::read(&path).unwrap()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_printed_number_stands_for_half_a_unit_of_its_last_digit_either_way() {
        let (value, interval) = read_printed("12.61").unwrap();
        assert_eq!(
            (value, interval.lower, interval.upper),
            (12.61, 12.605, 12.615)
        );
        let (_, interval) = read_printed("6.96e-3").unwrap();
        assert_eq!((interval.lower, interval.upper), (6.955e-3, 6.965e-3));
        let (_, interval) = read_printed("-45").unwrap();
        assert_eq!((interval.lower, interval.upper), (-45.5, -44.5));
        let (_, interval) = read_printed("0.90").unwrap();
        assert_eq!((interval.lower, interval.upper), (0.895, 0.905));
        assert!(read_printed("six").is_none());
        assert!(read_printed("1e400").is_none());
    }

    #[test]
    fn the_shipped_numbers_read() {
        let published = Published::shipped();
        assert_eq!(
            published.law("table1").unwrap(),
            published.law("table2.aluminium").unwrap()
        );
        assert_eq!(published.value("brush.count_3x3").unwrap(), 6.0);
        assert!(
            published
                .iter()
                .all(|(_, number)| number.interval.contains(number.value))
        );
    }

    #[test]
    fn an_altered_number_is_the_only_difference() {
        let published = Published::shipped();
        let altered = published.altered("gait.gain", "30.00").unwrap();
        let changed: Vec<_> = published
            .iter()
            .zip(altered.iter())
            .filter(|(old, new)| old != new)
            .map(|((id, _), _)| id)
            .collect();
        assert_eq!(changed, ["gait.gain"]);
    }
}

//! What can be read off a plain CSV file: delimiter, decimal mark, which column holds what, in which unit.

use crate::units::Quantity;

/// How the file is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Writing {
    pub(crate) delimiter: u8,
    pub(crate) decimal_comma: bool,
}

/// Told by the header and the first row: a semicolon or tab in the header separates; then a comma in a cell is a decimal
/// mark.
pub(crate) fn writing(text: &str) -> Writing {
    let mut lines = text.lines();
    let header = lines.next().unwrap_or_default();
    let first = lines.next().unwrap_or_default();
    let delimiter = [b';', b'\t', b'|']
        .into_iter()
        .find(|delimiter| header.bytes().any(|byte| byte == *delimiter))
        .unwrap_or(b',');
    Writing {
        delimiter,
        decimal_comma: delimiter != b',' && first.contains(','),
    }
}

/// A column as guessed: the quantity, and the unit if the header names one that is known.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Guess {
    pub(crate) quantity: Quantity,
    pub(crate) unit: Option<&'static str>,
}

/// Words that headers use for a quantity, the most telling first.
const WORDS: [(Quantity, &[&str]); 6] = [
    (
        Quantity::NormalForce,
        &[
            "normal force",
            "normalforce",
            "normal load",
            "normal",
            "load",
            "fn",
            "fz",
            "n force",
        ],
    ),
    (Quantity::Torque, &["torque", "moment", "tau"]),
    (Quantity::Temperature, &["temperature", "temp"]),
    (Quantity::Time, &["time", "timestamp", "zeit", "t"]),
    (
        Quantity::Velocity,
        &["velocity", "speed", "vel", "omega", "v", "w", "qd", "dq"],
    ),
    (
        Quantity::Force,
        &[
            "friction force",
            "friction",
            "tension",
            "force",
            "ft",
            "fx",
            "f",
        ],
    ),
];
const POSITION_WORDS: &[&str] = &[
    "position",
    "displacement",
    "pos",
    "angle",
    "stroke",
    "distance",
    "x",
    "q",
    "theta",
];

/// Spellings of units in headers, beside the exact ones of a package.
const UNITS: [(&str, &[&str]); 15] = [
    (
        "mm/s",
        &["mm/s", "mm_s", "mmps", "mm s-1", "mm.s-1", "mm s^-1"],
    ),
    ("rad/s", &["rad/s", "rad_s", "radps", "rad s-1", "rad s^-1"]),
    ("m/s", &["m/s", "m_s", "mps", "m s-1", "m.s-1", "m s^-1"]),
    ("mN m", &["mn m", "mnm", "mn_m", "mn*m"]),
    ("N m", &["n m", "nm", "n_m", "n*m", "n.m", "n\u{b7}m"]),
    ("mN", &["mn", "millinewton", "millinewtons"]),
    ("N", &["n", "newton", "newtons"]),
    (
        "mm",
        &[
            "mm",
            "millimetre",
            "millimeter",
            "millimetres",
            "millimeters",
        ],
    ),
    ("rad", &["rad", "radian", "radians"]),
    ("m", &["m", "metre", "meter", "metres", "meters"]),
    ("ms", &["ms", "msec", "milliseconds"]),
    ("s", &["s", "sec", "second", "seconds"]),
    ("degC", &["degc", "c", "\u{b0}c", "celsius"]),
    ("K", &["k", "kelvin"]),
    ("1", &["1"]),
];

/// What a header says: `Time (s)`, `velocity [mm/s]`, `F/N`, `force_n`, `v, m/s`.
pub(crate) fn column(header: &str) -> Option<Guess> {
    let header = header.trim().trim_start_matches('\u{feff}').to_lowercase();
    let (stem, unit_text) = split_unit(&header);
    let quantity = quantity(&stem)?;
    let unit = unit_text.as_deref().and_then(unit);
    let quantity = match unit {
        Some(unit) => quantity.with_unit(unit),
        None => quantity,
    };
    let unit = unit.filter(|unit| quantity.conversion(unit).is_ok());
    Some(Guess { quantity, unit })
}

/// Splits `name (unit)`, `name [unit]`, `name / unit`, `name, unit` or `name_unit`.
fn split_unit(header: &str) -> (String, Option<String>) {
    for (open, close) in [('(', ')'), ('[', ']'), ('<', '>'), ('{', '}')] {
        if let Some((stem, rest)) = header.split_once(open) {
            let unit = rest.split(close).next().unwrap_or_default();
            return (clean(stem), Some(unit.trim().to_owned()));
        }
    }
    for mark in ["/", ", ", " in "] {
        if let Some((stem, rest)) = header.split_once(mark)
            && unit(rest.trim()).is_some()
        {
            return (clean(stem), Some(rest.trim().to_owned()));
        }
    }
    // The longest tail behind an underscore or a space that is a unit: `velocity_mm_s` before `velocity_mm` + `s`.
    let places = header
        .char_indices()
        .filter(|(_, mark)| *mark == '_' || *mark == ' ');
    for (place, _) in places {
        let (stem, tail) = (&header[..place], &header[place + 1..]);
        if unit(tail).is_some() && quantity(&clean(stem)).is_some() {
            return (clean(stem), Some(tail.to_owned()));
        }
    }
    (clean(header), None)
}

fn clean(stem: &str) -> String {
    stem.replace(['_', '-', '.'], " ").trim().to_owned()
}

fn unit(text: &str) -> Option<&'static str> {
    UNITS
        .iter()
        .find(|(_, spellings)| spellings.contains(&text))
        .map(|(unit, _)| *unit)
}

/// The quantity whose word stands in the stem: the whole stem first, then one of its words.
fn quantity(stem: &str) -> Option<Quantity> {
    let table = || {
        WORDS
            .into_iter()
            .chain([(Quantity::Position, POSITION_WORDS)])
    };
    let whole = table().find(|(_, words)| words.contains(&stem));
    let part = || {
        table().find(|(_, words)| {
            let long = words.iter().filter(|word| word.len() > 3);
            long.into_iter()
                .any(|word| stem.split(' ').any(|part| part == *word))
        })
    };
    whole.or_else(part).map(|(quantity, _)| quantity)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_of_many_habits_are_read() {
        let read = |header| column(header).map(|guess| (guess.quantity, guess.unit));
        assert_eq!(read("time_s"), Some((Quantity::Time, Some("s"))));
        assert_eq!(read("Time (ms)"), Some((Quantity::Time, Some("ms"))));
        assert_eq!(
            read("velocity_mm_s"),
            Some((Quantity::Velocity, Some("mm/s")))
        );
        assert_eq!(
            read("Velocity [m/s]"),
            Some((Quantity::Velocity, Some("m/s")))
        );
        assert_eq!(
            read("omega (rad/s)"),
            Some((Quantity::AngularVelocity, Some("rad/s")))
        );
        assert_eq!(read("F/N"), Some((Quantity::Force, Some("N"))));
        assert_eq!(
            read("friction force, mN"),
            Some((Quantity::Force, Some("mN")))
        );
        assert_eq!(
            read("normal_force_n"),
            Some((Quantity::NormalForce, Some("N")))
        );
        assert_eq!(read("torque [Nm]"), Some((Quantity::Torque, Some("N m"))));
        assert_eq!(read("q (rad)"), Some((Quantity::Angle, Some("rad"))));
        assert_eq!(read("force"), Some((Quantity::Force, None)));
        assert_eq!(read("force (lbf)"), Some((Quantity::Force, None)));
        assert_eq!(read("comment"), None);
    }

    #[test]
    fn a_semicolon_makes_the_comma_a_decimal_mark() {
        assert_eq!(
            writing("a;b\n1,5;2\n"),
            Writing {
                delimiter: b';',
                decimal_comma: true
            }
        );
        assert_eq!(
            writing("a,b\n1.5,2\n"),
            Writing {
                delimiter: b',',
                decimal_comma: false
            }
        );
    }
}

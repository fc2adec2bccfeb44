//! Quantities, their units and the names of their columns. Conversion to SI happens here and nowhere else.

use crate::refusal::{Problem, quoted};

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Quantity {
    Time,
    Velocity,
    Force,
    Position,
    NormalForce,
    Temperature,
    AngularVelocity,
    Angle,
    Torque,
}

/// A unit: how it is written, and SI value = (written value - zero) / divisor.
///
/// Division, not multiplication: 1000 is exact and 0.001 is not.
struct Unit {
    spellings: &'static [&'static str],
    divisor: f64,
    zero: f64,
}

const fn unit(spellings: &'static [&'static str], divisor: f64) -> Unit {
    Unit {
        spellings,
        divisor,
        zero: 0.0,
    }
}

const TIME: &[Unit] = &[unit(&["s"], 1.0), unit(&["ms"], 1000.0)];
const LENGTH: &[Unit] = &[unit(&["mm"], 1000.0), unit(&["m"], 1.0)];
const SPEED: &[Unit] = &[unit(&["mm/s"], 1000.0), unit(&["m/s"], 1.0)];
const FORCE: &[Unit] = &[unit(&["N"], 1.0), unit(&["mN"], 1000.0)];
const ANGLE: &[Unit] = &[unit(&["rad"], 1.0)];
const ANGULAR_SPEED: &[Unit] = &[unit(&["rad/s"], 1.0)];
const TORQUE: &[Unit] = &[
    unit(&["N m", "Nm", "N*m", "N.m", "N\u{b7}m"], 1.0),
    unit(&["mN m", "mNm", "mN*m", "mN.m", "mN\u{b7}m"], 1000.0),
];
const TEMPERATURE: &[Unit] = &[
    unit(&["degC", "C", "\u{b0}C", "Celsius", "celsius"], 1.0),
    Unit {
        spellings: &["K"],
        divisor: 1.0,
        zero: 273.15,
    },
];

impl Quantity {
    /// All of them; those of a linear rig first.
    pub(crate) const ALL: [Self; 9] = [
        Self::Time,
        Self::Velocity,
        Self::Force,
        Self::Position,
        Self::NormalForce,
        Self::Temperature,
        Self::AngularVelocity,
        Self::Angle,
        Self::Torque,
    ];

    /// The word for messages.
    pub(crate) fn word(self) -> &'static str {
        match self {
            Self::Time => "time",
            Self::Velocity => "velocity",
            Self::Force => "force",
            Self::Position => "position",
            Self::NormalForce => "normal force",
            Self::Temperature => "temperature",
            Self::AngularVelocity => "angular velocity",
            Self::Angle => "angle",
            Self::Torque => "torque",
        }
    }

    /// The name of its column in a package, and the unit that this name states.
    pub(crate) fn column(self) -> (&'static str, &'static str) {
        match self {
            Self::Time => ("time_s", "s"),
            Self::Velocity => ("velocity_mm_s", "mm/s"),
            Self::Force => ("force_n", "N"),
            Self::Position => ("position_mm", "mm"),
            Self::NormalForce => ("normal_force_n", "N"),
            Self::Temperature => ("temperature_c", "degC"),
            Self::AngularVelocity => ("velocity_rad_s", "rad/s"),
            Self::Angle => ("position_rad", "rad"),
            Self::Torque => ("torque_n_m", "N m"),
        }
    }

    fn units(self) -> &'static [Unit] {
        match self {
            Self::Time => TIME,
            Self::Velocity => SPEED,
            Self::Position => LENGTH,
            Self::Force | Self::NormalForce => FORCE,
            Self::Temperature => TEMPERATURE,
            Self::AngularVelocity => ANGULAR_SPEED,
            Self::Angle => ANGLE,
            Self::Torque => TORQUE,
        }
    }

    /// The quantity that a column of this name holds; `None` for a column of the reader's own.
    ///
    /// A name is the quantity alone (`velocity`) or with a unit behind it (`velocity_mm_s`, `velocity_m_s`).
    pub(crate) fn of_column(name: &str) -> Option<Self> {
        let written = |unit: &str| unit.to_lowercase().replace(['/', ' ', '*', '.'], "_");
        let stem = |quantity: Self| match quantity {
            Self::AngularVelocity => "velocity",
            Self::Angle => "position",
            Self::NormalForce => "normal_force",
            linear => linear.word(),
        };
        Self::ALL.into_iter().find(|quantity| {
            let bare = stem(*quantity);
            let units = quantity.units().iter().flat_map(|unit| unit.spellings);
            // A bare `velocity` or `position` is linear; its unit may still say otherwise (`of_rotary_unit`).
            name == bare
                || units
                    .into_iter()
                    .any(|unit| name == format!("{bare}_{}", written(unit)))
        })
    }

    /// The rotary quantity where the unit of a bare column says so.
    pub(crate) fn with_unit(self, unit: &str) -> Self {
        match (self, unit) {
            (Self::Velocity, "rad/s") => Self::AngularVelocity,
            (Self::Position, "rad") => Self::Angle,
            _ => self,
        }
    }

    /// How a value in this unit becomes SI.
    pub(crate) fn conversion(self, unit: &str) -> Result<Conversion, Problem> {
        let trimmed = unit.trim();
        self.units()
            .iter()
            .find(|known| known.spellings.contains(&trimmed))
            .map(|known| Conversion {
                divisor: known.divisor,
                zero: known.zero,
            })
            .ok_or_else(|| Problem::UnknownUnit {
                unit: quoted(unit, 40),
                quantity: self.word(),
                known: self
                    .units()
                    .iter()
                    .map(|known| known.spellings[0])
                    .collect::<Vec<_>>()
                    .join(", "),
            })
    }
}

/// SI value = (written value - zero) / divisor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Conversion {
    divisor: f64,
    zero: f64,
}

impl Conversion {
    /// The value in SI units (temperature: degrees Celsius).
    pub(crate) fn to_si(self, written: f64) -> f64 {
        if self.zero == 0.0 {
            written / self.divisor
        } else {
            (written - self.zero) / self.divisor
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_columns_tell_the_quantity() {
        for quantity in Quantity::ALL {
            assert_eq!(Quantity::of_column(quantity.column().0), Some(quantity));
            assert!(quantity.conversion(quantity.column().1).is_ok());
        }
        assert_eq!(
            Quantity::of_column("velocity_m_s"),
            Some(Quantity::Velocity)
        );
        assert_eq!(Quantity::of_column("force_mn"), Some(Quantity::Force));
        assert_eq!(Quantity::of_column("torque_nm"), Some(Quantity::Torque));
        assert_eq!(Quantity::of_column("force_raw_n"), None);
        assert_eq!(Quantity::of_column("note"), None);
    }

    #[test]
    fn units_convert_once_and_unknown_ones_are_refused() {
        assert_eq!(
            Quantity::Velocity.conversion("mm/s").unwrap().to_si(60.0),
            0.06
        );
        assert_eq!(Quantity::Force.conversion("mN").unwrap().to_si(1500.0), 1.5);
        assert_eq!(
            Quantity::Temperature.conversion("K").unwrap().to_si(273.15),
            0.0
        );
        let refused = Quantity::Force.conversion("lbf").unwrap_err();
        assert_eq!(refused.to_string(), "`lbf` is not a unit of force (N, mN)");
    }
}

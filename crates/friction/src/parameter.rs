//! What a parameter is called, measured in, bounded by.

use std::borrow::Cow;

/// One parameter of a law or of an effect.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterSpec {
    /// Name as it stands in files and tables, such as `sigma0`.
    pub name: Cow<'static, str>,
    /// Unit, `1` where there is none.
    pub unit: Cow<'static, str>,
    /// One line for a reader.
    pub doc: Cow<'static, str>,
    /// Smallest value that makes physical sense.
    pub lower: f64,
    /// Largest value that makes physical sense.
    pub upper: f64,
    /// Typical size: the scale for steps and starts, never a result.
    pub typical: f64,
    /// Value at which the parameter does nothing; `None` where there is no such value.
    pub null: Option<f64>,
}

impl ParameterSpec {
    /// A parameter without a null value.
    pub const fn new(
        name: &'static str,
        unit: &'static str,
        doc: &'static str,
        lower: f64,
        upper: f64,
        typical: f64,
    ) -> Self {
        Self {
            name: Cow::Borrowed(name),
            unit: Cow::Borrowed(unit),
            doc: Cow::Borrowed(doc),
            lower,
            upper,
            typical,
            null: None,
        }
    }

    /// The same parameter with a value at which it does nothing.
    pub const fn with_null(mut self, null: f64) -> Self {
        self.null = Some(null);
        self
    }

    /// Whether a value is finite and inside the bounds.
    pub fn admits(&self, value: f64) -> bool {
        value.is_finite() && value >= self.lower && value <= self.upper
    }
}

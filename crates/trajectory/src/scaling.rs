//! Fixed physical scales: between the user's units and the solver's.
//!
//! ```text
//! x̃ = x / s        c̃ = c / r        f̃ = f / φ
//! ỹ = y r / φ      z̃ = z s / φ      (multipliers of rows and of bounds)
//! ```

use crate::{Block, LinearRow, ProgrammeError, Variable};

/// Multipliers in the user's units: at a solution `∇f + Σ yᵣ∇cᵣ + z = 0`.
///
/// **Sign**: positive where an upper limit holds the solution, negative where
/// a lower limit does, zero where neither is active.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Multipliers {
    /// One per row: block rows in order, then linear rows.
    pub rows: Vec<f64>,
    /// One per variable.
    pub bounds: Vec<f64>,
}

/// The scales of a programme.
#[derive(Clone, Debug)]
pub(crate) struct Scaling {
    pub variables: Vec<f64>,
    pub rows: Vec<f64>,
    pub cost: f64,
}

impl Scaling {
    pub(crate) fn new(
        variables: &[Variable],
        blocks: &[Block],
        linear: &[LinearRow],
        cost: f64,
    ) -> Result<Self, ProgrammeError> {
        for v in variables {
            check_scale("variable", &v.name, v.scale)?;
            check_limits("variable", &v.name, v.lower, v.upper)?;
        }
        let named = blocks
            .iter()
            .flat_map(|b| b.rows.iter().map(move |r| (b.name.as_str(), r)))
            .chain(linear.iter().map(|l| (l.name.as_str(), &l.row)));
        let mut rows = Vec::new();
        for (name, row) in named {
            check_scale("row", name, row.scale)?;
            check_limits("row", name, row.lower, row.upper)?;
            rows.push(row.scale);
        }
        check_scale("cost", "cost", cost)?;
        Ok(Self {
            variables: variables.iter().map(|v| v.scale).collect(),
            rows,
            cost,
        })
    }

    pub(crate) fn scale_point(&self, x: &[f64]) -> Vec<f64> {
        x.iter().zip(&self.variables).map(|(x, s)| x / s).collect()
    }

    pub(crate) fn unscale_point(&self, x: &[f64]) -> Vec<f64> {
        x.iter().zip(&self.variables).map(|(x, s)| x * s).collect()
    }

    pub(crate) fn scale_multipliers(&self, m: &Multipliers) -> (Vec<f64>, Vec<f64>) {
        let y = m
            .rows
            .iter()
            .zip(&self.rows)
            .map(|(y, r)| y * r / self.cost)
            .collect();
        let z = m
            .bounds
            .iter()
            .zip(&self.variables)
            .map(|(z, s)| z * s / self.cost)
            .collect();
        (y, z)
    }

    pub(crate) fn unscale_multipliers(&self, y: &[f64], z: &[f64]) -> Multipliers {
        Multipliers {
            rows: y
                .iter()
                .zip(&self.rows)
                .map(|(y, r)| y * self.cost / r)
                .collect(),
            bounds: z
                .iter()
                .zip(&self.variables)
                .map(|(z, s)| z * self.cost / s)
                .collect(),
        }
    }
}

fn check_scale(what: &'static str, name: &str, scale: f64) -> Result<(), ProgrammeError> {
    if scale > 0.0 && scale.is_finite() {
        Ok(())
    } else {
        Err(ProgrammeError::BadScale {
            what,
            name: name.to_owned(),
            scale,
        })
    }
}

fn check_limits(
    what: &'static str,
    name: &str,
    lower: f64,
    upper: f64,
) -> Result<(), ProgrammeError> {
    if lower <= upper && lower < f64::INFINITY && upper > f64::NEG_INFINITY {
        Ok(())
    } else {
        Err(ProgrammeError::BadLimits {
            what,
            name: name.to_owned(),
            lower,
            upper,
        })
    }
}

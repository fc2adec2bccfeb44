//! The first-order optimality error at a point.
//!
//! ```text
//! stationarity     ‖∇f + Jᵀy + z‖∞ / s
//! violation        max missed row
//! complementarity  max |multiplier| · distance to its limit / s
//! s = max(1, mean |multiplier| / 100)
//! ```

use crate::merit;
use crate::model::Structure;
use crate::pattern::max_abs;

/// The three errors of the first-order conditions (scaled).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OptimalityError {
    /// Gradient of the Lagrangian.
    pub stationarity: f64,
    /// Largest missed row.
    pub violation: f64,
    /// Largest product of a multiplier and the distance to its limit.
    pub complementarity: f64,
}

impl OptimalityError {
    /// The largest of the three.
    pub fn worst(&self) -> f64 {
        self.stationarity
            .max(self.violation)
            .max(self.complementarity)
    }
}

/// Evaluates the errors.
pub(crate) fn optimality_error(
    s: &Structure,
    x: &[f64],
    rows: &[f64],
    gradient: &[f64],
    jacobian: &[f64],
    y: &[f64],
    z: &[f64],
) -> OptimalityError {
    let mut pull: Vec<f64> = gradient.iter().zip(z).map(|(g, z)| g + z).collect();
    s.jacobian.add_transposed_product(jacobian, y, &mut pull);
    let size = multiplier_size(y, z);
    let row_gap = (0..s.rows()).map(|r| gap(rows[r], y[r], s.row_lower[r], s.row_upper[r]));
    let bound_gap = (0..s.variables()).map(|v| gap(x[v], z[v], s.lower[v], s.upper[v]));
    OptimalityError {
        stationarity: max_abs(&pull) / size,
        violation: merit::worst_violation(s, rows),
        complementarity: row_gap.chain(bound_gap).fold(0.0, f64::max) / size,
    }
}

/// s = max(1, mean |multiplier| / 100): what errors that grow with the multipliers are divided by.
pub(crate) fn multiplier_size(y: &[f64], z: &[f64]) -> f64 {
    let count = (y.len() + z.len()).max(1) as f64;
    let total: f64 = y.iter().chain(z).map(|v| v.abs()).sum();
    (total / count / 100.0).max(1.0)
}

/// |multiplier| · distance of `value` to the limit that its sign speaks of, at most |multiplier|. At a limit this is zero for
/// the right sign.
pub(crate) fn gap(value: f64, multiplier: f64, lower: f64, upper: f64) -> f64 {
    let distance = if multiplier > 0.0 {
        upper - value
    } else {
        value - lower
    };
    if multiplier == 0.0 || lower == upper {
        0.0
    } else {
        multiplier.abs() * distance.abs().min(1.0)
    }
}

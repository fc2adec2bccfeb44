//! The box l <= p <= u in which parameters may lie.

use thiserror::Error;

/// Which end of the box.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Side {
    /// At l.
    Lower,
    /// At u.
    Upper,
}

/// Why a box or a start was refused.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum BoundsError {
    /// l and u have different lengths.
    #[error("{lower} lower bounds but {upper} upper bounds")]
    Lengths {
        /// Number of lower bounds.
        lower: usize,
        /// Number of upper bounds.
        upper: usize,
    },
    /// l > u, or a bound that is not a number.
    #[error("parameter {index}: lower bound {lower} is not below upper bound {upper}")]
    Empty {
        /// Index of the parameter.
        index: usize,
        /// Its lower bound.
        lower: f64,
        /// Its upper bound.
        upper: f64,
    },
}

/// The box l <= p <= u; infinite ends are free ends, l = u holds a parameter fixed.
#[derive(Clone, Debug, PartialEq)]
pub struct Bounds {
    lower: Vec<f64>,
    upper: Vec<f64>,
}

impl Bounds {
    /// A box from its ends.
    ///
    /// # Errors
    /// When lengths differ or an interval is empty.
    pub fn new(lower: Vec<f64>, upper: Vec<f64>) -> Result<Self, BoundsError> {
        if lower.len() != upper.len() {
            return Err(BoundsError::Lengths {
                lower: lower.len(),
                upper: upper.len(),
            });
        }
        for (index, (&l, &u)) in lower.iter().zip(&upper).enumerate() {
            if l.is_nan() || u.is_nan() || l > u {
                return Err(BoundsError::Empty {
                    index,
                    lower: l,
                    upper: u,
                });
            }
        }
        Ok(Self { lower, upper })
    }

    /// No bounds on n parameters.
    pub fn free(n: usize) -> Self {
        Self {
            lower: vec![f64::NEG_INFINITY; n],
            upper: vec![f64::INFINITY; n],
        }
    }

    /// Number of parameters.
    pub fn len(&self) -> usize {
        self.lower.len()
    }

    /// True for a box of no parameters.
    pub fn is_empty(&self) -> bool {
        self.lower.is_empty()
    }

    /// Lower ends.
    pub fn lower(&self) -> &[f64] {
        &self.lower
    }

    /// Upper ends.
    pub fn upper(&self) -> &[f64] {
        &self.upper
    }

    /// The same box with parameter `index` held at `value`.
    #[must_use]
    pub fn with_fixed(&self, index: usize, value: f64) -> Self {
        let mut bounds = self.clone();
        bounds.lower[index] = value;
        bounds.upper[index] = value;
        bounds
    }

    /// True where l = u.
    pub fn is_fixed(&self, index: usize) -> bool {
        self.lower[index] >= self.upper[index]
    }

    /// Indices of the parameters that may move.
    pub fn movable(&self) -> Vec<usize> {
        (0..self.len()).filter(|&i| !self.is_fixed(i)).collect()
    }

    /// The nearest point of the box.
    #[must_use]
    pub fn clamp(&self, parameters: &[f64]) -> Vec<f64> {
        parameters
            .iter()
            .enumerate()
            .map(|(i, p)| p.max(self.lower[i]).min(self.upper[i]))
            .collect()
    }

    /// The end on which a movable parameter lies exactly, if any.
    pub fn side(&self, index: usize, value: f64) -> Option<Side> {
        if self.is_fixed(index) {
            None
        } else if value <= self.lower[index] {
            Some(Side::Lower)
        } else if value >= self.upper[index] {
            Some(Side::Upper)
        } else {
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_empty_interval_is_refused_with_its_place() {
        let refused = Bounds::new(vec![0.0, 2.0], vec![1.0, 1.0]);
        assert_eq!(
            refused,
            Err(BoundsError::Empty {
                index: 1,
                lower: 2.0,
                upper: 1.0
            })
        );
        assert!(Bounds::new(vec![f64::NAN], vec![1.0]).is_err());
    }

    #[test]
    fn fixed_parameters_do_not_count_as_lying_on_a_bound() {
        let bounds = Bounds::new(vec![0.0, 3.0], vec![1.0, 3.0]).unwrap();
        assert_eq!(bounds.movable(), vec![0]);
        assert_eq!(bounds.side(0, 0.0), Some(Side::Lower));
        assert_eq!(bounds.side(1, 3.0), None);
    }
}

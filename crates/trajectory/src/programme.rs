//! A nonlinear programme in structured form.
//!
//! ```text
//! minimise    Σ_b f_b(x_b)
//! subject to  l_r ≤ c_b,r(x_b) ≤ u_r      rows of every block b
//!             l_k ≤ a_kᵀ x     ≤ u_k      linear rows
//!             x̲   ≤ x          ≤ x̄        bounds
//! ```
//!
//! `x_b` are the few variables that block `b` names. A block is a collocation
//! point, a defect or a linkage; the solver knows only its functions and its
//! variables. Because every term belongs to a block, Jacobian and Hessian have
//! a pattern that is known before the first evaluation and never changes.

use crate::Scalar;
use thiserror::Error;

/// One decision variable: bounds and the size it is expected to have.
#[derive(Clone, Debug, PartialEq)]
pub struct Variable {
    /// Name used in messages.
    pub name: String,
    /// Lower bound, in the variable's own unit; `-∞` if there is none.
    pub lower: f64,
    /// Upper bound, in the variable's own unit; `+∞` if there is none.
    pub upper: f64,
    /// Fixed physical scale (> 0), in the variable's own unit. The solver works
    /// on `x / scale`; it is never derived from data.
    pub scale: f64,
}

impl Variable {
    /// A variable with bounds `lower..upper` and physical scale `scale`.
    pub fn new(name: impl Into<String>, lower: f64, upper: f64, scale: f64) -> Self {
        Self {
            name: name.into(),
            lower,
            upper,
            scale,
        }
    }

    /// A variable without bounds.
    pub fn free(name: impl Into<String>, scale: f64) -> Self {
        Self::new(name, f64::NEG_INFINITY, f64::INFINITY, scale)
    }
}

/// One constraint row `lower ≤ c(x) ≤ upper`; an equality has `lower == upper`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Lower limit in the row's own unit.
    pub lower: f64,
    /// Upper limit in the row's own unit.
    pub upper: f64,
    /// Fixed physical scale (> 0) in the row's own unit.
    pub scale: f64,
}

impl Row {
    /// `c(x) = 0`.
    pub fn equal(scale: f64) -> Self {
        Self {
            lower: 0.0,
            upper: 0.0,
            scale,
        }
    }

    /// `c(x) ≥ 0`.
    pub fn at_least(scale: f64) -> Self {
        Self {
            lower: 0.0,
            upper: f64::INFINITY,
            scale,
        }
    }

    /// `c(x) ≤ 0`.
    pub fn at_most(scale: f64) -> Self {
        Self {
            lower: f64::NEG_INFINITY,
            upper: 0.0,
            scale,
        }
    }

    /// `lower ≤ c(x) ≤ upper`.
    pub fn between(lower: f64, upper: f64, scale: f64) -> Self {
        Self {
            lower,
            upper,
            scale,
        }
    }

    /// Is this row an equality?
    pub fn is_equality(&self) -> bool {
        self.lower == self.upper
    }
}

/// A block: a few variables, a share of the cost and some constraint rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    /// Name used in messages.
    pub name: String,
    /// Indices of the variables, in the order in which `evaluate` gets them.
    pub variables: Vec<usize>,
    /// The rows, in the order in which `evaluate` fills them.
    pub rows: Vec<Row>,
    /// Blocks with the same group are convexified as one sum. Blocks without
    /// a group are convexified one by one, which is more conservative.
    pub group: Option<usize>,
}

impl Block {
    /// A block over `variables` with `rows`, convexified on its own.
    pub fn new(name: impl Into<String>, variables: Vec<usize>, rows: Vec<Row>) -> Self {
        Self {
            name: name.into(),
            variables,
            rows,
            group: None,
        }
    }

    /// The same block as a member of a convexification group.
    pub fn in_group(mut self, group: usize) -> Self {
        self.group = Some(group);
        self
    }
}

/// A linear row `lower ≤ Σ coefficient·x ≤ upper`; exact from the first step on.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearRow {
    /// Name used in messages.
    pub name: String,
    /// Pairs of variable index and coefficient.
    pub terms: Vec<(usize, f64)>,
    /// Limits and scale.
    pub row: Row,
}

/// A nonlinear programme made of blocks.
///
/// Rows are numbered in the order of the blocks, the linear rows last.
pub trait Programme: Sync {
    /// The decision variables.
    fn variables(&self) -> Vec<Variable>;

    /// The blocks.
    fn blocks(&self) -> Vec<Block>;

    /// Linear rows over any variables.
    fn linear(&self) -> Vec<LinearRow> {
        Vec::new()
    }

    /// The size that the cost is expected to have (> 0).
    fn cost_scale(&self) -> f64 {
        1.0
    }

    /// Adds the block's share to `cost` (which comes in as zero) and fills
    /// `rows` (which come in as zeros).
    ///
    /// **Units**: `x` in the variables' own units, rows in the rows' own units.
    /// **Shape**: `x` as `blocks()[block].variables`, `rows` as its `rows`.
    fn evaluate<D: Scalar>(&self, block: usize, x: &[D], cost: &mut D, rows: &mut [D]);
}

/// A programme or a start that cannot be worked with.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum ProgrammeError {
    /// A scale is zero, negative or not finite.
    #[error("{what} `{name}` has scale {scale}, which must be positive and finite")]
    BadScale {
        /// Variable, row or cost.
        what: &'static str,
        /// Its name.
        name: String,
        /// The scale found.
        scale: f64,
    },
    /// Limits that exclude each other or are not numbers.
    #[error("{what} `{name}` has the limits {lower} and {upper}, which exclude each other")]
    BadLimits {
        /// Variable or row.
        what: &'static str,
        /// Its name.
        name: String,
        /// Lower limit.
        lower: f64,
        /// Upper limit.
        upper: f64,
    },
    /// A block or linear row names a variable that does not exist.
    #[error("`{name}` names variable {index}, but there are only {count}")]
    NoSuchVariable {
        /// The block or row.
        name: String,
        /// The index found.
        index: usize,
        /// The number of variables.
        count: usize,
    },
    /// A block names a variable twice.
    #[error("`{name}` names variable {index} twice")]
    DoubledVariable {
        /// The block or row.
        name: String,
        /// The index found.
        index: usize,
    },
    /// A vector of the wrong length.
    #[error("{what} has {got} entries where {need} are needed")]
    WrongLength {
        /// What it is.
        what: &'static str,
        /// Its length.
        got: usize,
        /// The length needed.
        need: usize,
    },
}

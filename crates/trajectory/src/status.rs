//! How a solve ended, as a value with advice.

use std::fmt;

/// How a solve ended. Only `Solved` is a solution.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Status {
    /// First- and second-order sufficient conditions hold: a strict local minimum.
    Solved,
    /// First-order conditions hold, but curvature along the active
    /// constraints is not positive: a saddle, or a minimum that is not strict.
    Uncertified,
    /// The point minimises the violation locally, but the violation is not zero.
    LocallyInfeasible,
    /// No step makes progress although the conditions do not hold.
    Stalled,
    /// The iteration limit was reached.
    IterationLimit,
    /// Clarabel ended without a solution, elastic subproblem included.
    SubproblemFailed,
    /// Cost, row or derivative at the start is not finite.
    NonFiniteStart,
    /// Derivatives became infinite or not a number on the way.
    NonFinite,
    /// The cost falls without limit.
    Unbounded,
}

impl Status {
    /// Does a point with this status count as solved?
    pub fn is_solved(self) -> bool {
        self == Self::Solved
    }
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Solved => "solved: a certified strict local minimum",
            Self::Uncertified => {
                "first-order conditions hold, but the point is not a strict minimum: look for variables that cost \
                 nothing, or start off the saddle"
            }
            Self::LocallyInfeasible => {
                "the constraints cannot all be met near this point: start elsewhere, or relax the rows that the \
                 result lists as missed"
            }
            Self::Stalled => {
                "no step makes progress: check the functions for kinks, the scales for their size, or start elsewhere"
            }
            Self::IterationLimit => "the iteration limit was reached: raise it, or start closer",
            Self::SubproblemFailed => "the quadratic subproblem could not be solved: check the scales of rows and variables",
            Self::NonFiniteStart => "a function or derivative is not finite at the start: start inside its domain",
            Self::NonFinite => "a function or derivative became infinite: bound the variables inside its domain",
            Self::Unbounded => "the cost falls without limit: a bound or a constraint is missing",
        })
    }
}

//! Running the solver and what comes of it.

use crate::bounds::{Bounds, BoundsError, Side};
use crate::levenberg_marquardt::{LevenbergMarquardt, LmState, Options};
use crate::residuals::Residuals;
use crate::triangular;
use argmin::core::{Error, Executor, Jacobian, Operator, State};
use nalgebra::{DMatrix, DVector};
use std::fmt;

/// How a minimisation ended. Anything but the first three is not a solution and must never be counted as one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Status {
    /// Nothing measurable is left to gain inside the bounds.
    Converged,
    /// The remaining step is below the resolution asked for.
    StepTooSmall,
    /// The residuals are zero.
    ExactFit,
    /// No step lowers the cost although the linear model promises one: derivatives are wrong or rounding rules.
    Stalled,
    /// The limit of iterations came first.
    IterationLimit,
    /// Given up: it would not have come below the cost that it must ([`Options::below`]).
    Hopeless,
    /// The residuals at the start are not finite.
    NonFiniteStart,
    /// The Jacobian is not finite at a point where the residuals are.
    NonFiniteJacobian,
}

impl Status {
    /// True where the result is a local minimum.
    pub fn converged(self) -> bool {
        matches!(
            self,
            Status::Converged | Status::StepTooSmall | Status::ExactFit
        )
    }

    /// Name as it stands in documents.
    pub fn id(self) -> &'static str {
        match self {
            Status::Converged => "converged",
            Status::StepTooSmall => "step-too-small",
            Status::ExactFit => "exact-fit",
            Status::Stalled => "stalled",
            Status::IterationLimit => "iteration-limit",
            Status::Hopeless => "hopeless",
            Status::NonFiniteStart => "non-finite-start",
            Status::NonFiniteJacobian => "non-finite-jacobian",
        }
    }
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Status::Converged => "converged",
            Status::StepTooSmall => "converged: the remaining step is below resolution",
            Status::ExactFit => "converged: the residuals are zero",
            Status::Stalled => "stalled: no step lowers the cost; check the derivatives",
            Status::IterationLimit => "not converged: the limit of iterations came first",
            Status::Hopeless => "given up: it would not have come below the cost that it must",
            Status::NonFiniteStart => "not started: the residuals at the start are not finite",
            Status::NonFiniteJacobian => "stopped: the Jacobian is not finite",
        })
    }
}

/// Result of a minimisation.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The point reached.
    pub parameters: Vec<f64>,
    /// r there.
    pub residuals: DVector<f64>,
    /// 1/2 |r|^2 there.
    pub cost: f64,
    /// How it ended.
    pub status: Status,
    /// Accepted steps.
    pub iterations: u64,
    /// Evaluations of r alone.
    pub evaluations: u64,
    /// Evaluations of r with J.
    pub jacobians: u64,
    /// Parameters that lie exactly on a bound (fixed ones do not count).
    pub at_bound: Vec<(usize, Side)>,
    /// (J^T J)^-1 over all parameters, zero in the rows of parameters that are fixed or on a bound; `None` where the data
    /// leave a direction undetermined or the residuals were never finite. For whitened residuals it is the covariance.
    pub covariance: Option<DMatrix<f64>>,
}

impl Fit {
    /// Standard deviation of parameter `index` by the covariance, `None` where there is none.
    pub fn standard_deviation(&self, index: usize) -> Option<f64> {
        self.covariance
            .as_ref()
            .map(|c| c[(index, index)].max(0.0).sqrt())
    }
}

/// The problem as argmin sees it: movable parameters only.
struct Movable<'a, R: ?Sized> {
    problem: &'a R,
    template: Vec<f64>,
    columns: Vec<usize>,
}

impl<R: Residuals + ?Sized> Movable<'_, R> {
    fn full(&self, movable: &[f64]) -> Vec<f64> {
        let mut parameters = self.template.clone();
        for (&column, value) in self.columns.iter().zip(movable) {
            parameters[column] = *value;
        }
        parameters
    }
}

impl<R: Residuals + ?Sized> Operator for Movable<'_, R> {
    type Param = Vec<f64>;
    type Output = DVector<f64>;

    fn apply(&self, movable: &Vec<f64>) -> Result<DVector<f64>, Error> {
        Ok(self.problem.residuals(&self.full(movable)))
    }
}

impl<R: Residuals + ?Sized> Jacobian for Movable<'_, R> {
    type Param = Vec<f64>;
    type Jacobian = (DVector<f64>, DMatrix<f64>);

    fn jacobian(&self, movable: &Vec<f64>) -> Result<Self::Jacobian, Error> {
        Ok(self
            .problem
            .jacobian_columns(&self.full(movable), &self.columns))
    }
}

/// Minimises 1/2 |r(p)|^2 over the box from `start` (moved into the box first).
///
/// # Errors
/// When `start` and `bounds` have different lengths. How the numerics ended is [`Fit::status`], never an error.
pub fn minimise<R: Residuals + ?Sized>(
    problem: &R,
    start: &[f64],
    bounds: &Bounds,
    options: &Options,
) -> Result<Fit, BoundsError> {
    if start.len() != bounds.len() {
        return Err(BoundsError::Lengths {
            lower: bounds.len(),
            upper: start.len(),
        });
    }
    let template = bounds.clamp(start);
    let columns = bounds.movable();
    let select = |values: &[f64]| columns.iter().map(|&c| values[c]).collect::<Vec<f64>>();
    let inner = Bounds::new(select(bounds.lower()), select(bounds.upper()))?;
    let first = select(&template);
    let movable = Movable {
        problem,
        template,
        columns,
    };
    let solver = LevenbergMarquardt::new(inner, *options);
    let run = Executor::new(movable, solver)
        .configure(|state: LmState| state.param(first.clone()))
        .run();
    // The adaptor above never fails, so the executor has nothing to pass on.
    let mut run = match run {
        Ok(run) => run,
        Err(error) => unreachable!("the residuals' adaptor cannot fail: {error}"),
    };
    let status = run.solver.status().unwrap_or(Status::IterationLimit);
    let count = |key: &str| run.problem.counts.get(key).copied().unwrap_or(0);
    let (evaluations, jacobians) = (count("operator_count"), count("jacobian_count"));
    let iterations = run.state.get_iter();
    let point = run.state.take_param().unwrap_or(first);
    let residuals = run.state.take_residuals().unwrap_or_default();
    let Some(movable) = run.problem.problem.take() else {
        unreachable!("the executor hands the problem back")
    };
    let parameters = movable.full(&point);
    let at_bound: Vec<(usize, Side)> = parameters
        .iter()
        .enumerate()
        .filter_map(|(j, &p)| bounds.side(j, p).map(|side| (j, side)))
        .collect();
    let covariance = run
        .solver
        .triangular_factor()
        .and_then(|r| full_covariance(r, &movable.columns, &at_bound, bounds.len()));
    Ok(Fit {
        cost: 0.5 * residuals.norm_squared(),
        parameters,
        residuals,
        status,
        iterations,
        evaluations,
        jacobians,
        at_bound,
        covariance,
    })
}

/// Covariance over all parameters from R of the movable ones, leaving out those on a bound.
fn full_covariance(
    r: &DMatrix<f64>,
    columns: &[usize],
    at_bound: &[(usize, Side)],
    n: usize,
) -> Option<DMatrix<f64>> {
    let inside: Vec<usize> = (0..columns.len())
        .filter(|&k| at_bound.iter().all(|(j, _)| *j != columns[k]))
        .collect();
    let small = triangular::covariance(&r.select_columns(&inside))?;
    let mut full = DMatrix::zeros(n, n);
    for (a, &ka) in inside.iter().enumerate() {
        for (b, &kb) in inside.iter().enumerate() {
            full[(columns[ka], columns[kb])] = small[(a, b)];
        }
    }
    Some(full)
}

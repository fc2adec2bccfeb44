//! Bounded Levenberg-Marquardt as an [`argmin`] solver.
//!
//! At p with residuals r and Jacobian J = Q R the step minimises the damped linear model inside the box,
//!
//! ```text
//! min over s of 1/2 |R s + Q^T r|^2 + 1/2 lambda |D s|^2,   l <= p + s <= u,
//! ```
//!
//! D_j being the largest norm of column j met so far (Moré 1978, "The Levenberg-Marquardt algorithm"), which makes the
//! method indifferent to units. lambda follows the ratio of actual to predicted reduction (Nielsen 1999,
//! "Damping parameter in Marquardt's method"). Convergence is judged by what the *undamped* bounded step could still
//! gain (the relative offset of Bates and Watts 1981): a long valley walked in short damped steps is not an end.

use crate::bounded_step::bounded_step;
use crate::bounds::Bounds;
use crate::minimise::Status;
use crate::triangular::{Reduced, reduce};
use argmin::core::{
    Error, IterState, Jacobian, KV, Operator, Problem, Solver, State, TerminationReason,
    TerminationStatus,
};
use nalgebra::{DMatrix, DVector};

/// State of an optimisation as argmin carries it: parameters, no Jacobian (kept reduced in the solver), residuals.
pub(crate) type LmState = IterState<Vec<f64>, (), (), (), DVector<f64>, f64>;

/// When to stop and how to begin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Converged when the undamped bounded step would lower the cost by less than this fraction of it.
    pub reduction_tolerance: f64,
    /// Converged when the undamped bounded step, in the scaling D, is shorter than this fraction of |D p|.
    pub step_tolerance: f64,
    /// Largest number of accepted steps.
    pub iteration_limit: u64,
    /// First lambda, relative to columns of norm 1. Small for a start that is already near.
    pub initial_damping: f64,
    /// Where the fit is of use only below a cost: given up once it plainly will not come there.
    pub below: Option<f64>,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            reduction_tolerance: 1e-14,
            step_tolerance: 1e-12,
            iteration_limit: 200,
            initial_damping: 1e-3,
            below: None,
        }
    }
}

impl Options {
    /// For a start that is a neighbour's solution: nearly undamped.
    pub fn warm() -> Self {
        Self {
            reduction_tolerance: 1e-10,
            initial_damping: 1e-7,
            ..Self::default()
        }
    }
}

/// Damping at which the model counts as undamped: it only settles directions that the data leave open.
const UNDAMPED: f64 = 1e-14;
/// Damping beyond which no representable step is left.
const EXHAUSTED: f64 = 1e16;

/// Accepted steps after which a fit that must come below a cost is judged: the first few of one from afar are the long ones.
const JUDGED_AFTER: u64 = 6;
/// Times that cost beyond which it has not come near after them.
const FAR: f64 = 2.5;
/// Accepted steps after which what the linear model promises counts, and times more than it says that a fit may still save.
const PROMISED_AFTER: u64 = 2;
const BEYOND_LINEAR: f64 = 3.0;

/// The solver; [`crate::minimise`] runs it. It can be handed to any [`argmin::core::Executor`] whose problem offers
/// residuals ([`Operator`]) and, as [`Jacobian`], residuals together with their Jacobian.
#[derive(Clone, Debug)]
pub struct LevenbergMarquardt {
    bounds: Bounds,
    options: Options,
    lambda: f64,
    growth: f64,
    scaling: DVector<f64>,
    reduced: Option<Reduced>,
    /// What the undamped step would save by the linear model.
    promised: f64,
    status: Option<Status>,
}

impl LevenbergMarquardt {
    /// A solver for a box.
    pub fn new(bounds: Bounds, options: Options) -> Self {
        let n = bounds.len();
        Self {
            bounds,
            options,
            lambda: options.initial_damping,
            growth: 2.0,
            scaling: DVector::zeros(n),
            reduced: None,
            promised: f64::INFINITY,
            status: None,
        }
    }

    /// How it ended; `None` while it runs.
    pub fn status(&self) -> Option<Status> {
        self.status
    }

    /// R of J = Q R at the last accepted point.
    pub(crate) fn triangular_factor(&self) -> Option<&DMatrix<f64>> {
        self.reduced.as_ref().map(|reduced| &reduced.r)
    }

    /// Reduces J, updates D, and asks whether anything is left to gain.
    fn linearise<O>(
        &mut self,
        problem: &mut Problem<O>,
        parameters: &[f64],
        cost: f64,
    ) -> Result<(), Error>
    where
        O: Operator<Param = Vec<f64>, Output = DVector<f64>>
            + Jacobian<Param = Vec<f64>, Jacobian = (DVector<f64>, DMatrix<f64>)>,
    {
        let (residuals, jacobian) = problem.jacobian(&parameters.to_vec())?;
        if jacobian.iter().any(|x| !x.is_finite()) {
            self.status = Some(Status::NonFiniteJacobian);
            return Ok(());
        }
        for (scale, column) in self.scaling.iter_mut().zip(jacobian.column_iter()) {
            *scale = scale.max(column.norm());
        }
        let reduced = reduce(jacobian, &residuals);
        let (lower, upper) = self.room(parameters);
        let step = bounded_step(&reduced, &self.damping(UNDAMPED), &lower, &upper);
        let gain = predicted_reduction(&reduced, &step);
        let scaled_step = step.component_mul(&self.scaling).norm();
        let scaled_point = DVector::from_column_slice(parameters)
            .component_mul(&self.scaling)
            .norm();
        if cost <= f64::MIN_POSITIVE {
            self.status = Some(Status::ExactFit);
        } else if gain <= self.options.reduction_tolerance * cost {
            self.status = Some(Status::Converged);
        } else if scaled_step <= self.options.step_tolerance * scaled_point {
            self.status = Some(Status::StepTooSmall);
        }
        self.promised = gain;
        self.reduced = Some(reduced);
        Ok(())
    }

    /// Whether a fit will not come below the cost that it must.
    fn is_hopeless(&self, steps: u64, cost: f64) -> bool {
        let beyond = |below: f64| {
            let far = steps >= JUDGED_AFTER && cost > FAR * below;
            far || steps >= PROMISED_AFTER && cost - BEYOND_LINEAR * self.promised > below
        };
        self.options.below.is_some_and(beyond)
    }

    /// sqrt(lambda) D, with 1 for D_j = 0 (a parameter that nothing depends on stays put).
    fn damping(&self, lambda: f64) -> DVector<f64> {
        self.scaling
            .map(|d| lambda.sqrt() * if d > 0.0 { d } else { 1.0 })
    }

    /// Room for a step: l - p and u - p.
    fn room(&self, parameters: &[f64]) -> (DVector<f64>, DVector<f64>) {
        let p = DVector::from_column_slice(parameters);
        (
            DVector::from_column_slice(self.bounds.lower()) - &p,
            DVector::from_column_slice(self.bounds.upper()) - &p,
        )
    }

    /// p + s, put exactly on the bound where s ends on it.
    fn moved(&self, parameters: &[f64], step: &DVector<f64>) -> Vec<f64> {
        let (lower, upper) = self.room(parameters);
        (0..parameters.len())
            .map(|j| {
                if step[j] <= lower[j] {
                    self.bounds.lower()[j]
                } else if step[j] >= upper[j] {
                    self.bounds.upper()[j]
                } else {
                    parameters[j] + step[j]
                }
            })
            .collect()
    }

    /// Nielsen's rule: less damping the better the model predicted, growing factors after failures.
    fn relax(&mut self, ratio: f64) {
        let factor = if ratio > 0.75 {
            0.1
        } else {
            (1.0 - (2.0 * ratio - 1.0).powi(3)).max(1.0 / 3.0)
        };
        self.lambda = (self.lambda * factor).max(UNDAMPED);
        self.growth = 2.0;
    }

    fn tighten(&mut self) {
        self.lambda *= self.growth;
        self.growth *= 2.0;
    }
}

/// 1/2 |c|^2 - 1/2 |R s + c|^2 = -s^T R^T c - 1/2 |R s|^2.
fn predicted_reduction(reduced: &Reduced, step: &DVector<f64>) -> f64 {
    let moved = &reduced.r * step;
    -(moved.dot(&reduced.qtb)) - 0.5 * moved.norm_squared()
}

impl<O> Solver<O, LmState> for LevenbergMarquardt
where
    O: Operator<Param = Vec<f64>, Output = DVector<f64>>
        + Jacobian<Param = Vec<f64>, Jacobian = (DVector<f64>, DMatrix<f64>)>,
{
    fn name(&self) -> &str {
        "bounded Levenberg-Marquardt"
    }

    fn init(
        &mut self,
        problem: &mut Problem<O>,
        mut state: LmState,
    ) -> Result<(LmState, Option<KV>), Error> {
        let start = self.bounds.clamp(&state.take_param().unwrap_or_default());
        let residuals = problem.apply(&start)?;
        let cost = 0.5 * residuals.norm_squared();
        if cost.is_finite() {
            self.linearise(problem, &start, cost)?;
        } else {
            self.status = Some(Status::NonFiniteStart);
        }
        Ok((state.param(start).residuals(residuals).cost(cost), None))
    }

    /// One accepted step: lambda grows until the cost falls.
    fn next_iter(
        &mut self,
        problem: &mut Problem<O>,
        mut state: LmState,
    ) -> Result<(LmState, Option<KV>), Error> {
        let parameters = state.take_param().unwrap_or_default();
        let cost = state.get_cost();
        let Some(reduced) = self.reduced.clone() else {
            self.status = Some(Status::NonFiniteJacobian);
            return Ok((state.param(parameters), None));
        };
        let (lower, upper) = self.room(&parameters);
        loop {
            let step = bounded_step(&reduced, &self.damping(self.lambda), &lower, &upper);
            let predicted = predicted_reduction(&reduced, &step);
            let trial = self.moved(&parameters, &step);
            let residuals = problem.apply(&trial)?;
            let trial_cost = 0.5 * residuals.norm_squared();
            let ratio = (cost - trial_cost) / predicted;
            if trial_cost < cost && ratio > 1e-4 {
                self.relax(ratio);
                self.linearise(problem, &trial, trial_cost)?;
                return Ok((
                    state.param(trial).residuals(residuals).cost(trial_cost),
                    None,
                ));
            }
            self.tighten();
            if self.lambda > EXHAUSTED || trial == parameters {
                self.status = Some(Status::Stalled);
                return Ok((state.param(parameters).cost(cost), None));
            }
        }
    }

    fn terminate(&mut self, state: &LmState) -> TerminationStatus {
        let steps = state.get_iter();
        if self.status.is_none() && steps >= self.options.iteration_limit {
            self.status = Some(Status::IterationLimit);
        }
        if self.status.is_none() && self.is_hopeless(steps, state.get_cost()) {
            self.status = Some(Status::Hopeless);
        }
        match self.status {
            None => TerminationStatus::NotTerminated,
            Some(status) if status.converged() => {
                TerminationStatus::Terminated(TerminationReason::SolverConverged)
            }
            Some(status) => {
                TerminationStatus::Terminated(TerminationReason::SolverExit(status.to_string()))
            }
        }
    }
}

//! The sequential quadratic programme: the loop that ties the parts together.
//!
//! Each iteration evaluates derivatives, checks the first-order errors, asks
//! `proposal` for a step, sets the penalty, searches along the step with the
//! merit function and moves point and multipliers together. Near the solution
//! the polish takes over; the certificate has the last word on the status.

use crate::certificate::{Certificate, certify};
use crate::estimate::least_squares_multipliers;
use crate::iterate::{Iterate, clamp};
use crate::merit::{self, Merit};
use crate::model::{Evaluator, Model};
use crate::newton::ActiveSet;
use crate::pattern::max_abs;
use crate::penalty::Penalty;
use crate::polish::polish;
use crate::probe::probe;
use crate::proposal::{Proposal, Proposer, model_change};
use crate::soc::Correction;
use crate::solution::{Counters, Iteration, Solution, Start, StepKind};
use crate::{Options, Programme, ProgrammeError, Status};
use std::collections::VecDeque;

/// Shortest step that the line search tries.
const SHORTEST: f64 = 1e-8;
/// Newton's step and a first subproblem step shorter than this give way to another source.
const IMPATIENT: f64 = 0.05;
/// Most second-order corrections of one trial point.
const CORRECTIONS: usize = 5;
/// A correction is repeated while it leaves at most this share of the violation.
const CONTRACTION: f64 = 0.7;
/// A cost below this is taken for unbounded (scaled).
const BOTTOMLESS: f64 = -1e15;

/// Solves a programme from a start.
///
/// **Errors**: a programme that contradicts itself or a start of the wrong
/// length. How the numerics ended is a [`Status`] in the solution, never an error.
pub fn solve<P: Programme>(
    programme: &P,
    start: &Start,
    options: &Options,
) -> Result<Solution, ProgrammeError> {
    let model = Model::new(programme)?;
    let (n, m) = (model.structure().variables(), model.structure().rows());
    check_length("the start", start.x.len(), n)?;
    let (y, z) = match &start.multipliers {
        Some(multipliers) => {
            check_length("the start's row multipliers", multipliers.rows.len(), m)?;
            check_length("the start's bound multipliers", multipliers.bounds.len(), n)?;
            model.scaling.scale_multipliers(multipliers)
        }
        None => (vec![0.0; m], vec![0.0; n]),
    };
    let x = model.scaling.scale_point(&start.x);
    let mut run = Run::new(&model, options, x, y, z, start.multipliers.is_some());
    let status = run.iterate();
    let certificate = run.certificate(status);
    let status = run.settle(status, &certificate);
    let multipliers = model.scaling.unscale_multipliers(&run.at.y, &run.at.z);
    Ok(Solution {
        status,
        x: model.scaling.unscale_point(&run.at.x),
        cost: run.at.cost * model.scaling.cost,
        multipliers,
        certificate,
        counters: run.counters,
        history: run.history,
    })
}

fn check_length(what: &'static str, got: usize, need: usize) -> Result<(), ProgrammeError> {
    if got == need {
        Ok(())
    } else {
        Err(ProgrammeError::WrongLength { what, got, need })
    }
}

struct Run<'e> {
    e: &'e dyn Evaluator,
    options: &'e Options,
    at: Iterate,
    proposer: Proposer<'e>,
    penalty: Penalty,
    counters: Counters,
    history: Vec<Iteration>,
    /// Cost and violation of the last points, for the merit function's reference.
    memory: VecDeque<(f64, f64)>,
    /// Errors at which the polish is tried next.
    target: f64,
}

impl<'e> Run<'e> {
    fn new(
        e: &'e dyn Evaluator,
        options: &'e Options,
        x: Vec<f64>,
        y: Vec<f64>,
        z: Vec<f64>,
        warm: bool,
    ) -> Self {
        let mut counters = Counters::default();
        let mut proposer = Proposer::new(e, options);
        if warm {
            proposer.active = Some(active_from_multipliers(e, &y, &z));
        }
        let mut at = Iterate::new(e, x, y, z, &mut counters);
        probe(e, &at, &mut proposer.newton);
        if !warm && at.is_finite() {
            at.y = least_squares_multipliers(e.structure(), &mut proposer.newton, &at);
        }
        Self {
            e,
            options,
            at,
            proposer,
            penalty: Penalty(1.0),
            counters,
            history: Vec::new(),
            memory: VecDeque::new(),
            target: options.optimality,
        }
    }

    /// The loop; the status before the certificate is known.
    fn iterate(&mut self) -> Status {
        if !self.at.is_finite() {
            return Status::NonFiniteStart;
        }
        loop {
            let error = self.at.error(self.e);
            let near = error.worst() <= self.target && error.violation <= self.options.feasibility;
            if near && let Some(status) = self.finish() {
                return status;
            }
            if self.at.cost < BOTTOMLESS {
                return Status::Unbounded;
            }
            if self.is_at_its_limit() {
                return Status::IterationLimit;
            }
            if !self.proposer.refresh_hessian(&self.at, &mut self.counters) {
                return Status::NonFinite;
            }
            if let Err(status) = self.advance(error.worst()) {
                return status;
            }
            if !self.at.is_finite() {
                return Status::NonFinite;
            }
        }
    }

    fn is_at_its_limit(&self) -> bool {
        self.counters.iterations >= self.options.max_iterations
            || self.counters.subproblems >= self.options.max_subproblems
    }

    /// Polishes; a status if the point is good enough to stop.
    fn finish(&mut self) -> Option<Status> {
        let certified = self.options.certified;
        if let Some(better) = polish(self.e, &mut self.proposer, &self.at, &mut self.counters) {
            self.at = better;
        }
        if self.at.error(self.e).worst() <= certified {
            return Some(Status::Solved);
        }
        self.target = (self.target * 0.1).max(certified);
        None
    }

    /// One iteration: a step from the cheapest source that the merit function accepts.
    fn advance(&mut self, error: f64) -> Result<(), Status> {
        let newton = self.options.newton_steps;
        if newton
            && let Some(proposal) = self.proposer.newton_step(&self.at, &mut self.counters)
            && self.search(&proposal, IMPATIENT)
        {
            return Ok(());
        }
        let tolerance = (1e-2 * error).clamp(1e-8, 1e-4);
        let penalty = self.penalty.0;
        let mut proposal = self.proposer.subproblem_step(
            &self.at,
            penalty,
            newton,
            tolerance,
            &mut self.counters,
        )?;
        let missed = self.at.violation(self.e) > self.options.feasibility;
        if self.search(&proposal, IMPATIENT) {
            return Ok(());
        }
        if proposal.kind == StepKind::Newton {
            proposal = self.proposer.subproblem_step(
                &self.at,
                penalty,
                false,
                tolerance,
                &mut self.counters,
            )?;
            if self.search(&proposal, IMPATIENT) {
                return Ok(());
            }
        }
        if missed && proposal.kind != StepKind::Elastic {
            // Contradicting or nearly dependent rows make long steps with large multipliers; the
            // elastic subproblem at the present penalty bounds both.
            let elastic = self
                .proposer
                .elastic_step(&self.at, penalty, &mut self.counters)?;
            if self.search(&elastic, SHORTEST) {
                return Ok(());
            }
        }
        if self.search(&proposal, SHORTEST) {
            Ok(())
        } else {
            Err(Status::Stalled)
        }
    }

    /// Backtracks along a proposal; moves and returns true if the merit function accepts.
    fn search(&mut self, proposal: &Proposal, shortest: f64) -> bool {
        let s = self.e.structure();
        let (slope, model, relief) = model_change(s, &self.at, proposal);
        let before = self.penalty;
        self.penalty.0 = self.penalty.0.max(proposal.penalty);
        self.penalty.update(model, relief);
        // The price of an elastic step is that of a place where rows cannot all be met: it must not fall there.
        self.penalty.0 = self.penalty.0.max(proposal.penalty);
        let violation = self.at.violation(self.e);
        let merit = Merit {
            value: self.reference(self.at.cost, violation),
            slope: slope - self.penalty.0 * relief,
            penalty: self.penalty.0,
        };
        if merit.slope > merit::ROUNDING * merit.value.abs().max(1.0) {
            self.penalty = before;
            return false;
        }
        let mut rows = vec![0.0; s.rows()];
        let mut correction = None;
        let mut alpha = 1.0;
        while alpha >= shortest {
            let x = self.point_at(alpha, &proposal.d);
            let (cost, v) = self.values(&x, &mut rows);
            if merit.accepts(alpha, cost, v) {
                self.move_to(x, alpha, proposal, proposal.kind);
                return true;
            }
            let curved = v.is_finite() && v > (1.0 - alpha) * violation + 1e-3 * relief.max(0.0);
            if self.options.second_order_correction && curved && alpha >= IMPATIENT {
                if alpha == 1.0 {
                    correction =
                        Correction::prepare(s, &mut self.proposer.newton, &self.at, &x, &rows);
                }
                if let Some(correction) = &correction
                    && self.correct(correction, proposal, &merit, alpha, x, &rows)
                {
                    return true;
                }
            }
            alpha *= 0.5;
        }
        self.penalty = before;
        false
    }

    /// The largest merit of the present point and the last few, with the present penalty.
    fn reference(&self, cost: f64, violation: f64) -> f64 {
        let merit = |&(f, v): &(f64, f64)| f + self.penalty.0 * v;
        self.memory
            .iter()
            .map(merit)
            .fold(cost + self.penalty.0 * violation, f64::max)
    }

    /// Tries the second-order correction of a rejected trial point.
    fn correct(
        &mut self,
        correction: &Correction,
        proposal: &Proposal,
        merit: &Merit,
        alpha: f64,
        mut x: Vec<f64>,
        trial_rows: &[f64],
    ) -> bool {
        let s = self.e.structure();
        let mut rows = trial_rows.to_vec();
        let mut violation = merit::violation(s, &rows);
        for _ in 0..CORRECTIONS {
            self.counters.corrections += 1;
            let newton = &mut self.proposer.newton;
            let Some(p) = correction.step(s, newton, &self.at, alpha, &rows) else {
                return false;
            };
            x.iter_mut().zip(&p).for_each(|(x, p)| *x += p);
            clamp(&mut x, &s.lower, &s.upper);
            let (cost, v) = self.values(&x, &mut rows);
            if merit.accepts(alpha, cost, v) {
                self.counters.corrections_accepted += 1;
                self.move_to(x, alpha, proposal, StepKind::Corrected);
                return true;
            }
            if v.is_nan() || v > CONTRACTION * violation {
                return false;
            }
            violation = v;
        }
        false
    }

    fn point_at(&self, alpha: f64, d: &[f64]) -> Vec<f64> {
        let s = self.e.structure();
        let mut x: Vec<f64> = self
            .at
            .x
            .iter()
            .zip(d)
            .map(|(x, d)| x + alpha * d)
            .collect();
        clamp(&mut x, &s.lower, &s.upper);
        x
    }

    fn values(&mut self, x: &[f64], rows: &mut [f64]) -> (f64, f64) {
        self.counters.value_evaluations += 1;
        let cost = self.e.values(x, rows);
        let finite = rows.iter().all(|r| r.is_finite());
        (
            cost,
            if finite {
                merit::violation(self.e.structure(), rows)
            } else {
                f64::INFINITY
            },
        )
    }

    fn move_to(&mut self, x: Vec<f64>, alpha: f64, proposal: &Proposal, kind: StepKind) {
        if self.options.history {
            self.history.push(Iteration {
                cost: self.at.cost,
                violation: self.at.violation(self.e),
                optimality: self.at.error(self.e).worst(),
                alpha,
                step: max_abs(&proposal.d),
                penalty: self.penalty.0,
                kind,
                smallest_eigenvalue: self.proposer.convexity.smallest,
                changed_eigenvalues: self.proposer.convexity.changed,
            });
        }
        self.counters.iterations += 1;
        self.memory
            .push_back((self.at.cost, self.at.violation(self.e)));
        if self.memory.len() > self.options.memory {
            self.memory.pop_front();
        }
        if proposal.kind == StepKind::Newton {
            self.proposer.shift.learn(alpha, max_abs(&proposal.d));
        } else {
            self.proposer.damping.learn(alpha);
        }
        self.counters.newton_steps += usize::from(kind == StepKind::Newton);
        self.at.x = x;
        for (y, new) in self.at.y.iter_mut().zip(&proposal.y) {
            *y += alpha * (new - *y);
        }
        for (z, new) in self.at.z.iter_mut().zip(&proposal.z) {
            *z += alpha * (new - *z);
        }
        self.at.differentiate(self.e, &mut self.counters);
    }

    fn certificate(&mut self, status: Status) -> Certificate {
        let error = self.at.error(self.e);
        if status != Status::Solved || !self.proposer.refresh_hessian(&self.at, &mut self.counters)
        {
            return Certificate::uninformed(error);
        }
        let active = match &self.proposer.active {
            Some(active) => active.clone(),
            None => active_from_multipliers(self.e, &self.at.y, &self.at.z),
        };
        certify(self.e, &mut self.proposer, &self.at, &active)
    }

    fn settle(&self, status: Status, certificate: &Certificate) -> Status {
        match status {
            Status::Solved if certificate.holds(self.options.certified) => Status::Solved,
            Status::Solved => Status::Uncertified,
            other => other,
        }
    }
}

/// The active set that multipliers speak of.
fn active_from_multipliers(e: &dyn Evaluator, y: &[f64], z: &[f64]) -> ActiveSet {
    let s = e.structure();
    ActiveSet {
        rows: (0..s.rows())
            .map(|r| s.row_lower[r] == s.row_upper[r] || y[r].abs() > 1e-9)
            .collect(),
        bounds: (0..s.variables())
            .map(|v| s.lower[v] == s.upper[v] || z[v].abs() > 1e-9)
            .collect(),
    }
}

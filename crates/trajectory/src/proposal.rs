//! Where the next step comes from: Newton on the known active set, the convex
//! subproblem, or the elastic one.
//!
//! A Newton step that keeps all inactive limits, has a positive definite
//! reduced Hessian and multipliers of the right sign *is* a local minimiser of
//! the subproblem with the exact Hessian. It is therefore tried first on the
//! active set that Clarabel found last, and again on each new one.

use crate::active_set::{self, Settled};
use crate::convexify::{self, Convexification, Convexity};
use crate::damping::Damping;
use crate::elastic::{self, ElasticStep};
use crate::iterate::Iterate;
use crate::merit;
use crate::model::{Evaluator, Structure};
use crate::newton::{ActiveSet, Limits, NewtonSystem};
use crate::pattern::max_abs;
use crate::qp::{QpData, QpStep, Subproblem};
use crate::shift::Shift;
use crate::solution::{Counters, StepKind};
use crate::{HessianModel, Options, Status};
use clarabel::solver::SolverStatus;

/// A subproblem's step longer than this (scaled) comes from rows that nearly contradict.
const OUTSIZED: f64 = 30.0;
/// Elastic subproblems at one point, each with more damping than the last.
const ATTEMPTS: usize = 4;

/// A step with multipliers.
#[derive(Clone, Debug)]
pub(crate) struct Proposal {
    pub kind: StepKind,
    pub d: Vec<f64>,
    pub y: Vec<f64>,
    pub z: Vec<f64>,
    /// dᵀHd with the Hessian that made the step.
    pub curvature: f64,
    /// Least penalty that this step asks for (elastic steps).
    pub penalty: f64,
}

/// The workspace that proposes steps.
pub(crate) struct Proposer<'e> {
    evaluator: &'e dyn Evaluator,
    options: &'e Options,
    subproblem: Option<Subproblem>,
    elastic: Option<Subproblem>,
    pub newton: NewtonSystem,
    groups: Vec<Vec<f64>>,
    pub hessian: Vec<f64>,
    convex: Vec<f64>,
    pub shift: Shift,
    pub damping: Damping,
    pub active: Option<ActiveSet>,
    pub convexity: Convexity,
    convex_is_current: bool,
    /// The layout of the Newton matrix whose entries the subproblems have.
    layout: usize,
}

impl<'e> Proposer<'e> {
    pub(crate) fn new(evaluator: &'e dyn Evaluator, options: &'e Options) -> Self {
        let s = evaluator.structure();
        Self {
            evaluator,
            options,
            subproblem: None,
            elastic: None,
            newton: NewtonSystem::new(s),
            groups: vec![Vec::new(); s.groups.len()],
            hessian: vec![0.0; s.hessian.len()],
            convex: vec![0.0; s.hessian.len()],
            shift: Shift::default(),
            damping: Damping::default(),
            active: None,
            convexity: Convexity {
                smallest: f64::NAN,
                changed: 0,
            },
            convex_is_current: false,
            layout: 0,
        }
    }

    fn s(&self) -> &'e Structure {
        self.evaluator.structure()
    }

    /// Evaluates the Hessian of the Lagrangian at `at`; false if it is not finite.
    pub(crate) fn refresh_hessian(&mut self, at: &Iterate, counters: &mut Counters) -> bool {
        counters.hessian_evaluations += 1;
        self.evaluator.second(&at.x, 1.0, &at.y, &mut self.groups);
        convexify::assemble(self.s(), &self.groups, &mut self.hessian);
        self.convex_is_current = false;
        self.convexity = Convexity {
            smallest: f64::NAN,
            changed: 0,
        };
        self.hessian.iter().all(|h| h.is_finite())
    }

    fn refresh_convex(&mut self, at: &Iterate, counters: &mut Counters) {
        if self.convex_is_current {
            return;
        }
        self.newton.grow(self.s(), &self.hessian, &at.jacobian);
        if self.layout != self.newton.layout {
            (self.subproblem, self.elastic) = (None, None);
            self.layout = self.newton.layout;
        }
        if self.options.hessian == HessianModel::CostOnly {
            counters.hessian_evaluations += 1;
            self.evaluator
                .second(&at.x, 1.0, &vec![0.0; at.y.len()], &mut self.groups);
        }
        let settings = Convexification {
            model: self.options.hessian,
            floor: self.options.curvature_floor,
            weight: self.options.row_weight,
        };
        self.convexity = convexify::assemble_convex(
            self.s(),
            &self.groups,
            &at.jacobian,
            settings,
            &mut self.convex,
        );
        self.convex_is_current = true;
    }

    /// Newton's step on the active set of the last subproblem, if it (revised) solves the
    /// subproblem with a Hessian that is exact or nearly so.
    pub(crate) fn newton_step(
        &mut self,
        at: &Iterate,
        counters: &mut Counters,
    ) -> Option<Proposal> {
        let active = self.active.clone()?;
        let limits = Limits::of(self.s(), &at.x, &at.rows, &at.y, &at.z);
        self.newton_on(at, active, limits, counters)
    }

    fn newton_on(
        &mut self,
        at: &Iterate,
        active: ActiveSet,
        limits: Limits,
        counters: &mut Counters,
    ) -> Option<Proposal> {
        let s = self.s();
        let settled = active_set::settle(
            s,
            &mut self.newton,
            &self.hessian,
            at,
            &active,
            &limits,
            &mut self.shift,
        );
        counters.factorisations = self.newton.factorisations;
        let Settled {
            step,
            active,
            hessian,
        } = settled?;
        self.active = Some(active);
        let curvature = s.hessian.quadratic_form(&hessian, &step.d);
        Some(Proposal {
            kind: StepKind::Newton,
            d: step.d,
            y: step.y,
            z: step.z,
            curvature,
            penalty: 0.0,
        })
    }

    /// The step of the convex subproblem, replaced by Newton's step on its
    /// active set where that is allowed and better.
    pub(crate) fn subproblem_step(
        &mut self,
        at: &Iterate,
        penalty: f64,
        newton: bool,
        tolerance: f64,
        counters: &mut Counters,
    ) -> Result<Proposal, Status> {
        self.refresh_convex(at, counters);
        let s = self.s();
        let step = match self.damped_step(at, tolerance, counters) {
            Ok(step) => step,
            Err(_) => return self.elastic_step(at, penalty, counters),
        };
        let active = ActiveSet {
            rows: step.active_rows.clone(),
            bounds: step.active_bounds.clone(),
        };
        self.active = Some(active.clone());
        if newton {
            let limits = Limits::of(s, &at.x, &at.rows, &step.y, &step.z);
            if let Some(proposal) = self.newton_on(at, active, limits, counters) {
                return Ok(proposal);
            }
        }
        if self.is_outsized(at, &step) {
            return self.elastic_step(at, penalty, counters);
        }
        Ok(self.convex_proposal(at, StepKind::Subproblem, step, 0.0))
    }

    /// Whether a step meets all missed rows only far outside of what its linearisation knows. Its multipliers, once
    /// taken over, would make a Hessian of their own size, and that still larger ones.
    fn is_outsized(&self, at: &Iterate, step: &QpStep) -> bool {
        merit::worst_violation(self.s(), &at.rows) > self.options.feasibility
            && max_abs(&step.d) > OUTSIZED
    }

    /// Solves the convex subproblem, with more damping while its step is out of reach.
    fn damped_step(
        &mut self,
        at: &Iterate,
        tolerance: f64,
        counters: &mut Counters,
    ) -> Result<QpStep, SolverStatus> {
        let s = self.s();
        let mut last = Err(SolverStatus::Unsolved);
        for attempt in 0..3 {
            let hessian = self.damped_hessian();
            counters.subproblems += 1;
            let gradient = self.gradient(at, &at.rows);
            last = self
                .subproblem
                .get_or_insert_with(|| Subproblem::new(s, self.newton.known_slopes(s)))
                .solve(s, &QpData::at(at, &hessian, &gradient, &at.rows), tolerance);
            match &last {
                Ok(step) => {
                    counters.interior_iterations += step.iterations;
                    let length = max_abs(&step.d);
                    if Damping::trusts(length) || attempt == 2 {
                        return last;
                    }
                    self.damping.shorten(length, self.options.curvature_floor);
                }
                Err(SolverStatus::PrimalInfeasible | SolverStatus::AlmostPrimalInfeasible) => {
                    return last;
                }
                Err(_) => {
                    // Data of this point must not be scaled by those of another.
                    self.subproblem = None;
                    self.damping.stiffen();
                }
            }
        }
        last
    }

    /// The gradient that goes with the convex Hessian.
    fn gradient(&self, at: &Iterate, rows: &[f64]) -> Vec<f64> {
        convexify::gradient(
            self.s(),
            &at.gradient,
            &at.jacobian,
            rows,
            self.options.row_weight,
        )
    }

    /// Share of dᵀPd that the squares of the rows make, and that is no curvature of the cost.
    fn squares(&self, at: &Iterate, d: &[f64]) -> f64 {
        let s = self.s();
        let own = s
            .groups
            .iter()
            .flat_map(|g| g.own_rows.iter().map(move |own| (g, own)));
        let moves = own.map(|(g, own)| {
            let product: f64 = own
                .entries
                .iter()
                .map(|&(slot, p)| at.jacobian[slot] * d[g.variables[p]])
                .sum();
            product * product
        });
        self.options.row_weight * moves.sum::<f64>()
    }

    /// H + δI.
    fn damped_hessian(&self) -> Vec<f64> {
        let mut hessian = self.convex.clone();
        if self.damping.0 > 0.0 {
            self.s()
                .hessian
                .add_to_diagonal(&mut hessian, self.damping.0);
        }
        hessian
    }

    /// The step of the elastic subproblem, with more damping while Clarabel cannot resolve it or its step is out of reach.
    pub(crate) fn elastic_step(
        &mut self,
        at: &Iterate,
        penalty: f64,
        counters: &mut Counters,
    ) -> Result<Proposal, Status> {
        self.refresh_convex(at, counters);
        self.active = None;
        for attempt in 1..=ATTEMPTS {
            match self.elastic_once(at, penalty, counters) {
                ElasticStep::Step(step, price) => {
                    if max_abs(&step.d) <= OUTSIZED || attempt == ATTEMPTS {
                        return Ok(self.convex_proposal(at, StepKind::Elastic, step, price));
                    }
                }
                ElasticStep::NoRelief => return Err(Status::LocallyInfeasible),
                // Data of this point must not be scaled by those of another.
                ElasticStep::Failed => self.elastic = None,
            }
            self.damping.stiffen();
        }
        Err(Status::SubproblemFailed)
    }

    fn elastic_once(&mut self, at: &Iterate, penalty: f64, counters: &mut Counters) -> ElasticStep {
        let s = self.s();
        let hessian = self.damped_hessian();
        let gradient = self.gradient(at, &at.rows);
        let max_penalty = self.options.max_penalty;
        let mut solved = 0;
        let outcome = elastic::solve(
            s,
            self.elastic
                .get_or_insert_with(|| Subproblem::new_elastic(s, self.newton.known_slopes(s))),
            &QpData::at(at, &hessian, &gradient, &at.rows),
            elastic::price(penalty, &at.gradient, max_penalty),
            max_penalty,
            &mut counters.interior_iterations,
            &mut solved,
        );
        counters.elastic += solved;
        counters.subproblems += solved;
        outcome
    }

    fn convex_proposal(
        &self,
        at: &Iterate,
        kind: StepKind,
        step: QpStep,
        penalty: f64,
    ) -> Proposal {
        let total = self
            .s()
            .hessian
            .quadratic_form(&self.damped_hessian(), &step.d);
        let curvature = total - self.squares(at, &step.d);
        Proposal {
            kind,
            d: step.d,
            y: step.y,
            z: step.z,
            curvature,
            penalty,
        }
    }
}

/// gᵀd + ½ max(0, dᵀHd) and the relief v − v_lin of a proposal.
pub(crate) fn model_change(s: &Structure, at: &Iterate, proposal: &Proposal) -> (f64, f64, f64) {
    let slope = crate::pattern::dot(&at.gradient, &proposal.d);
    let before = merit::violation(s, &at.rows);
    let after = merit::linear_violation(s, &at.rows, &at.jacobian, &proposal.d);
    (
        slope,
        slope + 0.5 * proposal.curvature.max(0.0),
        before - after,
    )
}

//! The current point of a solve with everything that was evaluated there.

use crate::merit;
use crate::model::Evaluator;
use crate::optimality::{OptimalityError, optimality_error};
use crate::solution::Counters;

/// Point, values, first derivatives and multipliers (scaled).
#[derive(Clone, Debug)]
pub(crate) struct Iterate {
    pub x: Vec<f64>,
    pub cost: f64,
    pub rows: Vec<f64>,
    pub gradient: Vec<f64>,
    pub jacobian: Vec<f64>,
    pub y: Vec<f64>,
    pub z: Vec<f64>,
}

impl Iterate {
    /// Evaluates the programme at `x`, moved into the bounds.
    pub(crate) fn new(
        e: &dyn Evaluator,
        x: Vec<f64>,
        y: Vec<f64>,
        z: Vec<f64>,
        counters: &mut Counters,
    ) -> Self {
        let s = e.structure();
        let mut iterate = Self {
            x,
            cost: 0.0,
            rows: vec![0.0; s.rows()],
            gradient: vec![0.0; s.variables()],
            jacobian: vec![0.0; s.jacobian.len()],
            y,
            z,
        };
        clamp(&mut iterate.x, &s.lower, &s.upper);
        iterate.differentiate(e, counters);
        iterate
    }

    /// Evaluates values and first derivatives at the present `x`.
    pub(crate) fn differentiate(&mut self, e: &dyn Evaluator, counters: &mut Counters) {
        counters.derivative_evaluations += 1;
        self.cost = e.first(
            &self.x,
            &mut self.rows,
            &mut self.gradient,
            &mut self.jacobian,
        );
    }

    /// Are all values and derivatives finite?
    pub(crate) fn is_finite(&self) -> bool {
        let finite = |v: &[f64]| v.iter().all(|x| x.is_finite());
        self.cost.is_finite()
            && finite(&self.rows)
            && finite(&self.gradient)
            && finite(&self.jacobian)
    }

    /// The first-order errors at this point.
    pub(crate) fn error(&self, e: &dyn Evaluator) -> OptimalityError {
        let s = e.structure();
        optimality_error(
            s,
            &self.x,
            &self.rows,
            &self.gradient,
            &self.jacobian,
            &self.y,
            &self.z,
        )
    }

    /// Sum of missed rows.
    pub(crate) fn violation(&self, e: &dyn Evaluator) -> f64 {
        merit::violation(e.structure(), &self.rows)
    }
}

/// Moves a point into its bounds.
pub(crate) fn clamp(x: &mut [f64], lower: &[f64], upper: &[f64]) {
    for (v, (&l, &u)) in x.iter_mut().zip(lower.iter().zip(upper)) {
        *v = v.max(l).min(u);
    }
}

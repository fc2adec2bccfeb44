//! Signatures of causes beside a fitted model: what a cause adds to the prediction, raw, over all samples.
//!
//! Two fits of one model to nearly the same data (a fold's and the whole campaign's) have the same signatures but for what the law moves between
//! them: those that were computed beside the one serve the other.

use std::sync::Arc;

use nalgebra::DMatrix;
use rig::Model;

use crate::bench::{Bench, Fitted};

/// One signature of a cause, all samples.
pub(crate) struct Signature {
    pub(crate) cause: usize,
    /// Cause's parameters at which it was taken.
    pub(crate) at: Vec<f64>,
    /// Raw columns.
    pub(crate) columns: DMatrix<f64>,
    /// Size that one unit of the first column stands for, where it is a chord.
    pub(crate) chord: Option<Vec<f64>>,
}

impl Signature {
    /// `None` where the columns leave the numbers.
    fn new(
        cause: usize,
        at: &[f64],
        columns: DMatrix<f64>,
        chord: Option<Vec<f64>>,
    ) -> Option<Self> {
        columns.iter().all(|x| x.is_finite()).then(|| Self {
            cause,
            at: at.to_vec(),
            columns,
            chord,
        })
    }
}

/// The model of a fit with one more cause, and the parameters with the cause at `own`.
pub(crate) fn extended(
    bench: &Bench<'_>,
    fitted: &Fitted,
    cause: usize,
    own: &[f64],
) -> Option<(Model, Vec<f64>)> {
    let mut effects = fitted.effects.clone();
    effects.push(cause);
    let model = bench.model(&effects)?;
    let end = fitted.model.initial_states().start;
    let mut p = fitted.parameters[..end].to_vec();
    p.extend_from_slice(own);
    p.extend_from_slice(&fitted.parameters[end..]);
    Some((model, p))
}

/// Signature of a cause at given shape (its sizes at zero).
pub(crate) fn tangent(
    bench: &Bench<'_>,
    fitted: &Fitted,
    cause: usize,
    at: &[f64],
) -> Option<Signature> {
    let (model, p) = extended(bench, fitted, cause, at)?;
    let first = fitted.model.initial_states().start;
    let columns: Vec<usize> = bench.catalogue[cause]
        .sizes()
        .iter()
        .map(|i| first + i)
        .collect();
    let paths = fitted.paths(bench);
    let jacobian = model.jacobian_beside(&bench.experiment, &p, &columns, paths);
    Signature::new(cause, at, jacobian, None)
}

/// The chord from the fit to a plausible size of a cause.
pub(crate) fn chord(
    bench: &Bench<'_>,
    fitted: &Fitted,
    cause: usize,
    at: &[f64],
) -> Option<Signature> {
    let (model, p) = extended(bench, fitted, cause, at)?;
    let there = model.predict_beside(&bench.experiment, &p, fitted.paths(bench));
    let columns = DMatrix::from_iterator(
        there.len(),
        1,
        there.iter().zip(&fitted.prediction).map(|(a, b)| a - b),
    );
    Signature::new(cause, at, columns, Some(at.to_vec()))
}

/// Signatures beside one fit.
pub(crate) struct Signatures {
    /// The effects of that fit, and what it predicts.
    effects: Vec<usize>,
    prediction: Vec<f64>,
    all: Vec<Arc<Signature>>,
}

/// Root mean square by which two fits may differ, as a share of what they predict, for the signatures beside the one to serve the other.
const NEAR: f64 = 0.02;

impl Signatures {
    pub(crate) fn beside(fitted: &Fitted, all: Vec<Arc<Signature>>) -> Self {
        Self {
            effects: fitted.effects.clone(),
            prediction: fitted.prediction.clone(),
            all,
        }
    }

    /// Whether they serve beside another fit.
    pub(crate) fn serve(&self, fitted: &Fitted) -> bool {
        if self.effects != fitted.effects || self.prediction.len() != fitted.prediction.len() {
            return false;
        }
        let both = self.prediction.iter().zip(&fitted.prediction);
        let apart: f64 = both.map(|(a, b)| (a - b) * (a - b)).sum();
        let size: f64 = self.prediction.iter().map(|a| a * a).sum();
        apart < NEAR * NEAR * size
    }

    pub(crate) fn all(&self) -> &[Arc<Signature>] {
        &self.all
    }

    /// A cause's tangent or chord at these parameters, if it is among them.
    pub(crate) fn of(&self, cause: usize, at: &[f64], is_chord: bool) -> Option<&Arc<Signature>> {
        let is_it = |own: &&Arc<Signature>| {
            own.cause == cause && own.chord.is_some() == is_chord && own.at == at
        };
        self.all.iter().find(is_it)
    }
}

//! The least-squares problem of a campaign: predicted less recorded force, whitened.

use std::sync::Arc;

use fitting::Residuals;
use fitting::noise::{Context, Whitener};
use nalgebra::{DMatrix, DVector};
use rig::{Experiment, Model};

/// r(p) = W (F(p) - F_recorded), W from the noise model; without one, forces over their typical size.
pub(crate) struct Problem<'a> {
    pub(crate) experiment: &'a Experiment,
    pub(crate) model: &'a Model,
    pub(crate) whitener: Option<&'a Whitener>,
}

impl Problem<'_> {
    /// F(p) - F_recorded, N (N m).
    pub(crate) fn difference(&self, predicted: Vec<f64>) -> DVector<f64> {
        DVector::from_vec(predicted) - DVector::from_column_slice(&self.experiment.measured_n)
    }

    /// 1 over the typical size of the force, the weight without a noise model.
    fn plain_weight(&self) -> f64 {
        1.0 / self.experiment.scales.force_n.max(f64::MIN_POSITIVE)
    }
}

impl Residuals for Problem<'_> {
    fn residuals(&self, parameters: &[f64]) -> DVector<f64> {
        let difference = self.difference(self.model.predict(self.experiment, parameters));
        match self.whitener {
            Some(whitener) => whitener.whiten(&difference),
            None => difference * self.plain_weight(),
        }
    }

    fn jacobian(&self, parameters: &[f64]) -> (DVector<f64>, DMatrix<f64>) {
        let all: Vec<usize> = (0..parameters.len()).collect();
        self.jacobian_columns(parameters, &all)
    }

    fn jacobian_columns(
        &self,
        parameters: &[f64],
        columns: &[usize],
    ) -> (DVector<f64>, DMatrix<f64>) {
        let (predicted, jacobian) =
            self.model
                .predict_with_jacobian(self.experiment, parameters, Some(columns));
        let difference = self.difference(predicted);
        let Some(whitener) = self.whitener else {
            let weight = self.plain_weight();
            return (difference * weight, jacobian * weight);
        };
        // One sweep whitens residual and columns together.
        let n = jacobian.ncols();
        let mut stacked = jacobian.resize_horizontally(n + 1, 0.0);
        stacked.set_column(n, &difference);
        let whitened = whitener.whiten_columns(&stacked);
        let residual = whitened.column(n).into_owned();
        (residual, whitened.resize_horizontally(n, 0.0))
    }
}

/// What the noise model must know of the samples, with the predicted force as the friction that roughness multiplies.
pub(crate) fn noise_context(experiment: &Experiment, predicted: &[f64]) -> Context {
    let stacked = |of: fn(&rig::RunMotion) -> &[f64]| -> Vec<f64> {
        experiment
            .runs
            .iter()
            .flat_map(|run| of(run).iter().copied())
            .collect()
    };
    let mut scale = predicted.to_vec();
    if experiment.moving_mass_kg != 0.0 {
        // Inertia is no friction: roughness does not multiply it.
        for run in &experiment.runs {
            for (s, a) in scale[run.samples.clone()]
                .iter_mut()
                .zip(&run.acceleration_m_s2)
            {
                *s -= experiment.moving_mass_kg * a;
            }
        }
    }
    Context {
        runs: experiment
            .runs
            .iter()
            .map(|run| run.samples.clone())
            .collect(),
        conditions: Vec::new(),
        steps_s: Vec::new(),
        sliding: stacked(|run| &run.distance_m),
        place: stacked(|run| &run.position_m),
        scale,
        channel: Arc::default(),
        rows: Vec::new(),
    }
}

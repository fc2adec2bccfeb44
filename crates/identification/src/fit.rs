//! Parameters and noise of a campaign together.
//!
//! First every start is fitted with plain weights and the distinct minima are kept. Then noise and parameters are
//! estimated in turn: the noise from the residuals of the last fit (restricted likelihood), the parameters by least
//! squares whitened with that noise, until neither moves.
//!
//! A law that misses the record by far more than repeats scatter leaves no residual from which a noise could be told:
//! the noise would swallow the law, and weights made from it would trade levels for details. Such a law is fitted with
//! plain weights, and its answer says so ([`Weighting::Plain`]).

use fitting::noise::{
    EstimateOptions, NoiseModel, ScatterEvidence, Search, Sizes, Whitener, estimate,
};
use fitting::{Bounds, Fit, Options, Residuals, Status, minimise, multi_start};
use nalgebra::DMatrix;
use rig::{Experiment, Model};

use crate::problem::{Problem, noise_context};
use crate::question::IdentificationError;

/// Work that a fit took, for snapshots.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Starts tried.
    pub starts: usize,
    /// Starts that converged.
    pub converged: usize,
    /// Converged starts that ended in the best minimum (of the fit with plain weights).
    pub agreeing: usize,
    /// Accepted steps of all fits.
    pub iterations: u64,
    /// Evaluations of the forces.
    pub evaluations: u64,
    /// Evaluations of forces with derivatives.
    pub jacobians: u64,
    /// Evaluations of the noise's likelihood.
    pub noise_evaluations: usize,
}

impl Work {
    pub(crate) fn add(&mut self, fit: &Fit) {
        self.iterations += fit.iterations;
        self.evaluations += fit.evaluations;
        self.jacobians += fit.jacobians;
    }
}

/// What weighs the residuals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weighting {
    /// The noise estimated from the record.
    Noise,
    /// All samples alike, because the law misses the record by more than its noise.
    Plain,
}

/// A fit whose residual exceeds the scatter of the repeats by this factor misses the record: a right law stays near one.
const GROSS: f64 = 3.0;
/// Weights under which the plain sum of squares grows by this factor have traded the record for the noise.
const TRADED: f64 = 2.0;

/// A fit with the noise under which it is one.
pub(crate) struct Fitted {
    pub(crate) weighting: Weighting,
    pub(crate) fit: Fit,
    pub(crate) predicted: Vec<f64>,
    /// dF/dp at the fit, all parameters, not whitened.
    pub(crate) jacobian: DMatrix<f64>,
    pub(crate) noise: NoiseModel,
    pub(crate) whitener: Whitener,
    pub(crate) work: Work,
}

/// What a fit needs besides starts.
pub(crate) struct Task<'a> {
    pub(crate) experiment: &'a Experiment,
    pub(crate) model: &'a Model,
    pub(crate) bounds: &'a Bounds,
    pub(crate) noise_options: EstimateOptions,
    /// The noise, where it is held instead of estimated.
    pub(crate) noise: Option<NoiseModel>,
    /// All samples weigh alike, whatever the noise.
    pub(crate) plain: bool,
    /// Scatter within repeats, in the unit of y.
    pub(crate) floor: Option<f64>,
}

/// Rounds of noise and parameters in turn. The noise depends on the parameters only through residuals that barely move
/// after the first whitened fit; a third round changes no printed digit.
const ROUNDS: usize = 2;

impl Task<'_> {
    fn problem<'a>(&'a self, whitener: Option<&'a Whitener>) -> Problem<'a> {
        Problem {
            experiment: self.experiment,
            model: self.model,
            whitener,
        }
    }

    /// Fits from the starts, which are compared on `rough` (a part of the experiment) where it is given.
    pub(crate) fn run(
        &self,
        starts: &[Vec<f64>],
        rough: Option<(&Experiment, &Model)>,
    ) -> Result<Fitted, IdentificationError> {
        if let Some(held) = &self.noise {
            return self.run_under(held, starts);
        }
        let mut work = Work::default();
        // Enough to rank the minima: every one that is kept is fitted again under the noise.
        let options = Options {
            reduction_tolerance: 1e-5,
            iteration_limit: 40,
            ..Options::default()
        };
        let (experiment, model) = rough.unwrap_or((self.experiment, self.model));
        let plain = Problem {
            experiment,
            model,
            whitener: None,
        };
        let many = multi_start(&plain, starts, self.bounds, &options)
            .map_err(|error| IdentificationError::NoStart(error.to_string()))?;
        (work.starts, work.converged, work.agreeing) = (many.tried, many.converged, many.agreeing);
        many.fits.iter().for_each(|fit| work.add(fit));
        if many.best.status == Status::NonFiniteStart {
            return Err(IdentificationError::NoStart(many.best.status.to_string()));
        }
        let candidates = distinct_minima(&many.fits, &many.best);
        let plain = self.best_of(&candidates, None, &mut work)?;
        let forces = self.model.predict(self.experiment, &plain.parameters);
        let missed = self
            .floor
            .is_some_and(|floor| crate::quality::sizes(self.experiment, &forces).0 > GROSS * floor);
        if self.plain || missed {
            return self.finish(plain, Weighting::Plain, None, work);
        }
        let mut best = plain.clone();
        let mut noise: Option<NoiseModel> = None;
        for _ in 0..ROUNDS {
            let (model, whitener) = self.noise_at(&best.parameters, noise.as_ref(), &mut work);
            let from = if noise.is_none() {
                candidates.clone()
            } else {
                vec![best.parameters.clone()]
            };
            best = self.best_of(&from, Some(&whitener), &mut work)?;
            noise = Some(model);
        }
        let traded = self
            .problem(None)
            .residuals(&best.parameters)
            .norm_squared();
        if !best.status.converged() || !(traded <= TRADED * 2.0 * plain.cost) {
            return self.finish(plain, Weighting::Plain, None, work);
        }
        self.finish(best, Weighting::Noise, noise, work)
    }

    /// Fits from the starts under a noise that is known.
    fn run_under(
        &self,
        noise: &NoiseModel,
        starts: &[Vec<f64>],
    ) -> Result<Fitted, IdentificationError> {
        let mut work = Work {
            starts: starts.len(),
            ..Work::default()
        };
        let mut fits = Vec::with_capacity(starts.len());
        for start in starts {
            let forces = self.model.predict(self.experiment, start);
            let whitener = Whitener::new(&noise_context(self.experiment, &forces), &noise.sizes);
            fits.push(self.best_of(std::slice::from_ref(start), Some(&whitener), &mut work)?);
        }
        work.converged = fits.iter().filter(|fit| fit.status.converged()).count();
        let best = fits
            .into_iter()
            .min_by(|a, b| a.cost.total_cmp(&b.cost))
            .expect("a question has a start");
        self.finish(best, Weighting::Noise, Some(noise.clone()), work)
    }

    /// Best fit from several places under given weights.
    fn best_of(
        &self,
        from: &[Vec<f64>],
        whitener: Option<&Whitener>,
        work: &mut Work,
    ) -> Result<Fit, IdentificationError> {
        let options = Options {
            reduction_tolerance: 1e-8,
            initial_damping: 1e-4,
            iteration_limit: 100,
            ..Options::default()
        };
        let many = multi_start(&self.problem(whitener), from, self.bounds, &options)
            .map_err(|error| IdentificationError::NoStart(error.to_string()))?;
        many.fits.iter().for_each(|fit| work.add(fit));
        Ok(many.best)
    }

    /// White noise of the size of the residual: what plain weights stand for.
    fn plain_noise(&self, forces: &[f64]) -> NoiseModel {
        let residual = self.problem(None).difference(forces.to_vec());
        let free = residual.len() - self.bounds.movable().len();
        NoiseModel {
            sizes: Sizes {
                sensor: (residual.norm_squared() / free as f64).sqrt(),
                length: self.experiment.scales.travel_m,
                ..Sizes::NONE
            },
            log_sd: Vec::new(),
            scatter: ScatterEvidence {
                lambda: Vec::new(),
                score: Vec::new(),
            },
            plate_separable: false,
            repeats: self.noise_options.repeats,
            converged: true,
            evaluations: 0,
            deviance: f64::NAN,
        }
    }

    fn noise_at(
        &self,
        parameters: &[f64],
        former: Option<&NoiseModel>,
        work: &mut Work,
    ) -> (NoiseModel, Whitener) {
        let movable = self.bounds.movable();
        let (predicted, jacobian) =
            self.model
                .predict_with_jacobian(self.experiment, parameters, Some(&movable));
        let context = noise_context(self.experiment, &predicted);
        let residual = self.problem(None).difference(predicted);
        let mut options = self.noise_options.clone();
        if let Some(former) = former {
            options.search = Search::Again(former.sizes);
        }
        let nothing = DMatrix::zeros(residual.len(), 0);
        let model = estimate(&context, &residual, &jacobian, &nothing, &options);
        work.noise_evaluations += model.evaluations;
        let whitener = Whitener::new(&context, &model.sizes);
        (model, whitener)
    }

    fn finish(
        &self,
        fit: Fit,
        weighting: Weighting,
        noise: Option<NoiseModel>,
        mut work: Work,
    ) -> Result<Fitted, IdentificationError> {
        // One covariance for residuals, intervals and criteria: that of the final forces, with the minimum taken again
        // under it (it moves by far less than its own uncertainty).
        let forces = self.model.predict(self.experiment, &fit.parameters);
        let noise = noise.unwrap_or_else(|| self.plain_noise(&forces));
        let whitener = Whitener::new(&noise_context(self.experiment, &forces), &noise.sizes);
        // The integrator's steps follow the values, so that forces and slopes agree to about 1e-8 of the level: less than
        // 1e-10 of the cost is no longer a promise. 1e-9 is some 2e-3 standard deviations for thousands of samples.
        let options = Options {
            reduction_tolerance: 1e-9,
            initial_damping: 1e-7,
            ..Options::default()
        };
        let problem = self.problem(Some(&whitener));
        let fit = minimise(&problem, &fit.parameters, self.bounds, &options)
            .map_err(|error| IdentificationError::NoStart(error.to_string()))?;
        work.add(&fit);
        let (predicted, jacobian) =
            self.model
                .predict_with_jacobian(self.experiment, &fit.parameters, None);
        Ok(Fitted {
            weighting,
            fit,
            predicted,
            jacobian,
            noise,
            whitener,
            work,
        })
    }
}

/// Minima that differ by more than rounding, best first, at most three, within a factor of four of the best cost:
/// under the right weights another one may win.
fn distinct_minima(fits: &[Fit], best: &Fit) -> Vec<Vec<f64>> {
    let mut sorted: Vec<&Fit> = fits.iter().filter(|fit| fit.cost.is_finite()).collect();
    sorted.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let mut kept: Vec<&Fit> = vec![best];
    for fit in sorted {
        let near = |other: &Fit| {
            fit.parameters
                .iter()
                .zip(&other.parameters)
                .all(|(a, b)| (a - b).abs() <= 1e-2 * (a.abs() + b.abs()) + 1e-9)
        };
        if kept.len() < 3 && fit.cost <= 4.0 * best.cost && !kept.iter().any(|k| near(k)) {
            kept.push(fit);
        }
    }
    kept.iter().map(|fit| fit.parameters.clone()).collect()
}

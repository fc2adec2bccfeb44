//! The bench: one campaign with its law and catalogue, fits of a law with effects, and the noise beneath them.

use std::sync::{Mutex, OnceLock};

use campaign::Campaign;
use fitting::noise::{EstimateOptions, NoiseModel, Search, Sizes, Whitener, estimate};
use fitting::{Bounds, Options as SolverOptions, Residuals, minimise};
use friction::{LawKind, ParameterSpec};
use nalgebra::{DMatrix, DVector};
use rig::{Cause, Experiment, Model, Paths};

use crate::condense::Condensed;
use crate::prior::{Prior, append_prior, with_prior_rows};
use crate::redrawn::{drawn_anew, left};
use crate::samples::Samples;
use crate::subset::Subset;
use crate::ways::Ways;

/// Everything that stays the same while hypotheses come and go.
#[derive(Clone)]
pub(crate) struct Bench<'a> {
    pub(crate) campaign: &'a Campaign,
    pub(crate) experiment: Experiment,
    pub(crate) samples: Samples,
    pub(crate) law: LawKind,
    /// Causes that act on this law and that this campaign can tell at all.
    pub(crate) catalogue: Vec<Box<dyn Cause>>,
    /// Parameters of the law known from elsewhere.
    pub(crate) prior: Option<Prior>,
    /// Accuracy of the sensor as stated, N.
    pub(crate) stated_sensor: Option<f64>,
    /// Condition of each run; runs of one condition are repeats.
    pub(crate) conditions: Vec<usize>,
    /// Samples that say nothing (a clipped channel).
    pub(crate) masked: Vec<bool>,
    /// Step of the force channel, N, where all forces are multiples of one.
    pub(crate) step_n: Option<f64>,
    /// Whether the force channel may wander.
    pub(crate) may_wander: bool,
    /// Recorded positions against recorded speeds.
    pub(crate) ways: Ways,
    /// See [`Bench::redrawn`].
    pub(crate) redrawn: OnceLock<Vec<Experiment>>,
    /// See [`crate::Options::told`].
    pub(crate) told: Option<fn(&str)>,
}

/// The condition of each run of a campaign.
pub(crate) fn conditions(campaign: &Campaign) -> Vec<usize> {
    let mut own = vec![0; campaign.runs.len()];
    for (condition, runs) in campaign.conditions().into_iter().enumerate() {
        runs.into_iter().for_each(|run| own[run] = condition);
    }
    own
}

/// Kinds of noise that an estimate asks for: roughness that is smoother or of two lengths, and a force channel that wanders.
#[derive(Clone, Copy)]
struct Kinds {
    smooth: bool,
    wanders: bool,
}

/// A law with effects, fitted to the runs of a subset.
#[derive(Clone)]
pub(crate) struct Fitted {
    /// Effects by their place in the catalogue.
    pub(crate) effects: Vec<usize>,
    pub(crate) model: Model,
    pub(crate) parameters: Vec<f64>,
    /// Prediction for all samples of the campaign, N.
    pub(crate) prediction: Vec<f64>,
    /// 1/2 |W r|^2 at the end of the fit.
    pub(crate) cost: f64,
    pub(crate) converged: bool,
    pub(crate) beside: Beside,
}

/// What is computed beside a fit when it is first asked for.
#[derive(Clone, Default)]
pub(crate) struct Beside {
    friction: OnceLock<Vec<f64>>,
    paths: OnceLock<Paths>,
    left: OnceLock<DMatrix<f64>>,
}

/// What a cell holds, computed when it is first asked for: outside of the cell, for a thread that waits for others within may be given work
/// that asks for the same.
fn kept<T>(cell: &OnceLock<T>, compute: impl FnOnce() -> T) -> &T {
    if let Some(known) = cell.get() {
        return known;
    }
    let computed = compute();
    cell.get_or_init(|| computed)
}

impl Beside {
    /// The paths of the contact's state are known.
    pub(crate) fn along(paths: Paths) -> Self {
        Self {
            paths: paths.into(),
            ..Self::default()
        }
    }
}

impl Fitted {
    /// The part of the prediction that follows friction, stacked over all runs; computed when it is first asked for.
    pub(crate) fn friction(&self, bench: &Bench<'_>) -> &[f64] {
        kept(&self.beside.friction, || {
            let known = self.beside.paths.get().unwrap_or(Paths::NONE);
            (self.model).friction_beside(&bench.experiment, &self.parameters, known)
        })
        .as_slice()
    }

    /// The paths of the contact's state, walked when they are first asked for: what a further cause does is computed along them.
    pub(crate) fn paths(&self, bench: &Bench<'_>) -> &Paths {
        let walk = || (self.model).predict_and_keep(&bench.experiment, &self.parameters);
        kept(&self.beside.paths, || walk().1)
    }

    /// What is left of the noise of recorded velocities, as the model has it (see [`crate::redrawn`]): all samples x draws, N; computed when it
    /// is first asked for.
    pub(crate) fn left_of_noise(&self, bench: &Bench<'_>) -> &DMatrix<f64> {
        kept(&self.beside.left, || left(bench, self))
    }

    /// The parameters of the law that have run to a bound, and their values.
    pub(crate) fn law_at_bounds(&self) -> impl Iterator<Item = (&ParameterSpec, f64)> {
        let law = self.model.parameters().iter().zip(&self.parameters);
        law.take(self.model.law_parameters())
            .map(|(spec, value)| (spec, *value))
            .filter(|(spec, value)| *value <= spec.lower || *value >= spec.upper)
    }

    /// The parameters with others in the place of the k-th cause's own.
    pub(crate) fn with_own(&self, k: usize, own: &[f64]) -> Vec<f64> {
        let mut parameters = self.parameters.clone();
        parameters.splice(self.model.span(k), own.iter().copied());
        parameters
    }

    /// The parameters without those of the k-th cause.
    pub(crate) fn without(&self, k: usize) -> Vec<f64> {
        self.with_own(k, &[])
    }

    /// 1/2 |W r|^2 under another noise than it was fitted under.
    pub(crate) fn cost_under(
        &self,
        bench: &Bench<'_>,
        subset: &Subset,
        whitener: &Whitener,
    ) -> f64 {
        0.5 * self.white_residual(bench, subset, whitener).norm_squared()
    }

    /// Measured less predicted, not whitened.
    pub(crate) fn residual(&self, bench: &Bench<'_>, subset: &Subset) -> DVector<f64> {
        subset.gather(&bench.experiment.measured_n) - subset.gather(&self.prediction)
    }

    /// The same whitened, with the rows of a prior below.
    pub(crate) fn white_residual(
        &self,
        bench: &Bench<'_>,
        subset: &Subset,
        whitener: &Whitener,
    ) -> DVector<f64> {
        let white = whitener.whiten(&self.residual(bench, subset));
        with_prior_rows(bench.prior.as_ref(), white, &self.parameters)
    }

    /// The ids of the named causes, in their order.
    pub(crate) fn ids(&self, bench: &Bench<'_>) -> Vec<&'static str> {
        let effects = self.effects.iter();
        effects.map(|&e| bench.catalogue[e].id()).collect()
    }

    /// Whether the model holds a cause, in this form or another one.
    pub(crate) fn names(&self, bench: &Bench<'_>, cause: usize) -> bool {
        let id = bench.catalogue[cause].id();
        self.effects.iter().any(|&e| bench.catalogue[e].id() == id)
    }
}

/// How long a fit may go on.
#[derive(Clone, Copy)]
pub(crate) struct Limit {
    steps: u64,
    below: Option<f64>,
}

impl From<u64> for Limit {
    fn from(steps: u64) -> Self {
        Self { steps, below: None }
    }
}

impl Limit {
    /// For a fit that is of use only below this cost (1/2 |W r|^2): given up once it plainly will not come there.
    pub(crate) fn below(steps: u64, cost: f64) -> Self {
        Self {
            steps,
            below: Some(cost),
        }
    }
}

/// Steps of a cord for each sample: what sticks and slips too fast for them is not in the record, and most of a search would be spent
/// on cords that do.
const STEPS_A_SAMPLE: usize = 20;

/// Which parameters move in a fit.
fn movable(model: &Model, subset: &Subset, runs: usize) -> Vec<bool> {
    let mut free = vec![true; model.parameters().len()];
    for run in 0..runs {
        if let Some(column) = model.initial_state_of(run) {
            free[column] = subset.runs.contains(&run);
        }
    }
    free
}

/// The whitened least-squares problem of a model on a subset.
struct Problem<'a> {
    bench: &'a Bench<'a>,
    subset: &'a Subset,
    model: &'a Model,
    whitener: &'a Whitener,
    measured: DVector<f64>,
    /// The point that was looked at last: a step that is taken is looked at again, for its derivatives.
    last: Mutex<Option<Looked>>,
}

/// Residuals at a point, and the paths of the contact's state there.
#[derive(Clone)]
struct Looked {
    parameters: Vec<f64>,
    residuals: DVector<f64>,
    paths: Paths,
}

impl Problem<'_> {
    fn look(&self, parameters: &[f64]) -> Looked {
        let (predicted, paths) = (self.model).predict_and_keep(&self.bench.experiment, parameters);
        let r = self.subset.gather(&predicted) - &self.measured;
        let prior = self.bench.prior.as_ref();
        Looked {
            parameters: parameters.to_vec(),
            // The residual here is predicted less measured.
            residuals: -with_prior_rows(prior, -self.whitener.whiten(&r), parameters),
            paths,
        }
    }

    /// The point that was looked at last, if it is this one.
    fn looked_at(&self, parameters: &[f64]) -> Option<Looked> {
        let last = self.last.lock().expect("no look panics");
        let here = last.as_ref().filter(|l| l.parameters == parameters);
        here.cloned()
    }
}

impl Residuals for Problem<'_> {
    fn residuals(&self, parameters: &[f64]) -> DVector<f64> {
        let looked = self.look(parameters);
        let residuals = looked.residuals.clone();
        *self.last.lock().expect("no look panics") = Some(looked);
        residuals
    }

    fn jacobian(&self, parameters: &[f64]) -> (DVector<f64>, DMatrix<f64>) {
        let columns: Vec<usize> = (0..parameters.len()).collect();
        self.jacobian_columns(parameters, &columns)
    }

    fn jacobian_columns(
        &self,
        parameters: &[f64],
        columns: &[usize],
    ) -> (DVector<f64>, DMatrix<f64>) {
        let looked = self
            .looked_at(parameters)
            .unwrap_or_else(|| self.look(parameters));
        let experiment = &self.bench.experiment;
        let jacobian = (self.model).jacobian_beside(experiment, parameters, columns, &looked.paths);
        let white = (self.whitener).whiten_columns(&self.subset.gather_columns(&jacobian));
        let owners: Vec<Option<usize>> = columns.iter().map(|&c| Some(c)).collect();
        let prior = self.bench.prior.as_ref();
        (looked.residuals, append_prior(prior, white, &owners))
    }
}

impl<'a> Bench<'a> {
    /// Says how far the diagnosis has come, to whoever wants to be told.
    pub(crate) fn tell(&self, how_far: impl FnOnce() -> String) {
        if let Some(told) = self.told {
            told(&how_far());
        }
    }

    /// The campaign with noise of its velocities drawn anew (see [`crate::redrawn`]); made when it is first asked for.
    pub(crate) fn redrawn(&self) -> &[Experiment] {
        kept(&self.redrawn, || drawn_anew(self)).as_slice()
    }

    /// Names of a subset's runs.
    pub(crate) fn run_names(&self, subset: &Subset) -> Vec<String> {
        let name = |&k: &usize| self.campaign.runs[k].name.clone();
        subset.runs.iter().map(name).collect()
    }

    /// The model of the law with these effects.
    pub(crate) fn model(&self, effects: &[usize]) -> Option<Model> {
        let effects = effects.iter().map(|&i| self.catalogue[i].boxed()).collect();
        let model = Model::new(self.law, effects, &self.experiment).ok()?;
        Some(model.with_steps_a_sample(STEPS_A_SAMPLE))
    }

    /// Fits a law with effects from one start. `target` replaces the measured force (stacked, all runs) where a fit to a
    /// prediction is asked for. `None` where the model cannot be computed.
    pub(crate) fn fit(
        &self,
        subset: &Subset,
        effects: &[usize],
        start: &[f64],
        whitener: &Whitener,
        target: Option<&[f64]>,
        limit: impl Into<Limit>,
    ) -> Option<Fitted> {
        let limit = limit.into();
        let model = self.model(effects)?;
        let free = movable(&model, subset, self.samples.runs.len());
        let (mut lower, mut upper) = (Vec::new(), Vec::new());
        for (k, spec) in model.parameters().iter().enumerate() {
            if free[k] {
                lower.push(spec.lower);
                upper.push(spec.upper);
            } else {
                lower.push(start[k]);
                upper.push(start[k]);
            }
        }
        let bounds = Bounds::new(lower, upper).ok()?;
        let problem = Problem {
            bench: self,
            subset,
            model: &model,
            whitener,
            measured: subset.gather(target.unwrap_or(&self.experiment.measured_n)),
            last: Mutex::new(None),
        };
        let options = SolverOptions {
            reduction_tolerance: 1e-7,
            step_tolerance: 1e-8,
            iteration_limit: limit.steps,
            initial_damping: 1e-4,
            below: limit.below,
        };
        let mut fit = minimise(&problem, start, &bounds, &options).ok()?;
        if !fit.cost.is_finite() {
            return None;
        }
        if let Some(again) = self.revived(&model, start, &fit.parameters, &bounds)
            && let Ok(other) = minimise(&problem, &again, &bounds, &options)
            && other.cost < fit.cost
        {
            fit = other;
        }
        let beside = match problem.looked_at(&fit.parameters) {
            Some(looked) => Beside::along(looked.paths),
            None => Beside::default(),
        };
        let known = beside.paths.get().unwrap_or(Paths::NONE);
        let prediction = model.predict_beside(&self.experiment, &fit.parameters, known);
        Some(Fitted {
            effects: effects.to_vec(),
            prediction,
            cost: fit.cost,
            converged: fit.status.converged(),
            parameters: fit.parameters,
            model,
            beside,
        })
    }

    /// Where a fit may go on that a long step has thrown against a bound: with a Stribeck velocity far below all speeds, the law has no dip
    /// any more and its slope says nothing of the way back. The law's parameters that ended so stand again where they began.
    fn revived(
        &self,
        model: &Model,
        start: &[f64],
        end: &[f64],
        bounds: &Bounds,
    ) -> Option<Vec<f64>> {
        /// Share of the force below which all the way back, by the slope at the bound, does nothing that noise would let be seen.
        const NOTHING: f64 = 1e-4;
        let (lower, upper) = (bounds.lower(), bounds.upper());
        let thrown: Vec<usize> = (0..model.law_parameters())
            .filter(|&k| end[k] != start[k] && (end[k] == lower[k] || end[k] == upper[k]))
            .collect();
        if thrown.is_empty() {
            return None;
        }
        let (force, slopes) = model.predict_with_jacobian(&self.experiment, end, Some(&thrown));
        let size = force.iter().map(|f| f * f).sum::<f64>().sqrt();
        let mut again = None;
        for (slope, &k) in slopes.column_iter().zip(&thrown) {
            if slope.norm() * (start[k] - end[k]).abs() < NOTHING * size {
                again.get_or_insert_with(|| end.to_vec())[k] = start[k];
            }
        }
        again
    }

    /// The same questions to a condensed record.
    pub(crate) fn condensed<'c>(&self, short: &'c Condensed) -> Bench<'c> {
        let mut samples = Samples::new(&short.campaign);
        samples.least_speed_m_s = self.samples.least_speed_m_s;
        samples.averaged = short.averaged.clone();
        let experiment = Experiment::new(&short.campaign).expect("what moves goes on moving");
        let mut experiment = experiment.moving_as(&self.experiment);
        for (run, own) in experiment.runs.iter_mut().zip(&self.experiment.runs) {
            run.take_past_of(own);
        }
        Bench {
            campaign: &short.campaign,
            experiment,
            samples,
            conditions: conditions(&short.campaign),
            masked: short.masked.clone(),
            redrawn: OnceLock::new(),
            ..self.clone()
        }
    }

    /// A fit with the law's parameters as a model from elsewhere states them: itself where none does.
    pub(crate) fn as_stated(&self, fitted: &Fitted) -> Fitted {
        let Some(prior) = &self.prior else {
            return fitted.clone();
        };
        let mut stated = fitted.clone();
        stated.parameters[..prior.values.len()].copy_from_slice(&prior.values);
        stated.prediction = stated.model.predict(&self.experiment, &stated.parameters);
        stated.beside = Beside::default();
        stated
    }

    /// Whether some condition was repeated.
    pub(crate) fn repeats(&self) -> bool {
        let last = self.conditions.iter().max();
        last.is_some_and(|last| last + 1 < self.conditions.len())
    }

    /// Samples whose mechanics must be computed, runs with the same motion counted once.
    pub(crate) fn mechanics(&self) -> usize {
        let runs = self.experiment.runs.iter().enumerate();
        runs.filter(|(k, run)| run.twin == *k)
            .map(|(_, run)| run.len())
            .sum()
    }

    /// Sizes to begin with, before any residual is known.
    pub(crate) fn first_sizes(&self) -> Sizes {
        let n = self.samples.len() as f64;
        let rms = (self.samples.force.iter().map(|f| f * f).sum::<f64>() / n).sqrt();
        let (lo, hi) = self.samples.extent();
        Sizes {
            sensor: self.stated_sensor.unwrap_or(0.0).max(3e-3 * rms).max(1e-12),
            private: 0.01,
            plate: 0.0,
            length: ((hi - lo) / 150.0).max(1e-9),
            scatter: 0.01,
            ..Sizes::NONE
        }
    }

    /// Something like the friction force before any fit: the record, smoothed over a few samples.
    pub(crate) fn crude_scale(&self) -> Vec<f64> {
        const HALF: usize = 8;
        let mut out = vec![0.0; self.samples.len()];
        for run in &self.samples.runs {
            for i in run.clone() {
                let a = i.saturating_sub(HALF).max(run.start);
                let b = (i + HALF + 1).min(run.end);
                out[i] = self.samples.force[a..b].iter().sum::<f64>() / (b - a) as f64;
            }
        }
        out
    }

    /// The noise beneath a fit. `within`: columns (all samples) that may be in the mean as far as runs within are
    /// concerned.
    pub(crate) fn noise(
        &self,
        subset: &Subset,
        fitted: &Fitted,
        jacobian: &DMatrix<f64>,
        within: &DMatrix<f64>,
        search: Search,
    ) -> NoiseModel {
        let kinds = Kinds {
            smooth: true,
            wanders: self.may_wander,
        };
        self.noise_with(subset, fitted, jacobian, within, (search, kinds))
    }

    /// The same from given sizes, of just their kind: with lengths, smoothings and a wander that they have, and no others.
    pub(crate) fn noise_of_their_kind(
        &self,
        subset: &Subset,
        fitted: &Fitted,
        jacobian: &DMatrix<f64>,
        within: &DMatrix<f64>,
        sizes: Sizes,
    ) -> Sizes {
        let own = Kinds {
            smooth: false,
            wanders: self.may_wander && sizes.wander > 0.0,
        };
        let again = (Search::Again(sizes), own);
        self.noise_with(subset, fitted, jacobian, within, again)
            .sizes
    }

    /// `search`: where it begins, and for what it asks beside.
    fn noise_with(
        &self,
        subset: &Subset,
        fitted: &Fitted,
        jacobian: &DMatrix<f64>,
        within: &DMatrix<f64>,
        (search, Kinds { smooth, wanders }): (Search, Kinds),
    ) -> NoiseModel {
        let context = subset.context_of(self, fitted);
        let residual =
            subset.gather(&self.experiment.measured_n) - subset.gather(&fitted.prediction);
        estimate(
            &context,
            &residual,
            &subset.gather_columns(jacobian),
            &subset.gather_columns(within),
            &EstimateOptions {
                stated_sensor: self.stated_sensor,
                repeats: self.repeats(),
                search,
                uncertainty: false,
                smooth,
                wanders,
            },
        )
    }

    /// Jacobian of a fit, all samples, columns of parameters that the subset can move.
    pub(crate) fn jacobian(&self, subset: &Subset, fitted: &Fitted) -> (DMatrix<f64>, Vec<usize>) {
        let free = movable(&fitted.model, subset, self.samples.runs.len());
        let columns: Vec<usize> = (0..free.len()).filter(|&k| free[k]).collect();
        let jacobian = fitted.model.jacobian_beside(
            &self.experiment,
            &fitted.parameters,
            &columns,
            fitted.paths(self),
        );
        (jacobian, columns)
    }
}

//! Law, rig and fitting together.

use campaign::Campaign;
use fitting::criteria::{aicc, t_quantile};
use fitting::noise::{EstimateOptions, NoiseModel, Search};
use fitting::{Bounds, Identifiability, Residuals, Side, Status, Verdict, identifiability};
use friction::{LawKind, ParameterSpec};
use nalgebra::DMatrix;
use rig::{Experiment, Model};

use crate::band::Spread;
use crate::degrees::{Drivers, drivers, plain_drivers};
use crate::features::{Features, features};
use crate::fit::{Fitted, Task, Weighting, Work};
use crate::intervals::{Interval, LEVEL, profiles};
use crate::problem::{Problem, noise_context};
use crate::quality::{Quality, lack_of_fit, repeat_floor, sizes};
use crate::question::{IdentificationError, Question};
use crate::starts::starts;
use crate::thinning::thinned;

/// One parameter of a law or an effect.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// Name, as in files.
    pub name: String,
    /// Unit on this rig.
    pub unit: String,
    /// One line for a reader.
    pub doc: String,
    /// Value.
    pub value: f64,
    /// Standard deviation by the covariance; `None` for held parameters, on a bound, or where the data leave it open.
    pub sd: Option<f64>,
    /// 95 % interval by profile likelihood; `None` for held parameters or where none was asked for.
    pub interval: Option<Interval>,
    /// Whether it was held.
    pub held: bool,
    /// The bound on which it ended.
    pub at_bound: Option<Side>,
    /// What the data say about it at all.
    pub verdict: Verdict,
    /// What drives its uncertainty.
    pub drivers: Option<Drivers>,
}

/// The parameters of a campaign, with what can and cannot be said of them.
#[derive(Clone)]
pub struct Identification {
    /// Name of the campaign.
    pub campaign: String,
    /// The law.
    pub law: LawKind,
    /// Law and effects.
    pub model: Model,
    /// Parameters of law and effects.
    pub estimates: Vec<Estimate>,
    /// All parameters, initial states included, as the model takes them.
    pub parameters: Vec<f64>,
    /// Covariance of all parameters (zero for held ones and on bounds); `None` where the data leave a direction open.
    pub covariance: Option<DMatrix<f64>>,
    /// Change of the parameters of law and effects (rows) a relative gain of each run (columns); no columns where the
    /// record is missed by more than its noise or leaves a direction open.
    pub moved_by_gains: DMatrix<f64>,
    /// How the fit ended.
    pub status: Status,
    /// Noise.
    pub noise: NoiseModel,
    /// Rank and spectrum of the sensitivities of the estimated parameters of law and effects.
    pub identifiability: Identifiability,
    /// Names of the columns of [`Identification::identifiability`].
    pub analysed: Vec<String>,
    /// What weighed the residuals.
    pub weighting: Weighting,
    /// How good the fit is.
    pub quality: Quality,
    /// Log-likelihood of the record under parameters and noise.
    pub log_likelihood: f64,
    /// Akaike's criterion, corrected for few samples; noise sizes count as parameters.
    pub aicc: f64,
    /// Predicted force, N (N m), stacked as in the experiment.
    pub predicted_n: Vec<f64>,
    /// Points of the profiles that gave the intervals, by parameter, in order of value; empty where none was asked for.
    pub profiles: Vec<(String, Vec<fitting::ProfilePoint>)>,
    /// A profile met a point that fits better than the answer: then the answer is no minimum.
    pub better_found: bool,
    /// Work done.
    pub work: Work,
}

impl Identification {
    /// The estimate of that name.
    pub fn estimate(&self, name: &str) -> Option<&Estimate> {
        self.estimates.iter().find(|e| e.name == name)
    }

    /// Value of the parameter of that name.
    pub fn value(&self, name: &str) -> Option<f64> {
        self.estimate(name).map(|e| e.value)
    }

    /// What a prediction with the law's parameters needs to know of their uncertainty and of the noise; `None` where the
    /// data leave a direction open.
    pub fn spread(&self) -> Option<Spread> {
        let count = self.law.parameters().len();
        let covariance = self.covariance.as_ref()?;
        Some(Spread {
            covariance: covariance.view((0, 0), (count, count)).into_owned(),
            moved_by_gains: self.moved_by_gains.rows(0, count).into_owned(),
            sizes: self.noise.sizes,
            scatters: self.noise.scatter.posterior(),
        })
    }

    /// Names of parameters on a bound.
    pub fn at_bound(&self) -> Vec<&str> {
        self.estimates
            .iter()
            .filter(|e| e.at_bound.is_some())
            .map(|e| e.name.as_str())
            .collect()
    }

    /// Names of parameters that the data do not determine.
    pub fn not_identifiable(&self) -> Vec<&str> {
        self.estimates
            .iter()
            .filter(|e| !e.held && e.verdict != Verdict::Identifiable)
            .map(|e| e.name.as_str())
            .collect()
    }
}

/// Bounds of a model's parameters, held ones closed.
fn bounds(specs: &[ParameterSpec], question: &Question) -> Result<Bounds, IdentificationError> {
    let known = || {
        specs
            .iter()
            .map(|s| s.name.as_ref())
            .collect::<Vec<_>>()
            .join(", ")
    };
    let (mut lower, mut upper): (Vec<f64>, Vec<f64>) =
        specs.iter().map(|s| (s.lower, s.upper)).unzip();
    for (name, &value) in &question.fixed {
        let j = specs
            .iter()
            .position(|s| s.name == name.as_str())
            .ok_or_else(|| IdentificationError::UnknownParameter {
                name: name.clone(),
                known: known(),
            })?;
        if !(value >= lower[j] && value <= upper[j]) {
            return Err(IdentificationError::OutOfBounds {
                name: name.clone(),
                value,
                lower: lower[j],
                upper: upper[j],
            });
        }
        (lower[j], upper[j]) = (value, value);
    }
    Bounds::new(lower, upper).map_err(|error| IdentificationError::NoStart(error.to_string()))
}

/// Starts of all parameters: the law's from the data, effects at their null or typical size, bent states from the first
/// recorded force.
fn all_starts(
    question: &Question,
    experiment: &Experiment,
    features: &Features,
    model: &Model,
    bounds: &Bounds,
) -> Vec<Vec<f64>> {
    let law = model.law;
    let specs = model.parameters();
    let count = model.law_parameters();
    let rest = |law_part: &[f64]| -> Vec<f64> {
        let mut start: Vec<f64> = specs.iter().map(|s| s.null.unwrap_or(s.typical)).collect();
        start[..law_part.len()].copy_from_slice(law_part);
        start_states(experiment, model, law_part, &mut start);
        bounds.clamp(&start)
    };
    if let Some(near) = &question.near {
        let law_part: Vec<f64> = specs[..count]
            .iter()
            .map(|s| near.get(s.name.as_ref()).copied().unwrap_or(s.typical))
            .collect();
        let mut start = rest(&law_part);
        for (value, spec) in start.iter_mut().zip(specs) {
            if let Some(&known) = near.get(spec.name.as_ref()) {
                *value = known;
            }
        }
        return vec![bounds.clamp(&start)];
    }
    let lean = question.fixed.get("theta0").copied();
    starts(law, features, experiment.height_m, lean)
        .iter()
        .map(|law_part| rest(law_part))
        .collect()
}

/// The state that the first recorded force implies: mu = sigma0 z, at most the level of the law.
fn start_states(experiment: &Experiment, model: &Model, law_part: &[f64], start: &mut [f64]) {
    let Ok(built) = model.law.build(law_part, experiment.height_m) else {
        return;
    };
    let level = built.curve.at_rest.max(built.curve.kinetic);
    for (k, run) in experiment.runs.iter().enumerate() {
        if let Some(column) = model.initial_state_of(k) {
            let load = run.load_n[0].max(f64::MIN_POSITIVE);
            let y = experiment.measured_n[run.samples.start] / load;
            start[column] = (y / built.stiffness.max(f64::MIN_POSITIVE)).clamp(-level, level);
        }
    }
}

/// Parameters, intervals, noise and fit quality of a campaign.
///
/// # Errors
/// When the campaign cannot be predicted or the question does not fit the model. How the numerics ended is
/// [`Identification::status`].
pub fn identify(
    campaign: &Campaign,
    question: &Question,
) -> Result<Identification, IdentificationError> {
    let experiment = Experiment::new(campaign)?;
    identify_prepared(campaign, &experiment, question)
}

/// As [`identify`], for an experiment that is already prepared from the campaign.
///
/// # Errors
/// As [`identify`].
pub fn identify_prepared(
    campaign: &Campaign,
    experiment: &Experiment,
    question: &Question,
) -> Result<Identification, IdentificationError> {
    let model = question.model(experiment)?;
    let specs = model.parameters();
    if experiment.samples() <= specs.len() {
        return Err(IdentificationError::TooFewSamples {
            samples: experiment.samples(),
            parameters: specs.len(),
        });
    }
    let bounds = bounds(specs, question)?;
    let starts = all_starts(question, experiment, &features(campaign), &model, &bounds);
    let task = Task {
        experiment,
        model: &model,
        bounds: &bounds,
        noise_options: noise_options(campaign),
        noise: question.noise.clone(),
        plain: question.plain,
        floor: repeat_floor(campaign),
    };
    let first = rough_part(campaign, &model, question)?;
    let fitted = task.run(&starts, first.as_ref().map(|(e, m)| (e, m)))?;
    Ok(report(
        campaign, experiment, question, &model, &bounds, fitted,
    ))
}

/// Samples on which starts are compared.
const ROUGH_SAMPLES: usize = 4000;

/// What starts are compared on: the first run of every condition (repeats cost time there and tell nothing), or all runs
/// where they bring parameters of their own, thinned. `None` where there is nothing to leave out.
fn rough_part(
    campaign: &Campaign,
    model: &Model,
    question: &Question,
) -> Result<Option<(Experiment, Model)>, IdentificationError> {
    let mut part = campaign.clone();
    if model.initial_states().is_empty() {
        let mut kept: Vec<usize> = campaign.conditions().iter().map(|c| c[0]).collect();
        kept.sort_unstable();
        part.runs = kept.iter().map(|&k| campaign.runs[k].clone()).collect();
    }
    let part = thinned(&part, ROUGH_SAMPLES);
    let samples = |c: &Campaign| -> usize { c.runs.iter().map(|run| run.time_s.len()).sum() };
    if samples(&part) == samples(campaign) {
        return Ok(None);
    }
    let experiment = Experiment::new(&part)?;
    let model = question.model(&experiment)?;
    Ok(Some((experiment, model)))
}

/// What is known of the noise before any fit.
pub(crate) fn noise_options(campaign: &Campaign) -> EstimateOptions {
    let stated = campaign
        .rig
        .sensor_accuracy_percent_fs
        .zip(campaign.rig.sensor_full_scale_n)
        .map(|(percent, full_scale)| 0.01 * percent * full_scale);
    EstimateOptions {
        stated_sensor: stated,
        repeats: campaign.conditions().iter().any(|c| c.len() > 1),
        search: Search::Scratch,
        uncertainty: false,
        smooth: false,
        wanders: false,
    }
}

/// Sizes of the noise that are estimated: sensor, private, plate, length, scatter.
const NOISE_SIZES: usize = 5;

/// Everything that follows from a fit.
fn report(
    campaign: &Campaign,
    experiment: &Experiment,
    question: &Question,
    model: &Model,
    bounds: &Bounds,
    fitted: Fitted,
) -> Identification {
    let specs = model.parameters();
    let problem = Problem {
        experiment,
        model,
        whitener: Some(&fitted.whitener),
    };
    let named = model.initial_states().start;
    let context = noise_context(experiment, &fitted.predicted);
    let (_, whitened) = problem.jacobian(&fitted.fit.parameters);
    let movable = bounds.movable();
    let driven = match fitted.weighting {
        Weighting::Noise => drivers(
            &context,
            &fitted.whitener,
            &fitted.noise,
            &whitened,
            &movable,
        ),
        Weighting::Plain => plain_drivers(&context, &fitted.fit.residuals, &whitened, &movable),
    };
    // Of parameter j: its drivers, and the step with which its profile begins where the fit gives none.
    let driver_of = |j: usize| {
        let k = movable.iter().position(|&m| m == j)?;
        driven.as_ref().map(|all| all.each[k])
    };
    let profile_options: Vec<(f64, f64)> = (0..specs.len())
        .map(|j| match driver_of(j) {
            Some((driver, sd)) => (driver.quantile, sd),
            None => (t_quantile(LEVEL, f64::INFINITY), 0.1 * specs[j].typical),
        })
        .collect();
    let runs = driven.as_ref().map_or(0, |all| all.moved.ncols());
    let mut moved_by_gains = DMatrix::zeros(named, runs);
    if let Some(all) = &driven {
        for (k, &j) in movable.iter().enumerate().filter(|(_, j)| **j < named) {
            moved_by_gains.set_row(j, &all.moved.row(k));
        }
    }
    let analysed: Vec<usize> = movable.iter().copied().filter(|&j| j < named).collect();
    let found = analyse(
        &whitened,
        &fitted.fit.parameters,
        specs,
        &analysed,
        &movable,
    );
    let columns: Vec<usize> = (0..named).collect();
    let profiled = if question.intervals {
        profiles(&problem, &fitted.fit, bounds, &columns, &profile_options)
    } else {
        vec![None; named]
    };
    let better_found = profiled.iter().flatten().any(|p| p.better.is_some());
    let curves = profiled
        .iter()
        .enumerate()
        .filter_map(|(j, p)| Some((specs[j].name.to_string(), p.as_ref()?.points.clone())))
        .collect();
    let estimates = (0..named)
        .map(|j| {
            let held = bounds.is_fixed(j);
            let at_bound = bounds.side(j, fitted.fit.parameters[j]);
            Estimate {
                name: specs[j].name.to_string(),
                unit: specs[j].unit.to_string(),
                doc: specs[j].doc.to_string(),
                value: fitted.fit.parameters[j],
                sd: fitted
                    .fit
                    .standard_deviation(j)
                    .filter(|_| !held && at_bound.is_none()),
                interval: profiled[j].as_ref().map(|p| Interval {
                    lower: p.lower.clone(),
                    upper: p.upper.clone(),
                }),
                held,
                at_bound,
                verdict: analysed
                    .iter()
                    .position(|&c| c == j)
                    .map_or(Verdict::Identifiable, |k| found.verdicts[k]),
                drivers: driver_of(j).map(|(driver, _)| driver),
            }
        })
        .collect();
    let (rmse, rms) = sizes(experiment, &fitted.predicted);
    let residual = problem.difference(fitted.predicted.clone());
    let testable = question.test_fit && fitted.weighting == Weighting::Noise;
    let lack = testable.then(|| {
        lack_of_fit(
            experiment,
            &context,
            &residual,
            &fitted.jacobian.select_columns(&movable),
            &fitted.noise,
            &noise_options(campaign),
        )
    });
    let n = experiment.samples();
    // log L = -1/2 (|W r|^2 + log det V + n log 2 pi)
    let log_likelihood = -fitted.fit.cost
        - 0.5 * fitted.whitener.log_det()
        - 0.5 * n as f64 * (2.0 * std::f64::consts::PI).ln();
    let quality = Quality {
        rmse,
        rms,
        floor_rmse: repeat_floor(campaign),
        lack_of_fit: lack,
    };
    Identification {
        campaign: campaign.name.clone(),
        law: model.law,
        model: model.clone(),
        estimates,
        parameters: fitted.fit.parameters,
        covariance: fitted.fit.covariance,
        moved_by_gains,
        status: fitted.fit.status,
        noise: fitted.noise,
        identifiability: found,
        weighting: fitted.weighting,
        analysed: analysed
            .iter()
            .map(|&j| specs[j].name.to_string())
            .collect(),
        quality,
        log_likelihood,
        aicc: aicc(log_likelihood, movable.len() + NOISE_SIZES, n),
        predicted_n: fitted.predicted,
        profiles: curves,
        better_found,
        work: fitted.work,
    }
}

/// Identifiability of the named columns, the bent states of runs projected out (they are not asked for).
fn analyse(
    whitened: &DMatrix<f64>,
    parameters: &[f64],
    specs: &[ParameterSpec],
    analysed: &[usize],
    movable: &[usize],
) -> Identifiability {
    let scales: Vec<f64> = analysed
        .iter()
        .map(|&j| {
            if parameters[j] == 0.0 {
                specs[j].typical
            } else {
                parameters[j].abs()
            }
        })
        .collect();
    let nuisance: Vec<usize> = movable
        .iter()
        .copied()
        .filter(|j| !analysed.contains(j))
        .collect();
    let mut kept = whitened.select_columns(analysed);
    if !nuisance.is_empty() {
        let q = whitened.select_columns(&nuisance).qr().q();
        kept -= &q * q.tr_mul(&kept);
    }
    identifiability(&kept, &scales)
}

//! The whole diagnosis in its fixed order: noise, gate, integrity, anatomy, causes, sets, gain, experiments.

use campaign::Campaign;
use friction::LawKind;
use rig::{Experiment, ModelFile};

use crate::anatomy::anatomy;
use crate::answer::{
    Baseline, Diagnosis, Estimate, Evidence, Finding, Hidden, LawFit, Rival, Status, Undecidable,
    Unexplained,
};
use crate::bench::{Bench, Fitted, Stand};
use crate::condense::{Condensed, condense};
use crate::equivalence::{Contest, contest};
use crate::excerpt::Excerpt;
use crate::experiment::{Hypothesis, propose};
use crate::floor;
use crate::gain;
use crate::integrity::{Integrity, Read, inspect};
use crate::intervals;
use crate::laws;
use crate::prepare::bench;
use crate::probability::weight_of_set;
use crate::refusal::{refuse_beaten, take_all_back};
use crate::selection::{
    ALPHA_GENERAL, ALPHA_NAME, Depth, SHAPE_TOLERANCE, Selected, law_alone, select,
};
use crate::subset::Subset;
use crate::tail::equivalent_z;
use crate::ties;
use crate::whole::{Whole, of_all_samples};

/// Selections on a condensed record after the first, each with the rows' errors at what the last one named.
const SECOND_LOOKS: usize = 2;
/// Rows' errors that changed by less than this share of the force are the same.
const ROWS_AGREE: f64 = 1e-3;

/// What the reader asks.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// The law; by default the asymmetric bristle where the specimen has a layout, else LuGre.
    pub law: Option<LawKind>,
    /// A model identified elsewhere: its parameters are fixed (to within their covariance).
    pub model: Option<ModelFile>,
    /// Causes left out of the catalogue (a control: their effects must then be unexplained).
    pub without: Vec<String>,
    /// Leave the gain by folds out.
    pub quick: bool,
}

/// Why no diagnosis can be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DiagnosisError {
    /// The campaign cannot be predicted.
    #[error(transparent)]
    Experiment(#[from] rig::ExperimentError),
    /// The law does not go with the campaign.
    #[error(transparent)]
    Model(#[from] rig::ModelError),
    /// The model file does not go with the question.
    #[error("model file: {0}")]
    ModelFile(String),
    /// The law's prediction is not finite anywhere near the data.
    #[error("law {0} cannot be fitted to this campaign at all: no start gives finite forces")]
    NoFit(&'static str),
}

/// A diagnosis with what pages and model files need beside it.
pub struct Diagnosed {
    /// The answer.
    pub answer: Diagnosis,
    /// The extended model.
    pub extension: ModelFile,
    /// The law alone, fitted to the same runs.
    pub plain: ModelFile,
    /// Curves for figures.
    pub curves: Curves,
}

/// Stacked curves of all runs, in the unit of the record (N or N m).
#[derive(Clone, Debug)]
pub struct Curves {
    /// Samples of each run.
    pub runs: Vec<std::ops::Range<usize>>,
    /// Names of the runs.
    pub names: Vec<String>,
    /// Time in the run, s.
    pub time_s: Vec<f64>,
    /// Velocity, m/s.
    pub velocity_m_s: Vec<f64>,
    /// Recorded force.
    pub measured: Vec<f64>,
    /// Law alone.
    pub law: Vec<f64>,
    /// Law with the named causes.
    pub extended: Vec<f64>,
    /// Half width of the 95 % noise band about a prediction.
    pub band: Vec<f64>,
}

/// Diagnoses a campaign.
///
/// # Errors
/// Where the question does not go with the campaign; everything that the data say, also that they say nothing, is an
/// answer.
pub fn diagnose(campaign: &Campaign, options: &Options) -> Result<Diagnosis, DiagnosisError> {
    Ok(diagnose_fully(campaign, options)?.answer)
}

/// Diagnoses a campaign and keeps the extended model and the curves.
///
/// # Errors
/// As [`diagnose`].
pub fn diagnose_fully(
    whole_campaign: &Campaign,
    options: &Options,
) -> Result<Diagnosed, DiagnosisError> {
    let excerpt = Excerpt::of(whole_campaign);
    let every_run = excerpt
        .as_ref()
        .map(|_| Experiment::new(whole_campaign))
        .transpose()?;
    let campaign = excerpt.as_ref().map_or(whole_campaign, |e| &e.campaign);
    let mut recorded = bench(campaign, options)?;
    if let (Some(excerpt), Some(all)) = (&excerpt, &every_run) {
        excerpt.place(all, &mut recorded.experiment);
    }
    let condensed = condense(campaign, &recorded.samples, &recorded.masked);
    let mut short = condensed.as_ref().map(|c| recorded.condensed(c));
    let no_fit = DiagnosisError::NoFit(recorded.law.id());
    let mut selected = match (&condensed, &mut short) {
        (Some(rows), Some(short)) => select_on_rows(&recorded, rows, short),
        _ => select(&recorded, &Subset::all(&recorded), Depth::Full, None),
    }
    .ok_or(no_fit)?;
    let bench = short.as_ref().unwrap_or(&recorded);
    let subset = selected.subset.clone();
    let integrity = inspect(campaign, selected.stand.sizes.sensor);
    let mut contests: Vec<Contest> = (0..selected.stand.fitted.effects.len())
        .filter_map(|k| contest(bench, &subset, &selected.stand, &selected.first, k))
        .collect();
    if refuse_beaten(bench, &mut selected, &contests) {
        contests.clear();
    }
    let mut whole = Whole::of(&recorded, bench, &selected);
    let unseen = match (&excerpt, &every_run) {
        (Some(excerpt), Some(all)) => {
            Some(excerpt.unseen(whole_campaign, all, &whole.law, &whole.extended))
        }
        _ => None,
    };
    if unseen.is_some_and(|u| u.speaks_against()) {
        take_all_back(bench, &mut selected);
        contests.clear();
        whole = Whole::of(&recorded, bench, &selected);
    }
    let mut answer = assemble(&whole, &selected, &contests, &integrity);
    if let Some(condensed) = &condensed {
        answer.notes.push(condensed.note(&recorded.samples));
    }
    if let Some(unseen) = unseen {
        answer.notes.push(unseen.note());
    }
    if !options.quick {
        complete(bench, &whole, &selected, &contests, &mut answer, options);
    }
    let extension = model_file(&recorded, &selected.stand, &whole.extended);
    let plain = model_file(&recorded, &selected.baseline, &whole.law);
    let curves = curves(&whole, &selected);
    Ok(Diagnosed {
        answer,
        extension,
        plain,
        curves,
    })
}

/// The selection on the rows of a condensed record. What rows make of the law, and then of the named causes, is taken off first:
/// the error of a law at a row's middle is the same in every run and would be named.
fn select_on_rows(
    recorded: &Bench<'_>,
    rows: &Condensed,
    short: &mut Bench<'_>,
) -> Option<Selected> {
    let subset = Subset::all(short);
    let allow = |short: &mut Bench<'_>, fitted: &Fitted| {
        let all = of_all_samples(recorded, fitted).prediction;
        short.allow_for(rows, fitted, &all)
    };
    let law = law_alone(short, &subset, None)?.fitted;
    allow(short, &law);
    let mut selected = select(short, &subset, Depth::Full, None)?;
    for _ in 0..SECOND_LOOKS {
        let named = selected.stand.fitted.effects.clone();
        let moved = allow(short, &selected.stand.fitted);
        if moved < ROWS_AGREE {
            break;
        }
        let warm = selected.warm();
        selected = select(short, &subset, Depth::Full, Some(&warm))?;
        if selected.stand.fitted.effects == named {
            break;
        }
    }
    Some(selected)
}

/// Gain by folds, experiments, ties of the design and the other laws.
fn complete(
    bench: &Bench<'_>,
    whole: &Whole<'_>,
    selected: &Selected,
    contests: &[Contest],
    answer: &mut Diagnosis,
    options: &Options,
) {
    let scatter = selected.stand.ground.likeliest_scatter();
    let ties: Vec<Vec<usize>> = contests.iter().map(Contest::tied).collect();
    if let Some(gains) = gain::judge(bench, whole, selected, &ties, answer.noise_floor.rmse) {
        answer.baseline.held_out_rmse = Some(gains.held_out_law);
        answer.gain = gains.joint;
        for (k, own) in gains.each.into_iter().enumerate() {
            let id = bench.catalogue[selected.stand.fitted.effects[k]].id();
            if let Some(finding) = answer.findings.iter_mut().find(|f| f.cause == id) {
                finding.gain = own;
            }
        }
    }
    for (k, contest) in contests.iter().enumerate() {
        let id = bench.catalogue[selected.stand.fitted.effects[k]].id();
        let Some(opponent) = contest.opponents.iter().find_map(|o| o.fitted.as_ref()) else {
            continue;
        };
        let named = answer.findings.iter_mut().find(|f| f.cause == id);
        let Some(finding) = named.filter(|f| !f.equivalent.is_empty()) else {
            continue;
        };
        let causes: Vec<String> = std::iter::once(finding.cause.clone())
            .chain(finding.equivalent.iter().cloned())
            .collect();
        let text = ties::decisive(&causes, || {
            propose(
                bench,
                &selected.stand.sizes,
                &Hypothesis {
                    effects: &selected.stand.fitted.effects,
                    parameters: &selected.stand.fitted.parameters,
                },
                &Hypothesis {
                    effects: &opponent.effects,
                    parameters: &opponent.parameters,
                },
            )
        });
        answer.undecidable.push(Undecidable {
            causes,
            because: "this campaign's fits cannot tell them apart".into(),
            experiment: text.clone(),
        });
        finding.experiment = Some(text);
    }
    let of_the_design = ties::ties(bench, &selected.baseline, &selected.first, scatter);
    for tie in of_the_design {
        let same = |u: &Undecidable| {
            let held = |id: &String| tie.causes.contains(id);
            u.causes.len() == tie.causes.len() && u.causes.iter().all(held)
        };
        // The named set's own line says it already.
        if !answer.undecidable.iter().any(same) {
            answer.undecidable.push(tie);
        }
    }
    answer.undecidable.extend(ties::lacking(bench));
    if options.model.is_none() {
        answer.laws = laws::compare(bench, whole, selected);
        if let Some(best) = answer.laws.first()
            && best.law != answer.law
        {
            answer.notes.push(format!(
                "law {} fits this campaign better than {} (corrected Akaike criterion lower by {:.0})",
                best.law,
                answer.law,
                answer
                    .laws
                    .iter()
                    .find(|l| l.law == answer.law)
                    .map_or(f64::NAN, |l| l.delta_aicc)
            ));
        }
    }
}

fn assemble(
    whole: &Whole<'_>,
    selected: &Selected,
    contests: &[Contest],
    integrity: &Integrity,
) -> Diagnosis {
    let bench = whole.bench;
    let noise_floor = floor::noise_floor(bench, selected, &whole.extended.prediction, whole.apart);
    let rmse = floor::rmse(bench, &whole.law.prediction, None);
    let mut findings: Vec<Finding> = contests
        .iter()
        .enumerate()
        .map(|(k, contest)| finding(whole, selected, contest, k))
        .collect();
    // Finding order: what saves most comes first.
    findings.sort_by(|a, b| {
        b.evidence
            .delta_log_likelihood
            .total_cmp(&a.evidence.delta_log_likelihood)
    });
    findings.extend(integrity_findings(bench, integrity));
    let gate = selected.gate_log_p < (ALPHA_NAME + ALPHA_GENERAL).ln();
    // What a named cause's shape may be wrong by is no structure of its own.
    let explained = (selected.baseline.deviance - selected.stand.deviance).max(0.0);
    let beyond_shape = selected.stand.fitted.effects.is_empty()
        || selected
            .left
            .excess
            .max(equivalent_z(selected.left.log_p).powi(2))
            > SHAPE_TOLERANCE.powi(2) * explained;
    let detected = gate && beyond_shape && selected.left.log_p < ALPHA_GENERAL.ln();
    let status = if detected {
        Status::Unexplained
    } else if findings.iter().any(|f| !f.equivalent.is_empty()) {
        Status::Ambiguous
    } else if findings.is_empty() {
        Status::Consistent
    } else {
        Status::Explained
    };
    let explainable = if rmse > noise_floor.rmse && status != Status::Consistent {
        1.0 - (noise_floor.rmse / rmse).powi(2)
    } else {
        0.0
    };
    let residual: Vec<f64> = bench
        .samples
        .force
        .iter()
        .zip(&whole.law.prediction)
        .zip(&bench.samples.load)
        .map(|((m, p), n)| {
            if bench.samples.loaded && *n > 0.0 {
                (m - p) / n
            } else {
                m - p
            }
        })
        .collect();
    Diagnosis {
        schema: "bristle/diagnosis/1".into(),
        campaign: bench.campaign.name.clone(),
        law: bench.law.id().into(),
        status,
        baseline: Baseline {
            rmse,
            held_out_rmse: None,
            explainable_fraction: explainable,
        },
        anatomy: anatomy(
            &bench.samples,
            &residual,
            noise_floor.rmse,
            selected.stand.sizes.length,
        ),
        noise_floor,
        findings,
        unexplained: Unexplained {
            detected,
            r#where: if detected {
                selected.left.place.clone()
            } else {
                None
            },
            z: equivalent_z(selected.left.log_p),
        },
        undecidable: Vec::new(),
        laws: Vec::<LawFit>::new(),
        hidden: hidden(bench, selected),
        gain: None,
        notes: notes(whole),
    }
}

/// What a reader should not miss.
fn notes(whole: &Whole<'_>) -> Vec<String> {
    let mut notes = Vec::new();
    if !whole.law.converged {
        notes.push(
            "the fit of the law alone did not converge: not converged: iteration limit".to_owned(),
        );
    }
    if !whole.extended.converged && !whole.extended.effects.is_empty() {
        notes.push("the fit of the extended model did not converge: iteration limit".to_owned());
    }
    let model = &whole.law.model;
    for (spec, value) in model
        .parameters()
        .iter()
        .zip(&whole.law.parameters)
        .take(model.law_parameters())
    {
        if *value <= spec.lower || *value >= spec.upper {
            notes.push(format!(
                "with the law alone, {} runs to its bound ({value:.4})",
                spec.name
            ));
        }
    }
    if whole.bench.samples.temperature.is_none() {
        notes.push(
            "no temperature is recorded: its share of the residual cannot be shown".to_owned(),
        );
    }
    notes
}

/// A named cause as it stands in the answer.
fn finding(whole: &Whole<'_>, selected: &Selected, contest: &Contest, k: usize) -> Finding {
    let bench = whole.bench;
    let own = selected.stand.fitted.effects[k];
    let cause = &bench.catalogue[own];
    let mut equivalent: Vec<String> = contest
        .tied()
        .into_iter()
        .map(|cause| bench.catalogue[cause].id().to_owned())
        .collect();
    equivalent.sort();
    equivalent.dedup();
    let mut rivals: Vec<Rival> = contest
        .opponents
        .iter()
        .map(|o| Rival {
            cause: bench.catalogue[o.cause].id().to_owned(),
            delta: if o.excess_deviance.is_finite() {
                -0.5 * o.excess_deviance
            } else {
                -0.5 * o.separation * o.separation
            },
            separation: Some(o.separation),
        })
        .collect();
    rivals.sort_by(|a, b| b.delta.total_cmp(&a.delta).then(a.cause.cmp(&b.cause)));
    rivals.truncate(8);
    let log_p = selected.entry_log_p.get(k).copied().unwrap_or(0.0);
    Finding {
        cause: cause.id().into(),
        station: cause.station().id().into(),
        probability: weight_of_set(bench, contest, own, &equivalent),
        equivalent,
        parameters: intervals::estimates(bench, &selected.stand, &whole.extended, k),
        gain: None,
        evidence: Evidence {
            delta_log_likelihood: 0.5 * contest.saved,
            z: equivalent_z(log_p),
            rivals,
        },
        experiment: None,
    }
}

/// Findings that the numbers themselves show.
fn integrity_findings(bench: &Bench<'_>, integrity: &Integrity) -> Vec<Finding> {
    let rotary = bench.experiment.axis == campaign::Axis::Rotary;
    let unit = if rotary { "N m" } else { "N" };
    [
        ("force-saturation", "level_n", integrity.saturation),
        ("force-resolution", "step_n", integrity.resolution),
    ]
    .into_iter()
    .filter_map(|(cause, name, value)| {
        let Read { value, half } = value?;
        bench
            .catalogue
            .iter()
            .any(|c| c.id() == cause)
            .then(|| Finding {
                cause: cause.into(),
                station: "sensor".into(),
                equivalent: Vec::new(),
                probability: 0.999,
                parameters: vec![Estimate {
                    name: name.into(),
                    value,
                    ci95: Some([value - half, value + half]),
                    unit: unit.into(),
                }],
                gain: None,
                evidence: Evidence {
                    delta_log_likelihood: 0.0,
                    z: 0.0,
                    rivals: Vec::new(),
                },
                experiment: None,
            })
    })
    .collect()
}

/// How large an effect of each cause could have hidden: the size found with 90 % power.
fn hidden(bench: &Bench<'_>, selected: &Selected) -> Vec<Hidden> {
    let threshold = equivalent_z((ALPHA_NAME / selected.first.asked.max(1) as f64).ln()) + 1.2816;
    selected
        .first
        .candidates
        .iter()
        .map(|c| {
            let cause = &bench.catalogue[c.cause];
            let first = cause.sizes()[0];
            let spec = &cause.parameters_for(&bench.experiment)[first];
            let sd = c.score.sd.first().copied().unwrap_or(f64::INFINITY);
            Hidden {
                cause: cause.id().into(),
                parameter: spec.name.to_string(),
                size: Some(threshold * sd * c.unit).filter(|s| s.is_finite()),
                unit: intervals::unit_on_rig(bench, &spec.unit),
            }
        })
        .collect()
}

/// A fitted model as a file: the parameters of `fitted`, which are as uncertain as the stand says.
fn model_file(bench: &Bench<'_>, stand: &Stand, fitted: &Fitted) -> ModelFile {
    let law = fitted.model.law_parameters();
    let covariance = intervals::covariance(stand);
    let place = |p: usize| stand.columns.iter().position(|&c| c == p);
    let entry = |i: usize, j: usize| match (place(i), place(j), &covariance) {
        (Some(a), Some(b), Some(c)) => c[(a, b)],
        _ => 0.0,
    };
    let sd: Vec<f64> = (0..law).map(|i| entry(i, i).max(0.0).sqrt()).collect();
    let mut file = ModelFile::new(bench.law, &fitted.parameters[..law], Some(&sd));
    let fastest = bench
        .samples
        .velocity
        .iter()
        .fold(0.0_f64, |m, v| m.max(v.abs()));
    file.valid_speed_m_s = Some([0.0, fastest]);
    file.covariance = covariance.as_ref().map(|_| {
        (0..law)
            .map(|i| (0..law).map(|j| entry(i, j)).collect())
            .collect()
    });
    for k in 0..fitted.effects.len() {
        let span = fitted.model.span(k);
        let own: Vec<Vec<f64>> = span
            .clone()
            .map(|i| span.clone().map(|j| entry(i, j)).collect())
            .collect();
        let mut entry = ModelFile::extension_entry(
            bench.catalogue[fitted.effects[k]].as_ref(),
            &fitted.parameters[span],
            covariance.as_ref().map(|_| own.as_slice()),
        );
        for parameter in &mut entry.parameters {
            parameter.unit = intervals::unit_on_rig(bench, &parameter.unit);
        }
        file.extension.push(entry);
    }
    file
}

fn curves(whole: &Whole<'_>, selected: &Selected) -> Curves {
    let bench = whole.bench;
    let s = selected.stand.sizes;
    let relative = s.private.powi(2) + s.plate.powi(2) + s.scatter.powi(2);
    let extended = whole.extended.prediction.clone();
    Curves {
        runs: bench.samples.runs.clone(),
        names: bench.campaign.runs.iter().map(|r| r.name.clone()).collect(),
        time_s: bench.samples.time.clone(),
        velocity_m_s: bench.samples.velocity.clone(),
        measured: bench.samples.force.clone(),
        law: whole.law.prediction.clone(),
        band: extended
            .iter()
            .map(|f| 1.96 * (s.sensor * s.sensor + relative * f * f).sqrt())
            .collect(),
        extended,
    }
}

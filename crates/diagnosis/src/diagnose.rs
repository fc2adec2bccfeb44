//! The whole diagnosis in its fixed order: noise, gate, integrity, anatomy, causes, sets, gain, experiments.

use campaign::Campaign;
use friction::LawKind;
use rig::{Experiment, ModelFile};

use crate::answer::{Diagnosis, Undecidable};
use crate::bench::{Bench, Fitted};
use crate::condense::{Condensed, condense};
use crate::curves::{Curves, curves};
use crate::equivalence::Contest;
use crate::excerpt::Excerpt;
use crate::experiment::{Hypothesis, propose};
use crate::extension::model_file;
use crate::integrity::inspect;
use crate::laws;
use crate::prepare::bench;
use crate::rises::straighter_than_the_law;
use crate::selection::{Depth, Selected, Start, select};
use crate::settled::law_alone;
use crate::subset::Subset;
use crate::ties;
use crate::verdict::Verdict;
use crate::wander::select_with_noise;
use crate::whole::{Whole, of_all_samples};

/// Selections on a condensed record after the first, each with the rows' errors at what the last one named.
const SECOND_LOOKS: usize = 2;
/// Laws whose corrected Akaike criteria differ by less than this fit alike (Burnham and Anderson 2002, 2.6).
const ALIKE: f64 = 2.0;
/// Rows' errors that changed by less than this share of the force are the same.
const ROWS_AGREE: f64 = 1e-3;

/// What a reader is told of a stage that went along the chords of its recorded velocity.
const STRAIGHT: &str = "the force says that the stage's velocity was straight between its samples, and not as smooth as these look";

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
    /// Who is told how far a diagnosis has come, in a few words each time.
    pub told: Option<fn(&str)>,
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
    let mut every_run = excerpt
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
    let mut straight = None;
    let selected = match (&condensed, &mut short) {
        (Some(rows), Some(short)) => select_on_rows(&recorded, rows, short),
        _ => select_with_noise(&mut recorded).map(|chosen| {
            straight = chosen.straight;
            chosen.selected
        }),
    }
    .ok_or(no_fit)?;
    let went_straight = straight.is_some();
    if let Some(straight) = straight {
        every_run = every_run.map(|all| all.moving_as(&straight.experiment));
        recorded = straight;
    }
    let bench = short.as_ref().unwrap_or(&recorded);
    let integrity = inspect(campaign, selected.stand.sizes.sensor);
    let mut verdict = Verdict::of(&recorded, bench, selected, &integrity);
    let unseen = match (&excerpt, &every_run) {
        (Some(excerpt), Some(all)) => {
            let whole = &verdict.whole;
            Some(excerpt.unseen(whole_campaign, all, &whole.stated, &whole.extended))
        }
        _ => None,
    };
    if unseen.is_some_and(|u| u.speaks_against()) {
        verdict.take_all_back();
    }
    let (gains, taken) = if options.quick {
        (None, None)
    } else {
        verdict.hold_against_unseen_runs()
    };
    let mut answer = verdict.answer();
    let Verdict {
        selected,
        contests,
        whole,
        ..
    } = verdict;
    answer.notes.extend(taken);
    if answer.unexplained.detected {
        answer.notes.extend(straighter_than_the_law(&whole));
    }
    if went_straight {
        answer.notes.push(STRAIGHT.into());
    }
    if let Some(condensed) = &condensed {
        answer.notes.push(condensed.note(&recorded.samples));
    }
    if let Some(unseen) = unseen {
        answer.notes.push(unseen.note());
    }
    if !options.quick {
        if let Some(gains) = gains {
            gains.enter(bench, &selected, &mut answer);
        }
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
    let law = law_alone(short, &subset, Start::Scratch)?.fitted;
    allow(short, &law);
    let mut selected = select(short, &subset, Depth::Full, Start::Scratch)?;
    for _ in 0..SECOND_LOOKS {
        let named = selected.stand.fitted.effects.clone();
        // Beside the law alone the rows were looked at first: what was found then has not stood.
        if named.is_empty() || allow(short, &selected.stand.fitted) < ROWS_AGREE {
            break;
        }
        let warm = selected.warm();
        selected = select(short, &subset, Depth::Full, Start::Near(&warm))?;
        if selected.stand.fitted.effects == named {
            break;
        }
    }
    Some(selected)
}

/// Experiments, ties of the design and the other laws.
fn complete(
    bench: &Bench<'_>,
    whole: &Whole<'_>,
    selected: &Selected,
    contests: &[Contest],
    answer: &mut Diagnosis,
    options: &Options,
) {
    let scatter = selected.stand.ground.likeliest_scatter();
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
    let of_the_design = ties::ties_beside(bench, &selected.subset, &selected.baseline, scatter);
    for tie in of_the_design {
        let same = |u: &Undecidable| {
            let held = |id: &String| tie.causes.contains(id);
            u.causes.len() == tie.causes.len() && u.causes.iter().all(held)
        };
        // Signatures that are one for small effects may differ at the size of this one: a cause named without its rivals is decided.
        let decided = answer.findings.iter().any(|f| {
            let rival = |id: &String| f.equivalent.contains(id);
            tie.causes.contains(&f.cause) && !tie.causes.iter().any(rival)
        });
        // The named set's own line says it already.
        if !decided && !answer.undecidable.iter().any(same) {
            answer.undecidable.push(tie);
        }
    }
    answer.undecidable.extend(ties::lacking(bench));
    if options.model.is_none() {
        bench.tell(|| "fitting the other laws".to_owned());
        answer.laws = laws::compare(bench, whole, selected);
        let own = answer.laws.iter().find(|l| l.law == answer.law);
        let behind = own.map_or(f64::NAN, |l| l.delta_aicc);
        if let Some(best) = answer.laws.first()
            && best.law != answer.law
            && !(behind <= ALIKE)
        {
            answer.notes.push(format!(
                "law {} fits this campaign better than {} (corrected Akaike criterion lower by {:.0})",
                best.law,
                answer.law,
                behind
            ));
        }
    }
}

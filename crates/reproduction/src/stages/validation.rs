//! The 3x3 brush predicted with the parameters of the 2x2 brush: nothing is refitted.
//!
//! Prediction and band come from the parameters, their covariance and the noise that the 2x2 campaign gave; the error
//! is set beside what the 3x3 repeats scatter among themselves. What the model itself asks for is tried as well: with
//! sigma0 = k/(N h), and k by the number of brushes, another brush and load mean another sigma0 (C16).

use friction::LawKind;
use identification::{Band, Question, Spread, identify, prediction_band, repeat_floor};
use report::figure::{self, Axis, Figure, LinePlot, Provenance};
use report::{Block, Cell, Column, Evidence, NoticeKind, Section, Table, Value};
use rig::{Experiment, Model, ModelFile};

use super::friction_curves::{
    DIRECTIONS, coefficient_against_speed, relative_error, runs_in, speed_series,
};
use super::identification::spread::Kept;
use super::identification::{choices, failed};
use crate::multiverse::Worlds;
use crate::stage::{Needs, Stage, StageContext, StageError, StageOutput};

/// The stage.
pub(super) struct Validation;

const CAMPAIGN: &str = "brush-3x3-aluminium";
const STEM: &str = "validation.brush-3x3";

/// The 2x2 brush as identified: law, parameters, and how uncertain they are where the data bound them.
struct Source {
    parameters: Vec<f64>,
    spread: Option<Spread>,
}

fn source(context: &StageContext<'_>) -> Result<Source, StageError> {
    let earlier = context.earlier("identification")?;
    let file = earlier
        .artefacts
        .get("model.aluminium")
        .ok_or_else(|| StageError::Failed("identification left no model.aluminium".into()))?;
    let file: ModelFile = serde_json::from_value(file.clone()).map_err(failed)?;
    let spread = earlier
        .artefacts
        .get("spread.aluminium")
        .map(|kept| serde_json::from_value::<Kept>(kept.clone()))
        .transpose()
        .map_err(failed)?;
    Ok(Source {
        parameters: file.law_values().map_err(StageError::Failed)?,
        spread: spread.map(Spread::from),
    })
}

/// The error of the prediction under every combination of choices that the identification made.
fn worlds(
    context: &StageContext<'_>,
    campaign: &campaign::Campaign,
    experiment: &Experiment,
) -> Result<Worlds, StageError> {
    let kept = context
        .earlier("identification")?
        .artefacts
        .get("choices.aluminium")
        .ok_or_else(|| StageError::Failed("identification left no choices.aluminium".into()))?;
    let all: Vec<choices::Choice> = serde_json::from_value(kept.clone()).map_err(failed)?;
    choices::errors(STEM, &all, campaign, experiment)
}

impl Stage for Validation {
    fn id(&self) -> &'static str {
        "validation"
    }

    fn title(&self) -> &'static str {
        "the 3x3 brush predicted with the 2x2's parameters"
    }

    fn needs(&self) -> Needs {
        Needs {
            campaigns: &[CAMPAIGN],
            stages: &["identification"],
            model: false,
        }
    }

    fn run(&self, context: &StageContext<'_>) -> Result<StageOutput, StageError> {
        let campaign = context.campaign(CAMPAIGN)?;
        let evidence = crate::evidence_of(campaign.provenance);
        let experiment = Experiment::new(&campaign).map_err(failed)?;
        let source = source(context)?;
        let model =
            Model::new(LawKind::AsymmetricBristle, Vec::new(), &experiment).map_err(failed)?;
        let force_n = model.predict(&experiment, &source.parameters);
        let band = source
            .spread
            .as_ref()
            .map(|spread| prediction_band(&experiment, &model, &source.parameters, spread));

        let mut output = StageOutput::done();
        let mut add = |part: &str, number: f64, unit: &str| {
            let id = format!("{STEM}.{part}");
            output
                .values
                .push(Value::new(id, number, unit, "validation", evidence));
        };
        for (direction, word, _) in DIRECTIONS {
            let error = relative_error(&campaign, &experiment, &force_n, direction);
            add(&format!("nrmse_{word}"), error.unwrap_or(f64::NAN), "1");
        }
        add("rmse", rmse(&experiment, &force_n), "1");
        add(
            "floor_rmse",
            repeat_floor(&campaign).unwrap_or(f64::NAN),
            "1",
        );
        let inside = band.as_ref().map(|band| band.share_inside(&experiment));
        add("inside_band", inside.unwrap_or(f64::NAN), "1");

        let hypotheses = hypotheses(context, &experiment, &model, &source)?;
        for one in &hypotheses {
            add(&format!("{}.sigma0", one.id), one.sigma0, "1/rad");
            add(&format!("{}.rmse", one.id), one.rmse, "1");
        }
        let asked = ask_for_stiffness(&campaign, &source)?;
        let mut own = Value::new(
            format!("{STEM}.sigma0"),
            asked.0,
            "1/rad",
            "validation",
            evidence,
        );
        if let Some((low, high)) = asked.1 {
            own = own.with_ci95(low, high);
        }
        output.values.push(own);
        let worlds = worlds(context, &campaign, &experiment)?;
        output
            .artefacts
            .extend([worlds.artefact("C03").map_err(failed)?]);
        output.sections = vec![section(
            &campaign,
            &experiment,
            &force_n,
            band.as_ref(),
            &hypotheses,
            evidence,
        )];
        Ok(output)
    }
}

fn rmse(experiment: &Experiment, force_n: &[f64]) -> f64 {
    let (mut sum, mut count) = (0.0, 0_usize);
    for run in &experiment.runs {
        for (i, load) in run.samples.clone().zip(&run.load_n) {
            if *load > 0.0 {
                sum += ((force_n[i] - experiment.measured_n[i]) / load).powi(2);
                count += 1;
            }
        }
    }
    (sum / count.max(1) as f64).sqrt()
}

/// A reading of what happens to sigma0 when the brush changes.
struct Hypothesis {
    id: &'static str,
    words: String,
    sigma0: f64,
    rmse: f64,
}

/// sigma0 = k/(N h): kept as the paper does, or by the number of brushes and the load.
fn hypotheses(
    context: &StageContext<'_>,
    experiment: &Experiment,
    model: &Model,
    source: &Source,
) -> Result<Vec<Hypothesis>, StageError> {
    let published = |id: &str| context.published.value(id);
    let four = published("brush.count_2x2")?;
    let load_ratio = published("brush.mass_2x2")? / published("brush.mass_3x3")?;
    let six = published("brush.count_3x3")?;
    let nine = published("brush.layout_3x3")?;
    let column = LawKind::AsymmetricBristle
        .parameters()
        .iter()
        .position(|p| p.name == "sigma0")
        .ok_or_else(|| StageError::Failed("the law has no sigma0".into()))?;
    let by_count = |count: f64| count / four * load_ratio;
    Ok([
        ("kept", "kept, as the paper does".to_owned(), 1.0),
        (
            "stated_brushes",
            format!("k by the stated number of brushes ({six:.0})"),
            by_count(six),
        ),
        (
            "nine_brushes",
            format!("k by the places of the layout ({nine:.0})"),
            by_count(nine),
        ),
    ]
    .into_iter()
    .map(|(id, words, factor)| {
        let mut parameters = source.parameters.clone();
        parameters[column] *= factor;
        let force = model.predict(experiment, &parameters);
        Hypothesis {
            id,
            words,
            sigma0: parameters[column],
            rmse: rmse(experiment, &force),
        }
    })
    .collect())
}

/// The sigma0 that the 3x3 records ask for, everything else held at the 2x2's values.
#[allow(clippy::type_complexity)]
fn ask_for_stiffness(
    campaign: &campaign::Campaign,
    source: &Source,
) -> Result<(f64, Option<(f64, f64)>), StageError> {
    let mut question = Question::of(LawKind::AsymmetricBristle);
    question.test_fit = false;
    for (spec, value) in LawKind::AsymmetricBristle
        .parameters()
        .iter()
        .zip(&source.parameters)
    {
        if spec.name != "sigma0" {
            question = question.holding(&spec.name, *value);
        }
    }
    let found = identify(campaign, &question).map_err(failed)?;
    let estimate = found
        .estimate("sigma0")
        .ok_or_else(|| StageError::Failed("the law has no sigma0".into()))?;
    let interval = estimate.interval.as_ref().map(|i| (i.low(), i.high()));
    Ok((estimate.value, interval))
}

fn section(
    campaign: &campaign::Campaign,
    experiment: &Experiment,
    force_n: &[f64],
    band: Option<&Band>,
    hypotheses: &[Hypothesis],
    evidence: Evidence,
) -> Section {
    let mut blocks = Vec::new();
    if evidence == Evidence::Synthetic {
        blocks.push(Block::notice(
            NoticeKind::Synthetic,
            "Stand-in data",
            "The 3x3 records are made from Table 1 as well, with another load, seed and scatter: the prediction must succeed. What is shown is how a reader's own records would be judged.",
        ));
    }
    blocks.push(figure(campaign, experiment, force_n, band, evidence).into());
    blocks.push(Block::prose(format!(
        "Error over the mean coefficient: {{{{ v(\"{STEM}.nrmse_forward\") }}}} forward, {{{{ v(\"{STEM}.nrmse_reverse\") }}}} in reverse. In the coefficient it is {{{{ v(\"{STEM}.rmse\") }}}}, beside {{{{ v(\"{STEM}.floor_rmse\") }}}} by which the repeats scatter among themselves; {{{{ n(\"{STEM}.inside_band\") }}}} of all samples lie inside the band."
    )));
    blocks.push(table(hypotheses, evidence).into());
    blocks.push(Block::notice(
        NoticeKind::Caution,
        "Six brushes or nine, and which stiffness",
        format!("$\\sigma_0 = k/(N h)$ contains the load, and $k$ the number of bristles. Keeping Table 1 for another brush is an assumption, not a consequence of the model. With all else held, these records ask for $\\sigma_0$ = {{{{ ci(\"{STEM}.sigma0\") }}}}; the readings by number of brushes predict {{{{ v(\"{STEM}.stated_brushes.sigma0\") }}}} and {{{{ v(\"{STEM}.nine_brushes.sigma0\") }}}}. The slope over the first millimetres of one measured 3x3 run would decide."),
    ));
    Section {
        id: "validation".into(),
        title: "Validation: the 3x3 brush, predicted".into(),
        lead: format!("With the parameters of the 2x2 brush and nothing refitted, the records of the 3x3 brush are predicted with an error of {{{{ v(\"{STEM}.nrmse_forward\") }}}} of the mean coefficient forward and {{{{ v(\"{STEM}.nrmse_reverse\") }}}} in reverse.").into(),
        method: Some("The motions of the 3x3 runs, the parameters and their covariance from the 2x2 campaign, the loads as recorded. The band holds 95 % of the samples of new runs, as a mean over campaigns: uncertainty of the parameters, roughness and sensor noise as the 2x2 campaign gave them, and the scatter between runs over all that its six runs leave possible. The gains of a few runs move all their samples together, so that one campaign may lie inside as a whole.".into()),
        status: None,
        claims: ["C03", "C16", "C20"].map(String::from).to_vec(),
        blocks,
    }
}

fn figure(
    campaign: &campaign::Campaign,
    experiment: &Experiment,
    force_n: &[f64],
    band: Option<&Band>,
    evidence: Evidence,
) -> Figure {
    let mut plot = LinePlot::new(
        Axis::new("speed", "mm/s"),
        Axis::new("coefficient of friction", "1"),
        speed_series(campaign, experiment, force_n),
    );
    for (direction, word, ink) in DIRECTIONS {
        let (Some(&run), Some(band)) = (runs_in(campaign, direction).first(), band) else {
            continue;
        };
        let wide = |sign: f64| -> Vec<f64> {
            band.force_n
                .iter()
                .zip(&band.half_width_n)
                .map(|(f, half)| f + sign * half * f.signum())
                .collect()
        };
        let low = coefficient_against_speed(experiment, run, Some(&wide(-1.0)));
        let high = coefficient_against_speed(experiment, run, Some(&wide(1.0)));
        plot.bands.push(figure::Band {
            label: format!("{word}, 95 % of a new run"),
            points: low
                .iter()
                .zip(&high)
                .map(|(l, h)| [l[0], l[1], h[1]])
                .collect(),
            ink,
        });
    }
    let mut made = Provenance::here("validation", "prediction_band");
    for (path, hash) in &campaign.input_hashes {
        made = made.with_input(format!("{}/{path}", campaign.name), hash.clone());
    }
    let synthetic = if evidence == Evidence::Synthetic {
        " Synthetic stand-in data."
    } else {
        ""
    };
    Figure::new(
        "validation-mu-speed",
        "The 3x3 brush, predicted with the parameters of the 2x2 brush",
        format!("Lines and bands know nothing of the dots.{synthetic}"),
        evidence,
        plot,
        made,
    )
    .with_paper("Fig. 8")
    .with_paper_limits(
        [0.0, 60.0],
        [0.0, 1.2],
        "0 to 60 mm/s: the range of the protocol; the other axis is ours",
    )
    .with_claims(&["C03", "C16"])
}

fn table(hypotheses: &[Hypothesis], evidence: Evidence) -> Table {
    Table {
        id: "validation-stiffness".into(),
        title: "What the model asks of σ₀ for another brush".into(),
        caption: "Prediction of the 3x3 records under three readings of $\\sigma_0 = k/(N h)$, nothing refitted.".into(),
        columns: vec![
            Column::text("reading"),
            Column::number("$\\sigma_0$", "1/rad"),
            Column::number("error", "1"),
        ],
        rows: hypotheses
            .iter()
            .map(|one| {
                vec![
                    Cell::Text(one.words.clone()),
                    Cell::Value(format!("{STEM}.{}.sigma0", one.id)),
                    Cell::Value(format!("{STEM}.{}.rmse", one.id)),
                ]
            })
            .collect(),
        evidence: Some(evidence),
        provenance: Some(Provenance::here("validation", "hypotheses")),
        claims: ["C03", "C16", "C20"].map(String::from).to_vec(),
        ..Table::default()
    }
}

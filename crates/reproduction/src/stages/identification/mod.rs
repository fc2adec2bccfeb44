//! Parameters of the asymmetric bristle law from the campaigns on three counterfaces, and what of them can be known.

pub(crate) mod choices;
mod cord;
pub(super) mod figures;
mod relative;
pub(crate) mod spread;
mod tables;
mod values;

use std::sync::Arc;

use campaign::Campaign;
use friction::LawKind;
use identification::{
    Identification as Found, LawFit, PaperForm, Question, compare_laws, identify, in_paper_form,
    least_sd, resample_runs,
};
use rayon::prelude::*;
use report::{Block, Evidence, NoticeKind, Section};
use rig::{Experiment, ModelFile};

use crate::stage::{Needs, Stage, StageContext, StageError, StageOutput, StageStatus};

/// The stage.
pub(super) struct Identification;

/// Counterfaces and their campaigns.
pub(super) const MATERIALS: [(&str, &str); 3] = [
    ("aluminium", "brush-2x2-aluminium"),
    ("nylon", "brush-2x2-nylon"),
    ("ceramic", "brush-2x2-ceramic"),
];
/// The 2x2 brush on aluminium, measured through the cord.
const CORDED: &str = "brush-2x2-aluminium-cord";
/// Seed and number of draws of the bootstrap over runs.
const BOOTSTRAP: (u64, usize) = (20_240_101, 999);

/// One identified campaign.
pub(super) struct Identified {
    pub(super) material: &'static str,
    pub(super) campaign: Arc<Campaign>,
    pub(super) experiment: Experiment,
    pub(super) found: Found,
    pub(super) bootstrap: Option<fitting::Bootstrap>,
    pub(super) evidence: Evidence,
    /// The least standard deviations that its records allow under the estimated noise.
    least_sd: Option<Vec<f64>>,
}

/// The law with theta0 held at one of the leans that the published steady coefficients ask for.
pub(super) struct HeldLean {
    pub(super) reading: &'static str,
    pub(super) found: Found,
}

/// Readings of "steady" in the table of leans, by the ids of the audit.
const LEANS: [(&str, &str); 4] = [
    (
        "cosine on all terms, mean from 10 to 60 mm/s",
        "audit.lean.all_terms.mean.joint",
    ),
    (
        "cosine on all terms, at 60 mm/s",
        "audit.lean.all_terms.top.joint",
    ),
    (
        "cosine on the stiffness term, mean from 10 to 60 mm/s",
        "audit.lean.stiffness_only.mean.joint",
    ),
    (
        "cosine on the stiffness term, at 60 mm/s",
        "audit.lean.stiffness_only.top.joint",
    ),
];

pub(super) fn failed(error: impl std::fmt::Display) -> StageError {
    StageError::Failed(error.to_string())
}

fn identified(
    context: &StageContext<'_>,
    material: &'static str,
    name: &str,
) -> Result<Identified, StageError> {
    let campaign = context.campaign(name)?;
    let question = Question::of(LawKind::AsymmetricBristle);
    let found = identify(&campaign, &question).map_err(failed)?;
    let (seed, draws) = BOOTSTRAP;
    let values: Vec<f64> = found.estimates.iter().map(|e| e.value).collect();
    let least_sd = least_sd(&campaign, found.law, &values, &found.noise.sizes).map_err(failed)?;
    Ok(Identified {
        material,
        experiment: Experiment::new(&campaign).map_err(failed)?,
        bootstrap: resample_runs(&campaign, &found, draws, seed).ok(),
        evidence: crate::evidence_of(campaign.provenance),
        campaign,
        found,
        least_sd,
    })
}

fn held_leans(
    context: &StageContext<'_>,
    aluminium: &Identified,
) -> Result<Vec<HeldLean>, StageError> {
    let audit = context.earlier("audit")?;
    LEANS
        .par_iter()
        .filter_map(|(reading, id)| audit.value(id).map(|lean| (*reading, lean)))
        .map(|(reading, lean)| {
            let mut question = Question::of(LawKind::AsymmetricBristle)
                .holding("theta0", lean)
                .near(&aluminium.found);
            if reading.contains("stiffness term") {
                question.placement = friction::CosinePlacement::StiffnessOnly;
            }
            question.intervals = false;
            let found = identify(&aluminium.campaign, &question).map_err(failed)?;
            Ok(HeldLean { reading, found })
        })
        .collect()
}

/// The scale of sigma at which the ray is shown: the printed one, so that the figure lies on Table 1's axes. Any other
/// value gives the same curves.
fn ray(context: &StageContext<'_>, aluminium: &Identified) -> Result<PaperForm, StageError> {
    let sigma = context.published.value("table1.sigma")?;
    let factors: Vec<f64> = (-8..=8)
        .map(|k| 10_f64.powf(0.125 * f64::from(k)))
        .collect();
    in_paper_form(&aluminium.campaign, &aluminium.found, sigma, &factors).map_err(failed)
}

impl Stage for Identification {
    fn id(&self) -> &'static str {
        "identification"
    }

    fn title(&self) -> &'static str {
        "parameters of the law from the force records"
    }

    fn needs(&self) -> Needs {
        Needs {
            campaigns: &[
                "brush-2x2-aluminium",
                "brush-2x2-nylon",
                "brush-2x2-ceramic",
                CORDED,
            ],
            stages: &["audit"],
            model: false,
        }
    }

    fn run(&self, context: &StageContext<'_>) -> Result<StageOutput, StageError> {
        context.say("fitting three counterfaces");
        let materials = MATERIALS
            .par_iter()
            .map(|(material, name)| identified(context, material, name))
            .collect::<Result<Vec<_>, _>>()?;
        let aluminium = &materials[0];
        context.say("setting seven laws side by side");
        let laws = compare_laws(&aluminium.campaign, &aluminium.found);
        context.say("holding the lean, following the scale ray");
        let leans = held_leans(context, aluminium)?;
        let paper = ray(context, aluminium)?;
        context.say("fitting under every combination of open choices");
        let [choices, nylon, ceramic] = [0, 1, 2].map(|k| choices::all(context, &materials[k]));
        let (choices, nylon, ceramic) = (choices?, nylon?, ceramic?);
        context.say("assuming cords of many stiffnesses");
        let corded = context.campaign(CORDED)?;
        let sweep = cord::sweep(&corded, context.quick)?;

        let mut output = StageOutput::done();
        output.status = status(&materials, &laws);
        output.values = values::all(context, &materials, &laws, &paper)?;
        output.values.extend(sweep.values());
        for one in &materials {
            for (key, count) in [
                ("iterations", one.found.work.iterations),
                ("jacobians", one.found.work.jacobians),
                ("starts-agreeing", one.found.work.agreeing as u64),
            ] {
                output.work.insert(format!("{}.{key}", one.material), count);
            }
            let model = serde_json::to_value(model_file(&one.found)).map_err(failed)?;
            output
                .artefacts
                .insert(format!("model.{}", one.material), model);
            if let Some(spread) = one.found.spread() {
                let kept = spread::Kept::from(&spread);
                output.artefacts.insert(
                    format!("spread.{}", one.material),
                    serde_json::to_value(kept).map_err(failed)?,
                );
            }
        }
        let kept: Vec<choices::Choice> = choices.iter().map(|one| one.choice.clone()).collect();
        let (campaign, experiment) = (&aluminium.campaign, &aluminium.experiment);
        let errors = choices::errors("identification.aluminium", &kept, campaign, experiment)?;
        for (claim, worlds) in [
            ("C01", choices::parameters("aluminium", &choices)),
            ("C02", errors),
            (
                "C06",
                choices::parameters("nylon", &nylon)
                    .beside(choices::parameters("ceramic", &ceramic)),
            ),
        ] {
            output
                .artefacts
                .extend([worlds.artefact(claim).map_err(failed)?]);
        }
        output.artefacts.insert(
            "choices.aluminium".to_owned(),
            serde_json::to_value(kept).map_err(failed)?,
        );
        output.sections = vec![section(&materials, &laws, &leans, &paper, &sweep)];
        Ok(output)
    }
}

/// Parameters and covariance as a model file.
pub(crate) fn model_file(found: &Found) -> ModelFile {
    let count = found.law.parameters().len();
    let values: Vec<f64> = found.estimates[..count].iter().map(|e| e.value).collect();
    let sd: Vec<f64> = found.estimates[..count]
        .iter()
        .map(|e| e.sd.unwrap_or(0.0))
        .collect();
    let mut file = ModelFile::new(found.law, &values, Some(&sd));
    file.covariance = found.covariance.as_ref().map(|c| {
        (0..count)
            .map(|i| (0..count).map(|j| c[(i, j)]).collect())
            .collect()
    });
    file
}

fn status(materials: &[Identified], laws: &[LawFit]) -> StageStatus {
    let mut names: Vec<String> = materials
        .iter()
        .filter(|one| !one.found.status.converged())
        .map(|one| format!("{}: {}", one.material, one.found.status))
        .collect();
    for law in laws {
        match &law.identification {
            Ok(found) if !found.status.converged() => {
                names.push(format!("law {}: {}", law.law.id(), found.status));
            }
            Err(error) => names.push(format!("law {}: {error}", law.law.id())),
            Ok(_) => {}
        }
    }
    if names.is_empty() {
        StageStatus::Done
    } else {
        StageStatus::NotConverged(names.join("; "))
    }
}

fn section(
    materials: &[Identified],
    laws: &[LawFit],
    leans: &[HeldLean],
    paper: &PaperForm,
    sweep: &cord::Sweep,
) -> Section {
    let aluminium = &materials[0];
    let mut blocks = Vec::new();
    if materials
        .iter()
        .any(|one| one.evidence == Evidence::Synthetic)
    {
        blocks.push(Block::notice(
            NoticeKind::Synthetic,
            "Stand-in data",
            "The measurements are not published. These records were made from the printed parameters, the printed protocol and stated imperfections: getting the parameters back shows that the procedure works, not that the brush does.",
        ));
    }
    blocks.extend([
        Block::heading("identification-fit", "The fit"),
        figures::force_against_time(aluminium).into(),
        figures::coefficient_against_speed(aluminium).into(),
        figures::residual(aluminium).into(),
        tables::parameters(aluminium).into(),
        Block::prose(FIT_WORDS),
        tables::counterfaces(materials).into(),
        tables::widths(materials).into(),
        tables::noise(materials).into(),
        Block::heading("identification-known", "What the data determine"),
        figures::profiles(aluminium).into(),
        figures::ray(aluminium, paper).into(),
        figures::spectrum(aluminium, paper).into(),
        Block::notice(NoticeKind::Finding, "Seven numbers, six facts", RAY_WORDS),
        tables::held_leans(aluminium, leans).into(),
        Block::prose(LEAN_WORDS),
        Block::heading("identification-cord", "The cord"),
        sweep.figure().into(),
        sweep.table().into(),
        Block::prose(sweep.words()),
        Block::heading("identification-laws", "All laws on the same data"),
        tables::laws(aluminium, laws).into(),
        Block::prose(LAWS_WORDS),
    ]);
    Section {
        id: "identification".into(),
        title: "Identification: the law's parameters from force records".into(),
        lead: "From three ramps each way the bristle angle comes out as $\\theta_c/\\sigma$ = {{ ci(\"identification.aluminium.theta_c_over_sigma\") }}, the stiffness as $\\sigma_0$ = {{ ci(\"identification.aluminium.sigma0\") }} and the lean, left free, as {{ ci(\"identification.aluminium.theta0\") }}. $\\sigma$, $\\theta_c$ and $\\theta_s$ by themselves cannot be identified from any record.".into(),
        method: Some(METHOD.into()),
        status: None,
        claims: ["C01", "C02", "C04", "C06", "C17", "C18", "C19", "C21"]
            .map(String::from)
            .to_vec(),
        blocks,
    }
}

const METHOD: &str = "Bounded Levenberg-Marquardt on exact derivatives, from starts that are read off the record (plateaus, the stretch before sliding), never from printed values. Residuals are whitened with a noise that is estimated from the same record by restricted likelihood: sensor noise, friction roughness correlated in sliding distance, a part of it fixed to the plate, and a gain that differs from run to run. Intervals are profile likelihoods at the quantile of the noise that drives each parameter: wide for what hangs on the gains of six runs, near the normal one for what hangs on the shape within a run (a mixture of normals over the posterior of the scatter, Behrens-Fisher).";

const FIT_WORDS: &str = "Residual in all runs: {{ v(\"identification.aluminium.rmse\") }} of the coefficient; the repeats scatter by {{ v(\"identification.aluminium.floor_rmse\") }} among themselves. A test for smooth structure that all runs share gives p = {{ n(\"identification.aluminium.lack_of_fit_p\") }}: below 0.01 the law would be found wanting. On a run left out of the fit the error is {{ v(\"identification.laws.asymmetric-bristle.held_out_rmse\") }}.";

const RAY_WORDS: &str = "E3 holds $\\sigma$, $\\theta_c$, $\\theta_s$ only in the ratios $\\theta_c/\\sigma$ and $\\theta_s/\\sigma$. Multiplied by any common factor they change no force: over two decades of that factor twice the log-likelihood moves by {{ n(\"identification.paper_form.ray_deviance\") }}, while 6 % on $\\sigma_0$ moves it by {{ n(\"identification.paper_form.contrast_deviance\") }}. The sensitivities have rank {{ n(\"identification.paper_form.rank\") }} for {{ n(\"identification.paper_form.parameters\") }} parameters. Table 1's $\\sigma$ is therefore no property of the brush: an optimiser leaves it near where it began. Only the ratios may be compared with a measurement, or carried to a robot.";

const LEAN_WORDS: &str = "The paper measured the lean and does not print it. Held at what its steady coefficients ask for ([table of leans](#lean-brackets)), the other parameters move: $\\sigma_0$ and $\\theta_0$ share the factor $\\cos^2(\\theta+\\theta_0)$, and an error in one is paid by the other. With both directions in the record the lean is identifiable; with one direction it would not be.";

const LAWS_WORDS: &str = "Only a law with a lean can give two levels of friction in two directions; every other law here returns the mean of both and pays for it on held-out runs. Akaike's criterion counts the noise's own parameters, because a law that misses the record drives them up.";

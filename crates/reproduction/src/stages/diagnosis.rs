//! What the simulation gets wrong on every campaign, why, and what the extended model gains.
//!
//! The campaign behind the elastic cord is the instructive one: a plain fit looks good there and its parameters are
//! wrong. The stage shows both fits side by side, and the law's parameters with the cord taken into account.

use std::collections::BTreeMap;

use diagnosis::{Diagnosed, Options, diagnose_fully};
use report::{Block, Cell, Column, Evidence, Section, Table, Value, typeset};
use rig::ModelFile;

use crate::design_page;
use crate::diagnosis_page::{blocks, lead};
use crate::evidence_of;
use crate::stage::{Needs, Stage, StageContext, StageError, StageOutput};

/// The stage.
pub(super) struct Diagnosis;

/// Campaigns that are diagnosed, in the order of the page.
const CAMPAIGNS: &[&str] = &[
    "brush-2x2-aluminium",
    "brush-2x2-aluminium-cord",
    "brush-2x2-nylon",
    "brush-2x2-ceramic",
    "brush-3x3-aluminium",
];
/// The campaign without and the one with the cord.
const RIGID: &str = CAMPAIGNS[0];
const CORDED: &str = CAMPAIGNS[1];

impl Stage for Diagnosis {
    fn id(&self) -> &'static str {
        "diagnosis"
    }

    fn title(&self) -> &'static str {
        "what the simulation gets wrong"
    }

    fn needs(&self) -> Needs {
        Needs {
            campaigns: CAMPAIGNS,
            ..Needs::default()
        }
    }

    fn run(&self, context: &StageContext<'_>) -> Result<StageOutput, StageError> {
        let mut output = StageOutput::done();
        let mut done: BTreeMap<&str, (Diagnosed, Evidence)> = BTreeMap::new();
        let mut section = Section {
            id: "diagnosis".into(),
            title: "What the simulation gets wrong, and why".into(),
            lead: "Each campaign is asked in a fixed order: what is noise, is there an error beyond it, where, which cause explains it or \
                   which causes this protocol cannot tell apart, and what an extended model gains on runs that it has not seen."
                .into(),
            ..Section::default()
        };
        for &name in CAMPAIGNS {
            context.say(name);
            let campaign = context.campaign(name)?;
            let options = Options {
                quick: context.quick,
                ..Options::default()
            };
            let diagnosed = diagnose_fully(&campaign, &options)
                .map_err(|error| StageError::Failed(format!("{name}: {error}")))?;
            let evidence = evidence_of(campaign.provenance);
            output.values.extend(values(name, &diagnosed, evidence));
            section
                .blocks
                .push(Block::heading(&format!("diagnosis-{name}"), name));
            section.blocks.push(Block::prose(lead(&diagnosed.answer)));
            section
                .blocks
                .extend(blocks(&campaign, &diagnosed, &format!("diagnosis-{name}")));
            output.artefacts.insert(
                name.to_owned(),
                serde_json::to_value(&diagnosed.answer)
                    .map_err(|error| StageError::Failed(error.to_string()))?,
            );
            output.artefacts.insert(
                format!("{name}.extension"),
                serde_json::to_value(&diagnosed.extension)
                    .map_err(|error| StageError::Failed(error.to_string()))?,
            );
            output.work.insert(
                format!("{name}.findings"),
                diagnosed.answer.findings.len() as u64,
            );
            done.insert(name, (diagnosed, evidence));
        }
        if let (Some((rigid, _)), Some((corded, evidence))) = (done.get(RIGID), done.get(CORDED)) {
            section
                .blocks
                .insert(0, cord_table(rigid, corded, *evidence).into());
        }
        section.blocks.extend(protocol(context)?);
        output.sections = vec![section];
        Ok(output)
    }
}

/// What the paper's protocol could tell, whatever the forces are.
fn protocol(context: &StageContext<'_>) -> Result<Vec<Block>, StageError> {
    let campaign = context.campaign(RIGID)?;
    let design = diagnosis::design(&campaign, &Options::default())
        .map_err(|error| StageError::Failed(format!("{RIGID}: {error}")))?;
    let mut blocks = vec![
        Block::heading("diagnosis-design", "What the paper's protocol could tell"),
        Block::prose(design_page::lead(&design)),
    ];
    blocks.extend(design_page::blocks(&design, "diagnosis-design"));
    Ok(blocks)
}

/// The numbers of one campaign.
fn values(name: &str, diagnosed: &Diagnosed, evidence: Evidence) -> Vec<Value> {
    let answer = &diagnosed.answer;
    let unit = answer.noise_floor.unit.as_str();
    let id = |what: &str| format!("diagnosis.{name}.{what}");
    let mut values = vec![
        Value::new(
            id("floor_rmse"),
            answer.noise_floor.rmse,
            unit,
            "diagnosis",
            evidence,
        ),
        Value::new(
            id("baseline_rmse"),
            answer.baseline.rmse,
            unit,
            "diagnosis",
            evidence,
        ),
    ];
    if let Some(rmse) = answer.baseline.held_out_rmse {
        values.push(Value::new(
            id("baseline_held_out_rmse"),
            rmse,
            unit,
            "diagnosis",
            evidence,
        ));
        // Without a named cause the extended model is the law alone.
        let after = answer.gain.as_ref().map_or(rmse, |g| g.held_out_rmse_after);
        values.push(Value::new(
            id("extended_held_out_rmse"),
            after,
            unit,
            "diagnosis",
            evidence,
        ));
    }
    if let Some(gain) = &answer.gain
        && let Some(fraction) = gain.explained_fraction
    {
        let mut value = Value::new(
            id("explained_fraction"),
            fraction,
            "1",
            "diagnosis",
            evidence,
        );
        if let Some([low, high]) = gain.ci95 {
            value = value.with_ci95(low, high);
        }
        values.push(value);
    }
    for (model, word) in [
        (&diagnosed.plain, "plain"),
        (&diagnosed.extension, "extended"),
    ] {
        for parameter in &model.parameters {
            let mut value = Value::new(
                id(&format!("{word}.{}", parameter.name)),
                parameter.value,
                &parameter.unit,
                "diagnosis",
                evidence,
            );
            if let Some(sd) = parameter.sd.filter(|sd| *sd > 0.0) {
                value = value.with_ci95(parameter.value - 1.96 * sd, parameter.value + 1.96 * sd);
            }
            values.push(value);
        }
    }
    values
}

/// The law's parameters from the rigid campaign, from the corded one by a plain fit, and with its extension.
fn cord_table(rigid: &Diagnosed, corded: &Diagnosed, evidence: Evidence) -> Table {
    let cell = |file: &ModelFile, k: usize| -> Cell {
        file.parameters
            .get(k)
            .map_or(Cell::Missing("no such parameter".into()), |p| {
                p.sd.filter(|sd| *sd > 0.0)
                    .map_or(Cell::from(p.value), |sd| {
                        Cell::Interval(p.value, [p.value - 1.96 * sd, p.value + 1.96 * sd])
                    })
            })
    };
    Table {
        id: "diagnosis-cord".into(),
        title: "What the cord does to a plain fit".into(),
        caption: "The same brush measured rigidly and through the elastic cord. The plain fit to the corded campaign follows the curves \
                  by eye, and its parameters are those of brush and cord together; the extended model separates them as far as the \
                  protocol allows."
            .into(),
        columns: vec![
            Column::text("parameter"),
            Column::number("rigid, plain fit", ""),
            Column::number("corded, plain fit", ""),
            Column::number("corded, extended", ""),
            Column::text("unit"),
        ],
        rows: rigid
            .plain
            .parameters
            .iter()
            .enumerate()
            .map(|(k, p)| {
                vec![
                    Cell::Prose(typeset(&p.name).into()),
                    cell(&rigid.plain, k),
                    cell(&corded.plain, k),
                    cell(&corded.extension, k),
                    report::printed_unit(&p.unit).into(),
                ]
            })
            .collect(),
        evidence: Some(evidence),
        provenance: Some(report::figure::Provenance::here("diagnosis", "cord_table")),
        ..Table::default()
    }
}

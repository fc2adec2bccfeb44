//! `diagnose`: what the simulation gets wrong in a campaign, why, and what an extended model gains.

mod answer;
mod design;

use diagnosis::Options;

use super::{DiagnoseArguments, Failure, Outcome, files};
use crate::campaign_page::document;
use crate::design_page;
use crate::diagnosis_page;
use crate::provenance;

pub(super) fn run(arguments: &DiagnoseArguments) -> Result<Outcome, Failure> {
    let campaign = campaign::open(&arguments.package).map_err(Failure::input)?;
    let law = arguments
        .law
        .as_deref()
        .map(|name| files::law(Some(name), &campaign))
        .transpose()?;
    let model = arguments.model.as_deref().map(files::model).transpose()?;
    let options = Options {
        law,
        model,
        told: Some(|how_far| say_aside!("{how_far}")),
        ..Options::default()
    };
    if arguments.design {
        let design = diagnosis::design(&campaign, &options).map_err(Failure::input)?;
        design::print(&design);
        files::json(arguments.json.as_deref(), &design)?;
        let run = provenance::run(&super::root::root()?);
        files::page(arguments.report.as_deref(), || {
            document(
                &campaign,
                "Design",
                design_page::lead(&design),
                "cargo xtask diagnose --design PACKAGE",
                run,
                vec![design_page::section(&campaign, &design)],
                serde_json::to_value(&design).unwrap_or_default(),
            )
        })?;
        return Ok(Outcome::Done);
    }
    say_aside!("diagnosing {} runs", campaign.runs.len());
    let diagnosed = diagnosis::diagnose_fully(&campaign, &options).map_err(Failure::input)?;
    let answer = &diagnosed.answer;
    answer::print(answer);
    files::json(arguments.json.as_deref(), answer)?;
    files::json(arguments.extension.as_deref(), &diagnosed.extension)?;
    let run = provenance::run(&super::root::root()?);
    files::page(arguments.report.as_deref(), || {
        let results = serde_json::to_value(answer).unwrap_or_default();
        document(
            &campaign,
            "Diagnosis",
            diagnosis_page::lead(answer),
            "cargo xtask diagnose PACKAGE",
            run,
            vec![diagnosis_page::section(&campaign, &diagnosed)],
            results,
        )
    })?;
    Ok(Outcome::Done)
}

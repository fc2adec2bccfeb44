//! `diagnose`: what the simulation gets wrong in a campaign, why, and what an extended model gains.

use diagnosis::{Diagnosis, Options};

use super::{DiagnoseArguments, Failure, Outcome, files};
use crate::campaign_page::document;
use crate::provenance;
use crate::results::significant;

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
        ..Options::default()
    };
    if arguments.design {
        return Err(Failure::Output(
            "the design of a protocol cannot be examined yet".into(),
        ));
    }
    eprintln!("diagnosing {} runs", campaign.runs.len());
    let diagnosed = diagnosis::diagnose_fully(&campaign, &options).map_err(Failure::input)?;
    let answer = &diagnosed.answer;
    print(answer);
    files::json(arguments.json.as_deref(), answer)?;
    files::json(arguments.extension.as_deref(), &diagnosed.extension)?;
    let _ = (document, provenance::run);
    Ok(Outcome::Done)
}

fn print(answer: &Diagnosis) {
    println!(
        "{}: {} (law {})",
        answer.campaign,
        answer.status.word(),
        answer.law
    );
    let unit = if answer.noise_floor.unit == "1" {
        ""
    } else {
        answer.noise_floor.unit.as_str()
    };
    println!(
        "error {} {unit}, noise floor {} {unit} (from {})",
        significant(answer.baseline.rmse),
        significant(answer.noise_floor.rmse),
        answer.noise_floor.source
    );
    for finding in &answer.findings {
        let with = if finding.equivalent.is_empty() {
            String::new()
        } else {
            format!(", or {}", finding.equivalent.join(", or "))
        };
        println!(
            "cause {} at the {}{with}, probability {}",
            finding.cause,
            finding.station,
            significant(finding.probability)
        );
        for parameter in &finding.parameters {
            println!(
                "  {} = {} {}",
                parameter.name,
                significant(parameter.value),
                parameter.unit
            );
        }
    }
    if answer.unexplained.detected {
        match &answer.unexplained.r#where {
            Some(place) => println!(
                "unexplained structure at {} {} to {} {}",
                place.axis,
                significant(place.from),
                significant(place.to),
                place.unit
            ),
            None => println!("unexplained structure"),
        }
    }
    for open in &answer.undecidable {
        println!(
            "undecidable: {} ({}); would decide: {}",
            open.causes.join(", "),
            open.because,
            open.experiment
        );
    }
}

//! `diagnose`: what the simulation gets wrong in a campaign, why, and what an extended model gains.

use diagnosis::{Design, Diagnosis, Options};

use super::{DiagnoseArguments, Failure, Outcome, files};
use crate::campaign_page::document;
use crate::diagnosis_page;
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
        let design = diagnosis::design(&campaign, &options).map_err(Failure::input)?;
        print_design(&design);
        files::json(arguments.json.as_deref(), &design)?;
        return Ok(Outcome::Done);
    }
    say_aside!("diagnosing {} runs", campaign.runs.len());
    let diagnosed = diagnosis::diagnose_fully(&campaign, &options).map_err(Failure::input)?;
    let answer = &diagnosed.answer;
    print(answer);
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

/// Thresholds and the nearest rival of each cause: the whole matrix stands in the JSON.
fn print_design(design: &Design) {
    say!(
        "{}: what this protocol could tell (law {}; forces not read, noise nominal)",
        design.campaign,
        design.law
    );
    say!(
        "cause | smallest size found in nine cases of ten | nearest rival (sine of the angle between the two)"
    );
    for (i, threshold) in design.thresholds.iter().enumerate() {
        let size = threshold.size.map_or_else(
            || "none: the law absorbs it".to_owned(),
            |s| {
                format!(
                    "{} {} {}",
                    threshold.parameter,
                    significant(s),
                    threshold.unit
                )
            },
        );
        let nearest = design.isolability.get(i).and_then(|row| {
            row.iter()
                .enumerate()
                .filter(|(j, _)| *j != i && design.thresholds[*j].cause != threshold.cause)
                .filter_map(|(j, s)| s.map(|s| (j, s)))
                .min_by(|a, b| a.1.total_cmp(&b.1))
        });
        let rival = nearest.map_or_else(String::new, |(j, s)| {
            format!("{} ({})", design.thresholds[j].cause, significant(s))
        });
        say!("{} | {size} | {rival}", threshold.cause);
    }
    for open in &design.undecidable {
        say!(
            "undecidable: {} ({}); would decide: {}",
            open.causes.join(", "),
            open.because,
            open.experiment
        );
    }
}

fn print(answer: &Diagnosis) {
    say!(
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
    say!(
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
        say!(
            "cause {} at the {}{with}, probability {}",
            finding.cause,
            finding.station,
            significant(finding.probability)
        );
        for parameter in &finding.parameters {
            say!(
                "  {} = {} {}",
                parameter.name,
                significant(parameter.value),
                parameter.unit
            );
        }
    }
    if answer.unexplained.detected {
        match &answer.unexplained.r#where {
            Some(place) => say!(
                "unexplained structure at {} {} to {} {}",
                place.axis,
                significant(place.from),
                significant(place.to),
                place.unit
            ),
            None => say!("unexplained structure"),
        }
    }
    for open in &answer.undecidable {
        say!(
            "undecidable: {} ({}); would decide: {}",
            open.causes.join(", "),
            open.because,
            open.experiment
        );
    }
}

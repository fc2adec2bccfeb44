//! The answer in words, for a terminal: verdict, causes with their intervals and gains, what is left, what would decide, the laws.

use diagnosis::{Diagnosis, Estimate, Finding, Gain, LawFit};

use crate::results::significant;

pub(super) fn print(answer: &Diagnosis) {
    say!(
        "{}: {} (law {})",
        answer.campaign,
        answer.status.word(),
        answer.law
    );
    let unit = unit_of(answer);
    let held_out = answer.baseline.held_out_rmse.map_or_else(String::new, |e| {
        format!(" ({} on runs left out)", significant(e))
    });
    say!(
        "error {}{unit}{held_out}, noise floor {}{unit} (from {})",
        significant(answer.baseline.rmse),
        significant(answer.noise_floor.rmse),
        answer.noise_floor.source
    );
    answer.findings.iter().for_each(finding);
    if let Some(gain) = &answer.gain {
        say!("{}", gained(gain, unit));
    }
    if answer.unexplained.detected {
        match &answer.unexplained.r#where {
            Some(place) => say!(
                "unexplained structure at {} {} to {} {}{}",
                place.axis,
                significant(place.from),
                significant(place.to),
                place.unit,
                of_runs(&place.runs)
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
    laws(&answer.laws, unit);
    for note in &answer.notes {
        say!("note: {note}");
    }
}

/// More runs than this are not listed on one line.
const LISTED: usize = 4;

/// The runs where something sits, if they are few.
fn of_runs(runs: &[String]) -> String {
    match runs {
        [] => String::new(),
        [one] => format!(" of run {one}"),
        few if few.len() <= LISTED => format!(" of runs {}", few.join(", ")),
        _ => String::new(),
    }
}

/// A blank and the unit of errors, or nothing where they are coefficients.
fn unit_of(answer: &Diagnosis) -> &'static str {
    match answer.noise_floor.unit.as_str() {
        "N" => " N",
        "N m" => " N m",
        _ => "",
    }
}

fn finding(finding: &Finding) {
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
    finding.parameters.iter().for_each(parameter);
}

fn parameter(parameter: &Estimate) {
    let Estimate {
        name, value, unit, ..
    } = parameter;
    let unit = if unit == "1" { "" } else { unit.as_str() };
    let interval = parameter.ci95.map_or_else(String::new, |[least, most]| {
        format!(" [{}, {}]", significant(least), significant(most))
    });
    let line = format!("  {name} = {}{interval} {unit}", significant(*value));
    say!("{}", line.trim_end());
}

fn gained(gain: &Gain, unit: &str) -> String {
    let (before, after) = (gain.held_out_rmse_before, gain.held_out_rmse_after);
    // The share weighs errors by the noise; the plain error may rise all the same.
    let goes = if after > before { "rises" } else { "falls" };
    let errors = format!(
        "on runs left out the error {goes} from {}{unit} to {}{unit}",
        significant(before),
        significant(after)
    );
    let percent = |share: f64| format!("{:.0} %", 100.0 * share);
    match (gain.explained_fraction, gain.ci95) {
        (Some(share), Some([least, most])) => format!(
            "{errors}: {} of what can be explained [{}, {}]",
            percent(share),
            percent(least),
            percent(most)
        ),
        (Some(share), None) => format!("{errors}: {} of what can be explained", percent(share)),
        _ => errors,
    }
}

/// The laws on the same data, where there was more than one to compare.
fn laws(laws: &[LawFit], unit: &str) {
    if laws.len() < 2 {
        return;
    }
    let each = laws.iter().map(|law| {
        format!(
            "{} (+{:.0}, error {}{unit})",
            law.law,
            law.delta_aicc,
            significant(law.rmse)
        )
    });
    let each: Vec<String> = each.collect();
    say!(
        "laws alone, by corrected Akaike criterion: {}",
        each.join(", ")
    );
}

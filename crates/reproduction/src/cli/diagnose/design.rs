//! What a protocol could tell, in words: thresholds, and which causes it could tell apart.

use diagnosis::Design;

use crate::design_page::rival;
use crate::results::significant;

/// Thresholds with the nearest rival of each cause, then the whole isolability matrix.
pub(super) fn print(design: &Design) {
    say!(
        "{}: what this protocol could tell (law {}; forces not read, noise nominal)",
        design.campaign,
        design.law
    );
    thresholds(design);
    matrix(design);
    for open in &design.undecidable {
        say!(
            "undecidable: {} ({}); would decide: {}",
            open.causes.join(", "),
            open.because,
            open.experiment
        );
    }
}

fn thresholds(design: &Design) {
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
        let nearest = rival(design, 0..design.isolability.len(), i);
        let rival = nearest.map_or_else(String::new, |(j, s)| {
            format!("{} ({})", design.thresholds[j].cause, significant(s))
        });
        say!("{} | {size} | {rival}", threshold.cause);
    }
}

/// Row by row the hundredths of each sine: 0 the same signature, 99 nothing in common.
fn matrix(design: &Design) {
    if design.isolability.is_empty() {
        return;
    }
    say!(
        "isolability matrix (hundredths of the sine between two signatures; 0: one and the same, 99: nothing in common)"
    );
    let columns = 1..=design.isolability.len();
    let head: Vec<String> = columns.map(|j| format!("{j:>2}")).collect();
    let width = design.thresholds.iter().map(|t| t.cause.len()).max();
    let width = width.unwrap_or(0) + 4;
    say!("{:width$} {}", "", head.join(" "));
    for (i, row) in design.isolability.iter().enumerate() {
        let cells: Vec<String> = row
            .iter()
            .enumerate()
            .map(|(j, sine)| match sine {
                _ if i == j => " .".to_owned(),
                Some(sine) => format!("{:>2}", (100.0 * sine).floor().clamp(0.0, 99.0)),
                None => " -".to_owned(),
            })
            .collect();
        let name = format!("{:>2}. {}", i + 1, design.thresholds[i].cause);
        say!("{name:width$} {}", cells.join(" "));
    }
}

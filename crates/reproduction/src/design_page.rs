//! What a protocol could and could not tell, before anything is measured: the isolability matrix as a picture, the
//! smallest size of each cause that would be seen, and the experiments that break ties.

use campaign::Campaign;
use diagnosis::Design;
use report::figure::{Axis, Figure, HeatMap, Provenance};
use report::{Block, Cell, Column, Evidence, Section, Table, literal};

use crate::diagnosis_page::{size, undecidable};

/// Sine of the angle below which two signatures are next to one another: an effect of ten noise deviations then differs from its
/// rival by less than one.
const ALIKE: f64 = 0.1;
/// Command that stands on figure and tables.
const STAGE: &str = "diagnosis";

/// The first form of each cause: a place in the thresholds for each.
fn first_forms(design: &Design) -> Vec<usize> {
    let known = |i: usize| {
        let own = &design.thresholds[i].cause;
        design.thresholds[..i].iter().any(|t| t.cause == *own)
    };
    (0..design.thresholds.len())
        .filter(|&i| !known(i))
        .collect()
}

/// Those of them that the law does not absorb.
fn seen(design: &Design) -> Vec<usize> {
    let mut seen = first_forms(design);
    seen.retain(|&i| i < design.isolability.len());
    seen
}

/// What the page says first.
pub(crate) fn lead(design: &Design) -> String {
    let seen = seen(design);
    let alike = seen
        .iter()
        .filter(|&&i| rival(design, seen.iter().copied(), i).is_some_and(|(_, sine)| sine < ALIKE))
        .count();
    format!(
        "With the law `{}` and nominal noise this protocol would show {} causes of friction and measurement at some size; {alike} of them look \
         like another one to a tenth of their own size or less, so that only a larger effect or another protocol names them. No force was read.",
        literal(&design.law),
        seen.len()
    )
}

/// A section of its own for one protocol.
pub(crate) fn section(campaign: &Campaign, design: &Design) -> Section {
    Section {
        id: "design".into(),
        title: "What this protocol could tell".into(),
        lead: format!(
            "{} runs; every figure is computed from their commands, loads and order alone.",
            campaign.runs.len()
        )
        .into(),
        blocks: blocks(design, "design"),
        ..Section::default()
    }
}

/// Matrix, thresholds and ties; `prefix` keeps ids apart on a page with several.
pub(crate) fn blocks(design: &Design, prefix: &str) -> Vec<Block> {
    let mut blocks: Vec<Block> = Vec::new();
    if !design.isolability.is_empty() {
        blocks.push(matrix(design, prefix).into());
    }
    blocks.push(thresholds(design, prefix).into());
    if !design.undecidable.is_empty() {
        blocks.push(undecidable(&design.undecidable, Evidence::Computed, prefix).into());
    }
    blocks
}

/// The sine of the angle between each two signatures.
fn matrix(design: &Design, prefix: &str) -> Figure {
    let seen = seen(design);
    let sine = |i: usize, j: usize| {
        if i == j {
            None
        } else {
            design.isolability[i][j]
        }
    };
    let heat = HeatMap {
        x: Axis::new("cause, by its number", ""),
        y: Axis::new("cause", ""),
        columns: (1..=seen.len()).map(|k| k.to_string()).collect(),
        rows: (seen.iter().zip(1..))
            .map(|(&i, k)| format!("{} {k}", design.thresholds[i].cause))
            .collect(),
        values: (seen.iter())
            .map(|&i| seen.iter().map(|&j| sine(i, j)).collect())
            .collect(),
        quantity: "sine of the angle between two signatures".into(),
        limits: Some([0.0, 1.0]),
        ..HeatMap::default()
    };
    Figure::new(
        &format!("{prefix}-isolability"),
        "Which causes this protocol could tell apart",
        "How much of one cause's signature another cannot imitate, law and noise taken into account: at 0 the two are one and the same to this \
         protocol, at 1 they have nothing in common. An effect is told from a rival where its size times this sine stands out of the noise.",
        Evidence::Computed,
        heat,
        Provenance::here(STAGE, "diagnosis::design"),
    )
}

/// The form of another cause that is most like the i-th one, and the sine between them; `None` where the law absorbs it.
pub(crate) fn rival(
    design: &Design,
    among: impl IntoIterator<Item = usize>,
    i: usize,
) -> Option<(usize, f64)> {
    let row = design.isolability.get(i)?;
    let cause = |k: usize| &design.thresholds[k].cause;
    among
        .into_iter()
        .filter(|&j| cause(j) != cause(i))
        .filter_map(|j| row[j].map(|sine| (j, sine)))
        .min_by(|a, b| a.1.total_cmp(&b.1))
}

/// The smallest size of each cause that would be found, and what it would be mistaken for.
fn thresholds(design: &Design, prefix: &str) -> Table {
    let seen = seen(design);
    let row = |i: usize| {
        let threshold = &design.thresholds[i];
        let nearest = rival(design, seen.iter().copied(), i);
        let (name, sine) = nearest.map_or_else(
            || [Cell::Text(String::new()), Cell::Missing("no rival".into())].into(),
            |(j, sine)| (design.thresholds[j].cause.clone().into(), Cell::from(sine)),
        );
        vec![
            threshold.cause.clone().into(),
            threshold.parameter.clone().into(),
            size(threshold),
            report::printed_unit(&threshold.unit).into(),
            name,
            sine,
        ]
    };
    Table {
        id: format!("{prefix}-thresholds"),
        title: "What this protocol would show".into(),
        caption: "For each cause the size that would be found in nine cases of ten, and the cause that looks most like it.".into(),
        columns: vec![
            Column::text("cause"),
            Column::text("parameter"),
            Column::number("size", ""),
            Column::text("unit"),
            Column::text("nearest rival"),
            Column::number("sine between the two", ""),
        ],
        rows: first_forms(design).into_iter().map(row).collect(),
        evidence: Some(Evidence::Computed),
        provenance: Some(Provenance::here(STAGE, "diagnosis::design")),
        ..Table::default()
    }
}

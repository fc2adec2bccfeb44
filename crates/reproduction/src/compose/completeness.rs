//! The chapter that says what becomes of every number that the paper prints.

use std::collections::BTreeSet;

use report::figure::Provenance;
use report::{
    Block, Cell, Column, Evidence, Prose, Section, Table, literal, printed_with_unit, typeset,
};

use crate::numbers::{Coverage, Treatment};
use crate::published::Published;

/// The chapter; `anchors` are the parts of this page that a row may point at.
pub(super) fn section(
    coverage: &Coverage,
    published: &Published,
    anchors: &BTreeSet<String>,
) -> Section {
    let mut blocks = Vec::new();
    if !coverage.orphans.is_empty() {
        blocks.push(Block::prose(literal(&format!(
            "Rows that cover no number of their own: {}.",
            coverage.orphans.join(", ")
        ))));
    }
    blocks.push(table(coverage, published, anchors).into());
    Section {
        id: "completeness".into(),
        title: "Every printed number".into(),
        lead: lead(coverage).into(),
        method: Some(
            "The list was made by hand from abstract, text, tables and captions; the abstract holds no number. Numbers of references, figures, equations and pages are not counted. A number counts as *in a claim* where a verdict may depend on it.".into(),
        ),
        blocks,
        ..Section::default()
    }
}

/// How many numbers stand where.
fn lead(coverage: &Coverage) -> String {
    let treated = |treatment| coverage.treated(treatment);
    format!(
        "{}: {} in claims, {} compared in a table or a sum, {} not testable, {} not claims, each with its reason.",
        words(coverage),
        coverage.in_claims(),
        treated(Treatment::Compared),
        treated(Treatment::NotTestable),
        treated(Treatment::NotAClaim),
    )
}

/// The count that matters, for header and terminal.
pub(crate) fn words(coverage: &Coverage) -> String {
    format!(
        "{} of {} printed numbers without a place in the ledger",
        coverage.unledgered.len(),
        coverage.printed
    )
}

fn table(coverage: &Coverage, published: &Published, anchors: &BTreeSet<String>) -> Table {
    let mut rows: Vec<Vec<Cell>> = published
        .iter()
        .map(|(id, number)| {
            let (becomes, reason) = place(coverage, id, anchors);
            vec![
                Cell::Text(printed_with_unit(&number.printed, &number.unit)),
                Cell::Prose(typeset(&number.meaning).into()),
                Cell::Text(number.locator.clone()),
                Cell::Prose(becomes),
                reason,
            ]
        })
        .collect();
    rows.extend(coverage.others.beside.iter().map(|row| {
        vec![
            Cell::Text(printed_with_unit(&row.printed.join(", "), &row.unit)),
            Cell::Prose(typeset(&row.meaning).into()),
            Cell::Text(row.locator.clone()),
            Cell::from(row.status.word()),
            Cell::Prose(typeset(&row.reason).into()),
        ]
    }));
    Table {
        id: "printed-numbers".into(),
        title: "Printed numbers and their place".into(),
        caption: "As printed, with the paper’s own units.".into(),
        columns: [
            "printed",
            "what it is",
            "where",
            "what becomes of it",
            "reason where no claim rests on it",
        ]
        .map(Column::text)
        .to_vec(),
        rows,
        evidence: Some(Evidence::Published),
        provenance: Some(Provenance::here("completeness", "completeness::table")),
        ..Table::default()
    }
}

/// What becomes of a number, and why where no claim rests on it.
fn place(coverage: &Coverage, id: &str, anchors: &BTreeSet<String>) -> (Prose, Cell) {
    if let Some(claims) = coverage.claimed.get(id) {
        let links: Vec<String> = claims
            .iter()
            .map(|claim| format!("[{claim}](#{claim})"))
            .collect();
        return (links.join(", ").into(), Cell::from(""));
    }
    let group = coverage
        .others
        .group
        .iter()
        .find(|group| group.numbers.iter().any(|number| number == id));
    let Some(group) = group else {
        return (
            "**unledgered**".into(),
            Cell::Missing("neither a claim nor a reason".into()),
        );
    };
    let word = group.status.word();
    let becomes = match group.shown.as_ref().filter(|part| anchors.contains(*part)) {
        Some(part) => format!("[{word}](#{part})"),
        None => word.to_owned(),
    };
    (becomes.into(), Cell::Prose(typeset(&group.reason).into()))
}

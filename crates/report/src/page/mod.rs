//! The page: a document becomes one HTML file.

mod cards;
mod engine;
mod identity;
mod ids;
mod ledger;
mod sections;

use std::collections::BTreeMap;

use minijinja::Value as Item;
use minijinja::context;
use minijinja::value::Serde;

pub use identity::{hex, identity};

use crate::escape::{data_uri, json_in_script};
use crate::prose::Lookup;
use crate::{Document, Error, Table, number, palette};
use engine::{Engine, safe};

/// Style of the page, after the palette and the style of figures.
const STYLE: &str = include_str!("../../../../report/style.css");
/// The only script of the page; its hash stands in the content security policy.
const SCRIPT: &str = include_str!("../../../../report/script.js");

/// Renders the document as one self-contained HTML file.
///
/// # Errors
/// An unknown value id, a doubled id, an unreadable equation or text, a figure or table that cannot be drawn.
pub fn render(document: &Document) -> Result<String, Error> {
    let lookup = Lookup::new(&document.values, ids::collect(document)?);
    let engine = Engine::new()?;
    let cards = cards::Cards {
        engine: &engine,
        lookup: &lookup,
        repository: document.header.repository.as_deref(),
        commit: &document.run.commit,
    };
    let results = document.results.to_string();
    let empty = document.results.is_null();
    let page = context! {
        title => &document.title,
        kicker => if document.claims.is_empty() { "Report of a campaign" } else { "Audit of a paper" },
        lead => safe(lookup.paragraphs(&document.lead, "lead of the document")?),
        subject => Serde(&document.subject),
        identity => if empty { String::new() } else { identity(&document.results) },
        facts => Serde(&document.header.facts),
        program => &document.header.program,
        command => &document.header.command,
        stages => Serde(&document.header.stages),
        inputs => Serde(&document.header.inputs),
        run => Serde(&document.run),
        run_total => run_total(&document.run.seconds),
        costs => Serde(costs(document)),
        run_json => safe(json_in_script(&serde_json::to_string(&document.run)?)),
        results => safe(json_in_script(&results)),
        script => safe(SCRIPT.to_string()),
        script_hash => identity::script_hash(SCRIPT),
        style => safe(format!("{}{}{STYLE}", palette::for_page(), crate::figure::STYLE)),
        values => Serde(values(document)),
        values_csv => data_uri("text/csv;charset=utf-8", &values_csv(document)),
    };
    let ledger = ledger::context(document, &lookup)?;
    let sections = sections::context(document, &cards)?;
    engine.render("page.html", context! { ..page, ..ledger, ..sections })
}

/// A table as CSV, for a file beside the report: numbers with every digit, values by id from `values`.
///
/// # Errors
/// An unknown value id, a row of another width.
pub fn table_file(table: &Table, values: &[crate::Value]) -> Result<String, Error> {
    cards::check_width(table)?;
    cards::table_csv(
        table,
        &Lookup::new(values, std::collections::BTreeSet::new()),
    )
}

/// Sum of the times of the stages.
fn run_total(seconds: &BTreeMap<String, f64>) -> String {
    let total: f64 = seconds
        .iter()
        .filter(|(id, _)| !ids::is_claim(id))
        .map(|(_, seconds)| seconds)
        .sum();
    if total > 0.0 {
        number::with_unit(&number::significant(total, 3), "s")
    } else {
        String::new()
    }
}

/// Claims of the ledger with the time that computing them takes.
fn costs(document: &Document) -> Vec<(&str, String)> {
    let claims = document.claims.iter().map(|claim| claim.id.as_str());
    claims
        .filter_map(|id| {
            let seconds = *document.run.seconds.get(id)?;
            let text = if seconds < 0.1 {
                "less than 0.1".to_owned()
            } else {
                number::significant(seconds, 2)
            };
            Some((id, number::with_unit(&text, "s")))
        })
        .collect()
}

/// The values as the page lists them.
fn values(document: &Document) -> Vec<BTreeMap<&'static str, String>> {
    document
        .values
        .iter()
        .map(|value| {
            let text = match (value.value, value.ci95) {
                (Some(bare), Some(interval)) => number::with_interval(bare, interval),
                (Some(bare), None) => number::plain(bare),
                (None, _) => "no result".into(),
            };
            BTreeMap::from([
                ("id", value.id.clone()),
                ("text", text),
                ("unit", number::unit(&value.unit)),
                ("published", value.published.clone().unwrap_or_default()),
                ("evidence", value.evidence.word().to_string()),
            ])
        })
        .collect()
}

/// The values with every digit.
fn values_csv(document: &Document) -> String {
    let mut out = String::from("id,value,low,high,unit,published,stage,evidence\n");
    for value in &document.values {
        let number = |number: Option<f64>| number.map(number::exact).unwrap_or_default();
        let cells = [
            value.id.clone(),
            number(value.value),
            number(value.ci95.map(|ci| ci[0])),
            number(value.ci95.map(|ci| ci[1])),
            value.unit.clone(),
            value.published.clone().unwrap_or_default(),
            value.stage.clone(),
            value.evidence.word().to_string(),
        ];
        let cells: Vec<String> = cells.iter().map(|cell| crate::escape::csv(cell)).collect();
        out.push_str(&cells.join(","));
        out.push('\n');
    }
    out
}

/// Links to claims, separated by commas; claims that this page does not have stay plain words.
fn claim_links(claims: &[String], lookup: &Lookup<'_>) -> Item {
    let links: Vec<String> = claims
        .iter()
        .map(|claim| lookup.link(claim, claim))
        .collect();
    safe(links.join(", "))
}

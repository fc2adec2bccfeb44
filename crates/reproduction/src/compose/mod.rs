//! The page: results and the sections of the stages brought together as a document.

mod benchmarks;
mod checklist;
mod completeness;
mod equations;
mod identity;
mod inputs;
mod ledger;
mod notes;

use std::collections::BTreeSet;

use report::{
    AuditItem, Block, Document, Drift, Header, Input, NegativeControl, Run, Section, Subject,
    Value, Verdict,
};

use crate::numbers::Coverage;
use crate::published::Published;
use crate::results::Results;

pub use benchmarks::{Benchmarks, diagnosis_fingerprint};
pub(crate) use completeness::words as completeness_words;
pub use identity::{Prints, Twice};

/// What the page shows besides the results.
pub struct Surroundings {
    /// Command that makes the page again.
    pub command: String,
    /// Volatile facts.
    pub run: Run,
    /// Comparison with an earlier report.
    pub drift: Option<Drift>,
    /// Negative controls that were run.
    pub controls: Vec<NegativeControl>,
    /// Provenance of each campaign: name, `synthetic` or `measured`.
    pub campaigns: Vec<(String, &'static str)>,
    /// Public address of the repository.
    pub repository: Option<String>,
    /// What benchmarks counted, as it stands in data/.
    pub benchmarks: Benchmarks,
    /// Two runs compared byte for byte, where that was asked for.
    pub twice: Option<Twice>,
    /// The paper's numbers.
    pub published: Published,
    /// Where each of them stands.
    pub numbers: Coverage,
    /// Whether fewer starts and repetitions were used.
    pub quick: bool,
}

/// The document of a reproduction.
#[must_use]
pub fn document(results: &Results, around: Surroundings) -> Document {
    let values: Vec<Value> = results.values.values().cloned().collect();
    let sections: Vec<Section> = results
        .stages
        .iter()
        .filter_map(|stage| {
            let sections = stage.output.as_ref().ok()?.sections.clone();
            Some(inputs::with_inputs(sections, &stage.inputs))
        })
        .flatten()
        .collect();
    let mut sections = sections;
    sections.push(benchmarks::section(&around.benchmarks, &results.values));
    sections.push(equations::section());
    let anchors = anchors(&sections);
    let parts: BTreeSet<String> = ["audit".to_owned()]
        .into_iter()
        .chain(anchors.iter().map(|(id, _)| id.clone()))
        .collect();
    sections.push(completeness::section(
        &around.numbers,
        &around.published,
        &parts,
    ));
    sections.push(identity::section(around.twice.as_ref()));
    let known: BTreeSet<&str> = results.values.keys().map(String::as_str).collect();
    let checklist = checklist::items(results, &around);
    Document {
        checklist,
        title: "Asymmetric bristle model for steel brush: what holds".into(),
        lead: lead(results, &around).into(),
        subject: Subject {
            reference: "Zhong W., Jin Y., Jin X., Bao R., Huang Z. Asymmetric Bristle Model for Steel Brush and Its Application. Chinese Journal of Solid Mechanics 45(4), 477-487, 2024".into(),
            doi: Some("10.19636/j.cnki.cjsm42-1250/o3.2024.014".into()),
        },
        header: header(results, &around),
        run: around.run,
        claims: results
            .claims
            .iter()
            .map(|(claim, judged)| {
                let mut row = ledger::row(claim, judged, &known, &anchors);
                row.multiverse = results.multiverses.get(&claim.id).cloned();
                row
            })
            .collect(),
        deviations: ledger::deviations(&results.claims, &known),
        audit: audit(results),
        sections,
        drift: around.drift,
        doubts: notes::doubts(),
        controls: around.controls,
        synthetic: notes::synthetic(&around.campaigns),
        unpublished: notes::unpublished(),
        out_of_scope: notes::out_of_scope(),
        choices: notes::choices(&known),
        glossary: notes::glossary(),
        results: results.json(),
        values,
    }
}

/// What the page is, for a reader in a hurry; the board beneath it counts the verdicts.
fn lead(results: &Results, around: &Surroundings) -> String {
    let synthetic = around
        .campaigns
        .iter()
        .filter(|(_, kind)| *kind == "synthetic")
        .count();
    let data = match (synthetic, around.campaigns.len()) {
        (0, 0) => "No campaign was read.".to_owned(),
        (0, _) => "All campaigns are measured.".to_owned(),
        (all, count) if all == count => {
            "The paper publishes no measurement: every campaign is a synthetic stand-in, so claims about measurements are at best consistent.".to_owned()
        }
        (some, count) => format!("{some} of {count} campaigns are synthetic stand-ins."),
    };
    let quick = if around.quick {
        " Made with `--quick`: fewer starts and repetitions, not for the record."
    } else {
        ""
    };
    format!(
        "{} claims of the paper, each beside numbers of our own, with a tolerance and its reason. {data}{quick}",
        results.claims.len()
    )
}

/// How often each verdict came out, zeros included.
#[must_use]
pub fn counts(results: &Results) -> Vec<(Verdict, usize)> {
    let count = |verdict| {
        results
            .claims
            .iter()
            .filter(|(_, judged)| judged.verdict == verdict)
            .count()
    };
    Verdict::ALL
        .into_iter()
        .map(|verdict| (verdict, count(verdict)))
        .collect()
}

fn header(results: &Results, around: &Surroundings) -> Header {
    let kind = |path: &str| {
        let campaign = path
            .strip_prefix("data/campaigns/")
            .and_then(|rest| rest.split('/').next());
        match campaign {
            Some(name) => around
                .campaigns
                .iter()
                .find(|(known, _)| known == name)
                .map_or("campaign", |(_, kind)| *kind),
            None if path == "data/published.toml" => "published numbers",
            None => "model",
        }
    };
    let inputs: std::collections::BTreeMap<&String, &String> = results
        .stages
        .iter()
        .flat_map(|stage| &stage.inputs)
        .collect();
    Header {
        program: format!("Bristle {}", env!("CARGO_PKG_VERSION")),
        command: around.command.clone(),
        inputs: inputs
            .into_iter()
            .map(|(path, hash)| Input {
                path: path.clone(),
                hash: format!("blake3:{hash}"),
                kind: kind(path).into(),
            })
            .collect(),
        facts: facts(results, around),
        stages: results
            .stages
            .iter()
            .map(|stage| (stage.id.to_owned(), stage.status()))
            .collect(),
        repository: around.repository.clone(),
    }
}

/// What a reader wants to know at first sight besides the verdicts.
fn facts(results: &Results, around: &Surroundings) -> Vec<(String, String)> {
    let passed = around
        .controls
        .iter()
        .filter(|control| control.passed())
        .count();
    let sums = audit(results);
    let holds = sums
        .iter()
        .filter(|item| item.outcome == report::AuditOutcome::Holds)
        .count();
    let done = results
        .stages
        .iter()
        .filter(|stage| stage.status() == "done")
        .count();
    vec![
        (
            "Stages done".into(),
            format!("{done} of {}", results.stages.len()),
        ),
        ("Values computed".into(), results.values.len().to_string()),
        (
            "Sums on printed numbers that hold".into(),
            format!("{holds} of {}", sums.len()),
        ),
        (
            "Negative controls as expected".into(),
            format!("{passed} of {}", around.controls.len()),
        ),
        (
            "Printed numbers not accounted for".into(),
            format!(
                "{} of {}",
                around.numbers.unledgered.len(),
                around.numbers.printed
            ),
        ),
        (
            "Same bytes in two runs".into(),
            identity::fact(around.twice.as_ref()),
        ),
    ]
}

/// The sums of the audit, as its stage left them.
fn audit(results: &Results) -> Vec<AuditItem> {
    artefact(results, |stage, name| stage == "audit" && name == "items").unwrap_or_default()
}

/// The first artefact that is wanted, if it reads as a `T`.
fn artefact<T: serde::de::DeserializeOwned>(
    results: &Results,
    wanted: impl Fn(&str, &str) -> bool,
) -> Option<T> {
    results
        .stages
        .iter()
        .filter_map(|stage| Some((stage.id, stage.output.as_ref().ok()?)))
        .flat_map(|(id, output)| {
            output
                .artefacts
                .iter()
                .map(move |(name, json)| (id, name, json))
        })
        .find(|(id, name, _)| wanted(id, name))
        .and_then(|(.., json)| serde_json::from_value(json.clone()).ok())
}

/// Ids of figures and tables with the claims that each says it bears on.
fn anchors(sections: &[Section]) -> Vec<(String, Vec<String>)> {
    let blocks = sections.iter().flat_map(|section| &section.blocks);
    blocks
        .filter_map(|block| match block {
            Block::Figure(figure) => Some((figure.id.clone(), figure.claims.clone())),
            Block::Table(table) => Some((table.id.clone(), table.claims.clone())),
            _ => None,
        })
        .collect()
}

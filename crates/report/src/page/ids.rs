//! The ids of a page: each stands once, and links know what they may aim at.

use std::collections::BTreeSet;

use crate::{Block, Document, Error};

/// Ids that the templates themselves use.
const OF_THE_PAGE: [&str; 29] = [
    "top",
    "content",
    "run",
    "run-facts",
    "results",
    "contents-title",
    "ledger",
    "deviations",
    "changes",
    "audit",
    "doubts",
    "controls",
    "limits",
    "synthetic",
    "unpublished",
    "out-of-scope",
    "choices",
    "glossary",
    "verdict-words",
    "provenance",
    "stages",
    "inputs",
    "search",
    "review",
    "theme",
    "keys",
    "help",
    "costs",
    "checklist",
];

/// Whether an id is that of a claim: `C` and digits.
pub(super) fn is_claim(id: &str) -> bool {
    id.strip_prefix('C')
        .is_some_and(|rest| !rest.is_empty() && rest.chars().all(|c| c.is_ascii_digit()))
}

/// All ids of the page.
pub(super) fn collect(document: &Document) -> Result<BTreeSet<String>, Error> {
    let mut ids: BTreeSet<String> = OF_THE_PAGE.iter().map(|id| (*id).to_string()).collect();
    let claims = document.claims.iter().map(|claim| claim.id.clone());
    let audit = document.audit.iter().map(|item| item.id.clone());
    let deviations = document
        .deviations
        .iter()
        .map(|item| format!("deviation-{}", item.claim));
    let questions = document.checklist.iter().map(|item| item.id.clone());
    for id in claims.chain(audit).chain(deviations).chain(questions) {
        add(id, &mut ids)?;
    }
    for section in &document.sections {
        add(section.id.clone(), &mut ids)?;
        for block in &section.blocks {
            let id = match block {
                Block::Heading(id, _) => id,
                Block::Figure(figure) => &figure.id,
                Block::Table(table) => &table.id,
                Block::Equation(equation) => &equation.id,
                Block::Chain(chain) => &chain.id,
                Block::Prose(_) | Block::List(_) | Block::Notice(_) => continue,
            };
            add(id.clone(), &mut ids)?;
        }
    }
    Ok(ids)
}

fn add(id: String, ids: &mut BTreeSet<String>) -> Result<(), Error> {
    if ids.insert(id.clone()) {
        Ok(())
    } else {
        Err(Error::DoubledId(id))
    }
}

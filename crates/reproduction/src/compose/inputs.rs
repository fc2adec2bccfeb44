//! What a figure or table was made from, where its stage did not say more closely: the stage's own inputs.

use std::collections::BTreeMap;

use report::figure::Provenance;
use report::{Block, Section};

/// Sections whose figures and tables all name their inputs with the hashes that the stage was run with.
pub(super) fn with_inputs(
    mut sections: Vec<Section>,
    inputs: &BTreeMap<String, String>,
) -> Vec<Section> {
    for block in sections.iter_mut().flat_map(|section| &mut section.blocks) {
        match block {
            Block::Figure(figure) => fill(&mut figure.provenance, &figure.id, inputs),
            Block::Table(table) => {
                if let Some(made) = &mut table.provenance {
                    fill(made, &table.id, inputs);
                }
            }
            _ => {}
        }
    }
    sections
}

fn fill(made: &mut Provenance, id: &str, inputs: &BTreeMap<String, String>) {
    if !made.inputs.is_empty() {
        return;
    }
    let own = campaign_of(id, inputs);
    made.inputs = inputs
        .iter()
        .filter(|(path, _)| {
            own.is_none_or(|own| campaign(path).is_none_or(|campaign| campaign == own))
        })
        .map(|(path, hash)| (path.clone(), hash.clone()))
        .collect();
}

/// The campaign that a file belongs to.
fn campaign(path: &str) -> Option<&str> {
    path.strip_prefix("data/campaigns/")?.split('/').next()
}

/// The campaign that an id names after its stage (`diagnosis-brush-3x3-aluminium-laws`); the longest name where one
/// begins with another.
fn campaign_of<'a>(id: &str, inputs: &'a BTreeMap<String, String>) -> Option<&'a str> {
    let (_, rest) = id.split_once('-')?;
    inputs
        .keys()
        .filter_map(|path| campaign(path))
        .filter(|name| {
            rest.strip_prefix(name)
                .is_some_and(|rest| rest.starts_with('-'))
        })
        .max_by_key(|name| name.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A campaign's card names its own files; a card that names no campaign has all of the stage's.
    #[test]
    fn the_longest_name_of_a_campaign_wins() {
        let inputs: BTreeMap<String, String> = [
            "data/published.toml",
            "data/campaigns/brush/a.csv",
            "data/campaigns/brush-cord/a.csv",
        ]
        .into_iter()
        .map(|path| (path.to_owned(), "hash".to_owned()))
        .collect();
        let count = |id: &str| {
            let mut made = Provenance::default();
            fill(&mut made, id, &inputs);
            made.inputs.into_keys().collect::<Vec<_>>()
        };
        assert_eq!(
            count("diagnosis-brush-cord-laws"),
            ["data/campaigns/brush-cord/a.csv", "data/published.toml"]
        );
        assert_eq!(
            count("diagnosis-brush-laws"),
            ["data/campaigns/brush/a.csv", "data/published.toml"]
        );
        assert_eq!(count("fig-10").len(), 3);
    }
}

//! What benchmarks counted: how often 95 % intervals hold the truth, how often the diagnosis names the right cause. They
//! cost too much for every run: their counts lie in `data/`, and say so where they were counted with another program.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use report::figure::Provenance;
use report::{Block, Cell, Column, Evidence, NoticeKind, Section, Table, Value, literal, typeset};
use serde_json::Value as Json;

/// Counts as they lie in `data/`.
#[derive(Clone, Debug, Default)]
pub struct Benchmarks {
    /// `data/coverage.json`.
    pub coverage: Option<Json>,
    /// `data/hidden-effects.json`.
    pub hidden_effects: Option<Json>,
    /// Hash of each of these files, by its path in the repository.
    pub hashes: BTreeMap<String, String>,
    /// Fingerprint of the diagnosis as it is now.
    pub diagnosis: String,
}

impl Benchmarks {
    /// Reads what there is below the repository's root; a file that is not there was not measured.
    ///
    /// # Errors
    /// A file that is there and cannot be read.
    pub fn read(root: &Path) -> Result<Self, String> {
        let mut hashes = BTreeMap::new();
        let mut file = |name: &str| -> Result<Option<Json>, String> {
            let path = root.join("data").join(name);
            if !path.is_file() {
                return Ok(None);
            }
            let refuse = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
            let text = std::fs::read_to_string(&path).map_err(|error| refuse(&error))?;
            let hash = blake3::hash(text.as_bytes()).to_hex().to_string();
            hashes.insert(format!("data/{name}"), hash);
            serde_json::from_str(&text)
                .map(Some)
                .map_err(|error| refuse(&error))
        };
        let coverage = file("coverage.json")?;
        let hidden_effects = file("hidden-effects.json")?;
        Ok(Self {
            coverage,
            hidden_effects,
            hashes,
            diagnosis: diagnosis_fingerprint(root),
        })
    }
}

/// Sixteen hexadecimal digits that change with any source file of the crates that make a diagnosis (FNV-1a, 64 bits), as
/// the benchmark of hidden effects writes them into its counts.
#[must_use]
pub fn diagnosis_fingerprint(root: &Path) -> String {
    let mut files = Vec::new();
    for name in ["campaign", "friction", "rig", "fitting", "diagnosis"] {
        sources(&root.join("crates").join(name).join("src"), &mut files);
    }
    files.sort();
    let mut hash: u64 = 0xcbf2_9ce4_8422_2325;
    for file in files {
        for byte in std::fs::read(&file).unwrap_or_default() {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
    format!("{hash:016x}")
}

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    let Ok(listing) = std::fs::read_dir(folder) else {
        return;
    };
    for path in listing.flatten().map(|entry| entry.path()) {
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|end| end == "rs") {
            found.push(path);
        }
    }
}

/// The chapter.
pub(super) fn section(benchmarks: &Benchmarks, values: &BTreeMap<String, Value>) -> Section {
    let mut blocks = vec![Block::heading(
        "benchmarks-coverage",
        "Do 95 % intervals hold?",
    )];
    match &benchmarks.coverage {
        Some(counts) => coverage(benchmarks, counts, values, &mut blocks),
        None => blocks.push(not_measured("coverage")),
    }
    blocks.push(Block::heading(
        "benchmarks-hidden-effects",
        "Does the diagnosis name what was hidden?",
    ));
    match &benchmarks.hidden_effects {
        Some(counts) => hidden_effects(benchmarks, counts, &mut blocks),
        None => blocks.push(not_measured("hidden-effects")),
    }
    Section {
        id: "benchmarks".into(),
        title: "How often the program is right".into(),
        lead: "Counts over simulated campaigns whose truth is known. They are made apart from this run, because they take hours, and are shown as they were counted.".into(),
        blocks,
        ..Section::default()
    }
}

fn not_measured(name: &str) -> Block {
    Block::notice(
        NoticeKind::Caution,
        "Not measured",
        literal(&format!(
            "No counts lie in data/{name}.json; cargo xtask bench {name} makes them."
        )),
    )
}

fn stale(what: &str) -> Block {
    Block::notice(
        NoticeKind::Caution,
        "Counted with another program",
        literal(&format!(
            "The counts below were made before the {what} changed: they no longer speak for it."
        )),
    )
}

fn text(json: &Json) -> String {
    json.as_str()
        .map_or_else(|| json.to_string(), str::to_owned)
}

/// The file that a table was counted into.
#[track_caller]
fn provenance(benchmarks: &Benchmarks, function: &str, file: &str) -> Provenance {
    let made = Provenance::here("benchmarks", function);
    match benchmarks.hashes.get(file) {
        Some(hash) => made.with_input(file, hash),
        None => made,
    }
}

fn coverage(
    benchmarks: &Benchmarks,
    counts: &Json,
    values: &BTreeMap<String, Value>,
    blocks: &mut Vec<Block>,
) {
    let campaigns = counts["campaigns"].as_object().into_iter().flatten();
    let mut rows = Vec::new();
    let mut changed = false;
    for (name, campaign) in campaigns {
        let total = campaign["campaigns"].as_f64().unwrap_or(0.0);
        let resampled = campaign["resampled"].as_f64().unwrap_or(0.0);
        for parameter in campaign["parameters"].as_array().into_iter().flatten() {
            changed |= !still_so(name, parameter, values);
            let share = |key: &str, of: f64| {
                Cell::from(100.0 * parameter[key].as_f64().unwrap_or(f64::NAN) / of)
            };
            let covered = parameter["covered"].as_f64().unwrap_or(f64::NAN) / total;
            let error = 100.0 * (covered * (1.0 - covered) / total).sqrt();
            rows.push(vec![
                Cell::Prose(typeset(&format!("{name}, {}", text(&parameter["name"]))).into()),
                Cell::Number(total),
                share("covered", total),
                Cell::from(error),
                share("above", total),
                share("below", total),
                share("at_bound", total),
                share("bootstrap_covered", resampled),
            ]);
        }
    }
    if changed {
        blocks.push(stale("identification"));
    }
    blocks.push(Block::prose(literal(&format!(
        "Counted at commit {}, seed {}. Campaigns that did not converge count as not covered. A parameter whose truth lies on its bound has a one-sided interval.",
        text(&counts["commit"]),
        text(&counts["seed"])
    ))));
    let number = |name: &str, unit: &str| Column::number(name, unit);
    blocks.push(
        Table {
            id: "coverage".into(),
            title: "Share of nominal 95 % intervals that hold the truth".into(),
            caption: "Campaigns simulated from the identified parameters and noise of a stand-in, identified like any other. Bootstrap: percentile intervals over resampled runs, for comparison; with three repeats they are too narrow.".into(),
            columns: vec![
                Column::text("campaign, parameter"),
                number("campaigns", "1"),
                number("covered", "%"),
                number("standard error", "%"),
                number("interval above", "%"),
                number("interval below", "%"),
                number("on a bound", "%"),
                number("bootstrap covered", "%"),
            ],
            rows,
            evidence: Some(Evidence::Synthetic),
            provenance: Some(provenance(benchmarks, "coverage", "data/coverage.json")),
            ..Table::default()
        }
        .into(),
    );
}

/// Whether this run still identifies what the counts started from, to a fiftieth of the interval.
fn still_so(campaign: &str, parameter: &Json, values: &BTreeMap<String, Value>) -> bool {
    let material = campaign.trim_start_matches("brush-2x2-");
    let id = format!("identification.{material}.{}", text(&parameter["name"]));
    let Some(value) = values.get(&id) else {
        // The identification was not run: nothing to compare.
        return true;
    };
    let then = [
        parameter["estimate"].as_f64(),
        parameter["ci95"][0].as_f64(),
        parameter["ci95"][1].as_f64(),
    ];
    let now = [
        value.value,
        value.ci95.map(|ends| ends[0]),
        value.ci95.map(|ends| ends[1]),
    ];
    let width = value.ci95.map_or(0.0, |ends| ends[1] - ends[0]);
    then.iter().zip(now).all(|(then, now)| match (then, now) {
        (Some(then), Some(now)) => (then - now).abs() <= 0.02 * width,
        _ => true,
    })
}

fn hidden_effects(benchmarks: &Benchmarks, counts: &Json, blocks: &mut Vec<Block>) {
    if counts["diagnosis"].as_str() != Some(&benchmarks.diagnosis) {
        blocks.push(stale("diagnosis"));
    }
    blocks.push(Block::prose(literal(&format!(
        "{} trials, {} seeds from {}.",
        text(&counts["cases"]),
        text(&counts["season"]),
        text(&counts["first_seed"])
    ))));
    let mut rows = Vec::new();
    let mut add = |what: String, share: &Json| {
        let (Some(cases), Some(hits)) = (share["cases"].as_f64(), share["hits"].as_f64()) else {
            return;
        };
        if cases > 0.0 {
            rows.push(vec![
                Cell::Text(what),
                Cell::Number(cases),
                Cell::Number(hits),
                exact(share),
            ]);
        }
    };
    add(
        "nothing hidden: something named".into(),
        &counts["nothing"]["named"],
    );
    for row in counts["power"].as_array().into_iter().flatten() {
        for (key, words) in [
            ("detected", "noticed"),
            ("exact_set", "exactly the right set named"),
            ("truth_in_set", "the truth among the named"),
            ("wrong_name", "a wrong name"),
        ] {
            let what = format!("one cause at {} times the threshold: {words}", row["ratio"]);
            add(what, &row[key]);
        }
    }
    add(
        "an error from outside the catalogue: its place right".into(),
        &counts["alien_places"],
    );
    add(
        "intervals of sizes that hold the truth".into(),
        &counts["coverage"]["of_95"],
    );
    add(
        "reported gain within 0.1 of the true one".into(),
        &counts["gain"]["within_0.1"],
    );
    blocks.push(
        Table {
            id: "hidden-effects".into(),
            title: "What the diagnosis answers to hidden effects".into(),
            caption: "Effects of known cause and size hidden in synthetic campaigns by an independent simulator; exact 95 % intervals (Clopper-Pearson). The threshold is the size at which the best test that knows the cause would notice it.".into(),
            columns: vec![
                Column::text("what"),
                Column::number("cases", "1"),
                Column::number("hits", "1"),
                Column::number("share", "%"),
            ],
            rows,
            evidence: Some(Evidence::Synthetic),
            provenance: Some(provenance(benchmarks, "hidden_effects", "data/hidden-effects.json")),
            ..Table::default()
        }
        .into(),
    );
    blocks.push(groups(benchmarks, counts));
}

/// A share with its exact interval, percent.
fn exact(share: &Json) -> Cell {
    let percent = |x: &Json| x.as_f64().map_or(f64::NAN, |x| 100.0 * x);
    let ends = [percent(&share["ci95"][0]), percent(&share["ci95"][1])];
    match percent(&share["share"]) {
        middle if middle.is_finite() => Cell::Interval(middle, ends),
        _ => Cell::Missing("not counted".into()),
    }
}

/// Verdicts by group of trials.
fn groups(benchmarks: &Benchmarks, counts: &Json) -> Block {
    let groups = [
        ("pairs", "two causes"),
        ("triples", "three causes"),
        ("second_shapes", "a cause of another shape"),
        ("other_laws", "another law"),
        ("aliens", "causes outside the catalogue"),
        ("control", "a cause that was taken out of the catalogue"),
    ];
    let rows = groups
        .iter()
        .filter_map(|(key, words)| {
            let group = counts[*key].as_object()?;
            let cases = group.get("cases")?.as_f64().filter(|cases| *cases > 0.0)?;
            let verdicts: Vec<String> = group
                .iter()
                .filter_map(|(name, count)| Some((name, count.as_u64()?)))
                .filter(|(name, _)| *name != "cases")
                .map(|(name, count)| format!("{count} {name}"))
                .collect();
            Some(vec![
                Cell::Text((*words).to_owned()),
                Cell::Number(cases),
                Cell::Text(verdicts.join(", ")),
                exact(&group["exact"]),
            ])
        })
        .collect();
    Table {
        id: "hidden-effects-groups".into(),
        title: "Answers by group of trials".into(),
        caption: "Right: exactly the set that the protocol allows, and for what is outside the catalogue no name. Loose: the truth among more names than need be. Refused: the misfit is seen and no name is given. Missed: nothing is seen. Wrong: a name that is not the truth.".into(),
        columns: vec![
            Column::text("hidden"),
            Column::number("cases", "1"),
            Column::text("answers"),
            Column::number("exactly right", "%"),
        ],
        rows,
        evidence: Some(Evidence::Synthetic),
        provenance: Some(provenance(benchmarks, "groups", "data/hidden-effects.json")),
        ..Table::default()
    }
    .into()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(low: f64, high: f64) -> BTreeMap<String, Value> {
        let id = "identification.nylon.sigma0";
        let value = Value::new(id, 1.0, "1/rad", "identification", Evidence::Synthetic);
        BTreeMap::from([(id.to_owned(), value.with_ci95(low, high))])
    }

    /// Counts that started from other intervals are marked; those that started from these are not.
    #[test]
    fn counts_of_another_identification_are_stale() {
        let parameter = serde_json::json!({"name": "sigma0", "estimate": 1.0, "ci95": [0.9, 1.1]});
        let same = |values| still_so("brush-2x2-nylon", &parameter, &values);
        assert!(same(value(0.9, 1.1)));
        assert!(same(value(0.9001, 1.1)));
        assert!(!same(value(0.88, 1.1)));
        assert!(same(BTreeMap::new()));
    }

    #[test]
    fn what_is_missing_is_called_not_measured() {
        let found = section(&Benchmarks::default(), &BTreeMap::new());
        let missing = found
            .blocks
            .iter()
            .filter(|block| matches!(block, Block::Notice(n) if n.title == "Not measured"))
            .count();
        assert_eq!(missing, 2);
    }
}

//! Adds up judged trials into the table that the report shows.

use crate::hidden::judge::{Judgement, Verdict};
use crate::hidden::selection::{Group, Season, Trial};
use crate::proportion::clopper_pearson;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;

/// One trial, carried out and judged.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Judged {
    /// The trial, sizes set.
    pub trial: Trial,
    /// Causes that the protocol cannot tell from the planted one.
    pub forced: Vec<String>,
    /// Distance of the planted effect from the law alone, standard deviations.
    pub distance: f64,
    /// `None` where the law absorbs the effect at any size: listed, not counted.
    pub judgement: Option<Judgement>,
    /// Share of the effect that the named extension truly removes, if it was computed.
    pub true_gain: Option<f64>,
}

fn share(hits: usize, trials: usize) -> Value {
    let (low, high) = clopper_pearson(hits, trials);
    json!({
        "cases": trials,
        "hits": hits,
        "share": if trials > 0 { Some(hits as f64 / trials as f64) } else { None },
        "ci95": if trials > 0 { Some([low, high]) } else { None },
    })
}

/// Rows of counted trials of some groups.
fn counted<'a>(
    all: &'a [Judged],
    groups: &'a [Group],
) -> impl Iterator<Item = (&'a Judged, &'a Judgement)> {
    all.iter()
        .filter(move |judged| groups.contains(&judged.trial.group))
        .filter_map(|judged| {
            judged
                .judgement
                .as_ref()
                .map(|judgement| (judged, judgement))
        })
}

fn verdict_counts<'a>(rows: impl Iterator<Item = &'a Judgement>) -> Map<String, Value> {
    let mut counts: BTreeMap<Verdict, usize> = BTreeMap::new();
    let mut total = 0;
    for judgement in rows {
        *counts.entry(judgement.verdict).or_default() += 1;
        total += 1;
    }
    let mut map = Map::new();
    map.insert("cases".into(), json!(total));
    for (verdict, count) in counts {
        let name = serde_json::to_value(verdict)
            .ok()
            .and_then(|v| v.as_str().map(String::from))
            .unwrap_or_default();
        map.insert(name, json!(count));
    }
    map
}

fn nothing(all: &[Judged]) -> Value {
    let mut by_kind: BTreeMap<(String, String), (usize, usize, usize)> = BTreeMap::new();
    let mut by_noise: BTreeMap<String, (usize, usize, usize)> = BTreeMap::new();
    let mut total = (0, 0, 0);
    for (judged, judgement) in counted(all, &[Group::Nothing]) {
        let noise = judged.trial.case.noise.id().to_string();
        let key = (noise.clone(), judged.trial.case.protocol.id().to_string());
        for entry in [
            by_kind.entry(key).or_default(),
            by_noise.entry(noise).or_default(),
            &mut total,
        ] {
            entry.0 += 1;
            entry.1 += usize::from(!judgement.named.is_empty());
            entry.2 += usize::from(judgement.verdict == Verdict::Refused);
        }
    }
    let rows: Vec<Value> = by_kind
        .into_iter()
        .map(|((noise, protocol), (cases, named, refused))| {
            json!({"noise": noise, "protocol": protocol, "cases": cases, "named": named, "unexplained": refused})
        })
        .collect();
    let kinds: Vec<Value> = by_noise
        .into_iter()
        .map(|(noise, (cases, named, refused))| {
            json!({"noise": noise, "named": share(named, cases), "unexplained": share(refused, cases)})
        })
        .collect();
    json!({
        "named": share(total.1, total.0),
        "unexplained": share(total.2, total.0),
        "by_noise": kinds,
        "rows": rows,
    })
}

/// Cause, protocol, size over the threshold.
type Cell = (String, String, String);

fn singles(all: &[Judged], groups: &[Group]) -> Value {
    let mut by_key: BTreeMap<Cell, Vec<(&Judged, &Judgement)>> = BTreeMap::new();
    for (judged, judgement) in counted(all, groups) {
        let planted = &judged.trial.case.planted[0];
        let key = (
            planted.id.clone(),
            judged.trial.case.protocol.id().to_string(),
            format!("{:05.1}", judged.trial.ratio),
        );
        by_key.entry(key).or_default().push((judged, judgement));
    }
    let rows: Vec<Value> = by_key
        .into_iter()
        .map(|((cause, protocol, ratio), rows)| {
            let mut row = verdict_counts(rows.iter().map(|(_, judgement)| *judgement));
            let sizes: Vec<usize> = rows
                .iter()
                .flat_map(|(_, j)| j.named.first().map(Vec::len))
                .collect();
            let forced: usize = rows.iter().map(|(judged, _)| judged.forced.len()).sum();
            row.insert("cause".into(), json!(cause));
            row.insert("protocol".into(), json!(protocol));
            row.insert("ratio".into(), json!(ratio.parse::<f64>().ok()));
            row.insert(
                "mean_forced_set".into(),
                json!(forced as f64 / rows.len() as f64),
            );
            if !sizes.is_empty() {
                row.insert(
                    "mean_named_set".into(),
                    json!(sizes.iter().sum::<usize>() as f64 / sizes.len() as f64),
                );
            }
            Value::Object(row)
        })
        .collect();
    Value::Array(rows)
}

/// Shares against size, over all causes and protocols.
fn power(all: &[Judged]) -> Value {
    let mut by_ratio: BTreeMap<String, Vec<&Judgement>> = BTreeMap::new();
    for (judged, judgement) in counted(all, &[Group::Single]) {
        by_ratio
            .entry(format!("{:05.1}", judged.trial.ratio))
            .or_default()
            .push(judgement);
    }
    let rows: Vec<Value> = by_ratio
        .into_iter()
        .map(|(ratio, rows)| {
            let count =
                |accept: &[Verdict]| rows.iter().filter(|j| accept.contains(&j.verdict)).count();
            let detected = rows.iter().filter(|j| j.verdict != Verdict::Missed).count();
            json!({
                "ratio": ratio.parse::<f64>().ok(),
                "detected": share(detected, rows.len()),
                "exact_set": share(count(&[Verdict::Right]), rows.len()),
                "truth_in_set": share(
                    count(&[Verdict::Right, Verdict::Loose, Verdict::Tight, Verdict::Surplus]),
                    rows.len()
                ),
                "wrong_name": share(count(&[Verdict::Wrong, Verdict::Surplus]), rows.len()),
            })
        })
        .collect();
    Value::Array(rows)
}

/// How often each truth was answered by each first name.
fn confusion(all: &[Judged]) -> Value {
    let mut matrix: BTreeMap<String, BTreeMap<String, usize>> = BTreeMap::new();
    for (judged, judgement) in counted(
        all,
        &[
            Group::Nothing,
            Group::Single,
            Group::SecondShape,
            Group::Alien,
        ],
    ) {
        let truth = judged
            .trial
            .case
            .planted
            .first()
            .map_or("nothing".to_string(), |planted| planted.id.clone());
        let row = matrix.entry(truth.clone()).or_default();
        // A set counts for the truth if it holds it, else for its first member.
        let answer = match judgement.named.first() {
            Some(set) if set.contains(&truth) => truth,
            Some(set) => set[0].clone(),
            None => judgement.status.clone(),
        };
        *row.entry(answer).or_default() += 1;
    }
    json!(matrix)
}

fn coverage(all: &[Judged]) -> Value {
    let (mut inside, mut total) = (0, 0);
    let mut by_parameter: BTreeMap<String, (usize, usize)> = BTreeMap::new();
    for (judged, judgement) in counted(all, &[Group::Single, Group::Pair]) {
        if judged.trial.ratio < 2.5 {
            continue;
        }
        for interval in &judgement.intervals {
            if let Some(hit) = interval.inside {
                total += 1;
                inside += usize::from(hit);
                let entry = by_parameter.entry(interval.parameter.clone()).or_default();
                entry.0 += usize::from(hit);
                entry.1 += 1;
            }
        }
    }
    let rows: Vec<Value> = by_parameter
        .into_iter()
        .map(|(parameter, (inside, cases))| json!({"parameter": parameter, "inside": inside, "cases": cases}))
        .collect();
    json!({"of_95": share(inside, total), "rows": rows})
}

fn gains(all: &[Judged]) -> Value {
    let pairs: Vec<(f64, f64)> = counted(all, &[Group::Single, Group::Pair, Group::SecondShape])
        .filter_map(|(judged, judgement)| Some((judgement.reported_gain?, judged.true_gain?)))
        .collect();
    let within = pairs
        .iter()
        .filter(|(reported, truth)| (reported - truth).abs() <= 0.1)
        .count();
    json!({"within_0.1": share(within, pairs.len())})
}

fn places(all: &[Judged]) -> Value {
    let answers: Vec<bool> = counted(all, &[Group::Alien])
        .filter_map(|(_, judgement)| judgement.place_right)
        .collect();
    share(
        answers.iter().filter(|right| **right).count(),
        answers.len(),
    )
}

/// The table.
pub fn table(season: Season, identity: &str, all: &[Judged]) -> Value {
    let group = |groups: &[Group]| {
        let rows: Vec<&Judgement> = counted(all, groups)
            .map(|(_, judgement)| judgement)
            .collect();
        let right = rows.iter().filter(|j| j.verdict == Verdict::Right).count();
        let exact = share(right, rows.len());
        let mut counts = verdict_counts(rows.into_iter());
        counts.insert("exact".into(), exact);
        Value::Object(counts)
    };
    let absorbed: BTreeMap<String, Vec<String>> = all
        .iter()
        .filter(|judged| judged.judgement.is_none())
        .fold(BTreeMap::new(), |mut map, judged| {
            let protocols: &mut Vec<String> = map
                .entry(
                    judged
                        .trial
                        .case
                        .planted
                        .first()
                        .map(|p| p.id.clone())
                        .unwrap_or_default(),
                )
                .or_default();
            let id = judged.trial.case.protocol.id().to_string();
            if !protocols.contains(&id) {
                protocols.push(id);
                protocols.sort();
            }
            map
        });
    json!({
        "schema": "bristle/hidden-effects/1",
        "season": season,
        "first_seed": season.first_seed(),
        "diagnosis": identity,
        "cases": all.len(),
        "nothing": nothing(all),
        "power": power(all),
        "singles": singles(all, &[Group::Single]),
        "second_shapes": group(&[Group::SecondShape]),
        "other_laws": group(&[Group::OtherLaw]),
        "pairs": group(&[Group::Pair]),
        "triples": group(&[Group::Triple]),
        "aliens": group(&[Group::Alien]),
        "alien_places": places(all),
        "control": group(&[Group::Control]),
        "coverage": coverage(all),
        "gain": gains(all),
        "confusion": confusion(all),
        "absorbed_by_the_law": absorbed,
    })
}

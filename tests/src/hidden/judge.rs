//! Judges one answer against its key.

use planting::Key;
use planting::effect::Effect;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// What an answer was worth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Named exactly what the protocol forces; nothing said where nothing was; refused on aliens.
    Right,
    /// The truth is in the named set, the set is larger than it had to be.
    Loose,
    /// The truth is named, the set is smaller than the protocol allows one to say: lucky.
    Tight,
    /// The truth is named, and something else beside it.
    Surplus,
    /// Of several planted, some are named and nothing false is.
    Partial,
    /// Structure is reported, no name is given.
    Refused,
    /// Nothing is reported although something was planted.
    Missed,
    /// A name is given that is not the truth and no name is.
    Wrong,
}

/// An interval against the truth.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Covered {
    /// Cause and parameter.
    pub parameter: String,
    /// Reported value.
    pub value: f64,
    /// Truth.
    pub truth: f64,
    /// Whether the interval holds the truth; `None` without an interval.
    pub inside: Option<bool>,
}

/// The judgement of one case.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Judgement {
    /// The verdict.
    pub verdict: Verdict,
    /// Status as reported.
    pub status: String,
    /// Named sets, one a finding.
    pub named: Vec<Vec<String>>,
    /// Intervals.
    pub intervals: Vec<Covered>,
    /// Reported share of the explainable error that the findings remove.
    pub reported_gain: Option<f64>,
    /// Place of what is unexplained, as reported.
    pub place: Option<Value>,
    /// For aliens with a place: whether the reported place overlaps it.
    pub place_right: Option<bool>,
}

/// Sets of names in an answer: a finding's cause with its equivalents.
pub fn named_sets(answer: &Value) -> Vec<Vec<String>> {
    let text = |value: &Value| value.as_str().unwrap_or_default().to_string();
    answer["findings"]
        .as_array()
        .map(|findings| {
            findings
                .iter()
                .map(|finding| {
                    let mut set = vec![text(&finding["cause"])];
                    set.extend(
                        finding["equivalent"]
                            .as_array()
                            .into_iter()
                            .flatten()
                            .map(text),
                    );
                    set.sort();
                    set.dedup();
                    set
                })
                .collect()
        })
        .unwrap_or_default()
}

/// Judges an answer. `forced`: the causes that the protocol cannot tell from the planted one (one planted), or the
/// planted ones.
pub fn judge(answer: &Value, key: &Key, forced: &[String]) -> Judgement {
    let status = answer["status"].as_str().unwrap_or_default().to_string();
    let named = named_sets(answer);
    let truth: Vec<&str> = key
        .effects
        .iter()
        .filter(|effect| !effect.is_alien())
        .map(Effect::id)
        .collect();
    let alien = key.effects.iter().any(Effect::is_alien);
    let detected = status == "unexplained";
    let verdict = verdict(&named, &truth, alien, detected, forced);
    let place = answer["unexplained"]["where"].clone();
    Judgement {
        verdict,
        status,
        intervals: intervals(answer, key),
        reported_gain: reported_gain(answer),
        place_right: key
            .effects
            .iter()
            .find_map(|effect| overlaps(effect, &place)),
        place: (!place.is_null()).then_some(place),
        named,
    }
}

fn verdict(
    named: &[Vec<String>],
    truth: &[&str],
    alien: bool,
    detected: bool,
    forced: &[String],
) -> Verdict {
    let holds = |set: &Vec<String>, id: &str| set.iter().any(|name| name == id);
    let false_sets = named
        .iter()
        .filter(|set| !truth.iter().any(|id| holds(set, id)))
        .count();
    let found = truth
        .iter()
        .filter(|id| named.iter().any(|set| holds(set, id)))
        .count();
    if alien && truth.is_empty() {
        return match (named.is_empty(), detected) {
            (true, true) => Verdict::Right,
            (true, false) => Verdict::Missed,
            (false, _) => Verdict::Wrong,
        };
    }
    if truth.is_empty() {
        return match (named.is_empty(), detected) {
            (true, false) => Verdict::Right,
            (true, true) => Verdict::Refused,
            (false, _) => Verdict::Wrong,
        };
    }
    if false_sets > 0 {
        return if found == truth.len() {
            Verdict::Surplus
        } else {
            Verdict::Wrong
        };
    }
    if found == 0 {
        return if detected {
            Verdict::Refused
        } else {
            Verdict::Missed
        };
    }
    if found < truth.len() {
        return Verdict::Partial;
    }
    if truth.len() > 1 {
        // Each planted cause must be a finding of its own.
        return if named.len() >= truth.len() {
            Verdict::Right
        } else {
            Verdict::Loose
        };
    }
    let set = &named[0];
    if named.len() > 1 {
        Verdict::Surplus
    } else if set.iter().any(|name| !forced.contains(name)) {
        Verdict::Loose
    } else if forced.iter().any(|name| !set.contains(name)) {
        Verdict::Tight
    } else {
        Verdict::Right
    }
}

/// What an answer to something whose cause was taken out of the catalogue was worth. `twins`: the causes that the protocol cannot
/// tell from it; where there are others than itself, their names are what the data say.
pub fn verdict_of_stranger(judgement: &Judgement, twins: &[String]) -> Verdict {
    let named = judgement.named.iter().flatten();
    if twins.len() > 1 && named.clone().count() > 0 && named.clone().all(|n| twins.contains(n)) {
        return Verdict::Right;
    }
    verdict(
        &judgement.named,
        &[],
        true,
        judgement.status == "unexplained",
        &[],
    )
}

/// Reported parameters of the truly planted causes against the key (catalogue shapes only).
fn intervals(answer: &Value, key: &Key) -> Vec<Covered> {
    let mut covered = Vec::new();
    for effect in key
        .effects
        .iter()
        .filter(|effect| effect.has_catalogue_shape())
    {
        let finding = answer["findings"]
            .as_array()
            .into_iter()
            .flatten()
            .find(|f| f["cause"] == effect.id());
        let Some(finding) = finding else { continue };
        for (name, truth) in effect.sizes() {
            let parameter = finding["parameters"]
                .as_array()
                .into_iter()
                .flatten()
                .find(|p| p["name"] == name);
            let Some(parameter) = parameter else { continue };
            let Some(value) = parameter["value"].as_f64() else {
                continue;
            };
            let inside = match (parameter["ci95"][0].as_f64(), parameter["ci95"][1].as_f64()) {
                (Some(low), Some(high)) => Some(low <= truth && truth <= high),
                _ => None,
            };
            covered.push(Covered {
                parameter: format!("{}.{name}", effect.id()),
                value,
                truth,
                inside,
            });
        }
    }
    covered
}

/// The joint gain, or that of the only finding.
fn reported_gain(answer: &Value) -> Option<f64> {
    answer["gain"]["explained_fraction"]
        .as_f64()
        .or_else(|| answer["findings"][0]["gain"]["explained_fraction"].as_f64())
}

/// For an alien with a place on the plate or in time: whether the reported interval holds or touches it.
fn overlaps(effect: &Effect, place: &Value) -> Option<bool> {
    let (axis, low, high, margin) = match *effect {
        Effect::Scratch { at_m, width_m, .. } => {
            ("position", at_m - 2.0 * width_m, at_m + 2.0 * width_m, 0.01)
        }
        Effect::PlateStep { at_m, .. } => ("position", at_m, at_m, 0.02),
        Effect::StickSlipBurst { from_s, to_s, .. } => ("time", from_s, to_s, 0.5),
        Effect::Dropout { from_s, to_s, .. } => ("time", from_s, to_s, 0.1),
        _ => return None,
    };
    if place["axis"] != axis {
        return Some(false);
    }
    let (from, to) = (place["from"].as_f64()?, place["to"].as_f64()?);
    Some(from - margin <= high && low <= to + margin)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sets(names: &[&[&str]]) -> Vec<Vec<String>> {
        names
            .iter()
            .map(|set| set.iter().map(|name| (*name).to_string()).collect())
            .collect()
    }

    #[test]
    fn verdicts() {
        let forced = vec!["wear".to_string(), "thermal-softening".to_string()];
        let judged = |named: &[&[&str]], detected| {
            verdict(&sets(named), &["wear"], false, detected, &forced)
        };
        assert_eq!(
            judged(&[&["thermal-softening", "wear"]], false),
            Verdict::Right
        );
        assert_eq!(judged(&[&["wear"]], false), Verdict::Tight);
        assert_eq!(
            judged(&[&["sensor-lag", "thermal-softening", "wear"]], false),
            Verdict::Loose
        );
        assert_eq!(
            judged(&[&["wear"], &["sensor-lag"]], false),
            Verdict::Surplus
        );
        assert_eq!(judged(&[&["sensor-lag"]], false), Verdict::Wrong);
        assert_eq!(judged(&[], true), Verdict::Refused);
        assert_eq!(judged(&[], false), Verdict::Missed);
        let pair =
            |named: &[&[&str]]| verdict(&sets(named), &["wear", "sensor-lag"], false, false, &[]);
        assert_eq!(pair(&[&["wear"], &["sensor-lag"]]), Verdict::Right);
        assert_eq!(pair(&[&["sensor-lag", "wear"]]), Verdict::Loose);
        assert_eq!(pair(&[&["wear"]]), Verdict::Partial);
        assert_eq!(verdict(&sets(&[]), &[], true, true, &[]), Verdict::Right);
        assert_eq!(
            verdict(&sets(&[&["wear"]]), &[], true, true, &[]),
            Verdict::Wrong
        );
    }
}

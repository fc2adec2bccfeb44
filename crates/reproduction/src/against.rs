//! What changed against an earlier report: the results that it embeds, set beside the present ones.

mod flips;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use report::{Drift, DriftClass, DriftRow};
use serde_json::Value as Json;

use crate::published::PublishedError;

pub use flips::Rules;

/// Element of the page that holds the results.
const OPEN: &str = "<script type=\"application/json\" id=\"results\">";
/// Element that holds the facts of its run.
const FACTS: &str = "<script type=\"application/json\" id=\"run-facts\">";
const CLOSE: &str = "</script>";

/// An earlier report that cannot be compared with.
#[derive(Debug, thiserror::Error)]
pub enum AgainstError {
    /// It cannot be read.
    #[error("{}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// It holds no results.
    #[error("{}: {problem}", path.display())]
    NoResults {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        problem: String,
    },
}

/// What an earlier report embeds.
#[derive(Clone, Debug, PartialEq)]
pub struct Earlier {
    /// Its results.
    pub results: Json,
    /// Target and compiler that made it; empty where it does not say.
    pub platform: Platform,
}

/// What a program was compiled for, and with what.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Deserialize)]
#[serde(default)]
pub struct Platform {
    /// Target triple.
    pub target: String,
    /// Compiler.
    pub rustc: String,
}

impl Platform {
    /// That of a run.
    #[must_use]
    pub fn of(run: &report::Run) -> Self {
        Self {
            target: run.target.clone(),
            rustc: run.rustc.clone(),
        }
    }

    fn words(&self) -> String {
        [&self.target, &self.rustc]
            .into_iter()
            .filter(|part| !part.is_empty())
            .cloned()
            .collect::<Vec<_>>()
            .join(", ")
    }

    /// Whether two reports say that they come from two platforms; one that says nothing is taken for the same.
    fn differs(&self, other: &Self) -> bool {
        let apart = |one: &str, other: &str| !one.is_empty() && !other.is_empty() && one != other;
        apart(&self.target, &other.target) || apart(&self.rustc, &other.rustc)
    }
}

/// The text of an embedded element.
fn embedded<'p>(page: &'p str, open: &str) -> Option<Result<&'p str, &'static str>> {
    let (_, rest) = page.split_once(open)?;
    Some(
        rest.split_once(CLOSE)
            .map(|(text, _)| text)
            .ok_or("its results do not end"),
    )
}

/// The results inside an earlier report, and the platform that made it.
///
/// # Errors
/// Where the file cannot be read or embeds no results.
pub fn read(path: &Path) -> Result<Earlier, AgainstError> {
    let page = std::fs::read_to_string(path).map_err(|source| AgainstError::Read {
        path: path.to_owned(),
        source,
    })?;
    let refuse = |problem: &str| AgainstError::NoResults {
        path: path.to_owned(),
        problem: problem.to_owned(),
    };
    let text = embedded(&page, OPEN)
        .ok_or_else(|| refuse("embeds no results"))?
        .map_err(refuse)?;
    let platform = embedded(&page, FACTS).and_then(Result::ok);
    let platform = platform.and_then(|text| serde_json::from_str(text).ok());
    let results: Json = serde_json::from_str(text)
        .map_err(|error| refuse(&format!("its results are not JSON: {error}")))?;
    if results["schema"] == crate::results::SCHEMA {
        Ok(Earlier {
            results,
            platform: platform.unwrap_or_default(),
        })
    } else {
        Err(refuse("its results have another schema"))
    }
}

/// A quantity may move by so much, relative to the larger of both, before a change counts as one of the physics.
///
/// Sums and closed computations are exact to rounding; whatever an iteration ends at depends on where it stops.
#[must_use]
pub fn tolerance(id: &str) -> f64 {
    match id.split('.').next() {
        Some("published" | "audit" | "envelope") => 1e-9,
        Some("gait") => 1e-3,
        _ => 1e-5,
    }
}

/// Sets the present results beside earlier ones. The verdicts of the earlier report are read, and its values are judged
/// anew by the present rules: a value that was altered without its verdict flips its claims all the same.
///
/// # Errors
/// Where a published number that a claim names is missing.
pub fn compare(
    path: &Path,
    earlier: &Earlier,
    new: &Json,
    platform: &Platform,
    rules: &Rules<'_>,
) -> Result<Drift, PublishedError> {
    let old = &earlier.results;
    let differ = Differ {
        inputs: inputs(old) != inputs(new),
        platform: earlier.platform.differs(platform),
    };
    let (old_values, new_values) = (values(old), values(new));
    let verdicts = verdicts(old, new);
    let judged = flips::Judged::new(rules, old, new)?;
    let by_values = judged.by_values(&verdicts);
    let mut unchanged = 0;
    let mut rows = Vec::new();
    let ids: BTreeSet<&String> = old_values.keys().chain(new_values.keys()).collect();
    for id in ids {
        let (before, now) = (old_values.get(id), new_values.get(id));
        let number = |side: Option<&(Option<f64>, String)>| side.and_then(|(value, _)| *value);
        let (a, b) = (number(before), number(now));
        let same_number = a.map(f64::to_bits) == b.map(f64::to_bits);
        if before.is_some() == now.is_some() && same_number {
            unchanged += 1;
            continue;
        }
        rows.push(DriftRow {
            id: id.clone(),
            old: a,
            new: b,
            unit: now
                .or(before)
                .map(|(_, unit)| unit.clone())
                .unwrap_or_default(),
            tolerance_used_percent: used(id, a, b),
            class: class(a, b, used(id, a, b), differ),
            flips: judged.alone(id)?,
        });
    }
    let moved: Vec<&String> = verdicts
        .iter()
        .chain(&by_values)
        .map(|(id, ..)| id)
        .collect();
    share(&mut rows, &moved, old, new);
    Ok(Drift {
        against: path
            .file_name()
            .map(|name| name.to_string_lossy().into_owned())
            .unwrap_or_default(),
        old_identity: report::identity(old),
        unchanged,
        rows,
        verdicts,
        by_values,
        platforms: differ
            .platform
            .then(|| [&earlier.platform, platform].map(Platform::words)),
    })
}

/// How much of the tolerance the difference uses up, percent.
fn used(id: &str, old: Option<f64>, new: Option<f64>) -> Option<f64> {
    let (old, new) = (old?, new?);
    Some(100.0 * (old - new).abs() / (tolerance(id) * old.abs().max(new.abs())))
}

/// Claims that moved although no value alone flips them go to every changed value on which they rest: together they did.
fn share(rows: &mut [DriftRow], moved: &[&String], old: &Json, new: &Json) {
    let alone: BTreeSet<String> = rows.iter().flat_map(|row| row.flips.clone()).collect();
    for claim in moved.iter().filter(|claim| !alone.contains(**claim)) {
        let rests = |id: &String| [old, new].iter().any(|side| rests_on(side, claim, id));
        for row in rows.iter_mut().filter(|row| rests(&row.id)) {
            row.flips.push((*claim).clone());
        }
    }
}

/// What else is not the same in two reports.
#[derive(Clone, Copy)]
struct Differ {
    inputs: bool,
    platform: bool,
}

/// Why a value moved, as far as the two reports can tell: other inputs; within its tolerance, another platform, rounding or
/// another algorithm; else the physics.
fn class(old: Option<f64>, new: Option<f64>, used: Option<f64>, differ: Differ) -> DriftClass {
    const ROUNDING: f64 = 16.0 * f64::EPSILON;
    match (old, new, used) {
        (Some(a), Some(b), _) if (a - b).abs() <= ROUNDING * a.abs().max(b.abs()) => {
            match differ.platform {
                true => DriftClass::Platform,
                false => DriftClass::Noise,
            }
        }
        _ if differ.inputs => DriftClass::Input,
        (_, _, Some(used)) if used <= 100.0 => match differ.platform {
            true => DriftClass::Platform,
            false => DriftClass::Algorithm,
        },
        _ => DriftClass::Physics,
    }
}

/// Values by id: number and unit.
fn values(results: &Json) -> BTreeMap<String, (Option<f64>, String)> {
    array(results, "values")
        .map(|value| {
            let unit = value["unit"].as_str().unwrap_or_default().to_owned();
            (text(value, "id"), (value["value"].as_f64(), unit))
        })
        .collect()
}

fn inputs(results: &Json) -> BTreeMap<String, &Json> {
    array(results, "stages")
        .map(|stage| (text(stage, "id"), &stage["inputs"]))
        .collect()
}

/// Verdicts that changed: claim, before, now.
fn verdicts(old: &Json, new: &Json) -> Vec<(String, String, String)> {
    let of = |results| -> BTreeMap<String, String> {
        array(results, "claims")
            .map(|claim| (text(claim, "id"), text(claim, "verdict")))
            .collect()
    };
    let before = of(old);
    of(new)
        .into_iter()
        .filter_map(|(id, now)| {
            let before = before
                .get(&id)
                .cloned()
                .unwrap_or_else(|| "absent".to_owned());
            (before != now).then_some((id, before, now))
        })
        .collect()
}

/// Whether a claim says that it rests on a value.
fn rests_on(results: &Json, claim: &str, id: &str) -> bool {
    array(results, "claims").any(|entry| {
        text(entry, "id") == claim
            && entry["values"]
                .as_array()
                .is_some_and(|values| values.iter().any(|value| value == id))
    })
}

fn array<'a>(results: &'a Json, key: &str) -> impl Iterator<Item = &'a Json> {
    results[key]
        .as_array()
        .map(Vec::as_slice)
        .unwrap_or_default()
        .iter()
}

fn text(entry: &Json, key: &str) -> String {
    entry[key].as_str().unwrap_or_default().to_owned()
}

/// The comparison in words, for the terminal.
#[must_use]
pub fn words(drift: &Drift) -> String {
    if drift.nothing() {
        return format!(
            "against {}: nothing changed ({} values equal bit for bit)",
            drift.against, drift.unchanged
        );
    }
    let mut lines = vec![format!(
        "against {}: {} changed, {} equal bit for bit",
        drift.against,
        match drift.rows.len() {
            1 => "1 value".to_owned(),
            many => format!("{many} values"),
        },
        drift.unchanged
    )];
    if let Some([before, now]) = &drift.platforms {
        lines.push(format!("  platform: {before} -> {now}"));
    }
    let shown =
        |value: Option<f64>| value.map_or_else(|| "absent".to_owned(), |value| value.to_string());
    for row in drift.rows.iter().take(20) {
        let used = row.tolerance_used_percent.map_or_else(String::new, |used| {
            format!(", {used:.3e} % of its tolerance")
        });
        let flips = if row.flips.is_empty() {
            String::new()
        } else {
            format!(", flips {}", row.flips.join(", "))
        };
        lines.push(format!(
            "  {}: {} -> {} {}{used}, {}{flips}",
            row.id,
            shown(row.old),
            shown(row.new),
            row.unit,
            row.class.word()
        ));
    }
    if drift.rows.len() > 20 {
        lines.push(format!(
            "  and {} more (see the report)",
            drift.rows.len() - 20
        ));
    }
    for (claim, before, now) in &drift.verdicts {
        lines.push(format!("  {claim}: {before} -> {now}"));
    }
    for (claim, before, now) in &drift.by_values {
        lines.push(format!(
            "  {claim}: {before} -> {now} (the earlier values, judged by the present rules; the earlier report says {now})"
        ));
    }
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    /// Gains of force and of speed with the claims that look at them.
    fn results(pitch0: f64, gain: f64, verdict: &str) -> Json {
        let value = |id: &str, value: f64| {
            let stage = id.split('.').next();
            json!({"id": id, "value": value, "unit": "percent", "stage": stage, "evidence": "computed"})
        };
        json!({"schema": crate::results::SCHEMA,
            "values": [value("envelope.gain.pitch-5", 12.61), value("envelope.gain.pitch0", pitch0),
                value("envelope.gain.pitch+5", 17.52), value("gait.gain", gain)],
            "claims": [
                {"id": "C12", "verdict": verdict, "values": ["envelope.gain.pitch-5", "envelope.gain.pitch0", "envelope.gain.pitch+5"]},
                {"id": "C22", "verdict": "differs", "values": ["gait.gain"]}],
            "stages": [{"id": "envelope", "inputs": {}}]})
    }

    fn compared(old: &Json, new: &Json) -> Drift {
        compared_on(old, new, Platform::default())
    }

    /// The earlier report from a platform of its own, the present one from `x86_64` with compiler 1.
    fn compared_on(old: &Json, new: &Json, platform: Platform) -> Drift {
        let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data");
        let published = crate::published::Published::shipped();
        let claims: Vec<_> = crate::claims::read(&data.join("claims.toml"))
            .unwrap()
            .into_iter()
            .filter(|claim| ["C12", "C22"].contains(&claim.id.as_str()))
            .collect();
        let rules = Rules {
            claims: &claims,
            published: &published,
        };
        let earlier = Earlier {
            results: old.clone(),
            platform,
        };
        let here = named("x86_64", "rustc 1");
        compare(Path::new("old.html"), &earlier, new, &here, &rules).unwrap()
    }

    fn named(target: &str, rustc: &str) -> Platform {
        Platform {
            target: target.into(),
            rustc: rustc.into(),
        }
    }

    #[test]
    fn a_small_change_is_laid_to_another_platform_only_where_there_is_one() {
        let now = results(18.6, 4.7, "differs");
        // gait values have a tolerance of a thousandth
        let (ulp, little, much) = (4.7 * (1.0 + 4e-16), 4.701, 4.8);
        let class = |gain: f64, platform: Platform| {
            let drift = compared_on(&results(18.6, gain, "differs"), &now, platform);
            assert_eq!(drift.rows.len(), 1);
            (drift.rows[0].class, drift.platforms.is_some())
        };
        for other in [named("aarch64", "rustc 1"), named("x86_64", "rustc 2")] {
            assert_eq!(class(ulp, other.clone()), (DriftClass::Platform, true));
            assert_eq!(class(little, other.clone()), (DriftClass::Platform, true));
            assert_eq!(class(much, other), (DriftClass::Physics, true));
        }
        for same in [named("x86_64", "rustc 1"), Platform::default()] {
            assert_eq!(class(ulp, same.clone()), (DriftClass::Noise, false));
            assert_eq!(class(little, same), (DriftClass::Algorithm, false));
        }
        let arm = named("aarch64", "rustc 1");
        let said = words(&compared_on(&results(18.6, little, "differs"), &now, arm));
        assert!(
            said.contains("platform: aarch64, rustc 1 -> x86_64, rustc 1"),
            "{said}"
        );
        assert!(
            said.contains("gait.gain") && said.contains(", platform"),
            "{said}"
        );
    }

    #[test]
    fn equal_results_are_no_change() {
        let same = results(18.6, 4.7, "differs");
        assert_eq!(
            words(&compared(&same, &same)),
            "against old.html: nothing changed (4 values equal bit for bit)"
        );
    }

    #[test]
    fn a_changed_value_is_named_with_the_claims_that_it_flips() {
        let drift = compared(
            &results(18.79, 4.7, "reproduced"),
            &results(18.6, 4.7, "differs"),
        );
        assert_eq!(drift.rows.len(), 1);
        assert_eq!(drift.rows[0].flips, ["C12"]);
        assert_eq!(drift.rows[0].class, DriftClass::Physics);
        assert!(drift.by_values.is_empty(), "said once");
        assert!(words(&drift).contains("C12: reproduced -> differs"));
    }

    /// The verdicts of the earlier report stay as they were: its values alone must show the flip.
    #[test]
    fn a_value_altered_without_its_verdict_flips_its_claims() {
        let now = results(18.6, 4.7, "differs");
        let drift = compared(&results(18.79, 4.7, "differs"), &now);
        assert_eq!(drift.rows[0].flips, ["C12"]);
        assert!(drift.verdicts.is_empty());
        let said = words(&drift);
        assert!(
            said.contains("C12: reproduced -> differs (the earlier values"),
            "{said}"
        );
        let drift = compared(&results(18.6, 15.0, "differs"), &now);
        assert_eq!(drift.rows[0].id, "gait.gain");
        assert_eq!(drift.rows[0].flips, ["C22"]);
        assert!(words(&drift).contains("flips C22"));
    }

    /// The range of the gains of force is not among the values of C22, yet it decides.
    #[test]
    fn a_value_that_a_claim_does_not_list_flips_it_where_it_decides() {
        let drift = compared(
            &results(5.0, 4.7, "differs"),
            &results(18.6, 4.7, "differs"),
        );
        assert_eq!(drift.rows[0].id, "envelope.gain.pitch0");
        assert_eq!(drift.rows[0].flips, ["C22"]);
    }

    #[test]
    fn a_change_that_flips_nothing_says_so_by_an_empty_list() {
        let drift = compared(
            &results(18.6, 4.8, "differs"),
            &results(18.6, 4.7, "differs"),
        );
        assert!(drift.rows[0].flips.is_empty());
        assert!(drift.by_values.is_empty());
    }

    #[test]
    fn results_are_found_in_a_page() {
        let folder = std::env::temp_dir().join(format!("bristle-against-{}", std::process::id()));
        let text = results(18.6, 4.7, "differs")
            .to_string()
            .replace('<', "\\u003c");
        let facts = r#"{"commit": "c", "target": "aarch64", "rustc": "rustc 1"}"#;
        for (facts, platform) in [
            (
                format!("{FACTS}{facts}{CLOSE}"),
                named("aarch64", "rustc 1"),
            ),
            (String::new(), Platform::default()),
        ] {
            let page = format!("<html>{facts}{OPEN}{text}{CLOSE}</html>");
            campaign::write_atomically(&folder.join("old.html"), page.as_bytes()).unwrap();
            let earlier = read(&folder.join("old.html")).unwrap();
            assert_eq!(earlier.results, results(18.6, 4.7, "differs"));
            assert_eq!(earlier.platform, platform);
        }
        campaign::write_atomically(&folder.join("empty.html"), b"<html></html>").unwrap();
        assert!(
            read(&folder.join("empty.html"))
                .unwrap_err()
                .to_string()
                .ends_with("embeds no results")
        );
        std::fs::remove_dir_all(folder).unwrap();
    }
}

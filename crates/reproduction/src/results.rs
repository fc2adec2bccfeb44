//! `results.json`: what other programs read.

use std::collections::BTreeMap;

use report::{Multiverse, Run, Value};
use serde_json::json;

use crate::claims::Claim;
use crate::costs::Costs;
use crate::engine::Finished;
use crate::judge::Check;
use crate::judgements::{Facts, Judged, judge};
use crate::multiverse;
use crate::published::{Interval, Published, PublishedError};

/// Schema of `results.json`.
pub const SCHEMA: &str = "bristle/results/1";

/// Everything that came out of a run of stages.
#[derive(Clone, Debug)]
pub struct Results {
    /// The stages that ran.
    pub stages: Vec<Finished>,
    /// Their values by id.
    pub values: BTreeMap<String, Value>,
    /// All claims with their verdicts, in the order of the file.
    pub claims: Vec<(Claim, Judged)>,
    /// Verdicts over the product of defensible choices, by claim.
    pub multiverses: BTreeMap<String, Multiverse>,
}

impl Results {
    /// Judges the claims by the outputs of the stages.
    ///
    /// # Errors
    /// Where a published number that a claim names is missing.
    pub fn new(
        stages: Vec<Finished>,
        claims: &[Claim],
        published: &Published,
    ) -> Result<Self, PublishedError> {
        let values: BTreeMap<String, Value> = stages
            .iter()
            .filter_map(|stage| stage.output.as_ref().ok())
            .flat_map(|output| {
                output
                    .values
                    .iter()
                    .map(|value| (value.id.clone(), value.clone()))
            })
            .collect();
        let judged = {
            let facts = Facts {
                published,
                values: &values,
            };
            let each = claims
                .iter()
                .map(|claim| Ok((claim.clone(), judge(claim, &facts)?)));
            each.collect::<Result<Vec<_>, PublishedError>>()?
        };
        Ok(Self {
            multiverses: multiverse::all(&stages, &judged, &values, published)?,
            stages,
            values,
            claims: judged,
        })
    }

    /// `results.json` without `run`: equal for two runs on one target.
    #[must_use]
    pub fn json(&self) -> serde_json::Value {
        let claims: Vec<_> = self
            .claims
            .iter()
            .map(|(claim, judged)| claim_json(claim, judged))
            .collect();
        let stages: Vec<_> = self
            .stages
            .iter()
            .map(|stage| {
                let work = stage.output.as_ref().map(|output| output.work.clone()).unwrap_or_default();
                json!({"id": stage.id, "status": stage.status(), "inputs": stage.inputs, "work": work})
            })
            .collect();
        json!({
            "schema": SCHEMA,
            "values": self.values.values().collect::<Vec<_>>(),
            "claims": claims,
            "stages": stages,
        })
    }

    /// `results.json` with `run`.
    #[must_use]
    pub fn json_with_run(&self, run: &Run) -> serde_json::Value {
        let mut json = self.json();
        json["run"] = json!({
            "commit": run.commit,
            "dirty": run.dirty,
            "rustc": run.rustc,
            "target": run.target,
            "started": run.started,
            "seconds": run.seconds,
        });
        json
    }

    /// Seconds to compute each stage and each claim: a claim costs what the stages cost that it needs.
    #[must_use]
    pub fn seconds(
        &self,
        costs: &Costs,
        stages_of: impl Fn(&Claim) -> Vec<String>,
    ) -> BTreeMap<String, f64> {
        let mut seconds: BTreeMap<String, f64> = self
            .stages
            .iter()
            .map(|stage| (stage.id.to_owned(), round(costs.of([stage.id]))))
            .collect();
        for (claim, _) in &self.claims {
            let stages = stages_of(claim);
            let ran = |id: &&str| self.stages.iter().any(|stage| stage.id == *id);
            let cost = costs.of(stages.iter().map(String::as_str).filter(ran));
            seconds.insert(claim.id.clone(), round(cost));
        }
        seconds
    }
}

/// Milliseconds are enough.
fn round(seconds: f64) -> f64 {
    (seconds * 1000.0).round() / 1000.0
}

fn claim_json(claim: &Claim, judged: &Judged) -> serde_json::Value {
    let values: Vec<&str> = judged
        .checks
        .iter()
        .filter_map(|check| check.value_id.as_deref())
        .collect();
    json!({
        "id": claim.id,
        "verdict": judged.verdict,
        "published": claim.published_text,
        "ours": ours(&judged.checks, |check| check.unit.clone()),
        "tolerance": claim.tolerance_text,
        "reason": claim.reason,
        "evidence": judged.evidence,
        "values": values,
    })
}

/// Our side of the comparisons in words, each with its unit as `unit` writes it.
#[must_use]
pub fn ours(checks: &[Check], unit: impl Fn(&Check) -> String) -> String {
    let one = |check: &Check| {
        let value = check.ours.map_or_else(
            || "not computed".to_owned(),
            |ours| interval(ours, &unit(check)),
        );
        format!("{}: {value}", check.label)
    };
    if checks.is_empty() {
        return "nothing to compare".to_owned();
    }
    checks.iter().map(one).collect::<Vec<_>>().join("; ")
}

/// An interval with its unit, to four significant digits and to two of its width at least, so that the half of a last
/// printed digit, by which a rounded number is open, stays in sight: one number where both ends print alike.
#[must_use]
pub fn interval(interval: Interval, unit: &str) -> String {
    let [lower, upper] = [interval.lower, interval.upper].map(|end| {
        let text = significant(end);
        let decimals = |text: &str| text.split_once('.').map_or(0, |(_, after)| after.len());
        match resolving(interval) {
            Some(finer) if text.contains('.') && !text.contains('e') && finer > decimals(&text) => {
                format!("{end:.finer$}")
            }
            _ => text,
        }
    });
    let unit = if unit == "1" {
        String::new()
    } else {
        format!(" {unit}")
    };
    if lower == upper {
        format!("{lower}{unit}")
    } else {
        format!("[{lower}, {upper}]{unit}")
    }
}

/// Decimals that show two digits of the width of an interval; `None` where it has no width or needs none.
fn resolving(interval: Interval) -> Option<usize> {
    let width = interval.upper - interval.lower;
    if !(width > 0.0 && width.is_finite()) {
        return None;
    }
    // The scientific form rounds: a width of 0.00999999 is one of 0.01.
    let exponent: i32 = format!("{width:.1e}").split_once('e')?.1.parse().ok()?;
    usize::try_from(1 - exponent)
        .ok()
        .filter(|decimals| *decimals <= 12)
}

/// A number that somebody chose: as `significant`, without zeros at the end.
#[must_use]
pub fn stated(value: f64) -> String {
    let text = significant(value);
    if text.contains('.') && !text.contains('e') {
        return text.trim_end_matches('0').trim_end_matches('.').to_owned();
    }
    text
}

/// A number to four significant digits.
#[must_use]
pub fn significant(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    if value.fract() == 0.0 && value.abs() < 1e6 {
        return format!("{value:.0}");
    }
    let exponent = value.abs().log10().floor();
    if (-4.0..6.0).contains(&exponent) {
        let decimals = (3.0 - exponent).clamp(0.0, 12.0) as usize;
        format!("{value:.decimals$}")
    } else {
        format!("{value:.3e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interval_shows_where_it_ends() {
        let of = |lower, upper| interval(Interval { lower, upper }, "1");
        assert_eq!(of(12.61 - 0.005, 12.61 + 0.005), "[12.605, 12.615]");
        assert_eq!(of(17.515, 17.525), "[17.515, 17.525]");
        assert_eq!(of(0.8545, 0.8926), "[0.8545, 0.8926]");
        assert_eq!(of(0.25, 0.25), "0.2500");
        assert_eq!(of(0.0, 0.000_412_6), "[0, 0.0004126]");
        assert_eq!(of(9.95e-7, 1.005e-6), "[9.950e-7, 1.005e-6]");
    }
}

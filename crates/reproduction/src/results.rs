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
        "ours": ours(&judged.checks),
        "tolerance": claim.tolerance_text,
        "reason": claim.reason,
        "evidence": judged.evidence,
        "values": values,
    })
}

/// Our side of the comparisons in words.
#[must_use]
pub fn ours(checks: &[Check]) -> String {
    let one = |check: &Check| {
        let value = check.ours.map_or_else(
            || "not computed".to_owned(),
            |ours| interval(ours, &check.unit),
        );
        format!("{}: {value}", check.label)
    };
    if checks.is_empty() {
        return "nothing to compare".to_owned();
    }
    checks.iter().map(one).collect::<Vec<_>>().join("; ")
}

/// An interval with its unit, to four significant digits: one number where both ends print alike.
#[must_use]
pub fn interval(interval: Interval, unit: &str) -> String {
    let (lower, upper) = (significant(interval.lower), significant(interval.upper));
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

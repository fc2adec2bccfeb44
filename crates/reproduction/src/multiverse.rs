//! Verdicts over the product of defensible choices.
//!
//! A stage computes the numbers of a claim once for every combination of choices and leaves them as an artefact
//! `worlds.CXX`. The verdict of a combination comes from the function that judges the ledger, with those numbers in the
//! place of the stage's own: no second rule decides.

use std::collections::BTreeMap;

use report::{Multiverse, Value, Verdict};
use serde::{Deserialize, Serialize};

use crate::claims::Claim;
use crate::engine::Finished;
use crate::flips::agrees_from;
use crate::judgements::{Facts, Judged, judge};
use crate::published::{Published, PublishedError};
use crate::results::significant;

/// A number as one combination of choices gives it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// The number.
    pub value: f64,
    /// Its 95 % interval, where it has one.
    pub ci95: Option<[f64; 2]>,
}

impl From<f64> for Point {
    fn from(value: f64) -> Self {
        Self { value, ci95: None }
    }
}

/// What every combination of choices gives for the values of a claim.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Worlds {
    /// What was chosen, with the options.
    pub axes: Vec<(String, Vec<String>)>,
    /// Values by id, one map a combination, in the order of the product (the last axis runs fastest); empty where the
    /// combination came to no result.
    pub values: Vec<BTreeMap<String, Point>>,
}

impl Worlds {
    /// The same choices made for two sets of values at once; no result where one of the two has none.
    #[must_use]
    pub fn beside(mut self, other: Self) -> Self {
        for (own, more) in self.values.iter_mut().zip(other.values) {
            if own.is_empty() || more.is_empty() {
                own.clear();
            } else {
                own.extend(more);
            }
        }
        self
    }

    /// As the artefact of a claim.
    ///
    /// # Errors
    /// Never for finite numbers; the serialiser's word otherwise.
    pub fn artefact(&self, claim: &str) -> serde_json::Result<(String, serde_json::Value)> {
        Ok((name(claim), serde_json::to_value(self)?))
    }
}

fn name(claim: &str) -> String {
    format!("worlds.{claim}")
}

/// The multiverses of the claims for which a stage left one.
///
/// # Errors
/// Where a published number that a claim names is missing.
pub(crate) fn all(
    stages: &[Finished],
    claims: &[(Claim, Judged)],
    values: &BTreeMap<String, Value>,
    published: &Published,
) -> Result<BTreeMap<String, Multiverse>, PublishedError> {
    let mut found = BTreeMap::new();
    for (claim, judged) in claims {
        let artefact = stages
            .iter()
            .filter_map(|stage| stage.output.as_ref().ok())
            .find_map(|output| output.artefacts.get(&name(&claim.id)));
        let worlds: Option<Worlds> =
            artefact.and_then(|json| serde_json::from_value(json.clone()).ok());
        if let Some(worlds) = worlds {
            let multiverse = of_claim(claim, judged, &worlds, values, published)?;
            found.insert(claim.id.clone(), multiverse);
        }
    }
    Ok(found)
}

fn of_claim(
    claim: &Claim,
    judged: &Judged,
    worlds: &Worlds,
    values: &BTreeMap<String, Value>,
    published: &Published,
) -> Result<Multiverse, PublishedError> {
    let judgements = worlds
        .values
        .iter()
        .map(|world| {
            if world.is_empty() {
                return Ok(None);
            }
            let mut values = values.clone();
            for (id, point) in world {
                if let Some(value) = values.get_mut(id) {
                    (value.value, value.ci95) = (Some(point.value), point.ci95);
                }
            }
            let facts = Facts {
                published,
                values: &values,
            };
            judge(claim, &facts).map(Some)
        })
        .collect::<Result<Vec<_>, PublishedError>>()?;
    let verdicts: Vec<Verdict> = judgements
        .iter()
        .map(|one| one.as_ref().map_or(Verdict::NotRun, |one| one.verdict))
        .collect();
    let stated = judged.checks.iter().any(|check| check.tolerance > 0.0);
    let factors: Vec<Option<f64>> = judgements
        .iter()
        .flatten()
        .filter(|_| stated)
        .map(|one| agrees_from(claim, &one.checks))
        .collect();
    Ok(Multiverse {
        holds: verdicts.iter().filter(|v| **v == judged.verdict).count(),
        of: verdicts.iter().filter(|v| **v != Verdict::NotRun).count(),
        axes: worlds.axes.clone(),
        account: account(&factors).into(),
        verdicts,
    })
}

/// From which tolerance on the combinations agree, in units of the stated one; nothing where no tolerance takes part.
fn account(factors: &[Option<f64>]) -> String {
    let found: Vec<f64> = factors.iter().copied().flatten().collect();
    let never = factors.len() - found.len();
    let smallest = found.iter().copied().fold(f64::INFINITY, f64::min);
    let largest = found.iter().copied().fold(0.0, f64::max);
    if factors.is_empty() {
        return String::new();
    }
    if found.is_empty() {
        return "No combination agrees, whatever the tolerance.".to_owned();
    }
    let times = |factor: f64| match factor {
        0.0 => "without any tolerance".to_owned(),
        _ => format!("from {} times the stated tolerance on", significant(factor)),
    };
    let whole = match never {
        0 => "all of them".to_owned(),
        1 => "all but one, which agrees with none,".to_owned(),
        more => format!("all but {more}, which agree with none,"),
    };
    if smallest == largest && never == 0 {
        return format!("Every combination agrees {}.", times(smallest));
    }
    format!(
        "As the tolerance grows a first combination agrees {}, {whole} {}.",
        times(smallest),
        times(largest)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn claim() -> Claim {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/claims.toml");
        let claims = crate::claims::read(&path).unwrap();
        claims.into_iter().find(|claim| claim.id == "C02").unwrap()
    }

    /// One world inside the tolerance, one twice beyond it, one without a result.
    #[test]
    fn each_combination_is_judged_by_the_rule_of_the_ledger() {
        let (claim, published) = (claim(), Published::shipped());
        let tolerance = claim.tolerance["nrmse"];
        let ids = ["forward", "reverse"].map(|d| format!("identification.aluminium.nrmse_{d}"));
        let values: BTreeMap<String, Value> = ids
            .iter()
            .map(|id| {
                let evidence = report::Evidence::Synthetic;
                let value = Value::new(id, 0.0, "1", "identification", evidence);
                (id.clone(), value)
            })
            .collect();
        let facts = Facts {
            published: &published,
            values: &values,
        };
        let judged = judge(&claim, &facts).unwrap();
        assert_eq!(judged.verdict, Verdict::Consistent);
        let world = |factor: f64| -> BTreeMap<String, Point> {
            ids.iter()
                .map(|id| (id.clone(), Point::from(factor * tolerance)))
                .collect()
        };
        let worlds = Worlds {
            axes: vec![("choice".into(), ["a", "b", "c"].map(String::from).to_vec())],
            values: vec![world(0.5), world(2.0), BTreeMap::new()],
        };
        let found = of_claim(&claim, &judged, &worlds, &values, &published).unwrap();
        assert_eq!((found.holds, found.of), (1, 2));
        assert_eq!(
            found.verdicts,
            [Verdict::Consistent, Verdict::Differs, Verdict::NotRun]
        );
        assert!(
            found
                .account
                .0
                .contains(&format!("from {} times", significant(0.5))),
            "{}",
            found.account.0
        );
        assert!(
            found
                .account
                .0
                .contains(&format!("from {} times", significant(2.0))),
            "{}",
            found.account.0
        );
        assert_eq!(account(&[]), "");
        assert_eq!(
            account(&[Some(0.0), Some(3.5), None]),
            "As the tolerance grows a first combination agrees without any tolerance, all but one, which agrees with none, from 3.500 times the stated tolerance on."
        );
    }
}

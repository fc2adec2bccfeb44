//! One function a claim: from the values found and the numbers printed to comparisons. Verdicts are made elsewhere, by
//! one function for all (`judge::verdict`).

mod friction;
mod printed;
mod robot;

use std::collections::BTreeMap;

use report::{Evidence, Value, Verdict};

use crate::claims::Claim;
use crate::judge::{self, Check};
use crate::published::{Interval, Published, PublishedError};

/// What a judgement may look at.
pub struct Facts<'a> {
    /// The paper's numbers.
    pub published: &'a Published,
    /// Values of all stages that ran.
    pub values: &'a BTreeMap<String, Value>,
}

/// A claim with its comparisons and its verdict.
#[derive(Clone, Debug)]
pub struct Judged {
    /// Its id.
    pub id: String,
    /// The comparisons.
    pub checks: Vec<Check>,
    /// The verdict.
    pub verdict: Verdict,
    /// The weakest evidence among the comparisons; where nothing is compared, what the paper prints is all that was
    /// looked at.
    pub evidence: Evidence,
}

type Judgement = fn(&Claim, &Facts<'_>) -> Result<Vec<Check>, PublishedError>;

/// The functions by claim.
const JUDGEMENTS: [(&str, Judgement); 22] = [
    ("C01", friction::table_1),
    ("C02", friction::match_2x2),
    ("C03", friction::predict_3x3),
    ("C04", friction::repeatable),
    ("C05", friction::order_of_counterfaces),
    ("C06", friction::table_2),
    ("C07", printed::small_terms),
    ("C08", printed::small_rotation),
    ("C09", friction::steady_coefficients),
    ("C10", robot::force_directions),
    ("C11", robot::best_speeds),
    ("C12", robot::forward_force),
    ("C13", robot::vertical_force),
    ("C14", printed::rubber),
    ("C15", printed::ramp),
    ("C16", printed::count),
    ("C17", printed::static_and_dynamic),
    ("C18", printed::identifiable),
    ("C19", printed::tension),
    ("C20", printed::load),
    ("C21", printed::lean_alone),
    ("C22", robot::force_and_speed),
];

/// Judges a claim.
///
/// # Errors
/// Where a published number is missing, or no function has the claim's id.
pub fn judge(claim: &Claim, facts: &Facts<'_>) -> Result<Judged, PublishedError> {
    let (_, judgement) = JUDGEMENTS
        .iter()
        .find(|(id, _)| *id == claim.id)
        .ok_or_else(|| PublishedError::Entry {
            id: claim.id.clone(),
            problem: "no judgement has this id".to_owned(),
        })?;
    let checks = judgement(claim, facts)?;
    Ok(Judged {
        id: claim.id.clone(),
        verdict: judge::verdict(claim.nature, claim.combine, &checks),
        evidence: judge::weakest(&checks).unwrap_or(Evidence::Published),
        checks,
    })
}

/// Everything from minus to plus infinity.
const ABOVE_ZERO: Interval = Interval {
    lower: f64::MIN_POSITIVE,
    upper: f64::INFINITY,
};

impl Claim {
    /// A tolerance by its name; zero where the claim states none.
    fn allows(&self, name: &str) -> f64 {
        self.tolerance.get(name).copied().unwrap_or(0.0)
    }
}

impl Facts<'_> {
    /// The value as an interval: its 95 % interval, or a point where it has none.
    fn ours(&self, id: &str) -> Option<Interval> {
        let value = self.values.get(id)?;
        let [lower, upper] = value
            .ci95
            .or_else(|| value.value.map(|point| [point, point]))?;
        Some(Interval { lower, upper })
    }

    /// The number of a value without its interval.
    fn point(&self, id: &str) -> Option<f64> {
        self.values.get(id)?.value
    }

    /// The comparison of a value with what is allowed.
    fn check(&self, label: &str, id: &str, allowed: Interval, tolerance: f64) -> Check {
        let value = self.values.get(id);
        Check {
            label: label.to_owned(),
            ours: self.ours(id),
            allowed,
            tolerance,
            unit: value.map_or_else(|| "1".to_owned(), |value| value.unit.clone()),
            evidence: value.map_or(Evidence::Computed, |value| value.evidence),
            value_id: Some(id.to_owned()),
        }
    }

    /// The comparison of a value, without regard to sign or interval, with zero.
    fn small(&self, label: &str, id: &str, tolerance: f64) -> Check {
        let point = self.point(id).map(|value| Interval {
            lower: value.abs(),
            upper: value.abs(),
        });
        Check {
            ours: point,
            ..self.check(
                label,
                id,
                Interval {
                    lower: 0.0,
                    upper: 0.0,
                },
                tolerance,
            )
        }
    }

    /// Whether one value is larger than another: their difference above zero.
    fn larger(&self, label: &str, larger: &str, smaller: &str) -> Check {
        let difference = match (self.point(larger), self.point(smaller)) {
            (Some(a), Some(b)) => Some(Interval {
                lower: a - b,
                upper: a - b,
            }),
            _ => None,
        };
        Check {
            ours: difference,
            ..self.check(label, larger, ABOVE_ZERO, 0.0)
        }
    }
}

//! The one function that turns a value, a published interval and a tolerance into a verdict.

use report::{Evidence, Verdict};

use crate::published::Interval;

/// What kind of statement a claim is: it decides what agreement and disagreement mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Nature {
    /// The paper's own numbers or equations against each other: a disagreement is a contradiction.
    Arithmetic,
    /// About measurements: stand-in data, or the paper's own parameters, can at best be consistent with it.
    Measurement,
    /// Computed from what is published, with a published number to meet.
    Computation,
    /// Computed, but the number or an equation behind it is not published: at best consistent.
    Reading,
    /// Nothing is published that could test it: becomes a `Measurement` where measured data are brought.
    Untestable,
}

/// One comparison: is `ours` within `tolerance` of `allowed`?
#[derive(Clone, Debug, PartialEq)]
pub struct Check {
    /// What is compared, for the ledger.
    pub label: String,
    /// Our value with its uncertainty (a point where it has none); `None` where it was not computed.
    pub ours: Option<Interval>,
    /// The published interval, or the range that the claim's words allow; ends may be infinite.
    pub allowed: Interval,
    /// How far outside `allowed` still agrees, in the unit of the check.
    pub tolerance: f64,
    /// Unit of all of it.
    pub unit: String,
    /// What our value rests on.
    pub evidence: Evidence,
    /// The value in the results that it shows, where there is one.
    pub value_id: Option<String>,
}

impl Check {
    /// Gap between `ours` and `allowed`, 0 where they meet; `None` where ours was not computed.
    #[must_use]
    pub fn gap(&self) -> Option<f64> {
        let ours = self.ours?;
        Some(
            (self.allowed.lower - ours.upper)
                .max(ours.lower - self.allowed.upper)
                .max(0.0),
        )
    }

    /// Whether the gap is within the tolerance.
    #[must_use]
    pub fn agrees(&self) -> Option<bool> {
        // A rounding of the difference itself must not decide: equal decimals meet.
        self.gap().map(|gap| gap <= self.tolerance * (1.0 + 1e-12))
    }
}

/// How the checks of a claim combine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Combine {
    /// The claim holds where every check agrees.
    #[default]
    All,
    /// The checks are rival readings of one sentence: where only some agree, the claim is consistent.
    Readings,
}

/// Verdict of a claim.
///
/// | nature | all checks agree | one does not |
/// |---|---|---|
/// | arithmetic | reproduced | contradicted |
/// | measurement | consistent; reproduced with measured evidence | differs |
/// | computation | reproduced; consistent with synthetic evidence | differs |
/// | reading | consistent | differs |
/// | untestable | not testable, unless the evidence is measured (then as measurement) | |
///
/// A check without a value of ours makes the claim `not run`.
#[must_use]
pub fn verdict(nature: Nature, combine: Combine, checks: &[Check]) -> Verdict {
    let evidence = weakest(checks);
    if nature == Nature::Untestable && evidence != Some(Evidence::Measured) {
        return Verdict::NotTestable;
    }
    let agreement: Option<Vec<bool>> = checks.iter().map(Check::agrees).collect();
    let (Some(agreement), Some(evidence)) = (agreement, evidence) else {
        return Verdict::NotRun;
    };
    let all = agreement.iter().all(|agrees| *agrees);
    let some = agreement.iter().any(|agrees| *agrees);
    if !all {
        return match (nature, combine) {
            (Nature::Arithmetic, _) => Verdict::Contradicted,
            (_, Combine::Readings) if some => Verdict::Consistent,
            _ => Verdict::Differs,
        };
    }
    match (nature, evidence) {
        (Nature::Arithmetic, _) => Verdict::Reproduced,
        (Nature::Measurement | Nature::Untestable, Evidence::Measured) => Verdict::Reproduced,
        (Nature::Computation, evidence) if evidence != Evidence::Synthetic => Verdict::Reproduced,
        _ => Verdict::Consistent,
    }
}

/// The weakest evidence among the checks: a chain is as good as its weakest link. `None` without checks.
#[must_use]
pub fn weakest(checks: &[Check]) -> Option<Evidence> {
    checks
        .iter()
        .map(|check| check.evidence)
        .min_by_key(|evidence| strength(*evidence))
}

/// Order of the kinds of evidence, the weakest first.
fn strength(evidence: Evidence) -> u8 {
    match evidence {
        Evidence::Synthetic => 0,
        Evidence::Computed => 1,
        Evidence::Published => 2,
        Evidence::Measured => 3,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(ours: Option<f64>, evidence: Evidence) -> Check {
        Check {
            label: String::new(),
            ours: ours.map(|x| Interval { lower: x, upper: x }),
            allowed: Interval {
                lower: 12.605,
                upper: 12.615,
            },
            tolerance: 0.05,
            unit: "percent".into(),
            evidence,
            value_id: None,
        }
    }

    #[test]
    fn the_table_of_verdicts() {
        use Evidence::{Computed, Measured, Published, Synthetic};
        use Nature::{Arithmetic, Computation, Measurement, Reading, Untestable};
        let of =
            |nature, ours, evidence| verdict(nature, Combine::All, &[check(Some(ours), evidence)]);
        assert_eq!(of(Arithmetic, 12.61, Published), Verdict::Reproduced);
        assert_eq!(of(Arithmetic, 13.0, Published), Verdict::Contradicted);
        assert_eq!(of(Measurement, 12.61, Synthetic), Verdict::Consistent);
        assert_eq!(of(Measurement, 12.61, Computed), Verdict::Consistent);
        assert_eq!(of(Measurement, 12.61, Measured), Verdict::Reproduced);
        assert_eq!(of(Measurement, 13.0, Synthetic), Verdict::Differs);
        assert_eq!(of(Computation, 12.664, Computed), Verdict::Reproduced);
        assert_eq!(of(Computation, 12.61, Synthetic), Verdict::Consistent);
        assert_eq!(of(Computation, 12.73, Computed), Verdict::Differs);
        assert_eq!(of(Reading, 12.61, Computed), Verdict::Consistent);
        assert_eq!(of(Untestable, 12.61, Synthetic), Verdict::NotTestable);
        assert_eq!(of(Untestable, 12.61, Measured), Verdict::Reproduced);
        assert_eq!(
            verdict(Computation, Combine::All, &[check(None, Computed)]),
            Verdict::NotRun
        );
        assert_eq!(verdict(Computation, Combine::All, &[]), Verdict::NotRun);
    }

    #[test]
    fn one_of_two_readings_makes_a_claim_consistent_and_none_makes_it_differ() {
        let pair = |one, other| {
            [
                check(Some(one), Evidence::Computed),
                check(Some(other), Evidence::Computed),
            ]
        };
        let of = |one, other| verdict(Nature::Computation, Combine::Readings, &pair(one, other));
        assert_eq!(of(12.61, 12.61), Verdict::Reproduced);
        assert_eq!(of(12.61, 14.0), Verdict::Consistent);
        assert_eq!(of(11.0, 14.0), Verdict::Differs);
    }

    #[test]
    fn the_weakest_link_is_the_evidence() {
        let pair = [
            check(Some(1.0), Evidence::Published),
            check(Some(1.0), Evidence::Synthetic),
        ];
        assert_eq!(weakest(&pair), Some(Evidence::Synthetic));
    }
}

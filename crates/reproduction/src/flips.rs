//! How a verdict hangs on its tolerances: all of them multiplied by one factor, judged by the one function of the ledger.

use report::Verdict;

use crate::claims::Claim;
use crate::judge::{Check, verdict};
use crate::results::{significant, stated};

/// Where a verdict would be another one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Flips {
    /// The smallest factor at which the verdict is what it is, and what it is below.
    pub below: Option<(f64, Verdict)>,
    /// The smallest factor above one at which it is another, and which.
    pub above: Option<(f64, Verdict)>,
}

/// Factors at which some check begins to agree, in rising order.
fn thresholds(checks: &[Check]) -> Vec<f64> {
    let mut found: Vec<f64> = checks
        .iter()
        .filter(|check| check.tolerance > 0.0)
        .filter_map(|check| Some(check.gap()? / check.tolerance))
        .collect();
    found.sort_by(f64::total_cmp);
    found.dedup();
    found
}

/// The verdict with all tolerances multiplied.
fn at(claim: &Claim, checks: &[Check], factor: f64) -> Verdict {
    let scaled: Vec<Check> = checks
        .iter()
        .map(|check| Check {
            tolerance: factor * check.tolerance,
            ..check.clone()
        })
        .collect();
    verdict(claim.nature, claim.combine, &scaled)
}

/// Just below a factor at which a check begins to agree.
fn before(factor: f64) -> f64 {
    factor * (1.0 - 1e-9)
}

/// Where the verdict of a claim would be another one.
#[must_use]
pub fn flips(claim: &Claim, checks: &[Check]) -> Flips {
    let own = at(claim, checks, 1.0);
    let steps = thresholds(checks);
    let below = steps
        .iter()
        .rev()
        .filter(|factor| **factor > 0.0 && **factor <= 1.0)
        .map(|factor| (*factor, at(claim, checks, before(*factor))))
        .find(|(_, other)| *other != own);
    let above = steps
        .iter()
        .filter(|factor| **factor > 1.0)
        .map(|factor| (*factor, at(claim, checks, *factor)))
        .find(|(_, other)| *other != own);
    Flips { below, above }
}

/// The smallest factor from which on the claim agrees: zero where it needs no tolerance, `None` where none suffices.
#[must_use]
pub fn agrees_from(claim: &Claim, checks: &[Check]) -> Option<f64> {
    let agrees = |factor: f64| {
        matches!(
            at(claim, checks, factor),
            Verdict::Reproduced | Verdict::Consistent
        )
    };
    std::iter::once(0.0)
        .chain(thresholds(checks))
        .find(|factor| agrees(*factor))
}

/// The same in words; `None` for a claim that is not tested or was not computed.
#[must_use]
pub fn words(claim: &Claim, checks: &[Check]) -> Option<String> {
    let own = at(claim, checks, 1.0);
    if matches!(own, Verdict::NotTestable | Verdict::NotRun) {
        return None;
    }
    if thresholds(checks).is_empty() {
        return Some("nowhere: no tolerance takes part".to_owned());
    }
    let found = flips(claim, checks);
    let mut said = Vec::new();
    if let Some((factor, other)) = found.below {
        said.push(format!(
            "{} below {} of the stated tolerance{}",
            other.word(),
            significant(factor),
            absolute(claim, factor)
        ));
    }
    if let Some((factor, other)) = found.above {
        said.push(format!(
            "{} from {} times the stated tolerance on{}",
            other.word(),
            significant(factor),
            absolute(claim, factor)
        ));
    }
    if !said.is_empty() {
        return Some(said.join("; "));
    }
    let decided = checks
        .iter()
        .any(|check| check.tolerance == 0.0 && check.agrees() == Some(false));
    Some(if decided {
        "nowhere: a check that has no tolerance fails".to_owned()
    } else {
        "nowhere: ours meets the published interval without any tolerance".to_owned()
    })
}

/// The tolerances at that factor, as the claim states them.
fn absolute(claim: &Claim, factor: f64) -> String {
    let each: Vec<String> = claim
        .tolerance
        .values()
        .map(|tolerance| {
            format!(
                "{} in place of {}",
                significant(factor * tolerance),
                stated(*tolerance)
            )
        })
        .collect();
    if each.is_empty() {
        String::new()
    } else {
        format!(" ({})", each.join(", "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::judge::{Combine, Nature};
    use crate::published::Interval;
    use report::Evidence;

    fn claim(nature: Nature, combine: Combine) -> Claim {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/claims.toml");
        let claims = crate::claims::read(&path).unwrap();
        let claim = claims.into_iter().find(|claim| claim.id == "C13").unwrap();
        Claim {
            nature,
            combine,
            ..claim
        }
    }

    /// A check that lies so many tolerances outside.
    fn outside(tolerances: f64) -> Check {
        let point = |x: f64| Interval { lower: x, upper: x };
        Check {
            label: String::new(),
            ours: Some(point(2.5 * tolerances)),
            allowed: point(0.0),
            tolerance: 2.5,
            unit: "percent".into(),
            evidence: Evidence::Computed,
            value_id: None,
        }
    }

    #[test]
    fn two_readings_flip_down_with_the_nearer_and_up_with_the_farther_one() {
        let claim = claim(Nature::Computation, Combine::Readings);
        let checks = [outside(0.4), outside(3.0)];
        let found = flips(&claim, &checks);
        assert_eq!(found.below, Some((0.4, Verdict::Differs)));
        assert_eq!(found.above, Some((3.0, Verdict::Reproduced)));
        assert_eq!(agrees_from(&claim, &checks), Some(0.4));
        let said = words(&claim, &checks).unwrap();
        assert!(
            said.starts_with("differs below 0.4000 of the stated tolerance (1 in place of 2.5)"),
            "{said}"
        );
        assert!(said.contains("reproduced from 3"), "{said}");
    }

    #[test]
    fn where_all_must_agree_the_farthest_decides() {
        let claim = claim(Nature::Computation, Combine::All);
        let found = flips(&claim, &[outside(0.4), outside(3.0)]);
        assert_eq!(found.below, None);
        assert_eq!(found.above, Some((3.0, Verdict::Reproduced)));
        let found = flips(&claim, &[outside(0.0), outside(0.5)]);
        assert_eq!(found.below, Some((0.5, Verdict::Differs)));
        assert_eq!(found.above, None);
    }

    #[test]
    fn a_check_without_tolerance_takes_part_in_the_verdict_but_not_in_the_factor() {
        let claim = claim(Nature::Computation, Combine::All);
        let exact = |tolerances: f64| Check {
            tolerance: 0.0,
            ..outside(tolerances)
        };
        assert_eq!(agrees_from(&claim, &[exact(0.0), outside(0.5)]), Some(0.5));
        assert_eq!(agrees_from(&claim, &[exact(1.0), outside(0.5)]), None);
        let said = words(&claim, &[exact(1.0), outside(0.5)]).unwrap();
        assert_eq!(said, "nowhere: a check that has no tolerance fails");
        assert_eq!(
            words(&claim, &[exact(0.0)]).unwrap(),
            "nowhere: no tolerance takes part"
        );
        assert_eq!(
            words(&claim, &[outside(0.0)]).unwrap(),
            "nowhere: ours meets the published interval without any tolerance"
        );
    }
}

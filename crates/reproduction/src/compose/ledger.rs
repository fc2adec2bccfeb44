//! Claims and judgements as rows of the ledger and entries of the list of deviations.

use std::collections::BTreeSet;

use report::{ClaimRow, Comparison, Deviation, Prose, Verdict, typeset, typeset_prose};

use crate::claims::Claim;
use crate::flips;
use crate::judge::Check;
use crate::judgements::Judged;
use crate::results::{interval, ours, significant, stated};

/// One row of the ledger.
pub(super) fn row(
    claim: &Claim,
    judged: &Judged,
    known: &BTreeSet<&str>,
    anchors: &[(String, Vec<String>)],
) -> ClaimRow {
    let mut row = ClaimRow::new(
        &claim.id,
        typeset(&claim.text),
        judged.verdict,
        judged.evidence,
    );
    row.locator.clone_from(&claim.locator);
    row.published = typeset(&claim.published_text).into();
    row.ours = typeset(&ours(&judged.checks, printed)).into();
    row.comparisons = comparisons(&judged.checks);
    row.deviation = deviation(&judged.checks)
        .filter(|_| judged.verdict != Verdict::NotTestable)
        .map(|text| typeset(&text).into());
    row.tolerance = typeset(&claim.tolerance_text).into();
    row.reason = typeset(&claim.reason).into();
    row.flips_at = flips::words(claim, &judged.checks).map(Into::into);
    row.account = told(&claim.account, known);
    if let Some(reason) = &claim.no_choices {
        let reason = told(reason, known);
        row.account = Prose(format!(
            "{}\n\n*Other choices:* {}",
            row.account.0, reason.0
        ));
    }
    row.values = judged
        .checks
        .iter()
        .filter_map(|check| check.value_id.clone())
        .filter(|id| known.contains(id.as_str()))
        .collect();
    row.figures = anchors
        .iter()
        .filter(|(id, claims)| claims.contains(&claim.id) || claim.figures.contains(id))
        .map(|(id, _)| id.clone())
        .collect();
    row.pinned_by = Some("crates/reproduction/tests/drift.rs".into());
    row
}

/// Number by number, where a claim has several.
fn comparisons(checks: &[Check]) -> Vec<Comparison> {
    if checks.len() < 2 {
        return Vec::new();
    }
    checks
        .iter()
        .map(|check| Comparison {
            label: typeset(&check.label).into(),
            published: typeset(&allowed(check)).into(),
            ours: typeset(&check.ours.map_or_else(
                || "not computed".to_owned(),
                |ours| interval(ours, &printed(check)),
            ))
            .into(),
            tolerance: typeset(&tolerance(check)).into(),
            deviation: typeset(&outside(check).unwrap_or_default()).into(),
            agrees: check.agrees(),
        })
        .collect()
}

/// The tolerance with its unit; a check that has none says so.
fn tolerance(check: &Check) -> String {
    if check.tolerance == 0.0 {
        return "none".to_owned();
    }
    report::printed_with_unit(&stated(check.tolerance), distance_unit(check))
}

/// The unit of a distance from what is printed: between percentages lie points, and a count stands alone.
fn distance_unit(check: &Check) -> &str {
    let counted = check.ours.is_some_and(|ours| {
        [ours, check.allowed]
            .iter()
            .all(|side| side.lower == side.upper && side.lower.fract() == 0.0)
    });
    match check.unit.as_str() {
        "percent" if !in_words(check) => "points",
        _ if counted && check.tolerance == 0.0 => "1",
        unit => unit,
    }
}

/// How far ours lies outside. What is held against no number lies outside of nothing: there the tolerance is the measure.
fn outside(check: &Check) -> Option<String> {
    let gap = check.gap().filter(|gap| *gap > 0.0)?;
    if in_words(check) {
        let times = significant(gap / check.tolerance);
        return (check.agrees() == Some(false)).then(|| format!("{times} times the tolerance"));
    }
    Some(report::printed_with_unit(
        &significant(gap),
        distance_unit(check),
    ))
}

/// A statement in words, such as "agree" or "very small", is compared with zero: the paper does not print the zero.
fn in_words(check: &Check) -> bool {
    check.allowed.lower == 0.0 && check.allowed.upper == 0.0 && check.tolerance > 0.0
}

/// The unit as it is printed, in the words of `interval`.
fn printed(check: &Check) -> String {
    match report::printed_unit(&check.unit) {
        unit if unit.is_empty() => "1".to_owned(),
        unit => unit,
    }
}

/// The interval of the paper; an open one as a bound.
fn allowed(check: &Check) -> String {
    let (lower, upper) = (check.allowed.lower, check.allowed.upper);
    let bound = |number: f64| {
        let point = crate::published::Interval {
            lower: number,
            upper: number,
        };
        interval(point, &printed(check))
    };
    if in_words(check) {
        return "no number, in words only".to_owned();
    }
    match (lower.is_finite(), upper.is_finite()) {
        (true, true) => interval(check.allowed, &printed(check)),
        // The smallest number above zero stands for "above zero".
        (true, false) if lower == f64::MIN_POSITIVE => "above 0".to_owned(),
        (true, false) => format!("at least {}", bound(lower)),
        (false, true) => format!("at most {}", bound(upper)),
        (false, false) => "anything".to_owned(),
    }
}

/// How far outside each failing check lies.
fn deviation(checks: &[Check]) -> Option<String> {
    let outside: Vec<String> = checks
        .iter()
        .filter_map(|check| {
            let outside = outside(check)?;
            let word = if in_words(check) { "" } else { "outside by " };
            Some(format!("{}: {word}{outside}", check.label))
        })
        .collect();
    (!outside.is_empty()).then(|| outside.join("; "))
}

/// Every claim that is not reproduced and was run, with the class of its cause and what would settle it.
pub(super) fn deviations(claims: &[(Claim, Judged)], known: &BTreeSet<&str>) -> Vec<Deviation> {
    claims
        .iter()
        .filter(|(_, judged)| !matches!(judged.verdict, Verdict::Reproduced | Verdict::NotRun))
        .filter_map(|(claim, _)| {
            Some(Deviation {
                claim: claim.id.clone(),
                cause: claim.cause?,
                account: told(claim.deviation.as_deref()?, known),
                settles: typeset(claim.settles.as_deref()?).into(),
            })
        })
        .collect()
}

/// A text that names values, if they are all there; in a partial run they need not be.
pub(super) fn told(text: &str, known: &BTreeSet<&str>) -> Prose {
    let named = text
        .split("(\"")
        .skip(1)
        .filter_map(|rest| rest.split_once('"').map(|(id, _)| id));
    let missing: Vec<&str> = named.filter(|id| !known.contains(id)).collect();
    if missing.is_empty() {
        typeset_prose(text).into()
    } else {
        "The values that this text shows were not computed in this run.".into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::published::Interval;

    #[test]
    fn a_statement_in_words_prints_no_zero_and_a_number_prints_itself() {
        let check = |at: f64, tolerance: f64| Check {
            label: String::new(),
            ours: None,
            allowed: Interval {
                lower: at,
                upper: at,
            },
            tolerance,
            unit: "1".into(),
            evidence: report::Evidence::Computed,
            value_id: None,
        };
        assert_eq!(allowed(&check(0.0, 0.05)), "no number, in words only");
        assert_eq!(
            allowed(&check(0.0, 0.0)),
            "0",
            "a count of nothing is a number"
        );
        assert_eq!(allowed(&check(7.0, 0.0)), "7");
    }
}

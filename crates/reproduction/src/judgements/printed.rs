//! Claims that the paper's own numbers and equations decide: C07, C08, C14 to C21.

use report::Evidence;

use super::{ABOVE_ZERO, Claim, Facts};
use crate::judge::Check;
use crate::published::{Interval, PublishedError};

/// C07: largest damping and viscous term of a ramp.
pub(super) fn small_terms(claim: &Claim, facts: &Facts<'_>) -> Result<Vec<Check>, PublishedError> {
    let percent = claim.allows("percent");
    Ok(vec![
        facts.small(
            "damping term over stiffness term",
            "audit.terms.damping",
            percent,
        ),
        facts.small(
            "viscous term over stiffness term",
            "audit.terms.viscous",
            percent,
        ),
    ])
}

/// C08: 1 - cos^2(theta_c/sigma).
pub(super) fn small_rotation(
    claim: &Claim,
    facts: &Facts<'_>,
) -> Result<Vec<Check>, PublishedError> {
    Ok(vec![facts.small(
        "1 - cos^2 theta",
        "audit.steady_cos2_loss",
        claim.allows("loss"),
    )])
}

/// C14: there is nothing to compare.
pub(super) fn rubber(_: &Claim, _: &Facts<'_>) -> Result<Vec<Check>, PublishedError> {
    Ok(Vec::new())
}

/// C15: room left on the stage.
pub(super) fn ramp(_: &Claim, facts: &Facts<'_>) -> Result<Vec<Check>, PublishedError> {
    Ok(vec![facts.check(
        "room left on the stage",
        "audit.ramp.room",
        ABOVE_ZERO,
        0.0,
    )])
}

/// C16: places of the layout against brushes counted.
pub(super) fn count(_: &Claim, facts: &Facts<'_>) -> Result<Vec<Check>, PublishedError> {
    Ok(vec![facts.small(
        "places less brushes",
        "audit.brushes_missing",
        0.0,
    )])
}

/// C17: slow friction above fast friction, either direction.
pub(super) fn static_and_dynamic(
    _: &Claim,
    facts: &Facts<'_>,
) -> Result<Vec<Check>, PublishedError> {
    Ok(vec![
        facts.check(
            "static excess forward",
            "audit.static_excess.forward",
            ABOVE_ZERO,
            0.0,
        ),
        facts.check(
            "static excess in reverse",
            "audit.static_excess.reverse",
            ABOVE_ZERO,
            0.0,
        ),
    ])
}

/// C18: how many of the seven can be found.
pub(super) fn identifiable(_: &Claim, facts: &Facts<'_>) -> Result<Vec<Check>, PublishedError> {
    let seven = Interval {
        lower: 7.0,
        upper: 7.0,
    };
    Ok(vec![facts.check(
        "parameters that can be found",
        "audit.scale_ray.parameters",
        seven,
        0.0,
    )])
}

/// C19: the brush's inertia over its friction.
pub(super) fn tension(claim: &Claim, facts: &Facts<'_>) -> Result<Vec<Check>, PublishedError> {
    let percent = claim.allows("percent");
    Ok(vec![facts.small(
        "inertia over friction",
        "audit.cord.inertia_share",
        percent,
    )])
}

/// C20: sigma0 of the 3x3 as its definition predicts it, for both counts of brushes, against the value that is kept.
pub(super) fn load(_: &Claim, facts: &Facts<'_>) -> Result<Vec<Check>, PublishedError> {
    let kept = facts.published.interval("table1.sigma0")?;
    let predicted = |name: &str| {
        let lower = format!("audit.sigma0_3x3.{name}.lower");
        let upper = format!("audit.sigma0_3x3.{name}.upper");
        let ours = match (facts.point(&lower), facts.point(&upper)) {
            (Some(lower), Some(upper)) => Some(Interval { lower, upper }),
            _ => None,
        };
        Check {
            ours,
            evidence: Evidence::Published,
            ..facts.check(
                &format!("sigma0 of the 3x3, {name} brushes"),
                &lower,
                kept,
                0.0,
            )
        }
    };
    Ok(vec![predicted("six"), predicted("nine")])
}

/// C21: what remains when one lean is to give both steady coefficients, in the worst of the four readings.
pub(super) fn lean_alone(claim: &Claim, facts: &Facts<'_>) -> Result<Vec<Check>, PublishedError> {
    Ok(vec![facts.small(
        "largest residual with one lean",
        "audit.lean.largest_residual",
        claim.allows("mu"),
    )])
}

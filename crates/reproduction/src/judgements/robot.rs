//! Claims about the biped: C10 to C13, C22.

use super::{Claim, Facts};
use crate::judge::Check;
use crate::published::{Interval, PublishedError};

const PITCHES: [&str; 3] = ["pitch-5", "pitch0", "pitch+5"];

/// C10: largest Fx/Fy of the asymmetric stride above that of the symmetric one.
pub(super) fn force_directions(_: &Claim, facts: &Facts<'_>) -> Result<Vec<Check>, PublishedError> {
    Ok(vec![facts.larger(
        "largest Fx/Fy, asymmetric less symmetric",
        "gait.force_direction.asymmetric.largest",
        "gait.force_direction.symmetric.largest",
    )])
}

/// C11: best speeds and their gain.
pub(super) fn best_speeds(claim: &Claim, facts: &Facts<'_>) -> Result<Vec<Check>, PublishedError> {
    let mut checks = Vec::new();
    for brush in ["asymmetric", "symmetric"] {
        let id = format!("gait.best_speed.{brush}");
        let tolerance = claim.allows("relative") * facts.published.value(&id)?;
        let printed = facts.published.interval(&id)?;
        checks.push(facts.check(
            &format!("mean best speed, {brush}"),
            &id,
            printed,
            tolerance,
        ));
    }
    let printed = facts.published.interval("gait.gain")?;
    checks.push(facts.check(
        "gain of the mean best speed",
        "gait.gain",
        printed,
        claim.allows("points"),
    ));
    Ok(checks)
}

/// C12: gain of the largest forward force at three pitches.
pub(super) fn forward_force(
    claim: &Claim,
    facts: &Facts<'_>,
) -> Result<Vec<Check>, PublishedError> {
    PITCHES
        .iter()
        .map(|pitch| {
            let id = format!("envelope.gain.{pitch}");
            let printed = facts.published.interval(&id)?;
            Ok(facts.check(
                &format!("gain at pitch {} deg", pitch.trim_start_matches("pitch")),
                &id,
                printed,
                claim.allows("points"),
            ))
        })
        .collect()
}

/// C13, two readings: the largest vertical force over the three postures, and its change between the two frictions.
pub(super) fn vertical_force(
    claim: &Claim,
    facts: &Facts<'_>,
) -> Result<Vec<Check>, PublishedError> {
    let percent = claim.allows("percent");
    let postures = facts.small(
        "spread over the three postures",
        "envelope.vertical_spread",
        percent,
    );
    // The worst of the three changes stands for the reading.
    let worst = PITCHES
        .iter()
        .map(|pitch| {
            facts.small(
                "change between the two frictions",
                &format!("envelope.vertical.{pitch}"),
                percent,
            )
        })
        .reduce(|one, other| match (one.gap(), other.gap()) {
            (Some(a), Some(b)) if a >= b => one,
            (None, _) => one,
            _ => other,
        });
    Ok(std::iter::once(postures).chain(worst).collect())
}

/// C22: the gain of speed against the range of the gains of force.
pub(super) fn force_and_speed(
    claim: &Claim,
    facts: &Facts<'_>,
) -> Result<Vec<Check>, PublishedError> {
    let gains: Option<Vec<f64>> = PITCHES
        .iter()
        .map(|pitch| facts.point(&format!("envelope.gain.{pitch}")))
        .collect();
    let range = gains.map(|gains| Interval {
        lower: gains.iter().copied().fold(f64::INFINITY, f64::min),
        upper: gains.iter().copied().fold(f64::NEG_INFINITY, f64::max),
    });
    let everything = Interval {
        lower: f64::NEG_INFINITY,
        upper: f64::INFINITY,
    };
    let check = facts.check(
        "gain of speed",
        "gait.gain",
        range.unwrap_or(everything),
        claim.allows("points"),
    );
    Ok(vec![Check {
        ours: check.ours.filter(|_| range.is_some()),
        ..check
    }])
}

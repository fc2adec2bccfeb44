//! Claims about friction measurements: C01 to C06, C09.

use super::{Claim, Facts};
use crate::judge::Check;
use crate::published::{Interval, PublishedError};

/// Parameters that a fit can compare singly.
const SINGLE: [&str; 4] = ["sigma0", "sigma1", "sigma2", "omega_sc"];

/// A row of Table 1 or 2 against the identified parameters of a material.
fn row(
    claim: &Claim,
    facts: &Facts<'_>,
    row: &str,
    material: &str,
) -> Result<Vec<Check>, PublishedError> {
    let mut checks = Vec::new();
    let mut add = |name: &str, printed: Interval| {
        let middle = 0.5 * (printed.lower + printed.upper).abs();
        let absolute = if name == "sigma2" {
            claim.allows("sigma2_s")
        } else {
            0.0
        };
        let tolerance = (claim.allows("relative") * middle).max(absolute);
        let id = format!("identification.{material}.{name}");
        checks.push(facts.check(&format!("{material} {name}"), &id, printed, tolerance));
    };
    for name in SINGLE {
        add(name, facts.published.interval(&format!("{row}.{name}"))?);
    }
    let sigma = facts.published.interval(&format!("{row}.sigma"))?;
    for (name, level) in [
        ("theta_c_over_sigma", "theta_c"),
        ("theta_s_over_sigma", "theta_s"),
    ] {
        let level = facts.published.interval(&format!("{row}.{level}"))?;
        add(name, level.combine(sigma, |level, sigma| level / sigma));
    }
    Ok(checks)
}

/// C01: Table 1 from the 2x2 campaign on aluminium.
pub(super) fn table_1(claim: &Claim, facts: &Facts<'_>) -> Result<Vec<Check>, PublishedError> {
    row(claim, facts, "table1", "aluminium")
}

/// C06: Table 2 from the campaigns on nylon and ceramic.
pub(super) fn table_2(claim: &Claim, facts: &Facts<'_>) -> Result<Vec<Check>, PublishedError> {
    let mut checks = row(claim, facts, "table2.nylon", "nylon")?;
    checks.extend(row(claim, facts, "table2.ceramic", "ceramic")?);
    Ok(checks)
}

/// C02: residual of the fit over the mean coefficient, either direction.
pub(super) fn match_2x2(claim: &Claim, facts: &Facts<'_>) -> Result<Vec<Check>, PublishedError> {
    Ok(both_directions(claim, facts, "identification.aluminium"))
}

/// C03: error of prediction over the mean coefficient, either direction.
pub(super) fn predict_3x3(claim: &Claim, facts: &Facts<'_>) -> Result<Vec<Check>, PublishedError> {
    Ok(both_directions(claim, facts, "validation.brush-3x3"))
}

fn both_directions(claim: &Claim, facts: &Facts<'_>, stem: &str) -> Vec<Check> {
    ["forward", "reverse"]
        .into_iter()
        .map(|direction| {
            let id = format!("{stem}.nrmse_{direction}");
            facts.small(
                &format!("error {direction} over mean coefficient"),
                &id,
                claim.allows("nrmse"),
            )
        })
        .collect()
}

/// C04: scatter between runs; counts only where it was measured.
pub(super) fn repeatable(claim: &Claim, facts: &Facts<'_>) -> Result<Vec<Check>, PublishedError> {
    let id = "identification.aluminium.run_scatter";
    Ok(vec![facts.small(
        "scatter between runs",
        id,
        claim.allows("scatter"),
    )])
}

/// C05: order of the differences forward less reverse.
pub(super) fn order_of_counterfaces(
    _: &Claim,
    facts: &Facts<'_>,
) -> Result<Vec<Check>, PublishedError> {
    let difference = |material: &str| format!("materials.{material}.difference");
    Ok(vec![
        facts.larger(
            "difference, aluminium less nylon",
            &difference("aluminium"),
            &difference("nylon"),
        ),
        facts.larger(
            "difference, nylon less ceramic",
            &difference("nylon"),
            &difference("ceramic"),
        ),
    ])
}

/// C09: the mean by rounding, the plateau of the campaign by tolerance.
pub(super) fn steady_coefficients(
    claim: &Claim,
    facts: &Facts<'_>,
) -> Result<Vec<Check>, PublishedError> {
    let forward = facts.published.interval("steady.forward")?;
    let reverse = facts.published.interval("steady.reverse")?;
    let mean = forward.combine(reverse, |f, r| 0.5 * (f + r));
    let sum = Check {
        ours: Some(mean),
        value_id: Some("audit.steady_mean.lower".to_owned()),
        evidence: report::Evidence::Published,
        ..facts.check(
            "mean of both",
            "audit.steady_mean.lower",
            facts.published.interval("steady.mean")?,
            0.0,
        )
    };
    let plateau = claim.allows("plateau");
    Ok(vec![
        sum,
        facts.check(
            "plateau forward",
            "materials.aluminium.steady_forward",
            forward,
            plateau,
        ),
        facts.check(
            "plateau reverse",
            "materials.aluminium.steady_reverse",
            reverse,
            plateau,
        ),
    ])
}

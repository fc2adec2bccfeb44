//! `claim`: one claim with what it needs, or those that say most within a budget of time.

mod budget;

use report::Verdict;

use super::inputs::Inputs;
use super::reproduce::{disagreements, needed};
use super::root::out;
use super::{ClaimArguments, Failure, Outcome};
use crate::claims::Claim;
use crate::costs::Costs;
use crate::engine::closure;
use crate::flips;
use crate::judge::Check;
use crate::judgements::Judged;
use crate::names::nearest;
use crate::results::{Results, interval, stated};
use crate::{cache, stages};

pub(super) fn run(arguments: &ClaimArguments) -> Result<Outcome, Failure> {
    match (&arguments.budget, &arguments.id) {
        (Some(budget), _) => budget::run(arguments, budget),
        (None, Some(id)) => one(arguments, id),
        (None, None) => Err(Failure::Input(
            "which claim? C01 to C22, or --budget TIME for those that say most".to_owned(),
        )),
    }
}

fn one(arguments: &ClaimArguments, id: &str) -> Result<Outcome, Failure> {
    let inputs = Inputs::read(None)?;
    let wanted = id.to_uppercase();
    let Some(claim) = inputs
        .claims
        .iter()
        .find(|claim| claim.id == wanted)
        .cloned()
    else {
        let near = nearest(id, inputs.claims.iter().map(|claim| claim.id.as_str()));
        return Err(Failure::Input(format!(
            "no claim is called `{id}`; the nearest name is `{near}`"
        )));
    };
    let folder = out(&inputs.root, &arguments.out);
    let results = judged(&inputs, &claim, &folder)?;
    let Some((_, judged)) = results.claims.iter().find(|(one, _)| one.id == claim.id) else {
        return Err(Failure::Output("the claim was not judged".to_owned()));
    };
    tell(&claim, judged, &results);
    let costs = Costs::read(&inputs.root, &cache::folder(&folder)).map_err(Failure::input)?;
    say!("cost       {}", cost(&claim, &results, &costs));
    let disagreements = disagreements(&only(&results, &claim));
    for disagreement in &disagreements {
        say_aside!("not as pinned: {disagreement}");
    }
    let not_run = judged.verdict == Verdict::NotRun;
    Ok(if disagreements.is_empty() && !not_run {
        Outcome::Done
    } else {
        Outcome::Disagrees
    })
}

/// Runs what a claim needs.
fn judged(inputs: &Inputs, claim: &Claim, folder: &std::path::Path) -> Result<Results, Failure> {
    let all = stages::all();
    let ids = needed(&all, claim);
    let ids: Vec<&str> = ids.iter().map(String::as_str).collect();
    let stages = closure(&all, &ids);
    inputs.open_all(&stages)?;
    inputs.run(&stages, folder, None, false)
}

/// The results with this claim alone: what was not asked for disagrees with nothing.
fn only(results: &Results, claim: &Claim) -> Results {
    let mut results = results.clone();
    results.claims.retain(|(one, _)| one.id == claim.id);
    results
}

fn tell(claim: &Claim, judged: &Judged, results: &Results) {
    say!("{}  {}", claim.id, claim.text);
    say!("verdict    {}", judged.verdict.word());
    say!("evidence   {}", judged.evidence.word());
    say!("published  {} ({})", claim.published_text, claim.locator);
    for check in &judged.checks {
        say!("ours       {}", compared(check));
    }
    say!("tolerance  {}", claim.tolerance_text);
    say!("reason     {}", claim.reason);
    if let Some(words) = flips::words(claim, &judged.checks) {
        say!("flips      {words}");
    }
    if let Some(multiverse) = results.multiverses.get(&claim.id) {
        say!(
            "choices    the same verdict in {} of {} combinations; the report lists them",
            multiverse.holds,
            multiverse.of
        );
    }
    for stage in results
        .stages
        .iter()
        .filter(|stage| stage.status() != "done")
    {
        say!("stage      {}: {}", stage.id, stage.status());
    }
}

/// One comparison in words: what came out, and what it is held against.
fn compared(check: &Check) -> String {
    let ours = check.ours.map_or_else(
        || "not computed".to_owned(),
        |ours| interval(ours, &check.unit),
    );
    let unit = if check.unit == "1" {
        String::new()
    } else {
        format!(" {}", check.unit)
    };
    let tolerance = format!("{}{unit}", stated(check.tolerance));
    let (lower, upper) = (check.allowed.lower, check.allowed.upper);
    let held = if lower == 0.0 && upper == 0.0 && check.tolerance > 0.0 {
        format!("at most {tolerance} agrees")
    } else if lower == f64::MIN_POSITIVE && upper.is_infinite() {
        "above 0 agrees".to_owned()
    } else if check.tolerance > 0.0 {
        format!(
            "the paper's {} to within {tolerance} agrees",
            interval(check.allowed, &check.unit)
        )
    } else {
        format!("exactly {} agrees", interval(check.allowed, &check.unit))
    };
    let outcome = match check.agrees() {
        Some(true) => "it does",
        Some(false) => "it does not",
        None => "open",
    };
    format!("{}: {ours}; {held}: {outcome}", check.label)
}

/// What the claim costs to compute, and what it cost now.
fn cost(claim: &Claim, results: &Results, costs: &Costs) -> String {
    let ids = needed(&stages::all(), claim);
    if ids.is_empty() {
        return "none: no stage takes part".to_owned();
    }
    let now: f64 = results.stages.iter().map(|stage| stage.seconds).sum();
    let kept = results.stages.iter().filter(|stage| stage.kept).count();
    let cold = costs.of(ids.iter().map(String::as_str));
    let kept = match (kept, results.stages.len()) {
        (0, _) => String::new(),
        (kept, all) if kept == all => format!(" (all kept; {cold:.1} s to compute)"),
        (kept, all) => format!(" ({kept} of {all} kept; {cold:.1} s to compute all)"),
    };
    format!("{now:.2} s{kept}; stages: {}", ids.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::published::Interval;
    use report::Evidence;

    fn check(ours: f64, allowed: [f64; 2], tolerance: f64) -> Check {
        let interval = |[lower, upper]: [f64; 2]| Interval { lower, upper };
        Check {
            label: "error forward".into(),
            ours: Some(interval([ours; 2])),
            allowed: interval(allowed),
            tolerance,
            unit: "1".into(),
            evidence: Evidence::Computed,
            value_id: None,
        }
    }

    #[test]
    fn a_comparison_is_said_as_a_person_would() {
        assert_eq!(
            compared(&check(0.0168, [0.0, 0.0], 0.05)),
            "error forward: 0.01680; at most 0.05 agrees: it does"
        );
        assert_eq!(
            compared(&check(11.58, [14.8, 14.9], 0.5)),
            "error forward: 11.58; the paper's [14.80, 14.90] to within 0.5 agrees: it does not"
        );
        assert_eq!(
            compared(&check(-4.9, [f64::MIN_POSITIVE, f64::INFINITY], 0.0)),
            "error forward: -4.900; above 0 agrees: it does not"
        );
        assert_eq!(
            compared(&check(6.0, [7.0, 7.0], 0.0)),
            "error forward: 6; exactly 7 agrees: it does not"
        );
    }
}

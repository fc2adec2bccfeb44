//! `claim`: one claim with what it needs.

use report::Verdict;

use super::reproduce::{Inputs, disagreements, needed};
use super::root::out;
use super::{ClaimArguments, Failure, Outcome};
use crate::engine::closure;
use crate::judge::flips_at;
use crate::names::nearest;
use crate::results::{interval, significant};
use crate::stages;

pub(super) fn run(arguments: &ClaimArguments) -> Result<Outcome, Failure> {
    let mut inputs = Inputs::read(None)?;
    let wanted = arguments.id.to_uppercase();
    let Some(claim) = inputs
        .claims
        .iter()
        .find(|claim| claim.id == wanted)
        .cloned()
    else {
        let near = nearest(
            &arguments.id,
            inputs.claims.iter().map(|claim| claim.id.as_str()),
        );
        return Err(Failure::Input(format!(
            "no claim is called `{}`; the nearest name is `{near}`",
            arguments.id
        )));
    };
    inputs.claims.retain(|other| other.id == claim.id);
    let all = stages::all();
    let ids = needed(&all, &claim);
    let ids: Vec<&str> = ids.iter().map(String::as_str).collect();
    let stages = closure(&all, &ids);
    inputs.open_all(&stages)?;
    let results = inputs.run(&stages, &out(&inputs.root, &arguments.out), None, false)?;
    let Some((_, judged)) = results.claims.first() else {
        return Err(Failure::Output("the claim was not judged".to_owned()));
    };
    println!("{}  {}", claim.id, claim.text);
    println!("verdict    {}", judged.verdict.word());
    println!("evidence   {}", judged.evidence.word());
    println!("published  {} ({})", claim.published_text, claim.locator);
    for check in &judged.checks {
        let ours = check.ours.map_or_else(
            || "not computed".to_owned(),
            |ours| interval(ours, &check.unit),
        );
        let gap = check.gap().filter(|gap| *gap > 0.0);
        let gap = gap.map_or_else(String::new, |gap| {
            format!(", outside by {}", significant(gap))
        });
        println!(
            "ours       {}: {ours}, allowed {}{gap}",
            check.label,
            interval(check.allowed, &check.unit)
        );
    }
    println!("tolerance  {}", claim.tolerance_text);
    println!("reason     {}", claim.reason);
    if let Some(factor) = flips_at(&judged.checks).filter(|factor| *factor > 1.0) {
        println!(
            "           would agree with {} times the tolerance",
            significant(factor)
        );
    }
    for stage in results
        .stages
        .iter()
        .filter(|stage| stage.status() != "done")
    {
        println!("stage      {}: {}", stage.id, stage.status());
    }
    let seconds: f64 = results.stages.iter().map(|stage| stage.seconds).sum();
    let names = if ids.is_empty() {
        "none".to_owned()
    } else {
        ids.join(", ")
    };
    println!("cost       {seconds:.2} s; stages: {names}");
    let disagreements = disagreements(&results);
    for disagreement in &disagreements {
        eprintln!("not as pinned: {disagreement}");
    }
    let not_run = judged.verdict == Verdict::NotRun;
    Ok(if disagreements.is_empty() && !not_run {
        Outcome::Done
    } else {
        Outcome::Disagrees
    })
}

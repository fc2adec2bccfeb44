//! `claim --budget 10min`: the claims that say most, as far as the time reaches.
//!
//! How much a claim can say is how freely its verdict can still fall, by its nature and the data at hand (see [`weight`]).
//! Stages are bought one bundle after the other, each time the one that opens the most weight a second; claims that share
//! a bundle come together, the weightiest first.

use std::collections::BTreeSet;
use std::path::Path;
use std::time::Instant;

use report::Verdict;

use super::super::inputs::Inputs;
use super::super::reproduce::{disagreements, needed};
use super::super::root::out;
use super::super::{ClaimArguments, Failure, Outcome};
use super::{judged, only};
use crate::claims::Claim;
use crate::costs::Costs;
use crate::judge::Nature;
use crate::{cache, stages};

/// How much a claim can say on the shipped data.
fn weight(claim: &Claim) -> f64 {
    match claim.nature {
        // The paper's own numbers decide, either way, and nothing of ours can be blamed.
        Nature::Arithmetic => 4.0,
        // A printed number is met or not.
        Nature::Computation => 3.0,
        // At best consistent: a number or an equation behind it is not published.
        Nature::Reading => 2.0,
        // On stand-ins at best consistent, and they were made to be.
        Nature::Measurement => 1.0,
        Nature::Untestable => 0.0,
    }
}

/// A claim with the stages that it needs.
#[derive(Clone, Debug, PartialEq)]
struct Candidate {
    id: String,
    weight: f64,
    stages: Vec<String>,
}

/// A claim that fits, with what is still to be computed for it, s.
#[derive(Clone, Debug, PartialEq)]
struct Planned {
    id: String,
    seconds: f64,
}

/// The claims that fit into the budget, in the order in which they are worth it; and the others with what each would add.
fn plan(candidates: &[Candidate], costs: &Costs, budget_s: f64) -> (Vec<Planned>, Vec<Planned>) {
    let mut bought: BTreeSet<&str> = BTreeSet::new();
    let mut planned: Vec<Planned> = Vec::new();
    let mut left: Vec<&Candidate> = candidates.iter().collect();
    left.sort_by(|a, b| b.weight.total_cmp(&a.weight).then(a.id.cmp(&b.id)));
    let mut spent = 0.0;
    loop {
        let missing = |candidate: &Candidate| {
            let stages = candidate.stages.iter().map(String::as_str);
            costs.of(stages.filter(|stage| !bought.contains(stage)))
        };
        let opened = |bundle: &Candidate, other: &Candidate| {
            other
                .stages
                .iter()
                .all(|stage| bought.contains(stage.as_str()) || bundle.stages.contains(stage))
        };
        let rate = |bundle: &Candidate| {
            let weight: f64 = left
                .iter()
                .filter(|other| opened(bundle, other))
                .map(|other| other.weight)
                .sum();
            // What is free comes first whatever it says.
            weight / missing(bundle).max(1e-3)
        };
        let best = left
            .iter()
            .filter(|candidate| spent + missing(candidate) <= budget_s)
            .max_by(|a, b| rate(a).total_cmp(&rate(b)).then(b.id.cmp(&a.id)))
            .copied();
        let Some(best) = best else {
            let rest = left.iter().map(|candidate| Planned {
                id: candidate.id.clone(),
                seconds: missing(candidate),
            });
            return (planned, rest.collect());
        };
        let mut cost = missing(best);
        spent += cost;
        let (now, later): (Vec<&Candidate>, Vec<&Candidate>) = left
            .iter()
            .copied()
            .partition(|candidate| opened(best, candidate));
        for candidate in now {
            let id = candidate.id.clone();
            // The first of a bundle pays for it.
            planned.push(Planned { id, seconds: cost });
            cost = 0.0;
        }
        left = later;
        bought.extend(best.stages.iter().map(String::as_str));
    }
}

/// Seconds of `10min`, `90s`, `1.5h` or a bare number of seconds.
fn seconds(text: &str) -> Option<f64> {
    let text = text.trim();
    let split = text
        .find(|letter: char| letter.is_ascii_alphabetic())
        .unwrap_or(text.len());
    let (number, unit) = text.split_at(split);
    let factor = match unit {
        "" | "s" | "sec" => 1.0,
        "m" | "min" => 60.0,
        "h" => 3600.0,
        _ => return None,
    };
    let number: f64 = number.trim().parse().ok()?;
    (number.is_finite() && number >= 0.0).then_some(factor * number)
}

pub(super) fn run(arguments: &ClaimArguments, budget: &str) -> Result<Outcome, Failure> {
    let budget_s = seconds(budget)
        .ok_or_else(|| Failure::Input(format!("`{budget}` is no time: 90s, 10min or 1h are")))?;
    let inputs = Inputs::read(None)?;
    let folder = out(&inputs.root, &arguments.out);
    let costs = Costs::read(&inputs.root, &cache::folder(&folder)).map_err(Failure::input)?;
    let all = stages::all();
    let candidates: Vec<Candidate> = inputs
        .claims
        .iter()
        .map(|claim| Candidate {
            id: claim.id.clone(),
            weight: weight(claim),
            stages: needed(&all, claim),
        })
        .collect();
    let (planned, rest) = plan(&candidates, &costs, budget_s);
    let total: f64 = planned.iter().map(|one| one.seconds).sum();
    say!(
        "plan       {} of {} claims in some {total:.0} s of {budget_s:.0} s; costs measured {}",
        planned.len(),
        candidates.len(),
        costs.measured
    );
    let words = |some: &[Planned]| -> String {
        let words = some.iter().map(|one| match one.seconds {
            0.0 => one.id.clone(),
            seconds => format!("{} ({seconds:.1} s)", one.id),
        });
        words.collect::<Vec<_>>().join(", ")
    };
    say!("order      {}", words(&planned));
    if !rest.is_empty() {
        say!("left out   {}", words(&rest));
    }
    carry_out(&inputs, &planned, &folder, budget_s)
}

/// Runs the plan claim by claim; stops before one that the time that is left would not pay for.
fn carry_out(
    inputs: &Inputs,
    planned: &[Planned],
    folder: &Path,
    budget_s: f64,
) -> Result<Outcome, Failure> {
    let clock = Instant::now();
    let mut outcome = Outcome::Done;
    for one in planned {
        let Some(claim) = inputs.claims.iter().find(|claim| claim.id == one.id) else {
            continue;
        };
        let left = budget_s - clock.elapsed().as_secs_f64();
        if one.seconds > left {
            say!("{}  left out: {left:.0} s are left", claim.id);
            continue;
        }
        let before = clock.elapsed().as_secs_f64();
        let results = only(&judged(inputs, claim, folder)?, claim);
        let Some((_, judged)) = results.claims.first() else {
            return Err(Failure::Output("the claim was not judged".to_owned()));
        };
        let took = clock.elapsed().as_secs_f64() - before;
        say!(
            "{}  {:<12}  {took:>6.1} s  {}",
            claim.id,
            judged.verdict.word(),
            claim.text
        );
        let found = disagreements(&results);
        for disagreement in &found {
            say_aside!("not as pinned: {disagreement}");
        }
        if !found.is_empty() || judged.verdict == Verdict::NotRun {
            outcome = Outcome::Disagrees;
        }
    }
    say!(
        "spent      {:.1} s of {budget_s:.0} s",
        clock.elapsed().as_secs_f64()
    );
    Ok(outcome)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn costs(stages: &[(&str, f64)]) -> Costs {
        let seconds = stages.iter().map(|(id, s)| ((*id).to_owned(), *s));
        Costs {
            measured: String::new(),
            seconds: seconds.collect(),
        }
    }

    fn candidate(id: &str, weight: f64, stages: &[&str]) -> Candidate {
        Candidate {
            id: id.into(),
            weight,
            stages: stages.iter().map(|stage| (*stage).to_owned()).collect(),
        }
    }

    fn ids(planned: &[Planned]) -> Vec<&str> {
        planned.iter().map(|one| one.id.as_str()).collect()
    }

    #[test]
    fn what_says_most_a_second_comes_first_and_a_stage_is_paid_once() {
        let all = [
            candidate("dear", 3.0, &["long"]),
            candidate("cheap", 1.0, &["short"]),
            candidate("free", 0.0, &[]),
            candidate("shared", 2.0, &["short"]),
        ];
        let costs = costs(&[("long", 50.0), ("short", 2.0)]);
        let (planned, rest) = plan(&all, &costs, 60.0);
        assert_eq!(ids(&planned), ["shared", "cheap", "free", "dear"]);
        assert!(rest.is_empty());
        let total: f64 = planned.iter().map(|one| one.seconds).sum();
        assert_eq!(total, 52.0);
    }

    #[test]
    fn what_does_not_fit_is_left_out_with_its_price() {
        let all = [
            candidate("dear", 9.0, &["short", "long"]),
            candidate("cheap", 1.0, &["short"]),
        ];
        let costs = costs(&[("long", 50.0), ("short", 2.0)]);
        let (planned, rest) = plan(&all, &costs, 10.0);
        assert_eq!(ids(&planned), ["cheap"]);
        assert_eq!(
            rest,
            [Planned {
                id: "dear".into(),
                seconds: 50.0
            }]
        );
        assert!(plan(&all, &costs, 0.0).0.is_empty());
    }

    #[test]
    fn times_are_read_as_people_write_them() {
        for (text, found) in [
            ("10min", Some(600.0)),
            ("90s", Some(90.0)),
            ("1.5h", Some(5400.0)),
            ("600", Some(600.0)),
            ("2 min", Some(120.0)),
            ("soon", None),
            ("-3s", None),
            ("10 weeks", None),
        ] {
            assert_eq!(seconds(text), found, "{text}");
        }
    }
}

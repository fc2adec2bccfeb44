//! What a design cannot tell apart, whatever the size: causes that the law absorbs, causes whose signatures are one, and
//! causes for which the campaign lacks what they need.

use nalgebra::DMatrix;
use rayon::prelude::*;
use rig::Cause;

use crate::answer::Undecidable;
use crate::bench::Bench;
use crate::equivalence::{flattened, sine};
use crate::experiment::{Hypothesis, Proposal, propose};
use crate::scan::{Scan, scan_without};
use crate::signatures::extended;
use crate::stand::Stand;
use crate::subset::Subset;

/// Two signatures closer than this (sine of their angle) are one: an effect of twenty times its threshold, d' = 94,
/// would still not reach the distance 4.7.
const ONE: f64 = 0.05;

/// Groups of causes that the design ties together beside a law under its noise.
pub(crate) fn ties_beside(
    bench: &Bench<'_>,
    subset: &Subset,
    law: &Stand,
    scatter: f64,
) -> Vec<Undecidable> {
    let skipped: Vec<usize> = (0..bench.catalogue.len())
        .filter(|&cause| bench.catalogue[cause].is_periodic())
        .collect();
    let scan = scan_without(bench, subset, law, scatter, &skipped);
    ties(bench, law, &scan, scatter)
}

/// Groups of causes that the design ties together, with the experiment that would break each tie; `scan` is that of this stand.
pub(crate) fn ties(
    bench: &Bench<'_>,
    stand: &Stand,
    scan: &Scan,
    scatter: f64,
) -> Vec<Undecidable> {
    let mut causes: Vec<usize> = scan.candidates.iter().map(|c| c.cause).collect();
    causes.sort_unstable();
    causes.retain(|&c| !bench.catalogue[c].is_periodic());
    let flat: Vec<Vec<DMatrix<f64>>> = causes
        .par_iter()
        .map(|&cause| flattened(&stand.ground, &scan.rays, cause, scatter))
        .collect();
    let mut group: Vec<usize> = (0..causes.len()).collect();
    for i in 0..causes.len() {
        for j in 0..i {
            let same = bench.catalogue[causes[i]].id() == bench.catalogue[causes[j]].id();
            if same || group[i] == group[j] {
                continue;
            }
            if sine(&flat[i], &flat[j]).is_some_and(|s| s < ONE) {
                let (a, b) = (group[i], group[j]);
                group.iter_mut().filter(|g| **g == a).for_each(|g| *g = b);
            }
        }
    }
    let mut out = Vec::new();
    for leader in 0..causes.len() {
        let members: Vec<usize> = (0..causes.len()).filter(|&i| group[i] == leader).collect();
        if members.len() < 2 {
            continue;
        }
        let mut ids: Vec<String> = members
            .iter()
            .map(|&i| bench.catalogue[causes[i]].id().to_owned())
            .collect();
        ids.sort();
        ids.dedup();
        if ids.len() < 2 {
            continue;
        }
        let (a, b) = (causes[members[0]], causes[members[1]]);
        let experiment = decisive(&ids, || break_tie(bench, stand, scan, a, b));
        out.push(Undecidable {
            because: why(bench, &ids),
            causes: ids,
            experiment,
        });
    }
    for &cause in &scan.absorbed {
        let effect: &dyn Cause = bench.catalogue[cause].as_ref();
        out.push(Undecidable {
            causes: vec![effect.id().to_owned()],
            because: "the law's own parameters absorb it".into(),
            experiment: absorbed_remedy(effect.id()).into(),
        });
    }
    out
}

/// Causes that the campaign's record cannot show at all.
pub(crate) fn lacking(bench: &Bench<'_>) -> Vec<Undecidable> {
    let mut out: Vec<Undecidable> = Vec::new();
    for cause in crate::causes::catalogue() {
        if !cause.applies_to(bench.law) {
            continue;
        }
        // Another form of it may be asked for.
        if bench.catalogue.iter().any(|other| other.id() == cause.id()) {
            continue;
        }
        if let Some(lack) = cause.lack(&bench.experiment) {
            let because = lack.lack().to_owned();
            match out.iter_mut().find(|u| u.because == because) {
                Some(entry) => {
                    if !entry.causes.iter().any(|id| id == cause.id()) {
                        entry.causes.push(cause.id().to_owned());
                    }
                }
                None => out.push(Undecidable {
                    causes: vec![cause.id().to_owned()],
                    experiment: remedy(lack).into(),
                    because,
                }),
            }
        }
    }
    out.iter_mut().for_each(|u| u.causes.sort());
    out
}

fn remedy(lack: rig::Requirement) -> &'static str {
    match lack {
        rig::Requirement::Load => "record the normal load",
        rig::Requirement::NoLoad => "diagnose the record without its load",
        rig::Requirement::TwoLoads => "repeat two runs at twice the load",
        rig::Requirement::Order => "write down the order of the runs",
        rig::Requirement::Clock => "write down when each run started",
        rig::Requirement::RunningClock => "start the clock before the first run",
        rig::Requirement::BothDirections => "repeat a run in the other direction",
        rig::Requirement::Reversals => "add a run that reverses",
        rig::Requirement::MovingMass => "state the rig's moving mass",
    }
}

fn absorbed_remedy(cause: &str) -> &'static str {
    match cause {
        "force-gain" => {
            "calibrate the force channel with a weight, or diagnose against a model identified elsewhere"
        }
        "lean-angle" => "diagnose against a model identified on another specimen",
        "load-dependence" => "repeat two runs at twice the load",
        _ => "diagnose against a model identified elsewhere",
    }
}

/// What would tell tied causes apart, in words: a gain needs no run with friction in it, else the run that is proposed.
pub(crate) fn decisive(causes: &[String], proposed: impl FnOnce() -> Option<Proposal>) -> String {
    if causes.iter().any(|id| id == "force-gain") {
        return "calibrate the force channel with a weight".into();
    }
    proposed().map_or_else(
        || "none of the runs that were considered".into(),
        |proposal| proposal.to_string(),
    )
}

/// Why a group is tied, in words.
fn why(bench: &Bench<'_>, ids: &[String]) -> String {
    let load_ties = ["force-zero-offset", "stage-tilt", "load-crosstalk"];
    let all_load = ids.iter().all(|id| load_ties.contains(&id.as_str()));
    if all_load && !bench.experiment.has_two_loads() {
        "all runs have one load".into()
    } else if all_load {
        "no run was made with the stage turned round".into()
    } else {
        "their signatures are the same on this protocol, once the law has been fitted".into()
    }
}

/// The run that separates two tied causes at a size of five times what the noise hides.
fn break_tie(
    bench: &Bench<'_>,
    stand: &Stand,
    scan: &Scan,
    a: usize,
    b: usize,
) -> Option<Proposal> {
    let sized = |cause: usize| -> Option<(Vec<usize>, Vec<f64>)> {
        let candidate = scan.candidates.iter().find(|c| c.cause == cause)?;
        let effect = &bench.catalogue[cause];
        let specs = effect.parameters_for(&bench.experiment);
        let mut own = candidate.starts.first()?.clone();
        for (k, &i) in effect.sizes().iter().enumerate() {
            let sd = candidate.score.sd.get(k).copied().unwrap_or(0.0) * candidate.unit;
            own[i] = (20.0 * sd).clamp(specs[i].lower, specs[i].upper);
        }
        let (_, p) = extended(bench, &stand.fitted, cause, &own)?;
        let mut effects = stand.fitted.effects.clone();
        effects.push(cause);
        Some((effects, p))
    };
    let (x, y) = (sized(a)?, sized(b)?);
    propose(
        bench,
        &stand.sizes,
        &Hypothesis {
            effects: &x.0,
            parameters: &x.1,
        },
        &Hypothesis {
            effects: &y.0,
            parameters: &y.1,
        },
    )
}

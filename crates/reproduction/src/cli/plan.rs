//! `plan`: the stages as tasks for several machines, as a matrix of GitHub Actions.

use std::collections::BTreeMap;

use serde::Serialize;

use super::inputs::{Inputs, stages_named};
use super::{Failure, Outcome, PlanArguments};
use crate::cache::Cache;
use crate::costs::Costs;
use crate::engine::Task;
use crate::stages;
use crate::watch::Watch;

/// A matrix of GitHub Actions whose jobs are given one by one.
#[derive(Debug, Serialize)]
struct Matrix<E> {
    include: Vec<E>,
}

/// One task.
#[derive(Debug, Serialize)]
struct Entry {
    stage: &'static str,
    title: &'static str,
    needs: Vec<String>,
    key: String,
    seconds: f64,
}

/// Tasks for one machine.
#[derive(Debug, PartialEq, Serialize)]
struct Shard {
    shard: usize,
    stages: String,
    seconds: f64,
}

pub(super) fn run(arguments: &PlanArguments) -> Result<Outcome, Failure> {
    let basis = &arguments.basis;
    let inputs = Inputs::read(basis.data.as_deref())?;
    let stages = stages_named(&stages::all(), &arguments.stage)?;
    let model = basis.model()?;
    inputs.open_all(&stages)?;
    let watch = Watch::new();
    // Nothing is computed, so nothing is kept.
    let cache = Cache::new(std::path::Path::new(""));
    let engine = inputs.engine(cache, model.as_ref(), basis.quick, &watch)?;
    let tasks = engine.plan(&stages).map_err(Failure::input)?;
    let costs = Costs::shipped(&inputs.root).map_err(Failure::input)?;
    let text = match arguments.shards {
        Some(count) => serde_json::to_string(&Matrix {
            include: shards(&tasks, &costs, count.get()),
        }),
        None => {
            let entry = |(task, stage): (&Task, &&dyn crate::Stage)| Entry {
                stage: task.stage,
                title: stage.title(),
                needs: task.origin.needs.keys().cloned().collect(),
                key: task.key(),
                seconds: rounded(costs.of([task.stage])),
            };
            serde_json::to_string_pretty(&Matrix {
                include: tasks.iter().zip(&stages).map(entry).collect::<Vec<_>>(),
            })
        }
    };
    say!("{}", text.map_err(Failure::output)?);
    Ok(Outcome::Done)
}

/// Hundredths of a second are more than enough.
fn rounded(seconds: f64) -> f64 {
    (seconds * 100.0).round() / 100.0
}

/// Tasks in at most `count` bundles: what hangs together stays together, the dearest goes first, each to the bundle that
/// is cheapest so far.
fn shards(tasks: &[Task], costs: &Costs, count: usize) -> Vec<Shard> {
    let mut parts = connected(tasks);
    let cost = |part: &Vec<&'static str>| costs.of(part.iter().copied());
    // A stable sort: equal costs stay in the order of the report.
    parts.sort_by(|a, b| cost(b).total_cmp(&cost(a)));
    let mut bundles = vec![Vec::new(); count.min(parts.len())];
    for part in parts {
        if let Some(cheapest) = bundles
            .iter_mut()
            .min_by(|a, b| cost(a).total_cmp(&cost(b)))
        {
            cheapest.extend(part);
        }
    }
    let shard = |(k, bundle): (usize, &Vec<&'static str>)| Shard {
        shard: k + 1,
        stages: bundle.join(" "),
        seconds: rounded(cost(bundle)),
    };
    bundles.iter().enumerate().map(shard).collect()
}

/// Groups of tasks that need no other group, in the order of the report.
fn connected(tasks: &[Task]) -> Vec<Vec<&'static str>> {
    // A task stands behind those that it needs; it joins their groups into the first.
    let mut group_of: BTreeMap<&str, usize> = BTreeMap::new();
    for (k, task) in tasks.iter().enumerate() {
        let joined: Vec<usize> = task
            .origin
            .needs
            .keys()
            .map(|need| group_of[need.as_str()])
            .collect();
        let first = joined.iter().copied().min().unwrap_or(k);
        for group in group_of.values_mut().filter(|group| joined.contains(group)) {
            *group = first;
        }
        group_of.insert(task.stage, first);
    }
    let mut groups: BTreeMap<usize, Vec<&'static str>> = BTreeMap::new();
    for task in tasks {
        groups
            .entry(group_of[task.stage])
            .or_default()
            .push(task.stage);
    }
    groups.into_values().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parcel::tests::origin;

    fn task(stage: &'static str, needs: &[&str]) -> Task {
        let mut origin = origin("one");
        origin.needs = needs
            .iter()
            .map(|need| ((*need).to_owned(), String::new()))
            .collect();
        Task { stage, origin }
    }

    #[test]
    fn what_hangs_together_stays_together_and_the_dearest_goes_alone() {
        let tasks = [
            task("a", &[]),
            task("b", &[]),
            task("c", &["a", "b"]),
            task("d", &[]),
            task("e", &[]),
        ];
        assert_eq!(
            connected(&tasks),
            [vec!["a", "b", "c"], vec!["d"], vec!["e"]]
        );
        let seconds = [("a", 1.0), ("b", 1.0), ("c", 1.0), ("d", 4.0), ("e", 0.5)];
        let costs = Costs {
            measured: String::new(),
            seconds: seconds.map(|(stage, cost)| (stage.to_owned(), cost)).into(),
        };
        let of = |count| -> Vec<String> {
            let found = shards(&tasks, &costs, count);
            found.into_iter().map(|shard| shard.stages).collect()
        };
        assert_eq!(of(1), ["d a b c e"]);
        assert_eq!(of(2), ["d", "a b c e"]);
        assert_eq!(of(9), ["d", "a b c", "e"], "no bundle is empty");
    }
}

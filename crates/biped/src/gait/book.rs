//! A book of strides: named problems with the best stride found for each, improved from each other.
//!
//! In every round each problem is solved from the strides of its neighbours that are new since it last
//! looked; the cheapest certified stride stays. The book is complete when a round changes nothing.

use super::Problem;
use super::catalogue::Name;
use super::chain::{Case, Outcome, solve_all};
use super::refine::on_mesh;
use trajectory::{Options, ProgrammeError, Start};

/// A named problem and what is known about it.
#[derive(Clone, Debug)]
pub struct Entry {
    /// The name.
    pub name: Name,
    /// The problem.
    pub problem: Problem,
    /// The best stride so far.
    pub outcome: Option<Outcome>,
    /// Round in which the best stride was found.
    changed: usize,
    /// Round in which this problem was last solved from its neighbours.
    looked: Option<usize>,
}

/// The book.
#[derive(Clone, Debug, Default)]
pub struct Book {
    /// Its entries, in the order in which they were added.
    pub entries: Vec<Entry>,
    round: usize,
}

impl Book {
    /// Adds problems, each with its starts, and solves them from these.
    ///
    /// # Errors
    /// A start of the wrong length, or a problem that contradicts itself.
    pub fn add(
        &mut self,
        named: Vec<(Name, Problem, Vec<Start>)>,
        options: &Options,
    ) -> Result<(), ProgrammeError> {
        let cases: Vec<Case> = named
            .iter()
            .map(|(_, problem, starts)| Case {
                problem: *problem,
                starts: starts.clone(),
            })
            .collect();
        let outcomes = solve_all(&cases, options)?;
        for ((name, problem, _), outcome) in named.into_iter().zip(outcomes) {
            self.entries.push(Entry {
                name,
                problem,
                outcome,
                changed: self.round,
                looked: None,
            });
        }
        Ok(())
    }

    /// One round: the problems that `wanted` takes are solved from the strides of their neighbours that are
    /// new to them. Returns how many strides became better (or were found for the first time).
    ///
    /// # Errors
    /// As [`Book::add`].
    pub fn cross_seed(
        &mut self,
        wanted: impl Fn(&Name) -> bool,
        options: &Options,
    ) -> Result<usize, ProgrammeError> {
        let cases: Vec<Case> = self
            .entries
            .iter()
            .map(|entry| Case {
                problem: entry.problem,
                starts: if wanted(&entry.name) {
                    self.starts(entry)
                } else {
                    Vec::new()
                },
            })
            .collect();
        let outcomes = solve_all(&cases, options)?;
        self.round += 1;
        let mut better = 0;
        for ((entry, outcome), case) in self.entries.iter_mut().zip(outcomes).zip(&cases) {
            if !case.starts.is_empty() {
                entry.looked = Some(self.round);
            }
            let Some(outcome) = outcome else { continue };
            let merged = match entry.outcome.take() {
                Some(before) => {
                    let (status, cost) = (before.status, before.cost);
                    let merged = before.merged(outcome);
                    (merged.status != status || merged.cost != cost, merged)
                }
                None => (true, outcome),
            };
            if merged.0 {
                entry.changed = self.round;
                better += 1;
            }
            entry.outcome = Some(merged.1);
        }
        Ok(better)
    }

    /// Problems without a certified stride.
    pub fn gaps(&self) -> impl Iterator<Item = Name> {
        let open = |e: &&Entry| e.outcome.as_ref().is_none_or(|o| !o.is_certified());
        self.entries.iter().filter(open).map(|e| e.name)
    }

    /// The certified strides of the neighbours of an entry that it has not started from yet.
    fn starts(&self, entry: &Entry) -> Vec<Start> {
        let mesh = entry.problem.mesh;
        self.entries
            .iter()
            .filter(|other| other.name.is_beside(&entry.name))
            .filter(|other| entry.looked.is_none_or(|looked| other.changed >= looked))
            .filter_map(|other| other.outcome.as_ref())
            .filter(|outcome| outcome.is_certified())
            .map(|outcome| {
                if outcome.problem.mesh == mesh {
                    outcome.start()
                } else {
                    Start::cold(on_mesh(&outcome.problem, &outcome.x, mesh))
                }
            })
            .collect()
    }
}

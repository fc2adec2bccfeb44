//! A book of strides: named problems with the best stride found for each, improved from each other.
//!
//! A problem is solved from the strides of other problems, the nearest by name first; the cheapest certified stride stays, and
//! how many starts ended in it is counted. A start is the stride of another problem: it is tried once, and again only
//! when that problem has found a better stride. The book is complete when nothing is left to try.

use super::Problem;
use super::catalogue::{Kind, Name};
use super::chain::{Case, Outcome, solve_all};
use super::refine::on_mesh;
use trajectory::{Options, ProgrammeError, Start};

/// Costs closer than this, relative, are those of one stride.
const SAME_COST: f64 = 1e-6;
/// Shortest part of a way between two contacts that is tried in one step.
const SHORTEST_PART: f64 = 1.0 / 16.0;

/// A start that a problem was solved from: whose stride it was, and its cost.
pub type Source = (Name, f64);

/// A named problem and what is known about it.
#[derive(Clone, Debug)]
pub struct Entry {
    /// The name.
    pub name: Name,
    /// The problem.
    pub problem: Problem,
    /// The best stride so far.
    pub outcome: Option<Outcome>,
    /// Starts that it was solved from; a start that is no stride of the book stands under its own name.
    pub tried: Vec<Source>,
}

impl Entry {
    /// Whether its best stride carries a certificate.
    pub fn is_certified(&self) -> bool {
        self.outcome.as_ref().is_some_and(Outcome::is_certified)
    }

    fn has_tried(&self, (name, cost): Source) -> bool {
        let same = |known: f64| (known - cost).abs() <= SAME_COST * cost.abs();
        self.tried
            .iter()
            .any(|&(known, at)| known == name && same(at))
    }

    /// Where no list of starts was kept, nothing tells whether a start was counted before: the count begins from nothing.
    fn count_from_list(&mut self) {
        if self.tried.is_empty()
            && let Some(outcome) = &mut self.outcome
        {
            (outcome.found_by, outcome.tried) = (0, 0);
        }
    }

    /// Merges a find; whether it is better than what stood here.
    fn take(&mut self, found: Outcome) -> bool {
        let (better, merged) = match self.outcome.take() {
            Some(before) => {
                let (status, cost) = (before.status, before.cost);
                let merged = before.merged(found);
                (merged.status != status || merged.cost != cost, merged)
            }
            None => (true, found),
        };
        self.outcome = Some(merged);
        better
    }
}

/// What a look at the other strides brought.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Looked {
    /// Starts tried.
    pub tried: usize,
    /// Whether the problem has a better stride now, or its first.
    pub better: bool,
}

/// The book.
#[derive(Clone, Debug, Default)]
pub struct Book {
    /// Its entries, in the order in which they were added.
    pub entries: Vec<Entry>,
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
        for ((name, problem, starts), outcome) in named.into_iter().zip(outcomes) {
            let source = outcome.as_ref().map(|o| (name, o.cost));
            self.entries.push(Entry {
                name,
                problem,
                outcome,
                tried: source.into_iter().cycle().take(starts.len()).collect(),
            });
        }
        Ok(())
    }

    /// Solves the problem at `place` from the nearest strides that are new to it: at most `most`, at most `reach` steps
    /// of the names away.
    ///
    /// # Errors
    /// As [`Book::add`].
    pub fn look(
        &mut self,
        place: usize,
        reach: usize,
        most: usize,
        options: &Options,
    ) -> Result<Looked, ProgrammeError> {
        let (sources, starts): (Vec<Source>, Vec<Start>) =
            self.starts(place, reach).into_iter().take(most).unzip();
        if starts.is_empty() {
            return Ok(Looked::default());
        }
        let tried = starts.len();
        let problem = self.entries[place].problem;
        let found = solve_all(&[Case { problem, starts }], options)?
            .pop()
            .flatten();
        let entry = &mut self.entries[place];
        entry.count_from_list();
        entry.tried.extend(sources);
        let better = found.is_some_and(|outcome| entry.take(outcome));
        Ok(Looked { tried, better })
    }

    /// Solves the problem at `place` from a start that is no stride of this book; it counts as one start.
    ///
    /// # Errors
    /// As [`Book::add`].
    pub fn offer(
        &mut self,
        place: usize,
        start: Start,
        options: &Options,
    ) -> Result<Looked, ProgrammeError> {
        let problem = self.entries[place].problem;
        let case = Case {
            problem,
            starts: vec![start],
        };
        let found = solve_all(&[case], options)?.pop().flatten();
        let entry = &mut self.entries[place];
        let Some(outcome) = found else {
            return Ok(Looked::default());
        };
        entry.count_from_list();
        entry.tried.push((entry.name, outcome.cost));
        let better = entry.take(outcome);
        Ok(Looked { tried: 1, better })
    }

    /// Walks to the contact of the problem at `place` from the nearest certified stride of another stiffness or loss, in
    /// parts of the way that are halved where one ends without a certificate. For problems that one whole step does not reach.
    ///
    /// # Errors
    /// As [`Book::add`].
    pub fn walk(&mut self, place: usize, options: &Options) -> Result<Looked, ProgrammeError> {
        let name = self.entries[place].name;
        let beside = |e: &&Entry| {
            let alike = Name {
                k: e.name.k,
                c: e.name.c,
                ..name
            };
            name.kind == Kind::Compliant && e.name == alike && e.name.is_beside(&name)
        };
        let mut looked = Looked::default();
        let from: Vec<(Name, Problem, Start)> = self
            .entries
            .iter()
            .filter(beside)
            .filter(|e| e.is_certified())
            .filter_map(|e| Some((e.name, e.problem, e.outcome.as_ref()?.start())))
            .collect();
        for (other, problem, mut start) in from {
            let (mut way, mut part) = (0.0, 0.5);
            while part >= SHORTEST_PART {
                let to = if way + part >= 1.0 {
                    self.entries[place].problem
                } else {
                    let ground = name.between(&other, 1.0 - way - part);
                    Problem {
                        contact: ground.contact(),
                        ..problem
                    }
                };
                let case = Case {
                    problem: to,
                    starts: vec![start.clone()],
                };
                looked.tried += 1;
                let found = solve_all(&[case], options)?.pop().flatten();
                let Some(found) = found.filter(Outcome::is_certified) else {
                    part /= 2.0;
                    continue;
                };
                way += part;
                if way >= 1.0 {
                    looked.better |= self.entries[place].take(found);
                    break;
                }
                start = found.start();
                part = (2.0 * part).min(1.0 - way);
            }
        }
        Ok(looked)
    }

    /// The certified strides within `reach` of an entry that it has not started from yet, the nearest first.
    fn starts(&self, place: usize, reach: usize) -> Vec<(Source, Start)> {
        let entry = &self.entries[place];
        let mesh = entry.problem.mesh;
        let mut near: Vec<(usize, Source, &Outcome)> = self
            .entries
            .iter()
            .filter(|other| other.name != entry.name && other.is_certified())
            .filter_map(|other| {
                let outcome = other.outcome.as_ref()?;
                let steps = other.name.steps_apart(&entry.name)?;
                Some((steps, (other.name, outcome.cost), outcome))
            })
            .filter(|&(steps, source, _)| steps <= reach && !entry.has_tried(source))
            .collect();
        near.sort_by_key(|&(steps, ..)| steps);
        near.into_iter()
            .map(|(_, source, outcome)| {
                let start = if outcome.problem.mesh == mesh {
                    outcome.start()
                } else {
                    Start::cold(on_mesh(&outcome.problem, &outcome.x, mesh))
                };
                (source, start)
            })
            .collect()
    }
}

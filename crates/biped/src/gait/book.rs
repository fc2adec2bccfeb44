//! A book of strides: named problems with the best stride found for each, improved from each other.
//!
//! A problem is solved from the strides of other problems, the nearest by name first; the best certified stride stays
//! ([`Outcome::merged`]), and how many starts ended in it is counted. A start is the stride of another problem, followed to this one in parts of the way: it is
//! tried once, and again only when that problem has found a better stride. One that came from the stride to be found may lead on, but proves nothing.
//! The book is complete when nothing is left to try.

use super::catalogue::{Choice, Kind, Name};
use super::chain::{Case, Outcome, solve_all};
use super::passage::{Pace, Passage, pass};
use super::programme::Stride;
use super::refine::on_mesh;
use super::{Mesh, Problem};
use rayon::prelude::*;
use trajectory::{Options, ProgrammeError, Start, Status, scaled_distance};

/// Costs closer than this, relative, are those of one stride.
const SAME_COST: f64 = 1e-6;
/// Other strides of a problem that are kept to hop from, the cheapest.
const OTHERS: usize = 6;
/// How the stride of another problem is followed to this one. In four parts it keeps to its branch: of 54 ways along the sweep and from other choices 52 arrived at a
/// certificate and 18 in the best stride, at 3.4 s of processor time; of 617 starts taken in one step 340 and 72 did.
const FOLLOWING: Pace = Pace {
    first: 0.25,
    shortest: 1.0 / 16.0,
    hops: 0,
};
/// How a way between two contacts is gone where following does not get there.
const SEARCHING: Pace = Pace {
    first: 0.125,
    shortest: 1.0 / 64.0,
    hops: 5,
};

/// A start that a problem was solved from: whose stride it was, and its cost.
pub type Source = (Name, f64);

/// Where a start came from.
#[derive(Clone, Copy, Debug)]
pub(super) struct Origin {
    pub(super) source: Source,
    /// Whether it counts if it leads to the stride that stands.
    pub(super) proof: bool,
    /// Whether the start is the stride itself: no hop from it.
    pub(super) direct: bool,
}

/// A named problem and what is known about it.
#[derive(Clone, Debug)]
pub struct Entry {
    /// The name.
    pub name: Name,
    /// The problem.
    pub problem: Problem,
    /// The best stride so far.
    pub outcome: Option<Outcome>,
    /// Other certified strides of it, the cheapest first.
    pub others: Vec<Outcome>,
    /// Starts that it was solved from; a start that is no stride of the book stands under its own name.
    pub tried: Vec<Source>,
    /// Hops by which it was solved ([`super::hopping`]); with the starts tried they are all that are counted.
    pub hops: usize,
    /// Starts tried before the best stride came.
    pub before: usize,
    /// The start that led to the best stride, if it is known.
    pub from: Option<Source>,
}

/// Whether two strides are one: the same problem up to a choice that does not bind, and the same cost. A stance below both of two
/// limits, say, is one start and not two.
fn is_same((a, a_cost): Source, (b, b_cost): Source) -> bool {
    let own = |name: Name| name.with_choice(Choice::Own);
    own(a) == own(b) && cost_alike(a_cost, b_cost)
}

fn cost_alike(a: f64, b: f64) -> bool {
    (a - b).abs() <= SAME_COST * b.abs()
}

impl Entry {
    /// Whether its best stride carries a certificate.
    pub fn is_certified(&self) -> bool {
        self.outcome.as_ref().is_some_and(Outcome::is_certified)
    }

    fn has_tried(&self, source: Source) -> bool {
        self.tried.iter().any(|&known| is_same(known, source))
    }

    /// Whether a stride is the one that stands here.
    fn is_own(&self, source: Source) -> bool {
        let own = self.outcome.as_ref().map(|o| (self.name, o.cost));
        own.is_some_and(|own| is_same(own, source))
    }

    /// Whether it is news that a stride of another problem leads here. It is not if it came from the stride that stands here, or
    /// is one of another choice, most of which were made from those of the own one: the way back proves nothing, though it may
    /// lead on to a better stride.
    pub(super) fn is_proof(&self, other: &Self) -> bool {
        let choice = other.name.choice;
        let derived = choice != Choice::Own && choice != self.name.choice;
        let back = other.from.is_some_and(|from| self.is_own(from));
        !derived && !back
    }

    /// How many starts it may still take until `wanted` have found the best stride, if they go on finding it as often as those
    /// since it came (one start more of either kind, so that the first ones do not decide). None if there are enough.
    pub fn starts_left(&self, wanted: usize) -> Option<f64> {
        let (found, tried) = self
            .outcome
            .as_ref()
            .filter(|o| o.is_certified())
            .map_or((0, self.tried.len()), |o| {
                (o.found_by, o.tried - self.before)
            });
        let missing = wanted.saturating_sub(found);
        let often = (found + 1) as f64 / (tried.max(found) + 2) as f64;
        (missing > 0).then_some(missing as f64 / often)
    }

    /// A better stride was found once, whoever led to it.
    fn first_find(&mut self) {
        if let Some(outcome) = &mut self.outcome {
            outcome.found_by = 1;
        }
    }

    /// A start that did not arrive counts as tried.
    fn lost_one(&mut self) {
        if let Some(outcome) = &mut self.outcome {
            outcome.tried += 1;
        }
    }

    /// Where neither a list of starts nor a number of hops was kept, nothing tells whether a start was counted before: the count begins
    /// from nothing.
    fn count_from_list(&mut self) {
        if self.tried.is_empty()
            && self.hops == 0
            && let Some(outcome) = &mut self.outcome
        {
            (outcome.found_by, outcome.tried, self.before) = (0, 0, 0);
        }
    }

    /// Keeps certified strides beside the best one as places to hop from.
    fn keep_others(&mut self, strides: [Outcome; 2], best: f64) {
        for stride in strides {
            let mut known = self.others.iter().map(|other| other.cost);
            let known = known.any(|cost| cost_alike(stride.cost, cost));
            if stride.is_certified() && !known {
                self.others.push(stride);
            }
        }
        self.others.retain(|other| !cost_alike(other.cost, best));
        self.others.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        self.others.truncate(OTHERS);
    }

    /// Merges what was found from each start, in their order.
    pub(super) fn take_all(&mut self, origins: Vec<Origin>, found: Vec<Option<Outcome>>) -> Looked {
        let mut looked = Looked::default();
        for (origin, found) in origins.into_iter().zip(found) {
            self.count_from_list();
            if origin.direct {
                self.tried.push(origin.source);
            } else {
                self.hops += 1;
            }
            let Some(mut found) = found else {
                self.lost_one();
                continue;
            };
            found.found_by = usize::from(origin.proof);
            let end = End::new(origin.source, &found, self.outcome.as_ref());
            looked.ends.push(end);
            if self.take(found, origin.source) {
                looked.better = true;
                self.first_find();
            }
        }
        looked
    }

    /// Merges a find and its start; whether it is better than what stood here.
    fn take(&mut self, found: Outcome, from: Source) -> bool {
        let (better, merged) = match self.outcome.take() {
            Some(before) => {
                let (status, cost) = (before.status, before.cost);
                let tried = before.tried;
                let both = [before.clone(), found.clone()];
                let merged = before.merged(found);
                let better = merged.status != status || merged.cost != cost;
                if better {
                    self.before = tried;
                }
                self.keep_others(both, merged.cost);
                (better, merged)
            }
            None => (true, found),
        };
        self.outcome = Some(merged);
        if better {
            self.from = Some(from);
        }
        better
    }
}

/// What a look at the other strides brought.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Looked {
    /// How the starts ended that were tried.
    pub ends: Vec<End>,
    /// Whether the problem has a better stride now, or its first.
    pub better: bool,
}

/// How one start ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct End {
    /// Whose stride it was.
    pub source: Source,
    /// How the solve ended.
    pub status: Status,
    /// Cost there.
    pub cost: f64,
    /// Steps.
    pub iterations: usize,
    /// Quadratic subproblems.
    pub subproblems: usize,
    /// Largest distance to the best stride until then, in scales of the variables.
    pub apart: Option<f64>,
}

impl End {
    fn new(source: Source, found: &Outcome, best: Option<&Outcome>) -> Self {
        let stride = Stride::new(found.problem);
        Self {
            source,
            status: found.status,
            cost: found.cost,
            iterations: found.iterations,
            subproblems: found.subproblems,
            apart: best.map(|best| scaled_distance(&stride, &best.x, &found.x)),
        }
    }
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
                others: Vec::new(),
                tried: source.into_iter().cycle().take(starts.len()).collect(),
                hops: 0,
                before: 0,
                from: None,
            });
        }
        Ok(())
    }

    /// Follows the nearest strides that are new to the problem at `place` to it: at most `most`, at most `reach` away
    /// ([`Name::distance`]). Ways run in parallel, what they found is merged in their order.
    ///
    /// # Errors
    /// As [`Book::add`].
    pub fn look(
        &mut self,
        place: usize,
        reach: f64,
        most: usize,
        options: &Options,
    ) -> Result<Looked, ProgrammeError> {
        let to = self.entries[place].problem;
        let near = self.near(place, reach).into_iter().take(most);
        let (origins, ways): (Vec<Origin>, Vec<(Problem, Start)>) = near
            .map(|near| {
                let origin = Origin {
                    source: near.source,
                    proof: near.proof,
                    direct: true,
                };
                let from = Problem {
                    mesh: to.mesh,
                    ..near.outcome.problem
                };
                (origin, (from, start(near.outcome, to.mesh)))
            })
            .unzip();
        let passages: Vec<Passage> = ways
            .into_par_iter()
            .map(|(from, start)| pass(&from, start, &to, FOLLOWING, options))
            .collect::<Result<_, _>>()?;
        let found = passages.into_iter().map(Passage::arrived).collect();
        Ok(self.entries[place].take_all(origins, found))
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
        let source = (entry.name, outcome.cost);
        entry.count_from_list();
        entry.tried.push(source);
        let ends = vec![End::new(source, &outcome, entry.outcome.as_ref())];
        let better = entry.take(outcome, source);
        Ok(Looked { ends, better })
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
        let from: Vec<(Source, Problem, Start)> = self
            .entries
            .iter()
            .filter(beside)
            .filter(|e| e.is_certified())
            .filter_map(|e| {
                let outcome = e.outcome.as_ref()?;
                Some(((e.name, outcome.cost), e.problem, outcome.start()))
            })
            .collect();
        let to = self.entries[place].problem;
        for (source, problem, start) in from {
            let passage = pass(&problem, start, &to, SEARCHING, options)?;
            let solves = passage.solves.iter();
            looked
                .ends
                .extend(solves.map(|(_, found)| End::new(source, found, None)));
            if let Some(found) = passage.end() {
                looked.better |= self.entries[place].take(found, source);
            }
        }
        Ok(looked)
    }

    /// Distance of the nearest stride that is new to the problem at `place`.
    pub fn nearest(&self, place: usize) -> Option<f64> {
        self.near(place, f64::INFINITY).first().map(|n| n.distance)
    }

    /// The certified strides within `reach` of an entry that it has not started from yet, the nearest first.
    fn near(&self, place: usize, reach: f64) -> Vec<Near<'_>> {
        let entry = &self.entries[place];
        let mut near: Vec<Near<'_>> = self
            .entries
            .iter()
            .filter(|other| other.name != entry.name && other.is_certified())
            .filter_map(|other| {
                let outcome = other.outcome.as_ref()?;
                let distance = other.name.distance(&entry.name)?;
                let source = (other.name, outcome.cost);
                let old = distance > reach || entry.is_own(source) || entry.has_tried(source);
                (!old).then(|| Near {
                    distance,
                    source,
                    outcome,
                    proof: entry.is_proof(other),
                })
            })
            .collect();
        near.sort_by(|a, b| a.distance.total_cmp(&b.distance));
        near
    }
}

/// The stride of another problem, as a start.
struct Near<'a> {
    distance: f64,
    source: Source,
    outcome: &'a Outcome,
    /// Whether it counts if it leads to the stride that stands here.
    proof: bool,
}

/// A stride as a start on a mesh.
pub(super) fn start(outcome: &Outcome, mesh: Mesh) -> Start {
    if outcome.problem.mesh == mesh {
        outcome.start()
    } else {
        Start::cold(on_mesh(&outcome.problem, &outcome.x, mesh))
    }
}

//! Basin hopping: new starts where the strides of other problems are used up.
//!
//! A stride is carried off its place by a few steps towards the stride of a problem that lies beside its own and is drawn at random:
//! another ground, another brush, another weight on speed, another gravity. From where that ends, two to thirty scales of
//! the variables away, the wanted problem is solved. Noise on the variables would leave every equation of motion; steps towards
//! another stride end where motion is nearly possible. (Iterated local search: Lourenço, Martin and Stützle 2003; basin
//! hopping: Wales and Doye 1997.)

use super::book::{Book, Entry, Looked, Origin, start};
use super::chain::{Case, Outcome, solve_all};
use super::{Contact, Goal, Problem};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use trajectory::{Options, ProgrammeError, Start};

/// Largest change of stiffness and loss, as the logarithm of a ratio,
const GROUND: f64 = 0.35;
/// of the weight on speed,
const WEIGHT: f64 = 1.0;
/// of gravity and of both coefficients of friction.
const FORCES: f64 = 0.15;
/// Largest shift of a hip's limit, rad.
const HIP_RAD: f64 = 0.05;
/// Steps and quadratic subproblems on the problem beside: a certificate is not needed there.
const STEPS: usize = 15;
const SUBPROBLEMS: usize = 8;

impl Problem {
    /// A problem beside this one, drawn at random. The same seed draws the same problem.
    #[must_use]
    pub fn beside(&self, seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut draw = |most: f64| rng.random_range(-most..=most);
        let mut other = *self;
        if let Contact::Compliant(ground) = &mut other.contact {
            ground.stiffness_n_m15 *= draw(GROUND).exp();
            ground.loss_s_m *= draw(GROUND).exp();
        }
        if let Goal::Speed { weight, .. } = &mut other.goal {
            *weight *= draw(WEIGHT).exp();
        }
        other.biped.gravity_m_s2 *= draw(FORCES).exp();
        other.brush.forward *= draw(FORCES).exp();
        other.brush.reverse *= draw(FORCES).exp();
        other.limits.hip_rad = other.limits.hip_rad.map(|limit| limit + draw(HIP_RAD));
        other
    }
}

impl Book {
    /// Solves the problem at `place` by hops (see the module): of four one from its own best stride, two from dearer ones of its own
    /// and one from a stride of another problem within `reach`. The first may lead on but does not count.
    ///
    /// # Errors
    /// As [`Book::add`].
    pub fn hop(
        &mut self,
        place: usize,
        reach: f64,
        most: usize,
        options: &Options,
    ) -> Result<Looked, ProgrammeError> {
        let entry = &self.entries[place];
        let tried = entry.outcome.as_ref().map_or(0, |o| o.tried);
        let seeds = (tried..).map(|turn| (place as u64) << 32 | turn as u64);
        let (origins, hops): (Vec<Origin>, Vec<Hop>) = seeds
            .take(most)
            .filter_map(|seed| {
                let (origin, start) = self.footing(place, reach, seed)?;
                Some((origin, Hop { start, seed }))
            })
            .unzip();
        let found = hop_all(&entry.problem, hops, options)?;
        Ok(self.entries[place].take_all(origins, found))
    }

    /// Whether there is a stride to hop from.
    pub fn can_hop(&self, place: usize, reach: f64) -> bool {
        self.footing(place, reach, 0).is_some()
    }

    /// The stride that a hop starts from. Which one it is the seed decides.
    fn footing(&self, place: usize, reach: f64, seed: u64) -> Option<(Origin, Start)> {
        let entry = &self.entries[place];
        let turn = seed % 4;
        let pick = |count: usize| (seed / 4 + turn) as usize % count;
        let origin = |source, proof| Origin {
            source,
            proof,
            direct: false,
        };
        let own = |stride: &Outcome, proof| {
            let source = (entry.name, stride.cost);
            (origin(source, proof), stride.start())
        };
        let best = entry.outcome.as_ref().filter(|o| o.is_certified());
        if let (0, Some(best)) = (turn, best) {
            return Some(own(best, false));
        }
        if turn < 3 && !entry.others.is_empty() {
            return Some(own(&entry.others[pick(entry.others.len())], true));
        }
        let within = |other: &&Entry| {
            let distance = other.name.distance(&entry.name);
            other.name != entry.name && other.is_certified() && distance.is_some_and(|d| d <= reach)
        };
        let near: Vec<&Entry> = self.entries.iter().filter(within).collect();
        let other = near.get(pick(near.len().max(1)))?;
        let stride = other.outcome.as_ref()?;
        let source = (other.name, stride.cost);
        let origin = origin(source, entry.is_proof(other));
        Some((origin, start(stride, entry.problem.mesh)))
    }
}

/// A stride, on the mesh of the problem, to hop from, and the seed of its hop.
#[derive(Clone, Debug)]
struct Hop {
    start: Start,
    seed: u64,
}

/// Solves a problem by hops from one stride.
pub(super) fn hops_from(
    problem: &Problem,
    start: &Start,
    seeds: std::ops::Range<u64>,
    options: &Options,
) -> Result<Vec<Option<Outcome>>, ProgrammeError> {
    let hop = |seed| Hop {
        start: start.clone(),
        seed,
    };
    hop_all(problem, seeds.map(hop).collect(), options)
}

/// Solves a problem from hops, each in two solves: on a problem beside it, then on itself. Hops run in parallel, ends stand in
/// the order of the hops.
fn hop_all(
    problem: &Problem,
    hops: Vec<Hop>,
    options: &Options,
) -> Result<Vec<Option<Outcome>>, ProgrammeError> {
    let away = Options {
        max_iterations: STEPS,
        max_subproblems: SUBPROBLEMS,
        ..options.clone()
    };
    let beside: Vec<Case> = hops
        .into_iter()
        .map(|hop| Case {
            problem: problem.beside(hop.seed),
            starts: vec![hop.start],
        })
        .collect();
    let landed = solve_all(&beside, &away)?;
    let back: Vec<Case> = landed
        .iter()
        .map(|end| Case {
            problem: *problem,
            starts: end.iter().map(Outcome::start).collect(),
        })
        .collect();
    let mut ends = solve_all(&back, options)?;
    for (end, landed) in ends.iter_mut().zip(landed) {
        if let (Some(end), Some(landed)) = (end, landed) {
            end.iterations += landed.iterations;
            end.subproblems += landed.subproblems;
        }
    }
    Ok(ends)
}

//! Forward selection: one cause after the other is taken in beside the law, and all are asked again beside it.

use std::sync::Arc;

use crate::bench::Bench;
use crate::forms::{plainest, refine_last};
use crate::general::Lack;
use crate::joint::is_dear;
use crate::lateness::looked_up;
use crate::left::lack;
use crate::look_back::{drop_idle, exchange_with_named, look_back};
use crate::proposal::{Next, Proposal, Seen, cannot_matter};
use crate::refusal::take_back;
use crate::scan::{Scan, scan, scan_knowing};
use crate::selection::{Depth, MOST_EFFECTS, SHAPE_TOLERANCE, Selected, Single, Warm, strict};
use crate::settled::{likely_scatter, settle};
use crate::signatures::Signatures;
use crate::stand::Stand;
use crate::subset::Subset;
use crate::swallowed::swallowed;
use crate::uniform::share_without_blows;
use crate::valleys::deepest;

/// Probability of noise below which a fold takes in a cause, as many of them as the whole campaign has named. That there is something the
/// whole campaign has said; a fold has fewer runs, and asks what among the catalogue it is.
const ALPHA_FOLD: f64 = 0.05;
/// Deviance below which a cause does nothing.
const IDLE: f64 = 8.0;

/// The selection from a law alone and what is seen beside it. Where that law turns out to lie in a valley of its own, all begins again
/// beside the better one, once.
pub(crate) fn select_beside(
    bench: &Bench<'_>,
    subset: Subset,
    ground: (Stand, Scan),
    depth: Depth,
    warm: Option<&Warm>,
) -> Option<Selected> {
    let mut forward = Forward::new(bench, subset, ground, depth, warm);
    let mut round = 0;
    while round < MOST_EFFECTS {
        match forward.round(round)? {
            Went::On => round += 1,
            Went::NoFurther => break,
            Went::Back(law) => {
                let found = scan(bench, &forward.subset, &law, likely_scatter(&law));
                forward = Forward {
                    once: false,
                    ..Forward::new(bench, forward.subset, (*law, found), depth, warm)
                };
                round = 0;
            }
        }
    }
    forward.finish()
}

/// How a round went.
enum Went {
    /// A cause was taken in.
    On,
    /// Nothing further is seen.
    NoFurther,
    /// The cause has only led the law out of a valley: this law does as well without.
    Back(Box<Stand>),
}

/// How far a selection has come.
struct Forward<'a, 'b> {
    bench: &'a Bench<'b>,
    depth: Depth,
    warm: Option<&'a Warm>,
    subset: Subset,
    /// The law alone, what is seen beside it, and what else is left there.
    base: Stand,
    first: Scan,
    general: Lack,
    /// What was taken in.
    chosen: Option<Stand>,
    entry: Vec<f64>,
    singles: Vec<Single>,
    /// Signatures beside it, as they were asked last.
    beside: Option<Arc<Signatures>>,
    /// Deviance that it explains.
    explained: f64,
    /// Whether the law may still turn out to lie in a valley of its own.
    once: bool,
}

impl<'a, 'b> Forward<'a, 'b> {
    fn new(
        bench: &'a Bench<'b>,
        subset: Subset,
        (base, first): (Stand, Scan),
        depth: Depth,
        warm: Option<&'a Warm>,
    ) -> Self {
        let general = left_beside(bench, &subset, &base, depth);
        Self {
            bench,
            depth,
            warm,
            subset,
            base,
            first,
            general,
            chosen: None,
            entry: Vec::new(),
            singles: Vec::new(),
            beside: None,
            explained: 0.0,
            once: true,
        }
    }

    /// Where the whole campaign has ended, inside a fold of it.
    fn whole_campaign(&self) -> Option<&'a Warm> {
        self.warm.filter(|_| self.depth == Depth::Fold)
    }

    /// The tail probability at which a round takes a cause in. What is plain comes in as in the whole campaign; a fold goes on to what is not.
    fn admitted(&self, round: usize) -> f64 {
        let expected = self.whole_campaign().map_or(0, |warm| warm.causes.len());
        if round < expected {
            ALPHA_FOLD.ln()
        } else {
            strict(&self.first)
        }
    }

    /// What is seen beside the causes that were taken in; dear ones that scored little beside the law alone are not asked again.
    fn seen_beside(&self, stand: &Stand) -> Scan {
        let mut dull: Vec<usize> = (self.first.dull())
            .filter(|&cause| is_dear(self.bench, cause))
            .collect();
        if let Some(whole) = self.whole_campaign() {
            dull.extend_from_slice(&whole.dull);
        }
        let (bench, scatter) = (self.bench, likely_scatter(stand));
        let known = (self.whole_campaign()).map_or(&[][..], |whole| &whole.signatures);
        scan_knowing(bench, &self.subset, stand, scatter, &dull, known)
    }

    /// What a round may take in, and the tail probability below which causes were asked; `None` where nothing further is seen.
    fn propose(&self, round: usize, stand: &Stand, found: &Scan) -> Option<(Proposal, f64)> {
        let top = found.candidates.first()?;
        let idle = cannot_matter(round, found, self.explained);
        let (bench, subset) = (self.bench, &self.subset);
        let (admitted, strict) = (self.admitted(round), strict(&self.first));
        // The first round asks all that come near; later ones must pass on their own.
        let threshold = if top.log_p > strict { admitted } else { strict };
        let hidden = || swallowed(bench, subset, stand, found, self.warm).map(Proposal::from);
        let proposal = if top.log_p > admitted || idle {
            hidden()
        } else {
            let seen = Seen {
                bench,
                subset,
                stand,
                found,
                warm: self.warm,
            };
            let seen = seen.proposal(threshold, self.depth);
            // What a fold hardly sees the plate may have taken up but for that.
            let doubtful = self.whole_campaign().is_some() && top.log_p > strict;
            let plainer =
                |hidden: &Proposal| seen.as_ref().is_none_or(|seen| hidden.log_p < seen.log_p);
            doubtful.then(hidden).flatten().filter(plainer).or(seen)
        }?;
        let passes = round == 0 || proposal.log_p <= admitted;
        let beyond_shape = round == 0 || proposal.drop > SHAPE_TOLERANCE.powi(2) * self.explained;
        (passes && beyond_shape && proposal.drop > IDLE).then_some((proposal, threshold))
    }

    /// One round; `None` where a model cannot be computed.
    fn round(&mut self, round: usize) -> Option<Went> {
        let later = self.chosen.as_ref().map(|stand| self.seen_beside(stand));
        self.beside = later.as_ref().and_then(|later| later.signatures.clone());
        let (stand, found) = match (&self.chosen, &later) {
            (Some(stand), Some(later)) => (stand, later),
            _ => (&self.base, &self.first),
        };
        let Some((proposal, threshold)) = self.propose(round, stand, found) else {
            return Some(Went::NoFurther);
        };
        let (bench, subset) = (self.bench, &self.subset);
        let next = match proposal.next {
            Next::Fit(fit) if round == 0 && self.depth == Depth::Full => {
                deepest(bench, subset, settle(bench, subset, &fit, found)?)?
            }
            Next::Fit(fit) => settle(bench, subset, &fit, &found.beneath(&fit, self.warm))?,
            Next::Settled(stand) => *stand,
        };
        if self.once
            && let Some(law) = law_without(bench, subset, &next, &self.base)
        {
            return Some(Went::Back(Box::new(law)));
        }
        let last = next.fitted.effects.len() - 1;
        let firm = share_without_blows(bench, subset, &next, last);
        if round == 0 {
            self.singles = proposal.tried;
        }
        if proposal.log_p * firm > self.admitted(round) {
            return Some(Went::NoFurther);
        }
        self.explained += proposal.drop;
        self.entry.push(proposal.log_p);
        self.take_in(round, next, threshold)?;
        self.tell_what_is_in();
        Some(Went::On)
    }

    fn tell_what_is_in(&self) {
        if let (Depth::Full, Some(stand)) = (self.depth, &self.chosen) {
            let bench = self.bench;
            bench.tell(|| format!("beside the law: {}", stand.fitted.ids(bench).join(", ")));
        }
    }

    /// Takes a cause in: lateness, the look back, its refined form.
    fn take_in(&mut self, round: usize, next: Stand, threshold: f64) -> Option<()> {
        let bench = self.bench;
        let (mut next, _) = looked_up(bench, &mut self.subset, next, self.depth)?;
        let last = next.fitted.effects.len() - 1;
        if round > 0 || bench.catalogue[next.fitted.effects[last]].is_periodic() {
            next = self.look_back(round, next, threshold)?;
        }
        let worth = -2.0 * strict(&self.first);
        self.chosen = Some(refine_last(bench, &self.subset, next, worth)?);
        Some(())
    }

    fn look_back(&mut self, round: usize, next: Stand, threshold: f64) -> Option<Stand> {
        let (bench, depth) = (self.bench, self.depth);
        let before = next.deviance;
        let (singles, entry) = (&self.singles, &mut self.entry);
        let mut next = look_back(bench, &self.subset, next, singles, entry, threshold, depth)?;
        // Beside a period that was found anew the law may lie in another valley.
        if round == 0 && depth == Depth::Full && next.deviance < before - IDLE {
            next = deepest(bench, &self.subset, next)?;
        }
        let (next, moved) = looked_up(bench, &mut self.subset, next, depth)?;
        if moved {
            return drop_idle(bench, &self.subset, next, &mut self.entry, -2.0 * threshold);
        }
        Some(next)
    }

    /// The set in its plainest form, what is left beside it, and whether its names may stay.
    fn finish(self) -> Option<Selected> {
        let (bench, subset) = (self.bench, &self.subset);
        let gate_log_p = self.gate_log_p();
        let known = self.warm.map_or(&[][..], |warm| &warm.causes);
        let chosen = match (self.chosen, self.depth) {
            (None, _) => None,
            (Some(stand), Depth::Full) => Some(plainest(bench, subset, stand)?),
            (Some(stand), Depth::Fold) if self.warm.is_some() => {
                Some(exchange_with_named(bench, subset, stand, known)?)
            }
            (Some(stand), Depth::Fold) => Some(stand),
        };
        let law = |sizes| Stand::new(bench, subset, self.base.fitted.clone(), sizes);
        let (baseline, stand, left) = match chosen {
            None => {
                let stand = law(self.base.sizes);
                (self.base, stand, self.general)
            }
            Some(stand) => {
                let left = left_beside(bench, subset, &stand, self.depth);
                (law(stand.sizes), stand, left)
            }
        };
        let mut selected = Selected {
            baseline,
            stand,
            first: self.first,
            beside: self.beside,
            gate_log_p,
            left,
            entry_log_p: self.entry,
            singles: self.singles,
            subset: self.subset,
            refused: Vec::new(),
        };
        // Whether names may stay is asked of the whole campaign.
        if self.depth == Depth::Full {
            take_back(bench, &mut selected);
        }
        Some(selected)
    }

    /// The tail probability of the campaign being noise, causes and general alternative together. A cause that the noise of the law alone
    /// had taken up is seen only as it comes in.
    fn gate_log_p(&self) -> f64 {
        let seen = self.first.candidates.first().map(|c| c.log_p);
        let best = (self.entry.iter().copied().chain(seen)).fold(0.0, f64::min);
        (best + (self.first.asked.max(1) as f64 / 0.5).ln())
            .min(self.general.log_p + 2.0_f64.ln())
            .min(0.0)
    }
}

/// What else is left beside a stand. Nobody asks a fold whether there is anything at all.
fn left_beside(bench: &Bench<'_>, subset: &Subset, stand: &Stand, depth: Depth) -> Lack {
    match depth {
        Depth::Full => lack(bench, subset, stand),
        Depth::Fold => Lack::nothing(),
    }
}

/// The law that a first cause has left behind, where that law alone does as well as both and better than the law alone did: the cause
/// has only led the law out of a valley.
fn law_without(bench: &Bench<'_>, subset: &Subset, single: &Stand, base: &Stand) -> Option<Stand> {
    if single.fitted.effects.len() != 1 {
        return None;
    }
    let whitener = single.likely_noise();
    let law = single.fitted.without(0);
    let fit = bench.fit(subset, &[], &law, &whitener, None, 20)?;
    if single.deviance_of(bench, subset, &fit) - single.deviance > IDLE {
        return None;
    }
    let found = Scan::empty(bench, Some(single.sizes));
    settle(bench, subset, &fit, &found).filter(|law| law.deviance < base.deviance - IDLE)
}

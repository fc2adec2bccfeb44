//! From the law alone to the set of causes that the campaign supports.
//!
//! 1. Noise and gate with the law alone.
//! 2. The causes that score best are fitted jointly with the law, from several starts.
//! 3. The best is taken in, the noise estimated anew, and everything asked again beside it: forward selection.
//! 4. Before a second cause stays, every other cause is asked to do better alone than the pair (the near miss), and
//!    each cause of the set to do without, or to be replaced.

use std::sync::Arc;

use fitting::noise::Sizes;

use crate::bench::{Bench, Fitted};
use crate::forward::select_beside;
use crate::general::Lack;
use crate::lateness::Lateness;
use crate::scan::{Scan, scan_knowing};
use crate::settled::{law_alone, likely_scatter};
use crate::signatures::Signatures;
use crate::stand::Stand;
use crate::subset::Subset;

/// Family-wise probability of naming a cause where there is none: half of the campaign's one percent.
pub(crate) const ALPHA_NAME: f64 = 0.004;
/// The same for the general alternative.
pub(crate) const ALPHA_GENERAL: f64 = 0.004;
/// Where this many causes together are needed, none is named: one cause outside the catalogue is likelier than so many in it.
pub(crate) const MOST_EFFECTS: usize = 4;
/// A catalogue's shape is taken to be right to this share of an effect's amplitude: less than its square of what is
/// explained may be the wrong shape of a named cause, and is no ground for naming another.
pub(crate) const SHAPE_TOLERANCE: f64 = 0.15;
/// How thorough a selection is.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Depth {
    /// The campaign itself.
    Full,
    /// Inside a fold: the same steps, starting from the campaign's noise and law.
    Fold,
}

/// A single cause with the law, fitted in the first round.
#[derive(Clone)]
pub(crate) struct Single {
    pub(crate) cause: usize,
    pub(crate) fitted: Fitted,
}

/// The outcome of a selection.
pub(crate) struct Selected {
    /// The law alone under the final noise.
    pub(crate) baseline: Stand,
    /// The law with the named causes.
    pub(crate) stand: Stand,
    /// Scan beside the law alone.
    pub(crate) first: Scan,
    /// Signatures beside the causes that were taken in, as they were asked last.
    pub(crate) beside: Option<Arc<Signatures>>,
    /// Tail probability of the campaign being noise, causes and general alternative together.
    pub(crate) gate_log_p: f64,
    /// What is left beside the final model.
    pub(crate) left: Lack,
    /// Tail probability at which each named cause came in.
    pub(crate) entry_log_p: Vec<f64>,
    /// Joint fits with one cause.
    pub(crate) singles: Vec<Single>,
    /// The runs that were looked at, as late as they tell of the plate.
    pub(crate) subset: Subset,
    /// What was found and taken back, and why, in words.
    pub(crate) refused: Vec<String>,
}

/// What a selection starts from.
#[derive(Clone, Copy)]
pub(crate) enum Start<'a> {
    /// Nothing is known.
    Scratch,
    /// The law alone was fitted before, under the noise that is assumed at first.
    Law(&'a Fitted),
    /// Another selection on nearly the same data.
    Near(&'a Warm),
}

impl<'a> Start<'a> {
    pub(crate) fn warm(self) -> Option<&'a Warm> {
        match self {
            Self::Near(warm) => Some(warm),
            Self::Scratch | Self::Law(_) => None,
        }
    }
}

/// Where another selection has ended.
#[derive(Clone)]
pub(crate) struct Warm {
    pub(crate) law: Vec<f64>,
    /// The noise beneath the law alone, and beneath the law with the named causes.
    pub(crate) law_sizes: Sizes,
    pub(crate) sizes: Sizes,
    /// The law's parameters beside the named causes.
    pub(crate) extended_law: Vec<f64>,
    /// The named causes and their parameters.
    pub(crate) causes: Vec<(usize, Vec<f64>)>,
    /// Causes that were not named and scored next to nothing beside the law alone: a fold does not ask them again.
    pub(crate) dull: Vec<usize>,
    /// How many causes were asked.
    pub(crate) asked: usize,
    /// How late samples tell of the plate.
    pub(crate) late: Lateness,
    /// Whether the plate turns.
    pub(crate) turns: bool,
    /// Signatures beside the law alone, and beside the named causes.
    pub(crate) signatures: Vec<Arc<Signatures>>,
}

impl Warm {
    /// The noise beneath a fit with just the named causes.
    pub(crate) fn sizes_beneath(&self, fit: &Fitted) -> Option<Sizes> {
        let named = |effect: &usize| self.causes.iter().any(|(cause, _)| cause == effect);
        let same = fit.effects.len() == self.causes.len() && fit.effects.iter().all(named);
        same.then_some(self.sizes)
    }
}

impl Selected {
    /// Whether no cause is named.
    pub(crate) fn names_nothing(&self) -> bool {
        self.stand.fitted.effects.is_empty()
    }

    /// Whether something is left that nothing explains.
    pub(crate) fn leaves_something(&self) -> bool {
        self.left.log_p < ALPHA_GENERAL.ln()
    }

    /// -2 log likelihood with each name paid for.
    pub(crate) fn worth(&self) -> f64 {
        let names = self.stand.fitted.effects.len() as f64;
        self.stand.deviance - 2.0 * strict(&self.first) * names
    }

    /// Tail probability of the plainest of the named causes; 0 (its logarithm) without any.
    pub(crate) fn seen(&self) -> f64 {
        self.entry_log_p.iter().copied().fold(0.0, f64::min)
    }

    /// Whether one of these causes is in the set and was seen as plainly as what a whole campaign names.
    pub(crate) fn is_plain(&self, causes: &[usize]) -> bool {
        let mut effects = self.stand.fitted.effects.iter().zip(&self.entry_log_p);
        effects.any(|(effect, log_p)| causes.contains(effect) && *log_p < strict(&self.first))
    }

    /// Where another selection on nearly the same data may start.
    pub(crate) fn warm(&self) -> Warm {
        let extended = &self.stand.fitted;
        let own = |k: usize| extended.parameters[extended.model.span(k)].to_vec();
        Warm {
            law: self.baseline.fitted.parameters.clone(),
            law_sizes: self.first.sizes.unwrap_or(self.stand.sizes),
            sizes: self.stand.sizes,
            extended_law: extended.parameters[..extended.model.law_parameters()].to_vec(),
            causes: (0..extended.effects.len())
                .map(|k| (extended.effects[k], own(k)))
                .collect(),
            dull: (self.first.dull())
                .filter(|cause| !extended.effects.contains(cause))
                .collect(),
            asked: self.first.asked,
            late: self.subset.lateness(),
            turns: self.subset.turns(),
            signatures: (self.first.signatures.iter().chain(&self.beside))
                .map(Arc::clone)
                .collect(),
        }
    }
}

/// The tail probability below which a cause is named, of all that were asked.
pub(crate) fn strict(first: &Scan) -> f64 {
    (ALPHA_NAME / first.asked.max(1) as f64).ln()
}

/// Law alone, its noise, and what is seen beside it.
fn baseline(
    bench: &Bench<'_>,
    subset: &Subset,
    depth: Depth,
    start: Start<'_>,
) -> Option<(Stand, Scan)> {
    let stand = law_alone(bench, subset, start)?;
    let scatter = likely_scatter(&stand);
    let whole = start.warm().filter(|_| depth == Depth::Fold);
    let dull = whole.map_or(&[][..], |whole| &whole.dull);
    let known = whole.map_or(&[][..], |whole| &whole.signatures);
    let mut found = scan_knowing(bench, subset, &stand, scatter, dull, known);
    // What a fold names is named among all that the whole campaign asked.
    found.asked = found.asked.max(whole.map_or(0, |whole| whole.asked));
    Some((stand, found))
}

/// The whole selection; `None` where the law itself cannot be computed on the campaign.
pub(crate) fn select(
    bench: &Bench<'_>,
    subset: &Subset,
    depth: Depth,
    start: Start<'_>,
) -> Option<Selected> {
    let warm = start.warm();
    let mut subset = subset
        .late_by(warm.map_or(Lateness::default(), |w| w.late))
        .turning(warm.is_some_and(|w| w.turns));
    let mut ground = baseline(bench, &subset, depth, start)?;
    if depth == Depth::Full {
        bench.tell(|| format!("law {} fitted alone; asking for causes", bench.law.id()));
    }
    if warm.is_none() && subset.can_turn(bench) {
        // A disc or a plate without end: the likelier, by what the law leaves.
        let disc = subset.turning(true);
        let beside = baseline(bench, &disc, depth, Start::Scratch)?;
        if beside.0.deviance < ground.0.deviance {
            (subset, ground) = (disc, beside);
        }
    }
    select_beside(bench, subset, ground, depth, warm)
}

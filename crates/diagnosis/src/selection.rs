//! From the law alone to the set of causes that the campaign supports.
//!
//! 1. Noise and gate with the law alone.
//! 2. The causes that score best are fitted jointly with the law, from several starts.
//! 3. The best is taken in, the noise estimated anew, and everything asked again beside it: forward selection.
//! 4. Before a second cause stays, every other cause is asked to do better alone than the pair (the near miss), and
//!    each cause of the set to do without, or to be replaced.

use fitting::noise::{Search, Sizes};

use crate::afresh::{STRONG, afresh};
use crate::bench::{Bench, Fitted};
use crate::forms::{plainest, refine_last};
use crate::general::Lack;
use crate::joint::{is_dear, joint_fits, survivors};
use crate::lateness::{Lateness, looked_up};
use crate::left::lack;
use crate::look_back::{drop_idle, exchange_with_named, look_back};
use crate::refusal::take_back;
use crate::scan::{Scan, scan, scan_without, smooth_beside};
use crate::stand::{Likelihood, Stand};
use crate::steps::levelled;
use crate::subset::Subset;
use crate::swallowed::{Recovered, swallowed};
use crate::tail::log_chi2_tail;
use crate::uniform::share_without_blows;
use crate::valleys::deepest;

/// Family-wise probability of naming a cause where there is none: half of the campaign's one percent.
pub(crate) const ALPHA_NAME: f64 = 0.004;
/// The same for the general alternative.
pub(crate) const ALPHA_GENERAL: f64 = 0.004;
/// Where this many causes together are needed, none is named: one cause outside the catalogue is likelier than so many in it.
pub(crate) const MOST_EFFECTS: usize = 4;
/// Joint fits tried in each round.
pub(crate) const SURVIVORS: usize = 6;
/// A catalogue's shape is taken to be right to this share of an effect's amplitude: less than its square of what is
/// explained may be the wrong shape of a named cause, and is no ground for naming another.
pub(crate) const SHAPE_TOLERANCE: f64 = 0.15;
/// Probability of noise below which a fold takes in a cause, as many of them as the whole campaign has named. That there is something the
/// whole campaign has said; a fold has fewer runs, and asks what among the catalogue it is.
const ALPHA_FOLD: f64 = 0.05;
/// Share of the deviance promised by the best score that a search afresh must save.
const KEPT: f64 = 0.5;
/// How many times more than its score says a fit may save.
const NONLINEAR: f64 = 3.0;

/// Deviance below which a cause does nothing.
const IDLE: f64 = 8.0;

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

/// Where a selection may start from.
#[derive(Clone)]
pub(crate) struct Warm {
    pub(crate) law: Vec<f64>,
    pub(crate) sizes: Sizes,
    /// The law's parameters beside the named causes.
    pub(crate) extended_law: Vec<f64>,
    /// The named causes and their parameters.
    pub(crate) causes: Vec<(usize, Vec<f64>)>,
    /// How late samples tell of the plate.
    pub(crate) late: Lateness,
    /// Whether the plate turns.
    pub(crate) turns: bool,
}

impl Selected {
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
            sizes: self.stand.sizes,
            extended_law: extended.parameters[..extended.model.law_parameters()].to_vec(),
            causes: (0..extended.effects.len())
                .map(|k| (extended.effects[k], own(k)))
                .collect(),
            late: self.subset.lateness(),
            turns: self.subset.turns(),
        }
    }
}

/// The tail probability below which a cause is named, of all that were asked.
pub(crate) fn strict(first: &Scan) -> f64 {
    (ALPHA_NAME / first.asked.max(1) as f64).ln()
}

/// Scatter between runs that is likeliest beside the fitted model.
pub(crate) fn likely_scatter(stand: &Stand) -> f64 {
    stand.ground.likeliest_scatter()
}

/// Law alone, its noise, and what is seen beside it.
fn baseline(bench: &Bench<'_>, subset: &Subset, warm: Option<&Warm>) -> Option<(Stand, Scan)> {
    let stand = law_alone(bench, subset, warm)?;
    let found = scan(bench, subset, &stand, likely_scatter(&stand));
    Some((stand, found))
}

/// Law alone and its noise.
pub(crate) fn law_alone(bench: &Bench<'_>, subset: &Subset, warm: Option<&Warm>) -> Option<Stand> {
    let first_sizes = warm.map_or_else(|| bench.first_sizes(), |w| w.sizes);
    let fitted = match warm {
        None => bench.law_fit(subset, &first_sizes, f64::INFINITY)?,
        Some(w) => {
            let model = bench.model(&[])?;
            let mut start = model.at_null(&w.law[..model.law_parameters()], &bench.experiment);
            let shared = start.len().min(w.law.len());
            start[..shared].copy_from_slice(&w.law[..shared]);
            let scale = model.friction(&bench.experiment, &start);
            let context = subset.context(bench, &scale);
            let whitener = fitting::noise::Whitener::new(&context, &first_sizes);
            bench.fit(subset, &[], &start, &whitener, None, 20)?
        }
    };
    under_its_noise(bench, subset, fitted, first_sizes, warm.is_some())
}

/// A fit, the noise beneath it, and the fit under that noise. `known`: whether the first sizes are those of a noise and not only
/// something to begin with.
pub(crate) fn under_its_noise(
    bench: &Bench<'_>,
    subset: &Subset,
    fitted: Fitted,
    first_sizes: Sizes,
    known: bool,
) -> Option<Stand> {
    let mut sizes = first_sizes;
    let mut stand = Stand::new(bench, subset, fitted, sizes);
    let rounds: &[fn(Sizes) -> Search] = if known {
        &[Search::Again]
    } else {
        &[|_| Search::Near, Search::Onward]
    };
    for search in rounds {
        let smooth = smooth_beside(bench, &stand.fitted);
        let noise = bench.noise(
            subset,
            &stand.fitted,
            &stand.jacobian,
            &smooth,
            search(sizes),
        );
        sizes = noise.sizes;
        stand = refit(bench, subset, &stand.fitted, &sizes)?;
    }
    Some(stand)
}

/// The same model fitted again under other sizes of the noise. The noise's scale is the fit's own friction: a fit that is nearer
/// under the old scale and less likely under its own (friction that hides behind the scatter between runs) is not taken.
fn refit(bench: &Bench<'_>, subset: &Subset, fitted: &Fitted, sizes: &Sizes) -> Option<Stand> {
    let before = Likelihood::of(bench, subset, fitted, *sizes);
    let context = subset.context_of(bench, fitted);
    let whitener = before.whitener.with_scatter(&context, sizes.scatter);
    let dear = fitted.effects.iter().any(|&e| is_dear(bench, e));
    let limit = if dear { 6 } else { 20 };
    let (effects, start) = (&fitted.effects, &fitted.parameters);
    let fit = bench.fit(subset, effects, start, &whitener, None, limit)?;
    let after = Likelihood::of(bench, subset, &fit, *sizes);
    let stand = if after.deviance <= before.deviance {
        Stand::at(bench, subset, fit, *sizes, after)
    } else {
        Stand::at(bench, subset, fitted.clone(), *sizes, before)
    };
    Some(levelled(bench, subset, stand))
}

/// The whole selection; `None` where the law itself cannot be computed on the campaign.
pub(crate) fn select(
    bench: &Bench<'_>,
    subset: &Subset,
    depth: Depth,
    warm: Option<&Warm>,
) -> Option<Selected> {
    let mut subset = subset
        .late_by(warm.map_or(Lateness::default(), |w| w.late))
        .turning(warm.is_some_and(|w| w.turns));
    let mut ground = baseline(bench, &subset, warm)?;
    if warm.is_none() && subset.can_turn(bench) {
        // A disc or a plate without end: the likelier, by what the law leaves.
        let disc = subset.turning(true);
        let beside = baseline(bench, &disc, warm)?;
        if beside.0.deviance < ground.0.deviance {
            (subset, ground) = (disc, beside);
        }
    }
    select_beside(bench, subset, ground, depth, warm, true)
}

/// The selection from a law alone and what is seen beside it. Where that law turns out to lie in a valley of its own, all begins again
/// beside the better one, `once`.
fn select_beside(
    bench: &Bench<'_>,
    mut subset: Subset,
    ground: (Stand, Scan),
    depth: Depth,
    warm: Option<&Warm>,
    once: bool,
) -> Option<Selected> {
    let (mut base, first) = ground;
    let strict = strict(&first);
    let expected = warm
        .filter(|_| depth == Depth::Fold)
        .map_or(0, |warm| warm.causes.len());
    let best = first.candidates.first().map_or(0.0, |c| c.log_p);
    // Nobody asks a fold whether there is anything at all.
    let left_beside = |subset: &Subset, stand: &Stand| match depth {
        Depth::Full => lack(bench, subset, stand),
        Depth::Fold => Lack::nothing(),
    };
    let general = left_beside(&subset, &base);
    let gate_log_p = (best + (first.asked.max(1) as f64 / 0.5).ln())
        .min(general.log_p + 2.0_f64.ln())
        .min(0.0);
    let mut singles: Vec<Single> = Vec::new();
    let mut entry: Vec<f64> = Vec::new();
    let mut chosen: Option<Stand> = None;
    let mut explained = 0.0;
    for round in 0..MOST_EFFECTS {
        // What is plain comes in as in the whole campaign; a fold goes on to what is not.
        let admitted = if round < expected {
            ALPHA_FOLD.ln()
        } else {
            strict
        };
        let later;
        let (stand, found) = match &chosen {
            None => (&base, &first),
            Some(stand) => {
                let best = first.candidates.first().map_or(0.0, |c| c.score.z());
                let dull: Vec<usize> = first
                    .candidates
                    .iter()
                    .filter(|c| is_dear(bench, c.cause) && c.score.z() < 0.2 * best)
                    .map(|c| c.cause)
                    .collect();
                later = scan_without(bench, &subset, stand, likely_scatter(stand), &dull);
                (stand, &later)
            }
        };
        let Some(top) = found.candidates.first() else {
            break;
        };
        if cannot_matter(round, found, explained) {
            break;
        }
        // The first round asks all that come near; later ones must pass on their own.
        let threshold = if top.log_p > strict { admitted } else { strict };
        let step = if top.log_p > admitted {
            swallowed(bench, &subset, stand, found).map(Step::from)
        } else {
            step(bench, &subset, stand, found, threshold, depth, warm)
        };
        let Some(step) = step.filter(|step| round == 0 || step.log_p <= admitted) else {
            break;
        };
        let beyond_shape = round == 0 || step.drop > SHAPE_TOLERANCE.powi(2) * explained;
        if !(step.drop > IDLE) || !beyond_shape {
            break;
        }
        if round == 0 {
            singles = step.tried;
        }
        let next = match step.next {
            Next::Fit(fit) if round == 0 && depth == Depth::Full => {
                deepest(bench, &subset, settle(bench, &subset, &fit, found)?)?
            }
            Next::Fit(fit) => settle(bench, &subset, &fit, found)?,
            Next::Settled(stand) => *stand,
        };
        if once && let Some(law) = law_without(bench, &subset, &next, &base) {
            let found = scan(bench, &subset, &law, likely_scatter(&law));
            return select_beside(bench, subset, (law, found), depth, warm, false);
        }
        let last = next.fitted.effects.len() - 1;
        if step.log_p * share_without_blows(bench, &subset, &next, last) > admitted {
            break;
        }
        explained += step.drop;
        entry.push(step.log_p);
        let (mut next, _) = looked_up(bench, &mut subset, next, depth)?;
        let periodic = bench.catalogue[next.fitted.effects[last]].is_periodic();
        if round > 0 || periodic {
            let before = next.deviance;
            next = look_back(bench, &subset, next, &singles, &mut entry, threshold, depth)?;
            // Beside a period that was found anew the law may lie in another valley.
            if round == 0 && depth == Depth::Full && next.deviance < before - IDLE {
                next = deepest(bench, &subset, next)?;
            }
            let (later, moved) = looked_up(bench, &mut subset, next, depth)?;
            next = later;
            if moved {
                next = drop_idle(bench, &subset, next, &mut entry, -2.0 * threshold)?;
            }
        }
        chosen = Some(refine_last(bench, &subset, next, -2.0 * strict)?);
    }
    if depth == Depth::Full
        && let Some(stand) = chosen.take()
    {
        chosen = Some(plainest(bench, &subset, stand)?);
    }
    if let Some(warm) = warm.filter(|_| depth == Depth::Fold)
        && let Some(stand) = chosen.take()
    {
        chosen = Some(exchange_with_named(bench, &subset, stand, &warm.causes)?);
    }
    let left;
    let stand = match chosen {
        None => {
            left = general;
            Stand::new(bench, &subset, base.fitted.clone(), base.sizes)
        }
        Some(stand) => {
            left = left_beside(&subset, &stand);
            base = Stand::new(bench, &subset, base.fitted.clone(), stand.sizes);
            stand
        }
    };
    let mut selected = Selected {
        baseline: base,
        stand,
        first,
        gate_log_p,
        left,
        entry_log_p: entry,
        singles,
        subset,
        refused: Vec::new(),
    };
    // Whether names may stay is asked of the whole campaign.
    if depth == Depth::Full {
        take_back(bench, &mut selected);
    }
    Some(selected)
}

/// The law that a first cause has left behind, where that law alone does as well as both and better than the law alone did: the cause
/// has only led the law out of a valley.
fn law_without(bench: &Bench<'_>, subset: &Subset, single: &Stand, base: &Stand) -> Option<Stand> {
    if single.fitted.effects.len() != 1 {
        return None;
    }
    let context = subset.context_of(bench, &single.fitted);
    let scatter = likely_scatter(single);
    let whitener = single.whitener.with_scatter(&context, scatter);
    let law = single.fitted.without(0);
    let fit = bench.fit(subset, &[], &law, &whitener, None, 20)?;
    if single.deviance_of(bench, subset, &fit) - single.deviance > IDLE {
        return None;
    }
    let found = Scan::empty(bench, Some(single.sizes));
    settle(bench, subset, &fit, &found).filter(|law| law.deviance < base.deviance - IDLE)
}

/// Whether what is seen beside a named cause lies so far within the tolerance of that cause's shape that no fit can lift it
/// out: a fit saves more than its score says where an effect is far from linear, but not [`NONLINEAR`] times more.
fn cannot_matter(round: usize, found: &Scan, explained: f64) -> bool {
    let scores = found.candidates.iter().map(|c| c.score.z().powi(2));
    let most = scores.fold(0.0, f64::max);
    round > 0 && NONLINEAR * most < SHAPE_TOLERANCE.powi(2) * explained
}

/// The model that a round proposes.
enum Next {
    /// Fitted under the noise of the stand before.
    Fit(Box<Fitted>),
    /// With its own noise already.
    Settled(Box<Stand>),
}

/// What one round of the selection proposes.
struct Step {
    next: Next,
    /// Deviance that the new cause saves.
    drop: f64,
    /// Tail probability at which it was seen.
    log_p: f64,
    /// All that were fitted.
    tried: Vec<Single>,
}

impl From<Recovered> for Step {
    fn from(recovered: Recovered) -> Self {
        Self {
            next: Next::Settled(Box::new(recovered.stand)),
            drop: recovered.saved,
            log_p: recovered.log_p,
            tried: Vec::new(),
        }
    }
}

/// The best further cause beside a stand whose parameters cannot be trusted.
fn strong_step(
    bench: &Bench<'_>,
    subset: &Subset,
    stand: &Stand,
    found: &Scan,
    warm: Option<&Warm>,
) -> Option<Step> {
    let mut stands = afresh(bench, subset, stand, found, warm);
    let tried = stands
        .iter()
        .map(|(cause, stand)| Single {
            cause: *cause,
            fitted: stand.fitted.clone(),
        })
        .collect();
    if stands.is_empty() {
        return None;
    }
    let (cause, next) = stands.swap_remove(0);
    // Beside a law that was bent to a cause, its tangent there may score nothing: what the fit saves under the noise that the law
    // alone leaves is seen too.
    let saved = stand.deviance - stand.deviance_of(bench, subset, &next.fitted);
    let asked = bench.catalogue[cause].parameters().len();
    Some(Step {
        drop: next.deviance_of(bench, subset, &stand.fitted) - next.deviance,
        next: Next::Settled(Box::new(next)),
        log_p: found
            .log_p_of(cause)
            .min(log_chi2_tail(saved.max(0.0), asked)),
        tried,
    })
}

/// The best further cause beside a stand. Where causes are strong, in what they score or in what a fit saves (beside a law that was
/// bent to them, and its noise, they may score little), the stand's parameters are not trusted.
fn step(
    bench: &Bench<'_>,
    subset: &Subset,
    stand: &Stand,
    found: &Scan,
    threshold: f64,
    depth: Depth,
    warm: Option<&Warm>,
) -> Option<Step> {
    // A search under the noise of a healthy rig may lose what the stand's own noise shows plainly.
    let anew = |promised: f64| {
        strong_step(bench, subset, stand, found, warm).filter(|step| step.drop > KEPT * promised)
    };
    let best = found.candidates.first().map_or(0.0, |c| c.score.z());
    if best > STRONG
        && let Some(step) = anew(best.powi(2))
    {
        return Some(step);
    }
    let (most, starts) = match depth {
        Depth::Full => (SURVIVORS, 2),
        Depth::Fold => (3, 1),
    };
    let asked = survivors(bench, found, threshold, most);
    let known = warm.map_or(&[][..], |warm| &warm.causes);
    let fits = joint_fits(bench, subset, stand, &asked, starts, known);
    let (cause, fit, deviance) = fits.first().cloned()?;
    let drop = stand.deviance - deviance;
    if best <= STRONG
        && drop > STRONG.powi(2)
        && let Some(step) = anew(drop)
    {
        return Some(step);
    }
    Some(Step {
        next: Next::Fit(Box::new(fit)),
        drop,
        log_p: found.log_p_of(cause),
        tried: fits
            .into_iter()
            .map(|(cause, fitted, _)| Single { cause, fitted })
            .collect(),
    })
}

/// A new model: noise estimated beside it, fitted again.
pub(crate) fn settle(
    bench: &Bench<'_>,
    subset: &Subset,
    fit: &Fitted,
    found: &Scan,
) -> Option<Stand> {
    let (jacobian, _) = bench.jacobian(subset, fit);
    let search = found.sizes.map_or(Search::Scratch, Search::Again);
    let noise = bench.noise(subset, fit, &jacobian, &found.smooth, search);
    refit(bench, subset, fit, &noise.sizes)
}

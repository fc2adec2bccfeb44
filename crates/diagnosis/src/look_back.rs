//! What a further cause makes of the causes before it: one other cause alone may do as well as the pair, one may have become
//! idle, and one may have been the best name only as long as its neighbour was missing.

use rayon::prelude::*;

use crate::bench::{Bench, Beside, Fitted};
use crate::joint::{joint_fits, search_price, survivors};
use crate::proposal::SURVIVORS;
use crate::scan::{Candidate, Scan, scan, scan_period};
use crate::selection::{Depth, MOST_EFFECTS, Single};
use crate::settled::{likely_scatter, settle};
use crate::stand::Stand;
use crate::subset::Subset;

/// Exchanges of one cause for another in one look back.
const MOST_EXCHANGES: usize = 3;
/// Times that one period is looked for again.
const MOST_PERIODS: usize = 3;
/// Deviance that an exchange must save: parameters are paid for, and neither cause has the right of the first.
pub(crate) const EXCHANGE: f64 = 1.0;
/// Deviance by which a model may come out worse than promised once its own noise is estimated. Beyond that the promise was made
/// under another's noise and does not hold: the friction that scales roughness is not the same.
const PROMISED: f64 = 20.0;

/// The near miss, one other cause alone against the pair; each cause against another in its place; each against doing without.
pub(crate) fn look_back(
    bench: &Bench<'_>,
    subset: &Subset,
    pair: Stand,
    singles: &[Single],
    entry: &mut Vec<f64>,
    threshold: f64,
    depth: Depth,
) -> Option<Stand> {
    let count = pair.fitted.effects.len();
    // One other cause alone: fitted singles under the pair's noise. A second cause must be worth its look-elsewhere.
    let worth = -2.0 * threshold;
    if count == 2 {
        let fitted = singles
            .iter()
            .map(|s| (s.cause, s.fitted.parameters.clone()));
        let whitener = pair.scattered(pair.sizes.scatter);
        let mut best: Option<(f64, Fitted)> = None;
        for (cause, start) in fitted.chain(other_forms_alone(bench, &pair.fitted)) {
            let Some(fit) = bench.fit(subset, &[cause], &start, &whitener, None, 15) else {
                continue;
            };
            let deviance = pair.deviance_of(bench, subset, &fit);
            if best.as_ref().is_none_or(|b| deviance < b.0) {
                best = Some((deviance, fit));
            }
        }
        if let Some((deviance, fit)) = best
            && deviance < pair.deviance + worth
        {
            let found = Scan::empty(bench, Some(pair.sizes));
            let alone = settle(bench, subset, &fit, &found)?;
            if alone.deviance < pair.deviance + worth + PROMISED {
                entry.truncate(1);
                return Some(alone);
            }
        }
    }
    // A fold starts from the causes that the whole campaign has settled on; of so many that none is named only those count that have become
    // idle.
    let best = match depth {
        Depth::Full if count < MOST_EFFECTS => {
            let pair = periods_again(bench, subset, pair, entry);
            exchange(bench, subset, pair, entry, threshold)?
        }
        Depth::Full | Depth::Fold => pair,
    };
    drop_idle(bench, subset, best, entry, worth)
}

/// Every other form of each cause of a set with a start for it alone: the set's law and the cause's own parameters, where it has as many.
/// A plain form may need a second cause to do what another form does without.
fn other_forms_alone(bench: &Bench<'_>, set: &Fitted) -> Vec<(usize, Vec<f64>)> {
    let mut alone = Vec::new();
    for (k, &named) in set.effects.iter().enumerate() {
        let span = set.model.span(k);
        let alike = |form: &usize| {
            let (other, own) = (&bench.catalogue[*form], &bench.catalogue[named]);
            *form != named && other.id() == own.id() && other.parameters().len() == span.len()
        };
        for form in (0..bench.catalogue.len()).filter(alike) {
            let mut start = set.parameters[..set.model.law_parameters()].to_vec();
            start.extend_from_slice(&set.parameters[span.clone()]);
            start.extend_from_slice(&set.parameters[set.model.initial_states()]);
            alone.push((form, start));
        }
    }
    alone
}

/// Each period of a set looked for again where the law stands beside it. A strong ripple bends the law that is fitted without it, and what
/// that law leaves may show a neighbour's line.
fn periods_again(bench: &Bench<'_>, subset: &Subset, mut stand: Stand, entry: &mut [f64]) -> Stand {
    for own in stand.fitted.effects.clone() {
        if !bench.catalogue[own].is_periodic() {
            continue;
        }
        for _ in 0..MOST_PERIODS {
            let Some((k, next)) = period_again(bench, subset, &stand, own) else {
                break;
            };
            stand = next;
            move_last(entry, k);
        }
    }
    stand
}

/// The set with one period looked for again, where that is better: the cause's place before, and the set, where it stands last.
fn period_again(
    bench: &Bench<'_>,
    subset: &Subset,
    stand: &Stand,
    own: usize,
) -> Option<(usize, Stand)> {
    let fitted = &stand.fitted;
    let k = fitted.effects.iter().position(|&e| e == own)?;
    let beside = Stand::new(bench, subset, bare(bench, fitted, k)?, stand.sizes);
    let at = &fitted.parameters[fitted.model.span(k)];
    let found = scan_period(bench, subset, &beside, likely_scatter(stand), own, at);
    let asked: Vec<&Candidate> = found.candidates.iter().collect();
    let fits = joint_fits(bench, subset, &beside, &asked, 2, &[]);
    let (_, fit, _) = fits.into_iter().next()?;
    if stand.deviance_of(bench, subset, &fit) > stand.deviance - EXCHANGE {
        return None;
    }
    let found = Scan::empty(bench, Some(stand.sizes));
    let next = settle(bench, subset, &fit, &found)?;
    (next.deviance <= stand.deviance - EXCHANGE).then_some((k, next))
}

/// Entries in the order of a set whose k-th cause was taken out and joined again as the last.
fn move_last(entry: &mut [f64], k: usize) {
    let last = entry.len() - 1;
    entry[k.min(last)..].rotate_left(1);
}

/// Each cause of a set against every other that comes near in its place. The first cause was the best name for the sum of all
/// that is wrong; beside its neighbours another may be.
fn exchange(
    bench: &Bench<'_>,
    subset: &Subset,
    mut stand: Stand,
    entry: &mut [f64],
    threshold: f64,
) -> Option<Stand> {
    for _ in 0..MOST_EXCHANGES {
        let own = |k: usize| search_price(bench, stand.fitted.effects[k]);
        let places = (0..stand.fitted.effects.len()).into_par_iter();
        let replaced = places.filter_map(|k| {
            let (cause, fit, log_p) = replacement(bench, subset, &stand, k, threshold)?;
            let worth = stand.deviance_of(bench, subset, &fit) + search_price(bench, cause);
            Some((stand.deviance + own(k) - worth, k, fit, log_p))
        });
        let replaced: Vec<(f64, usize, Fitted, f64)> = replaced.collect();
        let best = replaced
            .into_iter()
            .reduce(|best, other| if other.0 > best.0 { other } else { best });
        let Some((_, k, fit, log_p)) = best.filter(|b| b.0 > EXCHANGE) else {
            break;
        };
        let found = Scan::empty(bench, Some(stand.sizes));
        let exchanged = settle(bench, subset, &fit, &found)?;
        if exchanged.deviance > stand.deviance + PROMISED {
            break;
        }
        stand = exchanged;
        move_last(entry, k);
        if let Some(last) = entry.last_mut() {
            *last = log_p;
        }
    }
    Some(stand)
}

/// Inside a fold: what the whole campaign named against what the fold took in its stead. (The exchange with the whole catalogue is
/// made once, on all runs.)
pub(crate) fn exchange_with_named(
    bench: &Bench<'_>,
    subset: &Subset,
    mut stand: Stand,
    named: &[(usize, Vec<f64>)],
) -> Option<Stand> {
    let whitener = stand.likely_noise();
    let mut best: Option<(f64, Fitted)> = None;
    let absent = |cause: &usize| !stand.fitted.effects.contains(cause);
    for (cause, own) in named.iter().filter(|(cause, _)| absent(cause)) {
        for k in 0..stand.fitted.effects.len() {
            let out = stand.fitted.effects[k];
            if named.iter().any(|(cause, _)| *cause == out) {
                continue;
            }
            let mut effects = stand.fitted.effects.clone();
            effects[k] = *cause;
            let start = stand.fitted.with_own(k, own);
            let Some(fit) = bench.fit(subset, &effects, &start, &whitener, None, 20) else {
                continue;
            };
            let price = search_price(bench, *cause) - search_price(bench, out);
            let saved = stand.deviance - stand.deviance_of(bench, subset, &fit) - price;
            if best.as_ref().is_none_or(|b| saved > b.0) {
                best = Some((saved, fit));
            }
        }
    }
    if let Some((_, fit)) = best.filter(|b| b.0 > EXCHANGE) {
        let found = Scan::empty(bench, Some(stand.sizes));
        stand = settle(bench, subset, &fit, &found)?;
    }
    Some(stand)
}

/// The best other cause in the place of the k-th, or the same with another period, its fit and its tail probability.
fn replacement(
    bench: &Bench<'_>,
    subset: &Subset,
    stand: &Stand,
    k: usize,
    threshold: f64,
) -> Option<(usize, Fitted, f64)> {
    let own = stand.fitted.effects[k];
    let fit = fitted_without(bench, subset, stand, k)?;
    let beside = Stand::new(bench, subset, fit, stand.sizes);
    let found = scan(bench, subset, &beside, likely_scatter(stand));
    let same = |cause: usize| bench.catalogue[cause].id() == bench.catalogue[own].id();
    let mut asked = survivors(bench, &found, threshold, SURVIVORS);
    // A periodic cause may take its own place with another period: among strong neighbours the wrong line may have been the highest.
    asked.retain(|c| !same(c.cause) || bench.catalogue[c.cause].is_periodic());
    let (cause, fit, _) = joint_fits(bench, subset, &beside, &asked, 2, &[])
        .into_iter()
        .next()?;
    // What is not seen there on its own may not come in by the back door.
    let seen = found.candidates.iter().find(|c| c.cause == cause)?;
    (seen.log_p < threshold).then_some((cause, fit, seen.log_p))
}

/// Each cause against doing without it: the one that is missed least goes, as long as one is worth less than it must be.
pub(crate) fn drop_idle(
    bench: &Bench<'_>,
    subset: &Subset,
    mut stand: Stand,
    entry: &mut Vec<f64>,
    worth: f64,
) -> Option<Stand> {
    while stand.fitted.effects.len() > 1 {
        let mut least: Option<(f64, usize, Fitted)> = None;
        for k in 0..stand.fitted.effects.len() {
            let Some(fit) = fitted_without(bench, subset, &stand, k) else {
                continue;
            };
            let saved = stand.deviance_of(bench, subset, &fit) - stand.deviance;
            if least.as_ref().is_none_or(|l| saved < l.0) {
                least = Some((saved, k, fit));
            }
        }
        let Some((_, k, fit)) = least.filter(|l| l.0 < worth) else {
            break;
        };
        let found = Scan::empty(bench, Some(stand.sizes));
        let rest = settle(bench, subset, &fit, &found)?;
        if rest.deviance > stand.deviance + worth + PROMISED {
            break;
        }
        entry.remove(k.min(entry.len() - 1));
        stand = rest;
    }
    Some(stand)
}

/// The fit of all but the k-th effect, under the noise of the whole set.
pub(crate) fn fitted_without(
    bench: &Bench<'_>,
    subset: &Subset,
    stand: &Stand,
    k: usize,
) -> Option<Fitted> {
    /// One effect less is near.
    const STEPS: u64 = 20;
    let mut rest = stand.fitted.effects.clone();
    rest.remove(k);
    let whitener = stand.likely_noise();
    bench.fit(
        subset,
        &rest,
        &stand.fitted.without(k),
        &whitener,
        None,
        STEPS,
    )
}

/// A fit with its k-th effect taken out and all else where it was.
pub(crate) fn bare(bench: &Bench<'_>, fitted: &Fitted, k: usize) -> Option<Fitted> {
    let mut effects = fitted.effects.clone();
    effects.remove(k);
    let model = bench.model(&effects)?;
    let parameters = fitted.without(k);
    let prediction = model.predict(&bench.experiment, &parameters);
    Some(Fitted {
        effects,
        model,
        parameters,
        prediction,
        cost: f64::INFINITY,
        converged: fitted.converged,
        beside: Beside::default(),
    })
}

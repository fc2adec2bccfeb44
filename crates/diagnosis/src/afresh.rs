//! Joint fits that do not trust the law alone.
//!
//! A strong effect drags the law's parameters far away when the law is fitted without it: signatures taken there, and
//! the noise estimated there, say little about the cause. Then every cause is fitted together with the law from starts
//! that the record itself suggests, under the noise that a healthy rig would have, and the best of them are compared by
//! their likelihoods, each with the noise that its own residual shows.

use std::sync::OnceLock;

use fitting::noise::{Sizes, Whitener};
use nalgebra::DMatrix;
use rayon::prelude::*;

use crate::bench::{Bench, Fitted, Stand};
use crate::scan::{Scan, extended};
use crate::selection::{Warm, is_dear, search_price, settle};
use crate::subset::Subset;

/// Strength of the best candidate (in standard deviations) from which the law alone is not trusted: several times what
/// is needed to be seen.
const STRONG: f64 = 12.0;
/// Starts of the law that are tried with each cause, beside where the law stands.
const LAW_STARTS: usize = 20;
/// Sizes and shapes of each cause that are tried with each start of the law.
const OWN_STARTS: usize = 6;
/// Fits of each cause from its best starts, and steps of each.
const ROUGH: (usize, u64) = (3, 15);
/// The same where the mechanics are dear, and how many of the law's starts are tried there.
const DEAR: (usize, u64) = (2, 8);
const DEAR_LAWS: usize = 3;
/// Sizes and shapes of each cause that are tried beside such mechanics.
const BESIDE_DEAR: usize = 2;
/// Causes whose fits are carried to their end and compared under their own noise.
const FINISHED: usize = 4;

/// The same inside a fold, where the fits start from the whole campaign's.
const FINISHED_IN_FOLD: usize = 2;
/// Best candidates that are asked beside a cause that is named already, and inside a fold.
const ASKED_LATER: usize = 8;
const ASKED_IN_FOLD: usize = 3;

/// Which candidates are fitted: beside the law alone all, for what they score there means little; beside a named cause,
/// where the law has come right, the best; inside a fold also what the whole campaign named.
fn is_asked(place: usize, cause: usize, stand: &Stand, warm: Option<&Warm>) -> bool {
    match warm {
        Some(warm) => place < ASKED_IN_FOLD || warm.causes.iter().any(|(named, _)| *named == cause),
        None => stand.fitted.effects.is_empty() || place < ASKED_LATER,
    }
}

/// Whether what is seen beside a stand is so strong that its parameters cannot be trusted.
pub(crate) fn is_strong(found: &Scan) -> bool {
    found
        .candidates
        .first()
        .is_some_and(|c| c.score.z() > STRONG)
}

/// The stand's model with each further cause, fitted from starts that owe nothing to the stand (inside a fold: from where
/// the whole campaign ended); best first under each fit's own noise.
pub(crate) fn afresh(
    bench: &Bench<'_>,
    subset: &Subset,
    stand: &Stand,
    found: &Scan,
    warm: Option<&Warm>,
) -> Vec<(usize, Stand)> {
    let whitener = healthy_noise(bench, subset);
    let suggested = match warm {
        Some(warm) => vec![warm.extended_law.clone()],
        None => bench.law_starts(&stand.fitted.model),
    };
    let laws = law_starts(bench, subset, stand, &whitener, suggested);
    let stiff = match warm {
        Some(_) => Vec::new(),
        None => law_starts(bench, subset, stand, &whitener, bench.stiff_law_starts()),
    };
    let beside_dear = stand.fitted.effects.iter().any(|&e| is_dear(bench, e));
    let candidates: Vec<(usize, Vec<Vec<f64>>)> = found
        .candidates
        .iter()
        .enumerate()
        .filter(|(place, c)| is_asked(*place, c.cause, stand, warm))
        .map(|(_, c)| c)
        .map(|c| (c.cause, own_starts(bench, c.cause, &c.starts, warm)))
        .collect();
    let mut rough: Vec<(usize, Fitted)> = candidates
        .par_iter()
        .filter_map(|(cause, own)| {
            // Beside a cord that was fitted already the law has come right; where the cord is what is asked for, all that is
            // elastic may be in it: then the contact is stiff.
            let tries = if beside_dear {
                let own = &own[..own.len().min(BESIDE_DEAR)];
                Tries::new(vec![&stand.fitted], own, DEAR)
            } else if is_dear(bench, *cause) {
                let laws = laws.iter().take(DEAR_LAWS).chain(&stiff).collect();
                Tries::new(laws, own, DEAR)
            } else {
                Tries::new(laws.iter().collect(), own, ROUGH)
            };
            let fit = rough_fit(bench, subset, stand, *cause, &tries, &whitener)?;
            Some((*cause, fit))
        })
        .collect();
    rough.sort_by(|a, b| {
        let worth = |f: &(usize, Fitted)| 2.0 * f.1.cost + search_price(bench, f.0);
        worth(a).total_cmp(&worth(b)).then(a.0.cmp(&b.0))
    });
    rough.truncate(if warm.is_some() {
        FINISHED_IN_FOLD
    } else {
        FINISHED
    });
    // The whole campaign's noise is near a fold's; without one the law alone's says nothing.
    let blank = found.with_sizes(warm.map(|w| w.sizes));
    let stands: Vec<(usize, Stand)> = rough
        .par_iter()
        .filter_map(|(cause, fit)| {
            let limit = if is_dear(bench, *cause) { 20 } else { 60 };
            let fit = bench.fit(
                subset,
                &fit.effects,
                &fit.parameters,
                &whitener,
                None,
                limit,
            )?;
            Some((*cause, settle(bench, subset, &fit, &blank)?))
        })
        .collect();
    let worth = likeliest(bench, subset, &stands);
    let mut ranked: Vec<(f64, (usize, Stand))> = worth.into_iter().zip(stands).collect();
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.0.cmp(&b.1.0)));
    ranked.into_iter().map(|(_, stand)| stand).collect()
}

/// -2 log likelihood of each stand, parameters paid for, under whichever of the stands' noises suits it best. A stand's own noise
/// leaves out what further causes could explain, and then makes much of a remainder that a worse fit's noise swallows.
fn likeliest(bench: &Bench<'_>, subset: &Subset, stands: &[(usize, Stand)]) -> Vec<f64> {
    let each = stands.par_iter().map(|(cause, stand)| {
        let others = stands.iter().filter(|(other, _)| other != cause);
        others
            .map(|(_, other)| stand.deviance_with(bench, subset, other.sizes))
            .fold(stand.deviance, f64::min)
            + search_price(bench, *cause)
    });
    each.collect()
}

/// Whitening by the noise of a healthy rig: no residual has been looked at. The record itself stands for its friction, so a gain
/// free for each run would forgive a law without any friction; roughness along the run does not.
fn healthy_noise(bench: &Bench<'_>, subset: &Subset) -> Whitener {
    let context = subset.context(bench, &bench.crude_scale());
    let sizes = Sizes {
        scatter: 0.0,
        ..bench.first_sizes()
    };
    Whitener::new(&context, &sizes)
}

/// Parameters of the stand's model: where it stands, and its law at starts that the record suggests.
fn law_starts(
    bench: &Bench<'_>,
    subset: &Subset,
    stand: &Stand,
    whitener: &Whitener,
    suggested: Vec<Vec<f64>>,
) -> Vec<Fitted> {
    let model = &stand.fitted.model;
    let count = model.law_parameters();
    let measured = subset.gather(&bench.experiment.measured_n);
    let mut starts: Vec<Fitted> = suggested
        .into_iter()
        .filter_map(|law| {
            let mut parameters = stand.fitted.parameters.clone();
            parameters[..count].copy_from_slice(&law[..count]);
            let prediction = model.predict(&bench.experiment, &parameters);
            let residual = subset.gather(&prediction) - &measured;
            let cost = 0.5 * whitener.whiten(&residual).norm_squared();
            cost.is_finite().then(|| Fitted {
                effects: stand.fitted.effects.clone(),
                model: model.clone(),
                parameters,
                prediction,
                cost,
                converged: false,
                friction: OnceLock::new(),
            })
        })
        .collect();
    starts.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    starts.truncate(LAW_STARTS);
    starts.push(stand.fitted.clone());
    starts
}

/// A cause's own starts: what the scan suggests, then plausible sizes over its shapes, evenly chosen.
fn own_starts(
    bench: &Bench<'_>,
    cause: usize,
    suggested: &[Vec<f64>],
    warm: Option<&Warm>,
) -> Vec<Vec<f64>> {
    let effect = &bench.catalogue[cause];
    let known = warm.iter().flat_map(|w| &w.causes);
    let mut own: Vec<Vec<f64>> = known
        .filter(|(named, _)| *named == cause)
        .map(|(_, own)| own.clone())
        .collect();
    own.extend(suggested.iter().take(2).cloned());
    // A period is found in the residual or nowhere.
    if effect.is_periodic() {
        return own;
    }
    let plausible = effect.starts(&bench.experiment);
    let room = OWN_STARTS - own.len();
    let stride = plausible.len().div_ceil(room).max(1);
    own.extend(plausible.into_iter().step_by(stride));
    own
}

/// What is tried of one cause.
struct Tries<'a> {
    /// Starts of the law.
    laws: Vec<&'a Fitted>,
    /// Sizes and shapes of the cause.
    own: &'a [Vec<f64>],
    /// Fits from the best of all their pairs, and steps of each.
    fits: usize,
    steps: u64,
}

impl<'a> Tries<'a> {
    fn new(laws: Vec<&'a Fitted>, own: &'a [Vec<f64>], (fits, steps): (usize, u64)) -> Self {
        Self {
            laws,
            own,
            fits,
            steps,
        }
    }
}

/// The best of a few rough fits of one cause.
fn rough_fit(
    bench: &Bench<'_>,
    subset: &Subset,
    stand: &Stand,
    cause: usize,
    tries: &Tries<'_>,
    whitener: &Whitener,
) -> Option<Fitted> {
    let measured = subset.gather(&bench.experiment.measured_n);
    let mut tried: Vec<(f64, usize, Vec<f64>)> = Vec::new();
    for (place, law) in tries.laws.iter().enumerate() {
        let mut starts = Vec::with_capacity(tries.own.len());
        let mut residuals = DMatrix::zeros(subset.len(), tries.own.len());
        for (own, mut column) in tries.own.iter().zip(residuals.column_iter_mut()) {
            let (model, start) = extended(bench, law, cause, own)?;
            let predicted = model.predict(&bench.experiment, &start);
            column.copy_from(&(subset.gather(&predicted) - &measured));
            starts.push(start);
        }
        let white = whitener.whiten_columns(&residuals);
        for (start, column) in starts.into_iter().zip(white.column_iter()) {
            let cost = column.norm_squared();
            if cost.is_finite() {
                tried.push((cost, place, start));
            }
        }
    }
    tried.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut effects = stand.fitted.effects.clone();
    effects.push(cause);
    let mut taken: Vec<usize> = Vec::new();
    let mut best: Option<Fitted> = None;
    for (_, place, start) in tried {
        // Fits from one start of the law tend to end in one minimum.
        if taken.contains(&place) || taken.len() == tries.fits {
            continue;
        }
        taken.push(place);
        let Some(fit) = bench.fit(subset, &effects, &start, whitener, None, tries.steps) else {
            continue;
        };
        if best.as_ref().is_none_or(|b| fit.cost < b.cost) {
            best = Some(fit);
        }
    }
    best
}

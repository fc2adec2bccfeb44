//! The form in which a cause is named: the plainest that the record allows.
//!
//! Some causes stand in the catalogue in several forms (wear with and without a limit, a square of the speed that is added or a factor).
//! Where two of them do alike, chance decides which one comes in first, and a size that is reported by the other form's parameters
//! means another thing to the reader.

use crate::bench::{Bench, Fitted, Limit};
use crate::equivalence::AS_GOOD;
use crate::joint::{forms_of, is_dear, is_second_form, search_price};
use crate::look_back::EXCHANGE;
use crate::scan::Scan;
use crate::settled::settle;
use crate::stand::Stand;
use crate::subset::Subset;

/// Steps of a fit with another form.
const STEPS: u64 = 30;
/// Deviance by which a cost may misjudge another form: the scatter between runs is weighed anew.
const UNSURE: f64 = 5.0;
/// Starts of another form that are fitted, nearest first.
const STARTS: usize = 3;

/// The set with each cause in its plainest form, wherever that costs less than the price of a second form.
pub(crate) fn plainest(bench: &Bench<'_>, subset: &Subset, mut stand: Stand) -> Option<Stand> {
    for k in 0..stand.fitted.effects.len() {
        let own = stand.fitted.effects[k];
        // A refined form came in by beating the plain one.
        if !is_second_form(bench, own) || bench.catalogue[own].refines() {
            continue;
        }
        let plain = forms_of(bench, own).next();
        let Some(plain) = plain.filter(|&plain| !is_dear(bench, plain)) else {
            continue;
        };
        let dearer = search_price(bench, own) - search_price(bench, plain);
        let starts = bench.catalogue[plain].starts(&bench.experiment);
        let saves = Some(-dearer);
        let Some((deviance, fit)) = in_place(bench, subset, &stand, (k, plain), &starts, saves)
        else {
            continue;
        };
        if deviance > stand.deviance + dearer {
            continue;
        }
        let found = Scan::empty(bench, Some(stand.sizes));
        let next = settle(bench, subset, &fit, &found)?;
        if next.deviance <= stand.deviance + dearer {
            stand = next;
        }
    }
    Some(stand)
}

/// The set with its last cause in the refined form that saves most: a form of its own where that is worth `worth` and its further
/// parameters, or one of a cause that it is mistaken for (what a channel of second order does, a delay does nearly), of which neither has
/// the right of the first.
pub(crate) fn refine_last(
    bench: &Bench<'_>,
    subset: &Subset,
    stand: Stand,
    worth: f64,
) -> Option<Stand> {
    let fitted = &stand.fitted;
    let k = fitted.effects.len() - 1;
    let own = fitted.effects[k];
    if bench.catalogue[own].refines() {
        return Some(stand);
    }
    let best = refined_forms(bench, own)
        .filter_map(|form| {
            let starts = refined_starts(bench, fitted, k, form);
            let dearer = search_price(bench, form) - search_price(bench, own);
            let is_own = bench.catalogue[form].id() == bench.catalogue[own].id();
            let worth = if is_own { worth } else { EXCHANGE };
            let saves = Some(dearer + worth);
            let (deviance, fit) = in_place(bench, subset, &stand, (k, form), &starts, saves)?;
            Some((deviance + dearer + worth, fit, dearer + worth))
        })
        .min_by(|a, b| a.0.total_cmp(&b.0));
    let Some((_, fit, worth)) = best.filter(|best| best.0 < stand.deviance) else {
        return Some(stand);
    };
    let found = Scan::empty(bench, Some(stand.sizes));
    let next = settle(bench, subset, &fit, &found)?;
    Some(if next.deviance + worth < stand.deviance {
        next
    } else {
        stand
    })
}

/// The set with causes in the forms in which they are named elsewhere, wherever these runs do not tell otherwise: what only a few runs
/// of a campaign show (whether a stand within a run counts) the others cannot say.
pub(crate) fn as_named(
    bench: &Bench<'_>,
    subset: &Subset,
    mut stand: Stand,
    named: &[(usize, Vec<f64>)],
) -> Stand {
    for k in 0..stand.fitted.effects.len() {
        let own = stand.fitted.effects[k];
        let other = |&&(form, _): &&(usize, Vec<f64>)| {
            form != own && bench.catalogue[form].id() == bench.catalogue[own].id()
        };
        let Some((form, parameters)) = named.iter().find(other) else {
            continue;
        };
        let starts = std::slice::from_ref(parameters);
        let next = in_place(bench, subset, &stand, (k, *form), starts, Some(-AS_GOOD))
            .filter(|(deviance, _)| *deviance < stand.deviance + AS_GOOD)
            .and_then(|(_, fit)| {
                settle(bench, subset, &fit, &Scan::empty(bench, Some(stand.sizes)))
            });
        if let Some(next) = next.filter(|next| next.deviance < stand.deviance + AS_GOOD) {
            stand = next;
        }
    }
    stand
}

/// The refined forms that are asked in the place of a cause.
pub(crate) fn refined_forms<'a>(
    bench: &'a Bench<'_>,
    own: usize,
) -> impl Iterator<Item = usize> + 'a {
    let (id, others) = {
        let own = &bench.catalogue[own];
        (own.id(), own.mistaken_for())
    };
    (0..bench.catalogue.len()).filter(move |&form| {
        let form = &bench.catalogue[form];
        form.refines()
            && (form.id() == id || others.contains(&form.id()))
            && form.lack(&bench.experiment).is_none()
    })
}

/// Where the fit of a refined form begins: what the plain one shows, and its further shapes at their typical values. Another cause, or a
/// form with parameters of its own, begins from these.
fn refined_starts(bench: &Bench<'_>, fitted: &Fitted, k: usize, form: usize) -> Vec<Vec<f64>> {
    let effect = &bench.catalogue[form];
    let own = &bench.catalogue[fitted.effects[k]];
    let goes_on = (own.parameters().iter().zip(effect.parameters())).all(|(a, b)| a.name == b.name);
    if effect.id() != own.id() || !goes_on || own.parameters().len() > effect.parameters().len() {
        return effect.starts(&bench.experiment);
    }
    let specs = effect.parameters_for(&bench.experiment);
    let plain = &fitted.parameters[fitted.model.span(k)];
    let with_further = |sign: f64| -> Vec<f64> {
        let further = (plain.len()..specs.len()).map(|i| {
            let size = effect.sizes().contains(&i);
            if size { 0.0 } else { sign * specs[i].typical }
        });
        plain.iter().copied().chain(further).collect()
    };
    // A shape that may go either way begins from both sides.
    let admitted = |start: &Vec<f64>| {
        specs
            .iter()
            .zip(start)
            .skip(plain.len())
            .all(|(s, &x)| s.admits(x))
    };
    let mut starts = vec![with_further(1.0)];
    let other = with_further(-1.0);
    if other != starts[0] && admitted(&other) {
        starts.push(other);
    }
    starts
}

/// The set with another form in the place of its k-th cause, from the form's starts, and its deviance under the stand's noise. `saves`: the
/// deviance that it must save to be of use; `None` where it is asked by how much it loses.
pub(crate) fn in_place(
    bench: &Bench<'_>,
    subset: &Subset,
    stand: &Stand,
    (k, form): (usize, usize),
    starts: &[Vec<f64>],
    saves: Option<f64>,
) -> Option<(f64, Fitted)> {
    let fitted = &stand.fitted;
    let mut effects = fitted.effects.clone();
    effects[k] = form;
    let model = bench.model(&effects)?;
    let whitener = stand.likely_noise();
    let mut starts: Vec<(f64, Vec<f64>)> = starts
        .iter()
        .map(|own| fitted.with_own(k, own))
        .map(|start| {
            let prediction = model.predict(&bench.experiment, &start);
            let misses = prediction.iter().zip(&fitted.prediction);
            (misses.map(|(a, b)| (a - b).powi(2)).sum(), start)
        })
        .collect();
    starts.sort_by(|a, b| a.0.total_cmp(&b.0));
    let limit = saves.map_or(Limit::from(STEPS), |saves| {
        let own = fitted.cost_under(bench, subset, &whitener);
        Limit::below(STEPS, own + 0.5 * (UNSURE - saves))
    });
    let fits = starts.iter().take(STARTS).filter_map(|(_, start)| {
        let fit = bench.fit(subset, &effects, start, &whitener, None, limit)?;
        Some((stand.deviance_of(bench, subset, &fit), fit))
    });
    fits.min_by(|a, b| a.0.total_cmp(&b.0))
}

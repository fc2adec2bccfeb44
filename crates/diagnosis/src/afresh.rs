//! Joint fits that do not trust the law alone.
//!
//! A strong effect drags the law's parameters far away when the law is fitted without it: signatures taken there, and
//! the noise estimated there, say little about the cause. Then every cause is fitted together with the law from starts
//! that the record itself suggests, under the noise that a healthy rig would have, and the best of them are compared by
//! their likelihoods, each with the noise that its own residual shows.

use std::cmp::Ordering;

use rayon::prelude::*;

use crate::bench::{Bench, Beside, Fitted};
use crate::joint::{is_dear, search_price};
use crate::scan::Scan;
use crate::selection::Warm;
use crate::settled::{settle, settle_in_kind};
use crate::signatures::extended;
use crate::stand::Stand;
use crate::starts::{Record, with_laws};
use crate::subset::Subset;
use crate::valleys::deepest;

/// Strength of the best candidate (in standard deviations) from which the law alone is not trusted: several times what
/// is needed to be seen.
const STRONG: f64 = 12.0;
/// The same where the law has more free parameters than the campaign has conditions: each of its curves is then bent to a cause easily.
const STRONG_ON_FEW: f64 = 7.0;
/// Starts of the law that are tried with each cause, beside where the law stands.
const LAW_STARTS: usize = 20;
/// Sizes and shapes of each cause that are tried with each start of the law.
const OWN_STARTS: usize = 6;
/// A start of the law that costs this many times more than the nearest starts with a cause is not tried with it: no cause has been seen
/// to bring one nearer than to a twelfth.
const OUT_OF_REACH: f64 = 30.0;
/// Fits of each cause from its best starts, and steps of each.
const ROUGH: (usize, u64) = (3, 15);
/// The same where the mechanics are dear, and how many of the law's starts are tried there.
const DEAR: (usize, u64) = (2, 8);
const DEAR_LAWS: usize = 3;
/// Sizes and shapes of each cause that are tried beside such mechanics.
const BESIDE_DEAR: usize = 2;
/// Steps of a first fit of each cause, from its best start, and the causes that are fitted on: with a strong effect most causes
/// are soon far behind.
const FIRST_STEPS: u64 = 6;
const FITTED_ON: fn(usize) -> usize = |asked| (3 * asked / 8).max(4);
/// Steps of a fit that is carried on to be compared with another form of its cause, and how many times dearer than the best form one may be
/// to stay in the race.
const FORM_STEPS: u64 = 60;
const IN_THE_RACE: f64 = 2.5;
/// -2 log likelihood by which a rival under noise of the best's kind is too far behind to be asked for another kind.
const FAR_BEHIND: f64 = 100.0;
/// Causes whose fits are carried to their end and compared under their own noise.
const FINISHED: usize = 4;
/// The same inside a fold, where the fits start from the whole campaign's.
const FINISHED_IN_FOLD: usize = 2;
/// -2 log likelihood that another valley of the law is taken to save at most: on the paper's protocol lags of 0.2 to 0.5 s gained 60 to
/// 130 by it.
const DEEPEST_VALLEY: f64 = 250.0;
/// Best candidates that are asked inside a fold.
const ASKED_IN_FOLD: usize = 3;

/// The strength from which the law alone is not trusted.
pub(crate) fn strong(bench: &Bench<'_>) -> f64 {
    // A law that is held by a model from elsewhere bends to nothing.
    let free = match bench.prior {
        Some(_) => 0,
        None => bench.law.parameters().len(),
    };
    if bench.campaign.conditions().len() < free {
        STRONG_ON_FEW
    } else {
        STRONG
    }
}

/// Which candidates are fitted: all, for what they score beside a law that is bent means little (a delay of four samples beside a load
/// dependence, 32 standard deviations, scored less than eight others); inside a fold the best and what the whole campaign named.
fn is_asked(place: usize, cause: usize, warm: Option<&Warm>) -> bool {
    warm.is_none_or(|warm| {
        place < ASKED_IN_FOLD || warm.causes.iter().any(|(named, _)| *named == cause)
    })
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
    let search = Search {
        bench,
        subset,
        stand,
        record: Record::of_a_healthy_rig(bench, subset),
    };
    let candidates: Vec<(usize, Vec<Vec<f64>>)> = found
        .candidates
        .iter()
        .enumerate()
        .filter(|(place, c)| is_asked(*place, c.cause, warm))
        .map(|(_, c)| (c.cause, own_starts(bench, c.cause, &c.starts, warm)))
        .collect();
    let mut rough = search.rough_fits(&candidates, warm);
    rough.truncate(if warm.is_some() {
        FINISHED_IN_FOLD
    } else {
        FINISHED
    });
    let stands = search.finished(&rough, found, warm);
    let ranked = by_likelihood(bench, subset, stands);
    let stands = if warm.is_none() && stand.fitted.effects.is_empty() {
        in_deepest_valleys(bench, subset, ranked)
    } else {
        ranked
    };
    stands.into_iter().map(|(_, stand)| stand).collect()
}

/// Ranked stands with the law in its deepest valley, for those that a deeper one can bring to the top; ranked again if one was deeper.
fn in_deepest_valleys(
    bench: &Bench<'_>,
    subset: &Subset,
    ranked: Vec<(f64, (usize, Stand))>,
) -> Vec<(f64, (usize, Stand))> {
    let best = ranked.first().map_or(0.0, |(worth, _)| *worth);
    let each = ranked
        .into_par_iter()
        .filter_map(|(worth, (cause, stand))| {
            let before = stand.deviance;
            let near = worth < best + DEEPEST_VALLEY;
            let stand = if near {
                deepest(bench, subset, stand)?
            } else {
                stand
            };
            Some((stand.deviance < before, worth, (cause, stand)))
        });
    let each: Vec<(bool, f64, (usize, Stand))> = each.collect();
    let deeper = each.iter().any(|(deeper, _, _)| *deeper);
    let ranked = each.into_iter().map(|(_, worth, stand)| (worth, stand));
    if deeper {
        by_likelihood(bench, subset, ranked.map(|(_, stand)| stand).collect())
    } else {
        ranked.collect()
    }
}

/// Stands with -2 log likelihood, parameters paid for, the likeliest first.
fn by_likelihood(
    bench: &Bench<'_>,
    subset: &Subset,
    stands: Vec<(usize, Stand)>,
) -> Vec<(f64, (usize, Stand))> {
    let worth = likeliest(bench, subset, &stands);
    let mut ranked: Vec<(f64, (usize, Stand))> = worth.into_iter().zip(stands).collect();
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.0.cmp(&b.1.0)));
    ranked
}

/// -2 log likelihood of each stand, parameters paid for, under whichever of the stands' noises suits it best. A stand's own noise
/// leaves out what further causes could explain, and then makes much of a remainder that a worse fit's noise swallows.
fn likeliest(bench: &Bench<'_>, subset: &Subset, stands: &[(usize, Stand)]) -> Vec<f64> {
    let each = stands.par_iter().map(|(cause, stand)| {
        stands
            .iter()
            .map(|(_, other)| stand.deviance_past_resonance(bench, subset, other.sizes))
            .fold(f64::INFINITY, f64::min)
            + search_price(bench, *cause)
    });
    each.collect()
}

/// Of each cause the best of its forms: forms of one cause do not keep another one from being looked at.
fn better_forms(bench: &Bench<'_>, fits: Vec<(usize, Fitted)>) -> Vec<(usize, Fitted)> {
    let mut kept: Vec<(usize, Fitted)> = Vec::new();
    for (cause, fit) in fits {
        let id = bench.catalogue[cause].id();
        if kept.iter().all(|(k, _)| bench.catalogue[*k].id() != id) {
            kept.push((cause, fit));
        }
    }
    kept
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
struct Tries {
    cause: usize,
    /// Starts, nearest to the record first, each with a law of its own.
    starts: Vec<Vec<f64>>,
    /// Steps of a rough fit.
    steps: u64,
}

/// Joint fits of a stand's model with one more cause under a noise that owes nothing to the stand.
struct Search<'a> {
    bench: &'a Bench<'a>,
    subset: &'a Subset,
    stand: &'a Stand,
    record: Record<'a>,
}

impl Search<'_> {
    /// A rough fit of each candidate (a cause and its own starts), best first; those that are soon far behind are left out.
    fn rough_fits(
        &self,
        candidates: &[(usize, Vec<Vec<f64>>)],
        warm: Option<&Warm>,
    ) -> Vec<(usize, Fitted)> {
        let bench = self.bench;
        let suggested = match warm {
            Some(warm) => vec![warm.extended_law.clone()],
            None => bench.law_starts(&self.stand.fitted.model),
        };
        let laws = self.law_starts(suggested);
        let stiff = match warm {
            Some(_) => Vec::new(),
            None => self.law_starts(bench.stiff_law_starts()),
        };
        let mut first: Vec<(Fitted, Tries)> = candidates
            .par_iter()
            .filter_map(|(cause, own)| {
                let tries = self.tries(*cause, own, &laws, &stiff);
                let steps = FIRST_STEPS.min(tries.steps);
                let fit = self.fit(*cause, tries.starts.first()?, steps)?;
                Some((fit, tries))
            })
            .collect();
        first.sort_by(|(a, x), (b, y)| by_worth(bench, (x.cause, a), (y.cause, b)));
        first.truncate(FITTED_ON(candidates.len()));
        let rough: Vec<(usize, Fitted)> = first
            .into_par_iter()
            .map(|(fit, tries)| (tries.cause, self.fitted_on(fit, &tries)))
            .collect();
        let mut rough = self.forms_carried_on(rough);
        rough.sort_by(|a, b| by_worth(bench, (a.0, &a.1), (b.0, &b.1)));
        better_forms(bench, rough)
    }

    /// Forms of one cause are compared where their fits end: of rough fits that are still under way the nearer one need not be the better
    /// form.
    fn forms_carried_on(&self, rough: Vec<(usize, Fitted)>) -> Vec<(usize, Fitted)> {
        let bench = self.bench;
        let forms: Vec<(&str, f64)> = (rough.iter())
            .map(|(cause, fit)| (bench.catalogue[*cause].id(), fit.cost))
            .collect();
        let under_way = |cause: usize, fit: &Fitted| {
            let id = bench.catalogue[cause].id();
            let own = || forms.iter().filter(|(other, _)| *other == id);
            let best = own().map(|(_, cost)| *cost).fold(f64::INFINITY, f64::min);
            let near = own().filter(|(_, cost)| *cost < IN_THE_RACE * best).count();
            !fit.converged && near > 1 && fit.cost < IN_THE_RACE * best && !is_dear(bench, cause)
        };
        let carried_on = |(cause, fit): (usize, Fitted)| {
            let longer = (under_way(cause, &fit))
                .then(|| self.fit(cause, &fit.parameters, FORM_STEPS))
                .flatten();
            (cause, longer.unwrap_or(fit))
        };
        rough.into_par_iter().map(carried_on).collect()
    }

    /// Parameters of the stand's model: where it stands, and its law at starts that the record suggests.
    fn law_starts(&self, suggested: Vec<Vec<f64>>) -> Vec<Fitted> {
        let (bench, stand) = (self.bench, self.stand);
        let model = &stand.fitted.model;
        // As those of fits, 1/2 |W r|^2.
        let cost = |prediction: &[f64]| 0.5 * self.record.cost(prediction);
        let mut starts: Vec<Fitted> = with_laws(&stand.fitted.parameters, suggested)
            .into_iter()
            .filter_map(|parameters| {
                let (prediction, paths) = model.predict_and_keep(&bench.experiment, &parameters);
                let cost = cost(&prediction);
                cost.is_finite().then(|| Fitted {
                    effects: stand.fitted.effects.clone(),
                    model: model.clone(),
                    parameters,
                    prediction,
                    cost,
                    converged: false,
                    beside: Beside::along(paths),
                })
            })
            .collect();
        starts.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        starts.truncate(LAW_STARTS);
        starts.push(Fitted {
            cost: cost(&stand.fitted.prediction),
            ..stand.fitted.clone()
        });
        starts
    }

    /// What is tried of a cause. Beside a cord that was fitted already the law has come right; where the cord is what is asked for,
    /// all that is elastic may be in it: then the contact is stiff.
    fn tries(&self, cause: usize, own: &[Vec<f64>], laws: &[Fitted], stiff: &[Fitted]) -> Tries {
        let named = &self.stand.fitted;
        let beside_dear = named.effects.iter().any(|&e| is_dear(self.bench, e));
        let mut plenty = own.len();
        let (laws, (fits, steps)): (Vec<&Fitted>, _) = if beside_dear {
            plenty = plenty.min(BESIDE_DEAR);
            (vec![named], DEAR)
        } else if is_dear(self.bench, cause) {
            (laws.iter().take(DEAR_LAWS).chain(stiff).collect(), DEAR)
        } else {
            (laws.iter().collect(), ROUGH)
        };
        Tries {
            cause,
            starts: self.nearest_starts(cause, &laws, &own[..plenty], fits),
            steps,
        }
    }

    /// For each start of the law the cause's own start that brings it nearest to the record; the `most` nearest of all, best first. (Fits
    /// from one start of the law tend to end in one minimum.)
    fn nearest_starts(
        &self,
        cause: usize,
        laws: &[&Fitted],
        own: &[Vec<f64>],
        most: usize,
    ) -> Vec<Vec<f64>> {
        let mut laws = laws.to_vec();
        laws.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let mut nearest: Vec<(f64, Vec<f64>)> = Vec::new();
        for law in laws {
            let enough = nearest.get(most - 1).map_or(f64::INFINITY, |n| n.0);
            // The law's cost is 1/2 |W r|^2.
            if 2.0 * law.cost > OUT_OF_REACH * enough {
                break;
            }
            let beside = |own: &Vec<f64>| extended(self.bench, law, cause, own);
            let Some(with_own) = own.iter().map(beside).collect::<Option<Vec<_>>>() else {
                return Vec::new();
            };
            let (models, starts): (Vec<_>, Vec<_>) = with_own.into_iter().unzip();
            let Some(model) = models.first() else {
                continue;
            };
            let paths = law.paths(self.bench);
            nearest.extend(self.record.nearest(model, starts, paths, enough));
            nearest.sort_by(|a, b| a.0.total_cmp(&b.0));
            nearest.truncate(most);
        }
        nearest.into_iter().map(|(_, start)| start).collect()
    }

    /// The stand's model with a further cause, fitted from a start.
    fn fit(&self, cause: usize, start: &[f64], steps: u64) -> Option<Fitted> {
        let mut effects = self.stand.fitted.effects.clone();
        effects.push(cause);
        self.bench.fit(
            self.subset,
            &effects,
            start,
            self.record.whitener(),
            None,
            steps,
        )
    }

    /// Rough fits carried to their end, each under the noise that its own residual shows.
    ///
    /// The whole campaign's noise is near a fold's; without one the law alone's says nothing. That of the best is near its rivals', and of its
    /// kind: one that is far behind the best there is not asked whether noise of another kind would swallow what it leaves.
    fn finished(
        &self,
        rough: &[(usize, Fitted)],
        found: &Scan,
        warm: Option<&Warm>,
    ) -> Vec<(usize, Stand)> {
        let (bench, subset) = (self.bench, self.subset);
        let to_its_end = |cause: usize, fit: &Fitted| {
            let limit = if is_dear(bench, cause) { 20 } else { 60 };
            self.fit(cause, &fit.parameters, limit)
        };
        let settled = |fit: &Fitted, sizes| {
            let asked = found.with_sizes(sizes).beneath(fit, warm);
            settle(bench, subset, fit, &asked)
        };
        let worth = |cause: usize, stand: &Stand| stand.deviance + search_price(bench, cause);
        let known = warm.map(|w| w.sizes);
        let best = rough.first().and_then(|(cause, fit)| {
            let fit = to_its_end(*cause, fit)?;
            Some((*cause, settled(&fit, known)?))
        });
        let rivals = rough.par_iter().skip(1).filter_map(|(cause, fit)| {
            let fit = to_its_end(*cause, fit)?;
            let Some((first, best)) = &best else {
                return Some((*cause, settled(&fit, known)?));
            };
            let stand = settle_in_kind(bench, subset, &fit, &found.smooth, best.sizes)?;
            let behind = worth(*cause, &stand) - worth(*first, best);
            if behind > FAR_BEHIND {
                return Some((*cause, stand));
            }
            Some((*cause, settled(&stand.fitted, Some(stand.sizes))?))
        });
        let rivals: Vec<(usize, Stand)> = rivals.collect();
        best.into_iter().chain(rivals).collect()
    }

    /// The first fit carried on, and fits from the other starts: the best of them.
    fn fitted_on(&self, first: Fitted, tries: &Tries) -> Fitted {
        let mut best = first.clone();
        let others = tries.starts.iter().skip(1).map(Vec::as_slice);
        for start in std::iter::once(first.parameters.as_slice()).chain(others) {
            let fit = self.fit(tries.cause, start, tries.steps);
            if let Some(fit) = fit.filter(|fit| fit.cost < best.cost) {
                best = fit;
            }
        }
        best
    }
}

/// By cost with parameters paid for, then by place in the catalogue.
fn by_worth(bench: &Bench<'_>, a: (usize, &Fitted), b: (usize, &Fitted)) -> Ordering {
    let worth = |(cause, fit): (usize, &Fitted)| 2.0 * fit.cost + search_price(bench, cause);
    worth(a).total_cmp(&worth(b)).then(a.0.cmp(&b.0))
}

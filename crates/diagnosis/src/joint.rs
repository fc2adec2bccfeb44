//! Joint fits: the law, what is named, and one more cause together.

use std::collections::BTreeSet;

use fitting::noise::Whitener;
use rayon::prelude::*;

use crate::bench::{Bench, Fitted, Limit};
use crate::scan::{Candidate, Scan};
use crate::signatures::extended;
use crate::stand::Stand;
use crate::starts::{ranked, with_laws};
use crate::subset::Subset;

/// Samples, repeats counted once, up to which a mass on a cord is fitted from several starts.
pub(crate) const MOST_SAMPLES_AFRESH: usize = 15_000;

/// Steps of a joint fit, and where such a mass is too dear.
const STEPS: u64 = 20;
const FEW_STEPS: u64 = 8;
/// Lines of a periodic cause from which fits begin, those that score best.
const MOST_LINES_FITTED: usize = 24;
/// Steps of their first fits, and lines that are fitted on, the best of these.
const FIRST_STEPS: u64 = 4;
const LINES_FITTED_ON: usize = 5;

/// Joint fits of the stand's model with each candidate, from the candidate's starts and from what is `known` of it; best first
/// under the stand's noise.
pub(crate) fn joint_fits(
    bench: &Bench<'_>,
    subset: &Subset,
    stand: &Stand,
    candidates: &[&Candidate],
    starts: usize,
    known: &[(usize, Vec<f64>)],
) -> Vec<(usize, Fitted, f64)> {
    let fits: Vec<Option<(usize, Fitted, f64)>> = candidates
        .par_iter()
        .map(|candidate| {
            let joint = Joint {
                bench,
                subset,
                stand,
                candidate,
                whitener: stand.scattered(candidate.score.scatter),
            };
            let (from, limit) = joint.starts(starts, known);
            let (fit, deviance) = joint.best(from, limit)?;
            Some((candidate.cause, fit, deviance))
        })
        .collect();
    let mut fits: Vec<(usize, Fitted, f64)> = fits.into_iter().flatten().collect();
    fits.sort_by(|a, b| {
        price(bench, a)
            .total_cmp(&price(bench, b))
            .then(a.0.cmp(&b.0))
    });
    fits
}

/// A stand's model and one more cause.
struct Joint<'a, 'b> {
    bench: &'a Bench<'b>,
    subset: &'a Subset,
    stand: &'a Stand,
    candidate: &'a Candidate,
    whitener: Whitener,
}

impl Joint<'_, '_> {
    /// Starts of the fit, and its steps.
    fn starts(&self, starts: usize, known: &[(usize, Vec<f64>)]) -> (Vec<Vec<f64>>, u64) {
        let (bench, candidate) = (self.bench, self.candidate);
        if is_dear(bench, candidate.cause) {
            let mut from = self.nearest_about();
            if bench.mechanics() > MOST_SAMPLES_AFRESH {
                from.truncate(1);
                return (from, FEW_STEPS);
            }
            from.extend(self.starts_afresh());
            return (from, STEPS);
        }
        let same = known.iter().filter(|(cause, _)| *cause == candidate.cause);
        // Where one start is not enough, a searched period is begun from many of its lines.
        let searched = starts > 1 && bench.catalogue[candidate.cause].is_periodic();
        let most = if searched { MOST_LINES_FITTED } else { starts };
        let own = candidate.starts.iter().take(most);
        let own = own.chain(same.map(|(_, parameters)| parameters));
        let from = own
            .filter_map(|own| extended(bench, &self.stand.fitted, candidate.cause, own))
            .map(|(_, start)| start);
        (from.collect(), STEPS)
    }

    /// The best fit and its deviance under the stand's noise. Of many starts all are fitted for a few steps, and the best of these on.
    fn best(&self, mut from: Vec<Vec<f64>>, limit: u64) -> Option<(Fitted, f64)> {
        // A cause that does nothing costs no more than this.
        let without = (self.stand.fitted).cost_under(self.bench, self.subset, &self.whitener);
        if from.len() > LINES_FITTED_ON {
            let first = Limit::below(FIRST_STEPS, without);
            let first = self.fits(&from, first).into_iter();
            let on = first.take(LINES_FITTED_ON);
            from = on.map(|(fit, _)| fit.parameters).collect();
        }
        let on = Limit::below(limit, without);
        self.fits(&from, on).into_iter().next()
    }

    /// Fits from these starts, best first.
    fn fits(&self, from: &[Vec<f64>], limit: Limit) -> Vec<(Fitted, f64)> {
        let (bench, subset) = (self.bench, self.subset);
        let mut effects = self.stand.fitted.effects.clone();
        effects.push(self.candidate.cause);
        let fit = |start: &Vec<f64>| {
            let fit = bench.fit(subset, &effects, start, &self.whitener, None, limit)?;
            let deviance = self.stand.deviance_of(bench, subset, &fit);
            Some((fit, deviance))
        };
        let mut fits: Vec<(Fitted, f64)> = from.par_iter().filter_map(fit).collect();
        fits.sort_by(|a, b| a.1.total_cmp(&b.1));
        fits
    }

    /// The starts about the candidate's own that bring the stand's law nearest to the record.
    fn nearest_about(&self) -> Vec<Vec<f64>> {
        const TAKEN: usize = 2;
        let (bench, cause) = (self.bench, self.candidate.cause);
        let Some(own) = self.candidate.starts.first() else {
            return Vec::new();
        };
        let about = bench.catalogue[cause].about(&bench.experiment, own);
        let starts = about
            .iter()
            .filter_map(|own| extended(bench, &self.stand.fitted, cause, own))
            .map(|(_, start)| start);
        self.nearest(starts.collect(), TAKEN)
    }

    /// Starts with the law afresh. The law's own fit takes a cord's stretch for its stiffness and damping and may end in another valley than
    /// the two together: of all of the law's starts those nearest to the data with the cause at its estimated size.
    fn starts_afresh(&self) -> Vec<Vec<f64>> {
        const TAKEN: usize = 3;
        let (bench, fitted) = (self.bench, &self.stand.fitted);
        let own = self.candidate.starts.first();
        let extended = own.and_then(|own| extended(bench, fitted, self.candidate.cause, own));
        let Some((model, at)) = extended else {
            return Vec::new();
        };
        self.nearest(with_laws(&at, bench.law_starts(&model)), TAKEN)
    }

    /// Of these starts those nearest to the record.
    fn nearest(&self, starts: Vec<Vec<f64>>, taken: usize) -> Vec<Vec<f64>> {
        let (bench, fitted) = (self.bench, &self.stand.fitted);
        let mut effects = fitted.effects.clone();
        effects.push(self.candidate.cause);
        let Some(model) = bench.model(&effects) else {
            return Vec::new();
        };
        let paths = fitted.paths(bench);
        let ranked = ranked(bench, self.subset, &self.whitener, &model, starts, paths);
        ranked.into_iter().take(taken).map(|r| r.1).collect()
    }
}

/// Deviance with parameters and, for a searched period, the search paid for.
fn price(bench: &Bench<'_>, fit: &(usize, Fitted, f64)) -> f64 {
    fit.2 + search_price(bench, fit.0)
}

/// What a cause pays for its parameters and, where its period is searched, for the search, which by the clock of the day is hundreds
/// of times finer; a second form of the same cause for
/// not being the plain one.
pub(crate) fn search_price(bench: &Bench<'_>, cause: usize) -> f64 {
    const SEARCH: f64 = 10.0;
    const SECOND_FORM: f64 = 4.0;
    let effect = &bench.catalogue[cause];
    let search = match (effect.is_periodic(), effect.goes_on_between_runs()) {
        (true, false) => SEARCH,
        (true, true) => 2.0 * SEARCH,
        (false, _) => 0.0,
    };
    let form = if is_second_form(bench, cause) {
        SECOND_FORM
    } else {
        0.0
    };
    2.0 * effect.parameters().len() as f64 + search + form
}

/// Whether a cause stands in the catalogue in a plainer form before.
pub(crate) fn is_second_form(bench: &Bench<'_>, cause: usize) -> bool {
    forms_of(bench, cause).next() != Some(cause)
}

/// Every form in which the catalogue has a cause.
pub(crate) fn forms_of<'a>(bench: &'a Bench<'_>, cause: usize) -> impl Iterator<Item = usize> + 'a {
    let id = bench.catalogue[cause].id();
    (0..bench.catalogue.len()).filter(move |&form| bench.catalogue[form].id() == id)
}

/// Candidates that deserve a joint fit: all that pass, and those that come near the best, `most` causes in whatever forms.
pub(crate) fn survivors<'a>(
    bench: &Bench<'_>,
    found: &'a Scan,
    threshold: f64,
    most: usize,
) -> Vec<&'a Candidate> {
    let best = found.candidates.first().map_or(0.0, |c| c.score.z());
    let mut ids: BTreeSet<&str> = BTreeSet::new();
    found
        .candidates
        .iter()
        .enumerate()
        .filter(|(place, c)| {
            let z = c.score.z();
            let near = z > 0.6 * best && (c.log_p < threshold || z > 0.8 * best);
            near && (*place < 2 || !is_dear(bench, c.cause) || z > 0.95 * best)
        })
        .map(|(_, c)| c)
        .take_while(move |c| {
            ids.insert(bench.catalogue[c.cause].id());
            ids.len() <= most
        })
        .collect()
}

/// Whether a cause's mechanics are dear to compute (a mass on a cord).
pub(crate) fn is_dear(bench: &Bench<'_>, cause: usize) -> bool {
    bench.catalogue[cause].reach() == rig::Reach::Coupling
}

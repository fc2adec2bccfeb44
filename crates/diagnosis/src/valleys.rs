//! Other valleys of the law beside a named cause.
//!
//! The law alone bends its Stribeck curve or its stiffness to what a cause does, and the fit of both together begins there: it may
//! end in a valley where the law does half of the cause's work and the cause is too small. Starts of the law that the record
//! suggests, with the cause as it was found and under its noise, are a second way in.

use rayon::prelude::*;

use rig::Paths;

use crate::bench::{Bench, Fitted, Limit};
use crate::joint::{MOST_SAMPLES_AFRESH, is_dear};
use crate::scan::Scan;
use crate::settled::settle;
use crate::stand::Stand;
use crate::starts::{ranked, with_laws};
use crate::subset::Subset;

/// Starts of the law that are fitted: those nearest to the record.
const TAKEN: usize = 6;
/// The same beside dear mechanics.
const TAKEN_DEAR: usize = 3;
/// Steps of each fit.
const STEPS: u64 = 20;
/// Deviance by which another valley must be deeper; fits end that near to a minimum.
const DEEPER: f64 = 1.0;

/// The stand, or one with the same causes whose law is likelier. (A model from elsewhere leaves the law no other valley; long
/// records on a cord would take too long.)
pub(crate) fn deepest(bench: &Bench<'_>, subset: &Subset, stand: Stand) -> Option<Stand> {
    let fitted = &stand.fitted;
    let dear = fitted.effects.iter().any(|&e| is_dear(bench, e));
    if bench.prior.is_some() || dear && bench.mechanics() > MOST_SAMPLES_AFRESH {
        return Some(stand);
    }
    let whitener = stand.likely_noise();
    let starts = with_laws(&fitted.parameters, bench.law_starts(&fitted.model));
    let mut starts = ranked(bench, subset, &whitener, &fitted.model, starts, Paths::NONE);
    starts.truncate(if dear { TAKEN_DEAR } else { TAKEN });
    let limit = Limit::below(STEPS, fitted.cost_under(bench, subset, &whitener));
    let fits: Vec<Option<(f64, Fitted)>> = starts
        .par_iter()
        .map(|(_, start)| {
            let fit = bench.fit(subset, &fitted.effects, start, &whitener, None, limit)?;
            Some((stand.deviance_of(bench, subset, &fit), fit))
        })
        .collect();
    let best = fits
        .into_iter()
        .flatten()
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .filter(|(deviance, _)| *deviance < stand.deviance - DEEPER);
    let Some((_, fit)) = best else {
        return Some(stand);
    };
    let other = settle(bench, subset, &fit, &Scan::empty(bench, Some(stand.sizes)))?;
    Some(if other.deviance < stand.deviance {
        other
    } else {
        stand
    })
}

//! What the protocol cannot separate: for a named cause, every cause whose best imitation of the fitted effect stays
//! within reach of the noise.
//!
//! With d the fitted effect, whitened and cleared of what the law and the other named causes absorb, and S_r a rival's
//! directions in the same coordinates,
//!
//! ```text
//! D_r = min over sizes and shapes |d - S_r a| = |d| sqrt(1 - cos^2)                                        (D3)
//! ```
//!
//! A rival with D_r below 4.7 (d' sqrt(1 - cos^2) < 4.7: two hypotheses told apart in 99 % of cases, 27 causes
//! compared) belongs to the set. The rivals near it are also fitted to the data in the cause's place.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::bench::{Bench, Fitted};
use crate::forms::{in_place, refined_forms};
use crate::ground::{Ground, orthonormal};
use crate::joint::{is_dear, is_second_form, search_price};
use crate::look_back::bare;
use crate::scan::{Ray, Scan, scan_without};
use crate::signatures::extended;
use crate::stand::Stand;
use crate::subset::Subset;
use crate::ways::deviance_of_positions;

/// Distance below which no test separates two causes.
pub(crate) const SEPARABLE: f64 = 4.7;
/// A rival that leaves this share of the effect's length imitates nothing, however short the effect is.
const NO_IMITATION: f64 = 0.9;
/// A fit contradicts a distance D where it loses more than D^2 + 4 D: with the named cause true the loss is spread by 2 D about D^2.
const CONTRADICTED_SPREADS: f64 = 2.0;
/// Loss up to which no fit contradicts a distance. With the rival true, whatever the distance, a loss of 12 comes about in fewer than one
/// campaign in two thousand.
const CONTRADICTED_LEAST: f64 = 12.0;
/// The same for a second form of a cause: a more special assumption is held to what the data say of it. One in six hundred of one
/// parameter more.
const CONTRADICTED_FORM: f64 = 10.0;
/// Loss up to which a rival is as good as the named cause: odds of one in seven. Of two causes 4.7 apart the right one wins by less in
/// three campaigns of a hundred.
pub(crate) const AS_GOOD: f64 = 4.0;
/// Starts and steps of a rival's fit.
const RIVAL_FITS: (usize, u64) = (3, 12);
/// Rivals with distances up to this are fitted to the data.
const NEAR: f64 = 8.0;

/// A rival of a named cause.
#[derive(Clone)]
pub(crate) struct Opponent {
    pub(crate) cause: usize,
    /// Whether the catalogue has it in a plainer form too.
    second_form: bool,
    /// D_r of (D3).
    pub(crate) separation: f64,
    /// -2 log likelihood of the campaign with the rival in the cause's place less that with the cause,
    pub(crate) excess_deviance: f64,
    /// and what of it the recorded positions say (P1).
    of_the_positions: f64,
    /// Deviance by which roughness speaks for a filter, where the rival is one and the cause is none: it has passed one.
    seen_in_roughness: f64,
    /// What the rival pays for its parameters and its search (a searched period) beyond what the cause pays.
    charge: f64,
    /// The fit with the rival, where one was made.
    pub(crate) fitted: Option<Fitted>,
}

impl Opponent {
    /// What the campaign loses with the rival in the cause's place, parameters and search paid for; infinite where it was not fitted.
    pub(crate) fn loss(&self) -> f64 {
        self.excess_deviance + self.charge
    }
}

/// A named cause against the catalogue.
pub(crate) struct Contest {
    /// Deviance that the cause saves when it comes last.
    pub(crate) saved: f64,
    /// |d| of (D3).
    pub(crate) length: f64,
    /// Rivals, nearest first.
    pub(crate) opponents: Vec<Opponent>,
}

impl Contest {
    /// Causes that cannot be told from the named one.
    pub(crate) fn tied(&self) -> Vec<usize> {
        self.alike(|_| 0.0)
    }

    /// Causes that the force alone cannot tell from the named one.
    pub(crate) fn tied_in_force(&self) -> Vec<usize> {
        self.alike(|o| o.of_the_positions)
    }

    /// Causes that cannot be told from the named one by what is left of the evidence when this is taken off.
    fn alike(&self, apart: impl Fn(&Opponent) -> f64) -> Vec<usize> {
        let reach = SEPARABLE.min(NO_IMITATION * self.length);
        // A signature knows neither bounds nor signs: what was fitted in the cause's place and fits far worse is no imitation.
        let fails = |o: &Opponent| {
            let most = if o.second_form {
                CONTRADICTED_FORM
            } else {
                let spread = 2.0 * o.separation;
                (o.separation.powi(2) + CONTRADICTED_SPREADS * spread).max(CONTRADICTED_LEAST)
            };
            // Nor does the fit of a delay refute a filter that roughness has passed, unless it says more than roughness does.
            o.excess_deviance.is_finite()
                && o.excess_deviance - apart(o) - o.seen_in_roughness > most
        };
        // What came as near to the record belongs to the set, however far apart the protocol should hold the two.
        let as_good = |o: &Opponent| o.loss() - apart(o) < AS_GOOD;
        self.opponents
            .iter()
            .filter(|o| o.separation < reach && !fails(o) || as_good(o))
            .map(|o| o.cause)
            .collect()
    }
}

/// Sets the k-th effect of a fitted model against all other causes.
pub(crate) fn contest(
    bench: &Bench<'_>,
    subset: &Subset,
    stand: &Stand,
    first: &Scan,
    k: usize,
) -> Option<Contest> {
    let full = &stand.fitted;
    let scatter = stand.ground.likeliest_scatter();
    let bare = bare(bench, full, k)?;
    let beside = Stand::new(bench, subset, bare, stand.sizes);
    // A rival that imitates the effect would have scored beside the law alone nearly as well as the cause itself.
    let best = first.candidates.first().map_or(0.0, |c| c.score.z());
    let skipped: Vec<usize> = first
        .candidates
        .iter()
        .filter(|c| {
            is_dear(bench, c.cause)
                && full.effects.len() == 1
                && best > 5.0
                && c.score.z() < 0.3 * best
        })
        .map(|c| c.cause)
        .collect();
    let found = scan_without(bench, subset, &beside, scatter, &skipped);
    let effect = DMatrix::from_iterator(
        bench.samples.len(),
        1,
        full.prediction
            .iter()
            .zip(&beside.fitted.prediction)
            .map(|(a, b)| a - b),
    );
    let white = beside.whiten(subset, &effect);
    let projected = beside.ground.project_vector(&white.column(0).into_owned());
    let length = beside.ground.distance(&projected, scatter);
    let own = full.effects[k];
    let filters = |cause: usize| bench.catalogue[cause].filters_force();
    let late = subset.lateness();
    let passed = if late.lag_s > 0.0 && !full.effects.iter().any(|&e| filters(e)) {
        let delayed = subset.late_by(late.unfiltered());
        (stand.deviance_with(bench, &delayed, stand.sizes) - stand.deviance).max(0.0)
    } else {
        0.0
    };
    let mut opponents: Vec<Opponent> = Vec::new();
    for candidate in &found.candidates {
        if bench.catalogue[candidate.cause].id() == bench.catalogue[own].id() {
            continue;
        }
        let separation = nearest(
            &beside.ground,
            &found.rays,
            candidate.cause,
            &projected,
            scatter,
        )
        .unwrap_or(length);
        opponents.push(Opponent {
            cause: candidate.cause,
            second_form: is_second_form(bench, candidate.cause),
            separation,
            excess_deviance: f64::INFINITY,
            of_the_positions: 0.0,
            seen_in_roughness: if filters(candidate.cause) {
                passed
            } else {
                0.0
            },
            charge: search_price(bench, candidate.cause) - search_price(bench, own),
            fitted: None,
        });
    }
    let whitener = stand.scattered(scatter);
    let positions = |fit: &Fitted| deviance_of_positions(bench, fit);
    let checked: Vec<Opponent> = opponents
        .into_par_iter()
        .map(|mut opponent| {
            let candidate = found.candidates.iter().find(|c| c.cause == opponent.cause);
            if opponent.separation < NEAR
                && let Some(candidate) = candidate
                && let Some((fit, excess)) =
                    replace(bench, subset, stand, &beside, candidate, &whitener)
            {
                opponent.of_the_positions = positions(&fit) - positions(full);
                opponent.excess_deviance = excess + opponent.of_the_positions;
                opponent.fitted = Some(fit);
            }
            opponent
        })
        .collect();
    let mut opponents = checked;
    opponents.extend(mistaken(bench, subset, stand, &beside, k));
    opponents.sort_by(|a, b| {
        a.separation
            .total_cmp(&b.separation)
            .then(a.cause.cmp(&b.cause))
    });
    let start = beside.fitted.parameters.clone();
    let saved = bench
        .fit(subset, &beside.fitted.effects, &start, &whitener, None, 20)
        .map_or(length * length, |fit| {
            stand.deviance_of(bench, subset, &fit) - stand.deviance
        });
    Some(Contest {
        saved,
        length,
        opponents,
    })
}

/// The refined forms of other causes that the k-th may be mistaken for and that have no more parameters (with one more they may hold the cause as a
/// limit), fitted in its place; each as far from it as the two fits are apart.
fn mistaken(
    bench: &Bench<'_>,
    subset: &Subset,
    stand: &Stand,
    beside: &Stand,
    k: usize,
) -> Vec<Opponent> {
    let full = &stand.fitted;
    let own = full.effects[k];
    let scatter = stand.ground.likeliest_scatter();
    let others = refined_forms(bench, own).filter(|&form| {
        let (form, own) = (&bench.catalogue[form], &bench.catalogue[own]);
        form.id() != own.id() && form.parameters().len() <= own.parameters().len()
    });
    let fitted = others.filter_map(|form| {
        let starts = bench.catalogue[form].starts(&bench.experiment);
        let (deviance, fit) = in_place(bench, subset, stand, (k, form), &starts, None)?;
        let apart = full.prediction.iter().zip(&fit.prediction);
        let apart = apart.map(|(a, b)| a - b);
        let apart = DMatrix::from_iterator(full.prediction.len(), 1, apart);
        let white = beside.whiten(subset, &apart).column(0).into_owned();
        let ground = &beside.ground;
        let separation = ground.distance(&ground.project_vector(&white), scatter);
        let of_the_positions =
            deviance_of_positions(bench, &fit) - deviance_of_positions(bench, full);
        Some(Opponent {
            cause: form,
            second_form: true,
            separation,
            excess_deviance: deviance - stand.deviance + of_the_positions,
            of_the_positions,
            seen_in_roughness: 0.0,
            charge: search_price(bench, form) - search_price(bench, own),
            fitted: Some(fit),
        })
    });
    fitted.collect()
}

/// Fits the rival to the data in the cause's place.
fn replace(
    bench: &Bench<'_>,
    subset: &Subset,
    stand: &Stand,
    beside: &Stand,
    candidate: &crate::scan::Candidate,
    whitener: &fitting::noise::Whitener,
) -> Option<(Fitted, f64)> {
    let mut effects = beside.fitted.effects.clone();
    effects.push(candidate.cause);
    let (most, steps) = RIVAL_FITS;
    candidate
        .starts
        .iter()
        .take(most)
        .filter_map(|own| {
            let (_, start) = extended(bench, &beside.fitted, candidate.cause, own)?;
            let fit = bench.fit(subset, &effects, &start, whitener, None, steps)?;
            let excess = stand.deviance_of(bench, subset, &fit) - stand.deviance;
            Some((fit, excess))
        })
        .min_by(|a, b| a.1.total_cmp(&b.1))
}

/// The smallest distance (D3) over a rival's rays.
fn nearest(
    ground: &Ground,
    rays: &[Ray],
    cause: usize,
    effect: &DVector<f64>,
    scatter: f64,
) -> Option<f64> {
    let n = effect.len();
    let flat = ground.descatter(
        &DMatrix::from_column_slice(n, 1, effect.as_slice()),
        scatter,
    );
    let flat: DVector<f64> = flat.column(0).into_owned();
    rays.iter()
        .filter(|ray| ray.cause == cause)
        .map(|ray| {
            let (basis, back) =
                orthonormal(&ground.descatter(&ray.direction.columns, scatter), 1e-6);
            let size = back * basis.tr_mul(&flat);
            // The best imitation, subtracted before the scatter's root: what is left keeps its share between runs.
            let left = effect - &ray.direction.columns * size;
            ground.distance(&left, scatter)
        })
        .min_by(f64::total_cmp)
}

/// Orthonormal columns of each of a cause's rays, the scatter between runs whitened too: plain inner products hold between them.
pub(crate) fn flattened(
    ground: &Ground,
    rays: &[Ray],
    cause: usize,
    scatter: f64,
) -> Vec<DMatrix<f64>> {
    rays.iter()
        .filter(|ray| ray.cause == cause)
        .map(|ray| orthonormal(&ground.descatter(&ray.direction.columns, scatter), 1e-6).0)
        .filter(|columns| columns.ncols() > 0)
        .collect()
}

/// Sine of the angle between two causes' nearest rays, given flattened; `None` where one has none.
pub(crate) fn sine(left: &[DMatrix<f64>], right: &[DMatrix<f64>]) -> Option<f64> {
    let pairs = left.iter().flat_map(|x| right.iter().map(move |y| (x, y)));
    pairs
        .map(|(x, y)| {
            let cosine = x.tr_mul(y).singular_values().max().min(1.0);
            (1.0 - cosine * cosine).sqrt()
        })
        .min_by(f64::total_cmp)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether a rival 1.4 away that fits worse by 32 belongs to the set, roughness speaking so much for it.
    fn is_tied(seen_in_roughness: f64) -> bool {
        let opponent = Opponent {
            cause: 3,
            second_form: false,
            separation: 1.4,
            excess_deviance: 32.0,
            of_the_positions: 0.0,
            seen_in_roughness,
            charge: 0.0,
            fitted: None,
        };
        let contest = Contest {
            saved: 400.0,
            length: 20.0,
            opponents: vec![opponent],
        };
        contest.tied() == [3]
    }

    #[test]
    fn a_filter_that_roughness_has_passed_is_not_refuted_by_a_fit_that_says_less() {
        assert!(!is_tied(0.0));
        assert!(!is_tied(15.0));
        assert!(is_tied(30.0));
    }
}

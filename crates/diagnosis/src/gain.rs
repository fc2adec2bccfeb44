//! What an extension gains on runs that it has not seen.
//!
//! Each fold leaves out one run of every repeated condition; richer campaigns also leave out each whole condition.
//! Noise, selection and extension are done again in every fold; a held-out run keeps its commands and its place in the
//! day and hides its force. Squared errors are pooled over folds:
//!
//! ```text
//! explained = (before^2 - after^2) / (before^2 - floor^2)                                              (D4)
//! ```
//!
//! with an interval from the differences between runs (Student's t over runs), and a placebo: the fitted effect with
//! its course along each run scrambled, fitted and judged in the same folds.
//!
//! The noise in the squared errors is not the floor's but what these runs happened to draw: the scatter of each run, and the
//! plate's roughness, which repeats and is in no floor from repeats. Where that may move (D4) by more than a tenth, no share is
//! stated; where less, it widens the interval.

use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use crate::answer::Gain;
use crate::bench::Bench;
use crate::floor;
use crate::ground::orthonormal;
use crate::intervals::student;
use crate::look_back::without;
use crate::selection::{Depth, Selected, Warm, law_alone, select};
use crate::subset::Subset;
use crate::whole::Whole;

/// Scrambled extensions that a gain must beat.
const PLACEBOS: usize = 19;
/// Conditions that are left out as a whole: at most this many, the first of the campaign.
const WHOLE_CONDITIONS: usize = 3;
/// Folds over repeats, at most.
const MOST_FOLDS: usize = 12;

/// Outcome of one fold.
struct Fold {
    held: Vec<usize>,
    /// Predictions for all recorded samples: law alone, and with what the fold selected.
    law: Vec<f64>,
    extended: Vec<f64>,
    /// The law's prediction on the record that was searched, beside which the placebos stand.
    searched: Vec<f64>,
    /// For each named cause: the extended model without it, where the fold named it.
    lacking: Vec<Option<Vec<f64>>>,
    /// Predictions with each scrambled extension.
    placebos: Vec<Vec<f64>>,
}

/// Gains of all findings together and of each when it comes last.
pub(crate) struct Gains {
    pub(crate) held_out_law: f64,
    pub(crate) joint: Option<Gain>,
    pub(crate) each: Vec<Option<Gain>>,
}

/// Runs left out, fold by fold.
fn folds(bench: &Bench<'_>) -> Vec<Vec<usize>> {
    let mut folds = merged(identification::folds(bench.campaign));
    let conditions = bench.campaign.conditions();
    if conditions.len() > 2 {
        folds.extend(
            conditions
                .into_iter()
                .filter(|c| 2 * c.len() < bench.samples.runs.len())
                .take(WHOLE_CONDITIONS),
        );
    }
    if folds.is_empty() && bench.samples.runs.len() > 2 {
        // No repeats: each run in turn, at most six.
        folds = (0..bench.samples.runs.len().min(6))
            .map(|k| vec![k])
            .collect();
    }
    folds
}

/// At most [`MOST_FOLDS`] folds: with more repeats each leaves out several runs of a condition.
fn merged(folds: Vec<Vec<usize>>) -> Vec<Vec<usize>> {
    if folds.len() <= MOST_FOLDS {
        return folds;
    }
    let mut few = vec![Vec::new(); MOST_FOLDS];
    for (k, fold) in folds.into_iter().enumerate() {
        few[k % MOST_FOLDS].extend(fold);
    }
    few
}

/// Judges a selection by folds; `None` where no run can be left out.
///
/// `ties`: for each named cause, the causes that cannot be told from it: a fold that takes one of them in has found it.
pub(crate) fn judge(
    bench: &Bench<'_>,
    whole: &Whole<'_>,
    selected: &Selected,
    ties: &[Vec<usize>],
    floor_rmse: f64,
) -> Option<Gains> {
    let folds = folds(whole.bench);
    if folds.is_empty() {
        return None;
    }
    let extended = &selected.stand.fitted;
    let warm = selected.warm();
    let named: Vec<Vec<usize>> = (0..extended.effects.len())
        .map(|k| {
            let tied = ties.get(k).into_iter().flatten().copied();
            std::iter::once(extended.effects[k]).chain(tied).collect()
        })
        .collect();
    let scrambled = scrambled(bench, selected);
    let done: Vec<Option<Fold>> = folds
        .par_iter()
        .map(|held| fold(bench, whole, held, &warm, &named, &scrambled))
        .collect();
    let done: Vec<Fold> = done.into_iter().flatten().collect();
    if done.is_empty() {
        return None;
    }
    let law = Errors::pool(whole.bench, &done, |f| &f.law);
    let extended = Errors::pool(whole.bench, &done, |f| &f.extended);
    let searched = Errors::pool(bench, &done, |f| &f.searched).total();
    let placebo: Vec<f64> = (0..scrambled.len())
        .map(|p| searched - Errors::pool(bench, &done, |f| &f.placebos[p]).total())
        .collect();
    let drawn = Drawn::by(whole, selected, &done);
    let joint = (!named.is_empty()).then(|| gain(&law, &extended, floor_rmse, &drawn, &placebo));
    let each = (0..named.len())
        .map(|k| {
            let lacking = Errors::pool(whole.bench, &done, |f| {
                f.lacking[k].as_ref().unwrap_or(&f.extended)
            });
            Some(gain(&lacking, &extended, floor_rmse, &drawn, &placebo))
        })
        .collect();
    Some(Gains {
        held_out_law: law.rmse(),
        joint,
        each,
    })
}

fn fold(
    bench: &Bench<'_>,
    whole: &Whole<'_>,
    held: &[usize],
    warm: &Warm,
    named: &[Vec<usize>],
    scrambled: &[Vec<f64>],
) -> Option<Fold> {
    let kept: Vec<usize> = (0..bench.samples.runs.len())
        .filter(|k| !held.contains(k))
        .collect();
    let subset = Subset::new(bench, kept);
    if named.is_empty() {
        // Nothing is named, nothing is gained: only the law's own error is asked for.
        let law = law_alone(bench, &subset, Some(warm))?.fitted;
        let prediction = whole.prediction(&law);
        return Some(Fold {
            held: held.to_vec(),
            extended: prediction.clone(),
            law: prediction,
            searched: law.prediction,
            lacking: Vec::new(),
            placebos: Vec::new(),
        });
    }
    let own = select(bench, &subset, Depth::Fold, Some(warm))?;
    let subset = &own.subset;
    let full = &own.stand.fitted;
    let lacking = named
        .iter()
        .map(|cause| {
            let k = full.effects.iter().position(|e| cause.contains(e))?;
            let mut rest = full.effects.clone();
            rest.remove(k);
            if rest.is_empty() {
                return Some(whole.prediction(&own.baseline.fitted));
            }
            let context = subset.context_of(bench, full);
            let whitener = own
                .stand
                .whitener
                .with_scatter(&context, own.stand.sizes.scatter);
            bench
                .fit(subset, &rest, &without(full, k), &whitener, None, 12)
                .map(|fit| whole.prediction(&fit))
        })
        .collect();
    let base = &own.baseline;
    let (basis, back) = orthonormal(&base.white_jacobian, 1e-9);
    let placebos = scrambled
        .iter()
        .map(|effect| {
            // Linear fit of the scrambled effect with the law's own directions.
            let raw = DMatrix::from_column_slice(effect.len(), 1, effect);
            let white: DVector<f64> = base.whiten(subset, &raw).column(0).into_owned();
            let along = basis.tr_mul(&white);
            let free = &white - &basis * &along;
            let power = free.norm_squared().max(1e-300);
            let size = free.dot(&base.ground.y) / power;
            let shift = &base.jacobian * (&back * along);
            base.fitted
                .prediction
                .iter()
                .zip(effect)
                .zip(shift.iter())
                .map(|((p, e), j)| p + size * (e - j))
                .collect()
        })
        .collect();
    Some(Fold {
        held: held.to_vec(),
        law: whole.prediction(&base.fitted),
        extended: whole.prediction(full),
        searched: base.fitted.prediction.clone(),
        lacking,
        placebos,
    })
}

/// The fitted effects with their course along each run shifted round and their sign drawn, from fixed seeds.
fn scrambled(bench: &Bench<'_>, selected: &Selected) -> Vec<Vec<f64>> {
    if selected.stand.fitted.effects.is_empty() {
        return Vec::new();
    }
    let effect: Vec<f64> = selected
        .stand
        .fitted
        .prediction
        .iter()
        .zip(&selected.baseline.fitted.prediction)
        .map(|(a, b)| a - b)
        .collect();
    (0..PLACEBOS)
        .map(|p| {
            let mut rng = ChaCha8Rng::seed_from_u64(0x0b1a_5eed + p as u64);
            let mut out = effect.clone();
            for run in &bench.samples.runs {
                let n = run.len();
                let shift = rng.random_range(n / 10..n.max(n / 10 + 1));
                let sign = if rng.random::<f64>() < 0.5 { -1.0 } else { 1.0 };
                for (place, i) in run.clone().enumerate() {
                    out[i] = sign * effect[run.start + (place + shift) % n];
                }
            }
            out
        })
        .collect()
}

/// Squared errors of held-out runs.
struct Errors {
    /// Sum of squares and samples of each held-out run.
    runs: Vec<(f64, f64)>,
}

impl Errors {
    fn pool<'f>(
        bench: &Bench<'_>,
        folds: &'f [Fold],
        prediction: impl Fn(&'f Fold) -> &'f Vec<f64>,
    ) -> Self {
        let runs = folds
            .iter()
            .flat_map(|f| {
                let predicted = prediction(f);
                f.held
                    .iter()
                    .map(|&k| floor::squares(bench, predicted, Some(&[k])))
                    .collect::<Vec<_>>()
            })
            .filter(|(_, n)| *n > 0.0)
            .collect();
        Self { runs }
    }

    fn total(&self) -> f64 {
        self.runs.iter().map(|r| r.0).sum()
    }

    fn count(&self) -> f64 {
        self.runs.iter().map(|r| r.1).sum::<f64>().max(1.0)
    }

    fn rmse(&self) -> f64 {
        (self.total() / self.count()).sqrt()
    }
}

/// What the noise in held-out squared errors may have drawn beside the floor.
struct Drawn {
    /// Sum of squares of the plate's roughness.
    plate: f64,
    /// Standard deviation of the sum of squares of the scatter between runs.
    scatter_sd: f64,
}

impl Drawn {
    /// By the sizes of the noise beside the named causes. A run that is held out by several folds drew once.
    fn by(whole: &Whole<'_>, selected: &Selected, folds: &[Fold]) -> Self {
        let sizes = selected.stand.sizes;
        let prediction = &whole.extended.prediction;
        let mut plate = 0.0;
        let mut variance = 0.0;
        for run in 0..whole.bench.samples.runs.len() {
            let times = folds.iter().filter(|f| f.held.contains(&run)).count();
            let force = times as f64 * floor::force_squares(whole.bench, prediction, run);
            plate += sizes.plate.powi(2) * force;
            // var(s^2 chi^2_1) = 2 s^4
            variance += 2.0 * (sizes.scatter.powi(2) * force).powi(2);
        }
        Self {
            plate,
            scatter_sd: variance.sqrt(),
        }
    }
}

/// Share of the denominator of (D4) by which it may be wrong where a share is still stated.
const KNOWN_TO: f64 = 0.1;

fn gain(before: &Errors, after: &Errors, floor_rmse: f64, drawn: &Drawn, placebo: &[f64]) -> Gain {
    let count = before.count();
    let floor = count * floor_rmse * floor_rmse;
    let explainable = before.total() - floor;
    let dropped = before.total() - after.total();
    // Paired differences between runs: their mean's error, studentised.
    let differences: Vec<f64> = before
        .runs
        .iter()
        .zip(&after.runs)
        .map(|(b, a)| b.0 - a.0)
        .collect();
    let n = differences.len() as f64;
    let mean = differences.iter().sum::<f64>() / n;
    let variance = differences.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
    let error = (n * variance).sqrt();
    // The noise that was drawn is no more than what is left with the extension, and the floor has drawn as well.
    let left = (after.total() - floor).max(0.0);
    let by_noise = drawn.plate + 2.0 * std::f64::consts::SQRT_2 * drawn.scatter_sd;
    let unknown = left.min(by_noise);
    let known = explainable > 0.0 && unknown < KNOWN_TO * explainable;
    let fraction = known.then(|| dropped / explainable);
    let ci95 = (known && n > 1.0).then(|| {
        let share = dropped / explainable;
        let half = (student(n - 1.0) * error).hypot(share * unknown) / explainable;
        [share - half, share + half]
    });
    let beaten = placebo.iter().filter(|p| dropped > **p).count();
    Gain {
        held_out_rmse_before: before.rmse(),
        held_out_rmse_after: after.rmse(),
        explained_fraction: fraction,
        ci95,
        placebo_exceeded: (!placebo.is_empty()).then(|| beaten as f64 / placebo.len() as f64),
    }
}

//! The scan: every cause of the catalogue asked, by a score test, whether it is seen beside the fitted model.
//!
//! A cause's signature is the derivative of the prediction with respect to its sizes at zero, for every shape (time
//! constant, wavelength) on a grid, and, because some causes are far from linear, the chord to a plausible size. All
//! shapes of a cause pay together for the search by the length of the path that their signatures draw.

use std::sync::Arc;

use fitting::noise::Sizes;
use nalgebra::{DMatrix, DVectorView};
use rayon::prelude::*;

use crate::asked::{Task, Tasks, tasks};
use crate::bench::{Bench, Fitted};
use crate::ground::{Direction, Score, angle, look_elsewhere};
use crate::joint::is_second_form;
use crate::peaks::Peaks;
use crate::selection::Warm;
use crate::signatures::{Signature, Signatures, chord, tangent};
use crate::stand::Stand;
use crate::subset::Subset;

/// A cause with the shape at which it scores best.
#[derive(Clone)]
pub(crate) struct Candidate {
    /// Place in the catalogue.
    pub(crate) cause: usize,
    /// Parameters of the cause from which a joint fit starts, best first.
    pub(crate) starts: Vec<Vec<f64>>,
    pub(crate) score: Score,
    /// Logarithm of the tail probability, the search over shapes paid for.
    pub(crate) log_p: f64,
    /// Size of the first size parameter for one unit of the score's coefficients.
    pub(crate) unit: f64,
}

/// A cause's signature, whitened and projected.
pub(crate) struct Ray {
    pub(crate) cause: usize,
    at: Vec<f64>,
    chord: Option<Vec<f64>>,
    pub(crate) direction: Direction,
}

impl Ray {
    /// Reported size of the first size parameter for one unit along the ray.
    pub(crate) fn unit_size(&self, bench: &Bench<'_>) -> f64 {
        let first = bench.catalogue[self.cause].sizes()[0];
        self.chord.as_ref().map_or(1.0, |c| c[first])
    }
}

/// What a scan found.
pub(crate) struct Scan {
    /// One entry a cause, smallest tail probability first.
    pub(crate) candidates: Vec<Candidate>,
    /// All rays, for separations.
    pub(crate) rays: Vec<Ray>,
    /// Number of different causes that were asked.
    pub(crate) asked: usize,
    /// Raw columns of the causes without a period, for the noise's mean.
    pub(crate) smooth: DMatrix<f64>,
    /// Causes whose signature the law absorbs.
    pub(crate) absorbed: Vec<usize>,
    /// Sizes of the noise under which it was made.
    pub(crate) sizes: Option<Sizes>,
    /// Whether the kind of the noise to be searched is theirs: what nearly the same data have decided.
    pub(crate) of_their_kind: bool,
    /// The signatures that were asked, for scans beside fits that are nearly the same.
    pub(crate) signatures: Option<Arc<Signatures>>,
}

impl Scan {
    /// A scan that asks nothing.
    pub(crate) fn empty(bench: &Bench<'_>, sizes: Option<Sizes>) -> Self {
        Self {
            candidates: Vec::new(),
            rays: Vec::new(),
            asked: 0,
            smooth: DMatrix::zeros(bench.samples.len(), 0),
            absorbed: Vec::new(),
            sizes,
            of_their_kind: false,
            signatures: None,
        }
    }
}

impl Scan {
    /// Tail probability of a cause as the scan saw it.
    pub(crate) fn log_p_of(&self, cause: usize) -> f64 {
        let own = self.candidates.iter().find(|c| c.cause == cause);
        own.map_or(0.0, |c| c.log_p)
    }

    /// Candidates that scored next to nothing: less than a share of what the best did.
    pub(crate) fn dull(&self) -> impl Iterator<Item = usize> + '_ {
        /// Of the best score.
        const SHARE: f64 = 0.2;
        let best = self.candidates.first().map_or(0.0, |c| c.score.z());
        let dull = self.candidates.iter();
        dull.filter(move |c| c.score.z() < SHARE * best)
            .map(|c| c.cause)
    }

    /// The same scan for the noise beneath a fit: searched from where another selection has ended with the fit's causes, if it has, and of the
    /// kind that it has found.
    pub(crate) fn beneath(&self, fit: &Fitted, warm: Option<&Warm>) -> Self {
        let known = warm.and_then(|warm| warm.sizes_beneath(fit));
        Self {
            of_their_kind: known.is_some(),
            ..self.with_sizes(known.or(self.sizes))
        }
    }

    /// The same scan for a noise that is to be searched from other sizes (`None`: from scratch).
    pub(crate) fn with_sizes(&self, sizes: Option<Sizes>) -> Self {
        Self {
            candidates: Vec::new(),
            rays: Vec::new(),
            asked: self.asked,
            smooth: self.smooth.clone(),
            absorbed: Vec::new(),
            sizes,
            of_their_kind: false,
            signatures: None,
        }
    }
}

/// Index of a periodic cause's shape parameter, and whether its period is in time.
pub(crate) fn period(bench: &Bench<'_>, cause: usize) -> Option<(usize, bool)> {
    let effect = &bench.catalogue[cause];
    let specs = effect.parameters_for(&bench.experiment);
    let shape = (0..specs.len()).find(|i| !effect.sizes().contains(i))?;
    Some((shape, specs[shape].name.ends_with("_hz")))
}

/// Frequency of a periodic cause at given parameters.
fn frequency(bench: &Bench<'_>, cause: usize, at: &[f64]) -> Option<f64> {
    if !bench.catalogue[cause].is_periodic() {
        return None;
    }
    let (shape, in_time) = period(bench, cause)?;
    Some(if in_time {
        at[shape]
    } else {
        at[shape].recip()
    })
}

/// Scans the catalogue beside a fitted model; causes in the model are left out.
pub(crate) fn scan(bench: &Bench<'_>, subset: &Subset, stand: &Stand, scatter: f64) -> Scan {
    scan_without(bench, subset, stand, scatter, &[])
}

/// The same without some causes.
pub(crate) fn scan_without(
    bench: &Bench<'_>,
    subset: &Subset,
    stand: &Stand,
    scatter: f64,
    skipped: &[usize],
) -> Scan {
    scan_knowing(bench, subset, stand, scatter, skipped, &[])
}

/// The same with signatures that may be known already.
pub(crate) fn scan_knowing(
    bench: &Bench<'_>,
    subset: &Subset,
    stand: &Stand,
    scatter: f64,
    skipped: &[usize],
    known: &[Arc<Signatures>],
) -> Scan {
    let peaks = Peaks::find(bench, subset, stand, scatter, skipped);
    scan_with(bench, subset, stand, &peaks, skipped, known)
}

/// One periodic cause at the lines of the residual and at the neighbours of one.
pub(crate) fn scan_period(
    bench: &Bench<'_>,
    subset: &Subset,
    stand: &Stand,
    scatter: f64,
    cause: usize,
    at: &[f64],
) -> Scan {
    let others: Vec<usize> = (0..bench.catalogue.len()).filter(|&c| c != cause).collect();
    let mut peaks = Peaks::find(bench, subset, stand, scatter, &others);
    if let Some(frequency) = frequency(bench, cause, at) {
        peaks = peaks.with_neighbours(bench, cause, frequency);
    }
    scan_with(bench, subset, stand, &peaks, &others, &[])
}

/// The signatures of all causes where there is no residual to search: periods in the middle of their range.
pub(crate) fn scan_nominal(
    bench: &Bench<'_>,
    subset: &Subset,
    stand: &Stand,
    scatter: f64,
) -> Scan {
    let peaks = Peaks::find(bench, subset, stand, scatter, &[]).with_periods(bench, 20.0);
    scan_with(bench, subset, stand, &peaks, &[], &[])
}

/// Raw columns of the causes without a period beside a fit, one tangent each: what the noise's mean may hold. `known`: signatures that may serve.
pub(crate) fn smooth_beside(
    bench: &Bench<'_>,
    fitted: &Fitted,
    known: &[Arc<Signatures>],
) -> DMatrix<f64> {
    if let Some(known) = known.iter().find(|known| known.serve(fitted)) {
        return smooth_columns(bench, known.all());
    }
    let tasks: Vec<Task> = tasks(bench, fitted, &Peaks::none(), &[])
        .tasks
        .into_iter()
        .filter(|(cause, _, is_chord)| {
            let plain = !is_second_form(bench, *cause);
            !is_chord && plain && !bench.catalogue[*cause].is_periodic()
        })
        .collect();
    // A cause's further shapes are only asked where its first has no finite tangent.
    let groups: Vec<&[Task]> = tasks.chunk_by(|a, b| a.0 == b.0).collect();
    let found: Vec<Option<Arc<Signature>>> = groups
        .par_iter()
        .map(|group| {
            group
                .iter()
                .find_map(|(cause, at, _)| tangent(bench, fitted, *cause, at))
                .map(Arc::new)
        })
        .collect();
    let signatures: Vec<Arc<Signature>> = found.into_iter().flatten().collect();
    smooth_columns(bench, &signatures)
}

fn scan_with(
    bench: &Bench<'_>,
    subset: &Subset,
    stand: &Stand,
    peaks: &Peaks,
    skipped: &[usize],
    known: &[Arc<Signatures>],
) -> Scan {
    let fitted = &stand.fitted;
    let known = known.iter().find(|known| known.serve(fitted));
    let Tasks {
        tasks,
        paths,
        shifts,
    } = tasks(bench, fitted, peaks, skipped);
    let signature = |(cause, at, is_chord): &Task| {
        if let Some(known) = known.and_then(|known| known.of(*cause, at, *is_chord)) {
            return Some(Arc::clone(known));
        }
        let asked = if *is_chord { chord } else { tangent };
        asked(bench, fitted, *cause, at).map(Arc::new)
    };
    let signatures: Vec<Option<Arc<Signature>>> = tasks.par_iter().map(signature).collect();
    let signatures: Vec<Arc<Signature>> = signatures.into_iter().flatten().collect();
    let smooth = smooth_columns(bench, &signatures);
    let white = white_signatures(subset, stand, &signatures);
    let rays: Vec<Option<(Ray, Score)>> = signatures
        .par_iter()
        .zip(white)
        .map(|(signature, white)| {
            let direction = stand.ground.direction(&white)?;
            let background = frequency(bench, signature.cause, &signature.at)
                .map_or(1.0, |f| peaks.background(signature.cause, f));
            let score = stand.ground.score(&direction).over(background);
            Some((
                Ray {
                    cause: signature.cause,
                    at: signature.at.clone(),
                    chord: signature.chord.clone(),
                    direction,
                },
                score,
            ))
        })
        .collect();
    let rays: Vec<(Ray, Score)> = rays.into_iter().flatten().collect();
    let mut found = collect(bench, rays, &tasks, &paths, smooth);
    found.absorbed.extend(shifts);
    found.sizes = Some(stand.sizes);
    found.signatures = Some(Arc::new(Signatures::beside(fitted, signatures)));
    found
}

/// Whitened columns of each signature. Whitening several columns side by side costs little more than one: all signatures go
/// through it together.
fn white_signatures(
    subset: &Subset,
    stand: &Stand,
    signatures: &[Arc<Signature>],
) -> Vec<DMatrix<f64>> {
    let columns: Vec<DVectorView<'_, f64>> = signatures
        .iter()
        .flat_map(|signature| signature.columns.column_iter())
        .collect();
    if columns.is_empty() {
        return Vec::new();
    }
    let white = stand.whiten(subset, &DMatrix::from_columns(&columns));
    let mut first = 0;
    signatures
        .iter()
        .map(|signature| {
            let own = signature.columns.ncols();
            first += own;
            white.columns(first - own, own).into_owned()
        })
        .collect()
}

/// Best ray of each cause, with its path paid for.
fn collect(
    bench: &Bench<'_>,
    rays: Vec<(Ray, Score)>,
    tasks: &[Task],
    paths: &[f64],
    smooth: DMatrix<f64>,
) -> Scan {
    let mut asked: Vec<usize> = tasks.iter().map(|t| t.0).collect();
    asked.dedup();
    let mut candidates = Vec::new();
    let mut absorbed = Vec::new();
    for &cause in &asked {
        let mut own: Vec<usize> = (0..rays.len())
            .filter(|&i| rays[i].0.cause == cause)
            .collect();
        let tangents: Vec<usize> = own
            .iter()
            .copied()
            .filter(|&i| rays[i].0.chord.is_none())
            .collect();
        if own.is_empty() {
            if !bench.catalogue[cause].is_periodic() {
                absorbed.push(cause);
            }
            continue;
        }
        let path = if bench.catalogue[cause].is_periodic() {
            paths[cause]
        } else {
            let chords: Vec<usize> = own
                .iter()
                .copied()
                .filter(|&i| rays[i].0.chord.is_some())
                .collect();
            [tangents, chords]
                .iter()
                .flat_map(|family| family.windows(2))
                .map(|w| {
                    angle(
                        &rays[w[0]].0.direction.columns,
                        &rays[w[1]].0.direction.columns,
                    )
                })
                .sum()
        };
        own.sort_by(|&a, &b| rays[a].1.log_p.total_cmp(&rays[b].1.log_p));
        let best = &rays[own[0]];
        // Of lines that score nearly alike the fit may prefer another one.
        let most = if bench.catalogue[cause].is_periodic() {
            own.len()
        } else {
            3
        };
        let starts = own
            .iter()
            .take(most)
            .map(|&i| start_from(bench, &rays[i].0, &rays[i].1))
            .collect();
        candidates.push(Candidate {
            cause,
            starts,
            log_p: look_elsewhere(&best.1, path),
            unit: best.0.unit_size(bench).abs(),
            score: best.1.clone(),
        });
    }
    candidates.sort_by(|a, b| a.log_p.total_cmp(&b.log_p).then(a.cause.cmp(&b.cause)));
    let mut ids: Vec<&str> = asked.iter().map(|&c| bench.catalogue[c].id()).collect();
    ids.sort_unstable();
    ids.dedup();
    Scan {
        candidates,
        asked: ids.len(),
        rays: rays.into_iter().map(|r| r.0).collect(),
        smooth,
        absorbed,
        sizes: None,
        of_their_kind: false,
        signatures: None,
    }
}

/// Parameters of a cause at a ray's estimated size, inside its bounds.
fn start_from(bench: &Bench<'_>, ray: &Ray, score: &Score) -> Vec<f64> {
    let effect = &bench.catalogue[ray.cause];
    let specs = effect.parameters_for(&bench.experiment);
    let mut start = ray.at.clone();
    match &ray.chord {
        Some(end) => {
            let factor = score
                .coefficients
                .first()
                .copied()
                .unwrap_or(1.0)
                .clamp(0.02, 20.0);
            for &i in effect.sizes() {
                start[i] = end[i] * factor;
            }
        }
        None => {
            for (k, &i) in effect.sizes().iter().enumerate() {
                start[i] = score.coefficients.get(k).copied().unwrap_or(0.0);
            }
        }
    }
    for (value, spec) in start.iter_mut().zip(&specs) {
        *value = value.clamp(spec.lower, spec.upper);
    }
    // A start at the null has no slope in its shapes.
    if effect.is_null(&start) {
        for &i in effect.sizes() {
            start[i] = (0.05 * specs[i].typical).clamp(specs[i].lower, specs[i].upper);
        }
    }
    effect.prepare_start(&bench.experiment, &mut start);
    start
}

/// One tangent of each cause without a period, in its plainest form: what the noise's mean may hold.
fn smooth_columns(bench: &Bench<'_>, signatures: &[Arc<Signature>]) -> DMatrix<f64> {
    let n = bench.samples.len();
    let mut columns = Vec::new();
    let mut last = usize::MAX;
    for signature in signatures {
        if signature.cause != last
            && signature.chord.is_none()
            && !bench.catalogue[signature.cause].is_periodic()
            && !is_second_form(bench, signature.cause)
        {
            last = signature.cause;
            columns.extend(signature.columns.column_iter().map(|c| c.into_owned()));
        }
    }
    if columns.is_empty() {
        DMatrix::zeros(n, 0)
    } else {
        DMatrix::from_columns(&columns)
    }
}

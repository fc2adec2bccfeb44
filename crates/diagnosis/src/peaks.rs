//! Lines in a residual: the periods and frequencies at which a periodic cause is looked at closely.

use nalgebra::{DMatrix, DVector};
use rig::Reach;

use crate::bench::Bench;
use crate::comb::Comb;
use crate::periodic::{Family, Information, Peak};
use crate::samples::Samples;
use crate::scan::period;
use crate::signatures::tangent;
use crate::stand::Stand;
use crate::subset::Subset;

/// A line: frequency (1/m or Hz), and the background over which it stands (see [`crate::periodic::Peak`]).
#[derive(Clone, Copy)]
pub(crate) struct Line {
    pub(crate) frequency: f64,
    pub(crate) background: f64,
}

/// The lines at which a periodic cause is looked at, and the path length of the search.
struct Looked {
    cause: usize,
    lines: Vec<Line>,
    path: f64,
}

/// Lines in the residual, for each periodic cause.
pub(crate) struct Peaks {
    found: Vec<Looked>,
}

/// Lines of a cause that are looked at closely: of a factor on friction, which the search sees as it is, and of a ripple of the
/// speed, whose envelope is that of the middle of an octave.
pub(crate) const MOST_LINES: usize = 5;
const MOST_LINES_OF_SPEED: usize = 8;
/// Half cycles over the longest stretch below which a frequency is slow: 8 periods over the longest stretch, which the law absorbs in part; for a ripple of the
/// speed 32, because what it does in the moments after a start tells one phase only.
pub(crate) const SLOW: f64 = 16.0;
const SLOW_OF_SPEED: f64 = 64.0;
/// Runs are put together in between the frequencies at which each is looked at where all places span so many times the longest stretch.
const FURTHER: f64 = 1.2;
/// Cycles over the longest stretch by which two lines differ: a line's own flank is no second line.
const APART: f64 = 0.6;
/// How many times higher than on the grid of frequencies a line may stand between them: 1.23 in one run passed evenly, more where
/// runs over different places interfere.
const MOST_RISE: f64 = 2.0;

/// Neighbours of a line, up to this share of its frequency and so many on either side. What begins at both ends of a plate, or in a few moments of
/// a run, looks alike at frequencies that are whole cycles over the longest stretch apart: neighbours are half a cycle apart. Where a period is of
/// the place, all slower lines are neighbours: starts at a few places are as well explained by a fast one.
const NEIGHBOURHOOD: f64 = 0.3;
const NEIGHBOURS: i32 = 60;
/// Half cycles by which a faster line of the place may be a neighbour beyond that share.
const FASTER: i32 = 24;

impl Peaks {
    pub(crate) fn none() -> Self {
        Self { found: Vec::new() }
    }

    /// Of all periodic causes but those that are skipped, or in the stand's model already.
    pub(crate) fn find(
        bench: &Bench<'_>,
        subset: &Subset,
        stand: &Stand,
        scatter: f64,
        skipped: &[usize],
    ) -> Self {
        let causes: Vec<usize> = (0..bench.catalogue.len())
            .filter(|c| !skipped.contains(c))
            .filter(|&c| {
                let effect = &bench.catalogue[c];
                effect.is_periodic() && !effect.refines() && !stand.fitted.names(bench, c)
            })
            .collect();
        if causes.is_empty() {
            return Self::none();
        }
        let samples = subset.samples(bench);
        let g = solved_back(stand, scatter);
        let information = |columns: &DMatrix<f64>| information(stand, scatter, columns);
        let found = causes
            .iter()
            .filter_map(|&cause| {
                let families = families(bench, subset, &samples, stand, cause)?;
                let most = match bench.catalogue[cause].reach() {
                    Reach::Stage => MOST_LINES_OF_SPEED,
                    _ => MOST_LINES,
                };
                let peaks: Vec<(&Family<'_>, Peak)> = families
                    .iter()
                    .flat_map(|family| {
                        let peaks = family.peaks(&g, &information, 2 * most);
                        peaks.into_iter().map(move |peak| (family, peak))
                    })
                    .collect();
                Some(Looked {
                    cause,
                    lines: highest(peaks, &g, most),
                    path: families.iter().map(Family::path).sum(),
                })
            })
            .collect();
        Self { found }
    }

    /// The same with further lines for one cause: the neighbours of one.
    pub(crate) fn with_neighbours(
        mut self,
        bench: &Bench<'_>,
        cause: usize,
        frequency: f64,
    ) -> Self {
        let of_place = matches!(period(bench, cause), Some((_, false)));
        let half_cycle = match of_place {
            true => 0.5 / extent(&bench.samples.place).max(1e-9),
            false => 0.5 / stretch(bench, cause),
        };
        let slowest = 2.0 / stretch(bench, cause) - frequency;
        if let Some(looked) = self.found.iter_mut().find(|f| f.cause == cause) {
            let near = (-NEIGHBOURS..=NEIGHBOURS).map(|k| (k, f64::from(k) * half_cycle));
            let near = near.filter(|&(k, shift)| {
                let far = of_place && shift >= slowest && k <= FASTER;
                far || shift.abs() <= NEIGHBOURHOOD * frequency
            });
            let near = near.map(|(_, shift)| shift);
            looked.lines.extend(near.map(|shift| Line {
                frequency: frequency + shift,
                background: 1.0,
            }));
        }
        self
    }

    fn looked(&self, cause: usize) -> Option<&Looked> {
        self.found.iter().find(|f| f.cause == cause)
    }

    pub(crate) fn of(&self, cause: usize) -> &[Line] {
        self.looked(cause).map_or(&[], |f| f.lines.as_slice())
    }

    pub(crate) fn path(&self, cause: usize) -> f64 {
        self.looked(cause).map_or(0.0, |f| f.path)
    }

    /// The background at a line of a cause.
    pub(crate) fn background(&self, cause: usize, frequency: f64) -> f64 {
        let same = |line: &&Line| (line.frequency / frequency - 1.0).abs() < 1e-9;
        self.of(cause)
            .iter()
            .find(same)
            .map_or(1.0, |line| line.background)
    }

    /// The same search with one line for each cause, of as many periods over its longest stretch.
    pub(crate) fn with_periods(mut self, bench: &Bench<'_>, periods: f64) -> Self {
        for looked in &mut self.found {
            looked.lines = vec![Line {
                frequency: periods / stretch(bench, looked.cause),
                background: 1.0,
            }];
        }
        self
    }
}

/// g of [`crate::periodic`]: W'(projection)V^-1 y.
pub(crate) fn solved_back(stand: &Stand, scatter: f64) -> DVector<f64> {
    let solved = stand.ground.solved_residual(scatter);
    let free = stand.ground.project_vector(&solved);
    let own = free.rows(0, stand.whitener.rows()).into_owned();
    stand.whitener.whiten_transposed(&own)
}

/// A of [`crate::periodic`] for each pair of columns.
pub(crate) fn information(stand: &Stand, scatter: f64, columns: &DMatrix<f64>) -> Vec<Information> {
    let a = (stand.ground).information(&stand.whiten_own(columns), scatter);
    let pairs = (0..columns.ncols()).step_by(2);
    pairs
        .map(|k| Information([a[(k, k)], a[(k, k + 1)], a[(k + 1, k + 1)]]))
        .collect()
}

/// Whether a cause has a period in time.
pub(crate) fn in_time(bench: &Bench<'_>, cause: usize) -> bool {
    period(bench, cause).is_some_and(|p| p.1)
}

/// The longest stretch of one run that a periodic cause passes, m or s.
fn stretch(bench: &Bench<'_>, cause: usize) -> f64 {
    let samples = &bench.samples;
    let coordinate = if in_time(bench, cause) {
        &samples.time
    } else {
        &samples.place
    };
    longest(samples, coordinate).max(1e-9)
}

/// What a periodic cause may look like: bands of frequency with an envelope each; `None` where nothing passes by, or where the
/// model has no such tangent.
fn families<'a>(
    bench: &Bench<'_>,
    subset: &Subset,
    samples: &'a Samples,
    stand: &Stand,
    cause: usize,
) -> Option<Vec<Family<'a>>> {
    let (shape, in_time) = period(bench, cause)?;
    let goes_on = bench.catalogue[cause].goes_on_between_runs();
    let coordinate = match (in_time, goes_on) {
        (true, true) => &samples.clock,
        (true, false) => &samples.time,
        (false, _) => &samples.place,
    };
    let (span, band) = span_and_band(samples, coordinate)?;
    let slow = match bench.catalogue[cause].reach() {
        Reach::Stage => SLOW_OF_SPEED,
        _ => SLOW,
    };
    // Runs over different places of the plate interfere as those of a day do: a line is as narrow as all places together make it.
    let put_together = goes_on || extent(coordinate) > FURTHER * span;
    // Half a cycle over the longest stretch; half of that where runs are put together in between.
    let spacing = if put_together { 0.25 } else { 0.5 } / span;
    anchors(bench, cause, band, 30.0 / span)
        .into_iter()
        .map(|(anchor, band)| {
            let (along, across) = envelope(bench, subset, stand, cause, shape, coordinate, anchor)?;
            Some(Family {
                coordinate,
                along,
                across,
                band,
                spacing,
                slow: slow * 0.5 / span,
                comb: put_together.then(|| Comb::new(&samples.runs, coordinate, spacing)),
            })
        })
        .collect()
}

/// The longest stretch of a coordinate in one run, and the frequencies that runs over it tell; `None` where nothing passes by.
pub(crate) fn span_and_band(samples: &Samples, coordinate: &[f64]) -> Option<(f64, (f64, f64))> {
    let (span, step) = (
        longest(samples, coordinate),
        middling_step(samples, coordinate),
    );
    // Lines closer than two samples of a fast motion are aliases of slow ones there: half of the samples must tell them apart. Slower
    // ones than two in a run are no period.
    (span > 0.0 && step > 0.0).then(|| (span, (2.0 / span, 0.45 / step)))
}

/// The highest lines that stand apart. Peaks are sharpened from the highest on, until no other one can rise among them.
pub(crate) fn highest(
    mut peaks: Vec<(&Family<'_>, Peak)>,
    g: &DVector<f64>,
    most: usize,
) -> Vec<Line> {
    peaks.sort_by(|a, b| b.1.height().total_cmp(&a.1.height()));
    let mut sharp: Vec<(f64, Peak)> = Vec::new();
    let mut taken: Vec<Peak> = Vec::new();
    for (family, rough) in peaks {
        let lowest = taken.last().map_or(0.0, Peak::height);
        if taken.len() == most && MOST_RISE * rough.height() < lowest {
            break;
        }
        sharp.push((family.fine_spacing(), family.sharpened(&rough, g)));
        sharp.sort_by(|a, b| b.1.height().total_cmp(&a.1.height()));
        taken.clear();
        for (spacing, peak) in &sharp {
            // One spacing is half a cycle over the longest stretch.
            let apart =
                |other: &Peak| (other.frequency - peak.frequency).abs() > 2.0 * APART * spacing;
            if taken.len() < most && taken.iter().all(apart) {
                taken.push(*peak);
            }
        }
    }
    let line = |peak: Peak| Line {
        frequency: peak.frequency,
        background: peak.background,
    };
    taken.into_iter().map(line).collect()
}

/// What a coordinate spans over all runs.
fn extent(x: &[f64]) -> f64 {
    let (lo, hi) = (x.iter()).fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &x| {
        (a.min(x), b.max(x))
    });
    (hi - lo).max(0.0)
}

/// Longest stretch of a coordinate in one run.
fn longest(samples: &Samples, x: &[f64]) -> f64 {
    samples
        .runs
        .iter()
        .map(|r| {
            let (lo, hi) = r
                .clone()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), i| {
                    (a.min(x[i]), b.max(x[i]))
                });
            hi - lo
        })
        .fold(0.0_f64, f64::max)
}

/// The step of a coordinate from sample to sample that half of them do not exceed.
fn middling_step(samples: &Samples, x: &[f64]) -> f64 {
    let mut steps: Vec<f64> = samples
        .runs
        .iter()
        .flat_map(|r| (r.start + 1..r.end).map(|i| (x[i] - x[i - 1]).abs()))
        .filter(|s| *s > 0.0)
        .collect();
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).copied().unwrap_or(0.0)
}

/// Bands of frequency with the one at which the envelope is taken. A factor on friction acts at once, at all frequencies alike; to a
/// ripple of the speed the contact answers with its steady curve where it is slow, with its stiffness where it is fast.
fn anchors(
    bench: &Bench<'_>,
    cause: usize,
    (low, high): (f64, f64),
    middling: f64,
) -> Vec<(f64, (f64, f64))> {
    if bench.catalogue[cause].reach() != Reach::Stage || high < 2.0 * low {
        return vec![(middling, (low, high))];
    }
    let octaves = (high / low).log2().ceil() as usize;
    let ratio = (high / low).powf(1.0 / octaves as f64);
    (0..octaves)
        .map(|k| {
            let from = low * ratio.powi(k as i32);
            (from * ratio.sqrt(), (from, from * ratio))
        })
        .collect()
}

/// What a periodic cause's ripple multiplies: its tangent at a frequency, turned back by the ripple's own phase,
/// in phase and a quarter of a period behind.
fn envelope(
    bench: &Bench<'_>,
    subset: &Subset,
    stand: &Stand,
    cause: usize,
    shape: usize,
    coordinate: &[f64],
    frequency: f64,
) -> Option<(Vec<f64>, Vec<f64>)> {
    let effect = &bench.catalogue[cause];
    let specs = effect.parameters_for(&bench.experiment);
    let in_time = specs[shape].name.ends_with("_hz");
    let mut at = vec![0.0; specs.len()];
    let value: f64 = if in_time { frequency } else { 1.0 / frequency };
    at[shape] = value.clamp(specs[shape].lower, specs[shape].upper);
    let frequency = if in_time { at[shape] } else { 1.0 / at[shape] };
    let signature = tangent(bench, &stand.fitted, cause, &at)?;
    let columns = subset.gather_columns(&signature.columns);
    if columns.ncols() < 2 {
        return None;
    }
    let turned_back = |(i, x): (usize, &f64)| {
        let (s, c) = (std::f64::consts::TAU * frequency * x).sin_cos();
        (
            columns[(i, 0)] * s + columns[(i, 1)] * c,
            columns[(i, 0)] * c - columns[(i, 1)] * s,
        )
    };
    Some(coordinate.iter().enumerate().map(turned_back).unzip())
}

//! The coordinates in which the sizes of the noise are searched for: their scales and bounds, where a search starts, and how fine a grid of the
//! plate it has.

use std::ops::Range;

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::context::{Context, Sampling, Sizes};
use super::estimate::{EstimateOptions, Search};
use super::restricted::Criterion;
use super::search::{self, NEAR, TO_THE_END};

/// Coordinates of the search: logarithms of sensor, private, plate, length; of wander and its time, where the force channel wanders; and
/// of further numbers ([`More`]), where the record asks for them.
pub(super) const SENSOR: usize = 0;
pub(super) const PRIVATE: usize = 1;
pub(super) const PLATE: usize = 2;
pub(super) const LENGTH: usize = 3;
const WANDER: usize = 4;
const WANDER_TIME: usize = 5;

/// A further number.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum More {
    /// Roughness is smoother than exponential,
    Smoothing,
    /// that of the plate still smoother, or less so.
    PlateSmoothing,
    /// That of the plate has a length of its own.
    PlateRatio,
}

/// Least and most smoothing that is searched: below, no sample shows it (slow ones show one of a fiftieth, and a bound above that is paid for
/// by length, for over short ways roughness does what smoothing times length squared says); above, the covariance does not change any more.
const SMOOTHINGS: (f64, f64) = (0.004, 0.95);
/// Spacing of the plate's nodes over their own on which the sizes are searched for first: near enough for a few steps on the fine
/// grid to end the search, at a fraction of its price.
const COARSE: f64 = 3.0;
/// Most ratio of the two lengths that is searched, either way: a field of the plate with a length far beyond all else is a law's or a surface's bend.
const MOST_RATIO: f64 = 5.0;
/// The plate's length over the longest of a roughness that is longer than the private one.
const LONGEST_PLATE_SHARE: f64 = 40.0;

/// The plate's length over the longest correlation length that counts as roughness.
const LONGEST_SHARE: f64 = 20.0;
/// The same where runs go back and forth and no step of the plate says as much.
const LONGEST_SHARE_TO_AND_FRO: f64 = 6.0;
/// Where of plate and runs one has this share of the other's roughness, or less, it may have been lost on the way.
const LOST: f64 = 0.1;

/// Share of the whole residual below which a part may be nothing, and the -2 log likelihood that it may then be worth.
const SMALL: f64 = 0.05;
const INVISIBLE: f64 = 0.02;

/// A length nearer to its bound than this share lies on it.
const ON_BOUND: f64 = 0.05;

/// Times over which a force channel may wander: from some samples, below which that is white noise, to a share of a run, beyond which it
/// is a level of the run's own.
fn wander_times_s(context: &Context) -> (f64, f64) {
    const SAMPLES: f64 = 1.5;
    const SHARE: f64 = 0.1;
    let of_run = |run: &Range<usize>| -> f64 {
        context
            .steps_s
            .get(run.clone())
            .map_or(0.0, |steps| steps.iter().sum())
    };
    let longest = context.runs.iter().map(of_run).fold(0.0, f64::max);
    let steps = context.samples().saturating_sub(context.runs.len()).max(1) as f64;
    let step = context.steps_s.iter().sum::<f64>() / steps;
    (SAMPLES * step, SHARE * longest)
}

/// Scales and bounds of the search.
#[derive(Clone)]
pub(super) struct Frame {
    bounds: Vec<(f64, f64)>,
    /// Whether the force channel wanders.
    pub(super) wanders: bool,
    /// Shortest and longest time over which it may, s.
    pub(super) wander_times_s: (f64, f64),
    more: Vec<More>,
    plate: bool,
    sampling: Sampling,
    relative: f64,
    absolute: f64,
    /// Sizes that are compared before the search, where none are known.
    pub(super) starts: usize,
    lengths: (f64, f64),
    longest_plate: f64,
    /// The longest length where no law can be mistaken for a field of the plate; `None` where it can.
    longest_to_and_fro: Option<f64>,
}

impl Frame {
    pub(super) fn new(
        context: &Context,
        criterion: &Criterion<'_>,
        options: &EstimateOptions,
        plate: bool,
    ) -> Self {
        let absolute = criterion
            .residual_rms()
            .max(options.stated_sensor.unwrap_or(0.0) * 1e-2)
            .max(1e-300);
        let n = context.samples() as f64;
        let scale_rms = (context.scale.iter().map(|f| f * f).sum::<f64>() / n).sqrt();
        let relative = absolute / scale_rms.max(1e-300);
        let (lo, hi) = context.extent();
        let slid: f64 = context
            .runs
            .iter()
            .map(|r| context.sliding[r.end - 1] - context.sliding[r.start])
            .fold(0.0, f64::max);
        // A run that goes back and forth slides far over a short plate: the plate is what counts.
        let span = if hi > lo { hi - lo } else { slid.max(1e-9) };
        let step = slid / (n / context.runs.len() as f64);
        // A correlation over more than a twentieth of the plate is no roughness but a law that misses the record, unless places
        // are passed at many speeds.
        let shortest = (0.2 * step).max(span * 1e-4);
        let longest = (span / LONGEST_SHARE).max(2.0 * shortest);
        let longest_to_and_fro = context
            .goes_back_and_forth()
            .then_some((span / LONGEST_SHARE_TO_AND_FRO).max(longest));
        let begun_longer = options.search.start().is_some_and(|s| s.length > longest);
        let longest = longest_to_and_fro
            .filter(|_| begun_longer)
            .unwrap_or(longest);
        let lengths = (shortest, longest);
        let bounds = vec![
            ((absolute * 1e-5).ln(), (absolute * 4.0).ln()),
            ((relative * 1e-4).ln(), (relative * 6.0).ln()),
            ((relative * 1e-4).ln(), (relative * 6.0).ln()),
            (lengths.0.ln(), lengths.1.ln()),
        ];
        let begun = options.search.start().unwrap_or(Sizes::NONE);
        let more = [
            (More::Smoothing, begun.smoothing > 0.0),
            (More::PlateSmoothing, begun.plate_smoothing > 0.0),
            (More::PlateRatio, begun.plate_ratio != 1.0),
        ];
        Self {
            bounds,
            wanders: false,
            wander_times_s: wander_times_s(context),
            more: Vec::new(),
            plate,
            sampling: context.sampling(),
            relative,
            absolute,
            starts: 0,
            lengths,
            longest_plate: span / LONGEST_PLATE_SHARE,
            longest_to_and_fro,
        }
        .counting(options)
        .wandering_if(options.wanders && begun.wander > 0.0)
        .with_all(more.into_iter().filter(|m| m.1).map(|m| m.0))
    }

    fn with_all(self, more: impl Iterator<Item = More>) -> Self {
        more.fold(self, Self::with)
    }

    /// The same where the force channel wanders.
    pub(super) fn wandering_if(mut self, wanders: bool) -> Self {
        if wanders && !self.wanders {
            let (shortest, longest) = self.wander_times_s;
            let sizes = self.bounds[SENSOR];
            let times = (shortest.ln(), longest.ln());
            self.bounds.splice(WANDER..WANDER, [sizes, times]);
            self.wanders = true;
        }
        self
    }

    /// Place of the first further number in a point.
    pub(super) fn further_place(&self) -> usize {
        if self.wanders {
            WANDER_TIME + 1
        } else {
            WANDER
        }
    }

    /// Place of a further number in a point.
    pub(super) fn place(&self, more: More) -> Option<usize> {
        let among = self.more.iter().position(|&m| m == more)?;
        Some(self.further_place() + among)
    }

    /// Whether roughness is exponential and of one length.
    pub(super) fn is_plain(&self) -> bool {
        self.more.is_empty()
    }

    /// Whether the roughness fixed to the plate can be told.
    pub(super) fn has_plate(&self) -> bool {
        self.plate
    }

    pub(super) fn has(&self, more: More) -> bool {
        self.more.contains(&more)
    }

    /// The same with a further number, the last in a point.
    pub(super) fn with(mut self, more: More) -> Self {
        if !self.has(more) {
            self.more.push(more);
            self.bounds.push(match more {
                More::Smoothing | More::PlateSmoothing => (SMOOTHINGS.0.ln(), SMOOTHINGS.1.ln()),
                More::PlateRatio => (-MOST_RATIO.ln(), MOST_RATIO.ln()),
            });
        }
        self
    }

    /// The same with longer roughness, where the record allows for it and `found` lies on the bound.
    pub(super) fn reaching_further(&self, found: &[f64]) -> Option<Self> {
        let longest = self.longest_to_and_fro?.ln();
        let bound = self.bounds[LENGTH].1;
        let bent = found[LENGTH] > bound - ON_BOUND && longest > bound + ON_BOUND;
        bent.then(|| {
            let mut further = self.clone();
            further.bounds[LENGTH].1 = longest;
            further
        })
    }

    fn counting(mut self, options: &EstimateOptions) -> Self {
        self.starts = if options.search.start().is_some() {
            0
        } else {
            8
        };
        self
    }

    pub(super) fn sizes(&self, x: &[f64]) -> Sizes {
        let more = |of: More| self.place(of).map(|k| x[k].exp());
        let wander = |k: usize| x.get(k).filter(|_| self.wanders).map(|w| w.exp());
        let length = x[LENGTH].exp();
        let ratio = more(More::PlateRatio).unwrap_or(1.0);
        let longest = (self.longest_plate / length).max(1.0);
        Sizes {
            sensor: x[SENSOR].exp(),
            wander: wander(WANDER).unwrap_or(Sizes::NONE.wander),
            wander_time_s: wander(WANDER_TIME).unwrap_or(Sizes::NONE.wander_time_s),
            private: x[PRIVATE].exp(),
            plate: if self.plate { x[PLATE].exp() } else { 0.0 },
            length,
            smoothing: more(More::Smoothing).unwrap_or(0.0),
            plate_ratio: ratio.min(longest),
            plate_smoothing: more(More::PlateSmoothing).unwrap_or(0.0),
            scatter: 0.0,
        }
    }

    /// Spacing of the plate's grid at a point, m (or rad).
    pub(super) fn spacing(&self, x: &[f64]) -> f64 {
        self.sizes(x).node_spacing(self.sampling)
    }

    /// That of a coarse grid; it too has some nodes in each length.
    pub(super) fn coarse(&self, x: &[f64]) -> f64 {
        /// Nodes per correlation length.
        const FEWEST: f64 = 3.0;
        let spacing = self.spacing(x);
        let coarsest = self.sizes(x).plate_length() / FEWEST;
        (COARSE * spacing).min(coarsest).max(spacing)
    }

    /// The likeliest sizes from a start that has the smoothing or has it not; one that is far from them is first brought near on a
    /// coarse grid.
    pub(super) fn search(
        &self,
        criterion: &Criterion<'_>,
        mut start: Vec<f64>,
        search: Search,
        evaluations: &mut usize,
    ) -> search::Minimum {
        let far = search.start().is_none();
        let mut again = true;
        loop {
            let begun = start.clone();
            let spacing = self.spacing(&start);
            let mut hessian = None;
            if far {
                let near = self.on_grid(criterion, &start, self.coarse(&start), NEAR);
                *evaluations += near.evaluations;
                if search == Search::Near {
                    return near;
                }
                (start, hessian) = (near.point, Some(near.hessian));
            }
            let found = self.minimum(criterion, &start, spacing, hessian, TO_THE_END);
            *evaluations += found.evaluations;
            // The grid's spacing follows the sizes: search again only where the length or the grid moved far, and once.
            let length = |x: &[f64]| self.sizes(x).plate_length();
            let far_apart = |a: f64, b: f64| (a / b).ln().abs() > 0.7;
            let moved = far_apart(length(&found.point), length(&begun))
                || far_apart(self.spacing(&found.point), spacing);
            if !moved || !again {
                return found;
            }
            start = found.point;
            again = false;
        }
    }

    /// The likeliest sizes on one grid.
    pub(super) fn near(
        &self,
        criterion: &Criterion<'_>,
        start: &[f64],
        spacing: f64,
    ) -> search::Minimum {
        self.on_grid(criterion, start, spacing, TO_THE_END)
    }

    /// The same as far as steps are worthwhile.
    pub(super) fn on_grid(
        &self,
        criterion: &Criterion<'_>,
        start: &[f64],
        spacing: f64,
        worthwhile: f64,
    ) -> search::Minimum {
        self.minimum(criterion, start, spacing, None, worthwhile)
    }

    /// The same with an estimate of the Hessian at the start.
    fn minimum(
        &self,
        criterion: &Criterion<'_>,
        start: &[f64],
        spacing: f64,
        hessian: Option<DMatrix<f64>>,
        worthwhile: f64,
    ) -> search::Minimum {
        let counts = |&part: &usize| match part {
            PLATE => self.plate,
            WANDER => self.wanders,
            _ => true,
        };
        let parts: Vec<usize> = [SENSOR, PRIVATE, PLATE, WANDER]
            .into_iter()
            .filter(counts)
            .collect();
        let problem = search::Problem {
            level: &|x| criterion.level(&self.sizes(x), spacing),
            bounds: &self.bounds,
            parts: &parts,
            idle: (!self.plate).then_some(PLATE),
            degrees_of_freedom: criterion.degrees_of_freedom() as f64,
        };
        let expected = criterion.curvature(|x| self.sizes(x), start);
        search::minimise(&problem, start, expected, hessian, worthwhile)
    }

    /// The former sizes, or the best of a coarse grid over length and share of the sensor noise.
    pub(super) fn best_start(
        &self,
        criterion: &Criterion<'_>,
        options: &EstimateOptions,
    ) -> Vec<f64> {
        if let Some(s) = options.search.start() {
            let log = |x: f64, k: usize| {
                let (lo, hi) = self.bounds[k];
                x.max(f64::MIN_POSITIVE).ln().clamp(lo + 2.0, hi)
            };
            let mut start = vec![
                log(s.sensor, SENSOR),
                log(s.private, PRIVATE),
                log(s.plate, PLATE),
                s.length
                    .ln()
                    .clamp(self.bounds[LENGTH].0, self.bounds[LENGTH].1),
            ];
            if self.wanders {
                start.push(log(s.wander, WANDER));
                let (shortest, longest) = self.bounds[WANDER_TIME];
                start.push(s.wander_time_s.ln().clamp(shortest, longest));
            }
            for (&more, &(least, most)) in self.more.iter().zip(&self.bounds[start.len()..]) {
                let begun = match more {
                    More::Smoothing => s.smoothing,
                    More::PlateSmoothing => s.plate_smoothing,
                    More::PlateRatio => s.plate_ratio,
                };
                start.push(begun.ln().clamp(least, most));
            }
            return start;
        }
        let (short, long) = self.lengths;
        let mut points = Vec::new();
        for i in 0..4 {
            let length = (short * (0.7 * long / short).powf((i as f64 + 0.5) / 4.0)).max(short);
            for share in [0.05_f64, 0.5] {
                points.push(vec![
                    (self.absolute * share).ln(),
                    (self.relative * 0.6).ln(),
                    (self.relative * 0.6).ln(),
                    length.ln(),
                ]);
            }
        }
        let values: Vec<f64> = points
            .par_iter()
            .map(|x| self.value(criterion, x, self.coarse(x)))
            .collect();
        let best = (0..points.len()).min_by(|&a, &b| values[a].total_cmp(&values[b]));
        points.swap_remove(best.unwrap_or(0))
    }

    /// -2 log likelihood of the sizes at a point.
    pub(super) fn value(&self, criterion: &Criterion<'_>, point: &[f64], spacing: f64) -> f64 {
        criterion.value(&self.sizes(point), spacing)
    }

    /// Where nearly all roughness has ended in plate or runs: the likeliest sizes from both sharing it, if those are likelier. Along the
    /// logarithm of a part that is next to nothing no slope leads back, and a long first step may have led there.
    pub(super) fn shared_out(
        &self,
        criterion: &Criterion<'_>,
        found: &search::Minimum,
        evaluations: &mut usize,
    ) -> Option<search::Minimum> {
        let (plate, private) = (found.point[PLATE], found.point[PRIVATE]);
        if !self.plate || (plate - private).abs() < -LOST.ln() {
            return None;
        }
        let mut start = found.point.clone();
        let half = plate.max(private) - 0.5 * 2.0_f64.ln();
        (start[PLATE], start[PRIVATE]) = (half, half);
        let sizes = self.sizes(&found.point);
        *evaluations += 1;
        if self.value(criterion, &start, self.spacing(&found.point)) > found.value {
            return None;
        }
        let again = self.search(criterion, start, Search::Onward(sizes), evaluations);
        (again.value < found.value).then_some(again)
    }

    /// The same without a wander, where roughness does by now what it did.
    pub(super) fn stilled(
        &self,
        criterion: &Criterion<'_>,
        found: &search::Minimum,
        evaluations: &mut usize,
    ) -> Option<(Self, search::Minimum)> {
        if !self.wanders || found.point[WANDER] > (SMALL * self.absolute).ln() {
            return None;
        }
        let spacing = self.spacing(&found.point);
        let mut still = self.clone();
        still.wanders = false;
        still.bounds.drain(WANDER..=WANDER_TIME);
        let mut minimum = found.clone();
        minimum.point.drain(WANDER..=WANDER_TIME);
        let places = [WANDER, WANDER_TIME];
        minimum.hessian = (minimum.hessian)
            .remove_rows_at(&places)
            .remove_columns_at(&places);
        minimum.value = still.value(criterion, &minimum.point, spacing);
        *evaluations += 1;
        (minimum.value < found.value + INVISIBLE).then_some((still, minimum))
    }

    /// A part without which the data are as likely is zero, and exactly so.
    pub(super) fn without_invisible(
        &self,
        criterion: &Criterion<'_>,
        sizes: Sizes,
        spacing: f64,
        value: f64,
    ) -> Sizes {
        let is_small = |part: f64, scale: f64| part > 0.0 && part < SMALL * scale;
        let mut kept = sizes;
        let mut try_without = |small: bool, drop_part: fn(Sizes) -> Sizes| {
            let without = drop_part(kept);
            if small && criterion.value(&without, spacing) < value + INVISIBLE {
                kept = without;
            }
        };
        try_without(is_small(sizes.plate, self.relative), |s| Sizes {
            plate: 0.0,
            ..s
        });
        try_without(is_small(sizes.private, self.relative), |s| Sizes {
            private: 0.0,
            ..s
        });
        try_without(is_small(sizes.wander, self.absolute), |s| Sizes {
            wander: 0.0,
            ..s
        });
        kept
    }
}

//! Estimating the sizes of the noise from residuals.
//!
//! First the roughness, its length and the sensor noise from what happens within runs (N3), a gain for every run being
//! part of the mean; then, with these, the scatter between runs from what the mean leaves between runs (N2).

use nalgebra::{DMatrix, DVector};

use super::context::{Context, Sizes};
use super::frame::Frame;
use super::restricted::Criterion;
use super::scatter::{ScatterEvidence, gain_columns};
use super::search;
use super::whitener::Whitener;

/// What the caller knows besides the residuals.
#[derive(Clone, Debug, Default)]
pub struct EstimateOptions {
    /// The sensor's stated accuracy, in the unit of the data: a start, and the least that is believed without repeats.
    pub stated_sensor: Option<f64>,
    /// Whether the campaign has repeats.
    pub repeats: bool,
    /// Where the search begins and how far it goes.
    pub search: Search,
    /// Whether the standard deviations of the sizes are wanted (they cost some thirty evaluations).
    pub uncertainty: bool,
    /// Whether the roughness may be smoother than exponential, or that of the plate have a length of its own. Where nothing else is asked
    /// what a law leaves, such roughness also swallows structure that the law misses.
    pub smooth: bool,
    /// Whether the force channel may wander.
    pub wanders: bool,
}

/// Where the search for the sizes begins and how far it goes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Search {
    /// Nothing is known: from the best of a grid, as far as the likelihood tells.
    #[default]
    Scratch,
    /// The same, but only so near as a coarse grid brings it, with exponential roughness: another estimate follows.
    Near,
    /// From sizes found near, as far as the likelihood tells.
    Onward(Sizes),
    /// From sizes found on nearly the same data: smoothing counts only where it is seen at once.
    Again(Sizes),
}

impl Search {
    /// Sizes to start from.
    pub(super) fn start(self) -> Option<Sizes> {
        match self {
            Self::Scratch | Self::Near => None,
            Self::Onward(sizes) | Self::Again(sizes) => Some(sizes),
        }
    }

    pub(super) fn is_thorough(self) -> bool {
        !matches!(self, Self::Again(_))
    }
}

/// The sizes of a campaign's noise, and how well they are known.
#[derive(Clone, Debug)]
pub struct NoiseModel {
    /// The estimates.
    pub sizes: Sizes,
    /// Standard deviations of the logarithms of sensor, private, plate and length (infinite: not determined; empty:
    /// not asked for).
    pub log_sd: Vec<f64>,
    /// What the runs say about the scatter between them.
    pub scatter: ScatterEvidence,
    /// Whether runs pass the same places, so that the roughness fixed to the plate can be told from the private one.
    pub plate_separable: bool,
    /// Whether the campaign has repeats; without them scatter rests on the law being right.
    pub repeats: bool,
    /// Whether the search for the sizes converged.
    pub converged: bool,
    /// Evaluations of the restricted likelihood.
    pub evaluations: usize,
    /// -2 log restricted likelihood of what happens within runs.
    pub deviance: f64,
}

/// Samples times runs up to which the mean holds a gain for every run.
const MOST_GAINS: usize = 2_000_000;

/// Estimates the noise from the residual of a fit and the Jacobian of its mean (n x p).
///
/// `within` are further columns (n x q, q may be 0) that may lie in the mean as far as the noise within runs is
/// concerned, such as effects that are still being asked for.
pub fn estimate(
    context: &Context,
    residual: &DVector<f64>,
    jacobian: &DMatrix<f64>,
    within: &DMatrix<f64>,
    options: &EstimateOptions,
) -> NoiseModel {
    let n = context.samples();
    let runs = context.runs.len();
    let (p, q) = (jacobian.ncols(), within.ncols());
    let mut mean = jacobian.clone().resize_horizontally(p + q, 0.0);
    mean.view_mut((0, p), (n, q)).copy_from(within);
    let criterion = Criterion::new(context, &mean, n * runs <= MOST_GAINS, residual);
    let plate_separable = context.shared_places() > 0.05;
    let mut frame = Frame::new(context, &criterion, options, plate_separable);

    let start = frame.best_start(&criterion, options);
    let mut evaluations = frame.starts;
    let mut minimum = frame.search(&criterion, start, options.search, &mut evaluations);
    if let Some(shared) = frame.shared_out(&criterion, &minimum, &mut evaluations) {
        minimum = shared;
    }
    if options.wanders
        && context.rows.is_empty()
        && let Some(found) = frame.wandering(&criterion, &minimum, options.search, &mut evaluations)
    {
        (frame, minimum) = (found.frame, found.minimum);
    }
    // What rows are the means of is known of exponential roughness only.
    if options.smooth && context.rows.is_empty() && options.search != Search::Near {
        // Longer roughness first: at the bound of its length it would be taken for another kind.
        if frame.is_plain()
            && let Some(longer) = frame.longer(&criterion, &minimum, &mut evaluations)
        {
            (frame, minimum) = (longer.frame, longer.minimum);
        }
        while let Some(best) = frame.further(&criterion, &minimum, options.search, &mut evaluations)
        {
            (frame, minimum) = (best.frame, best.minimum);
            if let Some(still) = frame.stilled(&criterion, &minimum, &mut evaluations) {
                (frame, minimum) = still;
            }
        }
    }
    let spacing = frame.spacing(&minimum.point);
    let log_sd = if options.uncertainty {
        search::standard_deviations(
            &|x: &[f64]| frame.value(&criterion, x, spacing),
            &minimum.point,
        )
    } else {
        Vec::new()
    };
    let sizes = frame.sizes(&minimum.point);
    let mut sizes = frame.without_invisible(&criterion, sizes, spacing, minimum.value);
    if !options.repeats {
        sizes.sensor = sizes.sensor.max(options.stated_sensor.unwrap_or(0.0));
    }

    let whitener = Whitener::new(context, &sizes);
    let (gains, conditions) = gain_columns_limited(context);
    let scatter = ScatterEvidence::of_repeats(
        &whitener.whiten_columns(&gains),
        &whitener.whiten_columns(jacobian),
        &whitener.whiten(residual),
        &conditions,
    );
    sizes.scatter = scatter.estimate();
    NoiseModel {
        sizes,
        log_sd,
        scatter,
        plate_separable,
        repeats: options.repeats,
        converged: minimum.converged,
        evaluations,
        deviance: minimum.value,
    }
}

/// Gains of all runs, or for very many of 96 of them, evenly chosen; and the conditions of the runs, where gains are of all.
fn gain_columns_limited(context: &Context) -> (DMatrix<f64>, Vec<usize>) {
    const MOST: usize = 96;
    let runs = context.runs.len();
    if runs <= MOST {
        return (gain_columns(context), context.conditions.clone());
    }
    let mut gains = DMatrix::zeros(context.samples(), MOST);
    for c in 0..MOST {
        for i in context.runs[c * runs / MOST].clone() {
            gains[(i, c)] = context.scale[i];
        }
        context.recorded(gains.column_mut(c).as_mut_slice());
    }
    (gains, Vec::new())
}

//! The plate in cells, and what may be a mark on it: stretches of cells on which friction is raised evenly or towards their middle, and
//! steps from which on it is raised.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use statrs::distribution::{ContinuousCDF, Normal};

use crate::ground::{Direction, Ground};
use crate::samples::Samples;
use crate::stand::Stand;

/// Widths of a mark, in correlation lengths of the roughness; steps are looked for at the edges of cells of half the shortest.
const WIDTHS: [f64; 3] = [1.0, 2.0, 4.0];
/// Cells: at most this many.
const MOST: usize = 240;
/// Samples that must lie on a mark, and elsewhere.
const FEWEST: usize = 3;

/// A mark between two edges of cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Shape {
    /// Friction is raised alike between two edges.
    Even { from: usize, to: usize },
    /// It rises to the middle of an even number of cells and falls again, both in a straight line.
    Peaked { from: usize, to: usize },
    /// It is raised beyond an edge.
    Beyond { edge: usize },
}

/// A mark in its exact place, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Course {
    /// Friction is raised alike between two places.
    Even { from: f64, to: f64 },
    /// The same with soft edges: it rises and falls as the normal distribution does, with [`SOFT`] of its width.
    Soft { from: f64, to: f64 },
    /// It rises and falls as a normal density does.
    Bell { at: f64, deviation: f64 },
    /// It is raised beyond a place.
    Beyond { at: f64 },
    /// It rises beyond a place as the normal distribution does.
    Rise { at: f64, deviation: f64 },
}

/// Places to each side among which a course is sought, and shares of an extent that lie between them, round by round.
const STEPS: i32 = 2;
const STEP_SHARES: [f64; 3] = [0.25, 0.1, 0.04];
/// Powers of two between the widths of rises, round by round: what steps gradually may do so over any width.
const WIDTH_POWERS: [f64; 3] = [1.0, 0.4, 0.16];
/// Standard deviation of the edges of a soft strip, as a share of its width: between even friction and a bell.
const SOFT: f64 = 0.125;
/// The widest rise, as a share of the way that the runs pass: one over all of it is a gradient, and beside roughness that is smooth over as
/// much of it one over a tenth explains as much as a gradient does.
const WIDEST_RISE: f64 = 0.04;
/// Share of what a mark explains from which on another one beside it belongs to it.
const EDGE: f64 = 0.1;
/// Width of a bell at half its height, in its deviations: sqrt(8 ln 2).
const HALF_HEIGHT: f64 = 2.354_82;

fn counts() -> impl Iterator<Item = f64> {
    (-STEPS..=STEPS).map(f64::from)
}

impl Course {
    /// Courses near an extent of the plate, finer from round to round. `way`: how much of it the runs pass, m.
    fn near(extent: (f64, f64), way: f64, round: usize) -> Vec<Self> {
        [Self::strips(extent, round), Self::steps(extent, way, round)].concat()
    }

    /// Those of friction that is raised between two places.
    fn strips(extent: (f64, f64), round: usize) -> Vec<Self> {
        let (middle, width) = (0.5 * (extent.0 + extent.1), extent.1 - extent.0);
        let step = STEP_SHARES[round] * width;
        let mut out = Vec::new();
        for one in counts().map(|k| k * step) {
            for other in counts().map(|k| k * step) {
                let (from, to) = (extent.0 + one, extent.1 + other);
                out.push(Self::Even { from, to });
                out.push(Self::Soft { from, to });
                out.push(Self::Bell {
                    at: middle + one,
                    deviation: (width + other) / HALF_HEIGHT,
                });
            }
        }
        out
    }

    /// Those of friction that is raised beyond a place.
    fn steps(extent: (f64, f64), way: f64, round: usize) -> Vec<Self> {
        let (middle, width) = (0.5 * (extent.0 + extent.1), extent.1 - extent.0);
        let step = STEP_SHARES[round] * width;
        let mut out = Vec::new();
        for one in counts().map(|k| k * step) {
            let beyond = |at: f64| Self::Beyond { at: at + one };
            out.extend([middle, extent.0, extent.1].map(beyond));
            let widths = counts().map(|k| width * (k * WIDTH_POWERS[round]).exp2());
            let short = widths.filter(|wide| *wide <= WIDEST_RISE * way);
            out.extend(short.map(|wide| Self::Rise {
                at: middle + one,
                deviation: wide / HALF_HEIGHT,
            }));
        }
        out
    }

    /// Courses of its own kind near it.
    fn alike(self, extent: (f64, f64), way: f64, round: usize) -> Vec<Self> {
        match self {
            Self::Beyond { .. } | Self::Rise { .. } => Self::steps(extent, way, round),
            Self::Even { .. } | Self::Soft { .. } | Self::Bell { .. } => {
                Self::strips(extent, round)
            }
        }
    }

    /// Where it begins and ends; a step as closely as it is known, `width`.
    fn extent(self, width: f64) -> (f64, f64) {
        match self {
            Self::Even { from, to } | Self::Soft { from, to } => (from, to),
            Self::Bell { at, deviation } | Self::Rise { at, deviation } => {
                let half = 0.5 * HALF_HEIGHT * deviation;
                (at - half, at + half)
            }
            Self::Beyond { at } => (at - 0.5 * width, at + 0.5 * width),
        }
    }

    /// By how much friction is raised, in units of the largest.
    fn raised(self, place: f64) -> f64 {
        let normal = |x: f64| Normal::standard().cdf(x);
        match self {
            Self::Even { from, to } => f64::from(u8::from(place > from && place <= to)),
            Self::Soft { from, to } => {
                let deviation = SOFT * (to - from);
                normal((place - from) / deviation) - normal((place - to) / deviation)
            }
            Self::Bell { at, deviation } => (-0.5 * ((place - at) / deviation).powi(2)).exp(),
            Self::Beyond { at } => f64::from(u8::from(place > at)),
            Self::Rise { at, deviation } => normal((place - at) / deviation),
        }
    }

    /// The force that each of some courses adds at these places, in units of its height.
    pub(crate) fn columns(courses: &[Self], places: &[f64], friction: &[f64]) -> DMatrix<f64> {
        DMatrix::from_fn(places.len(), courses.len(), |i, k| {
            friction[i] * courses[k].raised(places[i])
        })
    }
}

/// A mark as it is found near a place.
pub(crate) struct Near {
    /// Its course, and that of what it throws up beside it.
    pub(crate) courses: Vec<Course>,
    pub(crate) extent: (f64, f64),
    /// What it explains there.
    pub(crate) explained: f64,
    /// How many were tried.
    pub(crate) tried: usize,
}

impl Near {
    /// Both marks, in the place of the first.
    pub(crate) fn and(&self, other: &Self) -> Self {
        Self {
            courses: [&self.courses[..], &other.courses].concat(),
            extent: self.extent,
            explained: self.explained + other.explained,
            tried: self.tried.saturating_mul(other.tried),
        }
    }
}

/// The course of the strongest mark near an extent, by what it explains beside a model on its ground.
pub(crate) fn closely(
    stand: &Stand,
    ground: &Ground,
    samples: &Samples,
    friction: &[f64],
    mut extent: (f64, f64),
) -> Option<Near> {
    let (mut best, mut tried): (Option<(f64, Course)>, _) = (None, 0);
    let (lo, hi) = samples.extent();
    for round in 0..STEP_SHARES.len() {
        let courses = match best {
            None => Course::near(extent, hi - lo, round),
            Some((_, course)) => course.alike(extent, hi - lo, round),
        };
        tried += courses.len();
        let white = stand.whiten_own(&Course::columns(&courses, &samples.place, friction));
        let free = ground.project(&white);
        let explained = (0..courses.len()).into_par_iter().filter_map(|j| {
            let direction = ground.along(free.column(j).into_owned(), white.column(j).norm())?;
            Some((ground.explained(&direction), courses[j]))
        });
        let explained: Vec<(f64, Course)> = explained.collect();
        let (explained, course) = (explained.into_iter()).max_by(|a, b| a.0.total_cmp(&b.0))?;
        extent = course.extent(extent.1 - extent.0);
        best = Some((explained, course));
    }
    let (explained, course) = best?;
    Some(Near {
        courses: vec![course],
        extent,
        explained,
        tried,
    })
}

/// A mark with what lies beside it: a groove throws up an edge. The strongest mark that adjoins the first on either side belongs to it where it
/// explains a share of what that does. `others`: courses of other marks, which are in the model.
pub(crate) fn with_edge(
    stand: &Stand,
    others: &[Course],
    samples: &Samples,
    friction: &[f64],
    mut mark: Near,
) -> Near {
    let held = [others, &mark.courses].concat();
    let columns = Course::columns(&held, &samples.place, friction);
    let ground = stand.ground_beside(&stand.whiten_own(&columns));
    let (from, to) = mark.extent;
    let width = to - from;
    let sides = [(from - width, from), (to, to + width)];
    let near = sides.map(|side| closely(stand, &ground, samples, friction, side));
    let tried: usize = near.iter().flatten().map(|near| near.tried).sum();
    let edges = near.into_iter().flatten();
    let edge = edges.max_by(|a, b| a.explained.total_cmp(&b.explained));
    if let Some(edge) = edge.filter(|edge| edge.explained > EDGE * mark.explained) {
        mark.courses.extend(edge.courses);
        mark.extent = (from.min(edge.extent.0), to.max(edge.extent.1));
        mark.explained += edge.explained;
        mark.tried *= tried;
    }
    mark
}

/// The plate in cells of half the shortest width.
pub(crate) struct Cells {
    lo: f64,
    width: f64,
    count: usize,
    /// The cell of each sample; what lies beyond the last whole one belongs to it.
    of_sample: Vec<usize>,
    /// Cells that the shortest mark, the next and the longest are wide.
    widths: Vec<usize>,
}

impl Cells {
    /// For roughness of this length; `None` where the runs pass no two places.
    pub(crate) fn new(length: f64, samples: &Samples) -> Option<Self> {
        let (lo, hi) = samples.extent();
        let width = (0.5 * WIDTHS[0] * length).max((hi - lo) / MOST as f64);
        let count = ((hi - lo) / width) as usize;
        // Whole cells; where the plate is long against the roughness, widths fall together.
        let wide = |share: &f64| ((share * length / width).round() as usize).max(2);
        let mut widths: Vec<usize> = WIDTHS.iter().map(wide).collect();
        widths.dedup();
        let cell = |&x: &f64| (((x - lo) / width) as usize).min(count - 1);
        (count >= 2).then(|| Self {
            lo,
            width,
            count,
            of_sample: samples.place.iter().map(cell).collect(),
            widths,
        })
    }

    /// All marks that are asked for.
    pub(crate) fn shapes(&self) -> Vec<Shape> {
        let mut out = Vec::new();
        for &width in &self.widths {
            let starts = |wide: usize| {
                let starts = (0..).step_by(width / 2);
                starts.take_while(move |from| from + wide <= self.count)
            };
            let even = |from| Shape::Even {
                from,
                to: from + width,
            };
            let peaked = |from| Shape::Peaked {
                from,
                to: from + 2 * width,
            };
            out.extend(starts(width).map(even));
            out.extend(starts(2 * width).map(peaked));
        }
        out.extend((1..self.count).map(|edge| Shape::Beyond { edge }));
        out
    }

    /// Where a mark begins and ends; a step is known to a cell.
    pub(crate) fn extent(&self, shape: Shape) -> (f64, f64) {
        let edge = |k: usize| self.lo + self.width * k as f64;
        match shape {
            Shape::Even { from, to } => (edge(from), edge(to)),
            Shape::Peaked { from, to } => {
                let quarter = (to - from) / 4;
                (edge(from + quarter), edge(to - quarter))
            }
            Shape::Beyond { edge: at } => (edge(at - 1), edge(at + 1)),
        }
    }
}

/// Friction on the plate up to each edge of the cells, and the sums of these: what a mark adds is a difference of two such columns or of
/// three, and whitening and projecting are linear, so that each cell is whitened once for all marks that it lies on.
pub(crate) struct Sums {
    /// Whitened; column e belongs to the cells before edge e.
    white: Twice,
    /// With the model's directions taken out.
    free: Twice,
    /// Samples before each edge.
    samples: Vec<usize>,
}

impl Sums {
    pub(crate) fn new(stand: &Stand, ground: &Ground, cells: &Cells, scale: &[f64]) -> Self {
        let mut own = DMatrix::zeros(scale.len(), cells.count);
        let mut samples = vec![0; cells.count + 1];
        for (i, (&cell, &friction)) in cells.of_sample.iter().zip(scale).enumerate() {
            own[(i, cell)] = friction;
            samples[cell + 1] += usize::from(friction != 0.0);
        }
        for edge in 1..samples.len() {
            samples[edge] += samples[edge - 1];
        }
        let white = summed(&stand.whiten_own(&own));
        Self {
            free: Twice::of(ground.project(&white)),
            white: Twice::of(white),
            samples,
        }
    }

    /// A mark as a direction; `None` where too few samples lie on it, or elsewhere, or the model absorbs it.
    pub(crate) fn direction(&self, ground: &Ground, shape: Shape) -> Option<Direction> {
        let (from, to) = match shape {
            Shape::Even { from, to } | Shape::Peaked { from, to } => (from, to),
            Shape::Beyond { edge } => (edge, self.samples.len() - 1),
        };
        let on_it = self.samples[to] - self.samples[from];
        if on_it < FEWEST || self.samples[self.samples.len() - 1] < on_it + FEWEST {
            return None;
        }
        ground.along(self.free.column(shape), self.white.column(shape).norm())
    }
}

/// Sums of cells, and the sums of these.
struct Twice {
    once: DMatrix<f64>,
    twice: DMatrix<f64>,
}

impl Twice {
    fn of(once: DMatrix<f64>) -> Self {
        Self {
            twice: summed(&once),
            once,
        }
    }

    fn column(&self, shape: Shape) -> DVector<f64> {
        let last = self.once.ncols() - 1;
        match shape {
            Shape::Even { from, to } => self.once.column(to) - self.once.column(from),
            Shape::Beyond { edge } => self.once.column(last) - self.once.column(edge),
            Shape::Peaked { from, to } => {
                let half = (to - from) / 2;
                // Stretches of half as many cells, each a cell beyond the one before: on cells from the first on lie 1, 2, ..., half, ..., 2, 1 of them.
                let [a, b, c] = [from, from + half, to].map(|e| self.twice.column(e));
                (a + c - b * 2.0) / half as f64
            }
        }
    }
}

/// Column e: the sum of the columns before e.
fn summed(own: &DMatrix<f64>) -> DMatrix<f64> {
    let (n, count) = own.shape();
    let mut sums = DMatrix::zeros(n, count + 1);
    for k in 0..count {
        let next = sums.column(k) + own.column(k);
        sums.set_column(k + 1, &next);
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    fn on_cells(shape: Shape) -> Vec<f64> {
        let sums = Twice::of(summed(&DMatrix::identity(8, 8)));
        sums.column(shape).iter().copied().collect()
    }

    #[test]
    fn sums_of_cells_make_the_shapes() {
        let third = 1.0 / 3.0;
        let near = |a: Vec<f64>, b: [f64; 8]| {
            assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12), "{a:?}");
        };
        let (even, peaked) = (
            Shape::Even { from: 2, to: 4 },
            Shape::Peaked { from: 1, to: 7 },
        );
        near(on_cells(even), [0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
        near(
            on_cells(peaked),
            [0.0, third, 2.0 * third, 1.0, 2.0 * third, third, 0.0, 0.0],
        );
        let beyond = Shape::Beyond { edge: 5 };
        near(on_cells(beyond), [0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0]);
    }

    /// A bell is half as high at the ends of its extent, and courses near an extent hold the bell that fills it.
    #[test]
    fn a_bell_fills_its_extent() {
        let bell = Course::Bell {
            at: 0.2,
            deviation: 0.004,
        };
        let (from, to) = bell.extent(0.0);
        assert!((bell.raised(from) - 0.5).abs() < 1e-5 && (bell.raised(to) - 0.5).abs() < 1e-5);
        let fills = |course: &Course| match course {
            Course::Bell { at, deviation } => {
                (at - 0.2).abs() < 1e-12 && (deviation - 0.004).abs() < 1e-12
            }
            _ => false,
        };
        assert!(Course::near((from, to), 1.0, 0).iter().any(fills));
    }

    /// A rise is half as high in its middle and over its extent rises by erf(sqrt(ln 2)) = 0.761 of itself; none that is tried is wider
    /// than a small share of the way: one that is looks like a gradient where the plate is rough over as much.
    #[test]
    fn rises_are_steps_and_no_gradients() {
        let rise = Course::Rise {
            at: 0.2,
            deviation: 0.004,
        };
        let (from, to) = rise.extent(0.0);
        assert!((rise.raised(0.2) - 0.5).abs() < 1e-12);
        assert!((rise.raised(to) - rise.raised(from) - 0.761).abs() < 1e-3);
        let widths = |way: f64| -> Vec<f64> {
            let near = Course::near((from, to), way, 0).into_iter();
            let rises = near.filter(|course| matches!(course, Course::Rise { .. }));
            let extents = rises.map(|course| course.extent(0.0));
            extents.map(|(from, to)| to - from).collect()
        };
        let all = widths(1.0);
        assert_eq!(all.len(), 25);
        let four = |wide: &f64| (wide / (to - from) - 4.0).abs() < 1e-9;
        assert!(all.iter().any(four));
        let few = widths(0.3);
        assert!(!few.is_empty() && few.iter().all(|wide| *wide <= WIDEST_RISE * 0.3));
    }
}

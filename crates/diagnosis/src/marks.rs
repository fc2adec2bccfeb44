//! Marks on the plate: a scratch, a seam, a spot of something, short against the travel and the same in every run; or a step, from which
//! on friction is another.
//!
//! Roughness fixed to the plate repeats in every run as a mark does, and is no error of a law. A mark is told from it by its
//! size alone: friction raised or lowered by a factor over a short stretch, or beyond a place, scored against the field's own spread. The
//! spread's tails are taken from the stretches themselves, as Student's t with the freedom that their quantiles show.

use nalgebra::DMatrix;
use statrs::distribution::{ContinuousCDF, StudentsT};

use crate::answer::Place;
use crate::bench::Bench;
use crate::general::Lack;
use crate::ground::Ground;
use crate::samples::Samples;
use crate::stand::Stand;
use crate::subset::Subset;
use crate::tail::{log_chi2_tail, normal_deviate};

/// Widths of a mark, in correlation lengths of the roughness; steps are looked for at the places of the shortest.
const WIDTHS: [f64; 3] = [1.0, 2.0, 4.0];
/// Stretches of one width: at most this many.
const MOST: usize = 240;
/// Samples that must lie on a stretch, and elsewhere.
const FEWEST: usize = 3;
/// Freedom of the tails: heavier than with the first no mark can be told from the roughness, from the last on they are normal.
const FREEDOMS: [f64; 7] = [3.0, 4.0, 5.0, 7.0, 10.0, 15.0, 30.0];

/// One stretch of the plate with the signed deviate of friction on it.
struct Stretch {
    from: f64,
    to: f64,
    z: f64,
}

/// The strongest mark beside a stand.
pub(crate) fn marks(
    bench: &Bench<'_>,
    stand: &Stand,
    ground: &Ground,
    subset: &Subset,
    samples: &Samples,
    scale: &[f64],
) -> Lack {
    let nothing = Lack::nothing();
    let stretches = stretches(stand, ground, samples, scale);
    let Some(best) = stretches
        .iter()
        .max_by(|a, b| a.z.abs().total_cmp(&b.z.abs()))
    else {
        return nothing;
    };
    let (spread, freedom) = tails(&stretches);
    let deviate = normal_deviate(best.z.abs() / spread, freedom);
    let log_p = log_chi2_tail(deviate * deviate, 1) + (stretches.len() as f64).ln();
    // Neighbours that deviate alike belong to the same mark.
    let alike = |s: &&Stretch| s.z * best.z.signum() > 0.5 * best.z.abs();
    let near = |s: &&Stretch| s.to > best.from && s.from < best.to;
    let (from, to) = stretches
        .iter()
        .filter(alike)
        .filter(near)
        .fold((best.from, best.to), |(a, b), s| {
            (a.min(s.from), b.max(s.to))
        });
    Lack {
        log_p: log_p.min(0.0),
        place: Some(Place {
            axis: "position".into(),
            from,
            to,
            unit: "m".into(),
            runs: bench.run_names(subset),
        }),
        excess: (best.z * best.z - 1.0).max(0.0),
    }
}

/// All stretches that samples lie on, and what lies beyond each place.
fn stretches(stand: &Stand, ground: &Ground, samples: &Samples, scale: &[f64]) -> Vec<Stretch> {
    let Some(cells) = Cells::new(stand.sizes.length, samples) else {
        return Vec::new();
    };
    let sums = Sums::new(stand, ground, &cells, scale);
    let mut out = Vec::new();
    let mut before = 0;
    for share in WIDTHS {
        // Whole cells; where the plate is long against the roughness, widths fall together.
        let width = ((share * stand.sizes.length / cells.width).round() as usize).max(2);
        if width == before {
            continue;
        }
        before = width;
        let starts = (0..).step_by(width / 2);
        for from in starts.take_while(|from| from + width <= cells.count) {
            let to = from + width;
            let z = sums.deviate(ground, from, to);
            out.extend(z.map(|z| cells.stretch(from, to, z)));
        }
    }
    for middle in 1..cells.count {
        let z = sums.deviate(ground, middle, cells.count);
        out.extend(z.map(|z| cells.stretch(middle - 1, middle + 1, z)));
    }
    out
}

/// The plate in cells of half the shortest width.
struct Cells {
    lo: f64,
    width: f64,
    count: usize,
    /// The cell of each sample; what lies beyond the last whole one belongs to it.
    of_sample: Vec<usize>,
}

impl Cells {
    /// `None` where the runs pass no two places.
    fn new(length: f64, samples: &Samples) -> Option<Self> {
        let places = samples.place.iter();
        let (lo, hi) = places.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &x| {
            (a.min(x), b.max(x))
        });
        let width = (0.5 * WIDTHS[0] * length).max((hi - lo) / MOST as f64);
        let count = ((hi - lo) / width) as usize;
        let cell = |&x: &f64| (((x - lo) / width) as usize).min(count - 1);
        (count >= 2).then(|| Self {
            lo,
            width,
            count,
            of_sample: samples.place.iter().map(cell).collect(),
        })
    }

    fn stretch(&self, from: usize, to: usize, z: f64) -> Stretch {
        let edge = |k: usize| self.lo + self.width * k as f64;
        Stretch {
            from: edge(from),
            to: edge(to),
            z,
        }
    }
}

/// Friction on the plate up to each edge of the cells: friction on a stretch is the difference of two such columns, and whitening and
/// projecting are linear, so that each cell is whitened once for all stretches that it lies on.
struct Sums {
    /// Whitened; column e belongs to the cells before edge e.
    white: DMatrix<f64>,
    /// With the model's directions taken out.
    free: DMatrix<f64>,
    /// Samples before each edge.
    samples: Vec<usize>,
}

impl Sums {
    fn new(stand: &Stand, ground: &Ground, cells: &Cells, scale: &[f64]) -> Self {
        let mut own = DMatrix::zeros(scale.len(), cells.count);
        let mut samples = vec![0; cells.count + 1];
        for (i, (&cell, &friction)) in cells.of_sample.iter().zip(scale).enumerate() {
            own[(i, cell)] = friction;
            samples[cell + 1] += usize::from(friction != 0.0);
        }
        let white = summed(&stand.whiten_own(&own));
        for edge in 1..samples.len() {
            samples[edge] += samples[edge - 1];
        }
        Self {
            free: ground.project(&white),
            white,
            samples,
        }
    }

    /// Signed deviate of friction between two edges; `None` where too few samples lie there, or elsewhere.
    fn deviate(&self, ground: &Ground, from: usize, to: usize) -> Option<f64> {
        let on_it = self.samples[to] - self.samples[from];
        if on_it < FEWEST || self.white.nrows() < on_it + FEWEST {
            return None;
        }
        let between = |sums: &DMatrix<f64>| sums.column(to) - sums.column(from);
        let direction = ground.along(between(&self.free), between(&self.white).norm())?;
        let score = ground.score(&direction);
        let sign = score.coefficients.first().map_or(0.0, |c| c.signum());
        Some(sign * score.z())
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

/// Spread (at least 1) and freedom of the stretches' deviates, from their median and their ninth decile.
fn tails(stretches: &[Stretch]) -> (f64, f64) {
    let mut sizes: Vec<f64> = stretches.iter().map(|s| s.z.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let at = |q: f64| sizes[((sizes.len() - 1) as f64 * q) as usize];
    let (middle, high) = (at(0.5).max(1e-12), at(0.9));
    let quantile = |freedom: f64, share: f64| {
        StudentsT::new(0.0, 1.0, freedom).map_or(f64::NAN, |t| t.inverse_cdf(0.5 + 0.5 * share))
    };
    let freedom = FREEDOMS
        .into_iter()
        .find(|&f| quantile(f, 0.9) / quantile(f, 0.5) < high / middle)
        .unwrap_or(FREEDOMS[FREEDOMS.len() - 1]);
    ((middle / quantile(freedom, 0.5)).max(1.0), freedom)
}

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
/// Samples that must lie on a stretch.
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
    let (lo, hi) = samples
        .place
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &x| {
            (a.min(x), b.max(x))
        });
    let mut out = Vec::new();
    for (k, share) in WIDTHS.into_iter().enumerate() {
        let width = (share * stand.sizes.length).max(2.0 * (hi - lo) / MOST as f64);
        let count = (2.0 * (hi - lo) / width) as usize;
        let edges: Vec<(f64, f64)> = (0..count.saturating_sub(1))
            .map(|j| lo + 0.5 * width * j as f64)
            .map(|from| (from, from + width))
            .collect();
        let mut short = DMatrix::zeros(samples.len(), edges.len());
        for (i, &x) in samples.place.iter().enumerate() {
            let last = ((x - lo) / (0.5 * width)) as usize;
            for j in last.saturating_sub(1)..=last {
                if j < edges.len() && x >= edges[j].0 && x < edges[j].1 {
                    short[(i, j)] = scale[i];
                }
            }
        }
        out.extend(scored(stand, ground, &edges, &short));
        if k == 0 {
            let beyond = DMatrix::from_fn(samples.len(), edges.len(), |i, j| {
                let middle = 0.5 * (edges[j].0 + edges[j].1);
                if samples.place[i] > middle {
                    scale[i]
                } else {
                    0.0
                }
            });
            out.extend(scored(stand, ground, &edges, &beyond));
        }
    }
    out
}

/// Signed deviates of columns, those on which too few samples lie left out.
fn scored(
    stand: &Stand,
    ground: &Ground,
    edges: &[(f64, f64)],
    columns: &DMatrix<f64>,
) -> Vec<Stretch> {
    let white = stand.whiten_own(columns);
    let each = edges.iter().enumerate().filter_map(|(j, &(from, to))| {
        let on_it = columns.column(j).iter().filter(|c| **c != 0.0).count();
        if on_it < FEWEST || columns.nrows() - on_it < FEWEST {
            return None;
        }
        let direction = ground.direction(&white.columns(j, 1).into_owned())?;
        let score = ground.score(&direction);
        let sign = score.coefficients.first().map_or(0.0, |c| c.signum());
        let z = sign * score.z();
        Some(Stretch { from, to, z })
    });
    each.collect()
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

//! Marks on the plate: a scratch, a seam, a spot of something, short against the travel and the same in every run; or a step, from which
//! on friction is another.
//!
//! Roughness fixed to the plate repeats in every run as a mark does, and is no error of a law. A mark is told from it by its
//! size alone: friction raised or lowered by a factor over a short stretch, evenly or towards its middle, or beyond a place, scored against
//! the field's own spread. The spread's tails are taken from all marks that are asked for, as Student's t with the freedom that their
//! quantiles show; but a mark that stands out of all others as none of such a tail would is no part of it.
//!
//! A mark makes the plate look rougher than it is, so much that it may not be seen any more. The strongest one, and the two strongest
//! together, are weighed again with the noise estimated beside them, by what their likelihood gains, each model under its own noise.

use fitting::noise::Sizes;
use nalgebra::DMatrix;
use rayon::prelude::*;
use statrs::distribution::{ContinuousCDF, StudentsT};

use crate::answer::Place;
use crate::bench::Bench;
use crate::general::Lack;
use crate::ground::Ground;
use crate::places::{Cells, Course, Near, Shape, Sums, closely, with_edge};
use crate::samples::Samples;
use crate::stand::Stand;
use crate::subset::Subset;
use crate::swallowed::may_hide;
use crate::tail::{log_chi2_tail, normal_deviate};

/// Standard deviations of the strongest mark from which the noise is estimated beside it.
const SUSPECT: f64 = 3.0;
/// Share of what the strongest mark explains beside a plate that is hardly rough from which on the next one is weighed with it.
const ANOTHER: f64 = 0.3;
/// Roughness of the plate beside which its place is sought, as a share of the smaller one of plate and runs.
const SHARP: f64 = 0.25;
/// Freedom of the tails: heavier than with the first no mark can be told from the roughness, from the last on they are normal.
const FREEDOMS: [f64; 7] = [3.0, 4.0, 5.0, 7.0, 10.0, 15.0, NORMAL];
/// Freedom of tails that count as normal.
const NORMAL: f64 = 30.0;
/// Where the next one is y, the largest of many is beyond x with the probability Q(x) / Q(y), Q the tail. A mark stands alone where that
/// is less than this: about three times as large as all others with tails that fall with the fourth power, and less with lighter ones.
const LONELY: f64 = 1.0 / 81.0;

/// A mark, or two of them, beside a stand.
#[derive(Clone)]
pub(crate) struct Mark {
    /// Of the stronger one.
    pub(crate) place: Place,
    /// Logarithm of the tail probability, the search paid for.
    pub(crate) log_p: f64,
    /// What -2 log likelihood falls by with the mark in the model, each at its own noise and scatter, less what the search costs.
    pub(crate) explained: f64,
    /// What the search costs.
    search: f64,
}

impl Mark {
    /// What -2 log likelihood falls by, nothing paid for the search.
    pub(crate) fn saved(&self) -> f64 {
        self.explained + self.search
    }

    pub(crate) fn lack(self) -> Lack {
        Lack {
            log_p: self.log_p,
            place: Some(self.place),
            excess: self.explained.max(0.0),
        }
    }
}

/// What was found beside a stand.
pub(crate) struct Found {
    /// The mark, or the two, that explain most, the search paid for.
    pub(crate) strongest: Mark,
    /// The single mark that saves most, nothing paid for the search.
    pub(crate) likeliest: Mark,
}

/// Looks for marks beside a stand.
pub(crate) fn find(
    bench: &Bench<'_>,
    subset: &Subset,
    stand: &Stand,
    ground: &Ground,
) -> Option<Found> {
    let samples = subset.samples_on_the_plate(bench);
    let scale = subset.gather(stand.fitted.friction(bench));
    let search = Search {
        cells: Cells::new(stand.sizes.length, &samples)?,
        samples,
        scale: scale.as_slice(),
        names: bench.run_names(subset),
    };
    let sums = Sums::new(stand, ground, &search.cells, search.scale);
    let marks = scored(ground, &sums, search.cells.shapes());
    let best = largest(&marks)?;
    let seen = search.mark(
        search.together(&marks, best),
        &Weight {
            deviance: best.z * best.z,
            explained: ground.explained(&sums.direction(ground, best.shape)?),
            tails: tails(&marks),
            asked: marks.len(),
            columns: 1,
        },
    );
    let (mut single, mut double) = (vec![seen], Vec::new());
    if is_suspect(best, stand.sizes)
        && let Some((first, both)) = search.sharply(bench, subset, stand)
    {
        let weighed = |kind| {
            search.beside_noise_of_a_kind(bench, subset, (stand, kind), (&first, both.as_ref()))
        };
        let kinds = kinds_of_noise(stand.sizes).into_par_iter();
        let (one, two): (Vec<_>, Vec<_>) = kinds.map(weighed).unzip();
        single.extend(one.into_iter().flatten());
        double.extend(two.into_iter().flatten());
    }
    let saved = |mark: &Mark| mark.saved();
    let likeliest = (single.iter()).max_by(|a, b| saved(a).total_cmp(&saved(b)));
    let likeliest = likeliest?.clone();
    let all = single.into_iter().chain(double);
    Some(Found {
        strongest: all.max_by(|a, b| a.explained.total_cmp(&b.explained))?,
        likeliest,
    })
}

/// Kinds of noise beside which marks are weighed, with the sizes to begin from: of one length (a length of its own for the plate's roughness takes
/// up a step), and the kind that these sizes have.
fn kinds_of_noise(sizes: Sizes) -> Vec<Sizes> {
    let one_length = Sizes {
        plate_ratio: 1.0,
        plate_smoothing: 0.0,
        ..sizes
    };
    let mut kinds = vec![one_length];
    if sizes != one_length {
        kinds.push(sizes);
    }
    kinds
}

/// Whether the strongest mark is worth a noise of its own: it is seen, or the plate is so rough that it may hide it.
fn is_suspect(best: Scored, sizes: Sizes) -> bool {
    sizes.plate > 0.0 && (best.z.abs() >= SUSPECT || may_hide(sizes))
}

/// A mark with its signed deviate.
#[derive(Clone, Copy)]
struct Scored {
    shape: Shape,
    z: f64,
}

fn scored(ground: &Ground, sums: &Sums, shapes: Vec<Shape>) -> Vec<Scored> {
    let score = |shape| {
        let score = ground.score(&sums.direction(ground, shape)?);
        Some(Scored {
            shape,
            z: score.signed_z(),
        })
    };
    shapes.into_par_iter().filter_map(score).collect()
}

fn largest(marks: &[Scored]) -> Option<Scored> {
    let size = |a: &&Scored, b: &&Scored| a.z.abs().total_cmp(&b.z.abs());
    marks.iter().max_by(size).copied()
}

/// What the strongest of the marks is worth.
struct Weight {
    /// Square of its deviate.
    deviance: f64,
    explained: f64,
    /// Spread and freedom of the others' deviates.
    tails: (f64, f64),
    /// How many marks were asked for.
    asked: usize,
    /// Heights that it has.
    columns: usize,
}

/// Where marks are looked for.
struct Search<'a> {
    cells: Cells,
    samples: Samples,
    scale: &'a [f64],
    names: Vec<String>,
}

impl Search<'_> {
    /// A mark, and two of them, weighed once more with the noise of one kind estimated beside them; that beside one is near that beside two.
    fn beside_noise_of_a_kind(
        &self,
        bench: &Bench<'_>,
        subset: &Subset,
        (stand, kind): (&Stand, Sizes),
        (one, two): (&Near, Option<&Near>),
    ) -> (Option<Mark>, Option<Mark>) {
        let places = subset.all_places(bench);
        let friction = stand.fitted.friction(bench);
        let beside = |near: &Near, begun: Sizes| {
            let columns = Course::columns(&near.courses, &places, friction);
            let (fitted, jacobian) = (&stand.fitted, &stand.jacobian);
            let sizes = bench.noise_of_their_kind(subset, fitted, jacobian, &columns, begun);
            (sizes, columns)
        };
        let (sizes, columns) = beside(one, kind);
        let weigh =
            |near, sizes, columns| self.weighed(bench, subset, (stand, sizes), (near, columns));
        rayon::join(
            || weigh(one, sizes, columns),
            || {
                let two = two?;
                let (sizes, columns) = beside(two, sizes);
                weigh(two, sizes, columns)
            },
        )
    }

    /// Marks weighed under the noise of these sizes.
    fn weighed(
        &self,
        bench: &Bench<'_>,
        subset: &Subset,
        (stand, sizes): (&Stand, Sizes),
        (near, columns): (&Near, DMatrix<f64>),
    ) -> Option<Mark> {
        let own = Stand::new(bench, subset, stand.fitted.clone(), sizes);
        let white = own.whiten(subset, &columns);
        let direction = own.ground.direction(&white)?;
        // Either noise is offered to the model without the mark too: one grid of the plate's nodes may suit all models better than another.
        let without = stand.deviance.min(own.deviance);
        let saved = without - own.deviance + own.ground.explained(&direction);
        let rest = own.ground_beside(&white);
        let sums = Sums::new(&own, &rest, &self.cells, self.scale);
        let others = scored(&rest, &sums, self.cells.shapes());
        let (spread, freedom) = tails(&others);
        let size = saved.max(0.0).sqrt();
        let apart = self.largest_apart(&others, near.extent);
        let alone = is_alone(size / spread, apart / spread, freedom);
        let weight = Weight {
            deviance: saved.max(0.0),
            explained: saved,
            tails: (spread, if alone { f64::INFINITY } else { freedom }),
            asked: near.tried,
            columns: near.courses.len(),
        };
        Some(self.mark(near.extent, &weight))
    }

    /// Size of the largest of the marks that do not touch this place.
    fn largest_apart(&self, marks: &[Scored], (from, to): (f64, f64)) -> f64 {
        let apart = |m: &&Scored| {
            let (begin, end) = self.cells.extent(m.shape);
            end < from || begin > to
        };
        let sizes = marks.iter().filter(apart).map(|m| m.z.abs());
        sizes.fold(0.0, f64::max)
    }

    /// The strongest mark, and where another one is nearly as strong both together, as they are found beside a plate that is hardly rough:
    /// roughness that was estimated with marks in it lets places that are far apart fit alike.
    fn sharply(
        &self,
        bench: &Bench<'_>,
        subset: &Subset,
        stand: &Stand,
    ) -> Option<(Near, Option<Near>)> {
        let sizes = Sizes {
            plate: SHARP * stand.sizes.plate.min(stand.sizes.private),
            plate_smoothing: stand.sizes.smoothing,
            plate_ratio: 1.0,
            ..stand.sizes
        };
        let sharp = Stand::new(bench, subset, stand.fitted.clone(), sizes);
        let samples = &self.samples;
        let strongest_beside = |others: &[Course]| {
            let columns = Course::columns(others, &samples.place, self.scale);
            let ground = sharp.ground_beside(&sharp.whiten_own(&columns));
            let sums = Sums::new(&sharp, &ground, &self.cells, self.scale);
            let all = scored(&ground, &sums, self.cells.shapes());
            let extent = self.cells.extent(largest(&all)?.shape);
            let mut near = closely(&sharp, &ground, samples, self.scale, extent)?;
            // As many near every mark of the first look could have been the strongest.
            near.tried *= all.len();
            Some(with_edge(&sharp, others, samples, self.scale, near))
        };
        let first = strongest_beside(&[])?;
        let second = strongest_beside(&first.courses)
            .filter(|second| second.explained > ANOTHER * first.explained);
        let both = second.map(|second| first.and(&second));
        Some((first, both))
    }

    /// A mark that sits here.
    fn mark(&self, (from, to): (f64, f64), weight: &Weight) -> Mark {
        let price = (weight.asked as f64).ln();
        let (spread, freedom) = weight.tails;
        let deviate = normal_deviate(weight.deviance.sqrt() / spread, freedom);
        Mark {
            place: Place {
                axis: "position".into(),
                from,
                to,
                unit: "m".into(),
                runs: self.names.clone(),
            },
            log_p: (log_chi2_tail(deviate * deviate, weight.columns) + price).min(0.0),
            explained: weight.explained - 2.0 * price,
            search: 2.0 * price,
        }
    }

    /// Neighbours that deviate alike belong to the same mark.
    fn together(&self, marks: &[Scored], best: Scored) -> (f64, f64) {
        let within = self.cells.extent(best.shape);
        let alike = |m: &&Scored| m.z * best.z.signum() > 0.5 * best.z.abs();
        (marks.iter().filter(alike))
            .map(|m| self.cells.extent(m.shape))
            .filter(|(from, to)| *to > within.0 && *from < within.1)
            .fold(within, |(a, b), (from, to)| (a.min(from), b.max(to)))
    }
}

/// Whether a mark of this size is no part of the tail, of such a freedom, of those apart from it.
fn is_alone(size: f64, largest_apart: f64, freedom: f64) -> bool {
    let tail = |x: f64| StudentsT::new(0.0, 1.0, freedom).map_or(f64::NAN, |t| t.sf(x));
    tail(size) < LONELY * tail(largest_apart)
}

/// Spread (at least 1) and freedom of the marks' deviates, from their median and their ninth decile.
fn tails(marks: &[Scored]) -> (f64, f64) {
    let mut sizes: Vec<f64> = marks.iter().map(|m| m.z.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let at = |q: f64| sizes[((sizes.len() - 1) as f64 * q) as usize];
    let (middle, high) = (at(0.5).max(1e-12), at(0.9));
    let quantile = |freedom: f64, share: f64| {
        StudentsT::new(0.0, 1.0, freedom).map_or(f64::NAN, |t| t.inverse_cdf(0.5 + 0.5 * share))
    };
    let freedom = FREEDOMS
        .into_iter()
        .find(|&f| quantile(f, 0.9) / quantile(f, 0.5) < high / middle)
        .unwrap_or(NORMAL);
    ((middle / quantile(freedom, 0.5)).max(1.0), freedom)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Plates of so many whose largest mark is said to stand alone, with tails of Student's t and taken for such of another freedom; marks
    /// that know nothing of one another.
    fn alone(plates: u64, freedom: f64, taken: f64) -> u64 {
        const MARKS: usize = 300;
        let student = StudentsT::new(0.0, 1.0, freedom).expect("a distribution");
        let mut state = 7_u64;
        let mut uniform = || {
            state = (state.wrapping_mul(6_364_136_223_846_793_005)).wrapping_add(1);
            ((state >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
        };
        let plate = |_: &u64| {
            let marks = (0..MARKS).map(|_| student.inverse_cdf(uniform()).abs());
            let (first, second) = marks.fold((0.0_f64, 0.0_f64), |(first, second), z| {
                (first.max(z), second.max(z.min(first)))
            });
            is_alone(first, second, taken)
        };
        (0..plates).filter(plate).count() as u64
    }

    /// Of 400 plates 400 / 81, five, are expected where the tails are those for which they are taken, fewer where they fall faster.
    #[test]
    fn tails_seldom_make_a_mark_that_stands_alone() {
        for freedom in [4.0, 10.0, NORMAL] {
            let heavy = alone(400, freedom, freedom);
            assert!(heavy <= 12, "{freedom}: {heavy}");
        }
        assert!(alone(400, 4.0, 4.0) >= 1);
        assert_eq!(alone(400, NORMAL, 4.0), 0);
        // where the tails fall with the power 4 a mark of 17 where all others are below 5 is no roughness, one of 13 may be
        assert!(is_alone(17.0, 5.0, 4.0) && !is_alone(13.0, 5.0, 4.0));
        assert!(is_alone(8.0, 4.0, 10.0) && !is_alone(5.0, 4.0, 10.0));
    }
}

//! Held-out errors weighed by the noise, for where the floor from repeats says too little.
//!
//! A run's scatter is one number for hundreds of samples, and the plate's roughness repeats and is in no floor from repeats: the
//! squared errors of the runs that were held out hold what these runs drew, which may be far from what noise draws on the
//! average. In the drop from the law to the extension it cancels, the better if errors are weighed by the noise; and what is left
//! of the explainable error is the extension's own error A, where nothing is left unexplained:
//!
//! ```text
//! share = D / (D + A),   D = sum |y - f_law|^2 - |y - f_fold|^2                                         (D8)
//!                        A = sum |f_fold - f_all|^2 + p H / R
//! ```
//!
//! Sums run over folds and their held-out runs. f_fold, f_all: the extension's
//! predictions from the fold and from the whole campaign, whose p parameters make it wrong by p = tr(V^-1 J C J') over all R runs;
//! H runs were held out.
//!
//! What a fold says of a run whose condition it never saw may rest on parameters that its own runs hardly tell; one such run
//! would then outweigh all others. Errors count by the noise and by that doubt:
//!
//! ```text
//! |r|^2 = |e|^2 - (B'e)' (I + B'B)^-1 B'e,   e = M r,   B = M J L,   L L' = C                           (D11)
//! ```
//!
//! which is e'(I + B B')^-1 e; M whitens one run's samples, scatter included, J and C are the Jacobian and the covariance of the extension
//! that the fold fitted, for the law, the extension and the scrambled ones alike.

use fitting::noise::Whitener;
use nalgebra::DMatrix;

use crate::bench::Bench;
use crate::floor;
use crate::fold::Fold;
use crate::selection::Selected;
use crate::subset::Subset;
use crate::whole::Whole;

/// The noise that weighs errors of held-out runs.
pub(crate) struct Weighed<'a> {
    bench: &'a Bench<'a>,
    subset: &'a Subset,
    whitener: Whitener,
    /// A of (D8).
    pub(crate) own: f64,
    /// The share of A that may be wrong: two standard deviations of a chi-squared with p degrees of freedom, over its mean.
    pub(crate) wrong: f64,
    /// B of (D11) and a root of I + B'B: for each fold, for each run that it holds out.
    doubts: Vec<Vec<Doubt>>,
}

struct Doubt {
    white: DMatrix<f64>,
    /// R, upper triangular, R'R = I + B'B.
    root: DMatrix<f64>,
}

impl<'a> Weighed<'a> {
    /// `None` where something is left unexplained, or where errors are not those of the record that was searched.
    pub(crate) fn new(
        bench: &'a Bench<'a>,
        whole: &Whole<'_>,
        selected: &'a Selected,
        folds: &[Fold],
    ) -> Option<Self> {
        if whole.apart || selected.leaves_something() {
            return None;
        }
        let (stand, subset) = (&selected.stand, &selected.subset);
        let parameters = stand.columns.len().max(1) as f64;
        let mut weighed = Self {
            bench,
            subset,
            whitener: stand.likely_noise(),
            own: 0.0,
            wrong: 2.0 * (2.0 / parameters).sqrt(),
            doubts: Vec::new(),
        };
        weighed.doubts = folds
            .iter()
            .map(|fold| {
                fold.held
                    .iter()
                    .map(|&run| weighed.doubt(fold, run))
                    .collect()
            })
            .collect();
        let all = &stand.fitted.prediction;
        let apart = folds
            .iter()
            .enumerate()
            .flat_map(|(k, fold)| weighed.squares(k, fold, &differences(all, &fold.extended)));
        let apart: f64 = apart.sum();
        let held: usize = folds.iter().map(|fold| fold.held.len()).sum();
        weighed.own = apart + parameters * held as f64 / bench.samples.runs.len() as f64;
        Some(weighed)
    }

    /// |y - f|^2 (D11) of a prediction f for each run that the k-th fold holds out.
    pub(crate) fn errors(&self, k: usize, fold: &Fold, prediction: &[f64]) -> Vec<f64> {
        let error = differences(&self.bench.experiment.measured_n, prediction);
        self.squares(k, fold, &error)
    }

    /// |r|^2 (D11) for each run that the k-th fold holds out.
    fn squares(&self, k: usize, fold: &Fold, stacked: &[f64]) -> Vec<f64> {
        let white = self.white(fold, stacked);
        let runs = self.doubts[k].iter().zip(white.column_iter());
        runs.map(|(doubt, e)| {
            let along = doubt
                .root
                .tr_solve_upper_triangular(&doubt.white.tr_mul(&e));
            // R is no more singular than I: only a doubt that is no number leaves nothing to solve.
            let excused = along.map_or(f64::NAN, |along| along.norm_squared());
            e.norm_squared() - excused
        })
        .collect()
    }

    /// M e for each run that a fold holds out, one column a run.
    fn white(&self, fold: &Fold, stacked: &[f64]) -> DMatrix<f64> {
        let mut columns = DMatrix::zeros(stacked.len(), fold.held.len());
        for (k, &run) in fold.held.iter().enumerate() {
            for i in self.bench.samples.runs[run].clone() {
                columns[(i, k)] = stacked[i];
            }
        }
        self.whitener
            .whiten_columns(&self.subset.gather_columns(&columns))
    }

    /// What (D11) needs of one run.
    fn doubt(&self, fold: &Fold, run: usize) -> Doubt {
        let mut columns = DMatrix::zeros(fold.doubt.nrows(), fold.doubt.ncols());
        let rows = self.bench.samples.runs[run].clone();
        let doubt = fold.doubt.rows(rows.start, rows.len());
        // A run that the fold's extension cannot predict is not excused by it.
        if doubt.iter().all(|x| x.is_finite()) {
            columns.rows_mut(rows.start, rows.len()).copy_from(&doubt);
        }
        let white = self
            .whitener
            .whiten_columns(&self.subset.gather_columns(&columns));
        Doubt {
            root: root(&white),
            white,
        }
    }
}

/// R of (D11). From B below I and not from B'B, in whose rounding I is lost beside a doubt of 1e8 standard deviations.
fn root(white: &DMatrix<f64>) -> DMatrix<f64> {
    let (n, p) = white.shape();
    let mut stacked = DMatrix::identity(p + n, p);
    stacked.rows_mut(p, n).copy_from(white);
    stacked.qr().unpack_r()
}

fn differences(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

/// Sum of squared errors of held-out runs by which the floor from repeats may be wrong: the plate's roughness, and two standard
/// deviations of what the scatter between runs draws. A run that is held out by several folds drew once.
pub(crate) fn beside_repeats(whole: &Whole<'_>, selected: &Selected, folds: &[Fold]) -> f64 {
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
    plate + 2.0 * (2.0 * variance).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_doubt_beyond_the_rounding_of_its_square_keeps_its_root() {
        // Columns along one direction: I + B'B has an eigenvalue beyond 1e18, and all others are 1.
        let mut without = 0;
        for case in 1..=20 {
            let white = DMatrix::from_fn(50, 3, |i, k| {
                1e9 * (1.0 + i as f64 / 7.0) * (case as f64 * 0.37 + k as f64).sin()
            });
            let squared = DMatrix::identity(3, 3) + white.tr_mul(&white);
            without += usize::from(nalgebra::Cholesky::new(squared).is_none());
            let root = root(&white);
            assert!((1..3).all(|k| root[(k, k)].abs() > 0.5), "{root}");
        }
        assert!(without > 0, "rounding never took the square its root");
    }

    #[test]
    fn the_root_is_that_of_the_square() {
        let white = DMatrix::from_fn(7, 3, |i, k| ((3 * i + 2 * k) as f64).sin());
        let squared = DMatrix::identity(3, 3) + white.tr_mul(&white);
        let root = root(&white);
        assert!((root.tr_mul(&root) - squared).amax() < 1e-12);
    }

    #[test]
    fn no_doubt_has_no_root() {
        assert_eq!(root(&DMatrix::zeros(5, 0)).ncols(), 0);
    }
}

//! The restricted likelihood of the noise's sizes, the mean's parameters profiled out.
//!
//! ```text
//! C(sizes) = log det V + log det(X' V^-1 X) + r' P r,   P = V^-1 - V^-1 X (X' V^-1 X)^-1 X' V^-1      (N3)
//! ```
//!
//! X spans the mean's Jacobian and a gain for every run, so that the scatter between runs drops out and the
//! roughness, its length and the sensor noise are estimated from what happens within runs. Inner products need no
//! root of V: with the columns filtered along the runs (index 0) and A, U of the plate's field (N10),
//! a' V^-1 b = a0' b0 - (U'^-1 A' a0)' (U'^-1 A' b0).

use std::ops::Range;

use nalgebra::{Cholesky, DMatrix, DVector};

use super::along::Along;
use super::context::{Context, Sizes};
use super::curvature::Spectra;
use super::field::Field;
use super::grid::Grid;
use super::rows::Rows;
use super::scatter::{orthonormal_basis, stacked_gains};
use super::search::Level;
use super::tiles::{SIDE, Tile};
use super::vectors::{dot, dots, wide};

/// The data of the criterion, the columns orthonormalised once.
pub(super) struct Criterion<'a> {
    context: &'a Context,
    /// Gains of the runs in the mean.
    gains: Gains,
    /// Basis of the rest of the mean's space, the residual as last column.
    columns: DMatrix<f64>,
    spectra: Spectra,
}

/// Share of a column beyond the gains below which it is a sum of them.
const PARALLEL: f64 = 1e-7;

/// A gain for every run: as many columns, each zero outside of its run, side by side in one.
#[derive(Clone, Default)]
struct Gains {
    runs: Vec<Range<usize>>,
    /// Force as recorded, of unit length in each run.
    force: Vec<f64>,
    /// The gain that each sample belongs to, `usize::MAX` of none.
    owner: Vec<usize>,
}

impl Gains {
    fn of(context: &Context) -> Self {
        let mut force = stacked_gains(context);
        let mut runs = Vec::new();
        let mut owner = vec![usize::MAX; force.len()];
        for run in &context.runs {
            let own = &mut force[run.clone()];
            let norm = own.iter().map(|f| f * f).sum::<f64>().sqrt();
            if norm > 0.0 && norm.is_finite() {
                own.iter_mut().for_each(|f| *f /= norm);
                owner[run.clone()].fill(runs.len());
                runs.push(run.clone());
            }
        }
        Self { runs, force, owner }
    }

    /// Takes what is parallel to the gains out of a column; one that is a sum of them is zero then.
    fn take_out(&self, column: &mut [f64]) {
        let before = dot(column, column);
        // Twice is enough (Kahan).
        for run in self.runs.iter().chain(&self.runs) {
            let (own, force) = (&mut column[run.clone()], &self.force[run.clone()]);
            let along = dot(own, force);
            for (x, f) in own.iter_mut().zip(force) {
                *x -= along * f;
            }
        }
        if dot(column, column) <= PARALLEL * PARALLEL * before {
            column.fill(0.0);
        }
    }
}

impl<'a> Criterion<'a> {
    /// `own_gains`: whether the mean holds a gain for every run beside the columns of `mean`.
    pub(super) fn new(
        context: &'a Context,
        mean: &DMatrix<f64>,
        own_gains: bool,
        residual: &DVector<f64>,
    ) -> Self {
        let gains = match own_gains {
            true => Gains::of(context),
            false => Gains::default(),
        };
        let (mut mean, mut rest) = (mean.clone(), residual.clone());
        let columns = mean.as_mut_slice().chunks_mut(residual.len().max(1));
        columns.for_each(|column| gains.take_out(column));
        gains.take_out(rest.as_mut_slice());
        let basis = orthonormal_basis(&mean);
        rest -= &basis * basis.tr_mul(&rest);
        let p = basis.ncols();
        let mut columns = basis.resize_horizontally(p + 1, 0.0);
        columns.set_column(p, &rest);
        Self {
            context,
            gains,
            columns,
            spectra: Spectra::of(context),
        }
    }

    /// The curvature that C may be expected to have at `x`, a point that stands for these sizes.
    pub(super) fn curvature(
        &self,
        sizes: impl Fn(&[f64]) -> Sizes,
        x: &[f64],
    ) -> Option<DMatrix<f64>> {
        self.spectra.curvature(sizes, x)
    }

    /// Degrees of freedom that the mean leaves.
    pub(super) fn degrees_of_freedom(&self) -> usize {
        let taken = self.columns.ncols() + self.gains.runs.len();
        (self.columns.nrows() + 1).saturating_sub(taken)
    }

    /// Root mean square of the residual that the mean leaves.
    pub(super) fn residual_rms(&self) -> f64 {
        let p = self.columns.ncols() - 1;
        (self.columns.column(p).norm_squared() / self.degrees_of_freedom().max(1) as f64).sqrt()
    }

    /// The same with further columns in the mean.
    pub(super) fn with_columns(&self, further: &DMatrix<f64>) -> Self {
        let (p, q) = (self.columns.ncols() - 1, further.ncols());
        let mut mean = self.columns.clone().resize_horizontally(p + q, 0.0);
        mean.columns_mut(p, q).copy_from(further);
        let residual = self.columns.column(p).into_owned();
        Self::new(self.context, &mean, !self.gains.runs.is_empty(), &residual)
    }

    /// C of (N3); infinite where the sizes make no covariance.
    pub(super) fn value(&self, sizes: &Sizes, spacing: f64) -> f64 {
        self.level(sizes, spacing).value
    }

    /// The same with r' P r, which tells how C changes as all sizes grow together.
    pub(super) fn level(&self, sizes: &Sizes, spacing: f64) -> Level {
        let (gram, log_det) = self.whitened(self.columns.clone(), sizes, spacing);
        let p = gram.nrows() - 1;
        let Some(factor) = Cholesky::new(gram.view((0, 0), (p, p)).into_owned()) else {
            return Level::NONE;
        };
        let cross = gram.view((0, p), (p, 1)).into_owned();
        let explained = if p > 0 {
            cross.dot(&factor.solve(&cross))
        } else {
            0.0
        };
        let lower = factor.l();
        let log_mean: f64 = 2.0 * (0..p).map(|j| lower[(j, j)].ln()).sum::<f64>();
        let squares = gram[(p, p)] - explained;
        let value = log_det + log_mean + squares;
        if value.is_finite() {
            Level { value, squares }
        } else {
            Level::NONE
        }
    }

    /// (x' P r)^2 / (x' P x) of each of the columns x: what r' P r falls by with that column in the mean.
    pub(super) fn scores(
        &self,
        further: &DMatrix<f64>,
        sizes: &Sizes,
        spacing: f64,
    ) -> Option<Vec<f64>> {
        let (p, q) = (self.columns.ncols() - 1, further.ncols());
        let mut columns = self.columns.clone().resize_horizontally(p + 1 + q, 0.0);
        for (k, column) in further.column_iter().enumerate() {
            columns.set_column(p + 1 + k, &column);
        }
        let (gram, _) = self.whitened(columns, sizes, spacing);
        let p = gram.nrows() - 1 - q;
        let factor = Cholesky::new(gram.view((0, 0), (p, p)).into_owned())?;
        let cross = gram.view((0, p), (p, 1 + q)).into_owned();
        let seen = factor.solve(&cross);
        let left = |a: usize, b: usize| gram[(p + a, p + b)] - cross.column(a).dot(&seen.column(b));
        let each = (1..=q).map(|k| left(0, k).powi(2) / left(k, k));
        Some(
            each.map(|score| if score.is_finite() { score } else { 0.0 })
                .collect(),
        )
    }

    /// The same with a level of its own for every run in the mean.
    pub(super) fn with_levels(&self) -> Self {
        let runs = &self.context.runs;
        let level = |i: usize, k: usize| f64::from(u8::from(runs[k].contains(&i)));
        self.with_columns(&DMatrix::from_fn(self.columns.nrows(), runs.len(), level))
    }

    /// Friction beyond places of the plate, evenly chosen, and friction that grows along it, as columns.
    pub(super) fn steps_and_slope(&self, places: usize) -> DMatrix<f64> {
        let (lo, hi) = self.context.extent();
        let mut courses = DMatrix::from_fn(self.columns.nrows(), places + 1, |i, k| {
            let share = (self.context.place[i] - lo) / (hi - lo).max(f64::MIN_POSITIVE);
            let course = match k < places {
                true => f64::from(u8::from(share > (k as f64 + 0.5) / places as f64)),
                false => share,
            };
            course * self.context.scale[i]
        });
        for mut course in courses.column_iter_mut() {
            self.context.recorded(course.as_mut_slice());
        }
        courses
    }

    /// The Gram matrix X' V^-1 X of the gains and the columns, in this order, and log det V.
    fn whitened(
        &self,
        mut columns: DMatrix<f64>,
        sizes: &Sizes,
        spacing: f64,
    ) -> (DMatrix<f64>, f64) {
        let grid = Grid::new(self.context, spacing);
        let undone = self.context.undone(sizes);
        let along = Along::new(self.context, sizes, &undone, grid.unresolved(sizes));
        let n = columns.nrows();
        let mut parts: Vec<&mut [f64]> = columns.as_mut_slice().chunks_mut(n).collect();
        let mut gains = self.gains.clone();
        if !gains.force.is_empty() {
            parts.push(&mut gains.force);
        }
        parts.iter_mut().for_each(|column| undone.take_out(column));
        along.whiten(&mut parts);
        let mut gram = gains.gram_beside(&columns);
        let mut log_det = along.log_det - 2.0 * undone.log_det();
        if sizes.plate > 0.0 {
            let rows = Rows::new(self.context, sizes, &grid, &along);
            let field = Field::new(&rows, &grid, sizes);
            log_det += field.log_det;
            gram -= self::gram(&seen_by_the_plate(
                &field,
                &gains,
                &self.gains.owner,
                &columns,
            ));
        }
        (gram, log_det)
    }
}

impl Gains {
    /// The Gram matrix of these columns and of further ones.
    fn gram_beside(&self, columns: &DMatrix<f64>) -> DMatrix<f64> {
        let (k, q) = (self.runs.len(), columns.ncols());
        let mut out = DMatrix::zeros(k + q, k + q);
        out.view_mut((k, k), (q, q)).copy_from(&gram(columns));
        let n = columns.nrows();
        for (j, run) in self.runs.iter().enumerate() {
            let force = &self.force[run.clone()];
            out[(j, j)] = dot(force, force);
            for (c, column) in columns.as_slice().chunks(n).enumerate() {
                let of = dot(&column[run.clone()], force);
                (out[(j, k + c)], out[(k + c, j)]) = (of, of);
            }
        }
        out
    }
}

/// U'^-1 A' x of the gains and the columns, in this order.
fn seen_by_the_plate(
    field: &Field,
    gains: &Gains,
    owner: &[usize],
    columns: &DMatrix<f64>,
) -> DMatrix<f64> {
    let mut seen = DMatrix::zeros(field.nodes, gains.runs.len() + columns.ncols());
    let mut keep = |first: usize, count: usize, of: Vec<Tile>| {
        for k in 0..count {
            let column = seen.column_mut(first + k).into_iter();
            for (slot, row) in column.zip(of.iter().flatten()) {
                *slot = row[k];
            }
        }
    };
    let of_gains = field.seen_owned(gains.runs.len(), owner, &gains.force);
    for (first, block) in (0..gains.runs.len()).step_by(SIDE).zip(of_gains) {
        keep(first, SIDE.min(gains.runs.len() - first), block);
    }
    let n = columns.nrows();
    for (c, block) in columns.as_slice().chunks(n * SIDE).enumerate() {
        let own = |i: usize| {
            let mut lanes = [0.0; SIDE];
            for (lane, x) in lanes.iter_mut().zip((i..block.len()).step_by(n)) {
                *lane = block[x];
            }
            lanes
        };
        keep(
            gains.runs.len() + c * SIDE,
            block.len() / n,
            field.seen(own),
        );
    }
    seen
}

/// Rows of one block of a Gram matrix: all its columns fit a processor's second cache.
const BLOCK: usize = 512;
/// X'X, by dot products in eight lanes.
pub(super) fn gram(columns: &DMatrix<f64>) -> DMatrix<f64> {
    wide(
        #[inline(always)]
        || gram_by_dots(columns),
    )
}

/// Block by block of rows, and in each two columns by two: every number that is loaded serves twice.
#[inline(always)]
fn gram_by_dots(columns: &DMatrix<f64>) -> DMatrix<f64> {
    let (n, p) = columns.shape();
    let data = columns.as_slice();
    let mut out = DMatrix::zeros(p, p);
    for from in (0..n).step_by(BLOCK) {
        let to = (from + BLOCK).min(n);
        let column = |j: usize| {
            let j = j.min(p - 1);
            &data[j * n + from..j * n + to]
        };
        for i in (0..p).step_by(2) {
            for j in (0..=i).step_by(2) {
                let of = dots([column(i), column(i + 1)], [column(j), column(j + 1)]);
                for (a, b) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                    if i + a < p && j + b <= i + a {
                        out[(i + a, j + b)] += of[a][b];
                    }
                }
            }
        }
    }
    out.fill_upper_triangle_with_lower_triangle();
    out
}

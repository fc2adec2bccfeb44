//! W with W'W = V^-1, V the covariance of (N1), applied in time linear in the samples.
//!
//! Three factors: the filter along the runs, what takes out the plate's field, and the root of the scatter,
//! (I + s^2 H H')^(-1/2) = I - U diag(1 - 1/sqrt(1 + s^2 sigma^2)) U', H = U sigma E' being the gains as the first two factors leave them.
//!
//! The field is taken out of all samples at once, (N10), where only inner products count: then W has rows for the plate's nodes below those of the
//! samples. Sample by sample ([`Whitener::by_sample`]) it is square and its rows are innovations, at several times the price.

use std::ops::Range;
use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::along::{Along, TOGETHER};
use super::channel::Undone;
use super::context::{Context, Sizes};
use super::field::Field;
use super::grid::Grid;
use super::rotations::Rotations;
use super::rows::Rows;
use super::scatter::{gain_columns, stacked_gains};
use super::vectors::dot;

/// With more runs than this the scatter's root is taken run by run (the coupling of runs through the plate's field is
/// then left out of the scatter, not out of the field), which asks for rows that belong to runs.
const RUNS_TOGETHER: usize = 96;

/// Whitening of residuals and Jacobians under a noise model.
#[derive(Clone)]
pub struct Whitener {
    runs: Arc<[Range<usize>]>,
    along: Arc<Along>,
    plate: Plate,
    scatter: Option<ScatterRoot>,
    /// Filter and resonances, which are taken out first.
    channel: Arc<Undone>,
    log_det: f64,
}

/// What takes the plate's field out.
#[derive(Clone)]
enum Plate {
    /// There is none.
    NoField,
    AtOnce(Arc<Field>),
    BySample(Arc<Rotations>),
}

/// Root of the scatter between runs.
#[derive(Clone)]
enum ScatterRoot {
    /// I - U diag(shrink) U', all runs together.
    Joint {
        directions: DMatrix<f64>,
        shrink: Vec<f64>,
    },
    /// The same with each run's direction restricted to its own samples.
    RunByRun {
        runs: Arc<[Range<usize>]>,
        direction: Vec<f64>,
        shrink: Vec<f64>,
    },
}

impl Whitener {
    /// Of a campaign's samples and the sizes of its noise.
    pub fn new(context: &Context, sizes: &Sizes) -> Self {
        if context.runs.len() > RUNS_TOGETHER {
            return Self::by_sample(context, sizes);
        }
        Self::with(context, sizes, |rows, grid| {
            let field = Field::new(rows, grid, sizes);
            (field.log_det, Plate::AtOnce(Arc::new(field)))
        })
    }

    /// The same with a row for each sample, less what the samples before it, its run's and those of the runs before, tell of it.
    pub fn by_sample(context: &Context, sizes: &Sizes) -> Self {
        Self::with(context, sizes, |rows, grid| {
            let rotations = Rotations::new(rows, grid, sizes);
            (rotations.log_det, Plate::BySample(Arc::new(rotations)))
        })
    }

    fn with(
        context: &Context,
        sizes: &Sizes,
        plate: impl FnOnce(&Rows, &Grid) -> (f64, Plate),
    ) -> Self {
        let grid = Grid::new(context, sizes.node_spacing(context.sampling()));
        let undone = context.undone(sizes);
        let along = Along::new(context, sizes, &undone, grid.unresolved(sizes));
        let (of_plate, plate) = if sizes.plate > 0.0 {
            plate(&Rows::new(context, sizes, &grid, &along), &grid)
        } else {
            (0.0, Plate::NoField)
        };
        let whitener = Self {
            runs: context.runs.clone().into(),
            log_det: along.log_det - 2.0 * undone.log_det() + of_plate,
            along: Arc::new(along),
            plate,
            scatter: None,
            channel: Arc::new(undone),
        };
        if sizes.scatter > 0.0 {
            let gains = if whitener.couples_runs() {
                gain_columns(context)
            } else {
                all_gains(context)
            };
            return whitener.with_scatter(&whitener.whiten_columns(&gains), sizes.scatter);
        }
        whitener
    }

    /// The same noise with a scatter between runs. `white_gains`: what these recursions, without a scatter, make of the force of each run,
    /// one column a run, or of many runs several a column.
    pub fn with_scatter(&self, white_gains: &DMatrix<f64>, scatter: f64) -> Self {
        debug_assert!(self.scatter.is_none(), "gains are whitened once");
        let mut other = self.clone();
        if scatter > 0.0 {
            let root = if self.couples_runs() {
                ScatterRoot::joint(white_gains, scatter)
            } else {
                ScatterRoot::run_by_run(&self.runs, white_gains, scatter)
            };
            other.log_det += root.log_det();
            other.scatter = Some(root);
        }
        other
    }

    /// Whether the scatter's root is taken of all runs together. Without a field that they share runs are independent: run by run is then
    /// exact.
    fn couples_runs(&self) -> bool {
        !matches!(self.plate, Plate::NoField) && self.runs.len() <= RUNS_TOGETHER
    }

    /// W r.
    pub fn whiten(&self, residual: &DVector<f64>) -> DVector<f64> {
        let mut out = residual.clone().resize_vertically(self.rows(), 0.0);
        self.sweep(&mut [out.as_mut_slice()]);
        out
    }

    /// W applied to every column.
    pub fn whiten_columns(&self, columns: &DMatrix<f64>) -> DMatrix<f64> {
        let mut out = columns.clone().resize_vertically(self.rows(), 0.0);
        if out.is_empty() {
            return out;
        }
        // Columns are independent: the split over threads changes no bit.
        let rows = out.nrows();
        out.as_mut_slice()
            .par_chunks_mut(rows * TOGETHER)
            .for_each(|block| {
                let mut parts: Vec<&mut [f64]> = block.chunks_mut(rows).collect();
                self.sweep(&mut parts);
            });
        out
    }

    /// W' x: with it a' V^-1 r of many columns a costs one pass over each, (W'W r)' a.
    pub fn whiten_transposed(&self, x: &DVector<f64>) -> DVector<f64> {
        let mut out = x.clone();
        let column = out.as_mut_slice();
        if let Some(scatter) = &self.scatter {
            // The root of the scatter is symmetric.
            scatter.apply(column);
        }
        match &self.plate {
            Plate::NoField => {}
            Plate::AtOnce(field) => field.whiten_transposed(column),
            Plate::BySample(rotations) => rotations.whiten_transposed(column),
        }
        let samples = &mut column[..self.samples()];
        self.along.whiten_transposed(samples);
        self.channel.take_out_transposed(samples);
        out.resize_vertically(self.samples(), 0.0)
    }

    /// Of columns whose samples are followed by room for the nodes' rows.
    fn sweep(&self, columns: &mut [&mut [f64]]) {
        let mut samples: Vec<&mut [f64]> = (columns.iter_mut())
            .map(|column| &mut column[..self.samples()])
            .collect();
        for column in &mut samples {
            self.channel.take_out(column);
        }
        self.along.whiten(&mut samples);
        match &self.plate {
            Plate::NoField => {}
            Plate::AtOnce(field) => field.whiten(columns),
            Plate::BySample(rotations) => rotations.whiten(columns),
        }
        if let Some(scatter) = &self.scatter {
            for column in columns.iter_mut() {
                scatter.apply(column);
            }
        }
    }

    /// Rows of W: one for each sample, first, and for each node of the plate where its field is taken out at once.
    pub fn rows(&self) -> usize {
        let nodes = match &self.plate {
            Plate::AtOnce(field) => field.nodes,
            Plate::NoField | Plate::BySample(_) => 0,
        };
        self.samples() + nodes
    }

    fn samples(&self) -> usize {
        self.runs.last().map_or(0, |run| run.end)
    }

    /// log det V.
    pub fn log_det(&self) -> f64 {
        self.log_det
    }
}

impl ScatterRoot {
    fn joint(gains: &DMatrix<f64>, scatter: f64) -> Self {
        let eigen = gains.tr_mul(gains).symmetric_eigen();
        let largest = eigen.eigenvalues.iter().copied().fold(0.0, f64::max);
        let keep: Vec<usize> = (0..eigen.eigenvalues.len())
            .filter(|&k| eigen.eigenvalues[k] > 1e-12 * largest)
            .collect();
        let mut directions = DMatrix::zeros(gains.nrows(), keep.len());
        let mut shrink = Vec::with_capacity(keep.len());
        for (c, &k) in keep.iter().enumerate() {
            let power = eigen.eigenvalues[k];
            let u = gains * eigen.eigenvectors.column(k) / power.sqrt();
            directions.set_column(c, &u);
            shrink.push(shrinkage(scatter, power));
        }
        Self::Joint { directions, shrink }
    }

    fn run_by_run(runs: &Arc<[Range<usize>]>, gains: &DMatrix<f64>, scatter: f64) -> Self {
        let mut direction: Vec<f64> = gains.column_sum().iter().copied().collect();
        let mut shrink = Vec::with_capacity(runs.len());
        for run in runs.iter() {
            let own = &mut direction[run.clone()];
            let power: f64 = own.iter().map(|x| x * x).sum();
            if power > 0.0 {
                own.iter_mut().for_each(|x| *x /= power.sqrt());
            }
            shrink.push(shrinkage(scatter, power));
        }
        Self::RunByRun {
            runs: runs.clone(),
            direction,
            shrink,
        }
    }

    /// log det(I + s^2 H H') = -2 sum log(1 - shrink).
    fn log_det(&self) -> f64 {
        let (Self::Joint { shrink, .. } | Self::RunByRun { shrink, .. }) = self;
        -2.0 * shrink.iter().map(|x| (1.0 - x).ln()).sum::<f64>()
    }

    fn apply(&self, column: &mut [f64]) {
        match self {
            Self::Joint { directions, shrink } => {
                for (u, s) in directions.column_iter().zip(shrink) {
                    remove(column, u.as_slice(), *s);
                }
            }
            Self::RunByRun {
                runs,
                direction,
                shrink,
            } => {
                for (run, s) in runs.iter().zip(shrink) {
                    remove(&mut column[run.clone()], &direction[run.clone()], *s);
                }
            }
        }
    }
}

/// 1 - 1/sqrt(1 + s^2 power).
fn shrinkage(scatter: f64, power: f64) -> f64 {
    1.0 - 1.0 / (1.0 + scatter * scatter * power).sqrt()
}

/// x - shrink u (u'x).
fn remove(x: &mut [f64], u: &[f64], shrink: f64) {
    let step = dot(u, x) * shrink;
    for (x, a) in x.iter_mut().zip(u) {
        *x -= step * a;
    }
}

/// One column that holds every run's own force.
fn all_gains(context: &Context) -> DMatrix<f64> {
    DMatrix::from_vec(context.samples(), 1, stacked_gains(context))
}

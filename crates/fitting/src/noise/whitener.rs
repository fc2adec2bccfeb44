//! W with W'W = V^-1, V the covariance of (N1), applied in time linear in the samples.
//!
//! Three factors, each a stored recursion: the filter along the runs, the rotations that remove the plate's field, and
//! the root of the scatter, (I + s^2 H H')^(-1/2) = I - U diag(1 - 1/sqrt(1 + s^2 sigma^2)) U', H = U sigma E' being
//! the gains as the first two factors leave them.

use std::ops::Range;
use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::along::{Along, TOGETHER};
use super::channel::Undone;
use super::context::{Context, Sizes};
use super::plate::{Grid, Rows};
use super::rotations::{MOST_TOGETHER, Rotations};
use super::scatter::{gain_columns, stacked_gains};

/// With more runs than this the scatter's root is taken run by run (the coupling of runs through the plate's field is
/// then left out of the scatter, not out of the field).
const RUNS_TOGETHER: usize = 96;

/// Whitening of residuals and Jacobians under a noise model.
#[derive(Clone)]
pub struct Whitener {
    runs: Arc<[Range<usize>]>,
    along: Arc<Along>,
    rotations: Option<Arc<Rotations>>,
    scatter: Option<ScatterRoot>,
    /// Filter and resonances, which are taken out first.
    channel: Arc<Undone>,
    log_det: f64,
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
    /// Builds the recursions for a campaign's samples and the sizes of its noise.
    pub fn new(context: &Context, sizes: &Sizes) -> Self {
        let grid = Grid::new(context, sizes.node_spacing(context.sampling()));
        let undone = context.undone(sizes);
        let along = Along::new(context, sizes, &undone, grid.unresolved(sizes));
        let mut log_det = along.log_det - 2.0 * undone.log_det();
        let rotations = (sizes.plate > 0.0).then(|| {
            let rows = Rows::new(context, sizes, &grid, &along);
            Arc::new(Rotations::new(&rows, &grid, sizes))
        });
        log_det += rotations.as_ref().map_or(0.0, |r| r.log_det);
        let whitener = Self {
            runs: context.runs.clone().into(),
            along: Arc::new(along),
            rotations,
            scatter: None,
            channel: Arc::new(undone),
            log_det,
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
        self.rotations.is_some() && self.runs.len() <= RUNS_TOGETHER
    }

    /// W r.
    pub fn whiten(&self, residual: &DVector<f64>) -> DVector<f64> {
        let mut out = residual.clone();
        self.sweep(&mut [out.as_mut_slice()]);
        out
    }

    /// W applied to every column.
    pub fn whiten_columns(&self, columns: &DMatrix<f64>) -> DMatrix<f64> {
        let n = columns.nrows();
        let mut out = columns.clone();
        if n == 0 || columns.ncols() == 0 {
            return out;
        }
        // Columns are independent: the split over threads changes no bit.
        let block = if columns.ncols() > 2 * MOST_TOGETHER {
            MOST_TOGETHER
        } else {
            TOGETHER
        };
        out.as_mut_slice()
            .par_chunks_mut(n * block)
            .for_each(|block| {
                let mut parts: Vec<&mut [f64]> = block.chunks_mut(n).collect();
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
        if let Some(rotations) = &self.rotations {
            rotations.whiten_transposed(column);
        }
        self.along.whiten_transposed(column);
        self.channel.take_out_transposed(column);
        out
    }

    fn sweep(&self, columns: &mut [&mut [f64]]) {
        for column in columns.iter_mut() {
            self.channel.take_out(column);
        }
        self.along.whiten(columns);
        if let Some(rotations) = &self.rotations {
            rotations.whiten(columns);
        }
        if let Some(scatter) = &self.scatter {
            for column in columns.iter_mut() {
                scatter.apply(column);
            }
        }
    }

    /// Samples that it whitens.
    pub fn samples(&self) -> usize {
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
    let along: f64 = u.iter().zip(x.iter()).map(|(a, b)| a * b).sum();
    let step = along * shrink;
    for (x, a) in x.iter_mut().zip(u) {
        *x -= step * a;
    }
}

/// One column that holds every run's own force.
fn all_gains(context: &Context) -> DMatrix<f64> {
    DMatrix::from_vec(context.samples(), 1, stacked_gains(context))
}

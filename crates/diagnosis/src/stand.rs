//! A fit with its noise: how likely it is, and the whitened coordinates in which further effects are asked for.

use fitting::noise::{Context, Sizes, Whitener};
use nalgebra::{DMatrix, DVector};

use crate::bench::{Bench, Fitted};
use crate::ground::{Ground, orthonormal};
use crate::integrity::is_staircase;
use crate::prior::{append_prior, with_prior_rows};
use crate::scatter::ScatterDeviance;
use crate::settled::likely_scatter;
use crate::subset::Subset;

/// Directions of the model's parameters that keep less than this share of their length beside the others are none of its own.
const OPEN: f64 = 1e-9;

/// How likely a fit is under given sizes of the noise.
pub(crate) struct Likelihood {
    /// Whitening without the scatter between runs.
    pub(crate) whitener: Whitener,
    white_gains: DMatrix<f64>,
    /// Whitened residual with the prior's rows.
    white: DVector<f64>,
    /// Condition of each run.
    conditions: Vec<usize>,
    /// -2 log likelihood, the scatter between runs at its likeliest.
    pub(crate) deviance: f64,
    scatter: ScatterDeviance,
}

impl Likelihood {
    pub(crate) fn of(bench: &Bench<'_>, subset: &Subset, fitted: &Fitted, sizes: Sizes) -> Self {
        Self::in_context(
            bench,
            subset,
            fitted,
            sizes,
            &subset.context_of(bench, fitted),
        )
    }

    fn in_context(
        bench: &Bench<'_>,
        subset: &Subset,
        fitted: &Fitted,
        sizes: Sizes,
        context: &Context,
    ) -> Self {
        let inner = Sizes {
            scatter: 0.0,
            ..sizes
        };
        let whitener = Whitener::new(context, &inner);
        let prior = bench.prior.as_ref();
        let gains = gain_matrix(context);
        let white_gains = append_prior(prior, whitener.whiten_columns(&gains), &[]);
        let white = fitted.white_residual(bench, subset, &whitener);
        let scatter = ScatterDeviance::new(&white_gains, &white);
        Self {
            deviance: whitener.log_det() + scatter.least(),
            whitener,
            white_gains,
            white,
            conditions: context.conditions.clone(),
            scatter,
        }
    }

    /// The noise with so much scatter between runs.
    pub(crate) fn scattered(&self, scatter: f64) -> Whitener {
        scattered(&self.whitener, &self.white_gains, scatter)
    }

    /// -2 log likelihood, the scatter between runs at its likeliest up to a bound.
    pub(crate) fn deviance_within(&self, bound: f64) -> f64 {
        self.whitener.log_det() + self.scatter.least_within(bound)
    }
}

/// A fit with its noise, ready to be asked about further effects.
pub(crate) struct Stand {
    pub(crate) fitted: Fitted,
    pub(crate) sizes: Sizes,
    /// Whitening without the scatter between runs.
    pub(crate) whitener: Whitener,
    /// All samples x movable parameters.
    pub(crate) jacobian: DMatrix<f64>,
    /// Parameters of the Jacobian's columns.
    pub(crate) columns: Vec<usize>,
    pub(crate) ground: Ground,
    /// Whitened Jacobian with the prior's rows.
    pub(crate) white_jacobian: DMatrix<f64>,
    white_gains: DMatrix<f64>,
    /// Whitened residual with the prior's rows.
    white: DVector<f64>,
    /// Condition of each run.
    conditions: Vec<usize>,
    /// What is left of channel noise, whitened, with the prior's rows.
    white_left: DMatrix<f64>,
    /// Rows that a prior adds.
    pub(crate) prior_rows: usize,
    /// -2 log likelihood, the scatter between runs at its likeliest.
    pub(crate) deviance: f64,
}

impl Stand {
    /// A fit under given sizes of the noise (their scatter is only the fit's; the tests integrate over it).
    pub(crate) fn new(bench: &Bench<'_>, subset: &Subset, fitted: Fitted, sizes: Sizes) -> Self {
        let likelihood = Likelihood::of(bench, subset, &fitted, sizes);
        Self::at(bench, subset, fitted, sizes, likelihood)
    }

    /// The same where the fit's likelihood is known.
    pub(crate) fn at(
        bench: &Bench<'_>,
        subset: &Subset,
        fitted: Fitted,
        sizes: Sizes,
        likelihood: Likelihood,
    ) -> Self {
        let Likelihood {
            whitener,
            white_gains,
            white,
            deviance,
            conditions,
            ..
        } = likelihood;
        let (jacobian, columns) = bench.jacobian(subset, &fitted);
        let owners: Vec<Option<usize>> = columns.iter().map(|&c| Some(c)).collect();
        let prior = bench.prior.as_ref();
        let white_jacobian = append_prior(
            prior,
            whitener.whiten_columns(&subset.gather_columns(&jacobian)),
            &owners,
        );
        let prior_rows = prior.map_or(0, |p| p.values.len());
        let left = whitener.whiten_columns(&subset.gather_columns(fitted.left_of_noise(bench)));
        let white_left = append_prior(prior, left, &[]);
        let ground =
            Ground::new(&white_jacobian, &white_gains, &white, &conditions).with_left(&white_left);
        Self {
            fitted,
            sizes,
            whitener,
            jacobian,
            columns,
            ground,
            white_jacobian,
            white_gains,
            white,
            conditions,
            white_left,
            prior_rows,
            deviance,
        }
    }

    /// The noise with so much scatter between runs.
    pub(crate) fn scattered(&self, scatter: f64) -> Whitener {
        scattered(&self.whitener, &self.white_gains, scatter)
    }

    /// The noise with the scatter between runs that is likeliest beside the fit.
    pub(crate) fn likely_noise(&self) -> Whitener {
        self.scattered(likely_scatter(self))
    }

    /// -2 log likelihood of the fit under other sizes of the noise.
    pub(crate) fn deviance_with(&self, bench: &Bench<'_>, subset: &Subset, sizes: Sizes) -> f64 {
        Likelihood::of(bench, subset, &self.fitted, sizes).deviance
    }

    /// The same as if roughness reached the record past no resonance: what a resonance makes of noise is no evidence for it beside
    /// rivals (the grid of a plate that is rough on a small scale gives it some).
    pub(crate) fn deviance_past_resonance(
        &self,
        bench: &Bench<'_>,
        subset: &Subset,
        sizes: Sizes,
    ) -> f64 {
        if sizes == self.sizes && subset.rings(bench, &self.fitted).is_empty() {
            return self.deviance;
        }
        let context = subset.context(bench, self.fitted.friction(bench));
        Likelihood::in_context(bench, subset, &self.fitted, sizes, &context).deviance
    }

    /// The residual, sample by sample, each drawn towards zero by half a step of the force channel: what rounding may have made is
    /// taken out, what is beyond it stays. `None` where the step is lost in the noise.
    pub(crate) fn beyond_rounding(
        &self,
        bench: &Bench<'_>,
        subset: &Subset,
    ) -> Option<DVector<f64>> {
        let half = 0.5
            * bench
                .step_n
                .filter(|s| is_staircase(*s, self.sizes.sensor))?;
        let beyond = |r: f64| r.signum() * (r.abs() - half).max(0.0);
        Some(self.fitted.residual(bench, subset).map(beyond))
    }

    /// The ground of another residual.
    pub(crate) fn ground_of_residual(&self, bench: &Bench<'_>, residual: &DVector<f64>) -> Ground {
        self.ground_of(&self.white_jacobian, &self.white_of(bench, residual))
    }

    fn white_of(&self, bench: &Bench<'_>, residual: &DVector<f64>) -> DVector<f64> {
        let white = self.whitener.whiten(residual);
        with_prior_rows(bench.prior.as_ref(), white, &self.fitted.parameters)
    }

    /// What the model's own directions leave of a residual, sample by sample (see [`Whitener::by_sample`]), in standard deviations that hold what
    /// is left of channel noise (M5).
    pub(crate) fn innovations(
        &self,
        bench: &Bench<'_>,
        subset: &Subset,
        residual: &DVector<f64>,
    ) -> DVector<f64> {
        let draws = subset.gather_columns(self.fitted.left_of_noise(bench));
        let count = draws.ncols();
        let mut white = self.white_left.clone().resize_horizontally(count + 1, 0.0);
        white.set_column(count, &self.white_of(bench, residual));
        let mut own = draws.resize_horizontally(count + 1, 0.0);
        own.set_column(count, residual);
        let (basis, back) = orthonormal(&self.white_jacobian, OPEN);
        own -= subset.gather_columns(&self.jacobian) * (back * basis.tr_mul(&white));
        let by_sample = self.by_sample(bench, subset, 0.0).whiten_columns(&own);
        DVector::from_fn(residual.len(), |i, _| {
            let left = by_sample.row(i).columns(0, count).norm_squared();
            by_sample[(i, count)] / (1.0 + left / count.max(1) as f64).sqrt()
        })
    }

    /// The noise with so much scatter between runs, sample by sample.
    pub(crate) fn by_sample(&self, bench: &Bench<'_>, subset: &Subset, scatter: f64) -> Whitener {
        let context = subset.context_of(bench, &self.fitted);
        let sizes = Sizes {
            scatter,
            ..self.sizes
        };
        Whitener::by_sample(&context, &sizes)
    }

    /// The ground with these whitened columns in the model, too.
    pub(crate) fn ground_beside(&self, white: &DMatrix<f64>) -> Ground {
        let (n, p) = self.white_jacobian.shape();
        let mut model = self
            .white_jacobian
            .clone()
            .resize_horizontally(p + white.ncols(), 0.0);
        model.view_mut((0, p), (n, white.ncols())).copy_from(white);
        self.ground_of(&model, &self.white)
    }

    /// The ground of a whitened model and residual.
    fn ground_of(&self, model: &DMatrix<f64>, white: &DVector<f64>) -> Ground {
        Ground::new(model, &self.white_gains, white, &self.conditions).with_left(&self.white_left)
    }

    /// Whitened gains of the runs, with the prior's rows.
    pub(crate) fn white_gains(&self) -> &DMatrix<f64> {
        &self.white_gains
    }

    /// The gains of the runs beside the fit, the model's directions left in them.
    pub(crate) fn between_runs(&self) -> BetweenRuns {
        let (gains, lambda) = self.turned_gains();
        BetweenRuns {
            turned: gains.tr_mul(&self.white).iter().copied().collect(),
            lambda,
            residual: self.white.clone(),
            gains,
        }
    }

    /// W H E and lambda of (W H)'(W H) = E diag(lambda) E'.
    fn turned_gains(&self) -> (DMatrix<f64>, Vec<f64>) {
        let eigen = self.white_gains.tr_mul(&self.white_gains).symmetric_eigen();
        let gains = &self.white_gains * &eigen.eigenvectors;
        (gains, eigen.eigenvalues.iter().copied().collect())
    }

    /// V(s)^-1/2 W J: the whitened Jacobian with the scatter between runs whitened too.
    pub(crate) fn white_descattered(&self, scatter: f64) -> DMatrix<f64> {
        let (gains, lambda) = self.turned_gains();
        let mut out = self.white_jacobian.clone();
        let largest = lambda.iter().copied().fold(0.0, f64::max);
        for (gain, l) in gains.column_iter().zip(&lambda) {
            if *l <= 1e-12 * largest {
                continue;
            }
            let u = gain / l.sqrt();
            let shrink = 1.0 - 1.0 / (1.0 + scatter * scatter * l).sqrt();
            let along = u.transpose() * &self.white_jacobian;
            out -= &u * along * shrink;
        }
        out
    }

    /// -2 log likelihood of another fit under this stand's noise, the scatter between runs at that fit's likeliest.
    pub(crate) fn deviance_of(&self, bench: &Bench<'_>, subset: &Subset, fit: &Fitted) -> f64 {
        let white = fit.white_residual(bench, subset, &self.whitener);
        self.whitener.log_det() + ScatterDeviance::new(&self.white_gains, &white).least()
    }

    /// Whitens columns (all samples), with empty rows for a prior.
    pub(crate) fn whiten(&self, subset: &Subset, columns: &DMatrix<f64>) -> DMatrix<f64> {
        self.whiten_own(&subset.gather_columns(columns))
    }

    /// The same of columns that hold the subset's samples only.
    pub(crate) fn whiten_own(&self, columns: &DMatrix<f64>) -> DMatrix<f64> {
        let white = self.whitener.whiten_columns(columns);
        let n = white.nrows();
        white.resize_vertically(n + self.prior_rows, 0.0)
    }
}

/// A noise with so much scatter between runs; the rows of a prior have none.
fn scattered(whitener: &Whitener, white_gains: &DMatrix<f64>, scatter: f64) -> Whitener {
    let rows = whitener.rows();
    whitener.with_scatter(&white_gains.rows(0, rows).into_owned(), scatter)
}

/// Gains of runs and residual in whitened coordinates: W H E with (W H)'(W H) = E diag(lambda) E', and t = E'(W H)'W r.
pub(crate) struct BetweenRuns {
    pub(crate) gains: DMatrix<f64>,
    pub(crate) lambda: Vec<f64>,
    pub(crate) turned: Vec<f64>,
    pub(crate) residual: DVector<f64>,
}

/// Gains of runs as columns; for very many runs neighbours share one.
pub(crate) fn gain_matrix(context: &Context) -> DMatrix<f64> {
    const MOST: usize = 96;
    let runs = context.runs.len();
    let columns = runs.min(MOST);
    let mut gains = DMatrix::zeros(context.samples(), columns);
    for (k, run) in context.runs.iter().enumerate() {
        for i in run.clone() {
            gains[(i, k * columns / runs)] = context.scale[i];
        }
    }
    for mut column in gains.column_iter_mut() {
        context.recorded(column.as_mut_slice());
    }
    gains
}

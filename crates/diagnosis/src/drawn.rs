//! The floor of held-out runs: not what noise draws on the average, but what these runs drew.
//!
//! A run's scatter is one number for hundreds of samples, and the plate's roughness repeats and is in no floor from repeats. So the
//! repeats' floor may be far from the noise in the squared errors of the runs that were held out. The errors after the
//! extension hold that noise and the extension's own error A, and nothing else where nothing is left unexplained:
//!
//! ```text
//! floor^2 = after^2 - A / n,   A = sum (f_fold - f_all)^2 + tr(J C J')                                  (D8)
//! ```
//!
//! f_fold, f_all: predictions of the extension from the fold and from the whole campaign; J, C: the latter's derivatives and
//! covariance. Sums run over held-out samples, in the unit of errors.

use nalgebra::DMatrix;

use crate::bench::Bench;
use crate::floor;
use crate::gain::Fold;
use crate::intervals::covariance;
use crate::selection::{ALPHA_GENERAL, Selected};
use crate::whole::Whole;

/// What the noise in held-out squared errors may have drawn beside the floor from repeats.
pub(crate) struct Drawn {
    /// Sum of squares of the plate's roughness.
    plate: f64,
    /// Standard deviation of the sum of squares of the scatter between runs.
    scatter_sd: f64,
    /// A of (D8) and the share of it that may be wrong; `None` where something is left unexplained or the errors are not
    /// those of the record that was searched.
    pub(crate) own: Option<(f64, f64)>,
}

impl Drawn {
    /// By the sizes of the noise beside the named causes. A run that is held out by several folds drew once.
    pub(crate) fn by(whole: &Whole<'_>, selected: &Selected, folds: &[Fold]) -> Self {
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
        Self {
            plate,
            scatter_sd: variance.sqrt(),
            own: own_error(whole, selected, folds),
        }
    }

    /// Sum of squares by which the floor from repeats may be wrong.
    pub(crate) fn beside_repeats(&self) -> f64 {
        self.plate + 2.0 * std::f64::consts::SQRT_2 * self.scatter_sd
    }
}

/// A of (D8) over all held-out samples, and the share of it that may be wrong: two standard deviations of a chi^2 with as many
/// degrees of freedom as there are parameters, over its mean.
fn own_error(whole: &Whole<'_>, selected: &Selected, folds: &[Fold]) -> Option<(f64, f64)> {
    let stand = &selected.stand;
    if whole.apart || selected.left.log_p < ALPHA_GENERAL.ln() {
        return None;
    }
    let covariance = covariance(stand)?;
    let bench = whole.bench;
    let sum = folds
        .iter()
        .flat_map(|fold| fold.held.iter().map(move |&run| (fold, run)))
        .map(|(fold, run)| {
            error_in(bench, run, |i| {
                let apart = fold.extended[i] - whole.extended.prediction[i];
                apart * apart + variance(&stand.jacobian, &covariance, i)
            })
        })
        .sum();
    let parameters = stand.columns.len().max(1) as f64;
    Some((sum, 2.0 * (2.0 / parameters).sqrt()))
}

/// Row i of J C J' on the diagonal, N^2.
fn variance(jacobian: &DMatrix<f64>, covariance: &DMatrix<f64>, i: usize) -> f64 {
    let row = jacobian.row(i);
    (row * covariance).dot(&row)
}

/// A squared error in force, summed over a run's samples in the unit of errors.
fn error_in(bench: &Bench<'_>, run: usize, squared_n2: impl Fn(usize) -> f64) -> f64 {
    let samples = &bench.samples;
    samples.runs[run]
        .clone()
        .filter(|&i| !samples.loaded || samples.load[i] > 0.0)
        .map(|i| squared_n2(i) * (samples.weight(i) / samples.load[i]).powi(2))
        .sum()
}

//! Intervals of a named cause's parameters.
//!
//! The scatter s between runs is known from few runs, and where a parameter lives between runs its estimate moves with s: what the
//! data say of the parameters b is a mixture over s, each s with its weight in the restricted likelihood,
//!
//! ```text
//! p(b) = sum_s w(s) N(b + d(s) - d(s^), C(s)),   C = (J'V(s)^-1 J)^-1,   d = C J'V(s)^-1 r                (D12)
//! ```
//!
//! J and r being the whitened Jacobian and residual of the fit, s^ the scatter under which it was made. The interval is that between
//! the mixture's 2.5 and 97.5 % quantiles; of one direction that lives between runs it is nearly Student's t.

use nalgebra::{Cholesky, DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

use crate::answer::Estimate;
use crate::bench::{Bench, Fitted};
use crate::ground::orthonormal;
use crate::stand::{BetweenRuns, Stand};

/// Covariance of the movable parameters at the likeliest scatter; `None` where the data leave a direction open.
pub(crate) fn covariance(stand: &Stand) -> Option<DMatrix<f64>> {
    let whole = stand.white_descattered(stand.sizes.scatter);
    let (basis, back) = orthonormal(&whole, OPEN);
    // Columns that are dropped (a parameter without influence) get no row: their variance is not known.
    (basis.ncols() == whole.ncols()).then(|| &back * back.transpose())
}

/// A direction of the parameters whose share of what is seen is below this is open.
const OPEN: f64 = 1e-10;
/// Scatters of less weight than this change no interval.
const WITHOUT_WEIGHT: f64 = 1e-7;

/// (D12): what the data say of the movable parameters, about their estimates.
struct Spread {
    /// Weight, shift of the estimate and covariance at each scatter.
    scatters: Vec<(f64, DVector<f64>, DMatrix<f64>)>,
}

impl Spread {
    /// `None` where the data leave a direction open.
    fn new(stand: &Stand) -> Option<Self> {
        let posterior = stand.ground.scatter_posterior();
        let home = stand.sizes.scatter;
        Self::of(
            &stand.white_jacobian,
            &stand.between_runs(),
            &posterior,
            home,
        )
    }

    /// Of the whitened Jacobian, the scatters with their weights and that under which the fit was made.
    fn of(
        jacobian: &DMatrix<f64>,
        between: &BetweenRuns,
        posterior: &[(f64, f64)],
        home: f64,
    ) -> Option<Self> {
        let (basis, back) = orthonormal(jacobian, OPEN);
        if basis.ncols() != jacobian.ncols() {
            return None;
        }
        let seen = basis.tr_mul(&between.gains);
        let own = basis.tr_mul(&between.residual);
        // In the coordinates of the basis Q: A = I - sum s^2/(1 + s^2 l) g g', u = Q'r - sum s^2/(1 + s^2 l) g t, g = Q'H e
        let at = |scatter: f64| {
            let (mut a, mut u) = (DMatrix::identity(own.len(), own.len()), own.clone());
            let s2 = scatter * scatter;
            for (k, (l, t)) in between.lambda.iter().zip(&between.turned).enumerate() {
                let shrink = s2 / (1.0 + s2 * l);
                let g = seen.column(k);
                a.ger(-shrink, &g, &g, 1.0);
                u.axpy(-shrink * t, &g, 1.0);
            }
            let factor = Cholesky::new(a)?;
            let shift = &back * factor.solve(&u);
            Some((shift, &back * factor.inverse() * back.transpose()))
        };
        let (home, _) = at(home)?;
        let scatters = posterior
            .iter()
            .filter(|(_, weight)| *weight > WITHOUT_WEIGHT)
            .filter_map(|&(s, weight)| {
                let (shift, covariance) = at(s)?;
                Some((weight, shift - &home, covariance))
            })
            .collect();
        Some(Self { scatters })
    }

    /// 95 % interval of a number with this gradient, about its estimate; `None` where it does not depend on the parameters.
    fn interval(&self, gradient: &DVector<f64>) -> Option<[f64; 2]> {
        let normals: Vec<(f64, Normal)> = self
            .scatters
            .iter()
            .filter_map(|(weight, shift, covariance)| {
                let variance = (covariance * gradient).dot(gradient);
                let normal = Normal::new(gradient.dot(shift), variance.sqrt()).ok()?;
                Some((*weight, normal))
            })
            .collect();
        let total: f64 = normals.iter().map(|(weight, _)| weight).sum();
        let below =
            |x: f64| -> f64 { normals.iter().map(|(w, n)| w * n.cdf(x)).sum::<f64>() / total };
        let quantile = |share: f64| {
            let own = normals.iter().map(|(_, n)| n.inverse_cdf(share));
            let (mut low, mut high) = own.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| {
                (a.min(x), b.max(x))
            });
            // A mixture's quantile lies between those of its parts.
            for _ in 0..100 {
                let middle = 0.5 * (low + high);
                if below(middle) < share {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            0.5 * (low + high)
        };
        (total > 0.0).then(|| [quantile(0.025), quantile(0.975)])
    }
}

/// Reported parameters of the k-th effect of a fit with their 95 % intervals, which a stand with the same effects gives;
/// `stepped`: a size, by its place among the effect's parameters, and its interval where that is not a matter of curvature.
pub(crate) fn estimates(
    bench: &Bench<'_>,
    stand: &Stand,
    fitted: &Fitted,
    k: usize,
    stepped: Option<(usize, [f64; 2])>,
) -> Vec<Estimate> {
    let span = fitted.model.span(k);
    let own = &fitted.parameters[span.clone()];
    let cause = &bench.catalogue[fitted.effects[k]];
    let spread = Spread::new(stand);
    let places: Vec<Option<usize>> = span
        .map(|p| stand.columns.iter().position(|&c| c == p))
        .collect();
    let specs = cause.parameters_for(&bench.experiment);
    cause
        .reported(own)
        .into_iter()
        .enumerate()
        .map(|(place, reported)| {
            let gradient = of_the_columns(&reported.gradient, &places, stand.columns.len());
            let within = spread.as_ref().zip(gradient);
            let within = within.and_then(|(spread, gradient)| spread.interval(&gradient));
            let of_steps = stepped.map(|(column, edges)| {
                edges.map(|edge| {
                    let mut at = own.to_vec();
                    at[column] = edge;
                    cause.reported(&at)[place].value
                })
            });
            let ci95 = within.map(|edges| edges.map(|edge| reported.value + edge));
            let bounds = specs.iter().find(|spec| spec.name == reported.name);
            let possible = |ci: [f64; 2]| match bounds {
                Some(spec) => ci.map(|edge| edge.clamp(spec.lower, spec.upper)),
                None => ci,
            };
            let ci95 = of_steps.filter(|[lower, upper]| lower < upper).or(ci95);
            Estimate {
                name: reported.name.into(),
                value: reported.value,
                ci95: ci95.map(possible),
                unit: unit_on_rig(bench, reported.unit),
            }
        })
        .collect()
}

/// A gradient by an effect's own parameters as one by the movable ones; `None` where it asks for one that does not move.
fn of_the_columns(own: &[f64], places: &[Option<usize>], columns: usize) -> Option<DVector<f64>> {
    let mut gradient = DVector::zeros(columns);
    for (slope, place) in own.iter().zip(places) {
        gradient[(*place)?] = *slope;
    }
    Some(gradient)
}

/// The 97.5 % quantile of Student's t.
pub(crate) fn student(freedom: f64) -> f64 {
    StudentsT::new(0.0, 1.0, freedom.clamp(1.0, 1e6)).map_or(1.96, |t| t.inverse_cdf(0.975))
}

/// A unit of the catalogue as this campaign's rig reads it: N m, rad and kg m^2 for N, m and kg on a rotary one.
pub(crate) fn unit_on_rig(bench: &Bench<'_>, unit: &str) -> String {
    match bench.experiment.axis {
        campaign::Axis::Rotary => rotary_unit(unit),
        campaign::Axis::Linear => unit.to_owned(),
    }
}

/// Units of a linear rig read on a rotary one.
fn rotary_unit(unit: &str) -> String {
    unit.split(' ')
        .map(|part| match part {
            "N" => "N m",
            "m" => "rad",
            "m/s" => "rad/s",
            "kg" => "kg m^2",
            "m/N" => "rad/(N m)",
            "1/m" => "1/rad",
            "1/m^2" => "1/rad^2",
            "1/N^2" => "1/(N m)^2",
            "N/s" => "N m/s",
            "s/m" => "s/rad",
            "s^2/m^2" => "s^2/rad^2",
            "s^3/m^3" => "s^3/rad^3",
            other => other,
        })
        .collect::<Vec<_>>()
        .join(" ")
}

#[cfg(test)]
mod tests {
    use fitting::noise::ScatterEvidence;
    use nalgebra::{DMatrix, DVector};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use super::{Spread, rotary_unit};
    use crate::causes;
    use crate::stand::BetweenRuns;

    /// Seven runs that tell their gains unequally well, a gain of all and an effect that steps between runs: whatever the scatter, the
    /// interval of the effect holds the truth (0) in 95 % of 2,000 draws.
    #[test]
    fn what_lives_between_few_runs_has_an_interval_that_covers() {
        let lengths = DVector::from_column_slice(&[30.0, 40.0, 60.0, 120.0, 200.0, 60.0, 100.0]);
        let effect = [0.0, 0.2, 0.45, 0.6, 0.8, 0.9, 1.0];
        let gains = DMatrix::from_diagonal(&lengths);
        let columns = [
            DVector::from_element(7, 1.0),
            DVector::from_column_slice(&effect),
        ];
        let jacobian = &gains * DMatrix::from_columns(&columns);
        for scatter in [0.0, 0.01, 0.05] {
            let mut rng = ChaCha8Rng::seed_from_u64(7);
            let mut draw = || -> f64 { StandardNormal.sample(&mut rng) };
            let mut inside = 0;
            for _ in 0..2000 {
                let record = DVector::from_fn(7, |k, _| lengths[k] * scatter * draw() + draw());
                let own = interval_of_the_effect(&gains, &jacobian, &record).expect("regular");
                inside += usize::from(own[0] < 0.0 && own[1] > 0.0);
            }
            let share = inside as f64 / 2000.0;
            assert!((0.93..0.985).contains(&share), "scatter {scatter}: {share}");
        }
    }

    /// The interval about the estimate that is least squares at the likeliest scatter.
    fn interval_of_the_effect(
        gains: &DMatrix<f64>,
        jacobian: &DMatrix<f64>,
        record: &DVector<f64>,
    ) -> Option<[f64; 2]> {
        let evidence = ScatterEvidence::new(gains, jacobian, record);
        let home = evidence.estimate();
        let between = |residual: &DVector<f64>| BetweenRuns {
            gains: gains.clone(),
            lambda: gains.diagonal().iter().map(|l| l * l).collect(),
            turned: gains.tr_mul(residual).iter().copied().collect(),
            residual: residual.clone(),
        };
        let whitened = gains.map_diagonal(|l| 1.0 / (1.0 + (home * l).powi(2)).sqrt());
        let scale = |m: &DMatrix<f64>| DMatrix::from_diagonal(&whitened) * m;
        let target = scale(&DMatrix::from_columns(std::slice::from_ref(record)));
        let fit = scale(jacobian).svd(true, true).solve(&target, 1e-12).ok()?;
        let residual = record - jacobian * fit.column(0);
        let posterior = evidence.posterior();
        let spread = Spread::of(jacobian, &between(&residual), &posterior, home)?;
        let about = spread.interval(&DVector::from_column_slice(&[0.0, 1.0]))?;
        Some(about.map(|edge| fit[(1, 0)] + edge))
    }

    #[test]
    fn no_length_or_force_of_a_linear_rig_is_left_on_a_rotary_one() {
        for cause in causes::catalogue() {
            for spec in cause.parameters() {
                let unit = rotary_unit(&spec.unit);
                let bare = unit
                    .replace("N m", "torque")
                    .replace("kg m^2", "inertia")
                    .replace("rad", "angle");
                let linear = bare
                    .split(|c: char| !c.is_ascii_alphabetic())
                    .any(|word| matches!(word, "m" | "N" | "kg"));
                assert!(!linear, "{}: {} -> {unit}", cause.id(), spec.unit);
            }
        }
        assert_eq!(rotary_unit("N s/m"), "N m s/rad");
    }
}

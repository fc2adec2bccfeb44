//! Intervals of a named cause's parameters.
//!
//! Covariance (J'V(s)^-1 J)^-1 with the likeliest scatter s; because s is known from few runs, the quantile is Student's
//! with nu / share^2 degrees of freedom, share being the part of the parameter's variance that the scatter makes
//! (Satterthwaite).

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, StudentsT};

use crate::answer::Estimate;
use crate::bench::{Bench, Fitted};
use crate::ground::orthonormal;
use crate::stand::Stand;

/// Covariance of the movable parameters at the likeliest scatter; `None` where the data leave a direction open.
pub(crate) fn covariance(stand: &Stand) -> Option<DMatrix<f64>> {
    covariance_at(stand, stand.sizes.scatter)
}

fn covariance_at(stand: &Stand, scatter: f64) -> Option<DMatrix<f64>> {
    let whole = stand.white_descattered(scatter);
    let (basis, back) = orthonormal(&whole, 1e-10);
    // Columns that are dropped (a parameter without influence) get no row: their variance is not known.
    (basis.ncols() == whole.ncols()).then(|| &back * back.transpose())
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
    let with = covariance_at(stand, stand.sizes.scatter);
    let without = covariance_at(stand, 0.0);
    let places: Vec<Option<usize>> = span
        .map(|p| stand.columns.iter().position(|&c| c == p))
        .collect();
    let freedom = stand.ground.scatter_freedom().max(1) as f64;
    let specs = cause.parameters_for(&bench.experiment);
    cause
        .reported(own)
        .into_iter()
        .enumerate()
        .map(|(place, reported)| {
            let g = DVector::from_vec(reported.gradient.clone());
            let variance = |c: &Option<DMatrix<f64>>| -> Option<f64> {
                let c = c.as_ref()?;
                let mut v = 0.0;
                for (i, a) in places.iter().enumerate() {
                    for (j, b) in places.iter().enumerate() {
                        v += g[i] * g[j] * c[((*a)?, (*b)?)];
                    }
                }
                Some(v)
            };
            let of_steps = stepped.map(|(column, edges)| {
                edges.map(|edge| {
                    let mut at = own.to_vec();
                    at[column] = edge;
                    cause.reported(&at)[place].value
                })
            });
            let ci95 = match (variance(&with), variance(&without)) {
                (Some(v), Some(v0)) if v > 0.0 => {
                    let share = ((v - v0) / v).clamp(1e-3, 1.0);
                    let t = student(freedom / (share * share));
                    let half = t * v.sqrt();
                    Some([reported.value - half, reported.value + half])
                }
                _ => None,
            };
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
            "N/s" => "N m/s",
            "s/m" => "s/rad",
            "s^2/m^2" => "s^2/rad^2",
            other => other,
        })
        .collect::<Vec<_>>()
        .join(" ")
}

#[cfg(test)]
mod tests {
    use super::rotary_unit;
    use crate::causes;

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

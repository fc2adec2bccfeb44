//! The seven numbers of Table 1 are at most six: the scale ray.
//!
//! E3 contains sigma, theta_c and theta_s only as theta_c/sigma and theta_s/sigma. In the paper's own parameters
//!
//! ```text
//! X = [sigma, sigma0, sigma1, sigma2, theta_c, theta_s, w_sc] (and theta0),   p = I(X)
//! dF/dX = dF/dp dI/dX
//! ```
//!
//! so (sigma, theta_c, theta_s) -> a (sigma, theta_c, theta_s) changes no force. This module fits X itself and shows
//! it: one singular value is zero, and the profile of each of the three is flat.

use campaign::Campaign;
use fitting::noise::Whitener;
use fitting::{
    Bounds, Identifiability, Options, ProfileOptions, ProfilePoint, Residuals, Status,
    identifiability, minimise, profile_curve,
};
use friction::{LawKind, paper_form};
use nalgebra::{DMatrix, DVector};
use rig::Experiment;

use crate::identify::Identification;
use crate::problem::{Problem, noise_context};
use crate::question::IdentificationError;

/// What the data say about the paper's own parameters.
#[derive(Clone, Debug)]
pub struct PaperForm {
    /// Names of the columns: X, then theta0 where it is free.
    pub names: Vec<String>,
    /// Rank, spectrum and null directions, sensitivities relative to each parameter's own value.
    pub identifiability: Identifiability,
    /// Profiles of sigma, theta_c and theta_s over the given factors of their value: (name, points).
    pub profiles: Vec<(String, Vec<ProfilePoint>)>,
    /// A profile of sigma0 over the same spans of threshold, for comparison: (name, points).
    pub contrast: (String, Vec<ProfilePoint>),
    /// How the fit in these parameters ended.
    pub status: Status,
    /// Names of the three on the ray.
    pub ray: [&'static str; 3],
}

/// Order of X and theta0 in [`paper_form::PARAMETERS`].
const SIGMA: usize = 0;
const SIGMA0: usize = 1;
const THETA_C: usize = 4;
const THETA_S: usize = 5;
const COUNT: usize = 8;

struct InPaperForm<'a>(Problem<'a>);

impl InPaperForm<'_> {
    fn identifiable(x: &[f64]) -> Vec<f64> {
        let mut paper = [0.0; COUNT];
        paper.copy_from_slice(x);
        paper_form::identifiable(&paper).to_vec()
    }

    /// dI/dX, 7 x 8: rows theta_c/sigma, theta_s/sigma, sigma0, sigma1, sigma2, w_sc, theta0.
    fn slopes(x: &[f64]) -> DMatrix<f64> {
        let mut d = DMatrix::zeros(7, COUNT);
        let sigma = x[SIGMA];
        d[(0, SIGMA)] = -x[THETA_C] / (sigma * sigma);
        d[(0, THETA_C)] = 1.0 / sigma;
        d[(1, SIGMA)] = -x[THETA_S] / (sigma * sigma);
        d[(1, THETA_S)] = 1.0 / sigma;
        for (row, column) in [(2, 1), (3, 2), (4, 3), (5, 6), (6, 7)] {
            d[(row, column)] = 1.0;
        }
        d
    }
}

impl Residuals for InPaperForm<'_> {
    fn residuals(&self, x: &[f64]) -> DVector<f64> {
        self.0.residuals(&Self::identifiable(x))
    }

    fn jacobian(&self, x: &[f64]) -> (DVector<f64>, DMatrix<f64>) {
        let (residuals, jacobian) = self.0.jacobian(&Self::identifiable(x));
        (residuals, jacobian * Self::slopes(x))
    }
}

/// Fits the paper's X beginning at an identified bristle law, with sigma set to `sigma` (any value: it is the unit in
/// which theta_c and theta_s are counted), and profiles the ray over `factors` of the fitted values.
///
/// # Errors
/// When the campaign cannot be predicted or the identification is not of the asymmetric bristle law alone.
pub fn in_paper_form(
    campaign: &Campaign,
    identified: &Identification,
    sigma: f64,
    factors: &[f64],
) -> Result<PaperForm, IdentificationError> {
    let experiment = Experiment::new(campaign)?;
    let expected = LawKind::AsymmetricBristle.parameters().len();
    if identified.law != LawKind::AsymmetricBristle || identified.parameters.len() != expected {
        return Err(IdentificationError::NoStart(
            "the paper's parameters belong to the asymmetric bristle law alone".into(),
        ));
    }
    let context = noise_context(&experiment, &identified.predicted_n);
    let whitener = Whitener::new(&context, &identified.noise.sizes);
    let problem = InPaperForm(Problem {
        experiment: &experiment,
        model: &identified.model,
        whitener: Some(&whitener),
    });
    let p = &identified.parameters;
    let start = [
        sigma,
        p[2],
        p[3],
        p[4],
        p[0] * sigma,
        p[1] * sigma,
        p[5],
        p[6],
    ];
    let specs = paper_form::PARAMETERS;
    let lower: Vec<f64> = specs.iter().map(|s| s.lower).collect();
    let upper: Vec<f64> = specs.iter().map(|s| s.upper).collect();
    let mut bounds =
        Bounds::new(lower, upper).map_err(|e| IdentificationError::NoStart(e.to_string()))?;
    let theta0_held = identified.estimate("theta0").is_some_and(|e| e.held);
    if theta0_held {
        bounds = bounds.with_fixed(7, p[6]);
    }
    let refuse = |error: fitting::BoundsError| IdentificationError::NoStart(error.to_string());
    let fit = minimise(&problem, &start, &bounds, &Options::warm()).map_err(refuse)?;
    let columns = bounds.movable();
    let (_, jacobian) = problem.jacobian_columns(&fit.parameters, &columns);
    let scales: Vec<f64> = columns
        .iter()
        .map(|&j| {
            if fit.parameters[j] == 0.0 {
                specs[j].typical
            } else {
                fit.parameters[j].abs()
            }
        })
        .collect();
    // A profile at a scaled value begins at the point of the ray that the fit itself gives: what it reports is then a
    // minimum over the others at most as high as that point.
    let along = |j: usize| -> Result<(String, Vec<ProfilePoint>), IdentificationError> {
        let points = factors
            .iter()
            .map(|factor| {
                let mut on_ray = fit.parameters.clone();
                for k in [SIGMA, THETA_C, THETA_S] {
                    on_ray[k] *= factor;
                }
                let value = on_ray[j];
                let held = bounds.with_fixed(j, value);
                let inner = minimise(&problem, &on_ray, &held, &Options::warm()).map_err(refuse)?;
                Ok(ProfilePoint {
                    value,
                    deviance: 2.0 * (inner.cost - fit.cost),
                    parameters: inner.parameters,
                    at_bound: inner.at_bound,
                    status: inner.status,
                })
            })
            .collect::<Result<Vec<_>, IdentificationError>>()?;
        Ok((specs[j].name.to_string(), points))
    };
    let profiles = [SIGMA, THETA_C, THETA_S]
        .into_iter()
        .map(along)
        .collect::<Result<Vec<_>, _>>()?;
    let narrow: Vec<f64> = (-6..=6)
        .map(|k| fit.parameters[SIGMA0] * (1.0 + 0.01 * f64::from(k)))
        .collect();
    let options = ProfileOptions::new(1.0, 0.01 * fit.parameters[SIGMA0]);
    let contrast = profile_curve(&problem, &fit, SIGMA0, &bounds, &narrow, &options)
        .map(|points| (specs[SIGMA0].name.to_string(), points))
        .map_err(refuse)?;
    Ok(PaperForm {
        names: columns.iter().map(|&j| specs[j].name.to_string()).collect(),
        identifiability: identifiability(&jacobian, &scales),
        profiles,
        contrast,
        status: fit.status,
        ray: ["sigma", "theta_c", "theta_s"],
    })
}

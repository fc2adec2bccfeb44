//! The least uncertainty that any unbiased estimate can have: the Cramer-Rao bound
//!
//! ```text
//! sd_j >= sqrt([(J' V^-1 J)^-1]_jj),
//! ```
//!
//! J the derivatives of the forces by all parameters of the law and V the covariance of a known noise. A width that the
//! bound does not allow asks for another experiment, not for another estimator.

use campaign::Campaign;
use fitting::noise::{Sizes, Whitener};
use friction::LawKind;
use rig::{Experiment, Model};

use crate::problem::noise_context;
use crate::question::IdentificationError;

/// The bound for every parameter of the law, in its unit, on the motions of `campaign` under noise of known sizes; `None`
/// where the motions leave a direction open. Forces are not read.
///
/// # Errors
/// When the campaign cannot be predicted.
pub fn least_sd(
    campaign: &Campaign,
    law: LawKind,
    parameters: &[f64],
    sizes: &Sizes,
) -> Result<Option<Vec<f64>>, IdentificationError> {
    let experiment = Experiment::new(campaign)?;
    let model = Model::new(law, Vec::new(), &experiment)?;
    let mut all = parameters.to_vec();
    all.resize(model.parameters().len(), 0.0);
    let (force_n, jacobian) = model.predict_with_jacobian(&experiment, &all, None);
    let whitener = Whitener::new(&noise_context(&experiment, &force_n), sizes);
    let covariance = fitting::covariance_of(&whitener.whiten_columns(&jacobian));
    Ok(covariance.map(|c| (0..parameters.len()).map(|j| c[(j, j)].sqrt()).collect()))
}

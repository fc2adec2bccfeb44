//! The fit under the product of choices that the paper leaves open: place of the cosine factor, exponent of the Stribeck
//! curve, lean free or held at what the printed steady coefficients ask for, weights.

use std::collections::BTreeMap;

use friction::{CosinePlacement, Exponent, LawKind};
use identification::{Identification as Found, Question, identify};
use rayon::prelude::*;
use rig::{Experiment, Model};
use serde::{Deserialize, Serialize};

use super::{Identified, failed};
use crate::multiverse::{Point, Worlds};
use crate::stage::{StageContext, StageError};
use crate::stages::friction_curves::{DIRECTIONS, relative_error};

/// One combination with the parameters that it gives; `None` where the fit did not converge.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Choice {
    /// The cosine factor on the stiffness term alone.
    stiffness_only: bool,
    /// The exponent 1/2 in place of 2.
    half: bool,
    /// Parameters of the law.
    pub(crate) parameters: Option<Vec<f64>>,
}

impl Choice {
    fn placement(&self) -> CosinePlacement {
        if self.stiffness_only {
            CosinePlacement::StiffnessOnly
        } else {
            CosinePlacement::AllTerms
        }
    }

    fn exponent(&self) -> Exponent<f64> {
        if self.half {
            Exponent::Half
        } else {
            Exponent::Two
        }
    }

    /// Forces on an experiment, N.
    pub(crate) fn predict(&self, experiment: &Experiment) -> Result<Option<Vec<f64>>, StageError> {
        let Some(parameters) = &self.parameters else {
            return Ok(None);
        };
        let model = Model::new(LawKind::AsymmetricBristle, Vec::new(), experiment)
            .map_err(failed)?
            .with_placement(self.placement())
            .with_exponent(self.exponent());
        let mut all = parameters.clone();
        all.resize(model.parameters().len(), 0.0);
        Ok(Some(model.predict(experiment, &all)))
    }
}

/// The axes, in the order of the product.
pub(crate) fn axes() -> Vec<(String, Vec<String>)> {
    [
        ("cosine factor", ["all terms", "stiffness term"]),
        ("Stribeck exponent", ["2", "1/2"]),
        ("θ₀", ["free", "held"]),
        ("weights", ["noise of the record", "all samples alike"]),
    ]
    .into_iter()
    .map(|(axis, options)| (axis.to_owned(), options.map(String::from).to_vec()))
    .collect()
}

/// All combinations fitted to the campaign of a material, in the order of the product.
pub(super) fn all(
    context: &StageContext<'_>,
    material: &Identified,
) -> Result<Vec<(Choice, Option<Found>)>, StageError> {
    let audit = context.earlier("audit")?;
    (0..16_usize)
        .into_par_iter()
        .map(|k| {
            let [stiffness_only, half, held, plain] = [8, 4, 2, 1].map(|bit| k & bit != 0);
            let mut choice = Choice {
                stiffness_only,
                half,
                parameters: None,
            };
            let mut question = Question::of(LawKind::AsymmetricBristle)
                .near(&material.found)
                .values_only();
            question.placement = choice.placement();
            question.exponent = Some(choice.exponent());
            question.plain = plain;
            if held {
                let reading = if stiffness_only {
                    "audit.lean.stiffness_only.mean.joint"
                } else {
                    "audit.lean.all_terms.mean.joint"
                };
                let Some(lean) = audit.value(reading) else {
                    return Ok((choice, None));
                };
                question = question.holding("theta0", lean);
            }
            let found = identify(&material.campaign, &question).map_err(failed)?;
            if !found.status.converged() {
                return Ok((choice, None));
            }
            let count = LawKind::AsymmetricBristle.parameters().len();
            choice.parameters = Some(found.parameters[..count].to_vec());
            Ok((choice, Some(found)))
        })
        .collect()
}

/// What each combination gives for a row of Table 1 or 2: values with the interval of their standard deviation.
pub(super) fn parameters(material: &str, choices: &[(Choice, Option<Found>)]) -> Worlds {
    worlds(choices, |found| {
        found
            .estimates
            .iter()
            .map(|e| {
                let half = e.sd.zip(e.drivers).map(|(sd, d)| sd * d.quantile);
                let point = Point {
                    value: e.value,
                    ci95: half.map(|half| [e.value - half, e.value + half]),
                };
                (format!("identification.{material}.{}", e.name), point)
            })
            .collect()
    })
}

/// What each combination leaves of the record, over the mean coefficient.
pub(super) fn errors(aluminium: &Identified, choices: &[(Choice, Option<Found>)]) -> Worlds {
    worlds(choices, |found| {
        DIRECTIONS
            .iter()
            .filter_map(|(direction, word, _)| {
                let error = relative_error(
                    &aluminium.campaign,
                    &aluminium.experiment,
                    &found.predicted_n,
                    *direction,
                )?;
                let id = format!("identification.aluminium.nrmse_{word}");
                Some((id, Point::from(error)))
            })
            .collect()
    })
}

fn worlds(
    choices: &[(Choice, Option<Found>)],
    values: impl Fn(&Found) -> BTreeMap<String, Point>,
) -> Worlds {
    Worlds {
        axes: axes(),
        values: choices
            .iter()
            .map(|(_, found)| found.as_ref().map(&values).unwrap_or_default())
            .collect(),
    }
}

//! The fit under the product of choices that the paper leaves open: place of the cosine factor, exponent of the Stribeck
//! curve, lean free or held at what the printed steady coefficients ask for, weights, integrator.
//!
//! A fit with another integrator is found by deferred correction. With f the prediction of the program's own integrator and
//! d(p) what another one adds to it, the parameters that fit f + d to the record y are those that fit f to y - d:
//!
//! ```text
//! p_0 fits f to y,   p_(k+1) fits f to y - d(p_k),   until p moves by less than 0.01 of its standard deviation
//! ```
//!
//! At the end the residuals are those of the other integrator; only the derivatives that lead there are not its own. Most of
//! the way is foreseen on smooth predictions; the last step is a fit to the record. All fits of one combination share the
//! noise that the program's own integrator found, so that the axis moves nothing but the integrator.

use std::collections::BTreeMap;

use campaign::Campaign;
use friction::{CosinePlacement, Exponent, Law, LawKind};
use identification::{Identification as Found, Question, identify};
use rayon::prelude::*;
use rig::{Experiment, Model};
use serde::{Deserialize, Serialize};

use super::{Identified, failed};
use crate::integrators::Integrator;
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
    /// How the state is carried along the motion.
    integrator: Integrator,
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
        let own = model.predict(experiment, &all);
        let Some(added) = self.added_n(experiment, parameters)? else {
            return Ok(None);
        };
        Ok(Some(own.iter().zip(&added).map(|(f, d)| f + d).collect()))
    }

    fn law(&self, experiment: &Experiment, parameters: &[f64]) -> Result<Law<f64>, StageError> {
        let law = LawKind::AsymmetricBristle
            .build(parameters, experiment.height_m)
            .map_err(failed)?;
        Ok(law
            .with_placement(self.placement())
            .with_exponent(self.exponent()))
    }

    /// What the integrator adds to the forces of the program's own, N; `None` where its state leaves the numbers.
    fn added_n(
        &self,
        experiment: &Experiment,
        parameters: &[f64],
    ) -> Result<Option<Vec<f64>>, StageError> {
        if self.integrator == Integrator::Controlled {
            return Ok(Some(vec![0.0; experiment.samples()]));
        }
        let law = self.law(experiment, parameters)?;
        let mut added = Vec::with_capacity(experiment.samples());
        for run in &experiment.runs {
            let forces = self
                .integrator
                .force_n(&law, run)
                .zip(Integrator::Controlled.force_n(&law, run));
            let Some((other, own)) = forces else {
                return Ok(None);
            };
            added.extend(other.iter().zip(&own).map(|(other, own)| other - own));
        }
        Ok(Some(added))
    }

    /// Fits the integrator's predictions, from the fit of the program's own.
    fn corrected(
        self,
        material: &Identified,
        question: &Question,
        own: &Found,
    ) -> Result<Fitted, StageError> {
        const LIMIT: usize = 4;
        // What lies so far below the residuals moves no estimate by a hundredth of its standard deviation.
        const UNSEEN: f64 = 1e-4;
        let first = self.added_n(&material.experiment, &law_parameters(own))?;
        let residuals = material.experiment.measured_n.iter().zip(&own.predicted_n);
        let floor = root_mean_square(residuals.map(|(y, f)| y - f));
        if first.is_some_and(|added| root_mean_square(added.into_iter()) <= UNSEEN * floor) {
            return Ok(Fitted::of(self, own));
        }
        let none = vec![0.0; material.experiment.samples()];
        let mut former: Option<(Found, Vec<f64>)> = None;
        for _ in 0..LIMIT {
            let (found, used) = former
                .as_ref()
                .map_or((own, &none), |(found, used)| (found, used));
            let Some(foreseen) = self.foreseen(material, question, found, used)? else {
                break;
            };
            let Some(added) = self.added_n(&material.experiment, &law_parameters(&foreseen))?
            else {
                break;
            };
            let mut asked = question.clone().under_noise_of(own);
            asked = asked.near(&foreseen);
            let recorded = less(&material.campaign, &added);
            let next = identify(&recorded, &asked).map_err(failed)?;
            if !next.status.converged() {
                break;
            }
            if settled(&foreseen, &next, &next) {
                return Ok(Fitted::of(self, &next));
            }
            former = Some((next, added));
        }
        Ok(Fitted::none(self))
    }

    /// Where a fit that was given y - `used` goes when it is given y - d of its own answer: the same iteration on its smooth
    /// prediction, all samples alike, which costs a hundredth of a fit that estimates a noise.
    fn foreseen(
        &self,
        material: &Identified,
        question: &Question,
        found: &Found,
        used_n: &[f64],
    ) -> Result<Option<Found>, StageError> {
        const LIMIT: usize = 30;
        let mut smooth = Campaign::clone(&material.campaign);
        let forces = smooth.runs.iter_mut().flat_map(|run| &mut run.force_n);
        for ((force, predicted), used) in forces.zip(&found.predicted_n).zip(used_n) {
            *force = predicted + used;
        }
        let mut question = question.clone();
        question.plain = true;
        let mut former: Option<Found> = None;
        for _ in 0..LIMIT {
            let from = former.as_ref().unwrap_or(found);
            let Some(added) = self.added_n(&material.experiment, &law_parameters(from))? else {
                return Ok(None);
            };
            let asked = question.clone().near(from);
            let next = identify(&less(&smooth, &added), &asked).map_err(failed)?;
            if !next.status.converged() {
                return Ok(None);
            }
            let settled = former
                .as_ref()
                .is_some_and(|from| settled(from, &next, found));
            former = Some(next);
            if settled {
                break;
            }
        }
        Ok(former)
    }
}

/// A combination with the estimates that it gives.
pub(super) struct Fitted {
    pub(super) choice: Choice,
    /// Estimates by name; `None` where the fit did not converge.
    estimates: Option<Vec<(String, Point)>>,
}

impl Fitted {
    fn of(choice: Choice, found: &Found) -> Self {
        let estimates = found.estimates.iter().map(|e| {
            let half = e.sd.zip(e.drivers).map(|(sd, d)| sd * d.quantile);
            let point = Point {
                value: e.value,
                ci95: half.map(|half| [e.value - half, e.value + half]),
            };
            (e.name.clone(), point)
        });
        Self {
            estimates: Some(estimates.collect()),
            choice: Choice {
                parameters: Some(law_parameters(found)),
                ..choice
            },
        }
    }

    fn none(choice: Choice) -> Self {
        Self {
            choice,
            estimates: None,
        }
    }
}

fn law_parameters(found: &Found) -> Vec<f64> {
    found.parameters[..LawKind::AsymmetricBristle.parameters().len()].to_vec()
}

fn root_mean_square(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len().max(1) as f64;
    (values.map(|x| x * x).sum::<f64>() / count).sqrt()
}

/// The campaign with so much less force recorded, N, run by run.
fn less(campaign: &Campaign, added_n: &[f64]) -> Campaign {
    let mut campaign = campaign.clone();
    let recorded = campaign.runs.iter_mut().flat_map(|run| &mut run.force_n);
    for (force, added) in recorded.zip(added_n) {
        *force -= added;
    }
    campaign
}

/// Whether no estimate moved from one answer to the next by more than a hundredth of the standard deviation that `judge`
/// gives it.
fn settled(one: &Found, next: &Found, judge: &Found) -> bool {
    let moves = one.estimates.iter().zip(&next.estimates);
    moves.zip(&judge.estimates).all(|((one, next), judge)| {
        judge
            .sd
            .is_none_or(|sd| (next.value - one.value).abs() <= 1e-2 * sd)
    })
}

/// The axes, in the order of the product.
pub(crate) fn axes() -> Vec<(String, Vec<String>)> {
    let mut axes: Vec<(String, Vec<String>)> = [
        ("cosine factor", ["all terms", "stiffness term"]),
        ("Stribeck exponent", ["2", "1/2"]),
        ("θ₀", ["free", "held"]),
        ("weights", ["noise of the record", "all samples alike"]),
    ]
    .into_iter()
    .map(|(axis, options)| (axis.to_owned(), options.map(String::from).to_vec()))
    .collect();
    let integrators = Integrator::ALL.map(|one| one.words().to_owned()).to_vec();
    axes.push(("integrator".to_owned(), integrators));
    axes
}

/// All combinations fitted to the campaign of a material, in the order of the product.
pub(super) fn all(
    context: &StageContext<'_>,
    material: &Identified,
) -> Result<Vec<Fitted>, StageError> {
    let audit = context.earlier("audit")?;
    let fits = (0..16_usize)
        .into_par_iter()
        .map(|k| {
            let [stiffness_only, half, held, plain] = [8, 4, 2, 1].map(|bit| k & bit != 0);
            let choices = Integrator::ALL.map(|integrator| Choice {
                stiffness_only,
                half,
                integrator,
                parameters: None,
            });
            let own = &choices[0];
            let mut question = Question::of(LawKind::AsymmetricBristle)
                .near(&material.found)
                .values_only();
            question.placement = own.placement();
            question.exponent = Some(own.exponent());
            question.plain = plain;
            if held {
                let reading = if stiffness_only {
                    "audit.lean.stiffness_only.mean.joint"
                } else {
                    "audit.lean.all_terms.mean.joint"
                };
                let Some(lean) = audit.value(reading) else {
                    return Ok(choices.into_iter().map(Fitted::none).collect());
                };
                question = question.holding("theta0", lean);
            }
            let found = identify(&material.campaign, &question).map_err(failed)?;
            if !found.status.converged() {
                return Ok(choices.into_iter().map(Fitted::none).collect());
            }
            choices
                .into_iter()
                .map(|choice| match choice.integrator {
                    Integrator::Controlled => Ok(Fitted::of(choice, &found)),
                    _ => choice.corrected(material, &question, &found),
                })
                .collect()
        })
        .collect::<Result<Vec<Vec<_>>, StageError>>()?;
    Ok(fits.into_iter().flatten().collect())
}

/// What each combination gives for a row of Table 1 or 2: values with the interval of their standard deviation.
pub(super) fn parameters(material: &str, all: &[Fitted]) -> Worlds {
    let world = |fitted: &Fitted| {
        let estimates = fitted.estimates.iter().flatten();
        estimates
            .map(|(name, point)| (format!("identification.{material}.{name}"), *point))
            .collect()
    };
    Worlds {
        axes: axes(),
        values: all.iter().map(world).collect(),
    }
}

/// The error of each combination on a campaign over its mean coefficient, as values `STEM.nrmse_DIRECTION`.
pub(crate) fn errors(
    stem: &str,
    choices: &[Choice],
    campaign: &Campaign,
    experiment: &Experiment,
) -> Result<Worlds, StageError> {
    let world = |choice: &Choice| -> Result<BTreeMap<String, Point>, StageError> {
        let Some(force_n) = choice.predict(experiment)? else {
            return Ok(BTreeMap::new());
        };
        Ok(DIRECTIONS
            .iter()
            .filter_map(|(direction, word, _)| {
                let error = relative_error(campaign, experiment, &force_n, *direction)?;
                Some((format!("{stem}.nrmse_{word}"), Point::from(error)))
            })
            .collect())
    };
    Ok(Worlds {
        axes: axes(),
        values: choices.iter().map(world).collect::<Result<_, _>>()?,
    })
}

//! What is asked of a campaign.

use std::collections::BTreeMap;

use friction::{CosinePlacement, Exponent, LawKind};
use rig::{Cause, Experiment, Model};

/// A model to identify and how far to go.
#[derive(Clone, Debug)]
pub struct Question {
    /// The law.
    pub law: LawKind,
    /// Effects at the stations, identified together with the law.
    pub effects: Vec<Box<dyn Cause>>,
    /// Place of the cosine factor of the bristle laws.
    pub placement: CosinePlacement,
    /// Exponent of the Stribeck curve where it is not the law's own.
    pub exponent: Option<Exponent<f64>>,
    /// All samples weigh alike, whatever the noise.
    pub plain: bool,
    /// Parameters that are held, by name.
    pub fixed: BTreeMap<String, f64>,
    /// Whether profile intervals are wanted.
    pub intervals: bool,
    /// Whether lack of fit is tested.
    pub test_fit: bool,
    /// A former answer to begin from (law and effect parameters by name) instead of starts from the data.
    pub near: Option<BTreeMap<String, f64>>,
    /// A noise that is already known (held), instead of estimating it.
    pub noise: Option<fitting::noise::NoiseModel>,
}

impl Question {
    /// Everything about a plain law.
    pub fn of(law: LawKind) -> Self {
        Self {
            law,
            effects: Vec::new(),
            placement: CosinePlacement::AllTerms,
            exponent: None,
            plain: false,
            fixed: BTreeMap::new(),
            intervals: true,
            test_fit: true,
            near: None,
            noise: None,
        }
    }

    /// The same with effects.
    #[must_use]
    pub fn with_effects(mut self, effects: Vec<Box<dyn Cause>>) -> Self {
        self.effects = effects;
        self
    }

    pub(crate) fn model(&self, experiment: &Experiment) -> Result<Model, rig::ModelError> {
        let model =
            Model::new(self.law, self.effects.clone(), experiment)?.with_placement(self.placement);
        Ok(match self.exponent {
            Some(exponent) => model.with_exponent(exponent),
            None => model,
        })
    }

    /// The same with a parameter held.
    #[must_use]
    pub fn holding(mut self, name: &str, value: f64) -> Self {
        self.fixed.insert(name.to_owned(), value);
        self
    }

    /// Values only: no intervals, no test.
    #[must_use]
    pub fn values_only(mut self) -> Self {
        self.intervals = false;
        self.test_fit = false;
        self
    }

    /// The same from the answer to a neighbouring question.
    #[must_use]
    pub fn near(mut self, former: &crate::Identification) -> Self {
        self.near = Some(
            former
                .estimates
                .iter()
                .map(|e| (e.name.clone(), e.value))
                .collect(),
        );
        self
    }

    /// The same under the noise of a former answer: from its parameters, weighed as it was.
    #[must_use]
    pub fn under_noise_of(mut self, former: &crate::Identification) -> Self {
        self.plain = former.weighting == crate::Weighting::Plain;
        self.noise = (!self.plain).then(|| former.noise.clone());
        self.near(former)
    }
}

/// Why a campaign gives no parameters at all.
#[derive(Clone, Debug, thiserror::Error, PartialEq)]
pub enum IdentificationError {
    /// The campaign cannot be predicted.
    #[error(transparent)]
    Experiment(#[from] rig::ExperimentError),
    /// Law and effects do not go with each other or with the campaign.
    #[error(transparent)]
    Model(#[from] rig::ModelError),
    /// A held parameter is none of the model's.
    #[error("`{name}` is no parameter of this model; parameters: {known}")]
    UnknownParameter {
        /// As given.
        name: String,
        /// Names that exist.
        known: String,
    },
    /// A held value lies outside its bounds.
    #[error("{name} = {value} is outside [{lower}, {upper}]")]
    OutOfBounds {
        /// The parameter.
        name: String,
        /// As given.
        value: f64,
        /// Lower bound.
        lower: f64,
        /// Upper bound.
        upper: f64,
    },
    /// No start gives finite forces.
    #[error("no start gives finite forces: {0}")]
    NoStart(String),
    /// Fewer samples than parameters.
    #[error("{samples} samples cannot determine {parameters} parameters")]
    TooFewSamples {
        /// Samples.
        samples: usize,
        /// Parameters.
        parameters: usize,
    },
}

//! A law with the effects that act at the stations, as a function of one flat vector of parameters.
//!
//! Order of the vector: the law's parameters; each effect's fitted parameters, in the order in which the effects were
//! given; one initial state for each run that starts in an unknown state.

use std::borrow::Cow;
use std::ops::Range;

use friction::{CosinePlacement, Drive, Exponent, Law, LawError, LawKind, ParameterSpec, Scalar};
use nalgebra::DMatrix;

use crate::chain::Pass;
use crate::contact::{Paths, Walks};
use crate::{Cause, ChainScalar, Coupling, Experiment, Hook, Place, Reach, jacobian};

/// Why a model cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ModelError {
    /// The law does not go with this campaign.
    #[error(transparent)]
    Law(#[from] LawError),
    /// The same cause twice.
    #[error("cause `{0}` stands twice in the model")]
    Twice(String),
    /// A cause that cannot act on this law.
    #[error("cause `{cause}` cannot act on law `{law}`")]
    NotOnThisLaw {
        /// The cause.
        cause: &'static str,
        /// The law.
        law: &'static str,
    },
}

/// A law of friction on a rig with effects.
#[derive(Clone, Debug)]
pub struct Model {
    /// The law.
    pub law: LawKind,
    pub(crate) effects: Vec<Box<dyn Cause>>,
    /// Effects in the order of the stations.
    pub(crate) sequence: Vec<usize>,
    specs: Vec<ParameterSpec>,
    effects_start: Vec<usize>,
    /// Column of each run's initial state.
    initial: Vec<Option<usize>>,
    height_m: Option<f64>,
    placement: CosinePlacement,
    exponent: Option<Exponent<f64>>,
    sign_width: f64,
    /// Steps that a cord may cost for each sample.
    pub(crate) steps_a_sample: usize,
}

/// Width of the regularised sign of static laws, as a share of the campaign's largest speed.
const SIGN_WIDTH_SHARE: f64 = 1e-3;
/// Such widths below which a static law tells how its sign is smoothed and not how large friction is: at four of them the sign is
/// short of one by less than a thousandth.
const WIDTHS_OF_STANDSTILL: f64 = 4.0;

impl Model {
    /// A model for this campaign.
    ///
    /// # Errors
    /// A bristle law without a height, a cause that stands twice or cannot act on the law.
    pub fn new(
        law: LawKind,
        effects: Vec<Box<dyn Cause>>,
        experiment: &Experiment,
    ) -> Result<Self, ModelError> {
        if law.needs_height() && experiment.height_m.is_none() {
            return Err(LawError::HeightMissing(law.id()).into());
        }
        for (i, cause) in effects.iter().enumerate() {
            if effects[..i]
                .iter()
                .any(|other| other.id() == cause.id() && other.variant() == cause.variant())
            {
                return Err(ModelError::Twice(cause.id().to_owned()));
            }
            if !cause.applies_to(law) {
                return Err(ModelError::NotOnThisLaw {
                    cause: cause.id(),
                    law: law.id(),
                });
            }
        }
        let mut specs = experiment
            .scales
            .law_parameters(law, experiment.axis, experiment.has_load);
        let mut effects_start = Vec::with_capacity(effects.len() + 1);
        for cause in &effects {
            effects_start.push(specs.len());
            specs.extend(cause.parameters_for(experiment));
        }
        effects_start.push(specs.len());
        let mut initial = vec![None; experiment.runs.len()];
        if let Some(unit) = law.state_unit() {
            for (index, run) in experiment.runs.iter().enumerate() {
                if run.initial_state_unknown {
                    initial[index] = Some(specs.len());
                    specs.push(initial_state_spec(index, unit, experiment));
                }
            }
        }
        let mut sequence: Vec<usize> = (0..effects.len()).collect();
        sequence.sort_by_key(|&i| {
            (
                effects[i].station(),
                effects[i].rank(),
                effects[i].id(),
                effects[i].variant(),
            )
        });
        Ok(Self {
            law,
            effects,
            sequence,
            specs,
            effects_start,
            initial,
            height_m: experiment.height_m,
            placement: CosinePlacement::AllTerms,
            exponent: None,
            sign_width: SIGN_WIDTH_SHARE * experiment.scales.speed_m_s,
            steps_a_sample: crate::cord::STEPS_A_SAMPLE,
        })
    }

    /// Speed from which on the law tells how large friction is, m/s. A static law knows no standstill: below, its force is that of
    /// a smoothed sign. Zero for laws with a state.
    pub fn least_speed_m_s(&self) -> f64 {
        if self.law.is_dynamic() {
            0.0
        } else {
            WIDTHS_OF_STANDSTILL * self.sign_width
        }
    }

    /// The same model with the cosine factor of E7 in another place.
    pub fn with_placement(mut self, placement: CosinePlacement) -> Self {
        self.placement = placement;
        self
    }

    /// The same model with another exponent of the Stribeck curve as its baseline.
    pub fn with_exponent(mut self, exponent: Exponent<f64>) -> Self {
        self.exponent = Some(exponent);
        self
    }

    /// The same model with a cord that may cost fewer steps a sample: a run that takes more is NaN, as one that leaves the numbers.
    pub fn with_steps_a_sample(mut self, steps: usize) -> Self {
        self.steps_a_sample = steps;
        self
    }

    /// All parameters, in the order of the vector.
    pub fn parameters(&self) -> &[ParameterSpec] {
        &self.specs
    }

    /// Number of the law's own parameters, which come first.
    pub fn law_parameters(&self) -> usize {
        self.law.parameters().len()
    }

    /// The effects, in the order in which they were given.
    pub fn effects(&self) -> &[Box<dyn Cause>] {
        &self.effects
    }

    /// Places of an effect's parameters in the vector.
    pub fn span(&self, effect: usize) -> Range<usize> {
        self.effects_start[effect]..self.effects_start[effect + 1]
    }

    /// Places of the initial states in the vector.
    pub fn initial_states(&self) -> Range<usize> {
        self.effects_start[self.effects.len()]..self.specs.len()
    }

    /// Column of a run's initial state, if it has one.
    pub fn initial_state_of(&self, run: usize) -> Option<usize> {
        self.initial[run]
    }

    /// A vector with these law parameters, effects at their nulls and initial states at zero.
    pub fn at_null(&self, law_parameters: &[f64], experiment: &Experiment) -> Vec<f64> {
        let mut p = law_parameters.to_vec();
        for cause in &self.effects {
            p.extend(
                cause
                    .shape_grid(experiment)
                    .into_iter()
                    .next()
                    .unwrap_or_else(|| vec![0.0; cause.parameters().len()]),
            );
        }
        p.resize(self.specs.len(), 0.0);
        p
    }

    /// Recorded force of all runs, one after the other, N (rotary N m). Runs whose state leaves the numbers are NaN.
    ///
    /// # Panics
    /// If `parameters` is not as long as [`Model::parameters`].
    pub fn predict(&self, experiment: &Experiment, parameters: &[f64]) -> Vec<f64> {
        self.predict_beside(experiment, parameters, Paths::NONE)
    }

    /// [`Model::predict`], bit for bit, sooner where these paths serve.
    ///
    /// # Panics
    /// As [`Model::predict`].
    pub fn predict_beside(
        &self,
        experiment: &Experiment,
        parameters: &[f64],
        paths: &Paths,
    ) -> Vec<f64> {
        self.predict_along(experiment, parameters, &Walks::forgotten(paths))
    }

    /// [`Model::predict_beside`] over the runs that are wanted, bit for bit; NaN over others, but for those that a wanted one remembers.
    ///
    /// # Panics
    /// As [`Model::predict`].
    pub fn predict_of(
        &self,
        experiment: &Experiment,
        parameters: &[f64],
        paths: &Paths,
        wanted: impl Fn(usize) -> bool + Sync,
    ) -> Vec<f64> {
        self.pass(experiment, parameters, &Walks::forgotten(paths))
            .predict_of(&wanted)
    }

    /// [`Model::predict`] with the paths that it walks, for what is computed beside it.
    ///
    /// # Panics
    /// As [`Model::predict`].
    pub fn predict_and_keep(
        &self,
        experiment: &Experiment,
        parameters: &[f64],
    ) -> (Vec<f64>, Paths) {
        let walks = Walks::kept(Paths::NONE, self.most_walks(experiment));
        let values = self.predict_along(experiment, parameters, &walks);
        (values, walks.into_paths())
    }

    /// Paths that one pass walks at most: one a run, and one for each law that an effect moves its law towards.
    fn most_walks(&self, experiment: &Experiment) -> usize {
        let reaches = self.effects.iter().map(|cause| cause.reach());
        experiment.runs.len() * (1 + reaches.filter(|reach| *reach == Reach::Along).count())
    }

    fn predict_along(
        &self,
        experiment: &Experiment,
        parameters: &[f64],
        walks: &Walks<'_>,
    ) -> Vec<f64> {
        self.pass(experiment, parameters, walks).predict()
    }

    fn pass<'a>(
        &'a self,
        experiment: &'a Experiment,
        parameters: &'a [f64],
        walks: &'a Walks<'a>,
    ) -> Pass<'a, f64> {
        self.assert_complete(parameters);
        Pass {
            model: self,
            experiment,
            parameters,
            active: self.off_null(parameters),
            state_varies: true,
            gain: None,
            walks,
        }
    }

    /// The part of each recorded force that follows friction, N (rotary N m): what roughness and the scatter between runs
    /// multiply. It is the prediction less inertia, offsets, drifts and weights, as the sensor shows it. Rows as in
    /// [`Model::predict`].
    ///
    /// # Panics
    /// If `parameters` is not as long as [`Model::parameters`].
    pub fn friction(&self, experiment: &Experiment, parameters: &[f64]) -> Vec<f64> {
        self.friction_beside(experiment, parameters, Paths::NONE)
    }

    /// [`Model::friction`], bit for bit, sooner where these paths serve.
    ///
    /// # Panics
    /// As [`Model::friction`].
    pub fn friction_beside(
        &self,
        experiment: &Experiment,
        parameters: &[f64],
        paths: &Paths,
    ) -> Vec<f64> {
        self.assert_complete(parameters);
        jacobian::friction(self, experiment, parameters, paths)
    }

    /// Prediction and its derivatives: samples x `columns` (all parameters for `None`). Rows as in [`Model::predict`].
    ///
    /// An effect at its null takes part wherever one of its columns is asked for, so the derivatives at the null are
    /// those of the extension; the prediction itself is that of [`Model::predict`], bit for bit.
    ///
    /// # Panics
    /// If `parameters` is not as long as [`Model::parameters`], or a column is beyond it.
    pub fn predict_with_jacobian(
        &self,
        experiment: &Experiment,
        parameters: &[f64],
        columns: Option<&[usize]>,
    ) -> (Vec<f64>, DMatrix<f64>) {
        let walks = Walks::kept(Paths::NONE, self.most_walks(experiment));
        let values = self.predict_along(experiment, parameters, &walks);
        let every: Vec<usize>;
        let columns = match columns {
            Some(columns) => columns,
            None => {
                every = (0..self.specs.len()).collect();
                &every
            }
        };
        (
            values,
            jacobian::columns(self, experiment, parameters, columns, &walks),
        )
    }

    /// The derivatives of [`Model::predict_with_jacobian`], sooner where these paths serve.
    ///
    /// # Panics
    /// As there.
    pub fn jacobian_beside(
        &self,
        experiment: &Experiment,
        parameters: &[f64],
        columns: &[usize],
        paths: &Paths,
    ) -> DMatrix<f64> {
        self.assert_complete(parameters);
        let walks = Walks::kept(paths, self.most_walks(experiment));
        jacobian::columns(self, experiment, parameters, columns, &walks)
    }

    fn assert_complete(&self, parameters: &[f64]) {
        assert_eq!(
            parameters.len(),
            self.specs.len(),
            "one value for each parameter"
        );
    }

    /// How much later the recorded forces are than the recorded motions, all effects together, s.
    pub fn lateness_s(&self, parameters: &[f64]) -> f64 {
        let effects = self.effects.iter().enumerate();
        effects
            .map(|(i, cause)| cause.lateness_s(&parameters[self.span(i)]))
            .sum()
    }

    /// Which effects do something at these parameters.
    pub(crate) fn off_null(&self, parameters: &[f64]) -> Vec<bool> {
        (0..self.effects.len())
            .map(|i| !self.effects[i].is_null(&parameters[self.span(i)]))
            .collect()
    }

    /// What holds the specimen in a run: rigid where no cause at the coupling is off its null.
    pub fn coupling(
        &self,
        experiment: &Experiment,
        run: usize,
        parameters: &[f64],
    ) -> Coupling<f64> {
        let mut coupling = Coupling::rigid();
        let at = Place {
            experiment,
            run: &experiment.runs[run],
        };
        let active = self.off_null(parameters);
        for &i in &self.sequence {
            let cause = self.effects[i].as_ref();
            if active[i] && cause.reach() == Reach::Coupling {
                let hook = Hook::Coupling {
                    coupling: &mut coupling,
                };
                f64::call(cause, &parameters[self.span(i)], at, hook);
            }
        }
        coupling
    }

    /// Slope of the friction force over the slip speed, the law's state held, at a run's mean speed, N s/m (rotary N m s/rad): what
    /// friction adds to the damping of a specimen that swings while it slides, faster than bristles bend.
    pub fn contact_damping(&self, experiment: &Experiment, run: usize, parameters: &[f64]) -> f64 {
        let law: Law<f64> = self.law_with(parameters);
        let run = &experiment.runs[run];
        let mean = |x: &[f64]| x.iter().map(|v| v.abs()).sum::<f64>() / x.len().max(1) as f64;
        let sum = run.velocity_m_s.iter().sum::<f64>();
        let speed = mean(&run.velocity_m_s).copysign(sum);
        if speed == 0.0 {
            return 0.0;
        }
        let at = law.evaluate(law.steady_state(speed), &Drive::at(speed));
        mean(&run.load_n) * at.coefficient_v
    }

    /// The law with these parameters (of the whole vector).
    pub(crate) fn law_with<D: Scalar>(&self, parameters: &[D]) -> Law<D> {
        let mut law = self
            .law
            .build(&parameters[..self.law_parameters()], self.height_m)
            .expect("count and height were checked when the model was made")
            .with_placement(self.placement);
        law.sign_width = self.sign_width;
        match self.exponent {
            Some(Exponent::Two) => law = law.with_exponent(Exponent::Two),
            Some(Exponent::Half) => law = law.with_exponent(Exponent::Half),
            Some(Exponent::General(p)) => {
                law = law.with_exponent(Exponent::General(D::constant(p)))
            }
            None => {}
        }
        law
    }

    pub(crate) fn initial_state<D: Scalar>(&self, run: usize, parameters: &[D]) -> D {
        self.initial[run].map_or(D::constant(0.0), |column| parameters[column])
    }
}

fn initial_state_spec(index: usize, unit: &'static str, experiment: &Experiment) -> ParameterSpec {
    let (lower, upper, typical) = match unit {
        "rad" => (-3.0, 3.0, 0.1),
        _ => {
            let travel = experiment.scales.travel_m;
            (-10.0 * travel, 10.0 * travel, 1e-2 * travel)
        }
    };
    ParameterSpec {
        name: Cow::Owned(format!("initial_state_{}", index + 1)),
        unit: Cow::Borrowed(unit),
        doc: Cow::Owned(format!(
            "deflection at the first sample of run {}",
            index + 1
        )),
        lower,
        upper,
        typical,
        null: Some(0.0),
    }
}

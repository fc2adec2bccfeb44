//! What an effect at a station is: the trait that every cause of the catalogue implements.
//!
//! A cause changes the chain in one place, its [`Reach`], through the hook of that name, written once for every
//! scalar. At its null it is skipped, so baseline and extension agree bit for bit there. To add one: write a file with
//! a `Clone` type and `impl Cause for` it, and put it into a list; nothing else needs to know it.

use std::collections::BTreeMap;

use friction::{Aged, Law, LawKind, ParameterSpec, Scalar};
use num_dual::DualSVec64;

use crate::{Coupling, Experiment, RunMotion, Station};

/// The one place of the chain that a cause changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reach {
    /// The true slip speed at the samples ([`Cause::stage`]).
    Stage,
    /// The law itself ([`Cause::law`]).
    Law,
    /// The law, which moves towards another one within a run ([`Cause::along`]; [`Cause::law`] is the other one).
    Along,
    /// The speed at which the Stribeck curve is read ([`Cause::curve_speed`]).
    CurveSpeed,
    /// The static level, or the whole Stribeck curve ([`Cause::rest_gain`], [`Cause::aged`]).
    RestGain,
    /// What holds the specimen ([`Cause::coupling`]).
    Coupling,
    /// A factor on friction at the samples ([`Cause::factor`]).
    Factor,
    /// The force on its way to the record ([`Cause::record`]).
    Record,
}

impl Reach {
    /// Whether the state of the contact depends on it (then its derivatives must go through the integration).
    pub const fn moves_the_state(self) -> bool {
        !matches!(self, Reach::Factor | Reach::Record)
    }
}

/// The speed that the viscous part of friction follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Follows {
    /// The slip speed.
    TheSlip,
    /// The speed at which the Stribeck curve is read, signed.
    TheCurve,
    /// The size of that speed, on the side of the slip.
    ItsSize,
}

/// What a campaign must have for a cause to be told at all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Requirement {
    /// A recorded load.
    Load,
    /// No load: the law is one of forces.
    NoLoad,
    /// At least two loads.
    TwoLoads,
    /// The order of the runs.
    Order,
    /// The campaign's clock.
    Clock,
    /// A clock of the campaign that ran before the first run.
    RunningClock,
    /// Motion in both directions.
    BothDirections,
    /// Reversals within a run.
    Reversals,
    /// A stated moving mass on a rig without a load.
    MovingMass,
}

impl Requirement {
    /// Whether a campaign has it.
    pub fn is_met(self, experiment: &Experiment) -> bool {
        match self {
            Requirement::Load => experiment.has_load,
            Requirement::NoLoad => !experiment.has_load,
            Requirement::TwoLoads => experiment.has_load && experiment.has_two_loads(),
            Requirement::Order => experiment.has_order,
            Requirement::Clock => experiment.has_clock,
            Requirement::RunningClock => experiment.first_start_s != 0.0,
            Requirement::BothDirections => experiment.has_both_directions(),
            Requirement::Reversals => experiment.has_reversals(),
            Requirement::MovingMass => !experiment.has_load && experiment.moving_mass_kg > 0.0,
        }
    }

    /// What to say where it is missing.
    pub const fn lack(self) -> &'static str {
        match self {
            Requirement::Load => "no load is recorded",
            Requirement::NoLoad => "a load is recorded",
            Requirement::TwoLoads => "all runs have one load",
            Requirement::Order => "the order of the runs is not recorded",
            Requirement::Clock => "the start of the runs on the campaign's clock is not recorded",
            Requirement::RunningClock => "the campaign's clock begins with the first run",
            Requirement::BothDirections => "all runs go in one direction",
            Requirement::Reversals => "no run reverses",
            Requirement::MovingMass => "no moving mass is stated, or there is a load",
        }
    }
}

/// A parameter as it is reported: a function of the fitted ones.
#[derive(Clone, Debug, PartialEq)]
pub struct Reported {
    /// Name in files, as the catalogue fixes it.
    pub name: &'static str,
    /// Unit on a linear rig.
    pub unit: &'static str,
    /// Value.
    pub value: f64,
    /// Derivatives with respect to the fitted parameters, for intervals.
    pub gradient: Vec<f64>,
}

/// An effect at a station of the chain.
///
/// Parameters are *fitted* parameters; where these differ from what is reported (a periodic effect is fitted as the
/// pair of its sine and cosine), [`Cause::reported`] and [`Cause::from_reported`] translate.
pub trait Cause: Hooks {
    /// Name in files.
    fn id(&self) -> &'static str;

    /// What sets this form apart from others of the same id, such as memory in time or in distance.
    fn variant(&self) -> Option<&'static str> {
        None
    }

    /// The station at which it sits.
    fn station(&self) -> Station;

    /// Place among effects of the same station: smaller acts earlier.
    fn rank(&self) -> u8 {
        0
    }

    /// The place of the chain that it changes.
    fn reach(&self) -> Reach;

    /// One sentence for a reader.
    fn describe(&self) -> &'static str;

    /// Fitted parameters, bounds as they are physically sensible on any rig.
    fn parameters(&self) -> &'static [ParameterSpec];

    /// Fitted parameters with bounds for this campaign.
    fn parameters_for(&self, _experiment: &Experiment) -> Vec<ParameterSpec> {
        self.parameters().to_vec()
    }

    /// Indices of fitted parameters that are sizes: at zero, all of them, the cause does nothing. The others are shapes
    /// (a wavelength, a time constant), which mean nothing at the null.
    fn sizes(&self) -> &'static [usize] {
        &[0]
    }

    /// Whether the effect is nothing at these fitted parameters.
    fn is_null(&self, fitted: &[f64]) -> bool {
        self.sizes().iter().all(|&i| fitted[i] == 0.0)
    }

    /// Fitted parameters at the null, with the shape parameters at every place where a score test should look. One entry
    /// for causes without shape parameters.
    fn shape_grid(&self, experiment: &Experiment) -> Vec<Vec<f64>> {
        let specs = self.parameters_for(experiment);
        vec![
            specs
                .iter()
                .enumerate()
                .map(|(i, spec)| {
                    if self.sizes().contains(&i) {
                        0.0
                    } else {
                        spec.typical
                    }
                })
                .collect(),
        ]
    }

    /// Fitted parameters from which a fit may start: every shape with plausible sizes of both signs where the bounds
    /// allow them.
    fn starts(&self, experiment: &Experiment) -> Vec<Vec<f64>> {
        let specs = self.parameters_for(experiment);
        let mut starts = Vec::new();
        for shape in self.shape_grid(experiment) {
            for sign in [1.0, -1.0] {
                let mut start = shape.clone();
                for &i in self.sizes() {
                    start[i] = sign * specs[i].typical;
                }
                if start
                    .iter()
                    .zip(&specs)
                    .all(|(&value, spec)| spec.admits(value))
                {
                    starts.push(start);
                }
            }
        }
        starts
    }

    /// Gives a start what it needs beside its size to be a good place to begin a fit.
    fn prepare_start(&self, _experiment: &Experiment, _start: &mut [f64]) {}

    /// Places about a start from which the nearest to the record should be chosen, where a fit from the start itself may end in
    /// another valley.
    fn about(&self, _experiment: &Experiment, start: &[f64]) -> Vec<Vec<f64>> {
        vec![start.to_vec()]
    }

    /// Whether a period is searched for.
    fn is_periodic(&self) -> bool {
        false
    }

    /// Whether it is asked for only in the place of its plain form, or of a cause that is [`Cause::mistaken_for`] it, once that is found.
    fn refines(&self) -> bool {
        false
    }

    /// Other causes whose refined forms look like this one at first, and are asked in its place too.
    fn mistaken_for(&self) -> &'static [&'static str] {
        &[]
    }

    /// Whether a period in time goes on between the runs, by the clock of the day, rather than begin anew with each of them.
    fn goes_on_between_runs(&self) -> bool {
        false
    }

    /// The size in which a prediction has steps because samples hide at which moment between them something happens.
    fn stepped(&self) -> Option<usize> {
        None
    }

    /// Whether data show it directly (a flat top, few distinct values) rather than through a fit.
    fn is_data_integrity(&self) -> bool {
        false
    }

    /// What a campaign must have for it to be told.
    fn requirements(&self) -> &'static [Requirement] {
        &[]
    }

    /// The first requirement that a campaign does not meet.
    fn lack(&self, experiment: &Experiment) -> Option<Requirement> {
        self.requirements()
            .iter()
            .copied()
            .find(|r| !r.is_met(experiment))
    }

    /// Whether it can act on this law.
    fn applies_to(&self, _law: LawKind) -> bool {
        true
    }

    /// Number of values carried from run to run (zero before the first).
    fn memory(&self) -> usize {
        0
    }

    /// Whether its hook looks at nothing but motion and load of the run, so that runs with equal ones share their
    /// mechanics. Not so where place, rest or history count.
    fn sees_only_the_motion(&self) -> bool {
        matches!(
            self.reach(),
            Reach::Law | Reach::CurveSpeed | Reach::Coupling
        ) && self.memory() == 0
    }

    /// Parameters under the catalogue's names.
    fn reported(&self, fitted: &[f64]) -> Vec<Reported> {
        self.parameters()
            .iter()
            .enumerate()
            .map(|(i, spec)| Reported {
                name: match &spec.name {
                    std::borrow::Cow::Borrowed(name) => name,
                    std::borrow::Cow::Owned(_) => "parameter",
                },
                unit: match &spec.unit {
                    std::borrow::Cow::Borrowed(unit) => unit,
                    std::borrow::Cow::Owned(_) => "1",
                },
                value: fitted[i],
                gradient: (0..fitted.len())
                    .map(|j| f64::from(u8::from(i == j)))
                    .collect(),
            })
            .collect()
    }

    /// Fitted parameters from reported ones.
    ///
    /// # Errors
    /// A name that is missing.
    #[allow(clippy::wrong_self_convention)]
    fn from_reported(&self, reported: &BTreeMap<String, f64>) -> Result<Vec<f64>, String> {
        self.parameters()
            .iter()
            .map(|spec| {
                reported
                    .get(spec.name.as_ref())
                    .copied()
                    .ok_or_else(|| spec.name.to_string())
            })
            .collect()
    }

    /// How much later a recorded force is than the recorded motion at these fitted parameters, s.
    fn lateness_s(&self, _p: &[f64]) -> f64 {
        0.0
    }

    /// Whether roughness reaches the record through a filter where this is what makes the force late.
    fn filters_force(&self) -> bool {
        false
    }

    /// Steps from sample to sample through which the contact must be carried to follow what the stage or the channel does at these
    /// fitted parameters (1: the samples follow it).
    fn steps_a_sample(&self, _p: &[f64], _run: &RunMotion) -> usize {
        1
    }

    /// [`Reach::Stage`]: turns the recorded velocity into the true one, in place.
    fn stage<D: Scalar>(&self, _p: &[D], _at: Place<'_>, _velocity: &mut [D])
    where
        Self: Sized,
    {
    }

    /// [`Reach::Stage`]: whether the rig's stated mass moves as the true velocity says; else it follows the motor's.
    fn moves_the_mass(&self) -> bool {
        false
    }

    /// [`Reach::Law`]: changes the law for this run; `memory` holds what was carried to it and takes what goes on.
    fn law<D: Scalar>(&self, _p: &[D], _at: Place<'_>, _law: &mut Law<D>, _memory: &mut [D])
    where
        Self: Sized,
    {
    }

    /// [`Reach::Along`]: how far the law has moved at the samples towards the one that [`Cause::law`] makes with a memory of one; `memory`
    /// as there.
    fn along<D: Scalar>(&self, _p: &[D], _at: Place<'_>, _share: &mut [D], _memory: &mut [D])
    where
        Self: Sized,
    {
    }

    /// [`Reach::CurveSpeed`]: `speed` holds the signed velocity and takes the one that the Stribeck curve sees (its
    /// magnitude is taken afterwards).
    fn curve_speed<D: Scalar>(&self, _p: &[D], _at: Place<'_>, _speed: &mut [D])
    where
        Self: Sized,
    {
    }

    /// [`Reach::CurveSpeed`]: how the viscous part of friction follows that speed too.
    fn viscous_part(&self) -> Follows {
        Follows::TheSlip
    }

    /// [`Reach::RestGain`]: what of the Stribeck curve the gain multiplies.
    fn aged(&self) -> Aged {
        Aged::StaticLevel
    }

    /// [`Reach::RestGain`]: multiplies the factor on what has aged, from each sample to the next.
    fn rest_gain<D: Scalar>(&self, _p: &[D], _at: Place<'_>, _gain: &mut [D])
    where
        Self: Sized,
    {
    }

    /// [`Reach::Coupling`]: sets compliance and damping of what holds the specimen.
    fn coupling<D: Scalar>(&self, _p: &[D], _at: Place<'_>, _coupling: &mut Coupling<D>)
    where
        Self: Sized,
    {
    }

    /// [`Reach::Factor`]: multiplies the factor on friction at the samples. `friction_n` is the friction force with the
    /// factors of earlier effects; `memory` as in [`Cause::law`].
    fn factor<D: Scalar>(
        &self,
        _p: &[D],
        _at: Place<'_>,
        _friction_n: &[D],
        _factor: &mut [D],
        _memory: &mut [D],
    ) where
        Self: Sized,
    {
    }

    /// [`Reach::Record`]: changes the force at the samples, in place.
    fn record<D: Scalar>(&self, _p: &[D], _at: Place<'_>, _force_n: &mut [D])
    where
        Self: Sized,
    {
    }
}

/// Where a hook acts.
#[derive(Clone, Copy, Debug)]
pub struct Place<'a> {
    /// The campaign.
    pub experiment: &'a Experiment,
    /// The run.
    pub run: &'a RunMotion,
}

/// A call of a hook, for dispatch over `dyn Cause`.
#[derive(Debug)]
#[allow(missing_docs)]
pub enum Hook<'a, D> {
    Stage {
        velocity: &'a mut [D],
    },
    Law {
        law: &'a mut Law<D>,
        memory: &'a mut [D],
    },
    Along {
        share: &'a mut [D],
        memory: &'a mut [D],
    },
    CurveSpeed {
        speed: &'a mut [D],
    },
    RestGain {
        gain: &'a mut [D],
    },
    Coupling {
        coupling: &'a mut Coupling<D>,
    },
    Factor {
        friction_n: &'a [D],
        factor: &'a mut [D],
        memory: &'a mut [D],
    },
    Record {
        force_n: &'a mut [D],
    },
}

fn dispatch<C: Cause, D: Scalar>(cause: &C, p: &[D], at: Place<'_>, hook: Hook<'_, D>) {
    match hook {
        Hook::Stage { velocity } => cause.stage(p, at, velocity),
        Hook::Law { law, memory } => cause.law(p, at, law, memory),
        Hook::Along { share, memory } => cause.along(p, at, share, memory),
        Hook::CurveSpeed { speed } => cause.curve_speed(p, at, speed),
        Hook::RestGain { gain } => cause.rest_gain(p, at, gain),
        Hook::Coupling { coupling } => cause.coupling(p, at, coupling),
        Hook::Factor {
            friction_n,
            factor,
            memory,
        } => cause.factor(p, at, friction_n, factor, memory),
        Hook::Record { force_n } => cause.record(p, at, force_n),
    }
}

macro_rules! hooks_for {
    ($($method:ident: $scalar:ty),* $(,)?) => {
        /// The hooks for each scalar of the chain; written by the blanket implementation, never by hand.
        #[allow(missing_docs)]
        pub trait Hooks: Send + Sync {
            $(fn $method(&self, p: &[$scalar], at: Place<'_>, hook: Hook<'_, $scalar>);)*
            fn boxed(&self) -> Box<dyn Cause>;
        }

        impl<C: Cause + Clone + 'static> Hooks for C {
            $(fn $method(&self, p: &[$scalar], at: Place<'_>, hook: Hook<'_, $scalar>) {
                dispatch(self, p, at, hook);
            })*
            fn boxed(&self) -> Box<dyn Cause> {
                Box::new(self.clone())
            }
        }

        $(impl ChainScalar for $scalar {
            fn call(cause: &dyn Cause, p: &[Self], at: Place<'_>, hook: Hook<'_, Self>) {
                cause.$method(p, at, hook);
            }
        })*
    };
}

/// A scalar that can pass through a chain of `dyn Cause`.
pub trait ChainScalar: Scalar {
    /// Calls a hook of a cause.
    fn call(cause: &dyn Cause, p: &[Self], at: Place<'_>, hook: Hook<'_, Self>);
}

hooks_for! {
    call_value: f64,
    call_dual_1: DualSVec64<1>,
    call_dual_4: DualSVec64<4>,
    call_dual_8: DualSVec64<8>,
    call_dual_12: DualSVec64<12>,
}

impl Clone for Box<dyn Cause> {
    fn clone(&self) -> Self {
        self.as_ref().boxed()
    }
}

impl std::fmt::Debug for dyn Cause {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Cause({})", self.id())
    }
}

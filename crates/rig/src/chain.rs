//! One campaign through the chain, for one scalar.

use std::sync::OnceLock;

use friction::{Aged, IntegrationError, Law, Scalar};
use rayon::prelude::*;

use crate::along::Move;
use crate::contact::Walks;
use crate::cord::{Corded, tension};
use crate::driven::Driven;
use crate::refined::between;
use crate::signal::slope;
use crate::{ChainScalar, Coupling, Experiment, Hook, Model, Place, Reach, RunMotion, Station};

/// What a prediction needs besides the model and the experiment.
pub(crate) struct Pass<'a, D> {
    pub(crate) model: &'a Model,
    pub(crate) experiment: &'a Experiment,
    pub(crate) parameters: &'a [D],
    /// Effects that take part: those off their null, and those whose derivatives are asked for.
    pub(crate) active: Vec<bool>,
    /// Whether the state of the contact depends on a seeded parameter; if not, it is computed in `f64`.
    pub(crate) state_varies: bool,
    /// A factor on the friction that leaves the contact (and the cord), for derivatives by it.
    pub(crate) gain: Option<D>,
    /// Paths of the contact's state.
    pub(crate) walks: &'a Walks<'a>,
}

impl<D: ChainScalar> Pass<'_, D> {
    /// Recorded force of all runs, N; NaN over a run whose state leaves the numbers.
    pub(crate) fn predict(&self) -> Vec<D> {
        self.predict_of(&|_| true)
    }

    /// The same with NaN over runs that are not wanted and that no wanted one remembers.
    pub(crate) fn predict_of(&self, wanted: &(dyn Fn(usize) -> bool + Sync)) -> Vec<D> {
        let runs = &self.experiment.runs;
        let done = Done::new(self);
        let each = if self.remembers() {
            let mut memories = self.blank();
            let one = |(index, run)| self.run(index, run, &mut memories, &done);
            let last = (0..runs.len()).rev().find(|&run| wanted(run));
            let remembered = runs
                .iter()
                .enumerate()
                .take(last.map_or(0, |last| last + 1));
            remembered.map(one).map(Some).collect()
        } else {
            self.side_by_side(&done, wanted)
        };
        let mut out = Vec::with_capacity(self.experiment.samples());
        let known = each.into_iter().chain(std::iter::repeat_with(|| None));
        for (force, run) in known.zip(runs) {
            match force {
                Some(Ok(force)) => out.extend(force),
                _ => out.resize(out.len() + run.len(), D::constant(f64::NAN)),
            }
        }
        out
    }

    /// Runs that know nothing of one another, on all threads: those first whose mechanics serve others. None of a run that is not wanted.
    fn side_by_side(
        &self,
        done: &Done<D>,
        wanted: &(dyn Fn(usize) -> bool + Sync),
    ) -> Vec<Option<Forces<D>>> {
        let runs = self.experiment.runs.par_iter().enumerate();
        let one = |index, run| self.run(index, run, &mut self.blank(), done);
        let first: Vec<Option<Forces<D>>> = runs
            .clone()
            .map(|(index, run)| (wanted(index) && !done.waits(index, run)).then(|| one(index, run)))
            .collect();
        runs.zip(first)
            .map(|((index, run), known)| known.or_else(|| wanted(index).then(|| one(index, run))))
            .collect()
    }

    /// Whether what a run has left behind reaches the runs after it.
    fn remembers(&self) -> bool {
        let mut effects = self.model.effects.iter().zip(&self.active);
        self.experiment.has_order && effects.any(|(cause, &active)| active && cause.memory() > 0)
    }

    /// What the effects know before the first run.
    fn blank(&self) -> Vec<Vec<D>> {
        let memories = self.model.effects.iter().map(|cause| cause.memory());
        memories.map(|held| vec![D::constant(0.0); held]).collect()
    }

    pub(crate) fn acts(&self, reach: Reach) -> bool {
        self.model
            .effects
            .iter()
            .zip(&self.active)
            .any(|(cause, &active)| active && cause.reach() == reach)
    }

    /// What rest makes larger: the whole curve where one of the effects says so.
    fn aged(&self) -> Aged {
        let effects = self.model.effects.iter().zip(&self.active);
        let whole = effects
            .filter(|(_, active)| **active)
            .any(|(cause, _)| cause.reach() == Reach::RestGain && cause.aged() == Aged::Whole);
        if whole {
            Aged::Whole
        } else {
            Aged::StaticLevel
        }
    }

    fn run(
        &self,
        index: usize,
        run: &RunMotion,
        memories: &mut [Vec<D>],
        done: &Done<D>,
    ) -> Forces<D> {
        let at = Place {
            experiment: self.experiment,
            run,
        };
        let mut law = self.law_of(at, memories);
        let corded = self.acts(Reach::Coupling) && run.in_contact();
        let moves = self.moves(at, &mut law, memories, corded);
        let driven = self.driven(run, corded);
        let contact = Contact {
            index,
            law: &law,
            moves: &moves,
            driven: &driven,
            initial: self.model.initial_state(index, self.parameters),
        };

        // contact, surface, history and load on the rigid chain
        let parts = driven.parts;
        let (mut force, mut factor, mut beside_chords) = (Vec::new(), None, None);
        if !corded || self.acts(Reach::Factor) {
            let fine = self.rigid_friction(&contact, run.twin, done)?;
            force = fine.iter().step_by(parts).copied().collect();
            let followed = parts > 1 && !corded && self.parts_of(Reach::Record, run) > 1;
            beside_chords = followed.then(|| beside(&fine, &force, parts));
        }
        if self.acts(Reach::Factor) {
            factor = Some(self.factors(at, &mut force, memories));
        }

        // coupling
        if corded {
            let known = done.corded(run.twin).filter(|_| factor.is_none());
            force = match known {
                Some(same) => same.to_vec(),
                None => {
                    let force = self.through_the_cord(at, &contact, factor.as_deref())?;
                    done.keep_corded(index, &force);
                    force
                }
            };
        }
        if let Some(gain) = self.gain {
            force.iter_mut().for_each(|f| *f *= gain);
        }
        self.add_inertia(run, &driven, &mut force);

        // load, sensor, clock
        Ok(self.recorded(run, &driven, force, beside_chords))
    }

    /// The law of this run.
    fn law_of(&self, at: Place<'_>, memories: &mut [Vec<D>]) -> Law<D> {
        let mut law = self.model.law_with(self.parameters);
        self.each_with_memory(Reach::Law, memories, |cause, p, memory| {
            let hook = Hook::Law {
                law: &mut law,
                memory,
            };
            D::call(cause, p, at, hook);
        });
        if self.acts(Reach::RestGain) {
            law.curve.aged = self.aged();
        }
        law
    }

    /// Friction force of the rigid chain on the grid of the run, without the factors on it: load times coefficient.
    fn rigid_friction(
        &self,
        contact: &Contact<'_, D>,
        twin: usize,
        done: &Done<D>,
    ) -> Result<Vec<D>, IntegrationError> {
        if let Some(same) = done.rigid(twin) {
            return Ok(same.to_vec());
        }
        let driven = contact.driven;
        let coefficient = self.coefficients(contact)?;
        let loads = &driven.motion.load_n;
        let force: Vec<D> = (coefficient.iter().zip(loads))
            .map(|(&mu, &load)| mu * (driven.turn * load))
            .collect();
        done.keep_rigid(contact.index, &force);
        Ok(force)
    }

    /// The factors of surface, history, speed and load on friction at the samples; the force takes them.
    fn factors(&self, at: Place<'_>, force: &mut Vec<D>, memories: &mut [Vec<D>]) -> Vec<D> {
        let mut whole = vec![D::constant(1.0); force.len()];
        let mut scaled = force.clone();
        self.each_with_memory(Reach::Factor, memories, |cause, p, memory| {
            let hook = Hook::Factor {
                friction_n: &scaled,
                factor: &mut whole,
                memory,
            };
            D::call(cause, p, at, hook);
            for ((scaled, force), factor) in scaled.iter_mut().zip(&*force).zip(&whole) {
                *scaled = *force * *factor;
            }
        });
        *force = scaled;
        whole
    }

    /// What reaches the sensor through the cord, at the samples.
    fn through_the_cord(
        &self,
        at: Place<'_>,
        contact: &Contact<'_, D>,
        factor: Option<&[D]>,
    ) -> Result<Vec<D>, IntegrationError> {
        let driven = contact.driven;
        let mut coupling = Coupling::rigid();
        self.couple(at, &mut coupling);
        let factors = factor.map(|factor| between(factor, driven.parts));
        let fine = self.tension(&Corded {
            law: contact.law,
            record: driven.record(),
            every_sample: &driven.motion.every_sample,
            load_n: &driven.motion.load_n,
            factor: factors.as_deref(),
            coupling,
            initial: contact.initial,
            steps_a_sample: self.model.steps_a_sample,
        })?;
        let samples = fine.iter().step_by(driven.parts);
        Ok(samples.map(|&f| f * driven.turn).collect())
    }

    /// What the channels make of the force: on the grid of the run where they follow what happens between the samples.
    fn recorded(
        &self,
        run: &RunMotion,
        driven: &Driven<'_, D>,
        mut force: Vec<D>,
        beside_chords: Option<Vec<D>>,
    ) -> Vec<D> {
        let record = |run: &RunMotion, force: &mut [D]| {
            self.in_place(Reach::Record, run, force, |force_n| Hook::Record {
                force_n,
            });
        };
        let Some(beside) = beside_chords else {
            record(run, &mut force);
            return force;
        };
        let mut fine = between(&force, driven.parts);
        for (f, b) in fine.iter_mut().zip(beside) {
            *f += b;
        }
        record(&driven.motion, &mut fine);
        fine.into_iter().step_by(driven.parts).collect()
    }

    /// Adds the inertia of the rig's stated mass.
    fn add_inertia(&self, run: &RunMotion, driven: &Driven<'_, D>, force: &mut [D]) {
        let mass = self.experiment.moving_mass_kg;
        if mass == 0.0 {
            return;
        }
        for (f, a) in force.iter_mut().zip(self.acceleration(run, driven)) {
            *f += a * mass;
        }
    }

    /// Acceleration of the rig's stated mass at the samples, m/s^2. It follows the speed of the motor, the record's where the velocity channel is
    /// sound, else what the channel was given; or that of the stage where an effect says so.
    fn acceleration(&self, run: &RunMotion, driven: &Driven<'_, D>) -> Vec<D> {
        let recorded = run.acceleration_m_s2.iter();
        let of_the_stage = (self.model.sequence.iter().copied())
            .filter(|&i| self.active[i] && self.model.effects[i].reach() == Reach::Stage);
        let mut effects = of_the_stage.map(|i| (i, &self.model.effects[i]));
        if effects.clone().any(|(_, cause)| cause.moves_the_mass()) {
            let beyond = driven.acceleration_beyond_the_record();
            return beyond
                .into_iter()
                .zip(recorded)
                .map(|(b, &a)| b + a)
                .collect();
        }
        let Some((i, channel)) = effects.find(|(_, cause)| cause.station() == Station::Sensor)
        else {
            return recorded.map(|&a| D::constant(a)).collect();
        };
        let at = Place {
            experiment: self.experiment,
            run,
        };
        let mut velocity: Vec<D> = run.velocity_m_s.iter().map(|&v| D::constant(v)).collect();
        let own = &self.parameters[self.model.span(i)];
        let hook = Hook::Stage {
            velocity: &mut velocity,
        };
        D::call(channel.as_ref(), own, at, hook);
        slope(&run.time_s, &velocity)
    }

    /// Effects that change a series in place, in the order of the stations.
    pub(crate) fn in_place(
        &self,
        reach: Reach,
        run: &RunMotion,
        series: &mut [D],
        hook: impl for<'h> Fn(&'h mut [D]) -> Hook<'h, D>,
    ) {
        let at = Place {
            experiment: self.experiment,
            run,
        };
        for &i in &self.model.sequence {
            let cause = self.model.effects[i].as_ref();
            if self.active[i] && cause.reach() == reach {
                D::call(
                    cause,
                    &self.parameters[self.model.span(i)],
                    at,
                    hook(series),
                );
            }
        }
    }

    fn couple(&self, at: Place<'_>, coupling: &mut Coupling<D>) {
        for &i in &self.model.sequence {
            let cause = self.model.effects[i].as_ref();
            if self.active[i] && cause.reach() == Reach::Coupling {
                D::call(
                    cause,
                    &self.parameters[self.model.span(i)],
                    at,
                    Hook::Coupling { coupling },
                );
            }
        }
    }

    pub(crate) fn each_with_memory(
        &self,
        reach: Reach,
        memories: &mut [Vec<D>],
        mut call: impl FnMut(&dyn crate::Cause, &[D], &mut [D]),
    ) {
        for &i in &self.model.sequence {
            let cause = self.model.effects[i].as_ref();
            if self.active[i] && cause.reach() == reach {
                call(
                    cause,
                    &self.parameters[self.model.span(i)],
                    &mut memories[i],
                );
            }
        }
    }

    /// Tension of the cord at the samples.
    fn tension(&self, held: &Corded<'_, D>) -> Result<Vec<D>, IntegrationError> {
        if D::NDERIV == 0 || self.state_varies {
            return tension(held);
        }
        // nothing that is seeded reaches the cord: values suffice
        let reals = held.record.real();
        let factor: Option<Vec<f64>> = held
            .factor
            .map(|factor| factor.iter().map(Scalar::value).collect());
        let values = tension(&Corded {
            law: &held.law.real(),
            record: reals.record(),
            every_sample: held.every_sample,
            load_n: held.load_n,
            factor: factor.as_deref(),
            coupling: held.coupling.real(),
            initial: held.initial.value(),
            steps_a_sample: held.steps_a_sample,
        })?;
        Ok(values.into_iter().map(D::constant).collect())
    }
}

/// The contact of a run: its law, the laws that this moves towards, what drives them, and the state at the first sample.
pub(crate) struct Contact<'a, D> {
    pub(crate) index: usize,
    pub(crate) law: &'a Law<D>,
    pub(crate) moves: &'a [Move<D>],
    pub(crate) driven: &'a Driven<'a, D>,
    pub(crate) initial: D,
}

/// What a series on the fine grid is beside the chords from sample to sample.
fn beside<D: Scalar>(fine: &[D], at_samples: &[D], parts: usize) -> Vec<D> {
    let chords = between(at_samples, parts);
    fine.iter().zip(chords).map(|(&f, c)| f - c).collect()
}

/// The recorded force at the samples of a run, N.
type Forces<D> = Result<Vec<D>, IntegrationError>;

/// Mechanics of runs that others repeat, see [`RunMotion::twin`].
struct Done<D> {
    /// Whether a run's mechanics serve another.
    wanted: Vec<bool>,
    rigid: Vec<OnceLock<Vec<D>>>,
    corded: Vec<OnceLock<Vec<D>>>,
}

impl<D: ChainScalar> Done<D> {
    fn new(pass: &Pass<'_, D>) -> Self {
        let runs = &pass.experiment.runs;
        let mut wanted = vec![false; runs.len()];
        let shared = (pass.model.effects.iter().zip(&pass.active))
            .filter(|&(_, &active)| active)
            .all(|(cause, _)| {
                cause.sees_only_the_motion()
                    || matches!(cause.reach(), Reach::Factor | Reach::Record)
            });
        if shared {
            for (index, run) in runs.iter().enumerate() {
                wanted[run.twin] |= run.twin != index;
            }
        }
        let places = || runs.iter().map(|_| OnceLock::new()).collect();
        Self {
            wanted,
            rigid: places(),
            corded: places(),
        }
    }

    /// Whether a run's mechanics are those of one before it.
    fn waits(&self, index: usize, run: &RunMotion) -> bool {
        run.twin != index && self.wanted[run.twin]
    }

    fn rigid(&self, twin: usize) -> Option<&[D]> {
        self.rigid[twin].get().map(Vec::as_slice)
    }

    fn corded(&self, twin: usize) -> Option<&[D]> {
        self.corded[twin].get().map(Vec::as_slice)
    }

    fn keep_rigid(&self, index: usize, force: &[D]) {
        if self.wanted[index] {
            self.rigid[index].get_or_init(|| force.to_vec());
        }
    }

    fn keep_corded(&self, index: usize, force: &[D]) {
        if self.wanted[index] {
            self.corded[index].get_or_init(|| force.to_vec());
        }
    }
}

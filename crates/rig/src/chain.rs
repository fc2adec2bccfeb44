//! One campaign through the chain, for one scalar.

use std::collections::BTreeMap;

use friction::{Aged, IntegrationError, Record, Scalar};

use crate::contact::Walks;
use crate::cord::{Corded, tension};
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
        let mut memories: Vec<Vec<D>> = self
            .model
            .effects
            .iter()
            .map(|cause| vec![D::constant(0.0); cause.memory()])
            .collect();
        let mut out = Vec::with_capacity(self.experiment.samples());
        let mut done = Done::new(self);
        for (index, run) in self.experiment.runs.iter().enumerate() {
            if !self.experiment.has_order {
                memories
                    .iter_mut()
                    .flatten()
                    .for_each(|m| *m = D::constant(0.0));
            }
            match self.run(index, run, &mut memories, &mut done) {
                Ok(force) => out.extend(force),
                Err(_) => out.resize(out.len() + run.len(), D::constant(f64::NAN)),
            }
        }
        out
    }

    fn acts(&self, reach: Reach) -> bool {
        self.model
            .effects
            .iter()
            .zip(&self.active)
            .any(|(cause, &active)| active && cause.reach() == reach)
    }

    /// Whether the viscous part follows the speed at which the curve is read.
    fn moves_the_viscous_part(&self) -> bool {
        (self.model.effects.iter().zip(&self.active))
            .any(|(cause, &active)| active && cause.moves_the_viscous_part())
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
        done: &mut Done<D>,
    ) -> Result<Vec<D>, IntegrationError> {
        let at = Place {
            experiment: self.experiment,
            run,
        };
        let n = run.len();

        // contact: the law of this run
        let mut law = self.model.law_with(self.parameters);
        self.each_with_memory(Reach::Law, memories, |cause, p, memory| {
            D::call(
                cause,
                p,
                at,
                Hook::Law {
                    law: &mut law,
                    memory,
                },
            );
        });

        let corded = self.acts(Reach::Coupling) && run.in_contact();
        let moves = self.moves(at, &mut law, memories, corded);

        // stage: recorded velocity -> slip speed. A specimen turned round meets the plate the other way.
        let parts = if corded {
            of_the_motion(run)
        } else {
            self.parts(run)
        };
        let followed = self.parts_of(Reach::Record, run) > 1;
        let halved = run.halved.as_deref().filter(|_| parts == 2);
        let refined = (parts > 1 && halved.is_none()).then(|| run.refined(parts));
        let motion = halved.or(refined.as_ref()).unwrap_or(run);
        let turn = if run.specimen_turned { -1.0 } else { 1.0 };
        let mut velocity: Vec<D> = motion
            .velocity_m_s
            .iter()
            .map(|&v| D::constant(v))
            .collect();
        self.in_place(Reach::Stage, motion, &mut velocity, |velocity| {
            Hook::Stage { velocity }
        });
        let remembered = self.acts(Reach::CurveSpeed).then(|| {
            let mut speed = velocity.clone();
            self.in_place(Reach::CurveSpeed, motion, &mut speed, |speed| {
                Hook::CurveSpeed { speed }
            });
            speed
        });
        let viscous_speed = remembered
            .as_ref()
            .filter(|_| self.moves_the_viscous_part());
        let viscous_speed =
            viscous_speed.map(|speed| speed.iter().map(|&u| u * turn).collect::<Vec<D>>());
        let curve_speed: Option<Vec<D>> =
            remembered.map(|speed| speed.into_iter().map(|u| u.magnitude()).collect());
        let rest_gain = self.acts(Reach::RestGain).then(|| {
            law.curve.aged = self.aged();
            let mut gain = vec![D::constant(1.0); motion.len()];
            self.in_place(Reach::RestGain, motion, &mut gain, |gain| Hook::RestGain {
                gain,
            });
            gain
        });
        if turn < 0.0 {
            velocity.iter_mut().for_each(|v| *v = -*v);
        }
        let shaped = self.acts(Reach::Stage) || curve_speed.is_some() || rest_gain.is_some();
        let knots = if shaped {
            &motion.every_sample
        } else {
            &motion.knots
        };
        let record = Record {
            time_s: &motion.time_s,
            velocity: &velocity,
            curve_speed: curve_speed.as_deref(),
            viscous_speed: viscous_speed.as_deref(),
            rest_gain: rest_gain.as_deref(),
            knots,
        };
        let initial = self.model.initial_state(index, self.parameters);

        let mut coupling = Coupling::rigid();
        if corded {
            self.couple(at, &mut coupling);
        }

        // friction on the rigid chain: load x coefficient x factors of surface, history, load
        let mut factor = None;
        let mut force: Vec<D> = Vec::new();
        let mut beside_chords: Option<Vec<D>> = None;
        if !corded || self.acts(Reach::Factor) {
            let fine = match done.rigid(run.twin) {
                Some(same) => same.to_vec(),
                None => {
                    let coefficient =
                        self.coefficients(index, (&law, &moves), &record, initial, parts)?;
                    let force: Vec<D> = coefficient
                        .iter()
                        .zip(&motion.load_n)
                        .map(|(&mu, &load)| mu * (turn * load))
                        .collect();
                    done.keep_rigid(index, &force);
                    force
                }
            };
            force = fine.iter().step_by(parts).copied().collect();
            beside_chords = (followed && parts > 1).then(|| {
                let chords = between(&force, parts);
                fine.iter().zip(chords).map(|(&f, c)| f - c).collect()
            });
        }
        if self.acts(Reach::Factor) {
            let mut whole = vec![D::constant(1.0); n];
            let mut scaled = force.clone();
            self.each_with_memory(Reach::Factor, memories, |cause, p, memory| {
                let hook = Hook::Factor {
                    friction_n: &scaled,
                    factor: &mut whole,
                    memory,
                };
                D::call(cause, p, at, hook);
                for ((scaled, force), factor) in scaled.iter_mut().zip(&force).zip(&whole) {
                    *scaled = *force * *factor;
                }
            });
            force = scaled;
            factor = Some(whole);
        }

        // coupling: what reaches the sensor through the cord
        if corded {
            let factors = factor.as_deref().map(|factor| between(factor, parts));
            let held = Corded {
                law: &law,
                record,
                every_sample: &motion.every_sample,
                load_n: &motion.load_n,
                factor: factors.as_deref(),
                coupling,
                initial,
                steps_a_sample: self.model.steps_a_sample,
            };
            force = match done.corded(run.twin).filter(|_| factor.is_none()) {
                Some(same) => same.to_vec(),
                None => {
                    let fine = self.tension(&held)?;
                    let force: Vec<D> = fine.iter().step_by(parts).map(|&f| f * turn).collect();
                    done.keep_corded(index, &force);
                    force
                }
            };
        }
        if let Some(gain) = self.gain {
            force.iter_mut().for_each(|f| *f *= gain);
        }
        self.add_inertia(run, &mut force);

        // load, sensor, clock
        let record_of = |run: &RunMotion, force: &mut [D]| {
            self.in_place(Reach::Record, run, force, |force_n| Hook::Record {
                force_n,
            });
        };
        match beside_chords.filter(|_| !corded) {
            None => record_of(run, &mut force),
            Some(beside) => {
                let mut fine = between(&force, parts);
                for (f, b) in fine.iter_mut().zip(beside) {
                    *f += b;
                }
                record_of(motion, &mut fine);
                force = fine.into_iter().step_by(parts).collect();
            }
        }
        Ok(force)
    }

    /// Adds the inertia of the rig's stated mass. It follows the speed of the motor: the record's where the velocity channel is
    /// sound, else what the channel was given.
    fn add_inertia(&self, run: &RunMotion, force: &mut [D]) {
        let mass = self.experiment.moving_mass_kg;
        if mass == 0.0 {
            return;
        }
        let of_the_channel = |i: &usize| {
            let cause = &self.model.effects[*i];
            self.active[*i] && cause.reach() == Reach::Stage && cause.station() == Station::Sensor
        };
        if let Some(i) = self.model.sequence.iter().copied().find(of_the_channel) {
            let at = Place {
                experiment: self.experiment,
                run,
            };
            let mut velocity: Vec<D> = run.velocity_m_s.iter().map(|&v| D::constant(v)).collect();
            let own = &self.parameters[self.model.span(i)];
            let hook = Hook::Stage {
                velocity: &mut velocity,
            };
            D::call(self.model.effects[i].as_ref(), own, at, hook);
            for (f, a) in force.iter_mut().zip(slope(&run.time_s, &velocity)) {
                *f += a * mass;
            }
            return;
        }
        for (f, a) in force.iter_mut().zip(&run.acceleration_m_s2) {
            *f += mass * a;
        }
    }

    /// Steps from sample to sample that a run's motion and the active effects ask for.
    fn parts(&self, run: &RunMotion) -> usize {
        let of_the_stage = self.parts_of(Reach::Stage, run);
        let of_the_record = self.parts_of(Reach::Record, run);
        of_the_motion(run).max(of_the_stage).max(of_the_record)
    }

    fn parts_of(&self, reach: Reach, run: &RunMotion) -> usize {
        let effects = self.model.effects.iter().enumerate();
        effects
            .filter(|&(i, cause)| self.active[i] && cause.reach() == reach)
            .map(|(i, cause)| {
                let own = &self.parameters[self.model.span(i)];
                let values: Vec<f64> = own.iter().map(Scalar::value).collect();
                cause.steps_a_sample(&values, run)
            })
            .fold(1, usize::max)
    }

    /// Effects that change a series in place, in the order of the stations.
    fn in_place(
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

/// Steps from sample to sample that a run's motion asks for.
fn of_the_motion(run: &RunMotion) -> usize {
    if run.halved.is_some() { 2 } else { 1 }
}

/// Mechanics of runs that others repeat, see [`RunMotion::twin`].
struct Done<D> {
    /// Whether a run's mechanics serve another.
    wanted: Vec<bool>,
    rigid: BTreeMap<usize, Vec<D>>,
    corded: BTreeMap<usize, Vec<D>>,
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
        Self {
            wanted,
            rigid: BTreeMap::new(),
            corded: BTreeMap::new(),
        }
    }

    fn rigid(&self, twin: usize) -> Option<&[D]> {
        self.rigid.get(&twin).map(Vec::as_slice)
    }

    fn corded(&self, twin: usize) -> Option<&[D]> {
        self.corded.get(&twin).map(Vec::as_slice)
    }

    fn keep_rigid(&mut self, index: usize, force: &[D]) {
        if self.wanted[index] {
            self.rigid.insert(index, force.to_vec());
        }
    }

    fn keep_corded(&mut self, index: usize, force: &[D]) {
        if self.wanted[index] {
            self.corded.insert(index, force.to_vec());
        }
    }
}

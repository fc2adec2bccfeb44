//! What drives the contact along one run: the slip speed that the stage gives it, and what of the past friction sees beside it, on the grid
//! on which the contact is carried.

use std::borrow::Cow;

use friction::{Record, Scalar};

use crate::chain::Pass;
use crate::signal::slope;
use crate::{ChainScalar, Follows, Hook, Reach, RunMotion};

/// A run as the contact meets it.
pub(crate) struct Driven<'r, D> {
    /// The motion on the grid: the samples, or steps between them.
    pub(crate) motion: Cow<'r, RunMotion>,
    /// Steps of the grid from one sample to the next.
    pub(crate) parts: usize,
    /// -1 where the specimen was turned round and meets the plate the other way, else 1.
    pub(crate) turn: f64,
    velocity: Vec<D>,
    curve_speed: Option<Vec<D>>,
    viscous_speed: Option<Vec<D>>,
    rest_gain: Option<Vec<D>>,
    /// Whether an effect bends the motion between the knots of the recorded one.
    shaped: bool,
}

impl<D: Scalar> Driven<'_, D> {
    /// What the true velocity adds to the recorded acceleration, at the samples, m/s^2: nothing where it is the recorded one.
    pub(crate) fn acceleration_beyond_the_record(&self) -> Vec<D> {
        let recorded = &self.motion.velocity_m_s;
        let beyond: Vec<D> = (self.velocity.iter().zip(recorded))
            .map(|(&v, &r)| v * self.turn - r)
            .collect();
        let slopes = slope(&self.motion.time_s, &beyond);
        slopes.into_iter().step_by(self.parts).collect()
    }

    /// The motion as the law of friction takes it.
    pub(crate) fn record(&self) -> Record<'_, D> {
        let knots = if self.shaped {
            &self.motion.every_sample
        } else {
            &self.motion.knots
        };
        Record {
            time_s: &self.motion.time_s,
            velocity: &self.velocity,
            curve_speed: self.curve_speed.as_deref(),
            viscous_speed: self.viscous_speed.as_deref(),
            rest_gain: self.rest_gain.as_deref(),
            knots,
        }
    }
}

impl<D: ChainScalar> Pass<'_, D> {
    /// Stage: recorded velocity -> slip speed, and what friction remembers of it.
    pub(crate) fn driven<'r>(&self, run: &'r RunMotion, corded: bool) -> Driven<'r, D> {
        let parts = if corded {
            of_the_motion(run)
        } else {
            self.parts(run)
        };
        let motion = match &run.halved {
            Some(halved) if parts == 2 => Cow::Borrowed(halved.as_ref()),
            _ if parts > 1 => Cow::Owned(run.refined(parts)),
            _ => Cow::Borrowed(run),
        };
        let turn = if run.specimen_turned { -1.0 } else { 1.0 };
        let recorded = motion.velocity_m_s.iter();
        let mut velocity: Vec<D> = recorded.map(|&v| D::constant(v)).collect();
        self.in_place(Reach::Stage, &motion, &mut velocity, |velocity| {
            Hook::Stage { velocity }
        });
        let remembered = self.acts(Reach::CurveSpeed).then(|| {
            let mut speed = velocity.clone();
            self.in_place(Reach::CurveSpeed, &motion, &mut speed, |speed| {
                Hook::CurveSpeed { speed }
            });
            speed
        });
        let rest_gain = self.acts(Reach::RestGain).then(|| {
            let mut gain = vec![D::constant(1.0); motion.len()];
            self.in_place(Reach::RestGain, &motion, &mut gain, |gain| Hook::RestGain {
                gain,
            });
            gain
        });
        let shaped = self.acts(Reach::Stage) || remembered.is_some() || rest_gain.is_some();
        if turn < 0.0 {
            velocity.iter_mut().for_each(|v| *v = -*v);
        }
        let viscous_speed = remembered
            .as_ref()
            .and_then(|speed| self.viscous_speed(speed, &velocity, turn));
        Driven {
            viscous_speed,
            curve_speed: remembered.map(|speed| speed.iter().map(|u| u.magnitude()).collect()),
            motion,
            parts,
            turn,
            velocity,
            rest_gain,
            shaped,
        }
    }

    /// The speed that the viscous part follows, where it is not the slip's.
    fn viscous_speed(&self, remembered: &[D], velocity: &[D], turn: f64) -> Option<Vec<D>> {
        let effects = self.model.effects.iter().zip(&self.active);
        let of_the_viscous_part = effects
            .filter(|(_, active)| **active)
            .map(|(cause, _)| cause.viscous_part())
            .find(|follows| *follows != Follows::TheSlip)?;
        let seen = remembered.iter().zip(velocity);
        let seen = seen.map(|(&u, v)| match of_the_viscous_part {
            Follows::ItsSize => u.magnitude() * v.value().signum(),
            _ => u * turn,
        });
        Some(seen.collect())
    }

    /// Steps from sample to sample that a run's motion and the active effects ask for.
    fn parts(&self, run: &RunMotion) -> usize {
        let of_the_stage = self.parts_of(Reach::Stage, run);
        let of_the_record = self.parts_of(Reach::Record, run);
        of_the_motion(run).max(of_the_stage).max(of_the_record)
    }

    pub(crate) fn parts_of(&self, reach: Reach, run: &RunMotion) -> usize {
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
}

/// Steps from sample to sample that a run's motion asks for.
fn of_the_motion(run: &RunMotion) -> usize {
    if run.halved.is_some() { 2 } else { 1 }
}

//! Derivatives of the state along the steps of a path.
//!
//! The stages of a step solve Z_i = z + h sum_j A_ij f(t_j, Z_j; p). By the implicit function theorem, with S the slopes df/dz at the
//! stages and M = I - h A diag(S),
//!
//! ```text
//! dZ = M^-1 (1 dz + h A df/dp dp)
//! ```
//!
//! so each stage's derivatives are one sum over those of the state before, of the motion and of the law's parameters, whose weights
//! are real. At a change of sign of v the rate vanishes on both sides: the crossing time contributes nothing.

use crate::gradient::{Followed, RateSlopes};
use crate::path::{Path, Step};
use crate::radau::{A, C, collocation_weights, inverse_newton_matrix};
use crate::stretch::{Node, Stretch, quintic, weighted};
use crate::{IntegrationError, Law, Record, Scalar};

impl Path {
    /// State at every sample with derivatives, for a law and a record whose real parts are those of the path.
    ///
    /// # Errors
    /// [`IntegrationError::Diverged`] where a step has no derivative.
    pub fn lift<D: Scalar>(
        &self,
        law: &Law<D>,
        record: &Record<'_, D>,
        initial: D,
    ) -> Result<Vec<D>, IntegrationError> {
        let mut states = Vec::with_capacity(record.time_s.len());
        if !law.is_dynamic() {
            states.resize(record.time_s.len(), D::constant(0.0));
            return Ok(states);
        }
        let followed = Followed::new(law);
        let mut steps = self.steps().iter().peekable();
        let mut z = initial;
        states.push(z);
        for (index, pair) in record.knots.windows(2).enumerate() {
            let (a, b) = (pair[0], pair[1]);
            let mut walk: Option<Walk<'_, D>> = None;
            while let Some(step) = steps.next_if(|step| step.stretch == index) {
                let walk = match &mut walk {
                    Some(walk) if walk.stretch.sign == step.sign => walk,
                    other => other.insert(Walk::new(law, &followed, record, a, b, step.sign)),
                };
                let taken = states.len() - 1 - a;
                let times = &record.time_s[a + 1 + taken..=b];
                let Some(next) = walk.follow(step, z, record.time_s[a], times, &mut states) else {
                    let time_s = record.time_s[a] + step.t;
                    return Err(IntegrationError::Diverged { time_s });
                };
                z = next;
            }
            // rounding of the end time must not lose the last sample
            states.resize(b + 1, z);
        }
        Ok(states)
    }
}

/// A stretch on one side of zero.
struct Walk<'a, D> {
    law: &'a Law<D>,
    followed: &'a Followed<D>,
    stretch: Stretch<D>,
    real: Stretch<f64>,
    /// Where the last step ended, where samples inside a step needed it.
    node: Option<Node<D>>,
}

impl<'a, D: Scalar> Walk<'a, D> {
    fn new(
        law: &'a Law<D>,
        followed: &'a Followed<D>,
        record: &Record<'_, D>,
        a: usize,
        b: usize,
        sign: f64,
    ) -> Self {
        let stretch = Stretch::between(record, a, b, sign);
        let real = stretch.real();
        Self {
            law,
            followed,
            stretch,
            real,
            node: None,
        }
    }

    /// The state after a step; pushes the states of samples at `times` that lie within it. `None`: there is no derivative.
    fn follow(
        &mut self,
        step: &Step,
        z: D,
        t0: f64,
        times: &[f64],
        states: &mut Vec<D>,
    ) -> Option<D> {
        let lifted = Lifted::new(self, step)?;
        let next = lifted.stage(self, step, &z, 2);
        let within = times.iter().take_while(|&&time| time - t0 <= step.end);
        let place = |time_s: f64| (time_s - t0 - step.t) / step.h;
        let inside = times.first().is_some_and(|&time| place(time) < 1.0);
        let start = self.node.take();
        if inside && !step.stiff {
            let start = start.unwrap_or_else(|| Node::at(self.law, &self.stretch, step.t, z));
            let finish = Node::at(self.law, &self.stretch, step.end, next);
            states.extend(within.map(|&time| match place(time) {
                s if s >= 1.0 => next,
                s => quintic(&start, &finish, step.h, s),
            }));
            self.node = Some(finish);
        } else if inside {
            let stages = [0, 1].map(|i| lifted.stage(self, step, &z, i));
            states.extend(within.map(|&time| match place(time) {
                s if s >= 1.0 => next,
                s => weighted([&z, &stages[0], &stages[1], &next], &collocation_weights(s)),
            }));
        } else {
            states.extend(within.map(|_| next));
        }
        Some(next)
    }
}

/// Slopes of a step's stages.
struct Lifted {
    rates: [RateSlopes; 3],
    /// By the state before the step.
    by_start: [f64; 3],
    /// By the rate at each stage, s.
    by_rate: [[f64; 3]; 3],
}

impl Lifted {
    #[inline(always)]
    fn new<D: Scalar>(walk: &Walk<'_, D>, step: &Step) -> Option<Self> {
        let law = &walk.followed.law;
        let rate = |i: usize| {
            let drive = walk.real.motion(step.t + C[i] * step.h).drive;
            law.rate_with_slopes(step.stages[i], &drive)
        };
        let rates = [rate(0), rate(1), rate(2)];
        let inverse = inverse_newton_matrix(step.h, &[rates[0].z, rates[1].z, rates[2].z])?;
        let mut by_rate = [[0.0; 3]; 3];
        for i in 0..3 {
            for j in 0..3 {
                let sum: f64 = (0..3).map(|k| inverse[i][k] * A[k][j]).sum();
                by_rate[i][j] = step.h * sum;
            }
        }
        Some(Self {
            rates,
            by_start: inverse.map(|row| row[0] + row[1] + row[2]),
            by_rate,
        })
    }

    /// Stage `i` with its derivatives.
    #[inline(always)]
    fn stage<D: Scalar>(&self, walk: &Walk<'_, D>, step: &Step, z: &D, i: usize) -> D {
        let weights = &self.by_rate[i];
        let sum = |slope: &dyn Fn(usize) -> f64| {
            weights[0] * slope(0) + weights[1] * slope(1) + weights[2] * slope(2)
        };
        let rates = &self.rates;
        let stretch = &walk.stretch;
        let after = |j: usize| step.t + C[j] * step.h;
        // where the curve is read at abs(v), the slope by its speed belongs to v
        let along = |j: usize| match stretch.curve {
            Some(_) => rates[j].velocity,
            None => rates[j].velocity + stretch.sign * rates[j].curve_speed,
        };
        let motion = [
            (z, self.by_start[i]),
            (&stretch.velocity, sum(&along)),
            (&stretch.acceleration, sum(&|j| along(j) * after(j))),
        ];
        let curve = stretch.curve.iter().flat_map(|(speed, slope)| {
            [
                (speed, sum(&|j| rates[j].curve_speed)),
                (slope, sum(&|j| rates[j].curve_speed * after(j))),
            ]
        });
        let gain = (stretch.rest_gain.iter()).map(|gain| (gain, sum(&|j| rates[j].rest_gain)));
        let law: [f64; 6] = std::array::from_fn(|k| sum(&|j| rates[j].law[k]));
        let arguments = motion.into_iter().chain(curve).chain(gain);
        D::along(
            step.stages[i],
            arguments.chain(walk.followed.of_the_rate(&law)),
        )
    }
}

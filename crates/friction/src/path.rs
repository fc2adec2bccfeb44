//! The state along a record in numbers, by steps that any derivatives can be taken along.
//!
//! On every stretch without change of sign the state is carried by Radau IIA (order five, L-stable) with steps chosen by its error
//! estimate, its stages found by Newton's iteration; samples inside a step are read off a quintic that matches z, z', z'' at both
//! ends. Units: s, m/s, state in rad or m.

use crate::integrate::TOLERANCE;
use crate::law::RateSlope;
use crate::radau::{A, C, E, GAMMA, collocation_weights, inverse_newton_matrix};
use crate::stretch::{Node, Stretch, quintic};
use crate::{IntegrationError, Law, Record};

/// Above this product of rate and step the quintic is replaced by the collocation polynomial, which does not overshoot.
const STIFF: f64 = 2.0;
/// Above this product the state is at its level all along the step, which has no polynomial of degree three: a step so stiff ends at the next
/// sample, where its error is known.
const QUASI_STATIC: f64 = 300.0;
/// Factor by which a step grows at most.
const FASTEST: f64 = 4.0;
/// The quintic of a step is continued over as many of its size at most.
const FARTHEST: f64 = 2.0;
const NEWTON_LIMIT: usize = 12;
const NEWTON_TOLERANCE: f64 = 1e-6;
/// A step is never cut below this share of its stretch.
const SMALLEST: f64 = 1e-9;
/// Steps that a run may try, at hand and for each of its samples: far more than any answer takes that the record can show. Beyond, an
/// error bound below what rounding leaves cuts every step to its smallest.
const STEPS_AT_HAND: usize = 10_000;
const STEPS_A_SAMPLE: usize = 100;

/// The state along a record.
#[derive(Clone, Debug)]
pub struct Path {
    states: Vec<f64>,
    steps: Vec<Step>,
}

/// A step of a path.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step {
    /// Which of the record's stretches it belongs to.
    pub(crate) stretch: usize,
    /// Side of zero.
    pub(crate) sign: f64,
    /// Start after the stretch's first knot, size and end, s.
    pub(crate) t: f64,
    pub(crate) h: f64,
    pub(crate) end: f64,
    /// States at the three stages; the last is the state at the end.
    pub(crate) stages: [f64; 3],
    /// The state decays within the step: samples are read off the collocation polynomial.
    pub(crate) stiff: bool,
}

impl Path {
    /// The state of a law along a record from z = `initial` at its first sample, with the steps that derivatives need.
    ///
    /// # Errors
    /// As [`crate::integrate`].
    pub fn along(
        law: &Law<f64>,
        record: &Record<'_, f64>,
        initial: f64,
    ) -> Result<Self, IntegrationError> {
        Self::within(law, record, initial, TOLERANCE, true)
    }

    pub(crate) fn within(
        law: &Law<f64>,
        record: &Record<'_, f64>,
        initial: f64,
        tolerance: f64,
        keeps_steps: bool,
    ) -> Result<Self, IntegrationError> {
        let n = record.time_s.len();
        let mut path = Self {
            states: Vec::with_capacity(n),
            steps: Vec::new(),
        };
        if !law.is_dynamic() {
            path.states.resize(n, 0.0);
            return Ok(path);
        }
        let level = law.curve.kinetic.abs().max(law.curve.at_rest.abs());
        let mut walker = Walker {
            law,
            record,
            tolerance: tolerance * level,
            step: f64::INFINITY,
            level,
            left: STEPS_AT_HAND + STEPS_A_SAMPLE * n,
            keeps_steps,
            last: None,
            path: &mut path,
        };
        walker.path.states.push(initial);
        let mut z = initial;
        for stretch in 0..record.knots.len().saturating_sub(1) {
            z = walker.stretch(stretch, z)?;
        }
        Ok(path)
    }

    /// State at every sample.
    pub fn states(&self) -> &[f64] {
        &self.states
    }

    pub(crate) fn into_states(self) -> Vec<f64> {
        self.states
    }

    pub(crate) fn steps(&self) -> &[Step] {
        &self.steps
    }
}

/// The law where a step ends.
#[derive(Clone, Copy)]
struct Arrival {
    z: f64,
    slope: RateSlope,
    sign: f64,
    rest_gain: Option<f64>,
    /// z''' within the step that ended.
    third: f64,
}

/// Where a step starts.
struct Start {
    node: Node<f64>,
    /// z''' as it was before.
    third: f64,
    /// Start and size of the step before on the same stretch, where its rates at both ends are exact.
    before: Option<(Node<f64>, f64)>,
    /// dz'/dz.
    slope: f64,
    /// Whether the rates are those of the law at the state, rather than carried over from a stage a rounding away.
    exact: bool,
}

impl Start {
    /// First guess of the stages of a step: the quintic of the step before continued, else Taylor's series, or where the step is
    /// stiff the state as it stands.
    #[inline(always)]
    fn continued(&self, h: f64) -> [f64; 3] {
        let node = &self.node;
        if (h * self.slope).abs() >= STIFF {
            return [node.z; 3];
        }
        match &self.before {
            Some((before, size)) if h <= FARTHEST * size => {
                C.map(|c| quintic(before, node, *size, 1.0 + c * h / size))
            }
            _ => C.map(|c| {
                let t = c * h;
                node.z + t * (node.rate + t * (0.5 * node.second + t * (self.third / 6.0)))
            }),
        }
    }
}

struct Walker<'a> {
    law: &'a Law<f64>,
    record: &'a Record<'a, f64>,
    tolerance: f64,
    /// Step that the estimate last allowed, s.
    step: f64,
    /// Level of the state: the size against which errors count.
    level: f64,
    /// Steps that may still be tried.
    left: usize,
    keeps_steps: bool,
    last: Option<Arrival>,
    path: &'a mut Path,
}

/// What a step is taken in: from `to - span` to `to` (s after the stretch's first knot at `t0`) the velocity does not change its sign.
struct Part<'a> {
    stretch: &'a Stretch<f64>,
    to: f64,
    span: f64,
    /// Where the next sample lies, at most `to`.
    sample: f64,
    t0: f64,
}

/// A solved step with the law at its end.
struct Solved {
    h: f64,
    stages: [f64; 3],
    end: RateSlope,
}

impl Walker<'_> {
    /// From one knot to the next, split where the velocity changes sign; pushes the states of its samples.
    fn stretch(&mut self, index: usize, mut z: f64) -> Result<f64, IntegrationError> {
        let (a, b) = (self.record.knots[index], self.record.knots[index + 1]);
        let span = self.record.time_s[b] - self.record.time_s[a];
        let (start, end) = (self.record.velocity[a], self.record.velocity[b]);
        let crossing = if start * end < 0.0 {
            start / (start - end) * span
        } else {
            span
        };
        let backward = start < 0.0 || (start == 0.0 && end < 0.0);
        let sign = if backward { -1.0 } else { 1.0 };
        let mut part = Stretch::between(self.record, a, b, sign);
        z = self.part(index, &part, 0.0, crossing, z)?;
        if crossing < span {
            part.sign = -part.sign;
            z = self.part(index, &part, crossing, span, z)?;
        }
        // rounding of the end time must not lose the last sample
        self.path.states.resize(b + 1, z);
        Ok(z)
    }

    /// From `from` to `to` (seconds after the first knot) with one sign of v.
    fn part(
        &mut self,
        index: usize,
        stretch: &Stretch<f64>,
        from: f64,
        to: f64,
        mut z: f64,
    ) -> Result<f64, IntegrationError> {
        let (a, b) = (self.record.knots[index], self.record.knots[index + 1]);
        let (t0, sign) = (self.record.time_s[a], stretch.sign);
        if stretch.velocity == 0.0 && stretch.acceleration == 0.0 {
            // at rest: z' = 0
            self.keep(Step {
                stretch: index,
                sign,
                t: from,
                h: to - from,
                end: to,
                stages: [z; 3],
                stiff: false,
            });
            return Ok(z);
        }
        let mut t = from;
        let mut start = self.start(stretch, t, z);
        while t < to {
            let sample = self.next_sample(b, t0).min(to);
            let part = Part {
                stretch,
                to,
                span: to - from,
                sample,
                t0,
            };
            let Solved { h, stages, end } = self.solve(&part, t, &start)?;
            // Rounding must not part the step from where it was to end.
            let rounding = 1e-12 * to;
            let mut end_s = t + h;
            if to - end_s <= rounding {
                end_s = to;
            } else if (sample - end_s).abs() <= rounding {
                end_s = sample;
            }
            let step = Step {
                stretch: index,
                sign,
                t,
                h,
                end: end_s,
                stages,
                // where the motion comes to rest nothing decays any more, but the way there was as stiff as its start
                stiff: start.slope.abs().max(end.z.abs()) * h > STIFF,
            };
            z = stages[2];
            if !z.is_finite() {
                return Err(IntegrationError::Diverged { time_s: t0 + t });
            }
            self.last = Some(Arrival {
                z,
                slope: end,
                sign,
                rest_gain: stretch.rest_gain,
                third: (end.second(&stretch.motion(step.end)) - start.node.second) / h,
            });
            let next = self.read_off(&step, stretch, &start, &self.record.time_s[..=b], t0);
            self.keep(step);
            t = step.end;
            start = match next {
                Some(next) => next,
                None => self.start(stretch, t, z),
            };
        }
        Ok(z)
    }

    fn keep(&mut self, step: Step) {
        if self.keeps_steps {
            self.path.steps.push(step);
        }
    }

    /// Rates where a step starts: those of the stage at which the last one ended, where nothing but the acceleration has changed.
    fn start(&self, stretch: &Stretch<f64>, t: f64, z: f64) -> Start {
        let motion = stretch.motion(t);
        let here = |last: &Arrival| {
            last.z == z && last.sign == stretch.sign && last.rest_gain == stretch.rest_gain
        };
        let carried = self.last.filter(here);
        let slope = match carried {
            Some(last) => last.slope,
            None => self.law.rate_slope(z, &motion.drive),
        };
        Start {
            node: Node {
                z,
                rate: slope.rate,
                second: slope.second(&motion),
            },
            third: carried.map_or(0.0, |last| last.third),
            before: None,
            slope: slope.z,
            exact: carried.is_none(),
        }
    }

    /// Pushes the states of samples within a step; where it had to know the rates at its end exactly, they start the next.
    fn read_off(
        &mut self,
        step: &Step,
        stretch: &Stretch<f64>,
        start: &Start,
        times: &[f64],
        t0: f64,
    ) -> Option<Start> {
        let taken = self.path.states.len();
        let within = times[taken..]
            .iter()
            .take_while(|&&time| time - t0 <= step.end);
        let place = |time_s: f64| (time_s - t0 - step.t) / step.h;
        let inside = times.get(taken).is_some_and(|&time| place(time) < 1.0);
        let end = step.stages[2];
        let states = &mut self.path.states;
        if inside && !step.stiff {
            let first = if start.exact {
                start.node
            } else {
                Node::at(self.law, stretch, step.t, start.node.z)
            };
            let motion = stretch.motion(step.end);
            let slope = self.law.rate_slope(end, &motion.drive);
            let node = Node {
                z: end,
                rate: slope.rate,
                second: slope.second(&motion),
            };
            states.extend(within.map(|&time| match place(time) {
                s if s >= 1.0 => end,
                s => quintic(&first, &node, step.h, s),
            }));
            return Some(Start {
                node,
                third: 0.0,
                before: Some((first, step.h)),
                slope: slope.z,
                exact: true,
            });
        }
        states.extend(within.map(|&time| match place(time) {
            s if s >= 1.0 => end,
            s => {
                let w = collocation_weights(s);
                let [first, second, third] = step.stages;
                start.node.z * w[0] + first * w[1] + second * w[2] + third * w[3]
            }
        }));
        None
    }

    /// The next sample whose state is not known, s after the first knot of the stretch that ends with sample `b`; infinite where all are.
    fn next_sample(&self, b: usize, t0: f64) -> f64 {
        let next = self.path.states.len();
        if next > b {
            return f64::INFINITY;
        }
        self.record.time_s[next] - t0
    }

    /// One accepted step from `t` on.
    fn solve(
        &mut self,
        part: &Part<'_>,
        t: f64,
        start: &Start,
    ) -> Result<Solved, IntegrationError> {
        let node = &start.node;
        let &Part {
            stretch,
            to,
            span,
            sample,
            t0,
        } = part;
        loop {
            let Some(left) = self.left.checked_sub(1) else {
                return Err(IntegrationError::TooManySteps { time_s: t0 + t });
            };
            self.left = left;
            let allowed = self.step.max(SMALLEST * span);
            let free = if t + allowed * 1.000_001 >= to {
                to - t
            } else {
                allowed
            };
            let speed = |t: f64| stretch.motion(t).drive.curve_speed;
            let share = self
                .law
                .share_to_the_peak(node.z, speed(t), speed(t + free));
            let mut h = share * free;
            if (start.slope * h).abs() > QUASI_STATIC {
                h = h.min(sample - t);
            }
            let smallest = h <= SMALLEST * span * 1.01;
            match self.stages(stretch, t, h, start) {
                Some((_, end)) if end.z.abs() * h > QUASI_STATIC && h > sample - t => {
                    self.step = sample - t;
                }
                Some((stages, end)) => {
                    let sum: f64 = (0..3).map(|i| E[i] * (stages[i] - node.z)).sum();
                    let estimate =
                        ((h * GAMMA * node.rate + sum) / (1.0 - h * GAMMA * start.slope)).abs();
                    let factor = growth(self.tolerance / estimate.max(1e-300));
                    if estimate <= self.tolerance || smallest {
                        let cut_by_stretch = (t + h >= to || h < free) && h < self.step;
                        let next = h * factor.clamp(0.2, FASTEST);
                        self.step = if cut_by_stretch {
                            self.step.max(next)
                        } else {
                            next
                        };
                        return Ok(Solved { h, stages, end });
                    }
                    self.step = h * factor.clamp(0.1, 0.9);
                }
                None if smallest => return Err(IntegrationError::Diverged { time_s: t0 + t }),
                None => self.step = 0.25 * h,
            }
        }
    }

    /// Newton's iteration for the three stages, with the law at the last of them; `None` where it does not settle.
    #[inline(always)]
    fn stages(
        &self,
        stretch: &Stretch<f64>,
        t: f64,
        h: f64,
        start: &Start,
    ) -> Option<([f64; 3], RateSlope)> {
        let node = &start.node;
        let drives = C.map(|c| stretch.motion(t + c * h).drive);
        let mut z = start.continued(h);
        let scale = self.level + node.z.abs();
        for _ in 0..NEWTON_LIMIT {
            let rate = |i: usize| self.law.rate_slope(z[i], &drives[i]);
            let rates = [rate(0), rate(1), rate(2)];
            let inverse = inverse_newton_matrix(h, &rates.map(|r| r.z))?;
            let mut residual = [0.0; 3];
            for i in 0..3 {
                let sum =
                    A[i][0] * rates[0].rate + A[i][1] * rates[1].rate + A[i][2] * rates[2].rate;
                residual[i] = z[i] - node.z - h * sum;
            }
            let change = inverse
                .map(|row| row[0] * residual[0] + row[1] * residual[1] + row[2] * residual[2]);
            let mut largest: f64 = 0.0;
            for i in 0..3 {
                z[i] -= change[i];
                largest = largest.max(change[i].abs());
            }
            if !largest.is_finite() {
                return None;
            }
            // convergence is quadratic: what is left after a change this small is rounding
            if largest <= NEWTON_TOLERANCE * scale {
                return Some((z, rates[2].moved_by(-change[2])));
            }
        }
        None
    }
}

/// Factor by which a step may grow, at most [`FASTEST`], for the bound over its estimate, which is of order four.
fn growth(allowed: f64) -> f64 {
    const SAFETY: f64 = 0.9;
    if allowed > (FASTEST / SAFETY).powi(4) {
        // short of the bound by far, as most steps from sample to sample: no root is worth its time
        return FASTEST;
    }
    SAFETY * allowed.sqrt().sqrt()
}

//! The specimen on an elastic cord: slip, tension and the mass between them as one stiff system.
//!
//! Slip speed v = V - u with V the stage's speed and u the specimen's, friction P = N mu(z, v) pulls the specimen
//! along, the cord (compliance C, damping d) holds it back:
//!
//! ```text
//! z'   = f(z, V - u)                      the law's state
//! C w' = u                                w: the stretch over C, N
//! q    = w (1 + h w^2 / 3)                q: elastic tension, N; stiffness (1 + h w^2) / C
//! m u' = P(z, V - u) - q - d u            m: mass on the cord, kg
//! recorded tension = q + d u
//! ```
//!
//! C = 0 is the rigid chain (u = 0, q = P), m = 0 a cord without mass: both are algebraic limits of the same system,
//! so derivatives exist at the null. h = 0 is a straight spring (q = w), h > 0 a cord that hardens (Duffing's cubic spring). Radau IIA solves M y' = F(y) with the singular M as it stands (Hairer and Wanner
//! II, VI.1). Units: m, m/s, N, kg; h in 1/N^2. Errors: steps keep the error estimate of z, q and the tension below 4e-6 of their size; between
//! stages the collocation polynomial is read.

use friction::radau::{A, A_INVERSE, C, E, GAMMA, collocation_weights};
use friction::{Drive, Evaluation, Followed, IntegrationError, Law, Record, Scalar};

use crate::factorised::Factorised;

const TOLERANCE: f64 = 4e-6;
const NEWTON_TOLERANCE: f64 = 1e-8;
const NEWTON_LIMIT: usize = 10;
const DESCENT_LIMIT: usize = 15;
/// Share of a Newton step below which it is taken even where the residual does not fall.
const SHORTEST: f64 = 0.02;
const SMALLEST: f64 = 1e-7;
/// Steps that a run may take on the way to each further sample, unless the model says otherwise. A smooth answer takes about one;
/// stick-slip far faster than the record takes a hundred, and its price must not grow without bound.
pub(crate) const STEPS_A_SAMPLE: usize = 200;
/// Steps that a run may take beyond these: what starts or rings somewhere is paid for by the smooth rest, stick-slip soon is not.
const STEPS_AT_HAND: usize = 2_000;

/// What holds the specimen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coupling<D> {
    /// Compliance C, m/N; 0 is rigid.
    pub compliance: D,
    /// Damping d, N s/m.
    pub damping: D,
    /// Mass m on the cord, kg.
    pub mass: D,
    /// h of q = w (1 + h w^2 / 3), 1/N^2: how the stiffness rises with the tension w that the cord would have without.
    pub hardening: D,
}

impl<D: Scalar> Coupling<D> {
    /// No cord.
    pub fn rigid() -> Self {
        let zero = D::constant(0.0);
        Self {
            compliance: zero,
            damping: zero,
            mass: zero,
            hardening: zero,
        }
    }

    /// Elastic tension q at the stretch w C, N.
    fn elastic(&self, w: D) -> D {
        w * (w * w * self.hardening * (1.0 / 3.0) + 1.0)
    }

    /// w at which the elastic tension is `tension`: Newton's iteration in numbers, and one step that carries derivatives. A cord that hardens
    /// is met from above, one that softens from below, each time on the side where the steps do not leap over it.
    fn stretched(&self, tension: D) -> D {
        const STEPS: usize = 100;
        let real = self.real();
        let mut w = tension.value();
        for _ in 0..STEPS {
            let step = (real.elastic(w) - tension.value()) / real.stiffening(w);
            w -= step;
            if step.abs() <= 1e-15 * w.abs() {
                break;
            }
        }
        let at = D::constant(w);
        at - (self.elastic(at) - tension) / real.stiffening(w)
    }

    pub(crate) fn real(&self) -> Coupling<f64> {
        Coupling {
            compliance: self.compliance.value(),
            damping: self.damping.value(),
            mass: self.mass.value(),
            hardening: self.hardening.value(),
        }
    }
}

impl Coupling<f64> {
    /// Compliance for small swings about a tension, m/N: C over what the stiffness has risen by there.
    pub fn compliance_at(&self, tension_n: f64) -> f64 {
        self.compliance / self.stiffening(self.stretched(tension_n))
    }

    /// dq/dw: the stiffness over the one without tension.
    fn stiffening(&self, w: f64) -> f64 {
        1.0 + self.hardening * w * w
    }
}

/// A run on a cord.
pub(crate) struct Corded<'a, D> {
    pub(crate) law: &'a Law<D>,
    pub(crate) record: Record<'a, D>,
    pub(crate) every_sample: &'a [usize],
    pub(crate) load_n: &'a [f64],
    pub(crate) factor: Option<&'a [D]>,
    pub(crate) coupling: Coupling<D>,
    pub(crate) initial: D,
    /// Steps allowed for each sample.
    pub(crate) steps_a_sample: usize,
}

/// State: deflection z, stretch of the cord over its compliance w (N), speed of the specimen u.
type State<D> = [D; 3];

/// Straight lines between two knots.
struct Stretch<D> {
    t0: f64,
    t1: f64,
    velocity: [D; 2],
    weight: [D; 2],
    curve: Option<[D; 2]>,
    /// What the speed that the viscous part follows is ahead of the stage.
    lead: Option<[D; 2]>,
    rest_gain: Option<D>,
}

impl<D: Scalar> Stretch<D> {
    fn line(&self, ends: &[D; 2], t: f64) -> D {
        ends[0] + (ends[1] - ends[0]) * ((t - self.t0) / (self.t1 - self.t0))
    }

    /// What drives the law where the specimen moves at speed `u`.
    fn drive(&self, t: f64, u: D) -> Drive<D> {
        let mut drive = Drive::at(self.line(&self.velocity, t) - u);
        if let Some(curve) = &self.curve {
            drive.curve_speed = self.line(curve, t);
        }
        drive.rest_gain = self.rest_gain;
        drive
    }

    /// Speed at which the curve is read where the specimen goes on at speed `u`, with the slip's sign where it has no memory.
    fn curve_speed(&self, t: f64, u: D) -> D {
        match &self.curve {
            Some(curve) => self.line(curve, t),
            None => self.line(&self.velocity, t) - u,
        }
    }

    fn real(&self) -> Stretch<f64> {
        let pair = |ends: &[D; 2]| [ends[0].value(), ends[1].value()];
        Stretch {
            t0: self.t0,
            t1: self.t1,
            velocity: pair(&self.velocity),
            weight: pair(&self.weight),
            curve: self.curve.as_ref().map(pair),
            lead: self.lead.as_ref().map(pair),
            rest_gain: self.rest_gain.map(|g| g.value()),
        }
    }
}

/// Law, motion and cord at one instant: rates and slopes.
struct Instant {
    law: Evaluation<f64>,
    weight: f64,
    /// Stretch of the cord over its compliance, N.
    stretch_n: f64,
    has_curve: bool,
    sign: f64,
}

impl Instant {
    fn at(law: &Law<f64>, stretch: &Stretch<f64>, t: f64, y: &State<f64>) -> Self {
        let drive = stretch.drive(t, y[2]);
        let mut evaluated = law.evaluate(y[0], &drive);
        if let Some(lead) = &stretch.lead {
            let (more, more_z) = law.viscous_beyond(y[0], drive.sign, stretch.line(lead, t));
            evaluated.coefficient += more;
            evaluated.coefficient_z += more_z;
        }
        Self {
            law: evaluated,
            weight: stretch.line(&stretch.weight, t),
            stretch_n: y[1],
            has_curve: stretch.curve.is_some(),
            sign: drive.sign,
        }
    }

    /// Rate of the law's state and friction force.
    fn forces(&self) -> [f64; 2] {
        [self.law.rate, self.weight * self.law.coefficient]
    }

    /// Right-hand sides of the three equations.
    fn rhs(&self, y: &State<f64>, coupling: &Coupling<f64>) -> State<f64> {
        let [rate, friction] = self.forces();
        [
            rate,
            y[2],
            friction - coupling.elastic(y[1]) - coupling.damping * y[2],
        ]
    }

    /// Derivatives of the right-hand sides in (z, w, u).
    fn jacobian(&self, coupling: &Coupling<f64>) -> [[f64; 3]; 3] {
        let along_v = self.law.rate_v
            + if self.has_curve {
                0.0
            } else {
                self.law.rate_curve * self.sign
            };
        [
            [self.law.rate_z, 0.0, -along_v],
            [0.0, 0.0, 1.0],
            [
                self.weight * self.law.coefficient_z,
                -coupling.stiffening(self.stretch_n),
                -self.weight * self.law.coefficient_v - coupling.damping,
            ],
        ]
    }
}

/// Slopes of a series at the stages from its values there: h s_i = sum_j A_INVERSE_ij (x_j - x_0).
fn stage_slopes<D: Scalar>(h: f64, from: D, at: &[D; 3]) -> [D; 3] {
    let moved = at.map(|x| x - from);
    std::array::from_fn(|i| {
        let row = &A_INVERSE[i];
        (moved[0] * row[0] + moved[1] * row[1] + moved[2] * row[2]) / h
    })
}

/// Speeds of the specimen at the stages: u = C w', so that only z and w are unknown.
fn with_speeds<D: Scalar>(
    compliance: D,
    h: f64,
    y0: &State<D>,
    z: &[D; 3],
    w: &[D; 3],
) -> [State<D>; 3] {
    let slopes = stage_slopes(h, y0[1], w);
    std::array::from_fn(|i| [z[i], w[i], compliance * slopes[i]])
}

/// The k-th component where the weights of the collocation polynomial read it between a step's start and its stages.
fn weighted<D: Scalar>(w: &[f64; 4], from: &State<D>, stages: &[State<D>; 3], k: usize) -> D {
    from[k] * w[0] + stages[0][k] * w[1] + stages[1][k] * w[2] + stages[2][k] * w[3]
}

/// Unknowns of Newton's iteration: deflections, then stretches over the compliance, of the three stages.
fn unknowns(stages: &[State<f64>; 3]) -> [f64; 6] {
    std::array::from_fn(|i| stages[i % 3][i / 3])
}

/// Residuals of a step of size h from y0, three of z' = f and three of the balance of forces; `forces` holds z' and P at
/// the stages.
fn residual<D: Scalar>(
    coupling: &Coupling<D>,
    h: f64,
    y0: &State<D>,
    stages: &[State<D>; 3],
    forces: &[[D; 2]; 3],
) -> [D; 6] {
    let accelerations = stage_slopes(h, y0[2], &[stages[0][2], stages[1][2], stages[2][2]]);
    let mut out = [D::constant(0.0); 6];
    for i in 0..3 {
        // z_i - z_0 - h sum_j A_ij f_j
        let sum = forces[0][0] * A[i][0] + forces[1][0] * A[i][1] + forces[2][0] * A[i][2];
        out[i] = stages[i][0] - y0[0] - sum * h;
        // q + d u + m u' - P
        let inertia = coupling.mass * accelerations[i];
        let elastic = coupling.elastic(stages[i][1]);
        out[3 + i] = elastic + coupling.damping * stages[i][2] + inertia - forces[i][1];
    }
    out
}

/// Derivatives of the residuals in (z_1, z_2, z_3, w_1, w_2, w_3).
fn newton_matrix(coupling: &Coupling<f64>, h: f64, instants: &[Instant; 3]) -> [[f64; 6]; 6] {
    let slopes: [[[f64; 3]; 3]; 3] = std::array::from_fn(|j| instants[j].jacobian(coupling));
    // du_j/dw_k = C/h A_INVERSE_jk, du'_i/dw_k = C/h^2 (A_INVERSE^2)_ik
    let speed = coupling.compliance / h;
    let swing = coupling.mass * speed / h;
    let mut matrix = [[0.0; 6]; 6];
    for i in 0..3 {
        for k in 0..3 {
            let same = f64::from(u8::from(i == k));
            matrix[i][k] = same - h * A[i][k] * slopes[k][0][0];
            let (mut through, mut twice) = (0.0, 0.0);
            for j in 0..3 {
                through += A[i][j] * slopes[j][0][2] * A_INVERSE[j][k];
                twice += A_INVERSE[i][j] * A_INVERSE[j][k];
            }
            matrix[i][3 + k] = -h * speed * through;
            matrix[3 + i][k] = -same * slopes[i][2][0];
            matrix[3 + i][3 + k] =
                -same * slopes[i][2][1] - slopes[i][2][2] * speed * A_INVERSE[i][k] + swing * twice;
        }
    }
    matrix
}

/// A step that is tried: of size h from the state y at time t.
#[derive(Clone, Copy)]
struct Trial<'s> {
    stretch: &'s Stretch<f64>,
    t: f64,
    h: f64,
    y: &'s State<f64>,
}

struct Solver<'a, D> {
    held: &'a Corded<'a, D>,
    law: Law<f64>,
    followed: Followed<D>,
    coupling: Coupling<f64>,
    /// Sizes of z and of tensions against which errors count.
    size: [f64; 2],
    step: f64,
    /// Steps that may be taken before the next sample.
    left: usize,
    /// Last step: its size and its stages, for the predictor.
    previous: Option<(f64, State<f64>, [State<f64>; 3])>,
}

/// Recorded tension at the samples, N.
pub(crate) fn tension<D: Scalar>(held: &Corded<'_, D>) -> Result<Vec<D>, IntegrationError> {
    let record = &held.record;
    let law = held.law.real();
    let level = law.curve.kinetic.abs().max(law.curve.at_rest.abs());
    let load = held.load_n.iter().fold(0.0_f64, |a, n| a.max(n.abs()));
    let friction = load * level * if law.is_dynamic() { law.stiffness } else { 1.0 };
    let mut solver = Solver {
        held,
        law,
        followed: Followed::new(held.law),
        coupling: held.coupling.real(),
        size: [
            if law.is_dynamic() { level } else { 1.0 },
            friction.max(1e-300),
        ],
        step: f64::INFINITY,
        left: STEPS_AT_HAND,
        previous: None,
    };
    let weight = |i: usize| match held.factor {
        Some(factor) => factor[i] * held.load_n[i],
        None => D::constant(held.load_n[i]),
    };
    // start: the cord holds what friction pulls, nothing moves yet
    let start = held.law.coefficient(held.initial, &record.drive(0)) * weight(0);
    let mut y = [
        held.initial,
        held.coupling.stretched(start),
        D::constant(0.0),
    ];
    let mut out = Vec::with_capacity(record.time_s.len());
    out.push(start);
    let steady_load = held.load_n.iter().all(|&n| n == held.load_n[0]);
    let knots = if held.factor.is_some() || !steady_load {
        held.every_sample
    } else {
        record.knots
    };
    for pair in knots.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let stretch = Stretch {
            t0: record.time_s[a],
            t1: record.time_s[b],
            velocity: [record.velocity[a], record.velocity[b]],
            weight: [weight(a), weight(b)],
            curve: record.curve_speed.map(|u| [u[a], u[b]]),
            lead: (record.viscous_lead(a))
                .zip(record.viscous_lead(b))
                .map(|(a, b)| [a, b]),
            rest_gain: record.rest_gain.map(|g| g[a]),
        };
        y = solver.stretch(&stretch, y, &record.time_s[a + 1..=b], &mut out)?;
    }
    Ok(out)
}

impl<D: Scalar> Solver<'_, D> {
    fn stretch(
        &mut self,
        stretch: &Stretch<D>,
        mut y: State<D>,
        times: &[f64],
        out: &mut Vec<D>,
    ) -> Result<State<D>, IntegrationError> {
        let real = stretch.real();
        let (mut t, mut taken) = (stretch.t0, 0);
        while taken < times.len() {
            let from = y.map(|x| x.value());
            let (h, stages) = self.step(&real, t, &from)?;
            let lifted = self.lift(stretch, &real, (t, h), &y, &stages)?;
            let end = if stretch.t1 - (t + h) <= 1e-9 * h {
                stretch.t1
            } else {
                t + h
            };
            while taken < times.len() && times[taken] <= end {
                let s = ((times[taken] - t) / h).min(1.0);
                let w = collocation_weights(s);
                let at = |k: usize| {
                    if s == 1.0 {
                        lifted[2][k]
                    } else {
                        weighted(&w, &y, &lifted, k)
                    }
                };
                let held = &self.held.coupling;
                out.push(held.elastic(at(1)) + held.damping * at(2));
                taken += 1;
                self.left += self.held.steps_a_sample;
            }
            self.previous = Some((h, from, stages));
            y = lifted[2];
            t = end;
        }
        Ok(y)
    }

    /// One accepted step in `f64`.
    fn step(
        &mut self,
        stretch: &Stretch<f64>,
        t: f64,
        y: &State<f64>,
    ) -> Result<(f64, [State<f64>; 3]), IntegrationError> {
        let smallest = SMALLEST * (stretch.t1 - stretch.t0);
        let now = Instant::at(&self.law, stretch, t, y);
        let rates = now.rhs(y, &self.coupling);
        let slopes = now.jacobian(&self.coupling);
        loop {
            if self.left == 0 {
                return Err(IntegrationError::TooManySteps { time_s: t });
            }
            self.left -= 1;
            let allowed = self.step.max(smallest);
            let free = if t + allowed * 1.000_001 >= stretch.t1 {
                stretch.t1 - t
            } else {
                allowed
            };
            let speed = |t: f64| stretch.curve_speed(t, y[2]);
            let share = self.law.share_to_the_peak(y[0], speed(t), speed(t + free));
            let h = share * free;
            let last_resort = h <= smallest * 1.01;
            let trial = Trial { stretch, t, h, y };
            let Some(stages) = self.newton(trial) else {
                if last_resort {
                    return Err(IntegrationError::Diverged { time_s: t });
                }
                self.step = 0.25 * h;
                continue;
            };
            let estimate = self.estimate(h, y, &rates, &slopes, &stages);
            let factor = 0.9 * (TOLERANCE / estimate.max(1e-300)).sqrt().sqrt();
            if estimate <= TOLERANCE || last_resort {
                let next = h * factor.clamp(0.2, 4.0);
                let cut_by_stretch = (t + h >= stretch.t1 || h < free) && h < self.step;
                self.step = if cut_by_stretch {
                    self.step.max(next)
                } else {
                    next
                };
                return Ok((h, stages));
            }
            self.step = h * factor.clamp(0.1, 0.9);
        }
    }

    /// Largest error of z, w and the tension relative to their sizes: (M - h GAMMA J) e = h GAMMA F(y) + M sum_i E_i (Y_i - y).
    fn estimate(
        &self,
        h: f64,
        y: &State<f64>,
        rates: &State<f64>,
        slopes: &[[f64; 3]; 3],
        stages: &[State<f64>; 3],
    ) -> f64 {
        let mass = [1.0, self.coupling.compliance, self.coupling.mass];
        let mut matrix = [[0.0; 3]; 3];
        let mut rhs = [0.0; 3];
        for k in 0..3 {
            for j in 0..3 {
                matrix[k][j] = -h * GAMMA * slopes[k][j] + if k == j { mass[k] } else { 0.0 };
            }
            let sum: f64 = (0..3).map(|i| E[i] * (stages[i][k] - y[k])).sum();
            rhs[k] = h * GAMMA * rates[k] + mass[k] * sum;
        }
        match Factorised::new(matrix) {
            Some(f) => {
                let e: [f64; 3] = f.solve(&rhs);
                let elastic = self.coupling.stiffening(y[1]) * e[1];
                let tension = elastic + self.coupling.damping * e[2];
                let force = elastic.abs().max(tension.abs()) / self.size[1];
                force.max((e[0] / self.size[0]).abs())
            }
            None => f64::INFINITY,
        }
    }

    fn predict(&self, h: f64, y: &State<f64>) -> [State<f64>; 3] {
        match &self.previous {
            Some((before, from, stages)) if h <= 2.0 * before => std::array::from_fn(|i| {
                let w = collocation_weights(1.0 + C[i] * h / before);
                std::array::from_fn(|k| weighted(&w, from, stages, k))
            }),
            _ => [*y; 3],
        }
    }

    /// Newton's iteration for the stages, from the continued polynomial and, failing that, from where the step begins.
    fn newton(&self, trial: Trial<'_>) -> Option<[State<f64>; 3]> {
        self.iterate(trial, self.predict(trial.h, trial.y))
            .or_else(|| self.iterate(trial, [*trial.y; 3]))
            .or_else(|| self.descend(trial))
    }

    /// Newton's iteration with its steps cut until the residual falls. A static law sticks by a sign that turns within a small
    /// share of the speed: whole steps leap from side to side of it.
    fn descend(&self, trial: Trial<'_>) -> Option<[State<f64>; 3]> {
        let weigh = |r: &[f64; 6]| -> f64 {
            let part = |i: usize| (r[i] / self.size[i / 3]).powi(2);
            (0..6).map(part).sum::<f64>()
        };
        let mut at = unknowns(&[*trial.y; 3]);
        let (mut instants, mut r) = self.balance(trial, &at);
        for _ in 0..DESCENT_LIMIT {
            let factorised = Factorised::new(newton_matrix(&self.coupling, trial.h, &instants))?;
            let change = factorised.solve(&r);
            let now = weigh(&r);
            let mut share = 1.0;
            let largest = loop {
                let next: [f64; 6] = std::array::from_fn(|i| at[i] - share * change[i]);
                let (there, left) = self.balance(trial, &next);
                if weigh(&left) < now || share < SHORTEST {
                    (at, instants, r) = (next, there, left);
                    let moved = |i: usize| (share * change[i] / self.size[i / 3]).abs();
                    break (0..6).map(moved).fold(0.0, f64::max);
                }
                share *= 0.5;
            };
            if !largest.is_finite() || largest > 1e6 {
                return None;
            }
            if share == 1.0 && largest <= NEWTON_TOLERANCE {
                return Some(self.stages(trial, &at));
            }
        }
        None
    }

    /// Stages of a trial at the unknowns (z_1, z_2, z_3, w_1, w_2, w_3).
    fn stages(&self, trial: Trial<'_>, at: &[f64; 6]) -> [State<f64>; 3] {
        let (z, w) = ([at[0], at[1], at[2]], [at[3], at[4], at[5]]);
        with_speeds(self.coupling.compliance, trial.h, trial.y, &z, &w)
    }

    /// The law at the stages and the residuals there.
    fn balance(&self, trial: Trial<'_>, at: &[f64; 6]) -> ([Instant; 3], [f64; 6]) {
        let Trial { stretch, t, h, y } = trial;
        let stages = self.stages(trial, at);
        let instants: [Instant; 3] =
            std::array::from_fn(|i| Instant::at(&self.law, stretch, t + C[i] * h, &stages[i]));
        let forces = [
            instants[0].forces(),
            instants[1].forces(),
            instants[2].forces(),
        ];
        let r = residual(&self.coupling, h, y, &stages, &forces);
        (instants, r)
    }

    fn iterate(&self, trial: Trial<'_>, stages: [State<f64>; 3]) -> Option<[State<f64>; 3]> {
        let mut at = unknowns(&stages);
        for _ in 0..NEWTON_LIMIT {
            let (instants, r) = self.balance(trial, &at);
            let factorised = Factorised::new(newton_matrix(&self.coupling, trial.h, &instants))?;
            let change = factorised.solve(&r);
            let mut largest: f64 = 0.0;
            for i in 0..6 {
                at[i] -= change[i];
                largest = largest.max((change[i] / self.size[i / 3]).abs());
            }
            if !largest.is_finite() || largest > 1e6 {
                return None;
            }
            if largest <= NEWTON_TOLERANCE {
                return Some(self.stages(trial, &at));
            }
        }
        None
    }

    /// Stages with derivatives: one Newton step in dual numbers with the real matrix of these very stages. (That of the last iteration may lie
    /// on the other side of rest, where a specimen that stands still moves by nothing but rounding, and the law's slopes jump with the sign.)
    fn lift(
        &self,
        stretch: &Stretch<D>,
        real: &Stretch<f64>,
        (t, h): (f64, f64),
        y: &State<D>,
        stages: &[State<f64>; 3],
    ) -> Result<[State<D>; 3], IntegrationError> {
        if D::NDERIV == 0 {
            return Ok(stages.map(|s| s.map(D::constant)));
        }
        let instants: [Instant; 3] =
            std::array::from_fn(|i| Instant::at(&self.law, real, t + C[i] * h, &stages[i]));
        let matrix = newton_matrix(&self.coupling, h, &instants);
        let factorised = Factorised::new(matrix).ok_or(IntegrationError::Diverged { time_s: t })?;
        let compliance = self.held.coupling.compliance;
        let (mut z, mut q) = (
            stages.map(|s| D::constant(s[0])),
            stages.map(|s| D::constant(s[1])),
        );
        let lifted = with_speeds(compliance, h, y, &z, &q);
        let forces: [[D; 2]; 3] = std::array::from_fn(|i| {
            let at = t + C[i] * h;
            let drive = stretch.drive(at, lifted[i][2]);
            let (rate, mut mu) = self.followed.rate_and_coefficient(&lifted[i][0], &drive);
            if let Some(lead) = &stretch.lead {
                let lead = stretch.line(lead, at);
                mu += (self.held.law)
                    .viscous_beyond(lifted[i][0], drive.sign, lead)
                    .0;
            }
            [rate, stretch.line(&stretch.weight, at) * mu]
        });
        let r = residual(&self.held.coupling, h, y, &lifted, &forces);
        let change = factorised.solve(&r);
        for i in 0..3 {
            z[i] -= change[i] - change[i].value();
            q[i] -= change[3 + i] - change[3 + i].value();
        }
        Ok(with_speeds(compliance, h, y, &z, &q))
    }
}

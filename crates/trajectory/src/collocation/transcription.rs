//! From an optimal control problem to a programme of blocks.
//!
//! Variables: parameters, then for every phase its duration and its points.
//! A scheme without a node at the start (Radau) has a start point of positions,
//! velocities and states only. Blocks: one a collocation point, one a
//! coordinate or state and interval (defects), one a linkage.
//!
//! ```text
//! defects of a coordinate, h = T / intervals, for every node i of the interval
//!   q_i − q_0 − h c_i v_0 − h² Σ_j B_ij a_j = 0
//!   v_i − v_0 − h Σ_j A_ij a_j = 0
//! ```

use super::problem::{End, EndPoint, OptimalControl, Phase, Point, PointRows};
use super::scheme::Scheme;
use super::trajectory::PhaseTrajectory;
use crate::{Block, Programme, Row, Scalar, Variable};

/// Where the variables of one point are.
#[derive(Clone, Debug, Default)]
pub(crate) struct PointIndex {
    pub q: Vec<usize>,
    pub v: Vec<usize>,
    pub a: Vec<usize>,
    pub s: Vec<usize>,
    pub rate: Vec<usize>,
    pub u: Vec<usize>,
}

/// Where the variables of one phase are.
#[derive(Clone, Debug)]
pub(crate) struct PhaseIndex {
    pub duration: usize,
    /// Start point, then the new points of every interval.
    pub points: Vec<PointIndex>,
}

/// What a block is.
#[derive(Clone, Copy, Debug)]
enum Role {
    /// Collocation point, with its weight as a share of the duration.
    Point {
        phase: usize,
        weight: f64,
    },
    Coordinate,
    State,
    Linkage(usize),
}

/// A starting guess at one instant of a phase.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Guess {
    /// Positions.
    pub q: Vec<f64>,
    /// Velocities.
    pub v: Vec<f64>,
    /// Accelerations.
    pub a: Vec<f64>,
    /// First-order states.
    pub s: Vec<f64>,
    /// Their rates.
    pub rate: Vec<f64>,
    /// Controls.
    pub u: Vec<f64>,
}

/// An optimal control problem as a programme.
pub struct Transcription<'p, P> {
    problem: &'p P,
    pub(crate) scheme: Scheme,
    pub(crate) phases: Vec<Phase>,
    pub(crate) index: Vec<PhaseIndex>,
    parameters: usize,
    variables: Vec<Variable>,
    blocks: Vec<Block>,
    roles: Vec<Role>,
    ends: Vec<Vec<End>>,
}

impl<'p, P: OptimalControl> Transcription<'p, P> {
    /// Lays the problem out for a scheme.
    pub fn new(problem: &'p P, scheme: Scheme) -> Self {
        let phases = problem.phases();
        let mut variables = problem.parameters();
        let parameters = variables.len();
        let index: Vec<PhaseIndex> = phases
            .iter()
            .map(|phase| lay_out_phase(phase, &scheme, &mut variables))
            .collect();
        let mut transcription = Self {
            problem,
            scheme,
            phases,
            index,
            parameters,
            variables,
            blocks: Vec::new(),
            roles: Vec::new(),
            ends: Vec::new(),
        };
        for phase in 0..transcription.phases.len() {
            transcription.add_points(phase);
            transcription.add_defects(phase);
        }
        transcription.add_linkages();
        transcription
    }

    fn push(&mut self, block: Block, role: Role) {
        self.blocks.push(block);
        self.roles.push(role);
    }

    fn add_points(&mut self, phase: usize) {
        let spec = self.phases[phase].clone();
        let index = self.index[phase].clone();
        let k = self.scheme.nodes.len();
        let shared = self.scheme.starts_at_node();
        let fresh = if shared { k - 1 } else { k };
        let mut weights = vec![0.0; index.points.len()];
        for interval in 0..spec.intervals {
            for (j, b) in self.scheme.weights.iter().enumerate() {
                let place = interval * fresh + j + usize::from(!shared);
                weights[place] += b / spec.intervals as f64;
            }
        }
        for (n, (point, weight)) in index
            .points
            .iter()
            .zip(weights)
            .enumerate()
            .skip(usize::from(!shared))
        {
            let mut list = Vec::new();
            for part in [
                &point.q,
                &point.v,
                &point.a,
                &point.s,
                &point.rate,
                &point.u,
            ] {
                list.extend(part);
            }
            list.extend(0..self.parameters);
            list.push(index.duration);
            let name = format!("{}, point {n}", spec.name);
            self.push(
                Block::new(name, list, spec.rows.clone()),
                Role::Point { phase, weight },
            );
        }
    }

    fn add_defects(&mut self, phase: usize) {
        let spec = self.phases[phase].clone();
        let index = self.index[phase].clone();
        for (interval, points) in interval_points(&index, &self.scheme)
            .into_iter()
            .enumerate()
        {
            let (start, nodes, fresh) = (&points.0, &points.1, points.2);
            for (c, coordinate) in spec.coordinates.iter().enumerate() {
                let mut list = vec![start.q[c], start.v[c]];
                list.extend(nodes.iter().map(|p| p.a[c]));
                for p in &nodes[fresh..] {
                    list.extend([p.q[c], p.v[c]]);
                }
                list.push(index.duration);
                let rows = nodes[fresh..]
                    .iter()
                    .flat_map(|_| {
                        [
                            Row::equal(coordinate.position.scale),
                            Row::equal(coordinate.velocity.scale),
                        ]
                    })
                    .collect();
                let name = format!(
                    "{}, interval {interval}, {}",
                    spec.name, coordinate.position.name
                );
                self.push(Block::new(name, list, rows), Role::Coordinate);
            }
            for (c, state) in spec.states.iter().enumerate() {
                let mut list = vec![start.s[c]];
                list.extend(nodes.iter().map(|p| p.rate[c]));
                list.extend(nodes[fresh..].iter().map(|p| p.s[c]));
                list.push(index.duration);
                let rows = nodes[fresh..]
                    .iter()
                    .map(|_| Row::equal(state.value.scale))
                    .collect();
                let name = format!("{}, interval {interval}, {}", spec.name, state.value.name);
                self.push(Block::new(name, list, rows), Role::State);
            }
        }
    }

    fn add_linkages(&mut self) {
        for (k, linkage) in self.problem.linkages().into_iter().enumerate() {
            let mut list = Vec::new();
            let mut durations = Vec::new();
            for end in &linkage.ends {
                let (phase, point) = self.end_point(*end);
                list.extend(point.q.iter().chain(&point.v).chain(&point.s));
                durations.push(self.index[phase].duration);
            }
            durations.sort_unstable();
            durations.dedup();
            list.extend(durations);
            list.extend(0..self.parameters);
            self.push(
                Block::new(linkage.name, list, linkage.rows),
                Role::Linkage(k),
            );
            self.ends.push(linkage.ends);
        }
    }

    fn end_point(&self, end: End) -> (usize, &PointIndex) {
        let (phase, place) = match end {
            End::Start(phase) => (phase, 0),
            End::Finish(phase) => (phase, self.index[phase].points.len() - 1),
        };
        (phase, &self.index[phase].points[place])
    }

    /// A start from guesses: `guess(phase, share)` at `share ∈ [0, 1]` of the phase.
    pub fn start(
        &self,
        parameters: &[f64],
        durations_s: &[f64],
        guess: impl Fn(usize, f64) -> Guess,
    ) -> Vec<f64> {
        let mut x = vec![0.0; self.variables.len()];
        x[..self.parameters].copy_from_slice(parameters);
        for (phase, index) in self.index.iter().enumerate() {
            x[index.duration] = durations_s[phase];
            for (point, share) in index.points.iter().zip(self.shares(phase)) {
                let at = guess(phase, share);
                let parts = [
                    (&point.q, &at.q),
                    (&point.v, &at.v),
                    (&point.a, &at.a),
                    (&point.s, &at.s),
                    (&point.rate, &at.rate),
                    (&point.u, &at.u),
                ];
                for (places, values) in parts {
                    for (&place, &value) in places.iter().zip(values) {
                        x[place] = value;
                    }
                }
            }
        }
        x
    }

    /// Share of the phase's duration at which each of its points lies.
    pub(crate) fn shares(&self, phase: usize) -> Vec<f64> {
        let intervals = self.phases[phase].intervals;
        let mut shares = vec![0.0];
        for interval in 0..intervals {
            for &c in self.scheme.nodes.iter().filter(|&&c| c > 0.0) {
                shares.push((interval as f64 + c) / intervals as f64);
            }
        }
        shares
    }

    /// The trajectories of all phases at a point of the programme.
    pub fn trajectories(&self, x: &[f64]) -> Vec<PhaseTrajectory> {
        (0..self.phases.len())
            .map(|phase| PhaseTrajectory::new(self, phase, x))
            .collect()
    }

    /// The parameters at a point of the programme.
    pub fn parameters<'x>(&self, x: &'x [f64]) -> &'x [f64] {
        &x[..self.parameters]
    }

    fn evaluate_point<D: Scalar>(
        &self,
        phase: usize,
        weight: f64,
        x: &[D],
        cost: &mut D,
        rows: &mut [D],
    ) {
        let spec = &self.phases[phase];
        let mut rest = x;
        let mut take = |count: usize| {
            let (head, tail) = rest.split_at(count);
            rest = tail;
            head
        };
        let (nq, ns) = (spec.coordinates.len(), spec.states.len());
        let at = Point {
            q: take(nq),
            v: take(nq),
            a: take(nq),
            s: take(ns),
            rate: take(ns),
            u: take(spec.controls.len()),
            p: take(self.parameters),
        };
        let duration = take(1)[0];
        let mut running = D::zero();
        self.problem.point(
            phase,
            &at,
            PointRows {
                cost: &mut running,
                rows,
            },
        );
        *cost = running * duration * weight;
    }

    fn evaluate_link<D: Scalar>(&self, linkage: usize, x: &[D], cost: &mut D, rows: &mut [D]) {
        let mut durations: Vec<usize> = Vec::new();
        let mut rest = x;
        let mut parts = Vec::new();
        for end in &self.ends[linkage] {
            let (phase, point) = self.end_point(*end);
            let (q, tail) = rest.split_at(point.q.len());
            let (v, tail) = tail.split_at(point.v.len());
            let (s, tail) = tail.split_at(point.s.len());
            rest = tail;
            parts.push((phase, q, v, s));
            durations.push(phase);
        }
        durations.sort_unstable();
        durations.dedup();
        let ends: Vec<EndPoint<'_, D>> = parts
            .into_iter()
            .map(|(phase, q, v, s)| {
                let place = durations.partition_point(|&p| p < phase);
                EndPoint {
                    q,
                    v,
                    s,
                    duration: rest[place],
                }
            })
            .collect();
        self.problem
            .link(linkage, &ends, &rest[durations.len()..], cost, rows);
    }

    /// Defects of a first- or second-order quantity; see the head of this file.
    fn evaluate_defects<D: Scalar>(&self, order: usize, x: &[D], intervals: f64, rows: &mut [D]) {
        let scheme = &self.scheme;
        let k = scheme.nodes.len();
        let fresh = usize::from(scheme.starts_at_node());
        let h = x[x.len() - 1] / intervals;
        let slopes = &x[order..order + k];
        let values = &x[order + k..];
        let sum = |row: &[f64]| {
            let mut total = D::zero();
            for (a, slope) in row.iter().zip(slopes) {
                total += *slope * *a;
            }
            total
        };
        for i in fresh..k {
            let n = i - fresh;
            if order == 1 {
                rows[n] = values[n] - x[0] - h * sum(&scheme.first[i]);
            } else {
                let (q0, v0) = (x[0], x[1]);
                rows[2 * n] =
                    values[2 * n] - q0 - h * v0 * scheme.nodes[i] - h * h * sum(&scheme.second[i]);
                rows[2 * n + 1] = values[2 * n + 1] - v0 - h * sum(&scheme.first[i]);
            }
        }
    }

    fn phase_of_block(&self, block: usize) -> usize {
        let duration = self.blocks[block].variables.last().copied().unwrap_or(0);
        self.index
            .partition_point(|phase| phase.duration < duration)
    }
}

impl<P: OptimalControl> Programme for Transcription<'_, P> {
    fn variables(&self) -> Vec<Variable> {
        self.variables.clone()
    }

    fn blocks(&self) -> Vec<Block> {
        self.blocks.clone()
    }

    fn cost_scale(&self) -> f64 {
        self.problem.cost_scale()
    }

    fn evaluate<D: Scalar>(&self, block: usize, x: &[D], cost: &mut D, rows: &mut [D]) {
        match self.roles[block] {
            Role::Point { phase, weight } => self.evaluate_point(phase, weight, x, cost, rows),
            Role::Linkage(k) => self.evaluate_link(k, x, cost, rows),
            Role::Coordinate | Role::State => {
                let order = if matches!(self.roles[block], Role::Coordinate) {
                    2
                } else {
                    1
                };
                let intervals = self.phases[self.phase_of_block(block)].intervals as f64;
                self.evaluate_defects(order, x, intervals, rows);
            }
        }
    }
}

/// For every interval: its start point, its nodes, and the first node that is not the start.
pub(crate) fn interval_points(
    index: &PhaseIndex,
    scheme: &Scheme,
) -> Vec<(PointIndex, Vec<PointIndex>, usize)> {
    let k = scheme.nodes.len();
    let fresh = usize::from(scheme.starts_at_node());
    let step = k - fresh;
    let intervals = (index.points.len() - 1) / step;
    (0..intervals)
        .map(|interval| {
            let first = interval * step;
            let nodes = index.points[first + 1 - fresh..=first + step].to_vec();
            (index.points[first].clone(), nodes, fresh)
        })
        .collect()
}

fn lay_out_phase(phase: &Phase, scheme: &Scheme, variables: &mut Vec<Variable>) -> PhaseIndex {
    let mut push = |v: &Variable, label: &str| {
        variables.push(Variable {
            name: format!("{}, {label}, {}", phase.name, v.name),
            ..v.clone()
        });
        variables.len() - 1
    };
    let duration = push(&phase.duration, "duration");
    let fresh = scheme.nodes.len() - usize::from(scheme.starts_at_node());
    let points = (0..=phase.intervals * fresh)
        .map(|n| {
            let label = format!("point {n}");
            let dynamic = n > 0 || scheme.starts_at_node();
            let mut point = PointIndex {
                q: phase
                    .coordinates
                    .iter()
                    .map(|c| push(&c.position, &label))
                    .collect(),
                v: phase
                    .coordinates
                    .iter()
                    .map(|c| push(&c.velocity, &label))
                    .collect(),
                s: phase
                    .states
                    .iter()
                    .map(|s| push(&s.value, &label))
                    .collect(),
                ..PointIndex::default()
            };
            if dynamic {
                point.a = phase
                    .coordinates
                    .iter()
                    .map(|c| push(&c.acceleration, &label))
                    .collect();
                point.rate = phase.states.iter().map(|s| push(&s.rate, &label)).collect();
                point.u = phase.controls.iter().map(|u| push(u, &label)).collect();
            }
            point
        })
        .collect();
    PhaseIndex { duration, points }
}

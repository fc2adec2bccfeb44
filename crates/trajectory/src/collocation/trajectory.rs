//! Trajectories read back from a solution, as the scheme's polynomials.

use super::problem::OptimalControl;
use super::scheme::Scheme;
use super::transcription::{PointIndex, Transcription, interval_points};

/// Everything at one instant.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Knot {
    /// Time since the start of the phase in s.
    pub time_s: f64,
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

/// One phase of a solution.
#[derive(Clone, Debug, PartialEq)]
pub struct PhaseTrajectory {
    /// Duration in s.
    pub duration_s: f64,
    /// The collocation points (with Radau the start has no accelerations, rates and controls).
    pub knots: Vec<Knot>,
    scheme: Scheme,
    intervals: Vec<(Knot, Vec<Knot>)>,
}

impl PhaseTrajectory {
    pub(crate) fn new<P: OptimalControl>(
        transcription: &Transcription<'_, P>,
        phase: usize,
        x: &[f64],
    ) -> Self {
        let index = &transcription.index[phase];
        let duration_s = x[index.duration];
        let shares = transcription.shares(phase);
        let knot = |point: &PointIndex, share: f64| {
            let pick = |places: &[usize]| places.iter().map(|&k| x[k]).collect::<Vec<f64>>();
            Knot {
                time_s: share * duration_s,
                q: pick(&point.q),
                v: pick(&point.v),
                a: pick(&point.a),
                s: pick(&point.s),
                rate: pick(&point.rate),
                u: pick(&point.u),
            }
        };
        let knots = index
            .points
            .iter()
            .zip(&shares)
            .map(|(point, &share)| knot(point, share))
            .collect();
        let count = transcription.phases[phase].intervals as f64;
        let intervals = interval_points(index, &transcription.scheme)
            .iter()
            .enumerate()
            .map(|(k, (start, nodes, _))| {
                let at = |c: f64| (k as f64 + c) / count;
                let nodes = nodes
                    .iter()
                    .zip(&transcription.scheme.nodes)
                    .map(|(p, &c)| knot(p, at(c)))
                    .collect();
                (knot(start, at(0.0)), nodes)
            })
            .collect();
        Self {
            duration_s,
            knots,
            scheme: transcription.scheme.clone(),
            intervals,
        }
    }

    /// The polynomials at a time of the phase (clamped to it): accelerations,
    /// rates and controls interpolated, velocities, positions and states integrated.
    pub fn at(&self, time_s: f64) -> Knot {
        let count = self.intervals.len();
        let h = self.duration_s / count as f64;
        let time_s = time_s.clamp(0.0, self.duration_s);
        let interval = ((time_s / h) as usize).min(count - 1);
        let tau = (time_s - interval as f64 * h) / h;
        let (start, nodes) = &self.intervals[interval];
        let [l, once, twice] = self.scheme.basis_at(tau);
        let combine = |weights: &[f64], pick: fn(&Knot) -> &Vec<f64>, k: usize| -> f64 {
            weights
                .iter()
                .zip(nodes)
                .map(|(w, node)| w * pick(node)[k])
                .sum()
        };
        let mut knot = Knot {
            time_s,
            ..Knot::default()
        };
        for k in 0..start.q.len() {
            knot.a.push(combine(&l, |n| &n.a, k));
            knot.v.push(start.v[k] + h * combine(&once, |n| &n.a, k));
            knot.q
                .push(start.q[k] + h * tau * start.v[k] + h * h * combine(&twice, |n| &n.a, k));
        }
        for k in 0..start.s.len() {
            knot.rate.push(combine(&l, |n| &n.rate, k));
            knot.s.push(start.s[k] + h * combine(&once, |n| &n.rate, k));
        }
        let controls = nodes.first().map_or(0, |n| n.u.len());
        for k in 0..controls {
            knot.u.push(combine(&l, |n| &n.u, k));
        }
        knot
    }
}

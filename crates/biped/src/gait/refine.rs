//! A stride on another mesh: the collocation's own polynomials, read at the new points.
//!
//! With τ in (0, 1] the part of an interval that has passed, rates w and accelerations b of the interval are the lines
//! through their two stages, and by the method's definition
//!
//! q(τ) = q_0 + r ∫ w,   w(τ) = w_0 + r ∫ b   from 0 to τ,
//!
//! r the interval's length over the mean one of its phase. Each is the method's own, but between the points q' is the line and w the parabola, so the stride read on a finer mesh
//! misses the defects there by as much as the coarse one was wrong: a start, not a solution.

use super::layout::{Layout, Place};
use super::{Mesh, PHASES, Problem};
use crate::kinematics::{COORDINATES, JOINTS};

/// Line through the values at the two stages.
fn line(first: f64, second: f64, part: f64) -> f64 {
    let [c1, c2] = Problem::RADAU_C;
    first + (part - c1) / (c2 - c1) * (second - first)
}

/// Its integral from 0 to `part`.
fn integral(first: f64, second: f64, part: f64) -> f64 {
    let [c1, c2] = Problem::RADAU_C;
    let slope = (second - first) / (c2 - c1);
    (first - c1 * slope) * part + 0.5 * slope * part * part
}

/// The variables `x` of a stride of `problem`, read on another mesh.
///
/// Torques and the forces of a rigid stance are read from the line through their stages, like accelerations; they may
/// leave their limits by what the line does outside its stages, which a start may do.
pub fn on_mesh(problem: &Problem, x: &[f64], mesh: Mesh) -> Vec<f64> {
    let old = Layout::new(problem);
    let new = Layout::new(&Problem { mesh, ..*problem });
    // What stands before and behind the points does not know the mesh, but for the scale of w = h v.
    let mut y = x[..old.points().start].to_vec();
    y.resize(new.points().end, 0.0);
    y.extend_from_slice(&x[old.points().end..]);
    for phase in 0..PHASES {
        let intervals = problem.mesh.intervals(phase);
        let ratio = intervals as f64 / mesh.intervals(phase) as f64;
        let start = new.phase_start_w(phase);
        y[start..start + COORDINATES]
            .iter_mut()
            .for_each(|w| *w *= ratio);
        for place in new.places().into_iter().filter(|p| p.phase == phase) {
            let (interval, part) = problem.mesh.locate(phase, mesh.passed(place));
            let old = Old {
                layout: &old,
                x,
                phase,
                interval,
                part,
                relative: problem.mesh.relative_length(phase, interval),
            };
            old.read(&new, place, ratio, &mut y);
        }
    }
    y
}

/// A moment of the old stride.
struct Old<'a> {
    layout: &'a Layout,
    x: &'a [f64],
    phase: usize,
    interval: usize,
    part: f64,
    /// Length of the interval over the mean one.
    relative: f64,
}

impl Old<'_> {
    /// Values of a quantity at the two stages.
    fn stages(&self, at: impl Fn(Place) -> usize, k: usize) -> [f64; 2] {
        [0, 1].map(|stage| {
            let place = Place {
                phase: self.phase,
                interval: self.interval,
                stage,
            };
            self.x[at(place) + k]
        })
    }

    /// Writes this moment to a place of the new stride, rates and accelerations in its intervals.
    fn read(&self, new: &Layout, place: Place, ratio: f64, y: &mut [f64]) {
        let (old, part, r) = (self.layout, self.part, self.relative);
        let q0 = old.interval_start_q(self.phase, self.interval);
        let w0 = old.interval_start_w(self.phase, self.interval);
        for k in 0..COORDINATES {
            let [w1, w2] = self.stages(|p| old.w(p), k);
            let [b1, b2] = self.stages(|p| old.b(p), k);
            y[new.q(place) + k] = self.x[q0 + k] + r * integral(w1, w2, part);
            y[new.w(place) + k] = ratio * (self.x[w0 + k] + r * integral(b1, b2, part));
            y[new.b(place) + k] = ratio * ratio * line(b1, b2, part);
        }
        for k in 0..JOINTS {
            let [t1, t2] = self.stages(|p| old.torques(p), k);
            y[new.torques(place) + k] = line(t1, t2, part);
        }
        if let Some(force) = new.force(place) {
            for k in 0..2 {
                let [f1, f2] = self.stages(|p| old.torques(p) + JOINTS, k);
                y[force + k] = line(f1, f2, part);
            }
        }
    }
}

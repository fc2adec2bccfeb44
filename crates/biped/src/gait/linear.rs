//! The linear rows of a stride: defects, periodicity, joint rates, friction cones.

use super::layout::{Layout, Place, STAGES};
use super::variables::{IntervalScale, scale};
use super::{Goal, PHASES, Problem};
use crate::kinematics::{COORDINATES, JOINTS};
use trajectory::{LinearRow, Row};

fn row(name: impl Into<String>, terms: Vec<(usize, f64)>, row: Row) -> LinearRow {
    LinearRow {
        name: name.into(),
        terms,
        row,
    }
}

/// All linear rows.
pub(super) fn rows(problem: &Problem, layout: &Layout) -> Vec<LinearRow> {
    let mut rows = Vec::new();
    for place in layout.places() {
        let interval = IntervalScale::of(problem.mesh, place.phase);
        let relative = problem.mesh.relative_length(place.phase, place.interval);
        defects(layout, place, interval, relative, &mut rows);
        joint_rates(problem, layout, place, &mut rows);
        if let Some(force) = layout.force(place) {
            cone(problem, force, scale::FORCE_N, &mut rows);
        }
    }
    for flight in [1, 3] {
        if let Some(impulse) = layout.impulse(flight) {
            cone(problem, impulse, scale::IMPULSE_N_S, &mut rows);
        }
    }
    // T = sum of the phases.
    let mut period: Vec<(usize, f64)> = (0..PHASES).map(|p| (layout.duration(p), 1.0)).collect();
    period.push((layout.period(), -1.0));
    rows.push(row("period", period, Row::equal(scale::PHASE_S)));
    // Periodic in everything but x.
    let (end, start) = (
        layout.q(layout.last(PHASES - 1)),
        layout.interval_start_q(0, 0),
    );
    for k in 1..COORDINATES {
        let terms = vec![(end + k, 1.0), (start + k, -1.0)];
        rows.push(row(
            format!("periodic q{k}"),
            terms,
            Row::equal(scale::LENGTH_M),
        ));
    }
    if let Goal::Acceleration { start_m_s, .. } = problem.goal {
        // w = h v with h = T_0/N_0.
        let factor = start_m_s / problem.mesh.intervals(0) as f64;
        let terms = vec![
            (layout.phase_start_w(0), 1.0),
            (layout.duration(0), -factor),
        ];
        let scale = IntervalScale::of(problem.mesh, 0).w();
        rows.push(row("speed at the start", terms, Row::equal(scale)));
    }
    rows
}

/// q_i - q_0 - r sum_j A_ij w_j = 0 and w_i - w_0 - r sum_j A_ij b_j = 0, r the interval's relative length.
fn defects(
    layout: &Layout,
    place: Place,
    interval: IntervalScale,
    relative: f64,
    rows: &mut Vec<LinearRow>,
) {
    let stages = (0..STAGES).map(|stage| Place { stage, ..place });
    for k in 0..COORDINATES {
        let mut position = vec![
            (layout.q(place) + k, 1.0),
            (
                layout.interval_start_q(place.phase, place.interval) + k,
                -1.0,
            ),
        ];
        let mut velocity = vec![
            (layout.w(place) + k, 1.0),
            (
                layout.interval_start_w(place.phase, place.interval) + k,
                -1.0,
            ),
        ];
        for (other, weight) in stages.clone().zip(Problem::RADAU_A[place.stage]) {
            position.push((layout.w(other) + k, -relative * weight));
            velocity.push((layout.b(other) + k, -relative * weight));
        }
        let name = |what: &str| {
            format!(
                "defect of {what}{k} at {}.{}.{}",
                place.phase, place.interval, place.stage
            )
        };
        rows.push(row(name("q"), position, Row::equal(interval.w())));
        rows.push(row(name("w"), velocity, Row::equal(interval.b())));
    }
}

/// |w| <= h times the largest joint rate.
fn joint_rates(problem: &Problem, layout: &Layout, place: Place, rows: &mut Vec<LinearRow>) {
    let scale = IntervalScale::of(problem.mesh, place.phase).w();
    let limit = problem.limits.joint_rate_rad_s / problem.mesh.intervals(place.phase) as f64;
    for k in 0..JOINTS {
        let w = layout.w(place) + 3 + k;
        let duration = layout.duration(place.phase);
        let name = format!(
            "rate of joint {k} at {}.{}.{}",
            place.phase, place.interval, place.stage
        );
        rows.push(row(
            name.clone(),
            vec![(w, 1.0), (duration, -limit)],
            Row::at_most(scale),
        ));
        rows.push(row(
            name,
            vec![(w, 1.0), (duration, limit)],
            Row::at_least(scale),
        ));
    }
}

/// -mu_reverse F_y <= F_x <= mu_forward F_y.
fn cone(problem: &Problem, force: usize, scale: f64, rows: &mut Vec<LinearRow>) {
    let (x, y) = (force, force + 1);
    let forward = vec![(x, 1.0), (y, -problem.brush.forward)];
    let reverse = vec![(x, 1.0), (y, problem.brush.reverse)];
    rows.push(row("friction forward", forward, Row::at_most(scale)));
    rows.push(row("friction reverse", reverse, Row::at_least(scale)));
}

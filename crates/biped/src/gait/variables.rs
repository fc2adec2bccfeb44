//! Bounds and physical scales of the variables of a stride.

use super::layout::Layout;
use super::{Mesh, PHASES, Problem, STANDING};
use crate::kinematics::{COORDINATES, JOINTS};
use trajectory::Variable;

/// Physical scales, fixed.
pub(super) mod scale {
    pub(in crate::gait) const LENGTH_M: f64 = 1.0;
    pub(in crate::gait) const TORQUE_N_M: f64 = 35.0;
    pub(in crate::gait) const FORCE_N: f64 = 200.0;
    pub(in crate::gait) const IMPULSE_N_S: f64 = 5.0;
    pub(in crate::gait) const PHASE_S: f64 = 0.05;
    pub(in crate::gait) const SHARE: f64 = 0.25;
    pub(in crate::gait) const SPEED_M_S: f64 = 5.0;
    pub(in crate::gait) const ACCELERATION_M_S2: f64 = 5.0;
    pub(in crate::gait) const HEIGHT_M: f64 = 0.1;
}

/// Scales of what carries the length of an interval, by powers of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct IntervalScale(f64);

impl IntervalScale {
    /// Of a phase: relative to the default mesh, for which the constants below hold.
    pub(super) fn of(mesh: Mesh, phase: usize) -> Self {
        Self(Mesh::default().intervals(phase) as f64 / mesh.intervals(phase) as f64)
    }

    /// Length h, s.
    pub(super) fn length_s(self) -> f64 {
        0.005 * self.0
    }

    /// w = h v, m and rad: speeds of some 10 m/s and rad/s.
    pub(super) fn w(self) -> f64 {
        0.05 * self.0
    }

    /// b = h^2 a, m and rad: 4,000 rad/s^2, what a strike of some 1,200 N does to a shank of 0.3 kg.
    pub(super) fn b(self) -> f64 {
        0.1 * self.0 * self.0
    }

    /// Equations of motion times h^2, kg m: some hundreds of grammes times b.
    pub(super) fn motion(self) -> f64 {
        0.02 * self.0 * self.0
    }
}

/// All variables in the order of the layout.
pub(super) fn variables(problem: &Problem, layout: &Layout) -> Vec<Variable> {
    let (limits, biped) = (&problem.limits, &problem.biped);
    let mut list = vec![Variable::free("", 1.0); layout.count()];
    let mut set = |at: usize, name: String, range: [f64; 2], scale: f64| {
        list[at] = Variable::new(name, range[0], range[1], scale);
    };
    let free = [f64::NEG_INFINITY, f64::INFINITY];
    let pushing = [0.0, f64::INFINITY];

    for phase in 0..PHASES {
        let durations = if STANDING[phase].is_some() {
            [limits.stance_s, limits.longest_stance_s]
        } else {
            [limits.flight_s, limits.longest_flight_s]
        };
        set(
            layout.duration(phase),
            format!("duration {phase}"),
            durations,
            scale::PHASE_S,
        );
        set(
            layout.share(phase),
            format!("share {phase}"),
            free,
            scale::SHARE,
        );
        let w = IntervalScale::of(problem.mesh, phase).w();
        for k in 0..COORDINATES {
            set(
                layout.phase_start_w(phase) + k,
                format!("start {phase} w{k}"),
                free,
                w,
            );
        }
    }
    set(
        layout.period(),
        "period".into(),
        free,
        PHASES as f64 * scale::PHASE_S,
    );
    set(layout.speed(), "mean speed".into(), free, scale::SPEED_M_S);
    if let Some(acceleration) = layout.acceleration() {
        set(
            acceleration,
            "mean acceleration".into(),
            free,
            scale::ACCELERATION_M_S2,
        );
    }

    // The stride starts at x = 0. Its other coordinates are those of its end, which
    // carries their limits: stating them twice would make active limits dependent.
    let start = layout.interval_start_q(0, 0);
    for k in 0..COORDINATES {
        let range = if k == 0 { [0.0, 0.0] } else { free };
        set(start + k, format!("start q{k}"), range, scale::LENGTH_M);
    }

    let pitch = [-limits.pitch_rad, limits.pitch_rad];
    let (hip, knee) = (limits.hip_rad, limits.knee_rad);
    let ranges = [free, free, pitch, hip, knee, hip, knee];
    let torques = [biped.hip_torque_n_m, biped.knee_torque_n_m];
    for place in layout.places() {
        let name = |what: &str, k: usize| {
            format!(
                "{what}{k} at {}.{}.{}",
                place.phase, place.interval, place.stage
            )
        };
        let interval = IntervalScale::of(problem.mesh, place.phase);
        for (k, range) in ranges.into_iter().enumerate() {
            set(layout.q(place) + k, name("q", k), range, scale::LENGTH_M);
            set(layout.w(place) + k, name("w", k), free, interval.w());
            set(layout.b(place) + k, name("b", k), free, interval.b());
        }
        for k in 0..JOINTS {
            let limit = torques[k % 2];
            set(
                layout.torques(place) + k,
                name("torque ", k),
                [-limit, limit],
                scale::TORQUE_N_M,
            );
        }
        if let Some(force) = layout.force(place) {
            set(force, name("force x", 0), free, scale::FORCE_N);
            set(force + 1, name("force y", 1), pushing, scale::FORCE_N);
        }
    }
    for flight in [1, 3] {
        if let Some(impulse) = layout.impulse(flight) {
            set(
                impulse,
                format!("impulse x after {flight}"),
                free,
                scale::IMPULSE_N_S,
            );
            set(
                impulse + 1,
                format!("impulse y after {flight}"),
                pushing,
                scale::IMPULSE_N_S,
            );
        }
    }
    list
}

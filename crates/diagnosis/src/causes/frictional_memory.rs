//! Friction follows speed with a memory: the Stribeck curve is read at a speed u that lags behind v, in time,
//! tau u' = v - u, or in distance slid, D du/ds = v - u. u starts at v.

use friction::{LawKind, ParameterSpec, Scalar};
use rig::signal::lag_step;
use rig::{Cause, Experiment, Place, Reach, Station};

use super::grids;

const DESCRIPTION: &str = "Friction follows the speed with a memory.";

fn has_curve(law: LawKind) -> bool {
    !matches!(law, LawKind::CoulombViscous | LawKind::Dahl)
}

/// Memory of a time constant.
#[derive(Clone, Copy, Debug)]
pub struct MemoryInTime;

const IN_TIME: &[ParameterSpec] =
    &[ParameterSpec::new("time_constant_s", "s", "memory", 0.0, 1e9, 0.05).with_null(0.0)];

impl Cause for MemoryInTime {
    fn id(&self) -> &'static str {
        "frictional-memory"
    }

    fn variant(&self) -> Option<&'static str> {
        Some("time")
    }

    fn station(&self) -> Station {
        Station::Law
    }

    fn reach(&self) -> Reach {
        Reach::CurveSpeed
    }

    fn describe(&self) -> &'static str {
        DESCRIPTION
    }

    fn parameters(&self) -> &'static [ParameterSpec] {
        IN_TIME
    }

    fn parameters_for(&self, experiment: &Experiment) -> Vec<ParameterSpec> {
        let run = grids::duration_s(experiment);
        vec![grids::bounded(&IN_TIME[0], 0.0, 3.0 * run, 0.01 * run)]
    }

    fn applies_to(&self, law: LawKind) -> bool {
        has_curve(law)
    }

    fn curve_speed<D: Scalar>(&self, p: &[D], at: Place<'_>, speed: &mut [D]) {
        rig::signal::lag(&at.run.time_s, speed, p[0]);
    }
}

/// Memory of a distance.
#[derive(Clone, Copy, Debug)]
pub struct MemoryInDistance;

const IN_DISTANCE: &[ParameterSpec] =
    &[ParameterSpec::new("distance_m", "m", "memory", 0.0, 1e9, 1e-3).with_null(0.0)];

impl Cause for MemoryInDistance {
    fn id(&self) -> &'static str {
        "frictional-memory"
    }

    fn variant(&self) -> Option<&'static str> {
        Some("distance")
    }

    fn station(&self) -> Station {
        Station::Law
    }

    fn reach(&self) -> Reach {
        Reach::CurveSpeed
    }

    fn describe(&self) -> &'static str {
        DESCRIPTION
    }

    fn parameters(&self) -> &'static [ParameterSpec] {
        IN_DISTANCE
    }

    fn parameters_for(&self, experiment: &Experiment) -> Vec<ParameterSpec> {
        let slid = grids::slid_m(experiment).0;
        vec![grids::bounded(&IN_DISTANCE[0], 0.0, 3.0 * slid, 0.01 * slid)]
    }

    fn applies_to(&self, law: LawKind) -> bool {
        has_curve(law)
    }

    fn curve_speed<D: Scalar>(&self, p: &[D], at: Place<'_>, speed: &mut [D]) {
        let Some(&first) = speed.first() else { return };
        let slid = &at.run.distance_m;
        let (mut before, mut remembered) = (first, first);
        for i in 1..speed.len() {
            let now = speed[i];
            remembered = lag_step(before, now, remembered, slid[i] - slid[i - 1], p[0]);
            before = now;
            speed[i] = remembered;
        }
    }
}

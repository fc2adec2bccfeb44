//! Friction follows speed with a memory: the Stribeck curve is read at a speed u that lags behind v, in time,
//! tau u' = v - u, or in distance slid, D du/ds = v - u. u starts at v. Or it is the magnitude |v| that is remembered: through a
//! reversal the curve is then read at low speeds, not at zero. Or the viscous part follows u as well, sigma2 u in the place of sigma2 v:
//! friction as a whole then comes after the speed; of its magnitude, sigma2 u sgn(v).

use friction::{LawKind, ParameterSpec, Scalar};
use rig::signal::lag_step;
use rig::{Cause, Experiment, Follows, Place, Reach, Requirement, Station};

use super::{grids, marker};

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
        lag_along(&at.run.distance_m, speed, p[0]);
    }
}

/// A lag in the distance slid.
fn lag_along<D: Scalar>(slid_m: &[f64], speed: &mut [D], distance: D) {
    let Some(&first) = speed.first() else { return };
    let (mut before, mut remembered) = (first, first);
    for i in 1..speed.len() {
        let now = speed[i];
        remembered = lag_step(before, now, remembered, slid_m[i] - slid_m[i - 1], distance);
        before = now;
        speed[i] = remembered;
    }
}

/// Beside the memory, what tells that of the magnitude in a file.
const OF_MAGNITUDE: &str = "of_the_magnitude";

fn magnitudes<D: Scalar>(speed: &mut [D]) {
    speed.iter_mut().for_each(|u| *u = u.magnitude());
}

/// Memory of the magnitude of the speed, of a time constant.
#[derive(Clone, Copy, Debug)]
pub struct MagnitudeInTime;

impl Cause for MagnitudeInTime {
    marker::marked_form!(MemoryInTime, "magnitude, time", OF_MAGNITUDE);

    fn requirements(&self) -> &'static [Requirement] {
        &[Requirement::Reversals]
    }

    fn curve_speed<D: Scalar>(&self, p: &[D], at: Place<'_>, speed: &mut [D]) {
        magnitudes(speed);
        rig::signal::lag(&at.run.time_s, speed, p[0]);
    }
}

/// Memory of the magnitude of the speed, of a distance.
#[derive(Clone, Copy, Debug)]
pub struct MagnitudeInDistance;

impl Cause for MagnitudeInDistance {
    marker::marked_form!(MemoryInDistance, "magnitude, distance", OF_MAGNITUDE);

    fn requirements(&self) -> &'static [Requirement] {
        &[Requirement::Reversals]
    }

    fn curve_speed<D: Scalar>(&self, p: &[D], at: Place<'_>, speed: &mut [D]) {
        magnitudes(speed);
        lag_along(&at.run.distance_m, speed, p[0]);
    }
}

/// Memories from which fits of the forms begin that are asked in another cause's place: friction that comes after the speed as a whole looks
/// like a lag or a delay of the force at first.
fn times(experiment: &Experiment) -> Vec<Vec<f64>> {
    grids::delays_s(experiment).into_iter().map(|time| vec![time]).collect()
}

fn distances(experiment: &Experiment) -> Vec<Vec<f64>> {
    let speed = experiment.scales.speed_m_s;
    grids::delays_s(experiment).into_iter().map(|time| vec![speed * time]).collect()
}

/// Beside the memory, what tells that of the viscous part in a file.
const OF_THE_VISCOUS_PART: &str = "of_the_viscous_part";

/// What the forms share in which the viscous part remembers too: they are asked in another cause's place, and the curve is read where `hook`
/// reads it.
macro_rules! viscous_form {
    ($plain:ident, $hook:ident, $variant:literal, $marker:ident, $starts:ident, $follows:ident) => {
        marker::marked_form!($plain, $variant, $marker);

        fn refines(&self) -> bool {
            true
        }

        fn starts(&self, experiment: &Experiment) -> Vec<Vec<f64>> {
            $starts(experiment)
        }

        fn requirements(&self) -> &'static [Requirement] {
            $hook.requirements()
        }

        fn curve_speed<D: Scalar>(&self, p: &[D], at: Place<'_>, speed: &mut [D]) {
            $hook.curve_speed(p, at, speed);
        }

        fn viscous_part(&self) -> Follows {
            Follows::$follows
        }
    };
}

/// Memory of the curve and of the viscous part, of a time constant.
#[derive(Clone, Copy, Debug)]
pub struct ViscousMemoryInTime;

impl Cause for ViscousMemoryInTime {
    viscous_form!(MemoryInTime, MemoryInTime, "viscous too, time", OF_THE_VISCOUS_PART, times, TheCurve);
}

/// Memory of the curve and of the viscous part, of a distance.
#[derive(Clone, Copy, Debug)]
pub struct ViscousMemoryInDistance;

impl Cause for ViscousMemoryInDistance {
    viscous_form!(MemoryInDistance, MemoryInDistance, "viscous too, distance", OF_THE_VISCOUS_PART, distances, TheCurve);
}

/// Beside the memory, what tells that of the magnitude and of the viscous part in a file.
const OF_BOTH: &str = "of_the_magnitude_and_the_viscous_part";

/// Memory of the magnitude of the speed, of the curve and of the viscous part, of a time constant.
#[derive(Clone, Copy, Debug)]
pub struct WholeMagnitudeInTime;

impl Cause for WholeMagnitudeInTime {
    viscous_form!(MemoryInTime, MagnitudeInTime, "magnitude, viscous too, time", OF_BOTH, times, ItsSize);
}

/// Memory of the magnitude of the speed, of the curve and of the viscous part, of a distance.
#[derive(Clone, Copy, Debug)]
pub struct WholeMagnitudeInDistance;

impl Cause for WholeMagnitudeInDistance {
    viscous_form!(MemoryInDistance, MagnitudeInDistance, "magnitude, viscous too, distance", OF_BOTH, distances, ItsSize);
}

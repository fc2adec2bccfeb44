//! Play: after every reversal of the stage the specimen stays behind until the gap (m) is crossed. A run starts with the play
//! taken up in the direction of its first motion; or the play stands as the run before left it, so that a run against that one
//! crosses the gap first.

use std::collections::BTreeMap;

use friction::{ParameterSpec, Scalar};
use rig::{Cause, Experiment, Place, Reach, Reported, Requirement, RunMotion, Station};

use super::{grids, marker};

const DESCRIPTION: &str = "Play is crossed after a reversal before force builds.";

/// A run starts with the play taken up.
#[derive(Clone, Copy, Debug)]
pub struct Backlash;

const PARAMETERS: &[ParameterSpec] = &[
    ParameterSpec::new("gap_m", "m", "width of the play", 0.0, 1e9, 1e-4).with_null(0.0),
];

/// Steps from sample to sample: a gap that is crossed between two samples is known no better than one of them.
const STEPS: usize = 8;

impl Cause for Backlash {
    fn id(&self) -> &'static str {
        "backlash"
    }

    fn station(&self) -> Station {
        Station::Coupling
    }

    fn reach(&self) -> Reach {
        Reach::Stage
    }

    fn describe(&self) -> &'static str {
        DESCRIPTION
    }

    fn parameters(&self) -> &'static [ParameterSpec] {
        PARAMETERS
    }

    fn parameters_for(&self, experiment: &Experiment) -> Vec<ParameterSpec> {
        bounds(experiment)
    }

    fn requirements(&self) -> &'static [Requirement] {
        &[Requirement::Reversals]
    }

    fn starts(&self, experiment: &Experiment) -> Vec<Vec<f64>> {
        gaps(experiment)
    }

    fn stepped(&self) -> Option<usize> {
        Some(0)
    }

    fn steps_a_sample(&self, _p: &[f64], run: &RunMotion) -> usize {
        let goes = |way: f64| run.velocity_m_s.iter().any(|v| v * way > 0.0);
        if goes(1.0) && goes(-1.0) { STEPS } else { 1 }
    }

    fn stage<D: Scalar>(&self, p: &[D], at: Place<'_>, velocity: &mut [D]) {
        cross(p[0], &at.run.time_s, 0.0, velocity);
    }
}

/// The play stands as the run before left it.
#[derive(Clone, Copy, Debug)]
pub struct CarriedBacklash;

/// Beside the gap, what tells this form from the other one in a file.
const CARRIED: &str = "carried_between_runs";

impl Cause for CarriedBacklash {
    fn id(&self) -> &'static str {
        "backlash"
    }

    fn variant(&self) -> Option<&'static str> {
        Some("carried from run to run")
    }

    fn station(&self) -> Station {
        Station::Coupling
    }

    fn reach(&self) -> Reach {
        Reach::Stage
    }

    fn describe(&self) -> &'static str {
        DESCRIPTION
    }

    fn parameters(&self) -> &'static [ParameterSpec] {
        PARAMETERS
    }

    fn parameters_for(&self, experiment: &Experiment) -> Vec<ParameterSpec> {
        bounds(experiment)
    }

    fn requirements(&self) -> &'static [Requirement] {
        &[Requirement::Order, Requirement::BothDirections]
    }

    fn starts(&self, experiment: &Experiment) -> Vec<Vec<f64>> {
        gaps(experiment)
    }

    fn stepped(&self) -> Option<usize> {
        Some(0)
    }

    fn steps_a_sample(&self, _p: &[f64], run: &RunMotion) -> usize {
        let goes = |way: f64| run.heading_before * way > 0.0 || run.velocity_m_s.iter().any(|v| v * way > 0.0);
        if goes(1.0) && goes(-1.0) { STEPS } else { 1 }
    }

    fn reported(&self, fitted: &[f64]) -> Vec<Reported> {
        marker::marked(Backlash.reported(fitted), CARRIED)
    }

    fn from_reported(&self, reported: &BTreeMap<String, f64>) -> Result<Vec<f64>, String> {
        marker::demanded(reported, CARRIED)?;
        Backlash.from_reported(reported)
    }

    fn stage<D: Scalar>(&self, p: &[D], at: Place<'_>, velocity: &mut [D]) {
        cross(p[0], &at.run.time_s, at.run.heading_before, velocity);
    }
}

fn bounds(experiment: &Experiment) -> Vec<ParameterSpec> {
    let travel = experiment.scales.travel_m;
    vec![grids::bounded(&PARAMETERS[0], 0.0, 0.9 * travel, 0.01 * travel)]
}

/// The moment at which a gap is crossed makes a sample's force jump, so a fit gets over few of them: a ladder of gaps.
fn gaps(experiment: &Experiment) -> Vec<Vec<f64>> {
    let travel = experiment.scales.travel_m;
    [3e-5, 1e-4, 3e-4, 1e-3, 1e-2].iter().map(|share| vec![share * travel]).collect()
}

/// Takes the crossing of the gap out of a velocity. `heading`: the direction in which the play is taken up before the first
/// sample, 0 for that of the first motion.
fn cross<D: Scalar>(gap: D, time: &[f64], mut heading: f64, velocity: &mut [D]) {
    let n = velocity.len();
    let mut slack = D::constant(0.0);
    for i in 0..n {
        let v = velocity[i];
        if v.value() == 0.0 {
            continue;
        }
        let sign = v.value().signum();
        if heading != 0.0 && sign != heading {
            slack = gap - slack;
        }
        heading = sign;
        // path of this sample's share of the record: the trapezium's weight
        let before = if i > 0 { time[i] - time[i - 1] } else { 0.0 };
        let after = if i + 1 < n { time[i + 1] - time[i] } else { 0.0 };
        let path = v * (sign * 0.5 * (before + after));
        if slack.value() >= path.value() {
            slack -= path;
            velocity[i] = D::constant(0.0);
        } else {
            velocity[i] = v * (-(slack / path) + 1.0);
            slack = D::constant(0.0);
        }
    }
}

//! Play: after every reversal of the stage the specimen stays behind until the gap (m) is crossed. A run starts with the play
//! taken up in the direction of its first motion.

use friction::{ParameterSpec, Scalar};
use rig::{Cause, Experiment, Place, Reach, Requirement, RunMotion, Station};

use super::grids;

/// Play is crossed after a reversal before force builds.
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
        "Play is crossed after a reversal before force builds."
    }

    fn parameters(&self) -> &'static [ParameterSpec] {
        PARAMETERS
    }

    fn parameters_for(&self, experiment: &Experiment) -> Vec<ParameterSpec> {
        let travel = experiment.scales.travel_m;
        vec![grids::bounded(&PARAMETERS[0], 0.0, 0.9 * travel, 0.01 * travel)]
    }

    fn requirements(&self) -> &'static [Requirement] {
        &[Requirement::Reversals]
    }

    /// The moment at which a gap is crossed makes a sample's force jump, so a fit gets over few of them: a ladder of gaps.
    fn starts(&self, experiment: &Experiment) -> Vec<Vec<f64>> {
        let travel = experiment.scales.travel_m;
        [3e-5, 1e-4, 3e-4, 1e-3, 1e-2].iter().map(|share| vec![share * travel]).collect()
    }

    fn stepped(&self) -> Option<usize> {
        Some(0)
    }

    fn steps_a_sample(&self, _p: &[f64], run: &RunMotion) -> usize {
        let goes = |way: f64| run.velocity_m_s.iter().any(|v| v * way > 0.0);
        if goes(1.0) && goes(-1.0) { STEPS } else { 1 }
    }

    fn stage<D: Scalar>(&self, p: &[D], at: Place<'_>, velocity: &mut [D]) {
        let time = &at.run.time_s;
        let n = velocity.len();
        let mut heading = 0.0_f64;
        let mut slack = D::constant(0.0);
        for i in 0..n {
            let v = velocity[i];
            if v.value() == 0.0 {
                continue;
            }
            let sign = v.value().signum();
            if heading != 0.0 && sign != heading {
                slack = p[0] - slack;
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
}

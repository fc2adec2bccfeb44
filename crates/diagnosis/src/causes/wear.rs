//! Running-in or wear: mu (1 + A (1 - exp(-S/d))), S the distance slid since the first run (m), d a distance (m).

use friction::{ParameterSpec, Scalar};
use rig::{Cause, Experiment, Place, Reach, Requirement, Station};

use super::grids;

/// Friction changes with the distance slid since the first run.
#[derive(Clone, Copy, Debug)]
pub struct Wear;

const PARAMETERS: &[ParameterSpec] = &[
    ParameterSpec::new("amplitude", "1", "change after a long distance", -0.95, 20.0, 0.05).with_null(0.0),
    ParameterSpec::new("distance_m", "m", "distance of the change", 1e-9, 1e9, 1.0),
];

impl Cause for Wear {
    fn id(&self) -> &'static str {
        "wear"
    }

    fn station(&self) -> Station {
        Station::History
    }

    fn reach(&self) -> Reach {
        Reach::Factor
    }

    fn describe(&self) -> &'static str {
        "Friction changes with the distance slid since the first run."
    }

    fn parameters(&self) -> &'static [ParameterSpec] {
        PARAMETERS
    }

    fn parameters_for(&self, experiment: &Experiment) -> Vec<ParameterSpec> {
        let (run, all) = grids::slid_m(experiment);
        vec![PARAMETERS[0].clone(), grids::bounded(&PARAMETERS[1], 0.02 * run, 30.0 * all, all)]
    }

    fn requirements(&self) -> &'static [Requirement] {
        &[Requirement::Order]
    }

    fn shape_grid(&self, experiment: &Experiment) -> Vec<Vec<f64>> {
        let (run, all) = grids::slid_m(experiment);
        grids::logarithmic(0.1 * run, 3.0 * all, 9).into_iter().map(|d| vec![0.0, d]).collect()
    }

    fn factor<D: Scalar>(&self, p: &[D], at: Place<'_>, _friction_n: &[D], factor: &mut [D], _memory: &mut [D]) {
        let Some(before) = at.run.prior_distance_m else { return };
        for (f, &s) in factor.iter_mut().zip(&at.run.distance_m) {
            let gone = -(-(p[1].recip() * (before + s))).exp() + 1.0;
            *f *= p[0] * gone + 1.0;
        }
    }
}

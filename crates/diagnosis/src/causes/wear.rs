//! Running-in or wear, S the distance slid since the first run (m), d a distance (m): towards a limit, mu (1 + A (1 - exp(-S/d))),
//! or ever more slowly without one, mu (1 + a log10(1 + S/d)), which is what a power of 1 + S/d with a small exponent looks like.

use friction::{ParameterSpec, Scalar};
use rig::{Cause, Experiment, Place, Reach, Requirement, Station};

use super::grids;

const DESCRIPTION: &str = "Friction changes with the distance slid since the first run.";

/// Bounds of the distance for this campaign.
fn distance(spec: &ParameterSpec, experiment: &Experiment) -> ParameterSpec {
    let (run, all) = grids::slid_m(experiment);
    grids::bounded(spec, 0.02 * run, 30.0 * all, all)
}

/// Distances at which the scan looks.
fn distances(experiment: &Experiment) -> Vec<Vec<f64>> {
    let (run, all) = grids::slid_m(experiment);
    grids::logarithmic(0.1 * run, 3.0 * all, 9).into_iter().map(|d| vec![0.0, d]).collect()
}

/// Towards a limit.
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
        DESCRIPTION
    }

    fn parameters(&self) -> &'static [ParameterSpec] {
        PARAMETERS
    }

    fn parameters_for(&self, experiment: &Experiment) -> Vec<ParameterSpec> {
        vec![PARAMETERS[0].clone(), distance(&PARAMETERS[1], experiment)]
    }

    fn requirements(&self) -> &'static [Requirement] {
        &[Requirement::Order]
    }

    fn shape_grid(&self, experiment: &Experiment) -> Vec<Vec<f64>> {
        distances(experiment)
    }

    fn factor<D: Scalar>(&self, p: &[D], at: Place<'_>, _friction_n: &[D], factor: &mut [D], _memory: &mut [D]) {
        let Some(before) = at.run.prior_distance_m else { return };
        for (f, &s) in factor.iter_mut().zip(&at.run.distance_m) {
            let gone = -(-(p[1].recip() * (before + s))).exp() + 1.0;
            *f *= p[0] * gone + 1.0;
        }
    }
}

/// Ever more slowly.
#[derive(Clone, Copy, Debug)]
pub struct WearByDecades;

const BY_DECADES: &[ParameterSpec] = &[
    ParameterSpec::new("amplitude_per_decade", "1", "change for ten times the distance", -0.5, 10.0, 0.02).with_null(0.0),
    ParameterSpec::new("distance_m", "m", "distance at which it sets in", 1e-9, 1e9, 1.0),
];

impl Cause for WearByDecades {
    fn id(&self) -> &'static str {
        "wear"
    }

    fn variant(&self) -> Option<&'static str> {
        Some("by decades")
    }

    fn station(&self) -> Station {
        Station::History
    }

    fn reach(&self) -> Reach {
        Reach::Factor
    }

    fn describe(&self) -> &'static str {
        DESCRIPTION
    }

    fn parameters(&self) -> &'static [ParameterSpec] {
        BY_DECADES
    }

    fn parameters_for(&self, experiment: &Experiment) -> Vec<ParameterSpec> {
        vec![BY_DECADES[0].clone(), distance(&BY_DECADES[1], experiment)]
    }

    fn requirements(&self) -> &'static [Requirement] {
        &[Requirement::Order]
    }

    fn shape_grid(&self, experiment: &Experiment) -> Vec<Vec<f64>> {
        distances(experiment)
    }

    fn factor<D: Scalar>(&self, p: &[D], at: Place<'_>, _friction_n: &[D], factor: &mut [D], _memory: &mut [D]) {
        let Some(before) = at.run.prior_distance_m else { return };
        let slope = p[0] * std::f64::consts::LOG10_E;
        for (f, &s) in factor.iter_mut().zip(&at.run.distance_m) {
            *f *= slope * (p[1].recip() * (before + s)).ln_1p() + 1.0;
        }
    }
}

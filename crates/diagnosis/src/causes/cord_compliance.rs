//! The elastic cord between specimen and sensor: compliance C (m/N), damping d (N s/m), on it the specimen's mass, taken as
//! its load over standard gravity (the load is the weight; inferred) or, without a load, the rig's moving mass. In a second form
//! the moving mass stands beside the cord, on the motor's side, and nothing of weight is on it. Either may harden: its stiffness is
//! (1 + h w^2) / C where w is the tension that C alone would give. The mechanics stand in [`rig::Coupling`].
//!
//! A resonance of more than a turn between samples leaves no ringing in the record, so its damping cannot be told and the
//! ringing need not be computed: from there on the mass is taken as damped critically, the more the faster it is,
//!
//! ```text
//! d + 2 sqrt(m / C) s(w dt / pi),   w = 1 / sqrt(m C),   s = 0 up to 2, 1 from 4 on, smooth between
//! ```

use std::collections::BTreeMap;

use friction::{ParameterSpec, Scalar};
use rig::GRAVITY_M_S2;
use rig::{
    Cause, Coupling, Experiment, Place, Reach, Reported, Requirement, RunMotion, Station,
};

use super::grids;

/// The cord that holds the specimen stretches, so the slip speed differs from the stage's speed.
#[derive(Clone, Copy, Debug)]
pub struct CordCompliance;

const COMPLIANCE: ParameterSpec = ParameterSpec::new(
    "compliance_m_n",
    "m/N",
    "compliance of the cord",
    0.0,
    1e3,
    1e-3,
)
.with_null(0.0);
const DAMPING: ParameterSpec = ParameterSpec::new(
    "damping_n_s_m",
    "N s/m",
    "damping of the cord",
    0.0,
    1e9,
    0.0,
);
const PARAMETERS: &[ParameterSpec] = &[COMPLIANCE, DAMPING];

/// h of a cord that hardens (or, below nothing, softens).
const HARDENING: ParameterSpec = ParameterSpec::new(
    "hardening_1_n2",
    "1/N^2",
    "h in the stiffness (1 + h w^2) / C, w being the tension that C alone would give",
    -1e9,
    1e9,
    0.0,
);
/// Bounds and typical size of h times the square of the force's scale F. One that softens holds 2/3 / sqrt(-h) at most: 1.7 F at the lower bound, so
/// that a fit's way there does not lead past the last tension.
const SOFTEST: f64 = -0.15;
const HARDEST: f64 = 30.0;
const HARDER: f64 = 0.3;

/// Damping as a share of the critical one: of a mass that rings for some turns, and of one that does not.
const HARDLY_DAMPED: f64 = 0.05;
const WELL_DAMPED: f64 = 0.3;

impl CordCompliance {
    /// A share of the critical damping 2 sqrt(m / C) of the heaviest specimen, within the bounds, N s/m.
    fn damping(&self, experiment: &Experiment, compliance: f64, share: f64) -> f64 {
        let runs = experiment.runs.iter();
        let masses = runs.map(|run| specimen_mass_kg(run, experiment));
        let critical = 2.0 * (masses.fold(0.0, f64::max) / compliance).sqrt();
        (share * critical).min(self.parameters_for(experiment)[1].upper)
    }
}

impl Cause for CordCompliance {
    fn id(&self) -> &'static str {
        "cord-compliance"
    }

    fn station(&self) -> Station {
        Station::Coupling
    }

    fn reach(&self) -> Reach {
        Reach::Coupling
    }

    fn describe(&self) -> &'static str {
        "The cord that holds the specimen stretches, so the slip speed differs from the stage's speed."
    }

    fn parameters(&self) -> &'static [ParameterSpec] {
        PARAMETERS
    }

    fn parameters_for(&self, experiment: &Experiment) -> Vec<ParameterSpec> {
        // typical: a stretch of a hundredth of the travel at the largest force
        let scales = &experiment.scales;
        let soft = scales.travel_m / scales.force_n.max(1e-12);
        let damping = scales.force_n / scales.speed_m_s;
        vec![
            grids::bounded(&COMPLIANCE, 0.0, soft, 0.01 * soft),
            grids::bounded(&DAMPING, 0.0, 100.0 * damping, 0.0),
        ]
    }

    fn starts(&self, experiment: &Experiment) -> Vec<Vec<f64>> {
        let typical = self.parameters_for(experiment)[0].typical;
        [0.03, 0.3, 3.0, 30.0]
            .iter()
            .map(|share| {
                let mut start = vec![share * typical, 0.0];
                self.prepare_start(experiment, &mut start);
                start
            })
            .collect()
    }

    fn prepare_start(&self, experiment: &Experiment, start: &mut [f64]) {
        if start[0] > 0.0 && start[1] == 0.0 {
            start[1] = self.damping(experiment, start[0], WELL_DAMPED);
        }
    }

    /// A mass that rings is out of step with the record at the slightest error of its frequency, and every turn of the phase is a
    /// valley of its own: compliances in steps of an eighth, hardly damped and well damped.
    fn about(&self, experiment: &Experiment, start: &[f64]) -> Vec<Vec<f64>> {
        let upper = self.parameters_for(experiment)[0].upper;
        let steps = -8..=10;
        steps
            .flat_map(|k| {
                let compliance = (start[0] * 1.125_f64.powi(k)).min(upper);
                [HARDLY_DAMPED, WELL_DAMPED].map(|share| {
                    vec![compliance, self.damping(experiment, compliance, share)]
                })
            })
            .collect()
    }

    fn coupling<D: Scalar>(&self, p: &[D], at: Place<'_>, coupling: &mut Coupling<D>) {
        coupling.compliance = p[0];
        coupling.damping = p[1];
        let mass = specimen_mass_kg(at.run, at.experiment);
        // a mass rings after every jump of speed by the root of the compliance, which has no derivative at the null:
        // there the derivative is that of the cord alone
        let slack = p[0].value() == 0.0;
        coupling.mass = D::constant(if slack { 0.0 } else { mass });
        if !slack && mass > 0.0 {
            coupling.damping += unseen_damping(p[0], mass, mean_step_s(at.run));
        }
    }
}

/// The same cord beside the rig's moving mass: only the contact is elastic.
#[derive(Clone, Copy, Debug)]
pub struct CordBesideMass;

impl Cause for CordBesideMass {
    fn id(&self) -> &'static str {
        CordCompliance.id()
    }

    fn variant(&self) -> Option<&'static str> {
        Some("beside the moving mass")
    }

    fn station(&self) -> Station {
        CordCompliance.station()
    }

    fn reach(&self) -> Reach {
        CordCompliance.reach()
    }

    fn describe(&self) -> &'static str {
        CordCompliance.describe()
    }

    fn parameters(&self) -> &'static [ParameterSpec] {
        PARAMETERS
    }

    fn parameters_for(&self, experiment: &Experiment) -> Vec<ParameterSpec> {
        CordCompliance.parameters_for(experiment)
    }

    fn requirements(&self) -> &'static [Requirement] {
        &[Requirement::MovingMass]
    }

    fn starts(&self, experiment: &Experiment) -> Vec<Vec<f64>> {
        CordCompliance.starts(experiment)
    }

    fn prepare_start(&self, experiment: &Experiment, start: &mut [f64]) {
        CordCompliance.prepare_start(experiment, start);
    }

    fn reported(&self, fitted: &[f64]) -> Vec<Reported> {
        let mut reported = CordCompliance.reported(fitted);
        reported.push(Reported {
            name: "mass_kg",
            unit: "kg",
            value: 0.0,
            gradient: vec![0.0; fitted.len()],
        });
        reported
    }

    fn from_reported(&self, reported: &BTreeMap<String, f64>) -> Result<Vec<f64>, String> {
        match reported.get("mass_kg") {
            Some(0.0) => CordCompliance.from_reported(reported),
            _ => Err("mass_kg".to_owned()),
        }
    }

    fn coupling<D: Scalar>(&self, p: &[D], _at: Place<'_>, coupling: &mut Coupling<D>) {
        coupling.compliance = p[0];
        coupling.damping = p[1];
    }
}

/// What a cord that hardens has beside a plain one. Asked only where that is found: its shape is a small part of what a cord does.
macro_rules! hardening_form {
    ($plain:ident, $variant:literal) => {
        super::marker::refining_form!(
            $plain,
            $variant,
            [COMPLIANCE, DAMPING, HARDENING]
        );

        fn parameters_for(&self, experiment: &Experiment) -> Vec<ParameterSpec> {
            let mut specs = $plain.parameters_for(experiment);
            let unit = experiment.scales.force_n.max(1e-12).powi(-2);
            specs.push(grids::bounded(
                &HARDENING,
                SOFTEST * unit,
                HARDEST * unit,
                HARDER * unit,
            ));
            specs
        }

        fn starts(&self, experiment: &Experiment) -> Vec<Vec<f64>> {
            let typical = self.parameters_for(experiment)[2].typical;
            let mut starts = $plain.starts(experiment);
            for start in &mut starts {
                start.push(typical);
            }
            starts
        }

        fn reported(&self, fitted: &[f64]) -> Vec<Reported> {
            let mut reported = $plain.reported(fitted);
            reported.push(Reported {
                name: "hardening_1_n2",
                unit: "1/N^2",
                value: fitted[2],
                gradient: vec![0.0, 0.0, 1.0],
            });
            reported
        }

        fn from_reported(&self, reported: &BTreeMap<String, f64>) -> Result<Vec<f64>, String> {
            let mut fitted = $plain.from_reported(reported)?;
            let hardening = reported.get("hardening_1_n2");
            fitted.push(*hardening.ok_or_else(|| "hardening_1_n2".to_owned())?);
            Ok(fitted)
        }

        fn coupling<D: Scalar>(&self, p: &[D], at: Place<'_>, coupling: &mut Coupling<D>) {
            $plain.coupling(p, at, coupling);
            coupling.hardening = p[2];
        }
    };
}

/// A cord whose stiffness rises with its tension.
#[derive(Clone, Copy, Debug)]
pub struct HardeningCord;

impl Cause for HardeningCord {
    hardening_form!(CordCompliance, "hardening");
}

/// The same beside the rig's moving mass.
#[derive(Clone, Copy, Debug)]
pub struct HardeningBesideMass;

impl Cause for HardeningBesideMass {
    hardening_form!(CordBesideMass, "hardening, beside the moving mass");
}

/// Mass on the cord, kg.
fn specimen_mass_kg(run: &RunMotion, experiment: &Experiment) -> f64 {
    run.nominal_load_n
        .map_or(experiment.moving_mass_kg, |load| load / GRAVITY_M_S2)
}

/// Mean time from sample to sample, s.
fn mean_step_s(run: &RunMotion) -> f64 {
    (run.time_s[run.len() - 1] - run.time_s[0]) / (run.len() - 1).max(1) as f64
}

/// Damping of a ringing that samples so far apart cannot show, N s/m.
fn unseen_damping<D: Scalar>(compliance: D, mass: f64, step_s: f64) -> D {
    let turns = (compliance * mass).recip().sqrt() * (step_s / std::f64::consts::PI);
    let over = turns * 0.5 - 1.0;
    let share = if over.value() <= 0.0 {
        return D::constant(0.0);
    } else if over.value() >= 1.0 {
        D::constant(1.0)
    } else {
        over * over * (over * -2.0 + 3.0)
    };
    (compliance.recip() * mass).sqrt() * 2.0 * share
}

//! Friction grows faster than linearly with speed. The square is added to the coefficient, mu + q v |v|, q in s^2/m^2: it grows at once where
//! the bristles are still bending, and by as much in both directions. Or it is a factor, mu (1 + q v^2), which means the same with and without
//! a load. One q is mu times the other, so the plain form comes first wherever a load is recorded. Where none is, the factor comes first, and
//! what is added is a force, F + q v |v|, q in N s^2/m^2 as the law's own parameters are in newtons there. Where friction builds up over a way
//! on which the speed changes, the two differ. Any of them may have the next term of the series beside, q v^2 + c |v|^3, which is what
//! another power of the speed than the second looks like.

use friction::{ParameterSpec, Scalar};
use rig::{Cause, Experiment, Place, Reach, Requirement, Station};

use super::{grids, marker};

const fn coefficient(name: &'static str, unit: &'static str, symbol: &'static str) -> ParameterSpec {
    ParameterSpec::new(name, unit, symbol, -1e9, 1e9, 1.0).with_null(0.0)
}

const QUADRATIC: ParameterSpec = coefficient("quadratic_s2_m2", "s^2/m^2", "quadratic coefficient");
const CUBIC: ParameterSpec = coefficient("cubic_s3_m3", "s^3/m^3", "cubic coefficient");
const PARAMETERS: &[ParameterSpec] = &[QUADRATIC];

const FORCE_QUADRATIC: ParameterSpec = coefficient("quadratic_s2_m2", "N s^2/m^2", "quadratic coefficient");
const FORCE_CUBIC: ParameterSpec = coefficient("cubic_s3_m3", "N s^3/m^3", "cubic coefficient");
const FORCE_PARAMETERS: &[ParameterSpec] = &[FORCE_QUADRATIC];

/// q of what is added: the typical friction at the campaign's speed is the unit.
fn added(experiment: &Experiment, spec: &ParameterSpec) -> ParameterSpec {
    let unit = experiment.scales.friction / experiment.scales.speed_m_s.powi(2);
    grids::bounded(spec, -0.9 * unit, 100.0 * unit, 0.05 * unit)
}

/// Friction grows with the square of the speed.
#[derive(Clone, Copy, Debug)]
pub struct VelocityStrengthening;

impl Cause for VelocityStrengthening {
    fn id(&self) -> &'static str {
        "velocity-strengthening"
    }

    fn station(&self) -> Station {
        Station::Law
    }

    fn reach(&self) -> Reach {
        Reach::Factor
    }

    fn describe(&self) -> &'static str {
        "Friction grows with the square of the speed."
    }

    fn parameters(&self) -> &'static [ParameterSpec] {
        PARAMETERS
    }

    fn parameters_for(&self, experiment: &Experiment) -> Vec<ParameterSpec> {
        let square = experiment.scales.speed_m_s.powi(2);
        vec![grids::bounded(&PARAMETERS[0], -0.9 / square, 100.0 / square, 0.05 / square)]
    }

    fn factor<D: Scalar>(&self, p: &[D], at: Place<'_>, _friction_n: &[D], factor: &mut [D], _memory: &mut [D]) {
        for (f, &v) in factor.iter_mut().zip(&at.run.velocity_m_s) {
            *f *= p[0] * (v * v) + 1.0;
        }
    }
}

/// The square of the speed is added to the coefficient of friction.
#[derive(Clone, Copy, Debug)]
pub struct AddedStrengthening;

impl Cause for AddedStrengthening {
    fn id(&self) -> &'static str {
        "velocity-strengthening"
    }

    fn variant(&self) -> Option<&'static str> {
        Some("added")
    }

    fn station(&self) -> Station {
        Station::Law
    }

    fn reach(&self) -> Reach {
        Reach::Record
    }

    fn describe(&self) -> &'static str {
        "Friction grows with the square of the speed."
    }

    fn parameters(&self) -> &'static [ParameterSpec] {
        PARAMETERS
    }

    fn requirements(&self) -> &'static [Requirement] {
        &[Requirement::Load]
    }

    fn parameters_for(&self, experiment: &Experiment) -> Vec<ParameterSpec> {
        vec![added(experiment, &PARAMETERS[0])]
    }

    fn record<D: Scalar>(&self, p: &[D], at: Place<'_>, force_n: &mut [D]) {
        add(|v| p[0] * v, at, force_n);
    }
}

/// The square of the speed is added to the force, on a rig without a load.
#[derive(Clone, Copy, Debug)]
pub struct ForceStrengthening;

impl Cause for ForceStrengthening {
    marker::form_of!(AddedStrengthening, "added-force");

    fn parameters(&self) -> &'static [ParameterSpec] {
        FORCE_PARAMETERS
    }

    fn requirements(&self) -> &'static [Requirement] {
        &[Requirement::NoLoad]
    }

    fn parameters_for(&self, experiment: &Experiment) -> Vec<ParameterSpec> {
        vec![added(experiment, &FORCE_PARAMETERS[0])]
    }

    fn record<D: Scalar>(&self, p: &[D], at: Place<'_>, force_n: &mut [D]) {
        add(|v| p[0] * v, at, force_n);
    }
}

/// What a form with the cubic term has beside its plain one.
macro_rules! cubic_form {
    ($plain:ident, $variant:literal, $quadratic:ident, $cubic:ident) => {
        marker::refining_form!($plain, $variant, [$quadratic, $cubic]);

        /// The cubic term's bounds: as large as the quadratic one's at the campaign's speed, of either sign.
        fn parameters_for(&self, experiment: &Experiment) -> Vec<ParameterSpec> {
            let mut specs = $plain.parameters_for(experiment);
            let speed = experiment.scales.speed_m_s;
            let (most, typical) = (specs[0].upper / speed, specs[0].typical / speed);
            specs.push(grids::bounded(&$cubic, -most, most, typical));
            specs[0].lower = -specs[0].upper;
            specs
        }

        fn sizes(&self) -> &'static [usize] {
            &[0, 1]
        }
    };
}

/// The square and the cube of the speed, as a factor.
#[derive(Clone, Copy, Debug)]
pub struct CubicStrengthening;

impl Cause for CubicStrengthening {
    cubic_form!(VelocityStrengthening, "cubic", QUADRATIC, CUBIC);

    fn factor<D: Scalar>(&self, p: &[D], at: Place<'_>, _friction_n: &[D], factor: &mut [D], _memory: &mut [D]) {
        for (f, &v) in factor.iter_mut().zip(&at.run.velocity_m_s) {
            *f *= (p[1] * v.abs() + p[0]) * (v * v) + 1.0;
        }
    }
}

/// The square and the cube of the speed, added to the coefficient of friction.
#[derive(Clone, Copy, Debug)]
pub struct AddedCubic;

impl Cause for AddedCubic {
    cubic_form!(AddedStrengthening, "added, cubic", QUADRATIC, CUBIC);

    fn record<D: Scalar>(&self, p: &[D], at: Place<'_>, force_n: &mut [D]) {
        add(|v| (p[1] * v + p[0]) * v, at, force_n);
    }
}

/// The same, added to the force on a rig without a load.
#[derive(Clone, Copy, Debug)]
pub struct ForceCubic;

impl Cause for ForceCubic {
    cubic_form!(ForceStrengthening, "added-force, cubic", FORCE_QUADRATIC, FORCE_CUBIC);

    fn record<D: Scalar>(&self, p: &[D], at: Place<'_>, force_n: &mut [D]) {
        add(|v| (p[1] * v + p[0]) * v, at, force_n);
    }
}

/// F + g(|v|) v N, g v being what is added to the coefficient; N is one in contact where no load is recorded.
fn add<D: Scalar>(g: impl Fn(f64) -> D, at: Place<'_>, force_n: &mut [D]) {
    let motion = at.run.velocity_m_s.iter().zip(&at.run.load_n);
    for (f, (&v, &load)) in force_n.iter_mut().zip(motion) {
        *f += g(v.abs()) * (v * load);
    }
}

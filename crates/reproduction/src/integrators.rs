//! Ways to carry the bristle state along a recorded motion: the integrator as one of the choices that a paper leaves open.
//!
//! E3, z' = w(z, v) - abs(w) z/g, is integrated by crate `friction` to 1e-8 of the level of the state. Who writes the model
//! down anew takes one step a sample, most often one of these (dt: from sample to sample, v linear between them):
//!
//! ```text
//! explicit     Runge-Kutta of order four                                                    error dt^4
//! closed form  z1 = s + (z0 - s) exp(-r dt), the target s and the rate r at the mean speed   error dt
//! implicit     z1 = z0 + dt z'(z1, v1), Euler backwards                                       error dt
//! ```
//!
//! States in rad, times in s, speeds in m/s, as in crate `friction`.

use friction::{Drive, Law, Record, integrate};
use rig::RunMotion;
use serde::{Deserialize, Serialize};

/// How the state is carried from sample to sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Integrator {
    /// Radau IIA of order five with steps chosen by its error: what every number outside the multiverses comes from.
    Controlled,
    /// Runge-Kutta of order four, a step a sample.
    Explicit,
    /// The exact solution with target and rate held, a step a sample.
    ClosedForm,
    /// Euler backwards, a step a sample.
    Implicit,
}

impl Integrator {
    /// All of them, the one that the program uses first.
    pub(crate) const ALL: [Self; 4] = [
        Self::Controlled,
        Self::Explicit,
        Self::ClosedForm,
        Self::Implicit,
    ];

    /// Words for the list of choices.
    pub(crate) fn words(self) -> &'static str {
        match self {
            Self::Controlled => "Radau, error controlled",
            Self::Explicit => "Runge-Kutta 4, a step a sample",
            Self::ClosedForm => "closed form, a step a sample",
            Self::Implicit => "backward Euler, a step a sample",
        }
    }

    /// State at every sample of a motion that starts relaxed and whose velocity is linear between `knots`; `None` where it
    /// leaves the numbers.
    pub(crate) fn carry(
        self,
        law: &Law<f64>,
        time_s: &[f64],
        velocity_m_s: &[f64],
        knots: &[usize],
    ) -> Option<Vec<f64>> {
        if self == Self::Controlled {
            let record = Record::of_slip(time_s, velocity_m_s, knots);
            return integrate(law, &record, 0.0).ok();
        }
        let mut states = vec![0.0];
        let mut z = 0.0;
        for (times, speeds) in time_s.windows(2).zip(velocity_m_s.windows(2)) {
            let (dt, v) = (times[1] - times[0], [speeds[0], speeds[1]]);
            z = match self {
                Self::ClosedForm => closed_form(law, z, v, dt),
                Self::Implicit => backward_euler(law, z, v[1], dt)?,
                _ => runge_kutta(law, z, v, dt),
            };
            if !z.is_finite() {
                return None;
            }
            states.push(z);
        }
        Some(states)
    }

    /// Force of friction at every sample of a run, N; `None` where the state leaves the numbers. A specimen that was turned
    /// round meets the plate the other way.
    pub(crate) fn force_n(self, law: &Law<f64>, run: &RunMotion) -> Option<Vec<f64>> {
        let turn = if run.specimen_turned { -1.0 } else { 1.0 };
        let slip: Vec<f64> = run.velocity_m_s.iter().map(|v| turn * v).collect();
        let states = self.carry(law, &run.time_s, &slip, &run.knots)?;
        let motion = slip.iter().zip(&run.load_n);
        let force = states
            .iter()
            .zip(motion)
            .map(|(z, (v, load))| turn * load * law.coefficient(*z, &Drive::at(*v)));
        Some(force.collect())
    }
}

fn runge_kutta(law: &Law<f64>, z: f64, [v0, v1]: [f64; 2], dt: f64) -> f64 {
    let rate = |z: f64, v: f64| law.state_rate(z, &Drive::at(v));
    let middle = 0.5 * (v0 + v1);
    let k1 = rate(z, v0);
    let k2 = rate(z + 0.5 * dt * k1, middle);
    let k3 = rate(z + 0.5 * dt * k2, middle);
    let k4 = rate(z + dt * k3, v1);
    z + dt / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
}

fn closed_form(law: &Law<f64>, z: f64, [v0, v1]: [f64; 2], dt: f64) -> f64 {
    let v = 0.5 * (v0 + v1);
    if v == 0.0 {
        return z;
    }
    let away = z - law.steady_state(v);
    // z' = -r (z - s): at the target itself the rate is nothing and so is the way that is left
    if away == 0.0 {
        return z;
    }
    let rate = -law.state_rate(z, &Drive::at(v)) / away;
    z + away * (-rate * dt).exp_m1()
}

/// Newton's iteration with a slope from central differences; `None` where it does not end.
fn backward_euler(law: &Law<f64>, z: f64, v: f64, dt: f64) -> Option<f64> {
    const LIMIT: usize = 50;
    // Central differences of a smooth function are good to the cube root of rounding squared: enough for a slope.
    const WIDTH: f64 = 1e-6;
    let drive = Drive::at(v);
    let residual = |next: f64| next - z - dt * law.state_rate(next, &drive);
    let mut next = z;
    for _ in 0..LIMIT {
        let slope = (residual(next + WIDTH) - residual(next - WIDTH)) / (2.0 * WIDTH);
        let step = residual(next) / slope;
        next -= step;
        if step.abs() <= 1e-13 {
            return Some(next);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use friction::LawKind;

    /// A leaning brush with a Stribeck curve: angles in rad, damping in s.
    const PARAMETERS: [f64; 7] = [0.5, 0.56, 1.6, 0.09, 0.007, 1.1, -0.28];

    /// Speeds up to 60 mm/s in two seconds, there and back, in `steps` equal steps of time.
    fn states(integrator: Integrator, steps: usize) -> Vec<f64> {
        let law = LawKind::AsymmetricBristle
            .build(&PARAMETERS, Some(0.0072))
            .unwrap();
        let time: Vec<f64> = (0..=steps).map(|k| 4.0 * k as f64 / steps as f64).collect();
        let speed: Vec<f64> = time
            .iter()
            .map(|t| 0.03 * if *t < 2.0 { *t } else { 4.0 - t })
            .collect();
        integrator
            .carry(&law, &time, &speed, &[0, steps / 2, steps])
            .unwrap()
    }

    /// Largest distance from the controlled integration at the samples of the coarsest record.
    fn error(integrator: Integrator, steps: usize) -> f64 {
        let exact = states(Integrator::Controlled, 120);
        let thin = steps / 120;
        states(integrator, steps)
            .iter()
            .step_by(thin)
            .zip(&exact)
            .map(|(one, other)| (one - other).abs())
            .fold(0.0, f64::max)
    }

    #[test]
    fn every_one_comes_to_the_same_states_at_its_own_order() {
        for (integrator, order) in [
            (Integrator::Explicit, 4.0),
            (Integrator::ClosedForm, 1.0),
            (Integrator::Implicit, 1.0),
        ] {
            // Finer, the explicit one meets the 1e-8 to which the controlled one is good.
            let (coarse, fine) = (error(integrator, 120), error(integrator, 240));
            let found = (coarse / fine).log2();
            assert!(fine > 0.0 && coarse < 0.05, "{integrator:?}: {coarse:e}");
            assert!(
                (found - order).abs() < 0.35,
                "{integrator:?}: order {found}, errors {coarse:e} and {fine:e}"
            );
        }
    }

    #[test]
    fn a_step_too_long_for_it_makes_an_explicit_step_leave_the_numbers_or_the_state() {
        let law = LawKind::AsymmetricBristle
            .build(&PARAMETERS, Some(0.0072))
            .unwrap();
        // 3 m/s at a sample a second: hundreds of relaxation times a step
        let time: Vec<f64> = (0..20).map(f64::from).collect();
        let speed = vec![3.0; 20];
        let knots: Vec<usize> = (0..20).collect();
        let target = law.steady_state(3.0);
        let end = |integrator: Integrator| {
            let states = integrator.carry(&law, &time, &speed, &knots);
            states.and_then(|states| states.last().copied())
        };
        assert!(end(Integrator::Explicit).is_none_or(|z| (z - target).abs() > 1.0));
        for stable in [Integrator::Controlled, Integrator::ClosedForm] {
            assert!((end(stable).unwrap() - target).abs() < 1e-6, "{stable:?}");
        }
    }
}

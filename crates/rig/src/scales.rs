//! Typical sizes in a campaign, and what they mean for bounds and steps of a law's parameters.

use std::borrow::Cow;

use campaign::Axis;
use friction::{LawKind, ParameterSpec};

use crate::RunMotion;

/// Typical sizes in a campaign.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scales {
    /// Largest speed, m/s.
    pub speed_m_s: f64,
    /// Span of positions, m.
    pub travel_m: f64,
    /// Typical friction: root mean square of force over load in contact (of the force without a load channel).
    pub friction: f64,
    /// Largest recorded force, N.
    pub force_n: f64,
    /// Gap h where it is known, m.
    pub height_m: Option<f64>,
}

impl Scales {
    pub(crate) fn of(runs: &[RunMotion], measured_n: &[f64], height_m: Option<f64>) -> Self {
        let fold =
            |values: &mut dyn Iterator<Item = f64>| values.fold(0.0_f64, |a, x| a.max(x.abs()));
        let speed_m_s = fold(&mut runs.iter().flat_map(|r| r.velocity_m_s.iter().copied()));
        let travel_m = runs
            .iter()
            .map(|run| {
                let low = run.position_m.iter().copied().fold(f64::INFINITY, f64::min);
                let high = run
                    .position_m
                    .iter()
                    .copied()
                    .fold(f64::NEG_INFINITY, f64::max);
                high - low
            })
            .fold(0.0, f64::max);
        let (mut sum, mut count) = (0.0, 0usize);
        for run in runs {
            for (force, load) in measured_n[run.samples.clone()].iter().zip(&run.load_n) {
                if *load > 0.0 {
                    sum += (force / load).powi(2);
                    count += 1;
                }
            }
        }
        let friction = (sum / count.max(1) as f64).sqrt();
        Self {
            speed_m_s,
            travel_m: travel_m.max(1e-12),
            friction: if friction > 0.0 { friction } else { 1.0 },
            force_n: fold(&mut measured_n.iter().copied()),
            height_m,
        }
    }

    /// A law's parameters with bounds and typical sizes that fit this campaign and units that fit its rig.
    ///
    /// Bounds are wide: five decades about the size that speed, travel and friction suggest; angles keep theirs. A state may be ten
    /// decades stiffer than its typical size: a rig whose friction jumps has no stretch before sliding, and none that is longer would fit.
    pub fn law_parameters(&self, law: LawKind, axis: Axis, has_load: bool) -> Vec<ParameterSpec> {
        law.parameters()
            .iter()
            .map(|spec| self.fit(law, spec, axis, has_load))
            .collect()
    }

    fn fit(&self, law: LawKind, spec: &ParameterSpec, axis: Axis, has_load: bool) -> ParameterSpec {
        let (v, x, mu) = (self.speed_m_s, self.travel_m, self.friction);
        let rate = v / self.height_m.unwrap_or(1.0);
        let bristle = law.needs_height();
        let mut fitted = spec.clone();
        // (typical size, lower and upper bound as multiples of it); `true`: in units of friction
        let (typical, lower, upper, of_friction) = match (spec.unit.as_ref(), bristle) {
            ("1", false) => (0.5 * mu, 1e-4, 40.0, true),
            ("m/s", false) => (0.1 * v, 1e-4, 1e2, false),
            ("s/m", false) => (0.1 * mu / v, 0.0, 1e4, true),
            ("1/m", false) => (1e2 * mu / x, 1e-4, 1e10, true),
            ("1/rad", true) => (mu, 1e-3, 1e3, true),
            ("s/rad", true) => (0.01 * mu / rate, 0.0, 1e4, true),
            ("rad/s", true) => (0.2 * rate, 1e-3, 1e2, false),
            _ => return fitted,
        };
        fitted.typical = typical;
        fitted.lower = lower * typical;
        fitted.upper = upper * typical;
        fitted.unit = unit_on_rig(&spec.unit, axis, of_friction && !has_load, bristle);
        fitted
    }
}

/// Unit of a parameter on this rig: friction as force where there is no load, angles for lengths on rotary rigs.
fn unit_on_rig(unit: &str, axis: Axis, as_force: bool, bristle: bool) -> Cow<'static, str> {
    let force = match axis {
        Axis::Linear => "N",
        Axis::Rotary => "N m",
    };
    let turned = if axis == Axis::Rotary && !bristle {
        unit.replace("/m", "/rad").replace("m/", "rad/")
    } else {
        unit.to_owned()
    };
    let whole = match (as_force, turned.as_str()) {
        (false, _) => turned,
        (true, "1") => force.to_owned(),
        (true, rest) => match rest.strip_prefix("1/") {
            Some(per) => format!("{force}/{per}"),
            None => format!("{force} {rest}"),
        },
    };
    Cow::Owned(whole)
}

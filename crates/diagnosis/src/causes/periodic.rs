//! A periodic effect: fitted as a sin + b cos with a shape (period or frequency), reported as amplitude and phase.
//!
//! A sin(x + phase) = a sin(x) + b cos(x), A = sqrt(a^2 + b^2), phase = atan2(b, a). The pair is linear at the null, where
//! a phase means nothing.

use std::collections::BTreeMap;

use friction::{ParameterSpec, Scalar};
use rig::Reported;

pub(super) const SIN: ParameterSpec = ParameterSpec::new(
    "sin_amplitude",
    "1",
    "amplitude of the sine",
    -0.9,
    0.9,
    0.02,
)
.with_null(0.0);
pub(super) const COS: ParameterSpec = ParameterSpec::new(
    "cos_amplitude",
    "1",
    "amplitude of the cosine",
    -0.9,
    0.9,
    0.02,
)
.with_null(0.0);

/// 1 + a sin(x) + b cos(x), p = (a, b, ...).
pub(super) fn ripple<D: Scalar>(p: &[D], x: D) -> D {
    let (sin, cos) = x.sin_cos();
    p[0] * sin + p[1] * cos + 1.0
}

/// Amplitude, shape and phase of p = (a, b, shape).
pub(super) fn reported(
    fitted: &[f64],
    shape: &'static str,
    shape_unit: &'static str,
) -> Vec<Reported> {
    let (a, b) = (fitted[0], fitted[1]);
    let amplitude = a.hypot(b);
    // at the null amplitude and phase have no derivatives
    let (by_a, by_b) = if amplitude > 0.0 {
        (a / amplitude, b / amplitude)
    } else {
        (0.0, 0.0)
    };
    let turn = if amplitude > 0.0 {
        1.0 / amplitude
    } else {
        0.0
    };
    vec![
        Reported {
            name: "amplitude",
            unit: "1",
            value: amplitude,
            gradient: vec![by_a, by_b, 0.0],
        },
        Reported {
            name: shape,
            unit: shape_unit,
            value: fitted[2],
            gradient: vec![0.0, 0.0, 1.0],
        },
        Reported {
            name: "phase_rad",
            unit: "rad",
            value: b.atan2(a),
            gradient: vec![-by_b * turn, by_a * turn, 0.0],
        },
    ]
}

/// (a, b, shape) from amplitude, shape and phase.
pub(super) fn from_reported(
    reported: &BTreeMap<String, f64>,
    shape: &str,
) -> Result<Vec<f64>, String> {
    let get = |name: &str| reported.get(name).copied().ok_or_else(|| name.to_owned());
    let (amplitude, phase) = (get("amplitude")?, get("phase_rad")?);
    Ok(vec![
        amplitude * phase.cos(),
        amplitude * phase.sin(),
        get(shape)?,
    ])
}

//! A periodic effect: fitted as a sin + b cos with a shape (period or frequency), reported as amplitude and phase.
//!
//! A sin(x + phase) = a sin(x) + b cos(x), A = sqrt(a^2 + b^2), phase = atan2(b, a). The pair is linear at the null, where
//! a phase means nothing.
//!
//! What ripples need not do so as a sine. Three refined forms are tried in the place of a sine that was found: with edges,
//!
//! ```text
//! u / sqrt(1 - s + s u^2 / A^2),   u = a sin(x) + b cos(x),   s from 0 (a sine) to 1 (a square wave of the height A)
//! ```
//!
//! with teeth,
//!
//! ```text
//! A sum over n of s^(n - 1) sin(n psi)/n = (A/s) atan(s u / (A - s w)),   w = a cos(x) - b sin(x)
//! ```
//!
//! psi being x + phase and s from -1 (it rises evenly and falls at once) over 0 (a sine) to 1 (it falls evenly), and with a second and a third
//! harmonic, sines and cosines of 2 x and 3 x. Of both A is the height of the first harmonic.

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

/// How a periodic effect goes over its period.
pub(super) trait Wave {
    /// The factor at the phase x, p = (a, b, shape, ...).
    fn ripple<D: Scalar>(p: &[D], x: D) -> D;
}

/// A wave that is asked for in the place of a sine.
pub(super) trait Refined: Wave {
    /// What tells the form from the plain one for a reader.
    const VARIANT: &'static str;
    /// Fitted parameters beside those of the sine.
    const FURTHER: &'static [ParameterSpec];
    /// Indices of fitted parameters that are sizes.
    const SIZES: &'static [usize];
}

/// 1 + a sin(x) + b cos(x).
pub(super) enum Sine {}

impl Wave for Sine {
    fn ripple<D: Scalar>(p: &[D], x: D) -> D {
        let (sin, cos) = x.sin_cos();
        p[0] * sin + p[1] * cos + 1.0
    }
}

/// Between a sine and a square wave.
pub(super) enum Edged {}

/// At most this near to a square: edges of a thousandth of a period.
const SHARPEST: f64 = 0.9999;

pub(super) const EDGES: ParameterSpec = ParameterSpec::new(
    "edges",
    "1",
    "from a sine, 0, to a square wave, 1",
    0.0,
    SHARPEST,
    0.5,
);

impl Refined for Edged {
    const VARIANT: &'static str = "with edges";
    const FURTHER: &'static [ParameterSpec] = &[EDGES];
    const SIZES: &'static [usize] = &[0, 1];
}

impl Wave for Edged {
    fn ripple<D: Scalar>(p: &[D], x: D) -> D {
        let (sin, cos) = x.sin_cos();
        let sine = p[0] * sin + p[1] * cos;
        // at the null u / A is nothing over nothing
        let height = p[0] * p[0] + p[1] * p[1] + f64::MIN_POSITIVE;
        let steepness = p[3] * (sine * sine / height - 1.0) + 1.0;
        sine / steepness.sqrt() + 1.0
    }
}

/// Between a sine and the teeth of a saw.
pub(super) enum Toothed {}

pub(super) const TEETH: ParameterSpec = ParameterSpec::new(
    "teeth",
    "1",
    "from a sine, 0, to teeth that fall (1) or rise (-1) evenly",
    -0.999,
    0.999,
    0.5,
);

impl Refined for Toothed {
    const VARIANT: &'static str = "with teeth";
    const FURTHER: &'static [ParameterSpec] = &[TEETH];
    const SIZES: &'static [usize] = &[0, 1];
}

impl Wave for Toothed {
    fn ripple<D: Scalar>(p: &[D], x: D) -> D {
        let teeth = p[3];
        if teeth.value() == 0.0 {
            return Sine::ripple(p, x);
        }
        let (sin, cos) = x.sin_cos();
        let (sine, cosine) = (p[0] * sin + p[1] * cos, p[0] * cos - p[1] * sin);
        let height = (p[0] * p[0] + p[1] * p[1] + f64::MIN_POSITIVE).sqrt();
        let angle = (teeth * sine / (height - teeth * cosine)).atan();
        height / teeth * angle + 1.0
    }
}

/// With the second and the third harmonic.
pub(super) enum Harmonics {}

const fn harmonic(name: &'static str, symbol: &'static str) -> ParameterSpec {
    ParameterSpec::new(name, "1", symbol, -0.9, 0.9, 0.02).with_null(0.0)
}

pub(super) const SECOND_SIN: ParameterSpec =
    harmonic("second_sin", "amplitude of the second harmonic's sine");
pub(super) const SECOND_COS: ParameterSpec =
    harmonic("second_cos", "amplitude of the second harmonic's cosine");
pub(super) const THIRD_SIN: ParameterSpec =
    harmonic("third_sin", "amplitude of the third harmonic's sine");
pub(super) const THIRD_COS: ParameterSpec =
    harmonic("third_cos", "amplitude of the third harmonic's cosine");

impl Refined for Harmonics {
    const VARIANT: &'static str = "with harmonics";
    const FURTHER: &'static [ParameterSpec] = &[SECOND_SIN, SECOND_COS, THIRD_SIN, THIRD_COS];
    const SIZES: &'static [usize] = &[0, 1, 3, 4, 5, 6];
}

impl Wave for Harmonics {
    fn ripple<D: Scalar>(p: &[D], x: D) -> D {
        let overtone = |k: f64, sine: usize| {
            let (sin, cos) = (x * k).sin_cos();
            p[sine] * sin + p[sine + 1] * cos
        };
        Sine::ripple(p, x) + overtone(2.0, 3) + overtone(3.0, 5)
    }
}

/// Amplitude, shape and phase of the sine, and the further parameters as they are fitted.
pub(super) fn refined(
    mut plain: Vec<Reported>,
    further: &[ParameterSpec],
    fitted: &[f64],
) -> Vec<Reported> {
    for own in &mut plain {
        own.gradient.resize(fitted.len(), 0.0);
    }
    let first = fitted.len() - further.len();
    for (k, spec) in further.iter().enumerate() {
        let mut gradient = vec![0.0; fitted.len()];
        gradient[first + k] = 1.0;
        let std::borrow::Cow::Borrowed(name) = spec.name else {
            unreachable!("names of the catalogue are constants");
        };
        plain.push(Reported {
            name,
            unit: "1",
            value: fitted[first + k],
            gradient,
        });
    }
    plain
}

/// The further parameters of a refined form behind those of the plain one.
pub(super) fn with_further(
    mut plain: Vec<f64>,
    further: &[ParameterSpec],
    reported: &BTreeMap<String, f64>,
) -> Result<Vec<f64>, String> {
    for spec in further {
        let value = reported.get(spec.name.as_ref());
        plain.push(*value.ok_or_else(|| spec.name.to_string())?);
    }
    Ok(plain)
}

/// What a refined form shares with its plain one, whose shape this is: everything but its wave and the hook.
macro_rules! refined_form {
    ($plain:ident, Edged, $shape:ident) => {
        $crate::causes::periodic::refined_form!($plain, Edged, [$shape, EDGES]);
    };
    ($plain:ident, Toothed, $shape:ident) => {
        $crate::causes::periodic::refined_form!($plain, Toothed, [$shape, TEETH]);
    };
    ($plain:ident, Harmonics, $shape:ident) => {
        $crate::causes::periodic::refined_form!(
            $plain,
            Harmonics,
            [$shape, SECOND_SIN, SECOND_COS, THIRD_SIN, THIRD_COS]
        );
    };
    ($plain:ident, $wave:ident, [$shape:ident, $($further:ident),+]) => {
        $crate::causes::marker::refining_form!(
            $plain,
            <$crate::causes::periodic::$wave as $crate::causes::periodic::Refined>::VARIANT,
            [
                $crate::causes::periodic::SIN,
                $crate::causes::periodic::COS,
                $shape,
                $($crate::causes::periodic::$further),+
            ]
        );

        fn parameters_for(&self, experiment: &rig::Experiment) -> Vec<friction::ParameterSpec> {
            let mut specs = $plain.parameters_for(experiment);
            specs.extend_from_slice(
                <$crate::causes::periodic::$wave as $crate::causes::periodic::Refined>::FURTHER,
            );
            specs
        }

        fn sizes(&self) -> &'static [usize] {
            <$crate::causes::periodic::$wave as $crate::causes::periodic::Refined>::SIZES
        }

        fn shape_grid(&self, experiment: &rig::Experiment) -> Vec<Vec<f64>> {
            let mut grid = $plain.shape_grid(experiment);
            for own in &mut grid {
                own.resize(self.parameters().len(), 0.0);
            }
            grid
        }

        fn is_periodic(&self) -> bool {
            true
        }

        fn reported(&self, fitted: &[f64]) -> Vec<rig::Reported> {
            let further =
                <$crate::causes::periodic::$wave as $crate::causes::periodic::Refined>::FURTHER;
            $crate::causes::periodic::refined($plain.reported(&fitted[..3]), further, fitted)
        }

        fn from_reported(
            &self,
            reported: &std::collections::BTreeMap<String, f64>,
        ) -> Result<Vec<f64>, String> {
            let further =
                <$crate::causes::periodic::$wave as $crate::causes::periodic::Refined>::FURTHER;
            $crate::causes::periodic::with_further(
                $plain.from_reported(reported)?,
                further,
                reported,
            )
        }
    };
}
pub(super) use refined_form;

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

//! Periodic texture of the plate: mu (1 + A sin(2 pi x/l + phase)), x the place on the plate (m), l the wavelength (m).

use std::collections::BTreeMap;

use friction::{ParameterSpec, Scalar};
use rig::{Cause, Experiment, Place, Reach, Reported, Requirement, Station};

use super::{grids, periodic};
use periodic::{Edged, Harmonics, Sine, Toothed, Wave};

/// Friction ripples with the place on the plate.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceTexture;

const WAVELENGTH: ParameterSpec = ParameterSpec::new("wavelength_m", "m", "wavelength of the texture", 1e-9, 1e9, 1.0);
const PARAMETERS: &[ParameterSpec] = &[periodic::SIN, periodic::COS, WAVELENGTH];

impl Cause for SurfaceTexture {
    fn id(&self) -> &'static str {
        "surface-texture"
    }

    fn station(&self) -> Station {
        Station::Surface
    }

    fn reach(&self) -> Reach {
        Reach::Factor
    }

    fn describe(&self) -> &'static str {
        "Friction ripples with the place on the plate."
    }

    fn parameters(&self) -> &'static [ParameterSpec] {
        PARAMETERS
    }

    fn parameters_for(&self, experiment: &Experiment) -> Vec<ParameterSpec> {
        let (shortest, longest) = grids::wavelengths_m(experiment);
        let shape = grids::bounded(&PARAMETERS[2], 0.8 * shortest, longest, 0.1 * longest);
        vec![PARAMETERS[0].clone(), PARAMETERS[1].clone(), shape]
    }

    fn sizes(&self) -> &'static [usize] {
        &[0, 1]
    }

    fn shape_grid(&self, experiment: &Experiment) -> Vec<Vec<f64>> {
        let (shortest, longest) = grids::wavelengths_m(experiment);
        grids::rates(1.0 / longest, 1.0 / shortest, longest).into_iter().map(|k| vec![0.0, 0.0, 1.0 / k]).collect()
    }

    fn is_periodic(&self) -> bool {
        true
    }

    fn requirements(&self) -> &'static [Requirement] {
        &[]
    }

    fn reported(&self, fitted: &[f64]) -> Vec<Reported> {
        periodic::reported(fitted, "wavelength_m", "m")
    }

    fn from_reported(&self, reported: &BTreeMap<String, f64>) -> Result<Vec<f64>, String> {
        periodic::from_reported(reported, "wavelength_m")
    }

    fn factor<D: Scalar>(&self, p: &[D], at: Place<'_>, _friction_n: &[D], factor: &mut [D], _memory: &mut [D]) {
        ripple::<Sine, D>(p, at, factor);
    }
}

/// Patches of two levels: between a sine and a square wave.
#[derive(Clone, Copy, Debug)]
pub struct EdgedTexture;

impl Cause for EdgedTexture {
    periodic::refined_form!(SurfaceTexture, Edged, WAVELENGTH);

    fn factor<D: Scalar>(&self, p: &[D], at: Place<'_>, _friction_n: &[D], factor: &mut [D], _memory: &mut [D]) {
        ripple::<Edged, D>(p, at, factor);
    }
}

/// Scales: it rises evenly and falls at once, or the other way round.
#[derive(Clone, Copy, Debug)]
pub struct ToothedTexture;

impl Cause for ToothedTexture {
    periodic::refined_form!(SurfaceTexture, Toothed, WAVELENGTH);

    fn factor<D: Scalar>(&self, p: &[D], at: Place<'_>, _friction_n: &[D], factor: &mut [D], _memory: &mut [D]) {
        ripple::<Toothed, D>(p, at, factor);
    }
}

/// With the second and the third harmonic.
#[derive(Clone, Copy, Debug)]
pub struct HarmonicTexture;

impl Cause for HarmonicTexture {
    periodic::refined_form!(SurfaceTexture, Harmonics, WAVELENGTH);

    fn factor<D: Scalar>(&self, p: &[D], at: Place<'_>, _friction_n: &[D], factor: &mut [D], _memory: &mut [D]) {
        ripple::<Harmonics, D>(p, at, factor);
    }
}

/// Multiplies a run's factor by the wave at each sample's place.
fn ripple<W: Wave, D: Scalar>(p: &[D], at: Place<'_>, factor: &mut [D]) {
    for (f, &x) in factor.iter_mut().zip(&at.run.position_m) {
        *f *= W::ripple(p, p[2].recip() * (std::f64::consts::TAU * x));
    }
}

//! The catalogue of causes: one file each, each a change at one station of the measurement chain.
//!
//! A new cause is a file here and one line in the list below.

mod grids;
mod marker;
mod periodic;
mod second_order;

macro_rules! catalogue {
    ($($module:ident :: $($form:ident),+;)*) => {
        $(mod $module;)*
        $($(pub use $module::$form;)+)*

        /// Every cause, in the order of the list; causes with more than one form (memory in time and in distance, wear with and without a limit, an oscillation that begins anew with each
        /// run and one that goes on between them, a cord under the moving mass and beside it)
        /// stand in every form, with the same id.
        pub fn catalogue() -> Vec<Box<dyn rig::Cause>> {
            vec![$($(Box::new($form)),+),*]
        }
    };
}

catalogue! {
    stage_ripple::StageRipple, CarryingRipple, ScrewRipple, EdgedRipple, ToothedRipple, HarmonicRipple;
    cord_compliance::CordCompliance, CordBesideMass, HardeningCord, HardeningBesideMass;
    stribeck_shape::StribeckShape;
    velocity_strengthening::AddedStrengthening, VelocityStrengthening, ForceStrengthening, AddedCubic, CubicStrengthening, ForceCubic;
    lean_angle::LeanAngle;
    bristle_set::BristleSet, KeptSet, LastWaySet, LostSet, SlidingSet;
    wear::Wear, WearByDecades;
    thermal_softening::ThermalSoftening, LevellingSoftening, ExponentialSoftening;
    surface_texture::SurfaceTexture, EdgedTexture, ToothedTexture, HarmonicTexture;
    surface_gradient::SurfaceGradient, BentGradient;
    load_dependence::LoadDependence;
    load_oscillation::LoadOscillation, OscillationOfTheDay, EdgedOscillation, HarmonicOscillation;
    force_zero_offset::ForceZeroOffset;
    stage_tilt::StageTilt;
    force_zero_drift::ForceZeroDrift, DriftSinceFirstRun, SettlingZero;
    force_gain::ForceGain;
    sensor_lag::SensorLag, SecondOrderLag;
    force_saturation::ForceSaturation;
    force_resolution::ForceResolution;
    clock_offset::ClockOffset;
    direction_asymmetry::DirectionAsymmetry, JumpingAsymmetry;
    frictional_memory::MemoryInTime, MemoryInDistance, MagnitudeInTime, MagnitudeInDistance, ViscousMemoryInTime, ViscousMemoryInDistance,
        WholeMagnitudeInTime, WholeMagnitudeInDistance;
    dwell_ageing::DwellAgeing, AgeingBetweenRuns, TurnedAgeing, FadingAgeing, GrownContact, FreshAgeing, FreshFadingAgeing;
    backlash::Backlash, CarriedBacklash, SoftBacklash, HeldBacklash, HeldCarriedBacklash;
    velocity_lag::VelocityLag, SecondOrderVelocityLag;
    load_crosstalk::LoadCrosstalk;
    moving_inertia::MovingInertia;
}

/// The cause of that id, in its first form.
pub fn find(id: &str) -> Option<Box<dyn rig::Cause>> {
    catalogue().into_iter().find(|cause| cause.id() == id)
}

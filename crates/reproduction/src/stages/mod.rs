//! The stages of the reproduction, one file each.

mod audit;
mod diagnosis;
mod envelope;
mod friction_curves;
mod gait;
mod identification;
mod machine;
mod materials;
mod validation;

use crate::stage::Stage;

/// All stages, in the order of the report; a stage stands behind those that it needs.
#[must_use]
pub fn all() -> Vec<&'static dyn Stage> {
    vec![
        &audit::Audit,
        &identification::Identification,
        &validation::Validation,
        &materials::Materials,
        &envelope::Envelope,
        &gait::Gait,
        &diagnosis::Diagnosis,
    ]
}

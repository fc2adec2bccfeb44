//! The biped and its feet as the paper prints them, for the stages that use them.

use biped::contact::Brush;
use biped::parameters::{Biped, Link};

use crate::published::{Published, PublishedError};
use crate::stage::StageError;

/// Standard acceleration of gravity, m/s^2 (the paper gives none).
const GRAVITY_M_S2: f64 = 9.81;

/// The biped of Table 3 in the project's reading.
pub(super) fn biped(published: &Published) -> Result<Biped, StageError> {
    let number = |name: &str| published.value(&format!("table3.{name}"));
    let link = |name: &str| -> Result<Link, PublishedError> {
        Ok(Link {
            mass_kg: number(&format!("{name}_mass"))?,
            inertia_kg_m2: number(&format!("{name}_inertia"))?,
            length_m: number(&format!("{name}_length"))?,
            centre_m: number(&format!("{name}_centre"))?,
        })
    };
    Biped {
        torso_mass_kg: number("torso_mass")?,
        torso_inertia_kg_m2: number("torso_inertia")?,
        torso_length_m: number("torso_length")?,
        thigh: link("thigh")?,
        shank: link("shank")?,
        hip_torque_n_m: number("hip_torque")?,
        knee_torque_n_m: number("knee_torque")?,
        gravity_m_s2: GRAVITY_M_S2,
    }
    .checked()
    .map_err(|problem| StageError::Failed(problem.to_string()))
}

/// The brush with its published steady coefficients.
pub(super) fn brush(published: &Published) -> Result<Brush, PublishedError> {
    Ok(Brush {
        forward: published.value("steady.forward")?,
        reverse: published.value("steady.reverse")?,
    })
}

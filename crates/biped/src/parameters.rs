//! Masses, lengths and limits of the planar biped.
//!
//! The values come from the paper's table of the biped (one leg, headers lost);
//! which number means what is our reading of it, and it enters here as plain
//! numbers, so that another reading is another value of this struct.

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// One rigid link of a leg, hanging from its upper joint.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Link {
    /// Mass, kg.
    pub mass_kg: f64,
    /// Moment of inertia about the mass centre, kg m^2.
    pub inertia_kg_m2: f64,
    /// Distance from the upper joint to the lower joint (or the foot), m.
    pub length_m: f64,
    /// Distance from the upper joint to the mass centre along the link, m.
    pub centre_m: f64,
}

/// The biped: a torso with a hip at either end, two legs of thigh and shank.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Biped {
    /// Mass of the torso, kg; its mass centre lies in its middle.
    pub torso_mass_kg: f64,
    /// Moment of inertia of the torso about its mass centre, kg m^2.
    pub torso_inertia_kg_m2: f64,
    /// Distance between the two hips, m.
    pub torso_length_m: f64,
    /// Thigh of either leg.
    pub thigh: Link,
    /// Shank of either leg.
    pub shank: Link,
    /// Largest torque of a hip in either direction, N m.
    pub hip_torque_n_m: f64,
    /// Largest torque of a knee in either direction, N m.
    pub knee_torque_n_m: f64,
    /// Acceleration of gravity, m/s^2.
    pub gravity_m_s2: f64,
}

/// A parameter that no body can have.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("biped: {name} must be finite and above zero, but is {value}")]
pub struct UnphysicalParameter {
    /// Field of [`Biped`].
    pub name: &'static str,
    /// What was given.
    pub value: f64,
}

impl Biped {
    /// Checks that every mass, length, inertia and limit is finite and positive.
    ///
    /// # Errors
    /// The first parameter that is not.
    pub fn checked(self) -> Result<Self, UnphysicalParameter> {
        let fields = [
            ("torso_mass_kg", self.torso_mass_kg),
            ("torso_inertia_kg_m2", self.torso_inertia_kg_m2),
            ("torso_length_m", self.torso_length_m),
            ("thigh.mass_kg", self.thigh.mass_kg),
            ("thigh.inertia_kg_m2", self.thigh.inertia_kg_m2),
            ("thigh.length_m", self.thigh.length_m),
            ("thigh.centre_m", self.thigh.centre_m),
            ("shank.mass_kg", self.shank.mass_kg),
            ("shank.inertia_kg_m2", self.shank.inertia_kg_m2),
            ("shank.length_m", self.shank.length_m),
            ("shank.centre_m", self.shank.centre_m),
            ("hip_torque_n_m", self.hip_torque_n_m),
            ("knee_torque_n_m", self.knee_torque_n_m),
            ("gravity_m_s2", self.gravity_m_s2),
        ];
        for (name, value) in fields {
            if !(value.is_finite() && value > 0.0) {
                return Err(UnphysicalParameter { name, value });
            }
        }
        Ok(self)
    }

    /// Mass of torso, one thigh and one shank, kg: what the paper normalises its
    /// force envelope by.
    pub fn one_leg_mass_kg(&self) -> f64 {
        self.torso_mass_kg + self.thigh.mass_kg + self.shank.mass_kg
    }

    /// Mass of the whole biped, kg.
    pub fn total_mass_kg(&self) -> f64 {
        self.torso_mass_kg + 2.0 * (self.thigh.mass_kg + self.shank.mass_kg)
    }

    /// Largest inertia about its mass centre that a thin link of this length can have:
    /// half its mass at either end, m L^2/4. Above it, the number includes
    /// something else (a rotor) or stands in another column.
    pub fn largest_inertia_of_a_rod_kg_m2(link: &Link) -> f64 {
        link.mass_kg * link.length_m * link.length_m / 4.0
    }
}

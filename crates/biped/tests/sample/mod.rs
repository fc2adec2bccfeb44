//! The biped of the tests: the values of the paper's table in the project's reading.

use biped::parameters::{Biped, Link};

/// The biped.
pub(crate) fn biped() -> Biped {
    Biped {
        torso_mass_kg: 7.5,
        torso_inertia_kg_m2: 0.1,
        torso_length_m: 0.6,
        thigh: Link {
            mass_kg: 2.0,
            inertia_kg_m2: 0.016,
            length_m: 0.3,
            centre_m: 0.05,
        },
        shank: Link {
            mass_kg: 0.28,
            inertia_kg_m2: 0.01,
            length_m: 0.3,
            centre_m: 0.05,
        },
        hip_torque_n_m: 35.0,
        knee_torque_n_m: 35.0,
        gravity_m_s2: 9.81,
    }
}

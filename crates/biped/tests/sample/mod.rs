//! The biped and the brush of tests and examples: the paper's values from `data/published.toml`.

use biped::contact::Brush;
use biped::parameters::{Biped, Link};

const PUBLISHED: &str = include_str!("../../../../data/published.toml");

/// A printed number.
fn printed(file: &toml::Table, table: &str, name: &str) -> f64 {
    let printed = file[table][name]["printed"].as_str();
    printed.and_then(|text| text.parse().ok()).expect(name)
}

/// The biped.
pub(crate) fn biped() -> Biped {
    let file: toml::Table = PUBLISHED.parse().expect("published.toml is TOML");
    let number = |name: &str| printed(&file, "table3", name);
    let link = |name: &str| Link {
        mass_kg: number(&format!("{name}_mass")),
        inertia_kg_m2: number(&format!("{name}_inertia")),
        length_m: number(&format!("{name}_length")),
        centre_m: number(&format!("{name}_centre")),
    };
    Biped {
        torso_mass_kg: number("torso_mass"),
        torso_inertia_kg_m2: number("torso_inertia"),
        torso_length_m: number("torso_length"),
        thigh: link("thigh"),
        shank: link("shank"),
        hip_torque_n_m: number("hip_torque"),
        knee_torque_n_m: number("knee_torque"),
        gravity_m_s2: 9.81,
    }
}

/// The brush of the biped's feet.
#[allow(dead_code, reason = "the test of the dynamics needs no feet")]
pub(crate) fn brush() -> Brush {
    let file: toml::Table = PUBLISHED.parse().expect("published.toml is TOML");
    Brush {
        forward: printed(&file, "steady", "forward"),
        reverse: printed(&file, "steady", "reverse"),
    }
}

//! Laws of friction that the planted rigs obey, written from the equations of the paper and of their authors.
//!
//! Each law has one inner state (z: bristle rotation in rad, or deflection in m or rad), a rate and a coefficient
//! (friction over load; the friction itself, N or N m, on a rig without a load channel).

use serde::{Deserialize, Serialize};

/// The asymmetric bristle (E3-E7): symmetric where `theta0_rad` is zero.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bristle {
    /// sigma in the paper's own parametrisation (only theta_c/sigma and theta_s/sigma matter).
    pub sigma: f64,
    /// Level of g at speed.
    pub theta_c: f64,
    /// Level of g at rest.
    pub theta_s: f64,
    /// Angular rate at which g has fallen to 1/e, rad/s.
    pub w_sc: f64,
    /// Stiffness coefficient, 1/rad.
    pub sigma0: f64,
    /// Damping coefficient, s.
    pub sigma1: f64,
    /// Viscous coefficient, s.
    pub sigma2: f64,
    /// Lean of the bristles, rad.
    pub theta0_rad: f64,
    /// Height of the root above the counterface, m.
    pub height_m: f64,
}

/// Deflection laws with a Stribeck curve; `stiffness` 1/m (or 1/rad), levels without unit (or N, N m).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Deflection {
    /// Slope of friction over deflection.
    pub stiffness: f64,
    /// Damping of the deflection, s/m.
    pub damping: f64,
    /// Viscous coefficient, s/m.
    pub viscous: f64,
    /// Coulomb level.
    pub coulomb: f64,
    /// Level at rest.
    pub breakaway: f64,
    /// Stribeck speed, m/s.
    pub stribeck_speed: f64,
}

/// A law of friction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Law {
    /// E3-E7.
    AsymmetricBristle(Bristle),
    /// Canudas de Wit, Olsson, Astrom, Lischinsky (1995).
    Lugre(Deflection),
    /// Dahl (1968): `coulomb` and `stiffness` only.
    Dahl(Deflection),
    /// Static Stribeck curve with viscous friction.
    Stribeck(Deflection),
    /// Coulomb and viscous friction: `coulomb` and `viscous` only.
    CoulombViscous(Deflection),
}

/// What the surroundings do to the law at this moment.
#[derive(Clone, Copy, Debug)]
pub struct Surroundings {
    /// Added to the lean, rad.
    pub lean_rad: f64,
    /// Factor on the level at rest.
    pub breakaway_factor: f64,
    /// Factor on the levels at any speed.
    pub grown_factor: f64,
    /// Added to the exponent 2 of the Stribeck curve.
    pub exponent_minus_2: f64,
    /// Speed that the Stribeck curve sees, if it is not the slip speed.
    pub remembered_speed: Option<f64>,
    /// Speed that the viscous part sees, if it is not the slip speed.
    pub viscous_speed: Option<f64>,
    /// Factors on Coulomb and viscous parts while sliding in reverse (forward they are one).
    pub reverse_factors: (f64, f64),
    /// The first of them is one on the bristles' force, which jumps where the motion turns, instead of one on the level.
    pub jumps: bool,
}

impl Surroundings {
    /// Nothing unusual.
    pub const PLAIN: Self = Self {
        lean_rad: 0.0,
        breakaway_factor: 1.0,
        grown_factor: 1.0,
        exponent_minus_2: 0.0,
        remembered_speed: None,
        viscous_speed: None,
        reverse_factors: (1.0, 1.0),
        jumps: false,
    };
}

fn stribeck(ratio: f64, exponent_minus_2: f64) -> f64 {
    (-ratio.abs().powf(2.0 + exponent_minus_2)).exp()
}

impl Law {
    /// Short name as in the program's documents.
    pub fn id(&self) -> &'static str {
        match self {
            Self::AsymmetricBristle(bristle) if bristle.theta0_rad == 0.0 => "symmetric-bristle",
            Self::AsymmetricBristle(_) => "asymmetric-bristle",
            Self::Lugre(_) => "lugre",
            Self::Dahl(_) => "dahl",
            Self::Stribeck(_) => "stribeck",
            Self::CoulombViscous(_) => "coulomb-viscous",
        }
    }

    /// The same law with bristles so much stiffer and so much more friction (levels of g; of the viscous part nothing changes).
    pub fn of_another_specimen(self, stiffness_minus_1: f64, level_minus_1: f64) -> Self {
        let (stiffer, level) = (1.0 + stiffness_minus_1, 1.0 + level_minus_1);
        let deflection = |of: Deflection| Deflection {
            stiffness: of.stiffness * stiffer,
            coulomb: of.coulomb * level,
            breakaway: of.breakaway * level,
            ..of
        };
        match self {
            // In steady sliding sigma0 g/sigma is the level: g takes back what sigma0 adds.
            Self::AsymmetricBristle(of) => Self::AsymmetricBristle(Bristle {
                sigma0: of.sigma0 * stiffer,
                theta_c: of.theta_c * level / stiffer,
                theta_s: of.theta_s * level / stiffer,
                ..of
            }),
            Self::Lugre(of) => Self::Lugre(deflection(of)),
            Self::Dahl(of) => Self::Dahl(deflection(of)),
            Self::Stribeck(of) => Self::Stribeck(deflection(of)),
            Self::CoulombViscous(of) => Self::CoulombViscous(deflection(of)),
        }
    }

    fn has_state(&self) -> bool {
        !matches!(self, Self::Stribeck(_) | Self::CoulombViscous(_))
    }

    /// (rate of the inner state, coefficient) at inner state `z` and slip speed `v`.
    pub fn evaluate(&self, z: f64, v: f64, around: &Surroundings) -> (f64, f64) {
        let (coulomb_factor, viscous_factor) = if v < 0.0 {
            around.reverse_factors
        } else {
            (1.0, 1.0)
        };
        let (level_factor, force_factor) = match around.jumps && self.has_state() {
            true => (around.grown_factor, coulomb_factor),
            false => (around.grown_factor * coulomb_factor, 1.0),
        };
        let seen = around.remembered_speed.unwrap_or(v);
        let dragged = around.viscous_speed.unwrap_or(v);
        match self {
            Self::AsymmetricBristle(b) => {
                // w = (v/h) cos^2(theta + theta0)                                   (E4)
                let lean = b.theta0_rad + around.lean_rad;
                let cos2 = (z + lean).cos().powi(2);
                let w = v / b.height_m * cos2;
                // g = theta_c + (theta_s - theta_c) exp(-|w/w_sc|^2)                (E5)
                let rest = b.theta_s * around.breakaway_factor - b.theta_c;
                let g = level_factor
                    * (b.theta_c
                        + rest
                            * stribeck(seen / b.height_m * cos2 / b.w_sc, around.exponent_minus_2));
                // theta' = w - sigma |w| theta / g                                  (E3)
                let rate = w - b.sigma * w.abs() * z / g;
                let dragged = dragged / b.height_m * cos2;
                // mu = (sigma0 theta + sigma1 theta' + sigma2 w) cos^2              (E7)
                (
                    rate,
                    (force_factor * (b.sigma0 * z + b.sigma1 * rate)
                        + viscous_factor * b.sigma2 * dragged)
                        * cos2,
                )
            }
            Self::Lugre(d) => {
                // z' = v - s0 |v| z / g,  F = s0 z + s1 z' + s2 v
                let g = level_factor * d.level(seen, around);
                let rate = v - d.stiffness * v.abs() * z / g;
                (
                    rate,
                    force_factor * (d.stiffness * z + d.damping * rate)
                        + viscous_factor * d.viscous * dragged,
                )
            }
            Self::Dahl(d) => {
                // z' = v (1 - s0 z sgn v / F_c),  F = s0 z
                let rate = v - d.stiffness * v.abs() * z / (level_factor * d.coulomb);
                (rate, force_factor * d.stiffness * z)
            }
            Self::Stribeck(d) => {
                let level = level_factor * d.level(seen, around);
                (0.0, sign(v) * level + viscous_factor * d.viscous * dragged)
            }
            Self::CoulombViscous(d) => (
                0.0,
                sign(v) * level_factor * d.coulomb + viscous_factor * d.viscous * dragged,
            ),
        }
    }

    /// What a measurement can tell of the law: its parameters without the redundant scale of the bristle's sigma.
    pub fn free_parameters(&self) -> Vec<f64> {
        match self {
            Self::AsymmetricBristle(b) => {
                let mut free = vec![b.theta_c, b.theta_s, b.w_sc, b.sigma0, b.sigma1, b.sigma2];
                if b.theta0_rad != 0.0 {
                    free.push(b.theta0_rad);
                }
                free
            }
            Self::Lugre(d) => {
                vec![
                    d.stiffness,
                    d.damping,
                    d.viscous,
                    d.coulomb,
                    d.breakaway,
                    d.stribeck_speed,
                ]
            }
            Self::Dahl(d) => vec![d.coulomb, d.stiffness],
            Self::Stribeck(d) => vec![d.coulomb, d.breakaway, d.stribeck_speed, d.viscous],
            Self::CoulombViscous(d) => vec![d.coulomb, d.viscous],
        }
    }

    /// The law with its free parameters replaced, in the order of [`Law::free_parameters`].
    #[must_use]
    pub fn with_free_parameters(mut self, free: &[f64]) -> Self {
        match &mut self {
            Self::AsymmetricBristle(b) => {
                (b.theta_c, b.theta_s, b.w_sc) = (free[0], free[1], free[2]);
                (b.sigma0, b.sigma1, b.sigma2) = (free[3], free[4], free[5]);
                b.theta0_rad = free.get(6).copied().unwrap_or(0.0);
            }
            Self::Lugre(d) => {
                (d.stiffness, d.damping, d.viscous) = (free[0], free[1], free[2]);
                (d.coulomb, d.breakaway, d.stribeck_speed) = (free[3], free[4], free[5]);
            }
            Self::Dahl(d) => (d.coulomb, d.stiffness) = (free[0], free[1]),
            Self::Stribeck(d) => {
                (d.coulomb, d.breakaway, d.stribeck_speed, d.viscous) =
                    (free[0], free[1], free[2], free[3]);
            }
            Self::CoulombViscous(d) => (d.coulomb, d.viscous) = (free[0], free[1]),
        }
        self
    }

    /// Coefficient after long sliding forward at `v` > 0, by relaxation of the inner state.
    pub fn steady_coefficient(&self, v: f64) -> f64 {
        // The inner state is steady where its rate vanishes: z = g/sigma, reached by a damped fixed-point iteration.
        let mut z = 0.0;
        let step = 0.1 * self.state_scale()
            / self
                .evaluate(0.0, v, &Surroundings::PLAIN)
                .0
                .abs()
                .max(1e-12);
        for _ in 0..400 {
            z += step * self.evaluate(z, v, &Surroundings::PLAIN).0;
        }
        self.evaluate(z, v, &Surroundings::PLAIN).1
    }

    /// Scale of the inner state, for tolerances: the deflection at which friction is fully built up.
    pub fn state_scale(&self) -> f64 {
        match self {
            Self::AsymmetricBristle(b) => b.theta_c / b.sigma,
            Self::Lugre(d) | Self::Dahl(d) => d.coulomb / d.stiffness,
            Self::Stribeck(_) | Self::CoulombViscous(_) => 1.0,
        }
    }
}

impl Deflection {
    fn level(&self, v: f64, around: &Surroundings) -> f64 {
        self.coulomb
            + (self.breakaway * around.breakaway_factor - self.coulomb)
                * stribeck(v / self.stribeck_speed, around.exponent_minus_2)
    }
}

fn sign(v: f64) -> f64 {
    if v == 0.0 { 0.0 } else { v.signum() }
}

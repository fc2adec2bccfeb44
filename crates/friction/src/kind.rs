//! The seven laws by name.

use crate::{Law, ParameterSpec, Scalar, laws};

/// A law of friction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum LawKind {
    /// Coulomb friction and linear viscosity.
    CoulombViscous,
    /// Coulomb friction with a Stribeck curve and linear viscosity.
    Stribeck,
    /// Dahl's law (1968, 1977), exponent one.
    Dahl,
    /// LuGre (Canudas de Wit, Olsson, Astrom, Lischinsky 1995).
    Lugre,
    /// LuGre in its tyre form: a coefficient, with Stribeck exponent 1/2.
    LugreTyre,
    /// Bristles that stand upright: E1-E7 with theta0 = 0.
    SymmetricBristle,
    /// Leaning bristles: E1-E7.
    AsymmetricBristle,
}

/// Why a law could not be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LawError {
    /// No law of that name.
    #[error(
        "unknown law `{0}`; laws: coulomb-viscous, stribeck, dahl, lugre, lugre-tyre, symmetric-bristle, asymmetric-bristle"
    )]
    UnknownLaw(String),
    /// Wrong number of parameters.
    #[error("law {law} takes {expected} parameters, {found} were given")]
    Count {
        /// The law.
        law: &'static str,
        /// Parameters it takes.
        expected: usize,
        /// Parameters it was given.
        found: usize,
    },
    /// A parameter that makes no sense.
    #[error("law {law}: {name} = {value} is outside [{lower}, {upper}]")]
    OutOfBounds {
        /// The law.
        law: &'static str,
        /// The parameter.
        name: String,
        /// Its value.
        value: f64,
        /// Its lower bound.
        lower: f64,
        /// Its upper bound.
        upper: f64,
    },
    /// Bristle laws need the gap between body and substrate.
    #[error("law {0} needs the gap between body and substrate (specimen.contact_height_mm)")]
    HeightMissing(&'static str),
}

impl LawKind {
    /// All laws, the simplest first.
    pub const ALL: [LawKind; 7] = [
        LawKind::CoulombViscous,
        LawKind::Stribeck,
        LawKind::Dahl,
        LawKind::Lugre,
        LawKind::LugreTyre,
        LawKind::SymmetricBristle,
        LawKind::AsymmetricBristle,
    ];

    /// Name in files and on the command line.
    pub const fn id(self) -> &'static str {
        match self {
            LawKind::CoulombViscous => "coulomb-viscous",
            LawKind::Stribeck => "stribeck",
            LawKind::Dahl => "dahl",
            LawKind::Lugre => "lugre",
            LawKind::LugreTyre => "lugre-tyre",
            LawKind::SymmetricBristle => "symmetric-bristle",
            LawKind::AsymmetricBristle => "asymmetric-bristle",
        }
    }

    /// The law of that name.
    pub fn from_id(id: &str) -> Result<Self, LawError> {
        Self::ALL
            .into_iter()
            .find(|kind| kind.id() == id)
            .ok_or_else(|| LawError::UnknownLaw(id.to_owned()))
    }

    /// Parameters of the identifiable form, in the order that [`LawKind::build`] takes them.
    pub fn parameters(self) -> &'static [ParameterSpec] {
        match self {
            LawKind::CoulombViscous => laws::coulomb_viscous::PARAMETERS,
            LawKind::Stribeck => laws::stribeck::PARAMETERS,
            LawKind::Dahl => laws::dahl::PARAMETERS,
            LawKind::Lugre => laws::lugre::PARAMETERS,
            LawKind::LugreTyre => laws::lugre_tyre::PARAMETERS,
            LawKind::SymmetricBristle => laws::symmetric_bristle::PARAMETERS,
            LawKind::AsymmetricBristle => laws::asymmetric_bristle::PARAMETERS,
        }
    }

    /// Unit of the inner state: `rad`, `m`, or `None` for static laws.
    pub const fn state_unit(self) -> Option<&'static str> {
        match self {
            LawKind::CoulombViscous | LawKind::Stribeck => None,
            LawKind::Dahl | LawKind::Lugre | LawKind::LugreTyre => Some("m"),
            LawKind::SymmetricBristle | LawKind::AsymmetricBristle => Some("rad"),
        }
    }

    /// Whether the law has an inner state.
    pub const fn is_dynamic(self) -> bool {
        self.state_unit().is_some()
    }

    /// Whether the law is about bristles of a known height.
    pub const fn needs_height(self) -> bool {
        matches!(self, LawKind::SymmetricBristle | LawKind::AsymmetricBristle)
    }

    /// Whether the law by itself can make friction depend on direction.
    pub const fn is_directional(self) -> bool {
        matches!(self, LawKind::AsymmetricBristle)
    }

    /// The law with these parameters. `height_m` is the gap h between body and substrate, needed by bristle laws only.
    ///
    /// # Errors
    /// A wrong number of parameters, or no height where the law needs one. Bounds are not checked here (a fit may
    /// look beyond them); see [`LawKind::check`].
    pub fn build<D: Scalar>(
        self,
        parameters: &[D],
        height_m: Option<f64>,
    ) -> Result<Law<D>, LawError> {
        let expected = self.parameters().len();
        if parameters.len() != expected {
            return Err(LawError::Count {
                law: self.id(),
                expected,
                found: parameters.len(),
            });
        }
        let height = || height_m.ok_or(LawError::HeightMissing(self.id()));
        Ok(match self {
            LawKind::CoulombViscous => laws::coulomb_viscous::build(parameters),
            LawKind::Stribeck => laws::stribeck::build(parameters),
            LawKind::Dahl => laws::dahl::build(parameters),
            LawKind::Lugre => laws::lugre::build(parameters),
            LawKind::LugreTyre => laws::lugre_tyre::build(parameters),
            LawKind::SymmetricBristle => laws::symmetric_bristle::build(parameters, height()?),
            LawKind::AsymmetricBristle => laws::asymmetric_bristle::build(parameters, height()?),
        })
    }

    /// Whether parameters are finite and inside their bounds.
    ///
    /// # Errors
    /// The first one that is not, by name.
    pub fn check(self, parameters: &[f64]) -> Result<(), LawError> {
        for (spec, &value) in self.parameters().iter().zip(parameters) {
            if !spec.admits(value) {
                return Err(LawError::OutOfBounds {
                    law: self.id(),
                    name: spec.name.to_string(),
                    value,
                    lower: spec.lower,
                    upper: spec.upper,
                });
            }
        }
        Ok(())
    }
}

//! Laws of friction and normal contact: pure functions of state and speed, generic over the scalar.
//!
//! One inner state, the mean deflection of the bristles, carries all seven laws ([`LawKind`]). A [`Law`] is a law with
//! its parameters; [`integrate`] drives it along a recorded motion. Every formula is generic over [`Scalar`], so the
//! same code gives values (`f64`) and exact derivatives (dual numbers). No files, no clocks, no randomness but a
//! generator that is passed in.

mod curve;
mod ensemble;
mod gradient;
mod integrate;
mod kind;
mod law;
mod laws;
mod lift;
mod normal;
mod parameter;
mod path;
mod peak;
pub mod radau;
mod scalar;
mod stretch;

pub use curve::{Aged, Exponent, StribeckCurve};
pub use ensemble::{Ensemble, EnsembleError};
pub use gradient::Followed;
pub use integrate::{IntegrationError, Reals, Record, integrate, linear_stretches};
pub use kind::{LawError, LawKind};
pub use law::{Asymmetry, CosinePlacement, Drive, Evaluation, Law, Lean, Motion, SIGN_WIDTH};
pub use laws::paper_form;
pub use normal::Hertz;
pub use parameter::ParameterSpec;
pub use path::Path;
pub use scalar::Scalar;

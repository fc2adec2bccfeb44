//! Least squares, noise models and identifiability: knows residuals and parameters, not friction.
//!
//! Everything here works on *whitened* residuals r(p): their inner products are those of the noise's precision,
//! so that 1/2 |r|^2 is a negative log-likelihood and thresholds on it are quantiles. What is offered:
//!
//! * [`minimise`] and [`multi_start`]: bounded Levenberg-Marquardt, an [`argmin`] solver run by its executor;
//! * [`profile`] and [`profile_curve`]: likelihood profiles and the intervals that follow from them;
//! * [`identifiability`]: what the data determine at all, from the singular values of the scaled sensitivities;
//! * [`criteria`]: thresholds (t, F) and AICc; [`bootstrap`]: resampling as a diagnostic;
//! * [`noise`]: the covariance of friction records and its whitening.

mod bootstrap;
mod bounded_step;
mod bounds;
pub mod criteria;
mod identifiability;
mod levenberg_marquardt;
mod minimise;
mod multi_start;
pub mod noise;
mod profile;
mod residuals;
mod triangular;

pub use bootstrap::{Bootstrap, bootstrap};
pub use bounds::{Bounds, BoundsError, Side};
pub use identifiability::{Identifiability, RANK_TOLERANCE, Verdict, identifiability};
pub use levenberg_marquardt::{LevenbergMarquardt, Options};
pub use minimise::{Fit, Status, minimise};
pub use multi_start::{MultiStart, multi_start, spread_starts};
pub use profile::{
    Limit, Profile, ProfileOptions, ProfilePoint, profile, profile_curve, profile_interval,
};
pub use residuals::Residuals;
pub use triangular::covariance_of;

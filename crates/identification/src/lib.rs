//! Law, rig and fitting together: the parameters of a campaign and what of them can be identified.
//!
//! [`identify`] asks a [`Question`] of a campaign. Starts come from the record itself ([`features`]); parameters and noise
//! are estimated in turn; intervals follow from profile likelihoods with t quantiles, because the scatter between a few
//! runs is poorly known; what the data leave open is named. [`held_out`] is the error on runs that the fit has not
//! seen, [`compare_laws`] sets all laws side by side, [`in_paper_form`] shows the redundancy of the published parameters,
//! [`coverage`] checks that 95 % means 95 %.

mod band;
mod compare_laws;
mod coverage;
mod degrees;
mod features;
mod fit;
mod held_out;
mod identify;
mod information;
mod intervals;
mod paper_form;
mod problem;
mod quality;
mod question;
mod resampling;
mod simulate;
mod sliding;
mod starts;
mod thinning;

pub use band::{Band, Spread, prediction_band};
pub use compare_laws::{LawFit, compare_laws};
pub use coverage::{Coverage, ParameterCoverage, Simulated, Simulation, Truth, coverage};
pub use degrees::Drivers;
pub use features::{Features, features};
pub use fit::{Weighting, Work};
pub use held_out::{HeldOut, folds, held_out};
pub use identify::{Estimate, Identification, identify, identify_prepared};
pub use information::least_sd;
pub use intervals::{Interval, LEVEL};
pub use paper_form::{PaperForm, in_paper_form};
pub use quality::{LackOfFit, Quality, repeat_floor};
pub use question::{IdentificationError, Question};
pub use resampling::resample_runs;
pub use sliding::SlidingCurve;
pub use starts::starts;

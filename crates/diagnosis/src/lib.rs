//! What a simulation gets wrong in a campaign, why, and what an extended model gains.
//!
//! The order is fixed: the noise first; a gate that asks whether there is any error beyond it; where the error sits;
//! which cause of the catalogue explains it, or which set of causes the protocol cannot separate, or none; what the
//! extended model gains on runs that it has not seen; and what to measure next. [`diagnose`] gives the answer as it
//! stands in the JSON, [`diagnose_fully`] also the extended model and the curves.

mod afresh;
mod anatomy;
pub mod answer;
mod assemble;
mod bench;
mod bursts;
pub mod causes;
mod comb;
mod condense;
mod contests;
mod curves;
mod design;
mod diagnose;
mod equivalence;
mod excerpt;
mod experiment;
mod extension;
mod floor;
mod fold;
mod folds;
mod foreign;
mod forms;
mod forward;
mod gain;
mod general;
mod ground;
mod integrity;
mod intervals;
mod joint;
mod judged;
mod lateness;
mod laws;
mod left;
mod look_back;
mod marks;
mod patterns;
mod peaks;
mod periodic;
mod places;
mod prepare;
mod prior;
mod probability;
mod proposal;
mod refusal;
mod rhythm;
mod rises;
mod samples;
mod scan;
mod scatter;
mod scrambled;
mod selection;
mod settled;
mod spikes;
mod stand;
mod starts;
mod steps;
mod subset;
mod swallowed;
mod tail;
mod ties;
mod uniform;
mod valleys;
mod verdict;
mod ways;
mod weighed;
mod whole;

pub use answer::{Design, Diagnosis, Estimate, Finding, Gain, LawFit, Status};
pub use curves::Curves;
pub use design::design;
pub use diagnose::{Diagnosed, DiagnosisError, Options, diagnose, diagnose_fully};
pub use prepare::default_law;

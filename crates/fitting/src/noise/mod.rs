//! The noise of a campaign: how a healthy record scatters about a perfect model.
//!
//! For sample i of run k, at plate position x and after sliding s, the recorded force is
//!
//! ```text
//! y_i = f_i (1 + b_k + u_k(s_i) + q(x_i)) + e_i + a_k(t_i)                                 (N1)
//! b_k ~ N(0, scatter^2)                               scatter between runs, a gain a run
//! u_k : mean 0, cov u_k(s) u_k(s') = private^2 exp(-|s - s'| / length)    roughness, private to the run
//! q   : mean 0, cov q(x) q(x')     = plate^2   exp(-|x - x'| / (plate_ratio length))    roughness, fixed to the plate
//! e_i ~ N(0, sensor^2)                                sensor noise, white
//! a_k : mean 0, cov a_k(t) a_k(t') = wander^2 exp(-|t - t'| / wander_time)          the force channel's wander, sliding or not
//! ```
//!
//! with f the friction force that the model predicts. Where [`Sizes::smoothing`] is not zero both covariances are those of a
//! smoother field (N7), with a smoothing of its own for q where [`Sizes::plate_smoothing`] is not zero; `plate_ratio` is one unless the record says otherwise. Behind a filter of the channel or a resonance the record holds all but e as these show it (N5, N6, N8); a wander is slow against both. The
//! field q is the same in every run: it repeats, and no law could mend it. All sizes and the length are estimated by restricted maximum likelihood; whitening takes time linear
//! in the samples: a Kalman filter along each run for u, e and a; for q on a grid of plate nodes a banded least-squares problem of all samples
//! at once (N10), or a square-root information filter from sample to sample where innovations are asked for; a low-rank root for b.
//!
//! This module knows forces, distances and runs as plain numbers, and no friction.

mod along;
mod averaged;
mod channel;
mod context;
mod curvature;
mod estimate;
mod field;
mod frame;
mod further;
mod grid;
mod information;
mod lag;
mod panels;
mod quadratic;
mod restricted;
mod ring;
mod rotations;
mod roughness;
mod rows;
mod scatter;
mod search;
#[cfg(test)]
mod tests;
mod tiles;
mod vectors;
mod whitener;

pub use averaged::Averaged;
pub use channel::Channel;
pub use context::{Context, Sizes};
pub use estimate::{EstimateOptions, NoiseModel, Search, estimate};
pub use lag::{Lag, left_s};
pub use ring::{Ring, Spring};
pub use roughness::Roughness;
pub use scatter::{ScatterEvidence, free_gains};
pub use whitener::Whitener;

//! What smoothing leaves of the noise of a recorded velocity.
//!
//! Predictions are made along the smooth course of the recorded speeds. What is left of their noise in it is alike in all runs of one command,
//! so that neither repeats nor unseen runs know it, and sharp where friction starts. The campaign as it would have been recorded, were the
//! course z the stage's motion, with noise of the same spread drawn anew and smoothed again to z', shows how large it is:
//!
//! ```text
//! l_m = F(z'_m) - F(z),   var(u'r~) = 1 + mean_m (u'l~_m)^2                                             (M5)
//! ```
//!
//! F being the prediction, r~ and l~ residual and draws as the ground has them (whitened, the model's directions taken out), u a unit vector
//! there. Of smoothing's own error a draw shows little: z is smooth already.

use nalgebra::DMatrix;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;
use rig::Experiment;

use crate::bench::{Bench, Fitted};

/// Draws: their mean square along a direction is known to half of itself.
const DRAWS: u64 = 8;

/// The campaign as it would come out, were the motions that predictions are made from those of the stage; none where the velocities have no
/// noise.
pub(crate) fn drawn_anew(bench: &Bench<'_>) -> Vec<Experiment> {
    let experiment = &bench.experiment;
    let Some(sd_m_s) = experiment.channel_noise.velocity_m_s else {
        return Vec::new();
    };
    let draw = |seed: u64| {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        let mut campaign = bench.campaign.clone();
        for (run, course) in campaign.runs.iter_mut().zip(&experiment.runs) {
            let read = |z: &f64| {
                let noise: f64 = StandardNormal.sample(&mut generator);
                if *z == 0.0 { 0.0 } else { z + sd_m_s * noise }
            };
            run.velocity_m_s = course.velocity_m_s.iter().map(read).collect();
        }
        let mut drawn = Experiment::new(&campaign).ok()?.moving_as(experiment);
        for (run, own) in drawn.runs.iter_mut().zip(&experiment.runs) {
            run.take_past_of(own);
        }
        // Noise that is not seen in a draw would be in the motion there.
        (drawn.channel_noise.velocity_m_s.is_some()).then_some(drawn)
    };
    let drawn: Vec<Option<Experiment>> = (0..DRAWS).into_par_iter().map(draw).collect();
    drawn.into_iter().flatten().collect()
}

/// l of (M5) as columns, all samples x draws, N.
pub(crate) fn left(bench: &Bench<'_>, fitted: &Fitted) -> DMatrix<f64> {
    let drawn = bench.redrawn();
    let columns: Vec<Vec<f64>> = drawn
        .par_iter()
        .map(|experiment| {
            let there = fitted.model.predict(experiment, &fitted.parameters);
            let both = there.iter().zip(&fitted.prediction);
            both.map(|(a, b)| a - b).collect()
        })
        .collect();
    let finite = |column: &&Vec<f64>| column.iter().all(|x| x.is_finite());
    let columns: Vec<&Vec<f64>> = columns.iter().filter(finite).collect();
    DMatrix::from_fn(fitted.prediction.len(), columns.len(), |i, j| columns[j][i])
}

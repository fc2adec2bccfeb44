//! Campaigns as the model with its noise would record them: to check intervals, never to stand for data.
//!
//! y = F (1 + b + u + q) + e as in `fitting::noise`: gain of the run, roughness private to the run and fixed to the
//! plate (both drawn exactly at the samples, see `fitting::noise`), white sensor noise.

use campaign::{Campaign, Provenance};
use fitting::noise::{Roughness, Sizes};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rig::Experiment;

fn draw(generator: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(generator)
}

/// A path of roughness of unit variance at increasing places.
fn path(places: &[f64], roughness: Roughness, generator: &mut ChaCha8Rng) -> Vec<f64> {
    roughness.path(places, || draw(generator))
}

/// The campaign with its forces replaced by `force_n` under fresh noise.
pub(crate) fn with_fresh_noise(
    campaign: &Campaign,
    experiment: &Experiment,
    force_n: &[f64],
    sizes: &Sizes,
    generator: &mut ChaCha8Rng,
) -> Campaign {
    let places: Vec<f64> = experiment
        .runs
        .iter()
        .flat_map(|run| run.position_m.iter().copied())
        .collect();
    let mut order: Vec<usize> = (0..places.len()).collect();
    order.sort_by(|&a, &b| places[a].total_cmp(&places[b]).then(a.cmp(&b)));
    let sorted: Vec<f64> = order.iter().map(|&i| places[i]).collect();
    let mut plate = vec![0.0; places.len()];
    for (&i, value) in order
        .iter()
        .zip(path(&sorted, Roughness::of_plate(sizes), generator))
    {
        plate[i] = value;
    }
    let mut fresh = campaign.clone();
    fresh.provenance = Provenance::Synthetic;
    for (run, motion) in fresh.runs.iter_mut().zip(&experiment.runs) {
        let gain = sizes.scatter * draw(generator);
        let private = path(&motion.distance_m, Roughness::private(sizes), generator);
        for (k, i) in motion.samples.clone().enumerate() {
            let factor = 1.0 + gain + sizes.private * private[k] + sizes.plate * plate[i];
            run.force_n[k] = force_n[i] * factor + sizes.sensor * draw(generator);
        }
    }
    fresh
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    /// Variance one and the correlation of (N7) at one length: exp(-1) without smoothing.
    #[test]
    fn paths_have_the_stated_covariance() {
        for smoothing in [0.0_f64, 0.6] {
            let sizes = Sizes {
                private: 1.0,
                smoothing,
                ..Sizes::NONE
            };
            let mut generator = ChaCha8Rng::seed_from_u64(3);
            let places: Vec<f64> = (0..60_000).map(|i| 0.5 * f64::from(i)).collect();
            let x = path(&places, Roughness::private(&sizes), &mut generator);
            let n = x.len() as f64;
            let variance = x.iter().map(|a| a * a).sum::<f64>() / n;
            let one_length = x.iter().zip(&x[2..]).map(|(a, b)| a * b).sum::<f64>() / n;
            let fast = if smoothing > 0.0 {
                (-1.0 / smoothing).exp()
            } else {
                0.0
            };
            let stated = ((-1.0_f64).exp() - smoothing * fast) / (1.0 - smoothing);
            assert!((variance - 1.0).abs() < 0.05, "{variance}");
            assert!((one_length - stated).abs() < 0.03, "{one_length} {stated}");
        }
    }
}

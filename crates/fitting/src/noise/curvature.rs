//! The curvature that -2 log likelihood may be expected to have over the coordinates of a search.
//!
//! Where a record is nearly stationary its frequencies are independent. With m passes over every place their mean and their m - 1
//! differences are, with the spectra
//!
//! ```text
//! S1 = S2 + m f^2 plate^2 R_p,   S2 = sensor^2 + wander^2 A + f^2 private^2 R                          (N9)
//! d^2 (-2 log L) / da db  ~  sum_i mean_w [ g1_a g1_b / m + g2_a g2_b (m - 1) / m ],   g = d log S / d.
//! ```
//!
//! (Whittle's likelihood and its Fisher information), R the spectrum of unit roughness passed in steps as long as at sample i, A that of a unit wander. What the mean
//! takes and where nodes lie is not in it: it is near enough for a first step to be of the right length in every direction, and costs
//! less than a tenth of one value of the likelihood.

use nalgebra::{DMatrix, DVector};

use super::context::{Context, Sizes};
use super::roughness::Roughness;

/// Samples that stand for all, evenly chosen.
const SAMPLES: usize = 64;
/// Frequencies.
const FREQUENCIES: usize = 24;
/// Step of the differences in a coordinate.
const STEP: f64 = 1e-3;
/// Curvature of a coordinate that no spectrum shows.
const LEAST: f64 = 1.0;
/// Shortest way between two samples, in correlation lengths: a rig at rest shows no roughness.
const AT_REST: f64 = 1e-9;

/// A sample: its force, and way and time since the one before.
#[derive(Clone)]
struct Sampled {
    force: f64,
    way: f64,
    step_s: f64,
}

/// What the spectra depend on beside the sizes.
pub(super) struct Spectra {
    samples: Vec<Sampled>,
    /// How many samples each of them stands for.
    each: f64,
    /// Passes over a place, in the mean.
    passes: f64,
}

impl Spectra {
    pub(super) fn of(context: &Context) -> Self {
        let (lo, hi) = context.extent();
        let slid = |run: &std::ops::Range<usize>| {
            context.sliding[run.end - 1] - context.sliding[run.start]
        };
        let all: f64 = context.runs.iter().map(slid).sum();
        let inner = context
            .runs
            .iter()
            .flat_map(|run| run.start + 1..run.end)
            .step_by((context.samples() / SAMPLES).max(1));
        let samples: Vec<Sampled> = inner
            .map(|i| Sampled {
                force: context.scale[i],
                way: context.sliding[i] - context.sliding[i - 1],
                step_s: context.steps_s.get(i).copied().unwrap_or_default(),
            })
            .collect();
        Self {
            each: context.samples() as f64 / samples.len().max(1) as f64,
            passes: (all / (hi - lo).max(1e-12)).max(1.0),
            samples,
        }
    }

    /// The curvature (N9) at `x`, a point that stands for these sizes; `None` where it is not finite.
    pub(super) fn curvature(
        &self,
        sizes: impl Fn(&[f64]) -> Sizes,
        x: &[f64],
    ) -> Option<DMatrix<f64>> {
        let here = self.logarithms(&sizes(x));
        let slopes: Vec<DVector<f64>> = (0..x.len())
            .map(|k| {
                let mut beside = x.to_vec();
                beside[k] += STEP;
                (self.logarithms(&sizes(&beside)) - &here) / STEP
            })
            .collect();
        let least = DMatrix::identity(x.len(), x.len()) * LEAST;
        let slopes = DMatrix::from_columns(&slopes);
        let curvature = slopes.tr_mul(&slopes) + least;
        curvature.iter().all(|c| c.is_finite()).then_some(curvature)
    }

    /// log S1 and log S2 at each frequency of each sample, times the root of the number of values that they stand for.
    fn logarithms(&self, sizes: &Sizes) -> DVector<f64> {
        let (private, plate) = (Roughness::private(sizes), Roughness::of_plate(sizes));
        let each = self.each / FREQUENCIES as f64;
        let weights = [
            (each / self.passes).sqrt(),
            (each * (1.0 - 1.0 / self.passes)).sqrt(),
        ];
        let mut out = Vec::with_capacity(2 * FREQUENCIES * self.samples.len());
        for &Sampled { force, way, step_s } in &self.samples {
            let fading = (-step_s / sizes.wander_time_s).exp();
            let scaled = |size: f64| (force * size).powi(2);
            let (own, shared) = (scaled(sizes.private), scaled(sizes.plate));
            for k in 0..FREQUENCIES {
                let w = std::f64::consts::PI * (k as f64 + 0.5) / FREQUENCIES as f64;
                let channel = sizes.sensor.powi(2) + sizes.wander.powi(2) * wandering(fading, w);
                let apart = channel + own * spectrum(private, way, w);
                let together = apart + self.passes * shared * spectrum(plate, way, w);
                out.push(weights[0] * together.max(f64::MIN_POSITIVE).ln());
                out.push(weights[1] * apart.max(f64::MIN_POSITIVE).ln());
            }
        }
        DVector::from_vec(out)
    }
}

/// Power of a unit wander at w radians a sample, of which such a share is left after a sample; the mean over all w is one.
fn wandering(fading: f64, w: f64) -> f64 {
    (1.0 - fading * fading) / (1.0 - 2.0 * fading * w.cos() + fading * fading)
}

/// Power of unit roughness at w radians a sample, passed in steps of this way; the mean over all w is one.
fn spectrum(roughness: Roughness, way: f64, w: f64) -> f64 {
    let [a, b] = roughness.decays(way.max(AT_REST * roughness.length()));
    let power = |decay: f64| 1.0 - 2.0 * decay * w.cos() + decay * decay;
    let variance = (1.0 + a * b) / ((1.0 - a * b) * (1.0 - a * a) * (1.0 - b * b));
    1.0 / (variance * power(a) * power(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZES: Sizes = Sizes {
        sensor: 0.0,
        private: 0.01,
        plate: 0.0,
        length: 2e-3,
        ..Sizes::NONE
    };

    /// The spectrum's mean over all frequencies is the variance, one, exponential or smooth.
    #[test]
    fn the_power_of_unit_roughness_is_one() {
        for smoothing in [0.0, 0.4] {
            let roughness = Roughness::private(&Sizes { smoothing, ..SIZES });
            let at = |k: usize| {
                let w = std::f64::consts::PI * (k as f64 + 0.5) / 4000.0;
                spectrum(roughness, 5e-4, w)
            };
            let mean = (0..4000).map(at).sum::<f64>() / 4000.0;
            assert!((mean - 1.0).abs() < 1e-9, "{mean}");
        }
    }

    /// -2 log likelihood of n samples of white noise is 2 n log s + sum r^2 / s^2, whose curvature over log s is 4 n; nothing tells of the
    /// roughness there.
    #[test]
    fn the_curvature_of_white_noise_is_known() {
        let spectra = Spectra {
            samples: vec![
                Sampled {
                    force: 0.0,
                    way: 1e-4,
                    step_s: 0.01
                };
                10
            ],
            each: 50.0,
            passes: 3.0,
        };
        let sizes = |x: &[f64]| Sizes {
            sensor: x[0].exp(),
            private: x[1].exp(),
            ..SIZES
        };
        let curvature = spectra
            .curvature(sizes, &[-3.0, -4.0])
            .expect("it is finite");
        assert!((curvature[(0, 0)] - (4.0 * 500.0 + LEAST)).abs() < 1.0);
        assert!((curvature[(1, 1)] - LEAST).abs() < 1e-9);
    }
}

//! Friction roughness: a field over a length, sampled exactly on a fine grid.
//!
//! A field r has unit variance and covariance exp(-|x - y| / l), or, without corners, exp(-(x - y)^2 / l^2). Between grid points (a small share of l apart) it is
//! interpolated by a cubic through neighbouring points, so that dynamics which feel it have a smooth right-hand side.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal, StudentT};

/// Shape of the random innovations (always of unit variance).
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Tails {
    /// Normal.
    Normal,
    /// Student t with this many degrees of freedom (above 2), scaled to unit variance.
    StudentT(f64),
}

impl Tails {
    /// One number of unit variance.
    ///
    /// # Panics
    /// If Student's degrees of freedom are not above 2.
    pub fn draw(self, generator: &mut ChaCha8Rng) -> f64 {
        match self {
            Self::Normal => StandardNormal.sample(generator),
            Self::StudentT(freedom) => {
                let t = StudentT::new(freedom).expect("degrees of freedom above 2");
                let value: f64 = t.sample(generator);
                value * ((freedom - 2.0) / freedom).sqrt()
            }
        }
    }
}

/// An independent stream of random numbers of one campaign.
pub fn stream(seed: u64, purpose: u64) -> ChaCha8Rng {
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    generator.set_stream(purpose);
    generator
}

/// A random field over [from, to] in metres (or radians).
#[derive(Clone, Debug)]
pub struct Field {
    from: f64,
    spacing: f64,
    values: Vec<f64>,
}

/// Grid points in one correlation length: on the slowest run (3 mm/s, 60 samples a second) samples are further apart
/// than points, so that every record sees the field as rough as it is.
const POINTS_A_LENGTH: f64 = 50.0;

/// How smooth a field is.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub enum Grain {
    /// An Ornstein-Uhlenbeck process: corners at every scale.
    Rough,
    /// White noise behind a Gaussian: no corners at all.
    Smooth,
}

/// r_(i+1) = rho r_i + sqrt(1 - rho^2) e_i with rho = exp(-step), the step in correlation lengths.
fn rough(count: usize, step: f64, tails: Tails, generator: &mut ChaCha8Rng) -> Vec<f64> {
    let rho = (-step).exp();
    let fresh = (1.0 - rho * rho).sqrt();
    let mut value = tails.draw(generator);
    let mut values = Vec::with_capacity(count);
    for _ in 0..count {
        values.push(value);
        value = rho * value + fresh * tails.draw(generator);
    }
    values
}

/// sum_j w_j e_(i+j) with w a Gaussian of half the correlation length, sum_j w_j^2 = 1.
fn smooth(count: usize, tails: Tails, generator: &mut ChaCha8Rng) -> Vec<f64> {
    let wide = 0.5 * POINTS_A_LENGTH;
    let reach = (4.0 * wide) as i32;
    let weights: Vec<f64> = (-reach..=reach)
        .map(|j| (-0.5 * (f64::from(j) / wide).powi(2)).exp())
        .collect();
    let size = weights.iter().map(|w| w * w).sum::<f64>().sqrt();
    let white: Vec<f64> = (0..count + weights.len())
        .map(|_| tails.draw(generator))
        .collect();
    let seen = |around: &[f64]| -> f64 { around.iter().zip(&weights).map(|(e, w)| e * w).sum() };
    white
        .windows(weights.len())
        .take(count)
        .map(|around| seen(around) / size)
        .collect()
}

impl Field {
    /// A field of unit variance whose correlation falls to 1/e over `length`, over [from, to].
    pub fn new(
        from: f64,
        to: f64,
        length: f64,
        (grain, tails): (Grain, Tails),
        generator: &mut ChaCha8Rng,
    ) -> Self {
        let spacing = length / POINTS_A_LENGTH;
        let count = ((to - from) / spacing).ceil() as usize + 4;
        let values = match grain {
            Grain::Rough => rough(count, spacing / length, tails, generator),
            Grain::Smooth => smooth(count, tails, generator),
        };
        Self {
            from: from - spacing,
            spacing,
            values,
        }
    }

    /// Value at `x`; beyond the ends the end values hold.
    pub fn at(&self, x: f64) -> f64 {
        let place =
            ((x - self.from) / self.spacing).clamp(1.0, self.values.len() as f64 - 2.000_001);
        let i = place as usize;
        let u = place - i as f64;
        let [a, b, c, d] = [
            self.values[i - 1],
            self.values[i],
            self.values[i + 1],
            self.values[i + 2],
        ];
        // Catmull-Rom cubic through b and c.
        b + 0.5
            * u
            * ((c - a) + u * ((2.0 * a - 5.0 * b + 4.0 * c - d) + u * (3.0 * (b - c) + d - a)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Variance one and correlation exp(-1) one length apart, over a field of 4000 lengths.
    #[test]
    fn field_has_the_stated_variance_and_correlation() {
        for grain in [Grain::Rough, Grain::Smooth] {
            has_them(&Field::new(
                0.0,
                4000.0,
                1.0,
                (grain, Tails::Normal),
                &mut stream(5, 0),
            ));
        }
    }

    fn has_them(field: &Field) {
        let n = 39_000;
        let (mut variance, mut product) = (0.0, 0.0);
        for i in 0..n {
            let x = i as f64 * 0.1;
            variance += field.at(x).powi(2) / n as f64;
            product += field.at(x) * field.at(x + 1.0) / n as f64;
        }
        assert!((variance - 1.0).abs() < 0.12, "variance {variance}");
        assert!(
            (product / variance - (-1.0_f64).exp()).abs() < 0.06,
            "correlation {}",
            product / variance
        );
    }
}

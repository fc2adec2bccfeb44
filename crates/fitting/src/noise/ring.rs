//! A mass on a spring between what makes the noise and what records it.
//!
//! Roughness strikes the specimen; on a cord the record shows it through the resonance of m u' + (d + s) u + q = P, C q' = u,
//! y = q + d u, with s what friction itself adds to the damping. The noise has the covariance of (N1) only after that resonance is
//! taken out again: at the samples, with D's roots the sampled poles,
//!
//! ```text
//! z = L y,   L = lead D(B) / M(B),   D = 1 - (p1 + p2) B + p1 p2 B^2,   B the sample before                 (N5)
//! ```
//!
//! Roughness goes on between the samples, and what the spring lets through is folded by sampling: for roughness of unit size that is
//! x lengths further with each sample, (1 - exp(-x) B) D y is a moving average of white noise. M is its root inside the unit circle,
//! and lead makes z what (N1) says of a record without a spring, of unit size and with neighbours alike to exp(-x).

use nalgebra::{Matrix3, RowVector3, Vector3};

/// The resonance of one run.
#[derive(Clone, Debug, PartialEq)]
pub struct Ring {
    /// p1 + p2.
    sum: f64,
    /// p1 p2.
    product: f64,
    /// L over the lengths that a sample is further, see [`FURTHER`].
    table: Vec<Coefficients>,
    /// How late z is, s.
    left_s: f64,
}

/// What L is at a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Coefficients {
    pub(super) lead: f64,
    /// M without its leading one.
    pub(super) zeros: [f64; 2],
}

/// Lengths of roughness that a sample is further, least and most: what lies beyond hardly changes. The table has two a doubling.
pub(super) const FURTHER: (f64, f64) = (0.02, 32.0);
const A_DOUBLING: f64 = 2.0;

/// Numbers of one mass on a spring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spring {
    /// Mass m, kg.
    pub mass_kg: f64,
    /// Compliance C, m/N.
    pub compliance_m_n: f64,
    /// Damping d of what holds the mass, N s/m: its force is recorded.
    pub damping_n_s_m: f64,
    /// Damping s by friction, N s/m: its force is not.
    pub friction_n_s_m: f64,
}

/// Poles below this are gone at the next sample.
const GONE: f64 = 1e-3;
/// Steps a sample beyond which a resonance is no resonance.
const FASTEST: f64 = 1e6;

impl Ring {
    /// The resonance as seen every `step_s`. `None` where there is none, or one that is over at the next sample.
    pub fn new(spring: &Spring, step_s: f64) -> Option<Self> {
        let Spring {
            mass_kg: m,
            compliance_m_n: c,
            damping_n_s_m: d,
            friction_n_s_m: s,
        } = *spring;
        let damping = (d + s).max(0.0);
        let (turn, decay) = (step_s / (m * c).sqrt(), damping * step_s / m);
        if !(turn > 0.0 && turn + decay < FASTEST) {
            return None;
        }
        // time in samples, u in units that make q' = turn w:  w' = turn (P - q) - decay w,  P' = -x P + noise,  y = q + read w
        let motion = |x: f64| Matrix3::new(0.0, turn, 0.0, -turn, -decay, turn, 0.0, 0.0, -x);
        let read = RowVector3::new(1.0, d * (c / m).sqrt(), 0.0);
        let (step, _) = over_a_sample(&motion(0.0));
        let sum = step[(0, 0)] + step[(1, 1)];
        let product = step[(0, 0)] * step[(1, 1)] - step[(0, 1)] * step[(1, 0)];
        if sum.abs().max(product.abs()) < GONE {
            return None;
        }
        let entries = ((FURTHER.1 / FURTHER.0).log2() * A_DOUBLING).ceil() as usize;
        let table: Vec<Coefficients> = (0..=entries)
            .map(|k| {
                let x = FURTHER.0 * (k as f64 / A_DOUBLING).exp2();
                let (step, noise) = over_a_sample(&motion(x));
                let alike = (-x).exp();
                let ar = [-alike - sum, alike * sum + product];
                let (zeros, variance) = moving_average(&step, &(noise * (2.0 * x)), &read, ar);
                Coefficients {
                    lead: ((1.0 - alike * alike) / variance).sqrt(),
                    zeros,
                }
            })
            .collect();
        let late = |first: f64, second: f64| (first + 2.0 * second) / (1.0 + first + second);
        let near = table[0].zeros;
        let samples = late(-sum, product) - late(near[0], near[1]);
        let ring = Self {
            sum,
            product,
            left_s: samples * step_s + s.max(-d) * c,
            table,
        };
        let finite = ring.table.iter().all(|of| of.lead.is_finite());
        (finite && ring.left_s.is_finite()).then_some(ring)
    }

    /// How late z tells of the force P, s.
    pub fn left_s(&self) -> f64 {
        self.left_s
    }

    /// L where a sample is `further` lengths of the roughness beyond the one before.
    pub(super) fn at(&self, further: f64) -> Coefficients {
        let place = (further.clamp(FURTHER.0, FURTHER.1) / FURTHER.0).log2() * A_DOUBLING;
        let k = (place as usize).min(self.table.len() - 2);
        let (share, [a, b]) = (place - k as f64, [self.table[k], self.table[k + 1]]);
        let between = |a: f64, b: f64| a + share * (b - a);
        // Both polynomials have their roots inside the unit circle, and so has what lies between them.
        Coefficients {
            lead: between(a.lead, b.lead),
            zeros: [
                between(a.zeros[0], b.zeros[0]),
                between(a.zeros[1], b.zeros[1]),
            ],
        }
    }

    /// D without its leading one.
    pub(super) fn poles(&self) -> [f64; 2] {
        [-self.sum, self.product]
    }
}

/// exp(A) and the covariance that unit white noise on the last state adds within one sample, by doubling a short step.
fn over_a_sample(a: &Matrix3<f64>) -> (Matrix3<f64>, Matrix3<f64>) {
    /// Size of the short step: what is left out of its series is below 1e-6 of the covariance.
    const SHORT: f64 = 1e-3;
    const ORDER: usize = 4;
    let doublings = (a.norm() / SHORT).log2().ceil().max(0.0) as i32;
    let h = 0.5_f64.powi(doublings);
    // exp(A h) = sum (A h)^i / i!;  covariance = sum_ij h^(i + j + 1) / (i! j! (i + j + 1)) A^i b (A^j b)'
    let mut power = Matrix3::identity();
    let mut step = Matrix3::zeros();
    let mut terms: Vec<Vector3<f64>> = Vec::new();
    for i in 0..=ORDER {
        if i > 0 {
            power = power * a * (h / i as f64);
        }
        step += power;
        terms.push(power.column(2).into_owned());
    }
    let mut noise = Matrix3::zeros();
    for (i, x) in terms.iter().enumerate() {
        for (j, y) in terms.iter().enumerate() {
            noise += x * y.transpose() * (h / (i + j + 1) as f64);
        }
    }
    for _ in 0..doublings {
        noise += step * noise * step.transpose();
        step *= step;
    }
    (step, noise)
}

/// The moving average that (1 - alike B) D y is: its coefficients after the leading one and the variance of its noise. Of an
/// observation `read` of states that move by `step` and `noise`, with the first two coefficients of (1 - alike B) D.
fn moving_average(
    step: &Matrix3<f64>,
    noise: &Matrix3<f64>,
    read: &RowVector3<f64>,
    ar: [f64; 2],
) -> ([f64; 2], f64) {
    let first = read * step + read * ar[0];
    let second = read * step * step + read * step * ar[0] + read * ar[1];
    let of = [*read, first, second];
    let covariance = |lag: usize| -> f64 {
        let pairs = of.iter().zip(&of[lag..]);
        pairs.map(|(a, b)| (a * noise * b.transpose())[0]).sum()
    };
    let c = [covariance(0), covariance(1), covariance(2)];
    // The innovations of a moving average: the last coefficients of ever longer predictions.
    let (mut theta, mut variance) = ([0.0; 2], [c[0]; 2]);
    for _ in 0..2000 {
        let second = c[2] / variance[1];
        let first = (c[1] - second * theta[0] * variance[1]) / variance[0];
        let next = c[0] - first * first * variance[0] - second * second * variance[1];
        let change = (first - theta[0]).abs() + (second - theta[1]).abs();
        theta = [first, second];
        variance = [next, variance[0]];
        if change < 1e-14 {
            break;
        }
    }
    (theta, variance[0])
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use super::super::channel::Channel;
    use super::super::tests::assert_is_rough;
    use super::*;

    const SPRING: Spring = Spring {
        mass_kg: 0.2,
        compliance_m_n: 1e-3,
        damping_n_s_m: 3.0,
        friction_n_s_m: 0.5,
    };

    /// The tension of a spring that a force pulls, at samples, by small steps.
    fn tension(spring: &Spring, step_s: f64, force: &mut dyn FnMut(f64) -> f64) -> Vec<f64> {
        const FINE: usize = 800;
        let (mut q, mut u) = (force(0.0), 0.0);
        let mut out = Vec::new();
        for i in 0..4000 {
            out.push(q + spring.damping_n_s_m * u);
            for k in 0..FINE {
                let h = step_s / FINE as f64;
                let p = force((i * FINE + k) as f64 * h);
                let damping = spring.damping_n_s_m + spring.friction_n_s_m;
                u += h * (p - q - damping * u) / spring.mass_kg;
                q += h * u / spring.compliance_m_n;
            }
        }
        out
    }

    /// The record of one run, `further` lengths a sample, without the spring.
    fn taken_out(ring: Ring, mut record: Vec<f64>, further: f64) -> Vec<f64> {
        let run = 0..record.len();
        let sliding: Vec<f64> = run.clone().map(|i| i as f64 * further).collect();
        let channel = Channel {
            rings: vec![(run, ring)],
            ..Channel::default()
        };
        channel.undone(&sliding, 1.0).take_out(&mut record);
        record
    }

    #[test]
    fn a_struck_mass_on_a_spring_becomes_the_stroke_again() {
        let step = 1.0 / 60.0;
        let mut bump = |t: f64| (-((t - 1.0) / 0.05).powi(2)).exp();
        let record = tension(&SPRING, step, &mut bump);
        let ring = Ring::new(&SPRING, step).expect("slow enough");
        let left_s = ring.left_s();
        let back = taken_out(ring, record.clone(), 0.0);
        // the stroke is over at sample 75: what rings on is taken out, and what is left is as late as it says
        let after = |x: &[f64]| x[85..].iter().map(|v| v * v).sum::<f64>().sqrt();
        assert!(after(&back) < 0.03 * after(&record));
        let at = |x: f64| bump(x * step - left_s);
        let worst = (0..200).map(|i| (back[i] - at(i as f64)).abs());
        assert!(worst.fold(0.0, f64::max) < 0.06);
    }

    /// Roughness that struck a mass on a spring is roughness again: of its size, and neighbours as alike as they were. The resonance
    /// lies below, near, and above half of the sampling rate; lengths are longer and shorter than a sample's way.
    #[test]
    fn roughness_behind_a_spring_becomes_roughness_again() {
        for (rate, further) in [
            (60.0, 0.1),
            (60.0, 1.0),
            (24.0, 0.3),
            (24.0, 4.0),
            (17.0, 1.0),
        ] {
            let step = 1.0 / rate;
            let mut rng = ChaCha8Rng::seed_from_u64(5);
            let alike = (-further / 800.0_f64).exp();
            let mut rough = 0.0;
            let mut force = |_: f64| {
                let noise: f64 = StandardNormal.sample(&mut rng);
                rough = alike * rough + (1.0 - alike * alike).sqrt() * noise;
                rough
            };
            let record = tension(&SPRING, step, &mut force);
            let ring = Ring::new(&SPRING, step).expect("visible");
            let back = taken_out(ring, record, further);
            // 3950 numbers: 2.3 % for the variance, 1.6 % for the correlations
            assert_is_rough(&back, further, (0.09, 0.06), &format!("{rate}"));
        }
    }

    /// For a light undamped mass the moving average is known: sampled walks summed twice, 1 + 26 B + 66 B^2 + 26 B^3 + B^4.
    #[test]
    fn a_soft_spring_has_the_zeros_of_a_walk_summed_twice() {
        let soft = Spring {
            mass_kg: 1.0,
            compliance_m_n: 1.0,
            damping_n_s_m: 0.0,
            friction_n_s_m: 0.0,
        };
        let zeros = Ring::new(&soft, 0.01).expect("slow enough").at(0.0).zeros;
        // (B + g1)(B + g2) with g1 = 0.430575, g2 = 0.043096
        let (first, second) = (0.430_575 + 0.043_096, 0.430_575 * 0.043_096);
        assert!((zeros[0] - first).abs() < 2e-3, "{zeros:?}");
        assert!((zeros[1] - second).abs() < 2e-3, "{zeros:?}");
    }

    #[test]
    fn no_spring_or_one_too_fast_is_no_ring() {
        let with = |mass_kg, compliance_m_n| {
            let spring = Spring {
                mass_kg,
                compliance_m_n,
                ..SPRING
            };
            Ring::new(&spring, 0.01)
        };
        assert_eq!(with(0.2, 0.0), None);
        assert_eq!(with(0.0, 1e-3), None);
        assert_eq!(with(1e-4, 1e-6), None);
    }
}

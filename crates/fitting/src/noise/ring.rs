//! A mass on a spring between what makes the noise and what records it.
//!
//! Roughness strikes the specimen; on a cord the record shows it through the resonance of m u' + (d + s) u + q = P, C q' = u,
//! y = q + d u, with s what friction itself adds to the damping. The noise has the covariance of (N1) only after that resonance is
//! taken out again: at the samples, with D's roots the sampled poles,
//!
//! ```text
//! z = L y,   L = [D(B) / D(1)] [M(1) / M(B)],   D = 1 - (p1 + p2) B + p1 p2 B^2,   B the sample before      (N5)
//! ```
//!
//! Roughness goes on between the samples and is folded by sampling. M is what makes z that walk again where P is a random walk (the
//! short-range limit of roughness): (1 - B) D y is then a moving average of white noise, M its root inside the unit circle.

use nalgebra::{Matrix3, RowVector3, Vector3};

/// The resonance of one run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ring {
    /// p1 + p2.
    sum: f64,
    /// p1 p2.
    product: f64,
    /// M without its leading one.
    zeros: [f64; 2],
    /// L's first coefficient.
    lead: f64,
    /// How late z is, s.
    left_s: f64,
}

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
        // time in samples, u in units that make q' = turn w:  w' = turn (P - q) - decay w,  y = q + read w
        let motion = Matrix3::new(0.0, turn, 0.0, -turn, -decay, turn, 0.0, 0.0, 0.0);
        let read = RowVector3::new(1.0, d * (c / m).sqrt(), 0.0);
        let (step, noise) = over_a_sample(&motion);
        let sum = step[(0, 0)] + step[(1, 1)];
        let product = step[(0, 0)] * step[(1, 1)] - step[(0, 1)] * step[(1, 0)];
        if sum.abs().max(product.abs()) < GONE {
            return None;
        }
        let zeros = moving_average(&step, &noise, &read, [-1.0 - sum, sum + product]);
        let (at_one, of_zeros) = (1.0 - sum + product, 1.0 + zeros[0] + zeros[1]);
        let late = |first: f64, second: f64, all: f64| (first + 2.0 * second) / all;
        let samples = late(-sum, product, at_one) - late(zeros[0], zeros[1], of_zeros);
        let ring = Self {
            sum,
            product,
            zeros,
            lead: of_zeros / at_one,
            left_s: samples * step_s + s.max(-d) * c,
        };
        (ring.lead.is_finite() && ring.left_s.is_finite()).then_some(ring)
    }

    /// How late z tells of the force P, s.
    pub fn left_s(&self) -> f64 {
        self.left_s
    }

    /// Coefficients of L's numerator and of M, their powers of B in order.
    pub(super) fn coefficients(&self) -> ([f64; 3], [f64; 2]) {
        let lead = self.lead;
        ([lead, -lead * self.sum, lead * self.product], self.zeros)
    }

    /// log |det L| over a run of `samples`.
    pub(super) fn log_det(&self, samples: usize) -> f64 {
        samples.saturating_sub(1) as f64 * self.lead.ln()
    }

    /// L x for one run that was at rest at its first value before.
    pub(super) fn take_out(&self, run: &mut [f64]) {
        let Some(&first) = run.first() else { return };
        run.iter_mut().for_each(|x| *x -= first);
        self.filter(run.iter_mut());
        run.iter_mut().for_each(|x| *x += first);
    }

    /// L' x.
    pub(super) fn take_out_transposed(&self, run: &mut [f64]) {
        let before: f64 = run.iter().sum();
        self.filter(run.iter_mut().rev());
        let after: f64 = run.iter().sum();
        if let Some(first) = run.first_mut() {
            *first += before - after;
        }
    }

    /// L x where all was zero before.
    fn filter<'a>(&self, samples: impl Iterator<Item = &'a mut f64>) {
        let (mut x, mut y) = ([0.0; 2], [0.0; 2]);
        for sample in samples {
            let now = *sample;
            let out = self.lead * (now - self.sum * x[0] + self.product * x[1])
                - self.zeros[0] * y[0]
                - self.zeros[1] * y[1];
            x = [now, x[0]];
            y = [out, y[0]];
            *sample = out;
        }
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

/// Coefficients after the leading one of the moving average that (1 - B) D y is: of an observation `read` of states that move by
/// `step` and `noise`, with the first two coefficients of (1 - B) D.
fn moving_average(
    step: &Matrix3<f64>,
    noise: &Matrix3<f64>,
    read: &RowVector3<f64>,
    ar: [f64; 2],
) -> [f64; 2] {
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
    theta
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

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

    #[test]
    fn a_struck_mass_on_a_spring_becomes_the_stroke_again() {
        let step = 1.0 / 60.0;
        let mut bump = |t: f64| (-((t - 1.0) / 0.05).powi(2)).exp();
        let record = tension(&SPRING, step, &mut bump);
        let ring = Ring::new(&SPRING, step).expect("slow enough");
        let mut back = record.clone();
        ring.take_out(&mut back);
        // the stroke is over at sample 75: what rings on is taken out, and what is left is as late as it says
        let after = |x: &[f64]| x[85..].iter().map(|v| v * v).sum::<f64>().sqrt();
        assert!(after(&back) < 0.03 * after(&record));
        let at = |x: f64| bump(x * step - ring.left_s());
        let worst = (0..200).map(|i| (back[i] - at(i as f64)).abs());
        assert!(worst.fold(0.0, f64::max) < 0.06);
    }

    /// A walk that struck a mass on a spring is a walk again: its steps are white, of the size that they had. The resonance lies
    /// below, near, and above half of the sampling rate.
    #[test]
    fn a_walk_behind_a_spring_becomes_a_walk_again() {
        for (step, hertz) in [(1.0 / 60.0, 11.3), (1.0 / 24.0, 11.3), (1.0 / 17.0, 11.3)] {
            let mut rng = ChaCha8Rng::seed_from_u64(5);
            let mut walk = 0.0;
            let each = (step / 800.0_f64).sqrt();
            let mut force = |_: f64| {
                let noise: f64 = StandardNormal.sample(&mut rng);
                walk += each * noise;
                walk
            };
            let mut record = tension(&SPRING, step, &mut force);
            let ring = Ring::new(&SPRING, step).expect("visible");
            ring.take_out(&mut record);
            let steps: Vec<f64> = record.windows(2).map(|p| p[1] - p[0]).collect();
            let mean = |k: usize| {
                let products = steps[50..].iter().zip(&steps[50 + k..]).map(|(a, b)| a * b);
                products.sum::<f64>() / (steps.len() - 50 - k) as f64 / step
            };
            // 3950 steps: 2.3 % for the variance, 1.6 % for the correlations
            assert!((mean(0) - 1.0).abs() < 0.09, "{hertz} Hz: {}", mean(0));
            for k in 1..5 {
                assert!(mean(k).abs() < 0.06, "{hertz} Hz, {k}: {}", mean(k));
            }
        }
    }

    #[test]
    fn the_transposed_filter_is_the_transposed_matrix() {
        let ring = Ring::new(&SPRING, 1.0 / 60.0).expect("slow enough");
        let a: Vec<f64> = (0..40).map(|i| (i as f64 * 0.7).sin() + 0.3).collect();
        let b: Vec<f64> = (0..40).map(|i| (i as f64 * 1.3).cos()).collect();
        let (mut la, mut ltb) = (a.clone(), b.clone());
        ring.take_out(&mut la);
        ring.take_out_transposed(&mut ltb);
        let dot = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(p, q)| p * q).sum::<f64>();
        assert!((dot(&la, &b) - dot(&a, &ltb)).abs() < 1e-9);
        assert!((ring.log_det(3) - 2.0 * ring.lead.ln()).abs() < 1e-12);
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
        let ring = Ring::new(&soft, 0.01).expect("slow enough");
        // (B + g1)(B + g2) with g1 = 0.430575, g2 = 0.043096
        let (first, second) = (0.430_575 + 0.043_096, 0.430_575 * 0.043_096);
        assert!((ring.zeros[0] - first).abs() < 1e-3, "{:?}", ring.zeros);
        assert!((ring.zeros[1] - second).abs() < 1e-3, "{:?}", ring.zeros);
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

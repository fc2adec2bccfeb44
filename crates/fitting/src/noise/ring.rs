//! A mass on a spring between what makes the noise and what records it.
//!
//! Roughness strikes the specimen; on a cord the record shows it through the resonance of m u' + d u + q = P, C q' = u. The
//! noise is white only after that resonance is taken out again: at the samples, with p1, p2 the sampled poles,
//!
//! ```text
//! L(z) = (1 - p1/z)(1 - p2/z) / ((1 - p1)(1 - p2)) * ((1 + g) / (1 + g/z))^2,   g = 2 - sqrt(3)            (N5)
//! ```
//!
//! The squared factor stands for the zeros that sampling gives such a filter (for inputs linear between the samples). Sensor
//! noise passes no spring; it is treated as if it did, which asks too little of what lies above the resonance and is safe.

/// The resonance of one run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ring {
    /// p1 + p2.
    sum: f64,
    /// p1 p2.
    product: f64,
    /// L's first coefficient.
    lead: f64,
}

/// Zero of a sampled double integrator whose input is linear between samples.
const ZERO: f64 = 0.267_949_192_431_122_7;

impl Ring {
    /// For a mass (kg) on a spring of compliance C (m/N) with damping d (N s/m), sampled every `step_s`. `None` where there is
    /// no resonance, or one faster than the samples can show.
    pub fn new(mass_kg: f64, compliance_m_n: f64, damping_n_s_m: f64, step_s: f64) -> Option<Self> {
        let stiffness = 1.0 / (mass_kg * compliance_m_n);
        let decay = 0.5 * damping_n_s_m / mass_kg;
        let visible = stiffness.sqrt() * step_s < std::f64::consts::PI;
        if !(stiffness.is_finite() && decay.is_finite() && stiffness > 0.0 && visible) {
            return None;
        }
        let turn = stiffness - decay * decay;
        let swing = if turn >= 0.0 {
            2.0 * (-decay * step_s).exp() * (turn.sqrt() * step_s).cos()
        } else {
            let spread = (-turn).sqrt();
            (-(decay - spread) * step_s).exp() + (-(decay + spread) * step_s).exp()
        };
        let product = (-2.0 * decay * step_s).exp();
        let lead = (1.0 + ZERO).powi(2) / (1.0 - swing + product);
        Some(Self {
            sum: swing,
            product,
            lead,
        })
    }

    /// log |det L| over a run of `samples`.
    pub(super) fn log_det(&self, samples: usize) -> f64 {
        samples as f64 * self.lead.ln()
    }

    /// L x for one run, nothing having happened before it.
    pub(super) fn take_out(&self, run: &mut [f64]) {
        self.filter(run.iter_mut());
    }

    /// L' x: the same filter backwards.
    pub(super) fn take_out_transposed(&self, run: &mut [f64]) {
        self.filter(run.iter_mut().rev());
    }

    fn filter<'a>(&self, samples: impl Iterator<Item = &'a mut f64>) {
        let (mut x, mut y) = ([0.0; 2], [0.0; 2]);
        for sample in samples {
            let now = *sample;
            let out = self.lead * (now - self.sum * x[0] + self.product * x[1])
                - 2.0 * ZERO * y[0]
                - ZERO * ZERO * y[1];
            x = [now, x[0]];
            y = [out, y[0]];
            *sample = out;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_struck_mass_on_a_spring_becomes_the_stroke_again() {
        // m q'' C + d C q' + q = P with P a slow bump and then one that rings, by small steps
        let (m, c, d, step): (f64, f64, f64, f64) = (0.2, 1e-3, 3.0, 1.0 / 60.0);
        let force = |t: f64| (-((t - 1.0) / 0.05).powi(2)).exp();
        let (mut q, mut u, fine) = (0.0, 0.0, 400);
        let mut tension = Vec::new();
        for i in 0..180 {
            tension.push(q + d * u);
            for k in 0..fine {
                let h = step / fine as f64;
                let t = i as f64 * step + k as f64 * h;
                u += h * (force(t) - q - d * u) / m;
                q += h * u / c;
            }
        }
        let ring = Ring::new(m, c, d, step).expect("slow enough");
        let mut back = tension.clone();
        ring.take_out(&mut back);
        let after = |x: &[f64]| x[85..].iter().map(|v| v * v).sum::<f64>().sqrt();
        // the stroke is over at sample 75: what rings on is taken out
        assert!(
            after(&back) < 0.05 * after(&tension),
            "{} {}",
            after(&back),
            after(&tension)
        );
        assert!((ring.log_det(3) - 3.0 * ring.lead.ln()).abs() < 1e-12);
    }

    #[test]
    fn the_transposed_filter_is_the_transposed_matrix() {
        let ring = Ring::new(0.2, 1e-3, 3.0, 1.0 / 60.0).expect("slow enough");
        let a: Vec<f64> = (0..40).map(|i| (i as f64 * 0.7).sin()).collect();
        let b: Vec<f64> = (0..40).map(|i| (i as f64 * 1.3).cos()).collect();
        let (mut la, mut ltb) = (a.clone(), b.clone());
        ring.take_out(&mut la);
        ring.take_out_transposed(&mut ltb);
        let dot = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(p, q)| p * q).sum::<f64>();
        assert!((dot(&la, &b) - dot(&a, &ltb)).abs() < 1e-9);
    }

    #[test]
    fn no_spring_or_one_too_fast_is_no_ring() {
        assert_eq!(Ring::new(0.2, 0.0, 1.0, 0.01), None);
        assert_eq!(Ring::new(0.0, 1e-3, 1.0, 0.01), None);
        assert_eq!(Ring::new(0.2, 1e-9, 1.0, 0.01), None);
    }
}

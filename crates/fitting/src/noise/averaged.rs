//! Roughness in means of neighbouring samples.
//!
//! The mean of m samples, a distance d apart, of a field with correlation rho = exp(-d / length) between neighbours has
//!
//! ```text
//! v = [m (1 - rho^2) - 2 rho (1 - rho^m)] / [m (1 - rho)]^2                                    (N4)
//! ```
//!
//! times the variance of a sample. Means side by side are taken as a chain of first order with this variance, whose
//! correlation phi is such that long averages keep their variance: v m (1 + phi) / (1 - phi) = (1 + rho) / (1 - rho). For m = 1
//! that is the field itself. Neighbours of different kinds lie half of each one's own step apart.

/// What a row of a condensed record is the mean of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Averaged {
    /// Number of samples.
    pub samples: f64,
    /// Distance slid between neighbours, m (or rad).
    pub step: f64,
}

impl Averaged {
    /// Root of (N4), and by how many correlation lengths half of the row is longer for the chain than it is.
    pub(super) fn in_chain(&self, length: f64) -> (f64, f64) {
        let (m, d) = (self.samples, self.step / length);
        // Shorter rows are samples to one part in a million.
        if m <= 1.0 || m * d < 1e-6 {
            return (1.0, 0.0);
        }
        let rho = (-d).exp();
        let far = -(-d).exp_m1();
        let faded = -(-m * d).exp_m1();
        // The two terms cancel for short rows; then v = 1 - (m^2 - 1) d / 3 m to the next order.
        let variance = if m * d < 1e-3 {
            1.0 - (m * m - 1.0) * d / (3.0 * m)
        } else {
            (m * far * (1.0 + rho) - 2.0 * rho * faded) / (m * far).powi(2)
        };
        let (long, own) = ((1.0 + rho) / far, variance * m);
        let phi = (long - own) / (long + own);
        let extra = 0.5 * (-phi.max(1e-300).ln() - m * d);
        (variance.sqrt(), extra)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Variance against the sum over all pairs; long averages against the field's own.
    #[test]
    fn means_have_the_variance_of_the_sum_over_pairs() {
        for m in [1, 2, 3, 8, 16, 40] {
            for d in [1e-6_f64, 1e-4, 3e-3, 0.1, 0.7, 3.0] {
                let row = Averaged {
                    samples: f64::from(m),
                    step: d,
                };
                let (root, extra) = row.in_chain(1.0);
                let mut pairs = 0.0;
                for i in 0..m {
                    for j in 0..m {
                        pairs += (-d * f64::from(i - j).abs()).exp();
                    }
                }
                let exact = pairs / f64::from(m * m);
                assert!((root * root / exact - 1.0).abs() < 2e-5, "{m} {d}");
                let phi = (-(f64::from(m) * d + 2.0 * extra)).exp();
                let chain = root * root * f64::from(m) * (1.0 + phi) / (1.0 - phi);
                let rho = (-d).exp();
                let field = (1.0 + rho) / (1.0 - rho);
                assert!(
                    (chain / field - 1.0).abs() < 2e-3,
                    "{m} {d}: {chain} {field}"
                );
            }
        }
    }

    /// A sample is a row of one.
    #[test]
    fn one_sample_is_the_field_itself() {
        let row = Averaged {
            samples: 1.0,
            step: 0.4,
        };
        assert_eq!(row.in_chain(1.0), (1.0, 0.0));
    }
}

//! Thresholds and criteria of choice between models.

use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor, Normal, StudentsT};

/// Two-sided t quantile: P(|T| <= q) = `level` with `degrees` of freedom (not necessarily whole; infinite: normal).
///
/// A profile interval of one parameter whose noise was estimated with that many degrees uses q^2 as its threshold
/// on 2 (cost - lowest cost), which is the quantile of F(1, degrees).
pub fn t_quantile(level: f64, degrees: f64) -> f64 {
    let p = 0.5 + 0.5 * level;
    if degrees > 1e6 {
        return Normal::standard().inverse_cdf(p);
    }
    match StudentsT::new(0.0, 1.0, degrees.max(1e-3)) {
        Ok(t) => t.inverse_cdf(p),
        Err(_) => f64::INFINITY,
    }
}

/// Threshold on 2 (cost - lowest cost) for `parameters` parameters jointly: k F(k, degrees), chi-squared for infinite
/// degrees.
pub fn joint_threshold(level: f64, parameters: usize, degrees: f64) -> f64 {
    let k = parameters as f64;
    if degrees > 1e6 {
        return ChiSquared::new(k).map_or(f64::INFINITY, |d| d.inverse_cdf(level));
    }
    FisherSnedecor::new(k, degrees).map_or(f64::INFINITY, |f| k * f.inverse_cdf(level))
}

/// Akaike's criterion with the correction for few samples (Hurvich and Tsai 1989):
/// -2 log L + 2 k + 2 k (k + 1) / (n - k - 1); infinite when n <= k + 1.
pub fn aicc(log_likelihood: f64, parameters: usize, samples: usize) -> f64 {
    let (k, n) = (parameters as f64, samples as f64);
    if n <= k + 1.0 {
        return f64::INFINITY;
    }
    -2.0 * log_likelihood + 2.0 * k + 2.0 * k * (k + 1.0) / (n - k - 1.0)
}

/// Degrees of freedom of a sum of independently estimated variances (Satterthwaite 1946):
/// (sum v)^2 / sum (v^2 / degrees).
pub fn satterthwaite(parts: &[(f64, f64)]) -> f64 {
    let total: f64 = parts.iter().map(|(v, _)| v).sum();
    let spread: f64 = parts.iter().map(|(v, d)| v * v / d).sum();
    if spread > 0.0 {
        total * total / spread
    } else {
        f64::INFINITY
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// NIST/SEMATECH e-Handbook of Statistical Methods, tables 1.3.6.7.2 and 1.3.6.7.3.
    #[test]
    fn quantiles_agree_with_the_printed_tables() {
        assert!((t_quantile(0.95, 4.0) - 2.776).abs() < 5e-4);
        assert!((t_quantile(0.95, f64::INFINITY) - 1.960).abs() < 5e-4);
        assert!((joint_threshold(0.95, 2, 10.0) - 2.0 * 4.103).abs() < 2e-3);
        assert!((joint_threshold(0.95, 1, 4.0) - t_quantile(0.95, 4.0).powi(2)).abs() < 1e-6);
    }

    #[test]
    fn satterthwaite_lies_between_the_smallest_and_the_sum() {
        assert!((satterthwaite(&[(1.0, 4.0), (0.0, 100.0)]) - 4.0).abs() < 1e-12);
        assert!((satterthwaite(&[(1.0, 4.0), (1.0, 4.0)]) - 8.0).abs() < 1e-12);
        let between = satterthwaite(&[(1.0, 4.0), (0.3, 1e3)]);
        assert!(between > 4.0 && between < 1004.0);
    }

    #[test]
    fn the_correction_vanishes_with_many_samples_and_forbids_too_few() {
        assert!((aicc(-10.0, 2, 1_000_000) - 24.0).abs() < 1e-4);
        assert!(aicc(-10.0, 5, 6).is_infinite());
    }
}

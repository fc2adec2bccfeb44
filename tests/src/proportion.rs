//! Exact intervals of proportions.

use statrs::distribution::{Beta, ContinuousCDF};

/// Clopper-Pearson interval of confidence 95 % of a proportion: `hits` of `trials`.
///
/// Source: Clopper, Pearson, Biometrika 26 (1934) 404-413, by quantiles of the beta distribution.
pub fn clopper_pearson(hits: usize, trials: usize) -> (f64, f64) {
    let quantile =
        |a: f64, b: f64, p: f64| Beta::new(a, b).map_or(f64::NAN, |beta| beta.inverse_cdf(p));
    let (k, n) = (hits as f64, trials as f64);
    let low = if hits == 0 {
        0.0
    } else {
        quantile(k, n - k + 1.0, 0.025)
    };
    let high = if hits >= trials {
        1.0
    } else {
        quantile(k + 1.0, n - k, 0.975)
    };
    (low, high)
}

#[cfg(test)]
mod tests {
    use super::clopper_pearson;

    /// 0 of 300: at most 1 - 0.025^(1/300) = 1.222 %; 5 of 10: [0.1871, 0.8129] (tables of the binomial).
    #[test]
    fn known_intervals() {
        let (low, high) = clopper_pearson(0, 300);
        assert!(low == 0.0 && (high - (1.0 - 0.025_f64.powf(1.0 / 300.0))).abs() < 1e-9);
        let (low, high) = clopper_pearson(5, 10);
        assert!((low - 0.1871).abs() < 5e-5 && (high - 0.8129).abs() < 5e-5);
    }
}

//! Tail probabilities far out, where they underflow: their logarithms.

use statrs::distribution::{Continuous, ContinuousCDF, StudentsT};
use statrs::function::erf::erfc;
use statrs::function::gamma::ln_gamma;

/// log P(chi^2 with k degrees of freedom > t), accurate also where the probability underflows.
pub(crate) fn log_chi2_tail(t: f64, k: usize) -> f64 {
    if k == 0 || t.is_nan() || t <= 0.0 {
        return 0.0;
    }
    let x = 0.5 * t;
    // Q(a + 1, x) = Q(a, x) + x^a e^-x / Gamma(a + 1), from Q(1, x) = e^-x or Q(1/2, x) = erfc(sqrt x).
    let (mut a, mut log_q) = if k.is_multiple_of(2) {
        (1.0, -x)
    } else {
        (0.5, log_erfc(x.sqrt()))
    };
    while a + 0.75 < 0.5 * k as f64 {
        let term = a * x.ln() - x - ln_gamma(a + 1.0);
        log_q = log_sum(log_q, term);
        a += 1.0;
    }
    log_q.min(0.0)
}

/// log erfc(x) for x >= 0.
fn log_erfc(x: f64) -> f64 {
    if x < 20.0 {
        return erfc(x).ln();
    }
    // erfc(x) ~ exp(-x^2) / (x sqrt(pi)) (1 - 1/(2 x^2)), relative error below 1e-4 here.
    -x * x - (x * std::f64::consts::PI.sqrt()).ln() + (-0.5 / (x * x)).ln_1p()
}

/// log(exp a + exp b).
pub(crate) fn log_sum(a: f64, b: f64) -> f64 {
    let (hi, lo) = if a > b { (a, b) } else { (b, a) };
    if hi == f64::NEG_INFINITY {
        return hi;
    }
    hi + (lo - hi).exp().ln_1p()
}

/// The number of standard deviations with this two-sided tail: z with log P(|x| > z) = log_p.
pub(crate) fn equivalent_z(log_p: f64) -> f64 {
    if log_p >= 0.0 {
        return 0.0;
    }
    let (mut lo, mut hi) = (0.0, (-2.0 * log_p).sqrt() + 2.0);
    for _ in 0..80 {
        let mid = 0.5 * (lo + hi);
        if log_chi2_tail(mid * mid, 1) > log_p {
            lo = mid;
        } else {
            hi = mid;
        }
    }
    0.5 * (lo + hi)
}

/// The normal deviate with the two-sided tail of Student's t at `t` with `freedom` degrees.
pub(crate) fn normal_deviate(t: f64, freedom: f64) -> f64 {
    if freedom.is_infinite() {
        return t;
    }
    let Ok(student) = StudentsT::new(0.0, 1.0, freedom) else {
        return t;
    };
    let tail = 2.0 * student.sf(t);
    let log_tail = if tail > 1e-200 {
        tail.ln()
    } else {
        (2.0_f64).ln() + student.ln_pdf(t) + (t / freedom).ln()
    };
    equivalent_z(log_tail).min(t)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Quantiles from tables (NIST/SEMATECH e-Handbook 1.3.6.7.4).
    #[test]
    fn quantiles_of_tables() {
        for (t, k, p) in [
            (3.841, 1, 0.05),
            (5.991, 2, 0.05),
            (7.815, 3, 0.05),
            (18.307, 10, 0.05),
            (29.141, 14, 0.01),
            (52.191, 31, 0.01),
        ] {
            let ours = log_chi2_tail(t, k).exp();
            assert!((ours / p - 1.0).abs() < 2e-3, "{t} {k}: {ours}");
        }
        assert!((equivalent_z(0.05_f64.ln()) - 1.959_964).abs() < 1e-5);
        assert!((equivalent_z(log_chi2_tail(60.0 * 60.0, 1)) - 60.0).abs() < 1e-6);
    }
}

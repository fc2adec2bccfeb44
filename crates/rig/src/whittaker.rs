//! The smooth course of a series.
//!
//! ```text
//! min over z of  sum (y_i - z_i)^2 + lambda sum (z_{i-1} - 2 z_i + z_{i+1})^2                             (M2)
//! ```
//!
//! (Whittaker 1923), lambda by generalised cross-validation (Craven and Wahba 1979) over all series of one channel together.

/// Smoothness asked for: lambda = 4^0 to 4^10, which pass waves longer than some 6 to 200 samples.
const SMOOTHEST: i32 = 10;

/// lambda with the least n RSS / (n - trace)^2 over all series.
pub(crate) fn likeliest(all: &[&[f64]]) -> f64 {
    let score = |lambda: f64| {
        let (mut rest, mut free) = (0.0, 0.0);
        for y in all {
            let z = smoothed(y, lambda);
            rest += y.iter().zip(&z).map(|(y, z)| (y - z).powi(2)).sum::<f64>();
            free += y.len() as f64 - trace(y.len(), lambda);
        }
        rest / (free * free)
    };
    let candidates = (0..=SMOOTHEST).map(|k| 4.0_f64.powi(k));
    candidates
        .map(|lambda| (score(lambda), lambda))
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map_or(1.0, |(_, lambda)| lambda)
}

/// Trace of the smoother of (M2): its eigenvalues are 1 / (1 + lambda (2 - 2 cos(pi k / n))^2) but for the ends (Garcia 2010).
fn trace(n: usize, lambda: f64) -> f64 {
    (0..n)
        .map(|k| {
            let second = 2.0 - 2.0 * (std::f64::consts::PI * k as f64 / n as f64).cos();
            1.0 / (1.0 + lambda * second * second)
        })
        .sum()
}

/// z of (M2): the five diagonals of I + lambda D'D factorised as L diag(d) L', forward and back.
pub(crate) fn smoothed(series: &[f64], lambda: f64) -> Vec<f64> {
    let n = series.len();
    let (mut d, mut one, mut two) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
    let mut z = series.to_vec();
    // Row i of D'D: the second differences that hold sample i.
    let holds = |i: usize, weights: [f64; 3]| -> f64 {
        let at = |k: usize, w: f64| if i >= k && i + 2 < n + k { w } else { 0.0 };
        at(0, weights[0]) + at(1, weights[1]) + at(2, weights[2])
    };
    for i in 0..n {
        let mut diagonal = 1.0 + lambda * holds(i, [1.0, 4.0, 1.0]);
        let mut beside = if i + 1 < n {
            lambda * holds(i, [-2.0, -2.0, 0.0])
        } else {
            0.0
        };
        let beyond = if i + 2 < n { lambda } else { 0.0 };
        if i >= 1 {
            diagonal -= d[i - 1] * one[i - 1] * one[i - 1];
            beside -= d[i - 1] * one[i - 1] * two[i - 1];
            z[i] -= one[i - 1] * z[i - 1];
        }
        if i >= 2 {
            diagonal -= d[i - 2] * two[i - 2] * two[i - 2];
            z[i] -= two[i - 2] * z[i - 2];
        }
        (d[i], one[i], two[i]) = (diagonal, beside / diagonal, beyond / diagonal);
    }
    for i in (0..n).rev() {
        z[i] /= d[i];
        if i + 1 < n {
            z[i] -= one[i] * z[i + 1];
        }
        if i + 2 < n {
            z[i] -= two[i] * z[i + 2];
        }
    }
    z
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};

    /// Numbers that look like noise of unit variance: sums of twelve from a linear congruence (Knuth's MMIX constants).
    pub(crate) fn noise(seed: u64, n: usize) -> Vec<f64> {
        let mut state = seed;
        let mut uniform = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        (0..n)
            .map(|_| (0..12).map(|_| uniform()).sum::<f64>() - 6.0)
            .collect()
    }

    /// Root mean square difference.
    pub(crate) fn miss(a: &[f64], b: &[f64]) -> f64 {
        let squares: f64 = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum();
        (squares / a.len() as f64).sqrt()
    }

    #[test]
    fn the_smoother_solves_its_equation_and_leaves_straight_lines() {
        let n = 9;
        let mut second = DMatrix::<f64>::zeros(n - 2, n);
        for i in 0..n - 2 {
            second[(i, i)] = 1.0;
            second[(i, i + 1)] = -2.0;
            second[(i, i + 2)] = 1.0;
        }
        let matrix = DMatrix::identity(n, n) + 7.0 * second.transpose() * &second;
        let series = noise(3, n);
        let dense = matrix
            .cholesky()
            .expect("positive definite")
            .solve(&DVector::from_column_slice(&series));
        assert!(miss(&smoothed(&series, 7.0), dense.as_slice()) < 1e-14);
        let line: Vec<f64> = (0..40).map(|i| 3.0 - 0.2 * f64::from(i)).collect();
        assert!(miss(&smoothed(&line, 1e6), &line) < 1e-9);
    }
}

//! The smooth course of a series.
//!
//! ```text
//! min over z of  sum (y_i - z_i)^2 + lambda sum w_i (z_{i-1} - 2 z_i + z_{i+1})^2                         (M2)
//! ```
//!
//! (Whittaker 1923), lambda by generalised cross-validation (Craven and Wahba 1979): what bends all the way is not as smooth as a ramp. All w_i are one,
//! or what leaves the corners of a motion corners: they follow the second differences d_i of z itself (iterated reweighting; the weight is Cauchy's),
//!
//! ```text
//! w_i = 1 / (1 + (d_i / tau)^2),   tau = 5 standard deviations of the d_i, by the median                   (M4)
//! ```
//!
//! where the course may have to pass through some samples: a stage that stands has no noise.

use campaign::noise::spread;

/// Samples of a series; shorter ones have no course and are left as recorded.
pub(crate) const SHORTEST: usize = 16;
/// Smoothness asked for: lambda = 4^0 to 4^10, which pass waves longer than some 6 to 200 samples.
const SMOOTHEST: i32 = 10;
/// Standard deviations of second differences beyond which one is a corner.
const CORNER: f64 = 5.0;
/// Weight of a sample that the course must pass through.
pub(crate) const HELD: f64 = 1e6;
/// Times that the weights follow the course.
const REWEIGHTED: usize = 12;

/// A smooth course and the degrees of freedom that it has taken.
pub(crate) struct Course {
    pub(crate) z: Vec<f64>,
    pub(crate) taken: f64,
}

impl Course {
    /// What a series leaves beside its course: sum of squares and degrees of freedom.
    pub(crate) fn left_of(&self, series: &[f64]) -> (f64, f64) {
        let squares = series.iter().zip(&self.z).map(|(y, z)| (y - z).powi(2));
        (squares.sum(), series.len() as f64 - self.taken)
    }
}

/// lambda with the least n RSS / (n - trace)^2, `left` what a series leaves beside its course: RSS, n - trace.
pub(crate) fn likeliest(left: impl Fn(f64) -> (f64, f64)) -> f64 {
    let score = |lambda: f64| {
        let (rest, free) = left(lambda);
        rest / (free * free)
    };
    let candidates = (0..=SMOOTHEST).map(|k| 4.0_f64.powi(k));
    candidates
        .map(|lambda| (score(lambda), lambda))
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map_or(1.0, |(_, lambda)| lambda)
}

/// The course that bends alike everywhere.
pub(crate) fn smooth(series: &[f64], lambda: f64) -> Course {
    let ones = vec![1.0; series.len()];
    Factors::new(&ones, &ones, lambda).course(series)
}

/// The course with corners; `samples`: the weight of each sample.
pub(crate) fn cornered(series: &[f64], samples: &[f64], lambda: f64) -> Course {
    let mut weights = vec![1.0; series.len()];
    for _ in 0..REWEIGHTED {
        let z = Factors::new(samples, &weights, lambda).solve(series);
        let seconds: Vec<f64> = z.windows(3).map(|z| z[0] - 2.0 * z[1] + z[2]).collect();
        let tau = CORNER * spread(&seconds);
        if tau == 0.0 {
            break;
        }
        for (weight, second) in weights[1..].iter_mut().zip(&seconds) {
            *weight = 1.0 / (1.0 + (second / tau).powi(2));
        }
    }
    Factors::new(samples, &weights, lambda).course(series)
}

/// The five diagonals of V + lambda D' W D as L diag(d) L', V the weights of the samples; `one`, `two`: the entries of L below its diagonal.
struct Factors<'a> {
    samples: &'a [f64],
    d: Vec<f64>,
    one: Vec<f64>,
    two: Vec<f64>,
}

impl<'a> Factors<'a> {
    /// `weights`: of the second difference about each sample; those of both ends have none.
    fn new(samples: &'a [f64], weights: &[f64], lambda: f64) -> Self {
        let n = weights.len();
        let about = |i: usize| {
            if i > 0 && i + 1 < n {
                lambda * weights[i]
            } else {
                0.0
            }
        };
        let (mut d, mut one, mut two) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        for i in 0..n {
            let before = if i > 0 { about(i - 1) } else { 0.0 };
            let mut diagonal = samples[i] + before + 4.0 * about(i) + about(i + 1);
            let mut beside = -2.0 * (about(i) + about(i + 1));
            if i >= 1 {
                diagonal -= d[i - 1] * one[i - 1] * one[i - 1];
                beside -= d[i - 1] * one[i - 1] * two[i - 1];
            }
            if i >= 2 {
                diagonal -= d[i - 2] * two[i - 2] * two[i - 2];
            }
            d[i] = diagonal;
            if i + 1 < n {
                one[i] = beside / diagonal;
            }
            if i + 2 < n {
                two[i] = about(i + 1) / diagonal;
            }
        }
        Self {
            samples,
            d,
            one,
            two,
        }
    }

    /// z of (M2), forward and back.
    fn solve(&self, series: &[f64]) -> Vec<f64> {
        let (Self { d, one, two, .. }, n) = (self, series.len());
        let weighted = series.iter().zip(self.samples).map(|(y, v)| v * y);
        let mut z: Vec<f64> = weighted.collect();
        for i in 1..n {
            z[i] -= one[i - 1] * z[i - 1];
            if i >= 2 {
                z[i] -= two[i - 2] * z[i - 2];
            }
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

    /// Trace of what makes z of the series. Of an inverse only the five diagonals are needed to compute them from the last row up (Hutchinson and de Hoog 1985).
    fn trace(&self) -> f64 {
        let Self { d, one, two, .. } = self;
        let (mut sum, mut below, mut beside, mut last) = (0.0, 0.0, 0.0, 0.0);
        // of the inverse S about row i: S(i+1, i+1), S(i+1, i+2), S(i+2, i+2)
        for i in (0..d.len()).rev() {
            let next = -one[i] * below - two[i] * beside;
            let beyond = -one[i] * beside - two[i] * last;
            let own = 1.0 / d[i] - one[i] * next - two[i] * beyond;
            (last, beside, below) = (below, next, own);
            sum += self.samples[i] * own;
        }
        sum
    }

    fn course(&self, series: &[f64]) -> Course {
        Course {
            z: self.solve(series),
            taken: self.trace(),
        }
    }
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
        let dense = matrix.cholesky().expect("positive definite");
        let own = smooth(&series, 7.0);
        let solved = dense.solve(&DVector::from_column_slice(&series));
        assert!(miss(&own.z, solved.as_slice()) < 1e-14);
        assert!((own.taken - dense.inverse().trace()).abs() < 1e-13);
        let line: Vec<f64> = (0..40).map(|i| 3.0 - 0.2 * f64::from(i)).collect();
        assert!(miss(&smooth(&line, 1e6).z, &line) < 1e-9);
    }

    /// A trapezoid and a step: the plain course is far off at every corner, the other one keeps them and takes the noise off all the same.
    #[test]
    fn corners_stay_corners() {
        let trapezoid = |i: usize| 0.04 * (i.min(599 - i) as f64).min(75.0);
        let clean: Vec<f64> = (0..600)
            .map(|i| trapezoid(i) + if i < 300 { 0.0 } else { 2.0 })
            .collect();
        let series: Vec<f64> = (clean.iter().zip(noise(5, 600)))
            .map(|(z, e)| z + 0.01 * e)
            .collect();
        let cornered = |lambda: f64| super::cornered(&series, &[1.0; 600], lambda);
        let lambda = likeliest(|lambda| cornered(lambda).left_of(&series));
        let cornered = |lambda: f64| cornered(lambda).z;
        assert!(miss(&cornered(lambda), &clean) < 0.4 * 0.01, "{lambda}");
        let at_worst = |z: &[f64]| {
            let misses = z.iter().zip(&clean).map(|(z, c)| (z - c).abs());
            misses.fold(0.0, f64::max)
        };
        assert!(at_worst(&cornered(lambda)) < 0.03);
        assert!(at_worst(&smooth(&series, lambda).z) > 0.5);
    }
}

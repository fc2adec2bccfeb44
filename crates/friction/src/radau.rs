//! Radau IIA with three stages (order five, L-stable, stiffly accurate): the tableau and its error estimate.
//!
//! Hairer and Wanner, Solving Ordinary Differential Equations II, IV.5 and IV.8. A step from (t, y) of size h solves
//! Y_i = y + h sum_j A_ij f(t + C_j h, Y_j); its end is Y_3.

const SQRT_6: f64 = 2.449_489_742_783_178;

/// Places of the stages in the step.
pub const C: [f64; 3] = [(4.0 - SQRT_6) / 10.0, (4.0 + SQRT_6) / 10.0, 1.0];

/// Weights of the stages.
pub const A: [[f64; 3]; 3] = [
    [
        (88.0 - 7.0 * SQRT_6) / 360.0,
        (296.0 - 169.0 * SQRT_6) / 1800.0,
        (-2.0 + 3.0 * SQRT_6) / 225.0,
    ],
    [
        (296.0 + 169.0 * SQRT_6) / 1800.0,
        (88.0 + 7.0 * SQRT_6) / 360.0,
        (-2.0 - 3.0 * SQRT_6) / 225.0,
    ],
    [(16.0 - SQRT_6) / 36.0, (16.0 + SQRT_6) / 36.0, 1.0 / 9.0],
];

/// Inverse of A.
pub const A_INVERSE: [[f64; 3]; 3] = [
    [
        2.0 + SQRT_6 / 2.0,
        -1.2 + 29.0 / 30.0 * SQRT_6,
        0.4 - 4.0 / 15.0 * SQRT_6,
    ],
    [
        -1.2 - 29.0 / 30.0 * SQRT_6,
        2.0 - SQRT_6 / 2.0,
        0.4 + 4.0 / 15.0 * SQRT_6,
    ],
    [-1.0 + 8.0 / 3.0 * SQRT_6, -1.0 - 8.0 / 3.0 * SQRT_6, 5.0],
];

/// Inverse of the real eigenvalue of the inverse of A.
pub const GAMMA: f64 = 1.0 / 3.637_834_252_744_496;

/// Weights of the stage increments in the estimate of the error (order three, so it errs on the safe side):
/// (1 - h GAMMA J) error = h GAMMA f(y) + sum_i E_i (Y_i - y).
pub const E: [f64; 3] = [
    GAMMA / 3.0 * (-13.0 - 7.0 * SQRT_6),
    GAMMA / 3.0 * (-13.0 + 7.0 * SQRT_6),
    -GAMMA / 3.0,
];

/// Values at place s in [0, 1] of the four Lagrange polynomials through 0, C_1, C_2, C_3: the collocation polynomial
/// is their sum weighted with (y, Y_1, Y_2, Y_3).
pub fn collocation_weights(s: f64) -> [f64; 4] {
    let nodes = [0.0, C[0], C[1], C[2]];
    let mut weights = [1.0; 4];
    for (i, weight) in weights.iter_mut().enumerate() {
        for (j, node) in nodes.iter().enumerate() {
            if i != j {
                *weight *= (s - node) / (nodes[i] - node);
            }
        }
    }
    weights
}

/// Inverse of I - h A diag(slopes), the matrix of Newton's iteration for one scalar state; `None` if it is singular.
#[inline(always)]
pub fn inverse_newton_matrix(h: f64, slopes: &[f64; 3]) -> Option<[[f64; 3]; 3]> {
    let mut m = [[0.0; 3]; 3];
    for (i, row) in m.iter_mut().enumerate() {
        for (j, entry) in row.iter_mut().enumerate() {
            *entry = f64::from(u8::from(i == j)) - h * A[i][j] * slopes[j];
        }
    }
    let cofactor = |i: usize, j: usize| {
        let (a, b) = ((i + 1) % 3, (i + 2) % 3);
        let (c, d) = ((j + 1) % 3, (j + 2) % 3);
        m[a][c] * m[b][d] - m[a][d] * m[b][c]
    };
    let determinant =
        m[0][0] * cofactor(0, 0) + m[0][1] * cofactor(0, 1) + m[0][2] * cofactor(0, 2);
    let scale = 1.0 / determinant;
    if !scale.is_finite() {
        return None;
    }
    let mut inverse = [[0.0; 3]; 3];
    for (i, row) in inverse.iter_mut().enumerate() {
        for (j, entry) in row.iter_mut().enumerate() {
            *entry = cofactor(j, i) * scale;
        }
    }
    Some(inverse)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tableau_satisfies_the_simplifying_conditions() {
        // C(3): sum_j A_ij C_j^(k-1) = C_i^k / k; B(5): the last row integrates polynomials of degree four exactly
        for k in 1..=3 {
            for i in 0..3 {
                let sum: f64 = (0..3).map(|j| A[i][j] * C[j].powi(k - 1)).sum();
                assert!((sum - C[i].powi(k) / f64::from(k)).abs() < 1e-15);
            }
        }
        for k in 1..=5 {
            let sum: f64 = (0..3).map(|j| A[2][j] * C[j].powi(k - 1)).sum();
            assert!((sum - 1.0 / f64::from(k)).abs() < 1e-15);
        }
    }

    #[test]
    fn inverse_of_the_tableau_is_its_inverse() {
        for (i, row) in A.iter().enumerate() {
            for j in [0, 1, 2] {
                let product: f64 = (0..3).map(|k| row[k] * A_INVERSE[k][j]).sum();
                assert!((product - f64::from(u8::from(i == j))).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn error_estimate_vanishes_on_cubics() {
        // y' = 3 t^2 - 2 t + 1 over [0, 1]: stages are exact, so the estimate must be nothing
        let y = |t: f64| t * t * t - t * t + t;
        let estimate = GAMMA * 1.0 + (0..3).map(|i| E[i] * y(C[i])).sum::<f64>();
        assert!(estimate.abs() < 1e-14, "{estimate}");
        let quartic = (0..3).map(|i| E[i] * C[i].powi(4)).sum::<f64>();
        assert!(quartic.abs() > 1e-3, "{quartic}");
    }

    #[test]
    fn newton_matrix_is_inverted() {
        let slopes = [-3.0, 50.0, -700.0];
        let inverse = inverse_newton_matrix(0.3, &slopes).expect("regular");
        for (i, row) in inverse.iter().enumerate() {
            for j in 0..3 {
                let product: f64 = (0..3)
                    .map(|k| row[k] * (f64::from(u8::from(k == j)) - 0.3 * A[k][j] * slopes[j]))
                    .sum();
                assert!((product - f64::from(u8::from(i == j))).abs() < 1e-12);
            }
        }
    }
}

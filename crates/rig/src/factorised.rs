//! Small dense linear systems: LU with row scaling and partial pivoting, right-hand sides of any scalar.

use friction::Scalar;

/// A linear system of `N` equations, factorised with row scaling and partial pivoting.
pub(crate) struct Factorised<const N: usize> {
    lu: [[f64; N]; N],
    scale: [f64; N],
    order: [usize; N],
}

impl<const N: usize> Factorised<N> {
    /// `None` where the matrix is singular or not finite.
    pub(crate) fn new(mut m: [[f64; N]; N]) -> Option<Self> {
        let mut scale = [0.0; N];
        for (row, scale) in m.iter_mut().zip(&mut scale) {
            let largest = row.iter().fold(0.0_f64, |a, x| a.max(x.abs()));
            if !(largest > 0.0 && largest.is_finite()) {
                return None;
            }
            *scale = 1.0 / largest;
            row.iter_mut().for_each(|x| *x *= *scale);
        }
        let mut order: [usize; N] = std::array::from_fn(|i| i);
        for k in 0..N {
            let mut pivot = k;
            for i in k + 1..N {
                if m[i][k].abs() > m[pivot][k].abs() {
                    pivot = i;
                }
            }
            if m[pivot][k].is_nan() || m[pivot][k].abs() < 1e-280 {
                return None;
            }
            m.swap(k, pivot);
            order.swap(k, pivot);
            let head = m[k];
            let inverse = 1.0 / head[k];
            for row in m.iter_mut().skip(k + 1) {
                let ratio = row[k] * inverse;
                row[k] = ratio;
                if ratio != 0.0 {
                    for j in k + 1..N {
                        row[j] -= ratio * head[j];
                    }
                }
            }
        }
        Some(Self {
            lu: m,
            scale,
            order,
        })
    }

    /// Solution for a right-hand side, of any scalar.
    pub(crate) fn solve<D: Scalar>(&self, rhs: &[D; N]) -> [D; N] {
        let mut x: [D; N] = std::array::from_fn(|i| rhs[self.order[i]] * self.scale[self.order[i]]);
        for i in 0..N {
            for j in 0..i {
                if self.lu[i][j] != 0.0 {
                    x[i] -= x[j] * self.lu[i][j];
                }
            }
        }
        for i in (0..N).rev() {
            for j in i + 1..N {
                if self.lu[i][j] != 0.0 {
                    x[i] -= x[j] * self.lu[i][j];
                }
            }
            x[i] /= self.lu[i][i];
        }
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_badly_scaled_system_is_solved() {
        let m = [[0.0, 1e9, 2.0], [1e-9, 2e-9, -1e-9], [3.0, 1.0, 1.0]];
        let x = [1.0, -2.0, 0.5];
        let rhs: [f64; 3] = std::array::from_fn(|i| (0..3).map(|j| m[i][j] * x[j]).sum());
        let solved = Factorised::new(m).expect("regular").solve(&rhs);
        assert!(
            solved.iter().zip(x).all(|(a, b)| (a - b).abs() < 1e-8),
            "{solved:?}"
        );
        assert!(Factorised::new([[1.0, 2.0], [2.0, 4.0]]).is_none());
        assert!(Factorised::new([[0.0, 0.0], [2.0, 4.0]]).is_none());
        assert!(Factorised::new([[f64::NAN, 1.0], [2.0, 4.0]]).is_none());
    }
}

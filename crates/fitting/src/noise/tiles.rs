//! Matrices in tiles of eight by eight: what the plate's nodes cost is in products of these, each number of which serves eight times once it is
//! loaded.

use super::along::TOGETHER;

/// Side of a tile: nodes, samples or columns.
pub(super) const SIDE: usize = TOGETHER;

/// Row by row.
pub(super) type Tile = [[f64; SIDE]; SIDE];

/// Rows of a result that are kept in registers at once.
const HELD: usize = 4;

/// M' in the place of M.
pub(super) fn transpose(m: &mut Tile) {
    let before = *m;
    *m = std::array::from_fn(|i| std::array::from_fn(|j| before[j][i]));
}

/// C + s A'B, with s = 1 or -1.
#[inline(always)]
pub(super) fn add_transposed_product<const PLUS: bool>(c: &mut Tile, a: &Tile, b: &Tile) {
    for first in (0..SIDE).step_by(HELD) {
        let mut held: [[f64; SIDE]; HELD] = std::array::from_fn(|r| c[first + r]);
        for k in 0..SIDE {
            for r in 0..HELD {
                let x = if PLUS {
                    a[k][first + r]
                } else {
                    -a[k][first + r]
                };
                for l in 0..SIDE {
                    held[r][l] = x.mul_add(b[k][l], held[r][l]);
                }
            }
        }
        c[first..first + HELD].copy_from_slice(&held);
    }
}

/// C - A B.
#[inline(always)]
pub(super) fn subtract_product(c: &mut Tile, a: &Tile, b: &Tile) {
    for first in (0..SIDE).step_by(HELD) {
        let mut held: [[f64; SIDE]; HELD] = std::array::from_fn(|r| c[first + r]);
        for k in 0..SIDE {
            for r in 0..HELD {
                let x = -a[first + r][k];
                for l in 0..SIDE {
                    held[r][l] = x.mul_add(b[k][l], held[r][l]);
                }
            }
        }
        c[first..first + HELD].copy_from_slice(&held);
    }
}

/// The upper root of a tile in its place, M = U'U; what lies below the diagonal is not looked at.
#[inline(always)]
pub(super) fn root(m: &mut Tile) {
    for k in 0..SIDE {
        let pivot = m[k][k].max(f64::MIN_POSITIVE).sqrt();
        let mut row = m[k];
        row.iter_mut().for_each(|x| *x /= pivot);
        row[k] = pivot;
        m[k] = row;
        for r in k + 1..SIDE {
            let x = -row[r];
            for l in 0..SIDE {
                m[r][l] = x.mul_add(row[l], m[r][l]);
            }
        }
    }
}

/// U'^-1 B in the place of B.
#[inline(always)]
pub(super) fn solve_transposed(u: &Tile, b: &mut Tile) {
    for k in 0..SIDE {
        let mut row = b[k];
        row.iter_mut().for_each(|x| *x /= u[k][k]);
        b[k] = row;
        for r in k + 1..SIDE {
            let x = -u[k][r];
            for l in 0..SIDE {
                b[r][l] = x.mul_add(row[l], b[r][l]);
            }
        }
    }
}

/// U^-1 B in the place of B.
#[inline(always)]
pub(super) fn solve(u: &Tile, b: &mut Tile) {
    for k in (0..SIDE).rev() {
        let mut row = b[k];
        row.iter_mut().for_each(|x| *x /= u[k][k]);
        b[k] = row;
        for r in 0..k {
            let x = -u[r][k];
            for l in 0..SIDE {
                b[r][l] = x.mul_add(row[l], b[r][l]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Cholesky, SMatrix};

    use super::*;

    type Dense = SMatrix<f64, SIDE, SIDE>;

    fn tile(of: &Dense) -> Tile {
        std::array::from_fn(|i| std::array::from_fn(|j| of[(i, j)]))
    }

    fn assert_is(ours: &Tile, dense: &Dense) {
        let off = |i: usize, j: usize| (ours[i][j] - dense[(i, j)]).abs();
        let worst = (0..SIDE * SIDE).map(|k| off(k / SIDE, k % SIDE));
        assert!(worst.fold(0.0, f64::max) < 1e-12, "{ours:?} {dense}");
    }

    /// Products, root and solutions are those of nalgebra.
    #[test]
    fn tiles_are_matrices() {
        let a = Dense::from_fn(|i, j| ((3 * i + 5 * j) as f64).sin());
        let b = Dense::from_fn(|i, j| ((7 * i + 2 * j) as f64).cos());
        let c = Dense::from_fn(|i, j| (i as f64 - 2.0 * j as f64) / 9.0);
        let mut own = tile(&c);
        add_transposed_product::<true>(&mut own, &tile(&a), &tile(&b));
        assert_is(&own, &(c + a.transpose() * b));
        add_transposed_product::<false>(&mut own, &tile(&a), &tile(&b));
        assert_is(&own, &c);
        subtract_product(&mut own, &tile(&a), &tile(&b));
        assert_is(&own, &(c - a * b));
        let m = a.transpose() * a + Dense::identity();
        let upper = Cholesky::new(m).expect("positive definite").l().transpose();
        let mut own = tile(&m);
        root(&mut own);
        let above = Dense::from_fn(|i, j| if j < i { 0.0 } else { own[i][j] });
        assert_is(&tile(&above), &upper);
        let (mut forth, mut back) = (tile(&b), tile(&b));
        solve_transposed(&own, &mut forth);
        assert_is(
            &forth,
            &upper
                .transpose()
                .try_inverse()
                .map(|i| i * b)
                .expect("regular"),
        );
        solve(&own, &mut back);
        assert_is(&back, &upper.try_inverse().map(|i| i * b).expect("regular"));
    }
}

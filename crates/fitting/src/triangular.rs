//! Orthogonal reduction of tall least-squares systems to triangular ones.
//!
//! With J = Q R the problem min |J s + r| has the same minimiser as the small min |R s + Q^T r|. The normal
//! equations J^T J are never formed: they square the condition number.

use nalgebra::{DMatrix, DVector, QR};

/// R and Q^T b of a tall system, and |b|^2 - |Q^T b|^2, the part of b that no step reaches.
#[derive(Clone, Debug)]
pub(crate) struct Reduced {
    /// Upper triangular (upper trapezoidal for a wide system), min(m, n) rows and n columns.
    pub(crate) r: DMatrix<f64>,
    /// Q^T b, min(m, n) entries.
    pub(crate) qtb: DVector<f64>,
}

/// Reduces (J, b) to (R, Q^T b).
pub(crate) fn reduce(jacobian: DMatrix<f64>, b: &DVector<f64>) -> Reduced {
    let rows = jacobian.nrows().min(jacobian.ncols());
    let qr = QR::new(jacobian);
    let mut qtb = b.clone();
    qr.q_tr_mul(&mut qtb);
    Reduced {
        r: qr.r(),
        qtb: qtb.rows(0, rows).into_owned(),
    }
}

/// Least-squares solution of A x = b for A of full column rank.
pub(crate) fn solve_full_rank(a: DMatrix<f64>, b: &DVector<f64>) -> DVector<f64> {
    let columns = a.ncols();
    let Reduced { r, qtb } = reduce(a, b);
    r.rows(0, columns)
        .solve_upper_triangular(&qtb)
        .unwrap_or_else(|| DVector::zeros(columns))
}

/// Covariance (J^T J)^-1 = V S^-2 V^T from the singular values of R; `None` when a singular value of the
/// column-normalised R lies below `1e-12` of the largest: the data then leave a direction undetermined.
pub(crate) fn covariance(r: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let n = r.ncols();
    if n == 0 {
        return Some(DMatrix::zeros(0, 0));
    }
    let norms: Vec<f64> = r.column_iter().map(|c| c.norm()).collect();
    if r.nrows() < n || norms.iter().any(|&s| s <= 0.0 || !s.is_finite()) {
        return None;
    }
    let mut scaled = r.clone();
    for (mut column, norm) in scaled.column_iter_mut().zip(&norms) {
        column /= *norm;
    }
    let svd = scaled.svd(false, true);
    let v_t = svd.v_t?;
    let largest = svd.singular_values.max();
    if svd.singular_values.min() <= 1e-12 * largest {
        return None;
    }
    let mut v_over_s = v_t.transpose();
    for (mut column, s) in v_over_s.column_iter_mut().zip(svd.singular_values.iter()) {
        column /= *s;
    }
    for (mut row, norm) in v_over_s.row_iter_mut().zip(&norms) {
        row /= *norm;
    }
    Some(&v_over_s * v_over_s.transpose())
}

/// Covariance (J^T J)^-1 of a whitened Jacobian; `None` where the data leave a direction undetermined.
pub fn covariance_of(jacobian: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let rows = jacobian.nrows();
    covariance(&reduce(jacobian.clone(), &DVector::zeros(rows)).r)
}

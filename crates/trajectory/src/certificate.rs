//! What is known about the point that a solve returns.
//!
//! A point is certified as a strict local minimum when the first-order errors
//! are below tolerance and the Hessian of the Lagrangian is positive definite
//! along the strongly active constraints (equalities, and limits whose
//! multiplier is not zero):
//!
//! ```text
//! λ_min(Zᵀ H Z) > 0,   Z a basis of the null space of J_A
//! ```
//!
//! This second-order condition is sufficient whether or not the active
//! gradients are independent (Nocedal and Wright, theorem 12.6). Their smallest
//! singular value σ_min(J_A) is reported beside it: where it vanishes the
//! multipliers are not unique and say nothing on their own.
//!
//! Both numbers come from the factorisation that the polish uses anyway, by
//! Lanczos iterations on its inverse; positive definiteness itself is read from
//! the inertia, which is exact.

use crate::OptimalityError;
use crate::iterate::Iterate;
use crate::model::{Evaluator, Structure};
use crate::newton::ActiveSet;
use crate::pattern::dot;
use crate::proposal::Proposer;
use nalgebra::{DMatrix, SymmetricEigen};

/// Singular values below this are dependence (scaled rows and variables).
const INDEPENDENT: f64 = 1e-5;
/// Curvature below this is flat (scaled).
const FLAT: f64 = 1e-8;
/// Multipliers below this do not hold a limit (scaled).
const WEAK: f64 = 1e-7;

/// The evidence for or against a local minimum. All numbers are scaled.
#[derive(Clone, Debug, PartialEq)]
pub struct Certificate {
    /// Errors of the first-order conditions.
    pub error: OptimalityError,
    /// Equalities, active rows and active bounds.
    pub active: usize,
    /// Variables minus active constraints: the dimension of the reduced Hessian.
    pub freedom: usize,
    /// Smallest singular value of the active Jacobian (from above).
    pub smallest_singular_value: f64,
    /// Smallest eigenvalue of the reduced Hessian (from above); `+∞` without freedom.
    pub smallest_curvature: f64,
    /// The reduced Hessian is positive definite, by inertia.
    pub positive_definite: bool,
    /// Smallest multiplier of an active inequality; near zero means weakly active.
    pub weakest_multiplier: f64,
    /// Starts that found this minimum, out of starts tried (see `multistart`).
    pub starts: Option<(usize, usize)>,
}

impl Certificate {
    /// A certificate that says nothing but the first-order errors.
    pub(crate) fn uninformed(error: OptimalityError) -> Self {
        Self {
            error,
            active: 0,
            freedom: 0,
            smallest_singular_value: f64::NAN,
            smallest_curvature: f64::NAN,
            positive_definite: false,
            weakest_multiplier: f64::NAN,
            starts: None,
        }
    }

    /// Are the active gradients independent?
    pub fn independent(&self) -> bool {
        self.smallest_singular_value > INDEPENDENT
    }

    /// Is the point a certified strict local minimum for this tolerance?
    ///
    /// Curvature must not only be positive but exceed what rounding can feign.
    pub fn holds(&self, tolerance: f64) -> bool {
        self.error.worst() <= tolerance && self.positive_definite && self.smallest_curvature > FLAT
    }
}

/// Collects the evidence at a point on an active set.
pub(crate) fn certify(
    e: &dyn Evaluator,
    proposer: &mut Proposer<'_>,
    at: &Iterate,
    active: &ActiveSet,
) -> Certificate {
    let s = e.structure();
    let active = &strongly_active(s, at, active);
    let mut certificate = Certificate::uninformed(at.error(e));
    let n = s.variables();
    let m = s.rows();
    certificate.active = active
        .rows
        .iter()
        .chain(&active.bounds)
        .filter(|&&a| a)
        .count();
    certificate.freedom = n.saturating_sub(certificate.active);
    certificate.weakest_multiplier = weakest_multiplier(s, at, active);

    // [H J_Aᵀ; J_A 0]⁻¹ [v; 0] = [Z (ZᵀHZ)⁻¹ Zᵀ v; ·]: its largest eigenvalue is 1/λ_min.
    let hessian = proposer.hessian.clone();
    let inertia = proposer.newton.factorise(s, &hessian, &at.jacobian, active);
    certificate.positive_definite = inertia == Some(n);
    let free = |k: usize| k < n && !active.bounds[k];
    certificate.smallest_curvature = if certificate.freedom == 0 {
        f64::INFINITY
    } else {
        largest_eigenvalue(n + m, free, |v| proposer.newton.solve_backward(v))
            .map_or(f64::NAN, |θ| 1.0 / θ)
    };

    // [I J_Aᵀ; J_A 0]⁻¹ [0; w] = [·; −(J_A J_Aᵀ)⁻¹ w]: its largest eigenvalue is 1/σ_min².
    let identity: Vec<f64> = s
        .hessian
        .entries()
        .map(|(_, r, c)| if r == c { 1.0 } else { 0.0 })
        .collect();
    certificate.smallest_singular_value = if !active.rows.contains(&true) {
        1.0
    } else if proposer
        .newton
        .factorise(s, &identity, &at.jacobian, active)
        .is_some()
    {
        let held = |k: usize| k >= n && active.rows[k - n];
        let solve = |v: &[f64]| {
            proposer
                .newton
                .solve_backward(v)
                .map(|x| x.iter().map(|x| -x).collect())
        };
        largest_eigenvalue(n + m, held, solve).map_or(0.0, |θ| 1.0 / θ.max(0.0).sqrt())
    } else {
        0.0
    };
    certificate
}

fn strongly_active(s: &Structure, at: &Iterate, active: &ActiveSet) -> ActiveSet {
    let rows = (0..s.rows())
        .map(|r| s.row_lower[r] == s.row_upper[r] || (active.rows[r] && at.y[r].abs() > WEAK));
    let bounds = (0..s.variables())
        .map(|v| s.lower[v] == s.upper[v] || (active.bounds[v] && at.z[v].abs() > WEAK));
    ActiveSet {
        rows: rows.collect(),
        bounds: bounds.collect(),
    }
}

fn weakest_multiplier(s: &Structure, at: &Iterate, active: &ActiveSet) -> f64 {
    let rows = (0..s.rows())
        .filter(|&r| active.rows[r] && s.row_lower[r] < s.row_upper[r])
        .map(|r| at.y[r].abs());
    let bounds = (0..s.variables())
        .filter(|&v| active.bounds[v] && s.lower[v] < s.upper[v])
        .map(|v| at.z[v].abs());
    rows.chain(bounds).fold(f64::INFINITY, f64::min)
}

/// Largest eigenvalue of a symmetric operator restricted to some entries, by
/// Lanczos with full reorthogonalisation from a fixed start.
fn largest_eigenvalue(
    size: usize,
    keep: impl Fn(usize) -> bool,
    mut apply: impl FnMut(&[f64]) -> Option<Vec<f64>>,
) -> Option<f64> {
    let mut v: Vec<f64> = (0..size)
        .map(|k| {
            if keep(k) {
                1.0 + 0.5 * (k as f64).sin()
            } else {
                0.0
            }
        })
        .collect();
    let norm = dot(&v, &v).sqrt();
    if norm == 0.0 {
        return None;
    }
    v.iter_mut().for_each(|x| *x /= norm);
    let mut basis = vec![v];
    let (mut diagonal, mut off_diagonal) = (Vec::new(), Vec::<f64>::new());
    let mut largest = f64::NEG_INFINITY;
    for _ in 0..60 {
        let last = basis.last()?;
        let mut w = apply(last)?;
        for (k, x) in w.iter_mut().enumerate() {
            if !keep(k) {
                *x = 0.0;
            }
        }
        diagonal.push(dot(&w, last));
        for _ in 0..2 {
            for q in &basis {
                let share = dot(&w, q);
                w.iter_mut().zip(q).for_each(|(w, q)| *w -= share * q);
            }
        }
        let now = ritz(&diagonal, &off_diagonal);
        let norm = dot(&w, &w).sqrt();
        let settled = (now - largest).abs() <= 1e-6 * now.abs();
        largest = now;
        if settled || norm <= 1e-13 * now.abs() {
            break;
        }
        off_diagonal.push(norm);
        w.iter_mut().for_each(|x| *x /= norm);
        basis.push(w);
    }
    Some(largest)
}

/// Largest eigenvalue of the symmetric tridiagonal matrix.
fn ritz(diagonal: &[f64], off_diagonal: &[f64]) -> f64 {
    let k = diagonal.len();
    let matrix = DMatrix::from_fn(k, k, |i, j| {
        if i == j {
            diagonal[i]
        } else if i.abs_diff(j) == 1 {
            off_diagonal[i.min(j)]
        } else {
            0.0
        }
    });
    SymmetricEigen::new(matrix).eigenvalues.max()
}

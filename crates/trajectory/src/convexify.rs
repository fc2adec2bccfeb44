//! Makes the Hessian of the Lagrangian convex, group by group.
//!
//! ```text
//! H_g = V diag(λ) Vᵀ   →   V diag(φ(λ)) Vᵀ
//! clip    φ(λ) = max(λ, ε)          mirror  φ(λ) = max(|λ|, ε)
//! ```
//!
//! A sum of positive definite group matrices is positive definite, so the
//! quadratic subproblem is convex whatever the multipliers are. Clipping is
//! the default: it forgets negative curvature instead of inventing positive
//! curvature of the same size.

use crate::model::Structure;
use nalgebra::{DMatrix, SymmetricEigen};

/// How the Hessian of the subproblem is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HessianModel {
    /// Exact Hessian of the Lagrangian, negative eigenvalues clipped.
    ExactClip,
    /// Exact Hessian of the Lagrangian, negative eigenvalues mirrored.
    ExactMirror,
    /// Hessian of the cost alone, clipped: forgets the constraints' curvature.
    CostOnly,
}

/// How a convex Hessian is made.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Convexification {
    pub model: HessianModel,
    /// Smallest eigenvalue.
    pub floor: f64,
    /// Weight ρ of the groups' own equality rows.
    pub weight: f64,
}

/// g + ρ Σ a_r (c_r − b_r) over the groups' own rows: what the squares add to the gradient.
pub(crate) fn gradient(
    s: &Structure,
    gradient: &[f64],
    jacobian: &[f64],
    rows: &[f64],
    weight: f64,
) -> Vec<f64> {
    let mut out = gradient.to_vec();
    for group in &s.groups {
        for own in &group.own_rows {
            let miss = weight * (rows[own.row] - s.row_upper[own.row]);
            for &(slot, place) in &own.entries {
                out[group.variables[place]] += miss * jacobian[slot];
            }
        }
    }
    out
}

/// How convex the exact Hessian was.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Convexity {
    /// Smallest eigenvalue of any group.
    pub smallest: f64,
    /// Eigenvalues that were changed.
    pub changed: usize,
}

/// Scatters the groups as they are into the Hessian's pattern.
pub(crate) fn assemble(structure: &Structure, groups: &[Vec<f64>], values: &mut [f64]) {
    values.fill(0.0);
    for (group, dense) in structure.groups.iter().zip(groups) {
        scatter(
            &group.slots,
            group.variables.len(),
            |i, j| dense[i * group.variables.len() + j],
            values,
        );
    }
}

/// Scatters the groups, made convex, into the Hessian's pattern.
pub(crate) fn assemble_convex(
    structure: &Structure,
    groups: &[Vec<f64>],
    jacobian: &[f64],
    settings: Convexification,
    values: &mut [f64],
) -> Convexity {
    let Convexification {
        model,
        floor,
        weight,
    } = settings;
    values.fill(0.0);
    let mut convexity = Convexity {
        smallest: f64::INFINITY,
        changed: 0,
    };
    for (group, dense) in structure.groups.iter().zip(groups) {
        let n = group.variables.len();
        if dense.iter().all(|&h| h == 0.0) {
            convexity.smallest = convexity.smallest.min(0.0);
            continue;
        }
        let mut squared = dense.clone();
        for own in &group.own_rows {
            for &(a, i) in &own.entries {
                for &(b, j) in &own.entries {
                    squared[i * n + j] += weight * jacobian[a] * jacobian[b];
                }
            }
        }
        let dense = &squared;
        let eigen = SymmetricEigen::new(DMatrix::from_row_slice(n, n, dense));
        let smallest = eigen.eigenvalues.min();
        convexity.smallest = convexity.smallest.min(smallest);
        if smallest >= 0.0 {
            scatter(&group.slots, n, |i, j| dense[i * n + j], values);
            continue;
        }
        // H + Σ (φ(λ) − λ) v vᵀ over the changed eigenvalues only: directions
        // that were convex keep their curvature to the last bit.
        let mut added = DMatrix::zeros(n, n);
        for (k, &λ) in eigen.eigenvalues.iter().enumerate() {
            let target = match model {
                HessianModel::ExactMirror => λ.abs().max(floor),
                HessianModel::ExactClip | HessianModel::CostOnly => λ.max(floor),
            };
            if λ < 0.0 {
                convexity.changed += 1;
                let v = eigen.eigenvectors.column(k);
                added.ger(target - λ, &v, &v, 1.0);
            }
        }
        scatter(
            &group.slots,
            n,
            |i, j| dense[i * n + j] + added[(i, j)],
            values,
        );
    }
    // A small multiple of the identity keeps directions without any curvature
    // from making the subproblem's minimiser a set.
    structure.hessian.add_to_diagonal(values, floor);
    convexity
}

fn scatter(slots: &[usize], n: usize, entry: impl Fn(usize, usize) -> f64, values: &mut [f64]) {
    let mut k = 0;
    for i in 0..n {
        for j in i..n {
            values[slots[k]] += entry(i, j);
            k += 1;
        }
    }
}

//! The damped Gauss-Newton step inside a box, exactly.
//!
//! ```text
//! min over s of 1/2 |R s + c|^2 + 1/2 lambda |D s|^2   subject to   l - p <= s <= u - p
//! ```
//!
//! With lambda > 0 and D > 0 it is strictly convex, so the active-set method for bounded least squares (Stark and
//! Parker 1995, "Bounded-variable least-squares") ends at its one minimiser: parameters that belong on a bound are put
//! there exactly, and the others take the full step that follows from it (a step that is merely cut off does not).

use crate::triangular::{Reduced, solve_full_rank};
use nalgebra::{DMatrix, DVector};

/// Where a component stands.
#[derive(Clone, Copy, PartialEq)]
enum Place {
    Free,
    AtLower,
    AtUpper,
}

/// Minimiser s of the damped model inside [lower, upper]; 0 must lie inside.
///
/// **Shape:** `reduced.r` k x n, `damping` n (the entries sqrt(lambda) D_j), `lower`, `upper` n.
pub(crate) fn bounded_step(
    reduced: &Reduced,
    damping: &DVector<f64>,
    lower: &DVector<f64>,
    upper: &DVector<f64>,
) -> DVector<f64> {
    let n = reduced.r.ncols();
    let k = reduced.r.nrows();
    // A = [R; sqrt(lambda) D], b = [-Q^T r; 0]
    let mut a = DMatrix::zeros(k + n, n);
    a.rows_mut(0, k).copy_from(&reduced.r);
    for j in 0..n {
        a[(k + j, j)] = damping[j];
    }
    let mut b = DVector::zeros(k + n);
    b.rows_mut(0, k).copy_from(&(-&reduced.qtb));

    let mut step = DVector::zeros(n);
    let mut place = vec![Place::Free; n];
    // Every pass either reaches the minimiser of a face, binds a component or frees one; a face is never visited twice
    // because the model decreases. The cap only guards against ties of rounding.
    for _ in 0..(10 * n + 10) {
        let free: Vec<usize> = (0..n).filter(|&j| place[j] == Place::Free).collect();
        let target = face_minimiser(&a, &b, &step, &free);
        if let Some((fraction, j, end)) = first_crossing(&step, &target, &free, lower, upper) {
            for (&i, t) in free.iter().zip(target.iter()) {
                step[i] += fraction * (t - step[i]);
            }
            place[j] = end;
            step[j] = if end == Place::AtLower {
                lower[j]
            } else {
                upper[j]
            };
            continue;
        }
        for (&i, t) in free.iter().zip(target.iter()) {
            step[i] = *t;
        }
        let Some(j) = worst_multiplier(&a, &b, &step, &place) else {
            break;
        };
        place[j] = Place::Free;
    }
    step
}

/// Minimiser over the free components, the others held where they are.
fn face_minimiser(
    a: &DMatrix<f64>,
    b: &DVector<f64>,
    step: &DVector<f64>,
    free: &[usize],
) -> DVector<f64> {
    if free.is_empty() {
        return DVector::zeros(0);
    }
    let mut held = step.clone();
    for &j in free {
        held[j] = 0.0;
    }
    solve_full_rank(a.select_columns(free), &(b - a * held))
}

/// First bound that the straight way from `step` to `target` meets, as (fraction of the way, component, end).
fn first_crossing(
    step: &DVector<f64>,
    target: &DVector<f64>,
    free: &[usize],
    lower: &DVector<f64>,
    upper: &DVector<f64>,
) -> Option<(f64, usize, Place)> {
    let mut first: Option<(f64, usize, Place)> = None;
    for (&j, &t) in free.iter().zip(target.iter()) {
        let (limit, end) = if t < lower[j] {
            (lower[j], Place::AtLower)
        } else if t > upper[j] {
            (upper[j], Place::AtUpper)
        } else {
            continue;
        };
        let fraction = ((limit - step[j]) / (t - step[j])).clamp(0.0, 1.0);
        if first.is_none_or(|(f, _, _)| fraction < f) {
            first = Some((fraction, j, end));
        }
    }
    first
}

/// The bound component that most wants back inside: w = A^T (b - A s) is the direction of descent.
fn worst_multiplier(
    a: &DMatrix<f64>,
    b: &DVector<f64>,
    step: &DVector<f64>,
    place: &[Place],
) -> Option<usize> {
    let rest = b - a * step;
    let size = rest.norm();
    let mut worst: Option<(f64, usize)> = None;
    for (j, p) in place.iter().enumerate() {
        let inward = match p {
            Place::Free => continue,
            Place::AtLower => a.column(j).dot(&rest),
            Place::AtUpper => -a.column(j).dot(&rest),
        };
        // Rounding of the inner product: a multiplier below it has no sign.
        let scale = a.column(j).norm() * size;
        if inward > 1e-13 * scale && worst.is_none_or(|(w, _)| inward / scale > w) {
            worst = Some((inward / scale, j));
        }
    }
    worst.map(|(_, j)| j)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn solve(a: DMatrix<f64>, b: &[f64], lower: &[f64], upper: &[f64]) -> DVector<f64> {
        let n = a.ncols();
        let reduced = crate::triangular::reduce(a, &(-DVector::from_column_slice(b)));
        bounded_step(
            &reduced,
            &DVector::from_element(n, 1e-9),
            &DVector::from_column_slice(lower),
            &DVector::from_column_slice(upper),
        )
    }

    /// Strongly coupled columns: the clipped unconstrained solution (1, 0) is not the bounded minimiser.
    /// By hand: with s1 = 1, min over s0 of (s0 + 0.9 - 2)^2 + (0.9 s0 + 1 - 2.5)^2 gives s0 = 2.45/1.81.
    #[test]
    fn the_others_follow_a_parameter_that_meets_its_bound() {
        let a = DMatrix::from_row_slice(2, 2, &[1.0, 0.9, 0.9, 1.0]);
        let s = solve(a, &[2.0, 2.5], &[-10.0, -10.0], &[10.0, 1.0]);
        assert_eq!(s[1], 1.0);
        assert!((s[0] - 2.45 / 1.81).abs() < 1e-8, "{s}");
    }

    /// The first bound met on the way is not always one of the minimiser: it must be released again.
    #[test]
    fn optimality_conditions_hold_for_many_random_boxes() {
        let mut seed = 1_u64;
        let mut draw = move || {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1);
            ((seed >> 33) as f64) / f64::from(1_u32 << 31) - 0.5
        };
        for _ in 0..200 {
            let a = DMatrix::from_fn(7, 5, |_, _| draw());
            let b: Vec<f64> = (0..7).map(|_| 4.0 * draw()).collect();
            let lower: Vec<f64> = (0..5).map(|_| -(draw() + 0.5)).collect();
            let upper: Vec<f64> = (0..5).map(|_| draw() + 0.5).collect();
            let s = solve(a.clone(), &b, &lower, &upper);
            let gradient = a.transpose() * (&a * &s - DVector::from_column_slice(&b));
            for j in 0..5 {
                assert!(s[j] >= lower[j] && s[j] <= upper[j]);
                if s[j] == lower[j] {
                    assert!(gradient[j] > -1e-9);
                } else if s[j] == upper[j] {
                    assert!(gradient[j] < 1e-9);
                } else {
                    assert!(gradient[j].abs() < 1e-9);
                }
            }
        }
    }
}

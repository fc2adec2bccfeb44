//! A small quasi-Newton search (BFGS) for smooth functions of a few logarithms, with differences for the gradient.
//!
//! The restricted likelihood costs milliseconds and is smooth to about 1e-6, so that steps of 0.002 in a logarithm give its slope to
//! some 1e-3. Longer steps do harm: a difference to one side is off by half a step times that coordinate's own curvature, and along
//! a ridge (length against size and smoothing) a small error of the slope is a long way. With steps of 0.02 searches ended up to a quarter
//! short in length.

use nalgebra::{Cholesky, DMatrix, DVector};
use rayon::prelude::*;

/// Step of the differences.
const STEP: f64 = 0.002;
/// How far a search goes: a step that promises to lower -2 log likelihood by less than this is not worth taking.
pub(super) const TO_THE_END: f64 = 0.02;
/// The same where another search follows, or where what is compared must differ by tens.
pub(super) const NEAR: f64 = 0.3;

/// Inverse of the curvature before any is met.
const FIRST: f64 = 0.1;

/// Where a search ended.
pub(super) struct Minimum {
    pub(super) point: Vec<f64>,
    /// Estimate of the inverse of the Hessian there.
    pub(super) inverse: DMatrix<f64>,
    pub(super) value: f64,
    pub(super) evaluations: usize,
    pub(super) converged: bool,
}

/// Minimises `f` within box bounds from `start`, with an estimate of the inverse of the Hessian where there is one, as far as `worthwhile`
/// steps lead.
pub(super) fn minimise(
    f: &(dyn Fn(&[f64]) -> f64 + Sync),
    start: &[f64],
    inverse: Option<DMatrix<f64>>,
    bounds: &[(f64, f64)],
    worthwhile: f64,
) -> Minimum {
    const MOST_ITERATIONS: usize = 25;
    let n = start.len();
    let clamp = |x: &DVector<f64>| -> DVector<f64> {
        DVector::from_iterator(
            n,
            x.iter().zip(bounds).map(|(v, (lo, hi))| v.clamp(*lo, *hi)),
        )
    };
    let mut x = clamp(&DVector::from_column_slice(start));
    let mut value = f(x.as_slice());
    let mut evaluations = 1;
    let mut inverse = inverse.unwrap_or_else(|| DMatrix::identity(n, n) * FIRST);
    let mut slope = gradient(f, &x, value, &mut evaluations);
    let mut converged = false;
    let mut promised_before = None;
    for _ in 0..MOST_ITERATIONS {
        let mut direction = step_within(&x, &slope, &inverse, bounds);
        if direction.dot(&slope) >= 0.0 {
            direction = clamp(&(&x - &slope * 0.05)) - &x;
        }
        let longest = direction.amax();
        if longest > 1.5 {
            direction *= 1.5 / longest;
        }
        let promised = direction.dot(&slope);
        if promised.abs() < worthwhile {
            converged = true;
            break;
        }
        let mut length = 1.0;
        let mut accepted = None;
        for _ in 0..8 {
            let trial = clamp(&(&x + &direction * length));
            let trial_value = f(trial.as_slice());
            evaluations += 1;
            if trial_value < value + 1e-4 * length * promised {
                accepted = Some((trial, trial_value));
                break;
            }
            length *= 0.35;
        }
        let Some((next, next_value)) = accepted else {
            converged = promised.abs() < 0.5;
            break;
        };
        // The promises of whole steps fall by a factor. Where the next one, fallen as much, would not be worth taking, no slope is needed.
        let fallen = promised_before.map_or(1.0, |before: f64| promised / before);
        if length == 1.0 && promised.abs() * fallen < worthwhile {
            (x, value, converged) = (next, next_value, true);
            break;
        }
        promised_before = (length == 1.0).then_some(promised);
        let next_slope = gradient(f, &next, next_value, &mut evaluations);
        update(&mut inverse, &(&next - &x), &(&next_slope - &slope));
        x = next;
        value = next_value;
        slope = next_slope;
    }
    Minimum {
        point: x.as_slice().to_vec(),
        inverse,
        value,
        evaluations,
        converged,
    }
}

/// Forward differences, evaluated side by side (the order of the results is fixed).
fn gradient(
    f: &(dyn Fn(&[f64]) -> f64 + Sync),
    x: &DVector<f64>,
    value: f64,
    evaluations: &mut usize,
) -> DVector<f64> {
    let n = x.len();
    *evaluations += n;
    let values: Vec<f64> = (0..n)
        .into_par_iter()
        .map(|k| {
            let mut at = x.clone();
            at[k] += STEP;
            f(at.as_slice())
        })
        .collect();
    DVector::from_fn(n, |i, _| (values[i] - value) / STEP)
}

/// The step d to the minimum of the quadratic model with the slope g and the inverse Hessian M, within the bounds: coordinates B that
/// would leave them end on them, t away, and the others go where the model has its minimum beside these,
///
/// ```text
/// d = -M g + M_.B M_BB^-1 (t + (M g)_B).
/// ```
///
/// -(M g)_F alone is the step of the others were B free to follow: where size and length make up for a smoothing that lies on its bound,
/// it is a hundred times too long.
fn step_within(
    x: &DVector<f64>,
    slope: &DVector<f64>,
    inverse: &DMatrix<f64>,
    bounds: &[(f64, f64)],
) -> DVector<f64> {
    let free = -(inverse * slope);
    let room = |i: usize| (bounds[i].0 - x[i], bounds[i].1 - x[i]);
    // What presses on a bound stands still.
    let mut ended: Vec<(usize, f64)> = (0..x.len())
        .filter(|&i| (room(i).0 >= 0.0 && slope[i] > 0.0) || (room(i).1 <= 0.0 && slope[i] < 0.0))
        .map(|i| (i, 0.0))
        .collect();
    loop {
        let at: Vec<usize> = ended.iter().map(|(i, _)| *i).collect();
        let columns = inverse.select_columns(&at);
        let further = ended.iter().map(|&(i, target)| target - free[i]);
        let further = DVector::from_iterator(ended.len(), further);
        let mut step = match Cholesky::new(columns.select_rows(&at)) {
            Some(own) => &free + &columns * own.solve(&further),
            None => free.clone(),
        };
        ended.iter().for_each(|&(i, target)| step[i] = target);
        let beyond = |i: usize| {
            let inside = step[i].clamp(room(i).0, room(i).1);
            (inside != step[i] && !at.contains(&i)).then_some((i, inside))
        };
        let left: Vec<(usize, f64)> = (0..x.len()).filter_map(beyond).collect();
        if left.is_empty() {
            return step;
        }
        ended.extend(left);
    }
}

/// The BFGS update of the inverse Hessian, skipped where the curvature is not positive.
fn update(inverse: &mut DMatrix<f64>, step: &DVector<f64>, change: &DVector<f64>) {
    let curvature = step.dot(change);
    if curvature <= 1e-10 * step.norm() * change.norm() {
        return;
    }
    let rho = 1.0 / curvature;
    let n = step.len();
    let left = DMatrix::identity(n, n) - step * change.transpose() * rho;
    *inverse = &left * &*inverse * left.transpose() + step * step.transpose() * rho;
}

/// Standard deviations of the coordinates from the curvature of `f` = -2 log likelihood; infinite where it is flat.
pub(super) fn standard_deviations(f: &(dyn Fn(&[f64]) -> f64 + Sync), x: &[f64]) -> Vec<f64> {
    let n = x.len();
    let h = 0.1;
    let points: Vec<(usize, usize)> = (0..n).flat_map(|i| (i..n).map(move |j| (i, j))).collect();
    let second: Vec<f64> = points
        .par_iter()
        .map(|&(i, j)| {
            let at = |a: f64, b: f64| {
                let mut p = x.to_vec();
                p[i] += a;
                p[j] += b;
                f(&p)
            };
            if i == j {
                (at(h, 0.0) - 2.0 * f(x) + at(-h, 0.0)) / (h * h)
            } else {
                (at(h, h) - at(h, -h) - at(-h, h) + at(-h, -h)) / (4.0 * h * h)
            }
        })
        .collect();
    let mut hessian = DMatrix::zeros(n, n);
    for (&(i, j), v) in points.iter().zip(&second) {
        hessian[(i, j)] = *v;
        hessian[(j, i)] = *v;
    }
    // f = -2 log L, so the covariance is the inverse of half its Hessian.
    match (hessian * 0.5).try_inverse() {
        Some(covariance) => (0..n)
            .map(|i| {
                let v = covariance[(i, i)];
                if v > 0.0 { v.sqrt() } else { f64::INFINITY }
            })
            .collect(),
        None => vec![f64::INFINITY; n],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where every coordinate presses on its bound the search has come to its end.
    #[test]
    fn a_corner_is_an_end() {
        let plane = |x: &[f64]| 10.0 * x[0] - 20.0 * x[1];
        let found = minimise(
            &plane,
            &[0.0, 1.0],
            None,
            &[(0.0, 1.0), (0.0, 1.0)],
            TO_THE_END,
        );
        assert!(found.converged);
        assert_eq!((found.point, found.evaluations), (vec![0.0, 1.0], 3));
    }

    /// A narrow valley that a bound cuts: along it the second coordinate presses on its bound, and the first has its minimum beside it where
    /// the slope there says. With the curvature known one step leads there, however far the first one might go with the second free.
    #[test]
    fn beside_a_coordinate_on_its_bound_a_step_is_no_longer_than_the_valley_is_wide() {
        let hessian = DMatrix::from_row_slice(2, 2, &[200.0, 199.9, 199.9, 200.0]);
        let middle = DVector::from_vec(vec![-3.0, 3.0]);
        let valley = |x: &[f64]| {
            let off = DVector::from_column_slice(x) - &middle;
            0.5 * off.dot(&(&hessian * &off))
        };
        let bounds = [(-10.0, 10.0), (-10.0, 0.0)];
        // d/dx at y = 0: 200 (x + 3) - 199.9 * 3 = 0
        let there = 3.0 * 199.9 / 200.0 - 3.0;
        // The second coordinate presses on its bound at the first start, is drawn away from it by its slope at the next, and comes to it from
        // the last.
        for (first, second) in [(-0.05, 0.0), (0.05, 0.0), (0.2, -0.1)] {
            let inverse = hessian.clone().try_inverse();
            let found = minimise(&valley, &[first, second], inverse, &bounds, TO_THE_END);
            assert!(found.converged);
            let off = (found.point[0] - there).abs();
            assert!(off < 2.0 * STEP, "{first}: {:?}", found.point);
            assert_eq!(found.point[1], 0.0);
            // the start, its slope, the step, and at most one slope and step more
            assert!(found.evaluations <= 8, "{first}: {}", found.evaluations);
        }
    }
}

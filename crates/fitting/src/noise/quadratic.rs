//! The quadratic model of a search: slopes and a symmetric Hessian, and the steps to where it is least.
//!
//! The Hessian B is learnt from the steps that are taken by the symmetric update of rank one,
//!
//! ```text
//! B + r r' / (r's),   r = y - B s,
//! ```
//!
//! s a step and y the change of the slope. On a quadratic it is exact after as many steps as there are coordinates, whatever their lengths, and
//! it knows where the curvature is negative. (BFGS cannot tell that, and between two valleys it took steps a hundred times too long for dozens of
//! them.) What is short and what is long is told by the curvature E that may be expected: the model's own is taken by the amount of its
//! eigenvalues relative to E, and damping adds to them.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// Least curvature over the expected one that is believed.
const LEAST: f64 = 0.01;
/// An update whose denominator is less than this share of its two factors tells nothing.
const NOTHING: f64 = 1e-8;

/// Slopes are given, the Hessian is learnt.
pub(super) struct Quadratic {
    pub(super) hessian: DMatrix<f64>,
    /// Root of the expected curvature, E = L L'.
    expected: Cholesky<f64, Dyn>,
}

impl Quadratic {
    /// With a positive definite curvature that may be expected, and a Hessian where one is known.
    pub(super) fn new(expected: DMatrix<f64>, hessian: Option<DMatrix<f64>>) -> Self {
        let n = expected.nrows();
        let hessian = hessian.unwrap_or_else(|| expected.clone());
        let unit = || Cholesky::new(DMatrix::identity(n, n)).expect("the unit matrix has a root");
        Self {
            expected: Cholesky::new(expected).unwrap_or_else(unit),
            hessian,
        }
    }

    /// The inverse of L V (|D| + damping) V' L', L^-1 B L'^-1 = V D V'.
    fn inverse(&self, damping: f64) -> DMatrix<f64> {
        let root = self.expected.l();
        let half = |of: &DMatrix<f64>| root.solve_lower_triangular(of).expect("L is regular");
        let relative = half(&half(&self.hessian).transpose());
        let eigen = (&relative + relative.transpose())
            .scale(0.5)
            .symmetric_eigen();
        let scales = eigen
            .eigenvalues
            .map(|d| 1.0 / (d.abs().max(LEAST) + damping).sqrt());
        let turned = root
            .tr_solve_lower_triangular(&eigen.eigenvectors)
            .expect("L is regular");
        let scaled = turned * DMatrix::from_diagonal(&scales);
        &scaled * scaled.transpose()
    }

    /// What the model changes by along a step.
    pub(super) fn change(&self, step: &DVector<f64>, slope: &DVector<f64>) -> f64 {
        slope.dot(step) + 0.5 * step.dot(&(&self.hessian * step))
    }

    /// Learns from a step and the change of the slope along it.
    pub(super) fn update(&mut self, step: &DVector<f64>, change: &DVector<f64>) {
        let off = change - &self.hessian * step;
        let along = off.dot(step);
        if along.abs() > NOTHING * off.norm() * step.norm() {
            self.hessian += &off * off.transpose() / along;
        }
    }

    /// The step from `x` to where the damped model is least within the bounds.
    pub(super) fn step(
        &self,
        x: &DVector<f64>,
        slope: &DVector<f64>,
        bounds: &[(f64, f64)],
        damping: f64,
    ) -> DVector<f64> {
        step_within(x, slope, &self.inverse(damping), bounds)
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    const WIDE: [(f64, f64); 3] = [(-10.0, 10.0); 3];

    fn saddle() -> DMatrix<f64> {
        DMatrix::from_row_slice(3, 3, &[900.0, 20.0, -5.0, 20.0, 3.0, 1.0, -5.0, 1.0, -2.0])
    }

    /// After steps in as many directions as there are coordinates the Hessian is exact, short steps or long, whatever its signs.
    #[test]
    fn the_hessian_is_learnt_whatever_its_signs() {
        let truth = saddle();
        let mut model = Quadratic::new(DMatrix::identity(3, 3), None);
        for step in [[1e-3, 0.02, 0.1], [0.0, -0.5, 0.01], [2e-2, 0.0, 0.3]] {
            let step = DVector::from_row_slice(&step);
            model.update(&step, &(&truth * &step));
        }
        assert!((&model.hessian - &truth).amax() < 1e-6, "{}", model.hessian);
    }

    /// Every step leads down, where the curvature is negative as well, and a damped one is shorter.
    #[test]
    fn steps_lead_down() {
        let model = Quadratic::new(DMatrix::identity(3, 3) * 2.0, Some(saddle()));
        let slope = DVector::from_row_slice(&[1.0, -2.0, 0.5]);
        let origin = DVector::zeros(3);
        let [free, damped] = [0.0, 3.0].map(|damping| model.step(&origin, &slope, &WIDE, damping));
        assert!(free.dot(&slope) < 0.0 && damped.dot(&slope) < 0.0);
        assert!(damped.norm() < free.norm());
    }
}

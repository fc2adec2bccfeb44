//! Which entries of Hessian and Jacobian are not zero everywhere.
//!
//! Blocks name all their variables, but most rows know few of them. Derivatives at a point a little beside the start, with multipliers
//! that are all different from zero, show the others. What this one point hides is taken up when it appears (`NewtonSystem::grow`).

use crate::convexify;
use crate::iterate::Iterate;
use crate::model::Evaluator;
use crate::newton::NewtonSystem;

/// Distance of the point, in scales of the variables: enough that no entry vanishes by chance.
const BESIDE: f64 = 1e-3;
/// Multiples of this, modulo one, are spread evenly (the golden ratio).
const GOLDEN: f64 = 0.618_033_988_749_895;

/// Lays out the Newton matrix for the entries that a point beside `at` shows.
pub(crate) fn probe(e: &dyn Evaluator, at: &Iterate, newton: &mut NewtonSystem) {
    let s = e.structure();
    let spread = |k: usize| 0.5 + (k as f64 * GOLDEN).fract();
    let x: Vec<f64> =
        at.x.iter()
            .enumerate()
            .map(|(k, x)| x + BESIDE * spread(k))
            .collect();
    let y: Vec<f64> = (0..s.rows()).map(spread).collect();
    let (mut rows, mut gradient) = (vec![0.0; s.rows()], vec![0.0; s.variables()]);
    let mut jacobian = vec![0.0; s.jacobian.len()];
    e.first(&x, &mut rows, &mut gradient, &mut jacobian);
    let mut groups = vec![Vec::new(); s.groups.len()];
    e.second(&x, 1.0, &y, &mut groups);
    let mut hessian = vec![0.0; s.hessian.len()];
    convexify::assemble(s, &groups, &mut hessian);
    newton.grow(s, &hessian, &jacobian);
}

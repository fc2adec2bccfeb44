//! Sizes in which the likelihood has steps.
//!
//! A gap is crossed at some moment between two samples, and the force of the next sample tells only that it was: the likelihood
//! of such a size g falls in steps with long treads between them. A fit that follows slopes stops at the edge of a tread, and
//! the curvature there says nothing of how far the tread goes. So the size is moved along a ladder, all other parameters
//! following linearly:
//!
//! ```text
//! D(g) = |V(s)^-1/2 (I - QQ') W (measured - predicted(g))|^2,   Q an orthonormal basis of the other parameters' W J     (D6)
//! ```
//!
//! The estimate is where D is least; its interval holds all g up to the edges where D has risen by the square of Student's t.

use nalgebra::DMatrix;

use crate::bench::Bench;
use crate::ground::orthonormal;
use crate::intervals::student;
use crate::stand::{Likelihood, Stand};
use crate::subset::Subset;

/// Rungs of the ladder each way, and the ratio from one to the next: four times as large and a quarter.
const RUNGS: i32 = 16;
const RATIO: f64 = 1.09;
/// Bisections of an edge between two rungs.
const BISECTIONS: usize = 8;
/// What D must fall by to leave the fit's own size.
const WORTH: f64 = 0.5;
/// Steps of the fit that follows.
const STEPS: u64 = 20;

/// D of (D6) for one size of one effect of a stand.
struct Profile<'a> {
    bench: &'a Bench<'a>,
    subset: &'a Subset,
    stand: &'a Stand,
    /// Place of the size among all parameters.
    column: usize,
    /// Q.
    basis: DMatrix<f64>,
    scatter: f64,
    upper: f64,
}

impl<'a> Profile<'a> {
    /// Of the k-th effect; `None` where its likelihood has no steps.
    fn new(bench: &'a Bench<'a>, subset: &'a Subset, stand: &'a Stand, k: usize) -> Option<Self> {
        let model = &stand.fitted.model;
        let own = bench.catalogue[stand.fitted.effects[k]].stepped()?;
        let column = model.span(k).start + own;
        let others: Vec<usize> = (0..stand.columns.len())
            .filter(|&c| stand.columns[c] != column)
            .collect();
        let basis = orthonormal(&stand.white_jacobian.select_columns(&others), 1e-9).0;
        Some(Self {
            bench,
            subset,
            stand,
            column,
            basis,
            scatter: stand.ground.likeliest_scatter(),
            upper: model.parameters()[column].upper,
        })
    }

    fn own(&self) -> f64 {
        self.stand.fitted.parameters[self.column]
    }

    fn at(&self, size: f64) -> f64 {
        let Stand { fitted, ground, .. } = self.stand;
        let mut parameters = fitted.parameters.clone();
        parameters[self.column] = size;
        let predicted = fitted.model.predict(&self.bench.experiment, &parameters);
        let measured = &self.bench.experiment.measured_n;
        let left = measured.iter().zip(&predicted).map(|(y, f)| y - f);
        let left = DMatrix::from_iterator(predicted.len(), 1, left);
        let white = self.stand.whiten(self.subset, &left);
        let free = &white - &self.basis * self.basis.tr_mul(&white);
        ground.descatter(&free, self.scatter).norm_squared()
    }

    /// Sizes and D, from the smallest on.
    fn ladder(&self) -> Vec<(f64, f64)> {
        (-RUNGS..=RUNGS)
            .map(|rung| self.own() * RATIO.powi(rung))
            .filter(|size| *size <= self.upper)
            .map(|size| (size, self.at(size)))
            .filter(|(_, d)| d.is_finite())
            .collect()
    }

    /// The edge between a size inside and one outside.
    fn edge(&self, mut inside: f64, mut outside: f64, level: f64) -> f64 {
        for _ in 0..BISECTIONS {
            let middle = (inside * outside).sqrt();
            if self.at(middle) <= level {
                inside = middle;
            } else {
                outside = middle;
            }
        }
        outside
    }
}

/// The stand with every size that has steps where D is least.
pub(crate) fn levelled(bench: &Bench<'_>, subset: &Subset, mut stand: Stand) -> Stand {
    for k in 0..stand.fitted.effects.len() {
        let Some(profile) = Profile::new(bench, subset, &stand, k) else {
            continue;
        };
        let at_own = profile.at(profile.own());
        let least = profile
            .ladder()
            .into_iter()
            .min_by(|a, b| a.1.total_cmp(&b.1));
        let Some((size, _)) = least.filter(|(_, d)| *d < at_own - WORTH) else {
            continue;
        };
        let mut start = stand.fitted.parameters.clone();
        start[profile.column] = size;
        let whitener = stand.scattered(profile.scatter);
        let effects = &stand.fitted.effects;
        let Some(fit) = bench.fit(subset, effects, &start, &whitener, None, STEPS) else {
            continue;
        };
        let after = Likelihood::of(bench, subset, &fit, stand.sizes);
        if after.deviance < stand.deviance {
            stand = Stand::at(bench, subset, fit, stand.sizes, after);
        }
    }
    stand
}

/// The 95 % interval of the k-th effect's size, where its likelihood has steps; `None` where it has none or where the ladder ends
/// inside.
pub(crate) fn interval(
    bench: &Bench<'_>,
    subset: &Subset,
    stand: &Stand,
    k: usize,
) -> Option<(usize, [f64; 2])> {
    let profile = Profile::new(bench, subset, stand, k)?;
    let rungs = profile.ladder();
    let best = (0..rungs.len()).min_by(|&a, &b| rungs[a].1.total_cmp(&rungs[b].1))?;
    let freedom = stand.ground.scatter_freedom().max(1) as f64;
    let level = rungs[best].1 + student(freedom).powi(2);
    let below = (0..best).rev().find(|&i| rungs[i].1 > level)?;
    let above = (best..rungs.len()).find(|&i| rungs[i].1 > level)?;
    let lower = profile.edge(rungs[below + 1].0, rungs[below].0, level);
    let upper = profile.edge(rungs[above - 1].0, rungs[above].0, level);
    let own = profile.column - stand.fitted.model.span(k).start;
    Some((own, [lower, upper]))
}

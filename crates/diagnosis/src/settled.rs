//! A model under its own noise: fitted, the noise estimated beside it, fitted again.

use fitting::noise::{Search, Sizes, Whitener};
use nalgebra::DMatrix;

use crate::bench::{Bench, Fitted};
use crate::joint::is_dear;
use crate::scan::{Scan, smooth_beside};
use crate::selection::{Start, Warm};
use crate::stand::{Likelihood, Stand};
use crate::steps::levelled;
use crate::subset::Subset;

/// Scatter between runs that is likeliest beside the fitted model.
pub(crate) fn likely_scatter(stand: &Stand) -> f64 {
    stand.ground.likeliest_scatter()
}

/// Law alone and its noise.
pub(crate) fn law_alone(bench: &Bench<'_>, subset: &Subset, start: Start<'_>) -> Option<Stand> {
    let first_sizes = match start {
        Start::Near(w) => w.law_sizes,
        Start::Scratch | Start::Law(_) => bench.first_sizes(),
    };
    let fitted = match start {
        Start::Scratch => bench.law_fit(subset, &first_sizes, f64::INFINITY)?,
        Start::Law(fitted) => fitted.clone(),
        Start::Near(w) => {
            let model = bench.model(&[])?;
            let mut start = model.at_null(&w.law[..model.law_parameters()], &bench.experiment);
            let shared = start.len().min(w.law.len());
            start[..shared].copy_from_slice(&w.law[..shared]);
            let scale = model.friction(&bench.experiment, &start);
            let context = subset.context(bench, &scale);
            let whitener = Whitener::new(&context, &first_sizes);
            bench.fit(subset, &[], &start, &whitener, None, 20)?
        }
    };
    under_its_noise(bench, subset, fitted, first_sizes, start.warm())
}

/// A fit, the noise beneath it, and the fit under that noise. `warm`: another selection on nearly the same data, where the first sizes are those
/// of its noise, whose kind is this one's, and not only something to begin with.
pub(crate) fn under_its_noise(
    bench: &Bench<'_>,
    subset: &Subset,
    fitted: Fitted,
    first_sizes: Sizes,
    warm: Option<&Warm>,
) -> Option<Stand> {
    if let Some(warm) = warm {
        let smooth = smooth_beside(bench, &fitted, &warm.signatures);
        return settle_in_kind(bench, subset, &fitted, &smooth, first_sizes);
    }
    let mut sizes = first_sizes;
    let mut stand = Stand::new(bench, subset, fitted, sizes);
    let rounds: [fn(Sizes) -> Search; 2] = [|_| Search::Near, Search::Onward];
    for search in rounds {
        let smooth = smooth_beside(bench, &stand.fitted, &[]);
        let noise = bench.noise(
            subset,
            &stand.fitted,
            &stand.jacobian,
            &smooth,
            search(sizes),
        );
        sizes = noise.sizes;
        stand = refit(bench, subset, &stand.fitted, &sizes)?;
    }
    Some(stand)
}

/// The same model fitted again under other sizes of the noise. The noise's scale is the fit's own friction: a fit that is nearer
/// under the old scale and less likely under its own (friction that hides behind the scatter between runs) is not taken.
fn refit(bench: &Bench<'_>, subset: &Subset, fitted: &Fitted, sizes: &Sizes) -> Option<Stand> {
    let before = Likelihood::of(bench, subset, fitted, *sizes);
    let whitener = before.scattered(sizes.scatter);
    let dear = fitted.effects.iter().any(|&e| is_dear(bench, e));
    let limit = if dear { 6 } else { 20 };
    let (effects, start) = (&fitted.effects, &fitted.parameters);
    let fit = bench.fit(subset, effects, start, &whitener, None, limit)?;
    let after = Likelihood::of(bench, subset, &fit, *sizes);
    let stand = if after.deviance <= before.deviance {
        Stand::at(bench, subset, fit, *sizes, after)
    } else {
        Stand::at(bench, subset, fitted.clone(), *sizes, before)
    };
    Some(levelled(bench, subset, stand))
}

/// A new model: noise estimated beside it, fitted again.
pub(crate) fn settle(
    bench: &Bench<'_>,
    subset: &Subset,
    fit: &Fitted,
    found: &Scan,
) -> Option<Stand> {
    if let Some(sizes) = found.sizes.filter(|_| found.of_their_kind) {
        return settle_in_kind(bench, subset, fit, &found.smooth, sizes);
    }
    let (jacobian, _) = bench.jacobian(subset, fit);
    let search = found.sizes.map_or(Search::Scratch, Search::Again);
    let noise = bench.noise(subset, fit, &jacobian, &found.smooth, search);
    refit(bench, subset, fit, &noise.sizes)
}

/// The same with noise of just the kind of these sizes, whose mean may hold the columns `within`.
pub(crate) fn settle_in_kind(
    bench: &Bench<'_>,
    subset: &Subset,
    fit: &Fitted,
    within: &DMatrix<f64>,
    sizes: Sizes,
) -> Option<Stand> {
    let (jacobian, _) = bench.jacobian(subset, fit);
    let sizes = bench.noise_of_their_kind(subset, fit, &jacobian, within, sizes);
    refit(bench, subset, fit, &sizes)
}

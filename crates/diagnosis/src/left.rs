//! What is left beside a fitted model, whatever it is: smooth structure over the plate, speed, time, load or the force's slope,
//! short bursts, marks on the plate, gains that some runs share, shifts of level within a run, a line in time where no cause may be one. The searches pay for one another by Bonferroni's bound.

use nalgebra::DMatrix;

use crate::answer::Place;
use crate::bench::Bench;
use crate::bursts::bursts;
use crate::general::{self, Lack};
use crate::lines::line_in_time;
use crate::marks::{self, Mark};
use crate::patterns::patterns;
use crate::selection::ALPHA_GENERAL;
use crate::shifts::shifts;
use crate::stand::Stand;
use crate::subset::Subset;

/// Of it, the share that the search for marks on the plate may spend, that for gains that some runs share, that for shifts within a run, and that for
/// a line in time: a mark that matters is far beyond the roughness, such a gain far beyond the scatter, such a shift far beyond what other runs do, and
/// such a line is in all of them.
const SMALL_SHARE: f64 = 0.05;

/// The general lack-of-fit test beside a stand.
pub(crate) fn lack(bench: &Bench<'_>, subset: &Subset, stand: &Stand) -> Lack {
    let samples = subset.samples_on_the_plate(bench);
    let scale: Vec<f64> = subset
        .gather(stand.fitted.friction(bench))
        .iter()
        .copied()
        .collect();
    let names = bench.run_names(subset);
    let beyond = stand.beyond_rounding(bench, subset);
    let coarse = (beyond.as_ref()).map(|residual| stand.ground_of_residual(bench, residual));
    let ground = coarse.as_ref().unwrap_or(&stand.ground);
    let smooth = || {
        let recorded = subset.gather(&stand.fitted.prediction);
        let length = stand.sizes.length;
        let families = general::families(&samples, &scale, recorded.as_slice(), length);
        let each = families.iter();
        let white: Vec<DMatrix<f64>> = each.map(|f| stand.whiten_own(&f.columns)).collect();
        general::test(ground, &families, &white, &samples, &names)
    };
    let mark = || marks::find(bench, subset, stand, ground).map(|found| found.strongest);
    let others = || {
        let pattern = patterns(ground, stand.white_gains(), &samples, &names);
        let shift = shifts(stand, ground, &samples, &scale, &names);
        let line = line_in_time(bench, subset, stand, &samples, &scale);
        let residual = beyond.clone();
        let residual = residual.unwrap_or_else(|| stand.fitted.residual(bench, subset));
        let innovations = stand.innovations(bench, subset, &residual);
        let burst = bursts(&innovations, &samples, &names, beyond.is_some());
        (burst, [Some(pattern), Some(shift), line])
    };
    let (mark, (smooth, (burst, small))) = rayon::join(mark, || rayon::join(smooth, others));
    let paid = |mut lack: Lack, share: f64| {
        lack.log_p = (lack.log_p - share.ln()).min(0.0);
        lack
    };
    let mark = paid(mark.map_or_else(Lack::nothing, Mark::lack), SMALL_SHARE);
    let small: Vec<Lack> = (small.into_iter().flatten())
        .map(|lack| paid(lack, SMALL_SHARE))
        .collect();
    let half = 0.5 - 0.5 * (1 + small.len()) as f64 * SMALL_SHARE;
    let mut best = mark.clone();
    for other in [paid(smooth, half), paid(burst, half)]
        .into_iter()
        .chain(small)
    {
        if other.log_p < best.log_p {
            best = other;
        }
    }
    // Where a mark is seen on its own, it says most closely where.
    if best.place.as_ref().is_some_and(Place::is_on_plate) && mark.log_p < ALPHA_GENERAL.ln() {
        best.place = mark.place;
    }
    best
}

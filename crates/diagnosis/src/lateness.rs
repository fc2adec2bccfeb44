//! How late the record tells of the plate.
//!
//! Where the force channel lags behind the velocity, or the velocity behind the motion, a sample's roughness is that of the place
//! x - t v, t the lateness in seconds: two directions see the same plate apart by twice that way. Whatever makes the record late,
//! noise that is looked up at the recorded places is then wrong, and lines are found in it that no texture made. The lateness
//! belongs to the noise, not to a cause: it is taken from the roughness alone, near what the fitted causes suggest, and all
//! causes are compared with it. (A filter does not shift every wavelength alike, so that the two need not agree.)

use crate::bench::Bench;
use crate::scan::Scan;
use crate::selection::settle;
use crate::stand::Stand;
use crate::subset::Subset;

/// Shares of the suggested lateness that are tried.
const SHARES: [f64; 6] = [0.25, 0.5, 0.7, 0.85, 1.0, 1.2];
/// What a lateness must save in deviance.
const WORTH: f64 = 10.0;

/// A stand with the plate looked up as late as suits its residual, the subset with it; and whether that moved anything.
pub(crate) fn looked_up(
    bench: &Bench<'_>,
    subset: &mut Subset,
    stand: Stand,
) -> Option<(Stand, bool)> {
    let Some(later) = later(bench, subset, &stand) else {
        return Some((stand, false));
    };
    *subset = later;
    let found = Scan::empty(bench, Some(stand.sizes));
    let stand = settle(bench, subset, &stand.fitted, &found)?;
    Some((stand, true))
}

/// The subset with the lateness that suits a stand's residual best; `None` where the one it has is as good.
fn later(bench: &Bench<'_>, subset: &Subset, stand: &Stand) -> Option<Subset> {
    let suggested = stand.fitted.model.lateness_s(&stand.fitted.parameters);
    if suggested == 0.0 || subset.is_averaged() {
        return None;
    }
    let worth = |subset: &Subset| stand.deviance_with(bench, subset, stand.sizes);
    SHARES
        .iter()
        .map(|share| subset.late_by(share * suggested))
        .map(|later| (worth(&later), later))
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .filter(|best| best.0 < worth(subset) - WORTH)
        .map(|best| best.1)
}

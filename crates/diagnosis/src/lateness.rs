//! How late the record tells of the plate.
//!
//! Where the force channel lags behind the velocity, or the velocity behind the motion, a sample's roughness is that of the place
//! x - t v, t the lateness in seconds: two directions see the same plate apart by twice that way. A filter of the channel smooths
//! roughness as well, its own of every run too. Whatever makes the record late, noise that is looked up at the recorded places, as
//! rough as without a filter, is then wrong, and lines are found in it that no texture made. The lateness belongs to the noise,
//! not to a cause: it is taken from the roughness alone, as a delay or as a filter, near what the fitted causes suggest, and all
//! causes are compared with it.

use fitting::noise::{Sizes, left_s};

use crate::bench::Bench;
use crate::scan::Scan;
use crate::selection::Depth;
use crate::settled::settle;
use crate::stand::Stand;
use crate::subset::Subset;

/// Shares of the suggested lateness that are tried.
const SHARES: [f64; 6] = [0.25, 0.5, 0.7, 0.85, 1.0, 1.2];
/// What a lateness must save in deviance.
const WORTH: f64 = 10.0;

/// What the record does to roughness.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Lateness {
    /// Pure delay, s.
    pub(crate) delay_s: f64,
    /// Time constant of a first-order filter, s.
    pub(crate) lag_s: f64,
    /// Whether roughness reaches the record past the resonance of a cord, as what rides on the transmitted force does, and not through it.
    pub(crate) past_resonance: bool,
}

impl Lateness {
    /// How late a sample tells of the plate once the filter is taken out, `step_s` after the sample before, s.
    pub(crate) fn at_s(self, step_s: f64) -> f64 {
        self.delay_s + left_s(step_s, self.lag_s)
    }

    /// As late without a filter.
    pub(crate) fn unfiltered(self) -> Self {
        self.delay(self.delay_s + self.lag_s)
    }

    fn delay(self, delay_s: f64) -> Self {
        Self {
            delay_s,
            lag_s: 0.0,
            ..self
        }
    }

    fn filter(self, lag_s: f64) -> Self {
        Self {
            delay_s: 0.0,
            lag_s,
            ..self
        }
    }
}

/// A stand with the plate looked up as late as suits its residual, the subset with it; and whether that moved anything. A fold keeps
/// to the kind of lateness that the whole campaign has.
pub(crate) fn looked_up(
    bench: &Bench<'_>,
    subset: &mut Subset,
    stand: Stand,
    depth: Depth,
) -> Option<(Stand, bool)> {
    let before = subset.lateness();
    let mut best = stand;
    if depth == Depth::Full
        && let Some((other, beside)) = past_resonance(bench, subset, &best)
    {
        (*subset, best) = (other, beside);
    }
    let suggested = best.fitted.model.lateness_s(&best.fitted.parameters);
    if suggested == 0.0 || subset.is_averaged() {
        return Some((best, subset.lateness() != before));
    }
    if let Some(later) = later(bench, subset, &best, suggested) {
        *subset = later;
        best = resettled(bench, subset, &best, Some(best.sizes))?;
    }
    let filtered = subset.lateness().lag_s > 0.0;
    if suggested > 0.0 && !filtered && depth == Depth::Full {
        // Behind a filter the roughness has other sizes than it seems to have.
        let other = subset.late_by(subset.lateness().filter(suggested));
        let behind = resettled(bench, &other, &best, None)?;
        if behind.deviance < best.deviance - WORTH {
            *subset = other;
            best = behind;
            if let Some(nearer) = later(bench, subset, &best, suggested) {
                *subset = nearer;
                best = resettled(bench, subset, &best, Some(best.sizes))?;
            }
        }
    }
    Some((best, subset.lateness() != before))
}

/// The stand with roughness that reaches the record past the resonance of its cord, and the subset with it, where that is likelier.
fn past_resonance(bench: &Bench<'_>, subset: &Subset, stand: &Stand) -> Option<(Subset, Stand)> {
    if subset.rings(bench, &stand.fitted).is_empty() {
        return None;
    }
    let other = subset.late_by(Lateness {
        past_resonance: true,
        ..subset.lateness()
    });
    let beside = resettled(bench, &other, stand, None)?;
    (beside.deviance < stand.deviance - WORTH).then_some((other, beside))
}

/// The stand's model under the noise that its runs have as late as the subset says.
fn resettled(
    bench: &Bench<'_>,
    subset: &Subset,
    stand: &Stand,
    sizes: Option<Sizes>,
) -> Option<Stand> {
    settle(bench, subset, &stand.fitted, &Scan::empty(bench, sizes))
}

/// The subset with the lateness of its kind that suits a stand's residual best; `None` where the one it has is as good.
fn later(bench: &Bench<'_>, subset: &Subset, stand: &Stand, suggested: f64) -> Option<Subset> {
    let kind = if subset.lateness().lag_s > 0.0 {
        Lateness::filter
    } else {
        Lateness::delay
    };
    let worth = |subset: &Subset| stand.deviance_with(bench, subset, stand.sizes);
    SHARES
        .iter()
        .map(|share| subset.late_by(kind(subset.lateness(), share * suggested)))
        .map(|later| (worth(&later), later))
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .filter(|best| best.0 < worth(subset) - WORTH)
        .map(|best| best.1)
}

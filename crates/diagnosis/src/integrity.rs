//! Causes that are looked for directly in the numbers: a clipped channel and a coarse one.
//!
//! A clipped channel repeats its extreme value: with white noise alone two samples agree to the last digit only by
//! chance, so that many equal extremes in a row are a flat top. A coarse channel has few distinct values: all
//! differences are multiples of one step that is large against the noise.

use campaign::Campaign;

/// Equal extreme samples in a row that make a flat top.
const FLAT: usize = 6;

/// What was found in the numbers themselves.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Integrity {
    /// Level at which the force clips, N.
    pub(crate) saturation: Option<f64>,
    /// Step of the force channel, N.
    pub(crate) resolution: Option<f64>,
}

/// Looks for a flat top and for a coarse step; `noise` is the white noise of the force channel, N.
pub(crate) fn inspect(campaign: &Campaign, noise: f64) -> Integrity {
    let step = coarse_step(campaign);
    Integrity {
        saturation: flat_top(campaign, step),
        resolution: step.filter(|s| is_coarse(*s, noise)),
    }
}

/// Whether a step of the force channel is more than its white noise hides (both N).
pub(crate) fn is_coarse(step: f64, noise: f64) -> bool {
    step > 1.5 * noise
}

/// The largest |force| where at least two stretches or one long stretch of samples sit on it exactly.
fn flat_top(campaign: &Campaign, step: Option<f64>) -> Option<f64> {
    let top = campaign
        .runs
        .iter()
        .flat_map(|r| r.force_n.iter())
        .fold(0.0_f64, |m, f| m.max(f.abs()));
    if !(top > 0.0) {
        return None;
    }
    let tolerance = 1e-9 * top;
    let (mut on_top, mut longest, mut total) = (0, 0, 0);
    for run in &campaign.runs {
        on_top = 0;
        for f in &run.force_n {
            if (f.abs() - top).abs() <= tolerance {
                on_top += 1;
                total += 1;
                longest = longest.max(on_top);
            } else {
                on_top = 0;
            }
        }
    }
    let _ = on_top;
    // On a coarse channel neighbours agree by rounding: then the top must hold far more samples than its neighbour.
    let crowded = step.is_none_or(|s| {
        let below = campaign
            .runs
            .iter()
            .flat_map(|r| r.force_n.iter())
            .filter(|f| (f.abs() - (top - s)).abs() <= 0.25 * s)
            .count();
        total > 4 * (below + FLAT)
    });
    (longest >= FLAT && crowded).then_some(top)
}

/// The step of which all force values are multiples, where there are few distinct values.
fn coarse_step(campaign: &Campaign) -> Option<f64> {
    let mut values: Vec<f64> = campaign
        .runs
        .iter()
        .flat_map(|r| r.force_n.iter().copied())
        .collect();
    let n = values.len();
    values.sort_by(f64::total_cmp);
    let top = values[0].abs().max(values[n - 1].abs());
    values.dedup_by(|a, b| (*a - *b).abs() <= 1e-9 * top);
    if values.len() < 3 || values.len() > n / 4 {
        return None;
    }
    let step = values
        .windows(2)
        .map(|w| w[1] - w[0])
        .fold(f64::INFINITY, f64::min);
    let multiples = values.windows(2).all(|w| {
        let k = (w[1] - w[0]) / step;
        (k - k.round()).abs() < 0.02 * k.max(1.0)
    });
    // Over the whole span the rounding of single differences is lost.
    let span = values[values.len() - 1] - values[0];
    let step = span / (span / step).round();
    (multiples && step > 1e-6 * top).then_some(step)
}

//! A cause acts everywhere that its signature says: in every run, at every place, at all times.
//!
//! With d the fitted effect and y the residual without it (whitened, cleared of all else), the effect's own amplitude in a
//! group g of samples is a_g = d_g'y_g / d_g'd_g, and the same everywhere if the cause is the right one:
//!
//! ```text
//! H = sum_g d_g'd_g (a_g - mean a)^2  ~  chi-squared with (groups - 1) degrees of freedom                       (D5)
//! ```
//!
//! A burst in one run that looks like an oscillation, or a step on the plate that looks like a long wave, fails. What a wrong
//! shape of the right cause may do is allowed for: H must also exceed a share of the effect's whole size.

use nalgebra::{DMatrix, DVector};

use crate::bench::Bench;
use crate::ground::orthonormal;
use crate::stand::Stand;
use crate::subset::Subset;
use crate::tail::log_chi2_tail;

/// Bins of place and of time.
const BINS: usize = 8;
/// Share of d'd that a wrong shape of the right cause may leave uneven.
const UNEVEN: f64 = 0.3;
/// Tail probability below which unevenness counts.
const ALPHA: f64 = 1e-3;

/// Whether the k-th effect has one amplitude over runs, places and times.
pub(crate) fn is_uniform(bench: &Bench<'_>, subset: &Subset, stand: &Stand, k: usize) -> bool {
    let both = effect_and_residual(bench, subset, stand, k);
    let samples = subset.samples(bench);
    let bins = |x: &[f64]| -> Vec<usize> {
        let mut sorted = x.to_vec();
        sorted.sort_by(f64::total_cmp);
        let edges: Vec<f64> = (1..BINS).map(|b| sorted[b * sorted.len() / BINS]).collect();
        x.iter()
            .map(|v| edges.partition_point(|e| e <= v))
            .collect()
    };
    [
        samples.owner.clone(),
        bins(&samples.place),
        bins(&samples.time),
    ]
    .iter()
    .all(|groups| is_even(&both, groups))
}

/// Share of the evidence for the k-th effect that does not rest on blows: of the deviance that it saves what it would save if no
/// sample lay further than four standard deviations from the model with it, or what all samples but the most favourable one
/// promise for all. A single kick at the right moment looks like any cause that acts at such moments; a cause is seen in all of them.
pub(crate) fn share_without_blows(
    bench: &Bench<'_>,
    subset: &Subset,
    stand: &Stand,
    k: usize,
) -> f64 {
    let both = effect_and_residual(bench, subset, stand, k);
    calm_share(both.column(0).as_slice(), both.column(1).as_slice())
}

/// [`share_without_blows`] of an effect d and a residual y without it, both white.
fn calm_share(effect: &[f64], without: &[f64]) -> f64 {
    /// Standard deviations.
    const BLOW: f64 = 4.0;
    let each = || effect.iter().zip(without);
    let power = each()
        .map(|(d, _)| d * d)
        .sum::<f64>()
        .max(f64::MIN_POSITIVE);
    let along: f64 = each().map(|(d, y)| d * y).sum();
    let amplitude = along / power;
    let clipped = |(d, y): (&f64, &f64)| d * (d + (y - d).clamp(-BLOW, BLOW));
    let calm = each().map(clipped).sum::<f64>() / power;
    let without_one =
        |(d, y): (&f64, &f64)| (along - d * y) / (power - d * d).max(f64::MIN_POSITIVE);
    let least = each().map(without_one).fold(calm, f64::min).max(0.0);
    if amplitude > least {
        (least / amplitude).powi(2)
    } else {
        1.0
    }
}

/// The k-th fitted effect d and the residual y without it (n x 2): whitened, cleared of all else that is fitted and of the scatter.
fn effect_and_residual(
    bench: &Bench<'_>,
    subset: &Subset,
    stand: &Stand,
    k: usize,
) -> DMatrix<f64> {
    let fitted = &stand.fitted;
    let span = fitted.model.span(k);
    let mut bare = fitted.parameters.clone();
    for &i in bench.catalogue[fitted.effects[k]].sizes() {
        bare[span.start + i] = 0.0;
    }
    let without = fitted.model.predict(&bench.experiment, &bare);
    let effect = DMatrix::from_iterator(
        without.len(),
        1,
        fitted.prediction.iter().zip(&without).map(|(a, b)| a - b),
    );
    let rest: Vec<usize> = (0..stand.columns.len())
        .filter(|&c| !span.contains(&stand.columns[c]))
        .collect();
    let basis = orthonormal(&stand.white_jacobian.select_columns(&rest), 1e-9).0;
    let white: DVector<f64> = stand.whiten(subset, &effect).column(0).into_owned();
    let free = &white - &basis * basis.tr_mul(&white);
    let both = DMatrix::from_columns(&[free.clone(), &stand.ground.y + &free]);
    stand
        .ground
        .descatter(&both, stand.ground.likeliest_scatter())
}

/// The test (D5) over one grouping of the samples.
fn is_even(both: &DMatrix<f64>, groups: &[usize]) -> bool {
    let count = groups.iter().copied().max().map_or(0, |g| g + 1);
    let mut sums = vec![(0.0, 0.0); count];
    for (i, &g) in groups.iter().enumerate() {
        let d = both[(i, 0)];
        sums[g].0 += d * d;
        sums[g].1 += d * both[(i, 1)];
    }
    let whole: f64 = sums.iter().map(|s| s.0).sum();
    let present = sums.iter().filter(|s| s.0 > 1e-6 * whole);
    // Evenness is asked about the effect's own mean amplitude: a fit that stopped early is no burst.
    let common = sums.iter().map(|s| s.1).sum::<f64>() / whole.max(f64::MIN_POSITIVE);
    let (mut uneven, mut freedom) = (0.0, 0_usize);
    for (power, along) in present {
        uneven += (along - common * power).powi(2) / power;
        freedom += 1;
    }
    freedom < 2 || uneven < UNEVEN * whole || log_chi2_tail(uneven, freedom - 1) > ALPHA.ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    const EFFECT: [f64; 8] = [0.5, -1.0, 0.5, 2.0, -2.0, 1.0, 0.3, -0.7];

    #[test]
    fn an_effect_that_all_samples_show_keeps_its_evidence() {
        assert!((calm_share(&EFFECT, &EFFECT) - 1.0).abs() < 1e-12);
    }

    /// d'y is all from one sample: without it there is nothing.
    #[test]
    fn one_kick_at_the_right_moment_is_no_evidence() {
        let mut kick = [0.0; 8];
        kick[3] = 6.0;
        assert_eq!(calm_share(&EFFECT, &kick), 0.0);
        kick[3] = 3.0;
        assert_eq!(calm_share(&EFFECT, &kick), 0.0);
    }

    /// A kick of 9 beside an effect of 2 counts as one of 4 beyond it.
    #[test]
    fn a_kick_beside_an_effect_counts_as_far_as_tails_go() {
        let mut kicked = EFFECT;
        kicked[4] -= 7.0;
        let power: f64 = EFFECT.iter().map(|d| d * d).sum();
        let (whole, clipped) = (1.0 + 14.0 / power, 1.0 + 8.0 / power);
        let least = clipped.min(1.0);
        let share = calm_share(&EFFECT, &kicked);
        assert!((share - (least / whole).powi(2)).abs() < 1e-12, "{share}");
    }
}

//! An effect on the plate that the noise of the law alone has taken up.
//!
//! A texture is the same in all runs, as the plate's own roughness is, and where that may be larger or smoother than the runs' or of another
//! length it takes up most of it: under the law's own noise the score then says little, and not at which period. Periods are looked for beside a
//! plate as rough as its runs, too, and the likelihoods with and without the cause, each under its own noise, ask which of the two it is.

use fitting::noise::Sizes;
use rig::Station;

use crate::bench::Bench;
use crate::joint::joint_fits;
use crate::scan::{Candidate, Scan, scan_without};
use crate::selection::Warm;
use crate::settled::settle;
use crate::stand::Stand;
use crate::subset::Subset;
use crate::tail::log_chi2_tail;

/// Standard deviations of the score from which it is asked: what a search over periods finds on nothing stays below mostly.
const SUSPECT: f64 = 4.0;
/// How many times rougher than the runs a plate is that may hide something.
const ROUGHER: f64 = 1.25;

/// Whether the plate is so rough that it may hide something.
pub(crate) fn may_hide(sizes: Sizes) -> bool {
    sizes.plate > ROUGHER * sizes.private
}

/// A cause that the plate's roughness had taken up.
pub(crate) struct Recovered {
    pub(crate) stand: Stand,
    /// Deviance that it saves, each model under its own noise.
    pub(crate) saved: f64,
    /// Tail probability of that, the search paid for.
    pub(crate) log_p: f64,
}

/// The cause of the plate that saves most beside a stand, of those whose score is seen but does not pass. A fold looks beside the noise of
/// the whole campaign, too.
pub(crate) fn swallowed(
    bench: &Bench<'_>,
    subset: &Subset,
    stand: &Stand,
    found: &Scan,
    warm: Option<&Warm>,
) -> Option<Recovered> {
    if stand.sizes.plate <= 0.0 {
        return None;
    }
    let seen = under_suspicion(bench, found).filter_map(|suspect| {
        let background = |_: &Stand| suspect.score.background;
        recover(
            bench,
            subset,
            stand,
            (stand, found),
            (suspect, warm),
            background,
        )
    });
    let rough = match warm {
        Some(warm) => names_the_plate(bench, warm).then_some(warm.sizes),
        None => as_rough_as_its_runs(stand.sizes),
    };
    let beside_rough = rough.and_then(|sizes| {
        let rough = Stand::new(bench, subset, stand.fitted.clone(), sizes);
        let found = of_the_plate(bench, subset, &rough);
        let begun = (&rough, &found.with_sizes(None));
        let recovered = |suspect: &Candidate| {
            let background =
                |next: &Stand| background_under(bench, subset, stand, (suspect.cause, next.sizes));
            recover(bench, subset, stand, begun, (suspect, warm), background)
        };
        under_suspicion(bench, &found)
            .filter_map(recovered)
            .max_by(|a, b| a.saved.total_cmp(&b.saved))
    });
    seen.chain(beside_rough)
        .max_by(|a, b| a.saved.total_cmp(&b.saved))
}

/// Whether the whole campaign has named a cause of the plate: only then has a fold one to recover.
fn names_the_plate(bench: &Bench<'_>, warm: &Warm) -> bool {
    let mut causes = warm.causes.iter();
    causes.any(|&(cause, _)| bench.catalogue[cause].station() == Station::Surface)
}

/// Causes of the plate that are seen.
fn under_suspicion<'a>(
    bench: &'a Bench<'_>,
    found: &'a Scan,
) -> impl Iterator<Item = &'a Candidate> {
    let candidates = found.candidates.iter();
    candidates
        .filter(|c| bench.catalogue[c.cause].station() == Station::Surface && c.score.z() > SUSPECT)
}

/// The noise with a plate that is as rough as its runs, where it was rougher, smoother or of another length.
fn as_rough_as_its_runs(sizes: Sizes) -> Option<Sizes> {
    let rough = Sizes {
        plate: sizes.plate.min(sizes.private),
        plate_smoothing: sizes.smoothing,
        plate_ratio: 1.0,
        ..sizes
    };
    let is_another = sizes.plate_smoothing > sizes.smoothing || sizes.plate_ratio > 1.0;
    (is_another || may_hide(sizes)).then_some(rough)
}

/// A scan for the periodic causes of the plate alone.
fn of_the_plate(bench: &Bench<'_>, subset: &Subset, stand: &Stand) -> Scan {
    let is_of_the_plate = |&cause: &usize| {
        let cause = &bench.catalogue[cause];
        cause.station() == Station::Surface && cause.is_periodic()
    };
    let others: Vec<usize> = (0..bench.catalogue.len())
        .filter(|cause| !is_of_the_plate(cause))
        .collect();
    let scatter = stand.ground.likeliest_scatter();
    scan_without(bench, subset, stand, scatter, &others)
}

/// A suspect seen beside one stand, fitted there and settled; what it saves beside the stand as it is. Where roughness stands high over whole
/// bands of wavelengths, `background` times, a line there saves as much more.
fn recover(
    bench: &Bench<'_>,
    subset: &Subset,
    stand: &Stand,
    (beside, found): (&Stand, &Scan),
    (suspect, warm): (&Candidate, Option<&Warm>),
    background: impl Fn(&Stand) -> f64,
) -> Option<Recovered> {
    let fits = joint_fits(bench, subset, beside, &[suspect], 2, &[]);
    let (cause, fit, _) = fits.into_iter().next()?;
    let next = settle(bench, subset, &fit, &found.beneath(&fit, warm))?;
    let saved = stand.deviance - next.deviance;
    let evidence = saved.max(0.0) / background(&next);
    let search = suspect.log_p - suspect.score.log_p;
    let asked = bench.catalogue[cause].sizes().len();
    Some(Recovered {
        log_p: log_chi2_tail(evidence, asked) + search,
        saved,
        stand: next,
    })
}

/// How high a spectrum of the plate stands about its largest line, under the noise with which the line was settled: under the smaller one
/// beside which it was found all wavelengths stand high.
fn background_under(
    bench: &Bench<'_>,
    subset: &Subset,
    stand: &Stand,
    (cause, sizes): (usize, Sizes),
) -> f64 {
    let under = Stand::new(bench, subset, stand.fitted.clone(), sizes);
    let lines = of_the_plate(bench, subset, &under).candidates;
    let of_the_cause = lines.iter().filter(|line| line.cause == cause);
    let backgrounds = of_the_cause.map(|line| line.score.background);
    backgrounds.fold(1.0, f64::max)
}

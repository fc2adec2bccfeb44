//! An effect on the plate that the noise of the law alone has taken up.
//!
//! A texture is the same in all runs, as the plate's own roughness is, and where that may be smoother than the runs' it takes up most of a
//! weak one: under the law's own noise the score then says little. The likelihoods with and without the cause, each under its own
//! noise, ask which of the two it is.

use rig::Station;

use crate::bench::Bench;
use crate::joint::joint_fits;
use crate::scan::{Candidate, Scan};
use crate::settled::settle;
use crate::stand::Stand;
use crate::subset::Subset;
use crate::tail::log_chi2_tail;

/// Standard deviations of the score from which it is asked: what a search over periods finds on nothing stays below mostly.
const SUSPECT: f64 = 4.0;

/// A cause that the plate's roughness had taken up.
pub(crate) struct Recovered {
    pub(crate) stand: Stand,
    /// Deviance that it saves, each model under its own noise.
    pub(crate) saved: f64,
    /// Tail probability of that, the search paid for.
    pub(crate) log_p: f64,
}

/// The cause of the plate that saves most beside a stand, of those whose score is seen but does not pass.
pub(crate) fn swallowed(
    bench: &Bench<'_>,
    subset: &Subset,
    stand: &Stand,
    found: &Scan,
) -> Option<Recovered> {
    if stand.sizes.plate <= 0.0 {
        return None;
    }
    let suspects = found.candidates.iter().filter(|c| {
        bench.catalogue[c.cause].station() == Station::Surface && c.score.z() > SUSPECT
    });
    suspects
        .filter_map(|suspect| recover(bench, subset, stand, found, suspect))
        .max_by(|a, b| a.saved.total_cmp(&b.saved))
}

fn recover(
    bench: &Bench<'_>,
    subset: &Subset,
    stand: &Stand,
    found: &Scan,
    suspect: &Candidate,
) -> Option<Recovered> {
    let fits = joint_fits(bench, subset, stand, &[suspect], 2, &[]);
    let (cause, fit, _) = fits.into_iter().next()?;
    let next = settle(bench, subset, &fit, found)?;
    let saved = stand.deviance - next.deviance;
    let search = suspect.log_p - suspect.score.log_p;
    let asked = bench.catalogue[cause].sizes().len();
    Some(Recovered {
        log_p: log_chi2_tail(saved.max(0.0), asked) + search,
        saved,
        stand: next,
    })
}

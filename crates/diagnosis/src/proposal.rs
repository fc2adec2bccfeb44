//! What one round of the selection proposes: the cause that saves most beside what is named.

use crate::afresh::{afresh, strong};
use crate::bench::{Bench, Fitted};
use crate::joint::{joint_fits, survivors};
use crate::scan::Scan;
use crate::selection::{Depth, SHAPE_TOLERANCE, Single, Warm};
use crate::stand::Stand;
use crate::subset::Subset;
use crate::swallowed::Recovered;
use crate::tail::log_chi2_tail;

/// Joint fits tried in each round.
pub(crate) const SURVIVORS: usize = 6;
/// Share of the deviance promised by the best score that a search afresh must save.
const KEPT: f64 = 0.5;
/// How many times more than its score says a fit may save.
const NONLINEAR: f64 = 3.0;

/// Whether what is seen beside a named cause lies so far within the tolerance of that cause's shape that no fit can lift it
/// out: a fit saves more than its score says where an effect is far from linear, but not [`NONLINEAR`] times more.
pub(crate) fn cannot_matter(round: usize, found: &Scan, explained: f64) -> bool {
    let scores = found.candidates.iter().map(|c| c.score.z().powi(2));
    let most = scores.fold(0.0, f64::max);
    round > 0 && NONLINEAR * most < SHAPE_TOLERANCE.powi(2) * explained
}

/// The model that a round proposes.
pub(crate) enum Next {
    /// Fitted under the noise of the stand before.
    Fit(Box<Fitted>),
    /// With its own noise already.
    Settled(Box<Stand>),
}

/// What one round of the selection proposes.
pub(crate) struct Proposal {
    pub(crate) next: Next,
    /// Deviance that the new cause saves.
    pub(crate) drop: f64,
    /// Tail probability at which it was seen.
    pub(crate) log_p: f64,
    /// All that were fitted.
    pub(crate) tried: Vec<Single>,
}

impl From<Recovered> for Proposal {
    fn from(recovered: Recovered) -> Self {
        Self {
            next: Next::Settled(Box::new(recovered.stand)),
            drop: recovered.saved,
            log_p: recovered.log_p,
            tried: Vec::new(),
        }
    }
}

/// A stand and what is seen beside it: what a further cause is looked for in.
pub(crate) struct Seen<'a, 'b> {
    pub(crate) bench: &'a Bench<'b>,
    pub(crate) subset: &'a Subset,
    pub(crate) stand: &'a Stand,
    pub(crate) found: &'a Scan,
    pub(crate) warm: Option<&'a Warm>,
}

impl Seen<'_, '_> {
    /// The best further cause beside the stand. Where causes are strong, in what they score or in what a fit saves (beside a law that was
    /// bent to them, and its noise, they may score little), and where the law has run to a bound, the stand's parameters are not trusted.
    pub(crate) fn proposal(&self, threshold: f64, depth: Depth) -> Option<Proposal> {
        let best = self.found.candidates.first().map_or(0.0, |c| c.score.z());
        let strong = strong(self.bench);
        let mut afresh = (best > strong).then(|| self.afresh()).flatten();
        let keeps = |promised: f64, next: &Proposal| next.drop > KEPT * promised;
        if afresh
            .as_ref()
            .is_some_and(|next| keeps(best.powi(2), next))
        {
            return afresh;
        }
        let beside = self.beside(threshold, depth);
        let drop = beside.as_ref().map_or(0.0, |next| next.drop);
        let is_strong = drop > strong.powi(2);
        let at_bound = || self.stand.fitted.law_at_bounds().next().is_some();
        if best <= strong && (is_strong || self.warm.is_none() && at_bound()) {
            afresh = self.afresh();
        }
        // A search under the noise of a healthy rig may lose what the stand's own noise shows plainly; nor need a fit beside the stand keep
        // what its score promises: where the law is bent to two causes the tangent is far from either.
        let promised = if is_strong { drop } else { drop / KEPT };
        afresh.filter(|next| keeps(promised, next)).or(beside)
    }

    /// The best further cause where the stand's parameters cannot be trusted.
    fn afresh(&self) -> Option<Proposal> {
        let (bench, subset, stand) = (self.bench, self.subset, self.stand);
        let mut stands = afresh(bench, subset, stand, self.found, self.warm);
        let tried = stands
            .iter()
            .map(|(cause, stand)| Single {
                cause: *cause,
                fitted: stand.fitted.clone(),
            })
            .collect();
        if stands.is_empty() {
            return None;
        }
        let (cause, next) = stands.swap_remove(0);
        // Beside a law that was bent to a cause, its tangent there may score nothing: what the fit saves under the noise that the law
        // alone leaves is seen too.
        let saved = stand.deviance - stand.deviance_of(bench, subset, &next.fitted);
        let asked = bench.catalogue[cause].parameters().len();
        Some(Proposal {
            drop: next.deviance_of(bench, subset, &stand.fitted) - next.deviance,
            next: Next::Settled(Box::new(next)),
            log_p: (self.found.log_p_of(cause)).min(log_chi2_tail(saved.max(0.0), asked)),
            tried,
        })
    }

    /// The best of the causes that score best, each fitted together with the stand's model under the stand's noise.
    fn beside(&self, threshold: f64, depth: Depth) -> Option<Proposal> {
        let (most, starts) = match depth {
            Depth::Full => (SURVIVORS, 2),
            Depth::Fold => (3, 1),
        };
        let asked = survivors(self.bench, self.found, threshold, most);
        let known = self.warm.map_or(&[][..], |warm| &warm.causes);
        let fits = joint_fits(self.bench, self.subset, self.stand, &asked, starts, known);
        let (cause, fit, deviance) = fits.first().cloned()?;
        Some(Proposal {
            next: Next::Fit(Box::new(fit)),
            drop: self.stand.deviance - deviance,
            log_p: self.found.log_p_of(cause),
            tried: fits
                .into_iter()
                .map(|(cause, fitted, _)| Single { cause, fitted })
                .collect(),
        })
    }
}

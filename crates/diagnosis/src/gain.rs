//! What an extension gains on runs that it has not seen.
//!
//! Each fold leaves out one run of every repeated condition, or a whole condition of a richer campaign (`folds.rs`).
//! Noise, selection and extension are done again in every fold; a held-out run keeps its commands and its place in the
//! day and hides its force. Squared errors are pooled over folds:
//!
//! ```text
//! explained = (before^2 - after^2) / (before^2 - floor^2)                                              (D4)
//! ```
//!
//! with an interval from the differences between runs (Student's t over runs), and a placebo (`scrambled.rs`), judged by errors weighed by
//! the noise and the fold's own doubt (`weighed.rs`) where nothing is left unexplained.

use nalgebra::DMatrix;
use rayon::prelude::*;

use crate::answer::{Diagnosis, Gain};
use crate::bench::{Bench, Fitted};
use crate::folds::folds;
use crate::ground::orthonormal;
use crate::joint::forms_of;
use crate::judged::{Errors, Judged};
use crate::left::lack;
use crate::look_back::bare;
use crate::refusal::take_back;
use crate::scan::is_shift;
use crate::scrambled::{placebos, scrambled};
use crate::selection::{Depth, Selected, Warm, law_alone, likely_scatter, select};
use crate::stand::Stand;
use crate::subset::Subset;
use crate::weighed::{Weighed, beside_repeats};
use crate::whole::Whole;

/// Outcome of one fold.
pub(crate) struct Fold {
    pub(crate) held: Vec<usize>,
    /// Predictions for all recorded samples: law alone as its errors are stated, the law that names are judged against, and with what the
    /// fold selected.
    stated: Vec<f64>,
    law: Vec<f64>,
    pub(crate) extended: Vec<f64>,
    /// The same where the fold would have named what it took in; where not, the law's. Names are judged by it.
    firm: Vec<f64>,
    /// The same with what the whole campaign named in the place of what the fold took in its stead.
    named: Vec<f64>,
    /// The law's prediction on the record that was searched, beside which the placebos stand.
    searched: Vec<f64>,
    /// For each named cause: the extended model without it, where the fold named it.
    lacking: Vec<Option<Vec<f64>>>,
    /// Whether one of the named causes was found as plainly as a name must be.
    again: bool,
    /// Predictions with each scrambled extension.
    placebos: Vec<Vec<f64>>,
    /// J L of the fold's extension, all samples x directions: L L' is the covariance of its parameters (D11).
    pub(crate) doubt: DMatrix<f64>,
}

/// Gains of all findings together and of each when it comes last.
pub(crate) struct Gains {
    pub(crate) held_out_law: f64,
    pub(crate) joint: Option<Gain>,
    /// The gain that speaks for or against the names: beside a model from elsewhere a law that has bent to the data within its covariance
    /// stands in the place of the model, for all causes but the law's own parameters.
    judged: Option<Gain>,
    pub(crate) each: Vec<Option<Gain>>,
    /// Squared error that the named causes, fitted in each fold that found them or others in their stead, take off the unseen runs, in
    /// units of noise and doubt (D11); `None` where these are not known.
    seen: Option<f64>,
    /// Share of the folds that named one of the named causes again, or one that is tied to it.
    found_again: f64,
}

/// A drop (D11) that no noise makes: of a spurious extension whose predictions lie m from the law's it is normal about -m with variance
/// 4 m, so that a drop of D lies sqrt(D) standard deviations out or more, whatever m is.
const NO_NOISE: f64 = 25.0;
/// Share of the explainable error that a name must possibly explain on unseen runs.
const POSSIBLE: f64 = 0.5;
/// Share of the scrambled extensions that it must beat there, and the share below which it is worse than they are.
const BEATEN: f64 = 0.95;
const WORSE: f64 = 0.5;
/// Share of the folds that must find a name again whose drop on unseen runs may be noise.
const AGAIN: f64 = 1.0 / 3.0;

impl Gains {
    /// Why the unseen runs speak against what was named, if they do: scrambled signatures do better there, or as well while what is named
    /// can explain but a part of the error, or nobody knows how much; no fold found it again, or few did and it is not plain there; or its gain there may be none and not every fold found it.
    pub(crate) fn speak_against(&self) -> Option<&'static str> {
        let gain = self.judged.as_ref()?;
        let below = |share: f64| gain.placebo_exceeded.is_some_and(|beaten| beaten < share);
        // An effect that only one of a few held-out runs shows has an interval over runs that holds zero, however plain it is there.
        let plain = self.seen.is_some_and(|drop| drop > NO_NOISE);
        let a_part = gain.ci95.map_or(!plain, |[_, most]| most < POSSIBLE);
        if below(WORSE) || (below(BEATEN) && a_part) {
            return Some("does no better than scrambled ones");
        }
        if !plain && self.found_again < AGAIN {
            return Some(if self.found_again > 0.0 {
                "is found again by few of the others"
            } else {
                "is not found again by the others"
            });
        }
        let lost = self.seen.is_some_and(|drop| drop <= 0.0);
        // What every fold finds on its own needs no interval over few runs.
        let doubtful = self.found_again < 1.0 && gain.ci95.is_some_and(|[least, _]| least <= 0.0);
        ((doubtful || lost) && !plain).then_some("gains nothing that is seen")
    }

    /// What is left of them where the names were taken back.
    pub(crate) fn of_the_law(self) -> Self {
        Self {
            joint: None,
            judged: None,
            each: Vec::new(),
            ..self
        }
    }

    /// Writes them into the answer.
    pub(crate) fn enter(self, bench: &Bench<'_>, selected: &Selected, answer: &mut Diagnosis) {
        answer.baseline.held_out_rmse = Some(self.held_out_law);
        answer.gain = self.joint;
        for (own, &effect) in self.each.into_iter().zip(&selected.stand.fitted.effects) {
            let id = bench.catalogue[effect].id();
            if let Some(finding) = answer.findings.iter_mut().find(|f| f.cause == id) {
                finding.gain = own;
            }
        }
    }
}

/// Judges a selection by folds; `None` where no run can be left out.
///
/// `ties`: for each named cause, the causes that cannot be told from it: a fold that takes one of them in has found it.
pub(crate) fn judge(
    bench: &Bench<'_>,
    whole: &Whole<'_>,
    selected: &Selected,
    ties: &[Vec<usize>],
    floor_rmse: f64,
) -> Option<Gains> {
    let folds = folds(bench, whole, selected);
    if folds.is_empty() {
        return None;
    }
    let extended = &selected.stand.fitted;
    let named: Vec<Vec<usize>> = (0..extended.effects.len())
        .map(|k| {
            let tied = ties.get(k).into_iter().flatten().copied();
            forms_of(bench, extended.effects[k]).chain(tied).collect()
        })
        .collect();
    let shifted = bench.prior.is_some() && extended.effects.iter().any(|&e| is_shift(bench, e));
    let asked = Asked {
        warm: selected.warm(),
        scrambled: scrambled(bench, selected, shifted),
        shifted,
        named,
    };
    let done: Vec<Option<Fold>> = folds
        .par_iter()
        .map(|held| fold(bench, whole, held, &asked))
        .collect();
    let done: Vec<Fold> = done.into_iter().flatten().collect();
    if done.is_empty() {
        return None;
    }
    let weighed = Weighed::new(bench, whole, selected, &done);
    let pool = |prediction: &dyn Fn(&Fold) -> &[f64]| {
        Errors::pool(whole.bench, weighed.as_ref(), &done, prediction)
    };
    let stated = pool(&|f| &f.stated);
    let law = pool(&|f| &f.law);
    let extended = pool(&|f| &f.extended);
    let firm = pool(&|f| &f.firm);
    let found = pool(&|f| &f.named);
    // Errors are weighed by the noise only where the record that was searched is the whole one.
    let beside = |prediction: &dyn Fn(&Fold) -> &[f64]| {
        Errors::pool(bench, weighed.as_ref(), &done, prediction).judged()
    };
    let searched = beside(&|f| &f.searched);
    let judged = Judged {
        placebo: (0..asked.scrambled.len())
            .map(|p| searched - beside(&|f| &f.placebos[p]))
            .collect(),
        floor_rmse,
        beside_floor: beside_repeats(whole, selected, &done),
        weighed,
    };
    let named = asked.named.len();
    let gain = (named > 0).then(|| judged.gain(&law, &firm));
    let joint = (named > 0).then(|| Gain {
        placebo_exceeded: judged.gain(&law, &extended).placebo_exceeded,
        ..judged.gain(&stated, &extended)
    });
    let weighs = named > 0 && judged.weighed.is_some();
    let seen = weighs.then(|| law.judged() - found.judged());
    let each = (0..named)
        .map(|k| {
            let lacking = Errors::pool(whole.bench, judged.weighed.as_ref(), &done, &|f| {
                f.lacking[k].as_ref().unwrap_or(&f.extended)
            });
            Some(judged.gain(&lacking, &extended))
        })
        .collect();
    let again = done.iter().filter(|f| f.again).count();
    Some(Gains {
        held_out_law: stated.rmse(),
        joint,
        judged: gain,
        each,
        seen,
        found_again: again as f64 / done.len() as f64,
    })
}

/// What every fold is asked.
struct Asked {
    /// Where its selection starts.
    warm: Warm,
    /// For each named cause that cause and those that cannot be told from it.
    named: Vec<Vec<usize>>,
    /// The scrambled extensions.
    scrambled: Vec<Vec<f64>>,
    /// Whether one of the names is another value of the law's own parameters. Within the covariance of a model from elsewhere the law
    /// bends to the data instead, so that such a name gains something beside the model as it is stated only.
    shifted: bool,
}

fn fold(bench: &Bench<'_>, whole: &Whole<'_>, held: &[usize], asked: &Asked) -> Option<Fold> {
    let Asked {
        warm,
        named,
        shifted,
        ..
    } = asked;
    let kept: Vec<usize> = (0..bench.samples.runs.len())
        .filter(|k| !held.contains(k))
        .collect();
    let subset = Subset::new(bench, kept).turning(warm.turns);
    if named.is_empty() {
        // Nothing is named, nothing is gained: only the law's own error is asked for.
        let law = law_alone(bench, &subset, Some(warm))?.fitted;
        let prediction = whole.prediction(&law);
        return Some(Fold {
            held: held.to_vec(),
            stated: whole.stated_prediction(&law),
            extended: prediction.clone(),
            firm: prediction.clone(),
            named: prediction.clone(),
            law: prediction,
            searched: law.prediction,
            lacking: Vec::new(),
            again: false,
            placebos: Vec::new(),
            doubt: DMatrix::zeros(bench.samples.len(), 0),
        });
    }
    let own = select(bench, &subset, Depth::Fold, Some(warm))?;
    let subset = &own.subset;
    let full = &own.stand.fitted;
    let reference = reference(bench, &own.baseline.fitted, *shifted);
    let lacking = named
        .iter()
        .map(|cause| {
            let k = full.effects.iter().position(|e| cause.contains(e))?;
            let mut rest = full.effects.clone();
            rest.remove(k);
            if rest.is_empty() {
                return Some(whole.prediction(&reference));
            }
            if bench.prior.is_some() && is_shift(bench, full.effects[k]) {
                return bare(bench, full, k).map(|fit| whole.prediction(&fit));
            }
            let context = subset.context_of(bench, full);
            let whitener = own
                .stand
                .whitener
                .with_scatter(&context, own.stand.sizes.scatter);
            bench
                .fit(subset, &rest, &full.without(k), &whitener, None, 12)
                .map(|fit| whole.prediction(&fit))
        })
        .collect();
    let (law, extended) = (whole.prediction(&reference), whole.prediction(full));
    let instead = instead(bench, whole, &own, warm, named);
    let mut fold = Fold {
        held: held.to_vec(),
        stated: whole.stated_prediction(&own.baseline.fitted),
        placebos: placebos(bench, &own, &reference, &asked.scrambled, *shifted),
        searched: reference.prediction,
        lacking,
        again: named.iter().any(|cause| own.is_plain(cause)),
        firm: extended.clone(),
        named: instead,
        doubt: doubt(&own.stand),
        law,
        extended,
    };
    if !would_name(bench, own) {
        fold.again = false;
        fold.firm.clone_from(&fold.law);
        fold.named.clone_from(&fold.law);
    }
    Some(fold)
}

/// Whether a fold would have named something, were it the whole campaign.
fn would_name(bench: &Bench<'_>, mut own: Selected) -> bool {
    let effects = own.stand.fitted.effects.clone();
    if !own.is_plain(&effects) {
        return false;
    }
    own.left = lack(bench, &own.subset, &own.stand);
    take_back(bench, &mut own);
    !own.stand.fitted.effects.is_empty()
}

/// The law that an extension is judged against: the one that was fitted, or, where the names are its own parameters, as a model from
/// elsewhere states it.
pub(crate) fn reference(bench: &Bench<'_>, law: &Fitted, shifted: bool) -> Fitted {
    if shifted {
        bench.as_stated(law)
    } else {
        law.clone()
    }
}

/// The fold's extension, or, where the fold took something else in the stead of all that the whole campaign named, the fold's fit of that.
fn instead(
    bench: &Bench<'_>,
    whole: &Whole<'_>,
    own: &Selected,
    warm: &Warm,
    named: &[Vec<usize>],
) -> Vec<f64> {
    let full = &own.stand.fitted;
    let found = |cause: &Vec<usize>| full.effects.iter().any(|e| cause.contains(e));
    let refitted = || {
        let effects: Vec<usize> = warm.causes.iter().map(|(cause, _)| *cause).collect();
        let states = &full.parameters[full.model.initial_states()];
        let start: Vec<f64> = warm
            .extended_law
            .iter()
            .copied()
            .chain(warm.causes.iter().flat_map(|(_, own)| own.iter().copied()))
            .chain(states.iter().copied())
            .collect();
        let subset = &own.subset;
        let whitener = own
            .stand
            .whitener
            .with_scatter(&subset.context_of(bench, full), own.stand.sizes.scatter);
        bench.fit(subset, &effects, &start, &whitener, None, 20)
    };
    let other = !full.effects.is_empty() && !named.iter().any(found);
    match other.then(refitted).flatten() {
        Some(fit) => whole.prediction(&fit),
        None => whole.prediction(full),
    }
}

/// J L with L L' = (J' M'M J)^-1: by what a fit's prediction of each sample may be wrong, direction by direction.
fn doubt(stand: &Stand) -> DMatrix<f64> {
    let white = stand.white_descattered(likely_scatter(stand));
    &stand.jacobian * orthonormal(&white, 1e-9).1
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gains where no error is left to explain, so that the interval says nothing.
    fn gains(seen: f64, found_again: f64) -> Gains {
        Gains {
            held_out_law: 1.0,
            joint: None,
            judged: Some(Gain {
                held_out_rmse_before: 1.0,
                held_out_rmse_after: 1.001,
                explained_fraction: None,
                ci95: None,
                placebo_exceeded: Some(1.0),
            }),
            each: Vec::new(),
            seen: Some(seen),
            found_again,
        }
    }

    #[test]
    fn a_name_that_few_folds_find_again_needs_a_plain_drop() {
        let few = 1.0 / 6.0;
        assert!(gains(3.0, few).speak_against().is_some());
        assert_eq!(gains(3.0, 0.5).speak_against(), None);
        assert_eq!(gains(2.0 * NO_NOISE, few).speak_against(), None);
        assert!(gains(-1.0, 1.0).speak_against().is_some());
    }
}

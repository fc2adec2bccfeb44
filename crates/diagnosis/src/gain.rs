//! What an extension gains on runs that it has not seen.
//!
//! Each fold leaves out one run of every repeated condition, or a whole condition of a richer campaign (`folds.rs`).
//! Noise, selection and extension are done again in every fold, which takes in as many causes as the whole campaign has named; a
//! held-out run keeps its commands and its place in the day and hides its force. Squared errors are pooled over folds:
//!
//! ```text
//! explained = (before^2 - after^2) / (before^2 - floor^2)                                              (D4)
//! ```
//!
//! with an interval from the differences between runs (Student's t over runs), and a placebo (`scrambled.rs`), judged by errors weighed by
//! the noise and the fold's own doubt (`weighed.rs`) where nothing is left unexplained.

use rayon::prelude::*;

use crate::answer::{Diagnosis, Gain};
use crate::asked::is_shift;
use crate::bench::Bench;
use crate::fold::{Asked, Fold, fold};
use crate::folds::folds;
use crate::joint::forms_of;
use crate::judged::{Errors, Judged};
use crate::scrambled::scrambled;
use crate::selection::Selected;
use crate::weighed::{Weighed, beside_repeats};
use crate::whole::Whole;

/// Gains of all findings together and of each when it comes last.
pub(crate) struct Gains {
    pub(crate) held_out_law: f64,
    pub(crate) joint: Option<Gain>,
    /// The gain that speaks for or against the names: beside a model from elsewhere a law that has bent to the data within its covariance
    /// stands in the place of the model, for all causes but the law's own parameters. A fold that would name nothing on its own says that
    /// nothing is gained.
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

    /// Of several names the one that gains least of its own on unseen runs, where that is less than half of what is there and no more than
    /// scrambled signatures do: it came in beside the others and is not seen without its own force. One that is plain in the campaign
    /// itself stays: the few unseen runs that show it may not tell it from a scrambled one.
    pub(crate) fn surplus(&self, is_plain: impl Fn(usize) -> bool) -> Option<usize> {
        if self.each.len() < 2 {
            return None;
        }
        let share = |gain: &Gain| gain.explained_fraction.unwrap_or(0.0);
        let no_more = |gain: &Gain| gain.placebo_exceeded.is_some_and(|beaten| beaten < BEATEN);
        let each = self.each.iter().enumerate();
        each.filter_map(|(k, gain)| Some((k, gain.as_ref()?)))
            .filter(|(k, gain)| no_more(gain) && share(gain) < POSSIBLE && !is_plain(*k))
            .min_by(|a, b| share(a.1).total_cmp(&share(b.1)))
            .map(|(k, _)| k)
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
    bench.tell(|| {
        let count = folds.len();
        format!("selecting and extending again without some runs, in {count} folds")
    });
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

    /// The second of two names gains a third of what is there, no more than scrambled ones do.
    #[test]
    fn a_surplus_name_goes_unless_it_is_plain_in_the_campaign() {
        let own = |share: f64, beaten: f64| {
            Some(Gain {
                held_out_rmse_before: 1.0,
                held_out_rmse_after: 1.0,
                explained_fraction: Some(share),
                ci95: None,
                placebo_exceeded: Some(beaten),
            })
        };
        let two = Gains {
            each: vec![own(0.9, 1.0), own(0.3, 0.8)],
            ..gains(1.0, 1.0)
        };
        assert_eq!(two.surplus(|_| false), Some(1));
        assert_eq!(two.surplus(|k| k == 1), None);
        let alone = Gains {
            each: vec![own(0.3, 0.8)],
            ..gains(1.0, 1.0)
        };
        assert_eq!(alone.surplus(|_| false), None);
    }
}

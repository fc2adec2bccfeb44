//! Whether the stage went along the chords of its recorded velocity.
//!
//! Between samples a velocity is taken to bend as its samples do (the rig's M1). Where nobody has recorded the position, the force may say
//! that it did not: in the moments after a start or a turn of the motion, in which bristles are wound up, the way along the chords is
//! another one. The motions that suit a first fit of the law are asked first. Where the law in the end, or what is named beside it, fits plainly
//! better with the others, all is asked again with these, and the likelier of the two answers stands, with every name paid for.

use rig::Experiment;

use crate::bench::{Bench, Fitted};
use crate::selection::{Depth, Selected, Start, select};
use crate::stand::Stand;
use crate::subset::Subset;

/// -2 log likelihood that the other motions must save under the noise of those that were asked.
const PLAIN: f64 = 10.0;
/// Steps of a fit with the other motions, which begins where that with the first ones has ended.
const STEPS: u64 = 20;

/// A selection, and the bench of the motions that it rests on where these are straight between samples.
pub(crate) struct Chosen<'a> {
    pub(crate) selected: Selected,
    pub(crate) straight: Option<Bench<'a>>,
}

/// The whole selection with the motions that the force prefers; `None` where the law itself cannot be computed.
pub(crate) fn select_with_motions<'a>(bent: &Bench<'a>) -> Option<Chosen<'a>> {
    let ask = |(bench, start): (&Bench<'_>, Start<'_>)| {
        select(bench, &Subset::all(bench), Depth::Full, start)
    };
    let Some(chords) = bent.experiment.along_chords() else {
        return Some(Chosen {
            selected: ask((bent, Start::Scratch))?,
            straight: None,
        });
    };
    let straight = bent.with_motions(chords);
    let law = first_fit(bent)?;
    let is_straight = nearer(&straight, &Subset::all(bent), &law);
    let along_bends = (bent, Start::Law(&law.fitted));
    let along_chords = (&straight, Start::Scratch);
    let (first, second) = match is_straight {
        true => (along_chords, along_bends),
        false => (along_bends, along_chords),
    };
    let selected = ask(first)?;
    let other = other_motions_suit(second.0, &selected).then(|| {
        bent.tell(|| "asking again with other motions between the samples".to_owned());
        ask(second)
    });
    let likelier = (other.flatten()).filter(|other| other.worth() < selected.worth());
    let is_straight = is_straight != likelier.is_some();
    Some(Chosen {
        selected: likelier.unwrap_or(selected),
        straight: is_straight.then_some(straight),
    })
}

/// The law alone under the noise that is assumed at first.
fn first_fit(bent: &Bench<'_>) -> Option<Stand> {
    let (subset, sizes) = (Subset::all(bent), bent.first_sizes());
    let law = bent.law_fit(&subset, &sizes, f64::INFINITY)?;
    Some(Stand::new(bent, &subset, law, sizes))
}

/// Whether the law, or what was named beside it, fits plainly better with the other motions.
fn other_motions_suit(second: &Bench<'_>, selected: &Selected) -> bool {
    let nearer = |stand: &Stand| nearer(second, &selected.subset, stand);
    nearer(&selected.baseline) || nearer(&selected.stand)
}

/// Whether what is in a stand fits plainly better with other motions.
fn nearer(other: &Bench<'_>, subset: &Subset, stand: &Stand) -> bool {
    let Fitted {
        effects,
        parameters,
        ..
    } = &stand.fitted;
    let noise = stand.likely_noise();
    let fit = other.fit(subset, effects, parameters, &noise, None, STEPS);
    let deviance = fit.map(|fit| stand.deviance_of(other, subset, &fit));
    deviance.is_some_and(|deviance| deviance < stand.deviance - PLAIN)
}

impl<'a> Bench<'a> {
    /// The same questions with the motions of another experiment.
    fn with_motions(&self, experiment: Experiment) -> Self {
        Bench {
            experiment,
            redrawn: Default::default(),
            ..self.clone()
        }
    }
}

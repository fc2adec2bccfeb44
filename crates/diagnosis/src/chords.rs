//! Whether the stage went along the chords of its recorded velocity.
//!
//! Between samples a velocity is taken to bend as its samples do (the rig's M1). Where nobody has recorded the position, the force may say
//! that it did not: in the moments after a start or a turn of the motion, in which bristles are wound up, the way along the chords is
//! another one. A law, or what is named beside it, that fits plainly better along the chords is asked again as a whole, all motions straight, and
//! the likelier of the two answers stands, with every name paid for.

use rig::Experiment;

use crate::bench::{Bench, Fitted};
use crate::selection::{Depth, Selected, select, strict};
use crate::settled::likely_scatter;
use crate::stand::Stand;
use crate::subset::Subset;

/// -2 log likelihood that chords must save under the noise of the bends before all is asked again.
const PLAIN: f64 = 10.0;
/// Steps of a fit along the chords, which begins where that along the bends has ended.
const STEPS: u64 = 20;

/// The same questions and their answer with all motions straight between samples, where these are likelier.
pub(crate) fn along_chords<'a>(
    bench: &Bench<'a>,
    selected: &Selected,
) -> Option<(Bench<'a>, Selected)> {
    let straight = bench.with_motions(bench.experiment.along_chords()?);
    let nearer = |stand: &Stand| nearer(bench, &straight, &selected.subset, stand);
    if !nearer(&selected.baseline) && !nearer(&selected.stand) {
        return None;
    }
    bench.tell(|| "asking again with motions that are straight between samples".to_owned());
    let other = select(&straight, &Subset::all(&straight), Depth::Full, None)?;
    let likelier = worth(&other) < worth(selected);
    likelier.then_some((straight, other))
}

/// Whether what is in a stand fits plainly better along the chords.
fn nearer(bench: &Bench<'_>, straight: &Bench<'_>, subset: &Subset, stand: &Stand) -> bool {
    let Fitted {
        effects,
        parameters,
        ..
    } = &stand.fitted;
    let context = subset.context_of(bench, &stand.fitted);
    let whitener = (stand.whitener).with_scatter(&context, likely_scatter(stand));
    let fit = straight.fit(subset, effects, parameters, &whitener, None, STEPS);
    let deviance = fit.map(|fit| stand.deviance_of(straight, subset, &fit));
    deviance.is_some_and(|deviance| deviance < stand.deviance - PLAIN)
}

/// -2 log likelihood with each name paid for.
fn worth(selected: &Selected) -> f64 {
    let names = selected.stand.fitted.effects.len() as f64;
    selected.stand.deviance - 2.0 * strict(&selected.first) * names
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

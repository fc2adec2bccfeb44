//! Whether the force channel wanders, or the law is wrong.
//!
//! What a law misses is alike along a run, as a wander is, and noise that takes it up hides the half of it and lends a name to the rest. A channel
//! that wanders leaves nothing beside the noise that knows it; where something is left all the same, all is asked again without. A wander may
//! also swallow the whole of a cause (roughness behind a lag is smooth in time): where nothing is named beside one, what is named
//! without it stands if that is the likelier of the two.

use fitting::noise::Sizes;

use crate::bench::Bench;
use crate::chords::{Chosen, select_with_motions, worth};
use crate::selection::{ALPHA_GENERAL, Selected};

/// The selection with the motions that the force prefers, and with a wander if nothing is left beside it and it is likelier than what is
/// named without; the bench is then the one that was asked. `None` where the law itself cannot be computed.
pub(crate) fn select_with_noise<'a>(bench: &mut Bench<'a>) -> Option<Chosen<'a>> {
    let chosen = select_with_motions(bench)?;
    let is_in_doubt = is_in_doubt(&chosen.selected);
    if !is_in_doubt && !is_wander_alone(&chosen.selected) {
        return Some(chosen);
    }
    let what = match is_in_doubt {
        true => "something is left beside a force channel that wanders",
        false => "the force channel wanders and nothing is named",
    };
    bench.tell(|| format!("{what}; asking again without"));
    bench.may_wander = false;
    let without = select_with_motions(bench);
    if is_in_doubt || is_likelier(&without, &chosen.selected) {
        return without;
    }
    bench.may_wander = true;
    Some(chosen)
}

/// Whether something is left where the noise holds a wander, or held one beside the law alone: what came in beside it came in under its noise.
fn is_in_doubt(selected: &Selected) -> bool {
    let wanders = |sizes: Sizes| sizes.wander > 0.0;
    let wandered = wanders(selected.stand.sizes) || selected.first.sizes.is_some_and(wanders);
    wandered && is_left(selected)
}

fn is_left(selected: &Selected) -> bool {
    selected.left.log_p < ALPHA_GENERAL.ln()
}

/// Whether a wander is all that there is beside the law.
fn is_wander_alone(selected: &Selected) -> bool {
    selected.stand.sizes.wander > 0.0 && selected.stand.fitted.effects.is_empty()
}

/// Whether what is named without a wander leaves nothing and is likelier than the wander.
fn is_likelier(without: &Option<Chosen<'_>>, wander: &Selected) -> bool {
    without.as_ref().is_some_and(|Chosen { selected, .. }| {
        let is_named = !selected.stand.fitted.effects.is_empty();
        is_named && !is_left(selected) && worth(selected) < worth(wander)
    })
}

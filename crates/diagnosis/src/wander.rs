//! Whether the force channel wanders, or the law is wrong.
//!
//! What a law misses is alike along a run, as a wander is, and noise that takes it up hides the half of it and lends a name to the rest. A channel
//! that wanders leaves nothing beside the noise that knows it; where something is left all the same, all is asked again without. A wander may
//! also swallow the whole of a cause (roughness behind a lag is smooth in time): where nothing is named beside one, what is named
//! without it stands if that is the likelier of the two.

use fitting::noise::Sizes;

use crate::bench::Bench;
use crate::chords::{Chosen, select_with_motions};
use crate::selection::Selected;

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
    let stands = without
        .as_ref()
        .is_none_or(|without| stands(&without.selected, &chosen.selected, is_in_doubt));
    if stands {
        return without;
    }
    bench.may_wander = true;
    Some(chosen)
}

/// Whether the answer without a wander stands, and not that with one: what it names where something is left beside the wander; else if it is the
/// likelier of the two, and of names only where nothing is left beside them.
fn stands(without: &Selected, with: &Selected, is_in_doubt: bool) -> bool {
    let is_likelier = without.worth() < with.worth();
    match is_in_doubt {
        true => is_likelier || !(with.names_nothing() && without.names_nothing()),
        false => is_likelier && !without.names_nothing() && !without.leaves_something(),
    }
}

/// Whether something is left where the noise holds a wander, or held one beside the law alone: what came in beside it came in under its noise.
fn is_in_doubt(selected: &Selected) -> bool {
    let wanders = |sizes: Sizes| sizes.wander > 0.0;
    let wandered = wanders(selected.stand.sizes) || selected.first.sizes.is_some_and(wanders);
    wandered && selected.leaves_something()
}

/// Whether a wander is all that there is beside the law.
fn is_wander_alone(selected: &Selected) -> bool {
    selected.stand.sizes.wander > 0.0 && selected.names_nothing()
}

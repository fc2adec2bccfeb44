//! Whether the force channel wanders, or the law is wrong.
//!
//! What a law misses is alike along a run, as a wander is, and noise that takes it up hides the half of it and lends a name to the rest. A channel
//! that wanders leaves nothing beside the noise that knows it; where something is left all the same, all is asked again without.

use fitting::noise::Sizes;

use crate::bench::Bench;
use crate::chords::{Chosen, select_with_motions};
use crate::selection::{ALPHA_GENERAL, Selected};

/// The selection with the motions that the force prefers, and with a wander if nothing is left beside it; the bench is then the one that was
/// asked. `None` where the law itself cannot be computed.
pub(crate) fn select_with_noise<'a>(bench: &mut Bench<'a>) -> Option<Chosen<'a>> {
    let chosen = select_with_motions(bench)?;
    if !is_in_doubt(&chosen.selected) {
        return Some(chosen);
    }
    bench.tell(|| {
        "something is left beside a force channel that wanders; asking again without".to_owned()
    });
    bench.may_wander = false;
    select_with_motions(bench)
}

/// Whether something is left where the noise holds a wander, or held one beside the law alone: what came in beside it came in under its noise.
fn is_in_doubt(selected: &Selected) -> bool {
    let wanders = |sizes: Sizes| sizes.wander > 0.0;
    let wandered = wanders(selected.stand.sizes) || selected.first.sizes.is_some_and(wanders);
    wandered && selected.left.log_p < ALPHA_GENERAL.ln()
}

//! Each named cause against the catalogue, and the better one in its place where there is one.
//!
//! The selection names what scores best beside the law alone; fitted with the law, a twin of it may come nearer to the record. What the
//! protocol cannot separate is asked of the twin that fits best: the other's fit may have been bent to imitate nearly anything.

use crate::bench::Bench;
use crate::equivalence::{Contest, contest};
use crate::joint::search_price;
use crate::left::lack;
use crate::look_back::EXCHANGE;
use crate::scan::Scan;
use crate::selection::Selected;
use crate::settled::settle;
use crate::ways::deviance_of_positions;

/// Successions of one cause by another.
const MOST: usize = 2;

/// The contests of all named causes; a cause that another beats in its place is succeeded by it first.
pub(crate) fn contests(bench: &Bench<'_>, selected: &mut Selected) -> Vec<Contest> {
    let all = |selected: &Selected| -> Vec<Contest> {
        let (subset, stand) = (&selected.subset, &selected.stand);
        (0..stand.fitted.effects.len())
            .filter_map(|k| contest(bench, subset, stand, &selected.first, k))
            .collect()
    };
    let mut contests = all(selected);
    for _ in 0..MOST {
        if !succeed(bench, selected, &contests) {
            break;
        }
        contests = all(selected);
    }
    contests
}

/// Puts the opponent that saves most in the place of the cause that it beats; whether there was one.
fn succeed(bench: &Bench<'_>, selected: &mut Selected, contests: &[Contest]) -> bool {
    let stand = &selected.stand;
    let best = contests
        .iter()
        .enumerate()
        .flat_map(|(k, contest)| {
            let opponents = contest.opponents.iter();
            opponents.filter_map(move |o| Some((o.loss(), k, o.cause, o.fitted.as_ref()?)))
        })
        .min_by(|a, b| a.0.total_cmp(&b.0));
    let Some((_, k, cause, fit)) = best.filter(|best| best.0 < -EXCHANGE) else {
        return false;
    };
    let found = Scan::empty(bench, Some(stand.sizes));
    let Some(next) = settle(bench, &selected.subset, fit, &found) else {
        return false;
    };
    // A searched period is paid for, by the named cause and by its rival.
    let price = search_price(bench, cause) - search_price(bench, stand.fitted.effects[k]);
    let positions = |fit| deviance_of_positions(bench, fit);
    let charge = price + positions(&next.fitted) - positions(&stand.fitted);
    if next.deviance + charge > stand.deviance - EXCHANGE {
        return false;
    }
    selected.left = lack(bench, &selected.subset, &next);
    selected.stand = next;
    // The newcomer stands last.
    if let Some(entry) = selected.entry_log_p.get_mut(k..) {
        entry.rotate_left(1);
    }
    true
}

//! When names are taken back: a refusal beats a wrong name.

use rig::{Reach, Station};

use crate::answer::Place;
use crate::bench::{Bench, Fitted};
use crate::equivalence::{Contest, Opponent};
use crate::foreign::{beside_the_noise_of, strangest};
use crate::general::Lack;
use crate::left::lack;
use crate::look_back::fitted_without;
use crate::marks;
use crate::scan::Scan;
use crate::selection::{ALPHA_NAME, MOST_EFFECTS, SHAPE_TOLERANCE, Selected, Single, strict};
use crate::settled::settle;
use crate::stand::Stand;
use crate::subset::Subset;
use crate::uniform::is_uniform;

/// Where something is left that nothing explains, one cause stays named only if it explains this share of all of it.
const DOMINANT: f64 = 0.95;
/// The same of two causes together.
const DOMINANT_PAIR: f64 = 0.95;
/// The same of three: beside a rest they are as little to be believed as four, unless it is what their shapes may be wrong by.
const DOMINANT_TRIPLE: f64 = 1.0 - SHAPE_TOLERANCE * SHAPE_TOLERANCE;

/// A mark that explains less than this share of what a cause does, the search for it paid for, is none.
const MOSTLY: f64 = 0.5;

/// Runs with a law of their own are looked at closely from this share on of what all named causes explain.
const NEAR: f64 = 0.5;

/// Asks of a finished selection whether its names may stay.
pub(crate) fn take_back(bench: &Bench<'_>, selected: &mut Selected) {
    refuse_uneven(bench, selected);
    refuse_another_law(bench, selected);
    let worth = -2.0 * strict(&selected.first);
    refuse_beside_mark(bench, selected, worth);
    refuse_beside_foreign_runs(bench, selected, worth);
    keep_dominant(bench, selected);
}

/// Where a named cause saves nothing once all is fitted, or another one in its place saves more by what a name must be worth,
/// the selection has not found what is there: nothing is named. Returns whether names were taken back.
pub(crate) fn refuse_beaten(
    bench: &Bench<'_>,
    selected: &mut Selected,
    contests: &[Contest],
) -> bool {
    let worth = -2.0 * strict(&selected.first);
    let beaten = contests.iter().any(|contest| {
        let better = |o: &Opponent| o.loss() < -worth;
        !(contest.saved > 0.0) || contest.opponents.iter().any(better)
    });
    if beaten {
        let why = "came in, but once all was fitted it saved nothing, or another cause did better in its place";
        say_why(bench, selected, why);
        take_all_back(bench, selected);
    }
    beaten
}

/// Keeps for the reader why the causes that are named until now will not be.
fn say_why(bench: &Bench<'_>, selected: &mut Selected, why: &str) {
    let named = selected.stand.fitted.ids(bench).join(" with ");
    selected.refused.push(format!("{named} {why}: not named"));
}

/// Where a named cause does not act everywhere that its signature says, or where causes pile up, nothing is named: the
/// structure has another cause.
fn refuse_uneven(bench: &Bench<'_>, selected: &mut Selected) {
    let effects = &selected.stand.fitted.effects;
    let uneven = |k: &usize| !is_uniform(bench, &selected.subset, &selected.stand, *k);
    let why = if effects.len() >= MOST_EFFECTS {
        "fits best, but one cause outside the catalogue is likelier than so many in it".to_owned()
    } else if let Some(k) = (0..effects.len()).find(uneven) {
        let id = bench.catalogue[effects[k]].id();
        format!(
            "fits best, but {id} does not act alike in all runs, places and times, as it would have to"
        )
    } else {
        return;
    };
    say_why(bench, selected, &why);
    take_all_back(bench, selected);
}

/// A law whose curve needs two corrections at once is not the law: what is there is another one, in or outside the catalogue of laws.
/// Where one of two explains nearly all, the other is what its shape may be wrong by, and it stays alone. (Beside a model from elsewhere
/// the law is known.)
fn refuse_another_law(bench: &Bench<'_>, selected: &mut Selected) {
    let effects = &selected.stand.fitted.effects;
    // Ageing over rests that are all alike is no more than another start of every run.
    let rests_are_alike = !bench.experiment.has_two_rests();
    let of_the_law = |cause: &&usize| {
        let cause = &bench.catalogue[**cause];
        cause.station() == Station::Law || (cause.reach() == Reach::RestGain && rests_are_alike)
    };
    if bench.prior.is_some() || effects.iter().filter(of_the_law).count() < 2 {
        return;
    }
    let explained = selected.baseline.deviance - selected.stand.deviance;
    if effects.len() == 2 && first_alone(bench, selected) >= DOMINANT * explained {
        keep_first(bench, selected);
        return;
    }
    let why = "fits best, but a law whose curve needs several corrections at once is another law";
    say_why(bench, selected, why);
    take_all_back(bench, selected);
}

/// The fit with the first named cause alone.
fn first_single(selected: &Selected) -> Option<&Single> {
    let first = selected.stand.fitted.effects.first()?;
    selected.singles.iter().find(|s| s.cause == *first)
}

/// Deviance that the first named cause alone explains.
fn first_alone(bench: &Bench<'_>, selected: &Selected) -> f64 {
    let of = |fit| selected.stand.deviance_of(bench, &selected.subset, fit);
    first_single(selected).map_or(0.0, |s| selected.baseline.deviance - of(&s.fitted))
}

/// Only the first named cause stays, under the noise beside them all; none where it was not fitted alone.
fn keep_first(bench: &Bench<'_>, selected: &mut Selected) {
    let fitted = match first_single(selected) {
        Some(single) => {
            let fitted = single.fitted.clone();
            selected.entry_log_p.truncate(1);
            fitted
        }
        None => {
            selected.entry_log_p.clear();
            selected.baseline.fitted.clone()
        }
    };
    stand_with(bench, selected, fitted);
}

fn stand_with(bench: &Bench<'_>, selected: &mut Selected, fitted: Fitted) {
    let sizes = selected.stand.sizes;
    selected.stand = Stand::new(bench, &selected.subset, fitted, sizes);
    selected.left = lack(bench, &selected.subset, &selected.stand);
}

/// All but the k-th cause stay named, and the reader is told why; `None` where the others cannot be fitted.
pub(crate) fn take_one_back(
    bench: &Bench<'_>,
    selected: &mut Selected,
    k: usize,
    why: &str,
) -> Option<()> {
    let (stand, subset) = (&selected.stand, &selected.subset);
    let id = |effect: usize| bench.catalogue[effect].id();
    let taken = id(stand.fitted.effects[k]);
    let fit = fitted_without(bench, subset, stand, k)?;
    let rest = fit.effects.clone();
    let found = Scan::empty(bench, Some(stand.sizes));
    selected.stand = settle(bench, subset, &fit, &found)?;
    selected.left = lack(bench, &selected.subset, &selected.stand);
    selected.entry_log_p.truncate(rest.len());
    keep_dominant(bench, selected);
    let beside: Vec<&str> = rest.into_iter().map(id).collect();
    selected.refused.push(format!(
        "{taken} came in beside {}, but {why}: not named",
        beside.join(", ")
    ));
    Some(())
}

/// The law alone again; what was seen stays seen.
pub(crate) fn take_all_back(bench: &Bench<'_>, selected: &mut Selected) {
    back_to_the_law(bench, selected, lack);
}

/// Where one mark somewhere on the plate explains more than all named causes together, nothing is named: a step in the middle looks like
/// a gradient, three quarters of it. A cause that varies along the plate must moreover be likelier than the likeliest mark there is, since
/// beside roughness that may take up what remains a gradient explains all of a step.
fn refuse_beside_mark(bench: &Bench<'_>, selected: &mut Selected, worth: f64) {
    if selected.names_nothing() {
        return;
    }
    let law = &selected.baseline;
    let found = marks::find(bench, &selected.subset, law, &law.ground);
    let Some(marks::Found {
        strongest: mark,
        likeliest,
    }) = found
    else {
        return;
    };
    let named = law.deviance - selected.stand.deviance;
    let along_the_plate = match selected.stand.fitted.effects[..] {
        [one] => {
            let cause = &bench.catalogue[one];
            cause.station() == Station::Surface && !cause.is_periodic()
        }
        _ => false,
    };
    let likelier = named - mark.saved() > -2.0 * ALPHA_NAME.ln();
    let as_good = along_the_plate && !likelier && mark.explained > MOSTLY * named;
    let beaten = along_the_plate && likeliest.saved() > named;
    if mark.explained < named + worth && !as_good && !beaten {
        return;
    }
    let mark = if beaten { likeliest } else { mark };
    let why = "explains less, or hardly more, than a scratch or a step of friction somewhere on the plate would";
    say_why(bench, selected, why);
    back_to_the_law(bench, selected, |_, _, _| mark.lack());
}

/// Where one or two runs with a law of their own explain what all named causes together explain, nothing is named: they were made with
/// another specimen. That is one statement: each cause after the second must be worth its name beyond it, and one alone need not be.
fn refuse_beside_foreign_runs(bench: &Bench<'_>, selected: &mut Selected, worth: f64) {
    let (law, subset) = (&selected.baseline, &selected.subset);
    let names = selected.stand.fitted.effects.len();
    if names == 0 {
        return;
    }
    let named = law.deviance - selected.stand.deviance;
    let near = strangest(bench, subset, law).filter(|f| f.explained > NEAR * named);
    let Some(near) = near else {
        return;
    };
    let closer = beside_the_noise_of(bench, subset, law, &near);
    let foreign = closer
        .filter(|c| c.explained > near.explained)
        .unwrap_or(near);
    if foreign.explained < named + worth * (2.0 - names as f64) {
        return;
    }
    let why = "explains no more than a law of its own for one or two runs would";
    say_why(bench, selected, why);
    let left = Lack {
        log_p: foreign.log_p,
        place: Some(foreign.place(bench, &selected.subset)),
        excess: foreign.explained,
    };
    back_to_the_law(bench, selected, |_, _, _| left);
}

/// The law alone, beside which this is left; what was seen stays seen.
fn back_to_the_law(
    bench: &Bench<'_>,
    selected: &mut Selected,
    left: impl FnOnce(&Bench<'_>, &Subset, &Stand) -> Lack,
) {
    let seen = selected.seen();
    let fitted = selected.baseline.fitted.clone();
    selected.stand = Stand::new(bench, &selected.subset, fitted, selected.stand.sizes);
    selected.entry_log_p.clear();
    selected.left = left(bench, &selected.subset, &selected.stand);
    selected.left.log_p = selected.left.log_p.min(seen);
}

/// Where something is left that nothing explains: only causes that explain most of it stay named. What is left on the plate beside them
/// says more closely where it is than what is left beside a law that has bent to it.
fn keep_dominant(bench: &Bench<'_>, selected: &mut Selected) {
    if selected.names_nothing() || !selected.leaves_something() {
        return;
    }
    let explained = selected.baseline.deviance - selected.stand.deviance;
    let all = (explained + selected.left.weight()).max(1e-300);
    let share = explained / all;
    let alone = first_alone(bench, selected) / all;
    let enough = match selected.stand.fitted.effects.len() {
        1 => DOMINANT,
        2 => DOMINANT_PAIR,
        _ => DOMINANT_TRIPLE,
    };
    if share >= enough {
        return;
    }
    let several = selected.stand.fitted.effects.len() > 1;
    if several && alone >= DOMINANT {
        keep_first(bench, selected);
        return;
    }
    let why = format!(
        "would explain {:.0} % of what is seen beside the law, and nothing explains the rest",
        100.0 * share
    );
    say_why(bench, selected, &why);
    selected.entry_log_p.clear();
    let beside_names = selected.left.place.take();
    let law = selected.baseline.fitted.clone();
    stand_with(bench, selected, law);
    if beside_names.as_ref().is_some_and(Place::is_on_plate) {
        selected.left.place = beside_names;
    }
}

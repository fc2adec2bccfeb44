//! One fold: the selection done again without some runs, and what it says of them.

use std::collections::BTreeSet;

use nalgebra::DMatrix;

use crate::asked::is_shift;
use crate::bench::{Bench, Fitted};
use crate::forms::as_named;
use crate::ground::orthonormal;
use crate::left::lack;
use crate::look_back::bare;
use crate::refusal::take_back;
use crate::scrambled::placebos;
use crate::selection::{Depth, Selected, Start, Warm, select};
use crate::settled::{law_alone, likely_scatter};
use crate::stand::Stand;
use crate::subset::Subset;
use crate::whole::Whole;

/// Outcome of one fold.
pub(crate) struct Fold {
    pub(crate) held: Vec<usize>,
    /// Predictions for all recorded samples: law alone as its errors are stated, the law that names are judged against, and with what the
    /// fold selected.
    pub(crate) stated: Vec<f64>,
    pub(crate) law: Vec<f64>,
    pub(crate) extended: Vec<f64>,
    /// The same where the fold would have named what it took in; where not, that of the law that it fitted. Names are judged by it.
    pub(crate) firm: Vec<f64>,
    /// The same with what the whole campaign named in the place of what the fold took in its stead.
    pub(crate) named: Vec<f64>,
    /// The law's prediction on the record that was searched, beside which the placebos stand.
    pub(crate) searched: Vec<f64>,
    /// For each named cause: the extended model without it, where the fold named it.
    pub(crate) lacking: Vec<Option<Vec<f64>>>,
    /// Whether one of the named causes was found as plainly as a name must be.
    pub(crate) again: bool,
    /// Predictions with each scrambled extension.
    pub(crate) placebos: Vec<Vec<f64>>,
    /// J L of the fold's extension, all samples x directions: L L' is the covariance of its parameters (D11).
    pub(crate) doubt: DMatrix<f64>,
}

/// What every fold is asked.
pub(crate) struct Asked {
    /// Where its selection starts.
    pub(crate) warm: Warm,
    /// For each named cause that cause and those that cannot be told from it.
    pub(crate) named: Vec<Vec<usize>>,
    /// The scrambled extensions.
    pub(crate) scrambled: Vec<Vec<f64>>,
    /// Whether one of the names is another value of the law's own parameters. Within the covariance of a model from elsewhere the law
    /// bends to the data instead, so that such a name gains something beside the model as it is stated only.
    pub(crate) shifted: bool,
}

/// The fold that holds out these runs; `None` where the law itself cannot be computed without them.
pub(crate) fn fold(
    bench: &Bench<'_>,
    whole: &Whole<'_>,
    held: &[usize],
    asked: &Asked,
) -> Option<Fold> {
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
        let law = law_alone(bench, &subset, Start::Near(warm))?.fitted;
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
    let mut own = select(bench, &subset, Depth::Fold, Start::Near(warm))?;
    own.stand = as_named(bench, &own.subset, own.stand, &warm.causes);
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
            let whitener = own.stand.scattered(own.stand.sizes.scatter);
            bench
                .fit(subset, &rest, &full.without(k), &whitener, None, 12)
                .map(|fit| whole.prediction(&fit))
        })
        .collect();
    let (law, extended) = (whole.prediction(&reference), whole.prediction(full));
    let held = held.to_vec();
    let stated = whole.stated_prediction(&own.baseline.fitted);
    let placebos = placebos(bench, &own, &reference, &asked.scrambled, *shifted);
    let doubt = doubt(&own.stand);
    // The law that the fold fitted, which is another one than the reference only where that is stated elsewhere.
    let bare = match *shifted {
        true => whole.prediction(&own.baseline.fitted),
        false => law.clone(),
    };
    let plain = named.iter().any(|cause| own.is_plain(cause));
    let instead = (own.is_plain(&full.effects)).then(|| instead(bench, whole, &own, warm, named));
    let (again, firm, named) = match instead.filter(|_| keeps_names(bench, own, &asked.named)) {
        Some(instead) => (plain, extended.clone(), instead),
        None => (false, bare.clone(), bare),
    };
    Some(Fold {
        held,
        stated,
        law,
        extended,
        firm,
        named,
        searched: reference.prediction,
        lacking,
        again,
        placebos,
        doubt,
    })
}

/// Whether what a fold has named would stay named, were it the whole campaign: the names that the whole campaign has kept do, `sets`, each in
/// whatever form and as whichever of those that cannot be told from it.
fn keeps_names(bench: &Bench<'_>, mut own: Selected, sets: &[Vec<usize>]) -> bool {
    let set_of = |id: &str| {
        let holds = |set: &Vec<usize>| set.iter().any(|&c| bench.catalogue[c].id() == id);
        sets.iter().position(holds)
    };
    let ids = own.stand.fitted.ids(bench);
    let seen: Option<BTreeSet<usize>> = ids.iter().map(|id| set_of(id)).collect();
    if seen.is_some_and(|seen| seen.len() == ids.len() && ids.len() == sets.len()) {
        return true;
    }
    own.left = lack(bench, &own.subset, &own.stand);
    take_back(bench, &mut own);
    !own.names_nothing()
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
        let whitener = own.stand.scattered(own.stand.sizes.scatter);
        bench.fit(&own.subset, &effects, &start, &whitener, None, 20)
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

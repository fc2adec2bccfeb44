//! The whole record behind the one that was searched: the last fit, and every error that is stated, use all samples.

use fitting::noise::Whitener;
use rig::Model;

use crate::bench::{Bench, Beside, Fitted};
use crate::joint::is_dear;
use crate::selection::Selected;
use crate::subset::Subset;

/// Steps of the last fit, which starts where the search ended; fewer where the mechanics are dear.
const STEPS: u64 = 10;
const DEAR_STEPS: u64 = 4;

/// What was found, on all recorded samples.
pub(crate) struct Whole<'a> {
    /// The recorded campaign.
    pub(crate) bench: &'a Bench<'a>,
    /// Whether another record than this one was searched.
    pub(crate) apart: bool,
    /// The law alone.
    pub(crate) law: Fitted,
    /// The law as its errors are stated: with the parameters of a model from elsewhere where there is one, else as fitted.
    pub(crate) stated: Fitted,
    /// The law with the named causes.
    pub(crate) extended: Fitted,
}

impl<'a> Whole<'a> {
    /// What a search found, fitted to all samples where it was made on fewer.
    pub(crate) fn of(recorded: &'a Bench<'a>, searched: &Bench<'_>, selected: &Selected) -> Self {
        let apart = !std::ptr::eq(recorded, searched);
        let fit = |fitted: &Fitted| {
            if apart {
                fit(recorded, fitted, selected)
            } else {
                fitted.clone()
            }
        };
        let law = fit(&selected.baseline.fitted);
        Self {
            bench: recorded,
            apart,
            stated: recorded.as_stated(&law),
            law,
            extended: fit(&selected.stand.fitted),
        }
    }

    /// Prediction of a law alone, as its errors are stated, for all recorded samples.
    pub(crate) fn stated_prediction(&self, law: &Fitted) -> Vec<f64> {
        if self.bench.prior.is_none() {
            return self.prediction(law);
        }
        let law = if self.apart {
            of_all_samples(self.bench, law)
        } else {
            law.clone()
        };
        self.bench.as_stated(&law).prediction
    }

    /// Prediction of a fit for all recorded samples.
    pub(crate) fn prediction(&self, fitted: &Fitted) -> Vec<f64> {
        if self.apart {
            of_all_samples(self.bench, fitted).prediction
        } else {
            fitted.prediction.clone()
        }
    }
}

/// The same fit on the recorded samples.
pub(crate) fn of_all_samples(recorded: &Bench<'_>, fitted: &Fitted) -> Fitted {
    let effects = fitted.model.effects().iter().map(|e| e.boxed()).collect();
    let model = Model::new(fitted.model.law, effects, &recorded.experiment)
        .expect("the same law and effects made a model of the same runs");
    Fitted {
        prediction: model.predict(&recorded.experiment, &fitted.parameters),
        model,
        beside: Beside::default(),
        ..fitted.clone()
    }
}

/// A fit carried on with all samples, under the noise that the search found.
fn fit(recorded: &Bench<'_>, fitted: &Fitted, selected: &Selected) -> Fitted {
    let start = of_all_samples(recorded, fitted);
    let subset = Subset::all(recorded)
        .late_by(selected.subset.lateness())
        .turning(selected.subset.turns());
    let context = subset.context_of(recorded, &start);
    let whitener = Whitener::new(&context, &selected.stand.sizes);
    let dear = fitted.effects.iter().any(|&e| is_dear(recorded, e));
    let steps = if dear { DEAR_STEPS } else { STEPS };
    recorded
        .fit(
            &subset,
            &fitted.effects,
            &start.parameters,
            &whitener,
            None,
            steps,
        )
        .unwrap_or(start)
}

//! Carries trials out: sizes from the oracle, package, answer, judgement.

use std::collections::BTreeMap;

use diagnosis::Options;
use planting::{Base, Planted, Protocol};

use crate::hidden::ask::{ask, asked_law, true_gain};
use crate::hidden::judge::judge;
use crate::hidden::oracle::{Oracle, Rivals};
use crate::hidden::selection::{Group, Trial};
use crate::hidden::tally::Judged;

/// Largest multiple of a plausible size that is planted: beyond it the rig would be taken for broken.
const LARGEST_SIZE: f64 = 30.0;

/// An oracle with what it has already seen.
struct View {
    oracle: Oracle,
    rivals: Rivals,
    thresholds: BTreeMap<(String, bool), Option<f64>>,
}

/// Carries trials out, remembering oracles.
#[derive(Default)]
pub struct Workshop {
    views: BTreeMap<(Protocol, u64, String), View>,
}

impl Workshop {
    fn view(&mut self, trial: &Trial) -> Result<&mut View, String> {
        let case = &trial.case;
        let key = (case.protocol, case.specimen, format!("{:?}", case.base));
        if !self.views.contains_key(&key) {
            let oracle = Oracle::new(case)?;
            let rivals = oracle.rivals()?;
            self.views.insert(
                key.clone(),
                View {
                    oracle,
                    rivals,
                    thresholds: BTreeMap::new(),
                },
            );
        }
        self.views
            .get_mut(&key)
            .ok_or_else(|| "no view".to_string())
    }

    /// Sets the sizes of a trial in thresholds of its own oracle. `None` where the law absorbs what is planted.
    ///
    /// # Errors
    /// If something unknown is to be planted.
    pub fn sized(&mut self, trial: &Trial) -> Result<Option<Trial>, String> {
        let mut sized = trial.clone();
        if trial.case.planted.is_empty() {
            return Ok(Some(sized));
        }
        let (base, protocol) = (trial.case.base, trial.case.protocol);
        let ratio = trial.ratio;
        let view = self.view(trial)?;
        for planted in &mut sized.case.planted {
            if always_absorbed(planted, base, protocol) {
                return Ok(None);
            }
            let key = (planted.id.clone(), planted.second_shape);
            let threshold = match view.thresholds.get(&key) {
                Some(known) => *known,
                None => {
                    let found =
                        view.oracle
                            .threshold(&planted.id, planted.second_shape, LARGEST_SIZE)?;
                    view.thresholds.insert(key, found);
                    found
                }
            };
            let Some(threshold) = threshold else {
                return Ok(None);
            };
            planted.size = ratio * threshold;
            if planted.size > LARGEST_SIZE {
                return Ok(None);
            }
        }
        Ok(Some(sized))
    }

    /// Carries a trial out; returns the judgement and the answer that was judged.
    ///
    /// # Errors
    /// What the door or the diagnosis refuses, in words.
    pub fn carry_out(
        &mut self,
        trial: &Trial,
        quick: bool,
    ) -> Result<(Judged, serde_json::Value), String> {
        let Some(sized) = self.sized(trial)? else {
            let absorbed = Judged {
                trial: trial.clone(),
                forced: Vec::new(),
                distance: 0.0,
                judgement: None,
                true_gain: None,
            };
            return Ok((absorbed, serde_json::Value::Null));
        };
        let (mut forced, mut distance) = (Vec::new(), 0.0);
        if !sized.case.planted.is_empty() {
            let view = self.view(&sized)?;
            let sight = view.oracle.look(&sized.case.planted, &view.rivals)?;
            (forced, distance) = (sight.forced, sight.distance);
        }
        let outcome = sized.case.carry_out()?;
        let options = Options {
            law: asked_law(sized.case.base),
            without: sized.without.iter().cloned().collect(),
            quick,
            ..Options::default()
        };
        let answer = ask(&outcome.files, &options)?;
        let mut key = outcome.key.clone();
        if sized.group == Group::Control {
            // Without its cause in the catalogue the effect is as good as an alien: any name for it is false.
            key.effects.clear();
        }
        let mut judgement = judge(&answer.json, &key, &forced);
        if sized.group == Group::Control {
            judgement.verdict = crate::hidden::judge::verdict_of_stranger(&judgement, &forced);
        }
        let true_gain = if judgement.named.is_empty() {
            None
        } else {
            let oracle = &self.view(&sized)?.oracle;
            true_gain(oracle, &sized.case, &outcome, &answer.curves).ok()
        };
        let judged = Judged {
            trial: sized,
            forced,
            distance,
            judgement: Some(judgement),
            true_gain,
        };
        Ok((judged, answer.json))
    }
}

/// Effects that are another value of a free parameter of the law, at any size: the oracle's straight lines see the
/// curvature of the law in them, the fit does not.
fn always_absorbed(planted: &Planted, base: Base, protocol: Protocol) -> bool {
    match planted.id.as_str() {
        // Over equal rests ageing that lasts for a run is another level at rest.
        "dwell-ageing" => !planted.second_shape && !protocol.has_uneven_rests(),
        "lean-angle" => base != Base::SymmetricBristle,
        "force-gain" => matches!(base, Base::AsymmetricBristle | Base::SymmetricBristle),
        _ => false,
    }
}

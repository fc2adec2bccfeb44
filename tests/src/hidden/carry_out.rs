//! Carries trials out: sizes from the oracle, package, answer, judgement.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError, mpsc};
use std::thread;

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

impl View {
    fn sized(&mut self, trial: &Trial) -> Result<Option<Trial>, String> {
        let mut sized = trial.clone();
        let (base, protocol) = (trial.case.base, trial.case.protocol);
        for planted in &mut sized.case.planted {
            if always_absorbed(planted, base, protocol) {
                return Ok(None);
            }
            let key = (planted.id.clone(), planted.second_shape);
            let threshold = match self.thresholds.get(&key) {
                Some(known) => *known,
                None => {
                    let found =
                        self.oracle
                            .threshold(&planted.id, planted.second_shape, LARGEST_SIZE)?;
                    self.thresholds.insert(key, found);
                    found
                }
            };
            let Some(threshold) = threshold else {
                return Ok(None);
            };
            planted.size = trial.ratio * threshold;
            if planted.size > LARGEST_SIZE {
                return Ok(None);
            }
        }
        Ok(Some(sized))
    }
}

/// Carries trials out, remembering oracles.
#[derive(Default)]
pub struct Workshop {
    views: Mutex<BTreeMap<(Protocol, u64, String), View>>,
}

impl Workshop {
    /// Asks the oracle of a trial's campaign, one trial at a time.
    fn consult<R>(
        &self,
        trial: &Trial,
        question: impl FnOnce(&mut View) -> Result<R, String>,
    ) -> Result<R, String> {
        let case = &trial.case;
        let key = (case.protocol, case.specimen, format!("{:?}", case.base));
        let mut views = self.views.lock().unwrap_or_else(PoisonError::into_inner);
        if !views.contains_key(&key) {
            let oracle = Oracle::new(case)?;
            let rivals = oracle.rivals()?;
            let view = View {
                oracle,
                rivals,
                thresholds: BTreeMap::new(),
            };
            views.insert(key.clone(), view);
        }
        let view = views.get_mut(&key).ok_or_else(|| "no view".to_string())?;
        question(view)
    }

    /// Sets the sizes of a trial in thresholds of its own oracle. `None` where the law absorbs what is planted.
    ///
    /// # Errors
    /// If something unknown is to be planted.
    pub fn sized(&self, trial: &Trial) -> Result<Option<Trial>, String> {
        if trial.case.planted.is_empty() {
            return Ok(Some(trial.clone()));
        }
        self.consult(trial, |view| view.sized(trial))
    }

    /// Carries a trial out; returns the judgement and the answer that was judged.
    ///
    /// # Errors
    /// What the door or the diagnosis refuses, in words.
    pub fn carry_out(
        &self,
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
            let look = |view: &mut View| view.oracle.look(&sized.case.planted, &view.rivals);
            let sight = self.consult(&sized, look)?;
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
            let gain =
                |view: &mut View| true_gain(&view.oracle, &sized.case, &outcome, &answer.curves);
            self.consult(&sized, gain).ok()
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

/// Carries trials out side by side, as many as there are processors (a diagnosis has stretches that use one only). What comes of each is handed over
/// as it ends, with its place among the trials; none is begun once `enough` says so.
///
/// # Errors
/// The first that `ended` returns; no further trial is begun then.
pub fn side_by_side<R: Send, E>(
    trials: &[Trial],
    work: impl Fn(&Trial) -> R + Sync,
    enough: impl Fn() -> bool + Sync,
    mut ended: impl FnMut(usize, R) -> Result<(), E>,
) -> Result<(), E> {
    let workers = thread::available_parallelism().map_or(1, usize::from);
    let next = AtomicUsize::new(0);
    let (sender, results) = mpsc::channel();
    thread::scope(|scope| {
        for _ in 0..workers {
            let (sender, next, work, enough) = (sender.clone(), &next, &work, &enough);
            scope.spawn(move || {
                while !enough() {
                    let place = next.fetch_add(1, Ordering::Relaxed);
                    let Some(trial) = trials.get(place) else {
                        break;
                    };
                    // Nobody listens any more after an error.
                    if sender.send((place, work(trial))).is_err() {
                        break;
                    }
                }
            });
        }
        drop(sender);
        let stopped = results
            .iter()
            .try_for_each(|(place, result)| ended(place, result));
        drop(results);
        stopped
    })
}

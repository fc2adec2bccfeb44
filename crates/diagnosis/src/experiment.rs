//! The next experiment: which feasible run would separate two hypotheses, computed from their predictions.
//!
//! Candidate runs are simulated with both models; the distance of their predictions, in the noise's units, says what a
//! run would tell. The cheapest that separates is proposed, else the one that tells clearly more than all cheaper ones.

use std::sync::Arc;

use campaign::{Campaign, Direction, InitialState, Protocol, Run};
use fitting::noise::{Context, Sizes, Whitener};
use nalgebra::DVector;
use rig::{Experiment, Model};

use crate::bench::Bench;
use crate::equivalence::SEPARABLE;

/// A run in which two hypotheses differ by fewer standard deviations tells nothing, and is not proposed.
const LEAST: f64 = 2.0;
/// A dearer run is proposed in place of a cheaper one only if it tells so many times more.
const DEARER: f64 = 1.2;

/// A proposal: what to do, and what it would tell.
#[derive(Clone, Debug)]
pub(crate) struct Proposal {
    /// In words.
    pub(crate) text: String,
    /// Distance of the two predictions in standard deviations.
    pub(crate) distance: f64,
}

impl std::fmt::Display for Proposal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { text, distance } = self;
        write!(
            f,
            "{text} (the two would differ by {distance:.0} standard deviations)"
        )
    }
}

/// A hypothesis: causes by catalogue place with the whole parameter vector of the model.
pub(crate) struct Hypothesis<'a> {
    pub(crate) effects: &'a [usize],
    pub(crate) parameters: &'a [f64],
}

/// A candidate: words, price (runs and handling), and the runs themselves.
struct Candidate {
    text: &'static str,
    runs: Vec<Run>,
    /// The campaign's runs that these go through again, unchanged but for their place in the day; empty for other motions.
    again: Vec<usize>,
}

/// Proposes the run that tells two hypotheses apart; `None` where no run that was considered tells anything.
pub(crate) fn propose(
    bench: &Bench<'_>,
    sizes: &Sizes,
    a: &Hypothesis<'_>,
    b: &Hypothesis<'_>,
) -> Option<Proposal> {
    let mut best: Option<Proposal> = None;
    for candidate in candidates(bench.campaign) {
        let Some(distance) = distance(bench, sizes, &candidate, a, b) else {
            continue;
        };
        if distance > 1.5 * SEPARABLE {
            // Candidates come in the order of their cost: the first that separates well is the cheapest.
            return Some(Proposal {
                text: candidate.text.into(),
                distance,
            });
        }
        if best.as_ref().is_none_or(|p| distance > DEARER * p.distance) {
            best = Some(Proposal {
                text: candidate.text.into(),
                distance,
            });
        }
    }
    best.filter(|p| p.distance > LEAST)
}

/// Distance of the predictions in the candidate's own runs.
fn distance(
    bench: &Bench<'_>,
    sizes: &Sizes,
    candidate: &Candidate,
    a: &Hypothesis<'_>,
    b: &Hypothesis<'_>,
) -> Option<f64> {
    let mut longer: Campaign = bench.campaign.clone();
    let old = bench.samples.len();
    longer.runs.extend(candidate.runs.iter().cloned());
    let experiment = (Experiment::new(&longer).ok()?).moving_as(&bench.experiment);
    let predict = |h: &Hypothesis<'_>| -> Option<[Vec<f64>; 3]> {
        let effects = h
            .effects
            .iter()
            .map(|&i| bench.catalogue[i].boxed())
            .collect();
        let model = Model::new(bench.law, effects, &experiment).ok()?;
        let mut p = h.parameters.to_vec();
        p.resize(model.parameters().len(), 0.0);
        let mut whole = model.predict(&experiment, &p);
        let new = whole.split_off(old);
        Some([whole, new, model.friction(&experiment, &p)[old..].to_vec()])
    };
    let ([of_a, x, friction], [of_b, y, _]) = (predict(a)?, predict(b)?);
    let before: Vec<f64> = of_a.iter().zip(&of_b).map(|(p, q)| p - q).collect();
    let mut context = Context {
        runs: Vec::new(),
        conditions: Vec::new(),
        steps_s: Vec::new(),
        sliding: Vec::new(),
        place: Vec::new(),
        scale: friction,
        channel: Arc::default(),
        rows: Vec::new(),
    };
    for run in &experiment.runs[bench.samples.runs.len()..] {
        let start = context.sliding.len();
        let steps_s = run.time_s.windows(2).map(|pair| pair[1] - pair[0]);
        context.steps_s.extend(std::iter::once(0.0).chain(steps_s));
        context.sliding.extend(&run.distance_m);
        context.place.extend(&run.position_m);
        context.runs.push(start..context.sliding.len());
    }
    let mut difference = DVector::from_iterator(x.len(), x.iter().zip(&y).map(|(p, q)| p - q));
    for (run, again) in experiment.runs[bench.samples.runs.len()..]
        .iter()
        .zip(&candidate.again)
    {
        // What the two differ by in the run that is repeated the law has had to make up for already.
        for (i, first) in run.samples.clone().zip(bench.samples.runs[*again].clone()) {
            difference[i - old] -= before[first];
        }
    }
    if difference.iter().any(|d| !d.is_finite()) {
        return None;
    }
    Some(Whitener::new(&context, sizes).whiten(&difference).norm())
}

/// What a rig can usually do, cheapest first.
fn candidates(campaign: &Campaign) -> Vec<Candidate> {
    let forward = campaign
        .runs
        .iter()
        .find(|r| r.direction != Direction::Reverse)
        .or_else(|| campaign.runs.first());
    let Some(base) = forward else {
        return Vec::new();
    };
    let reverse = campaign
        .runs
        .iter()
        .find(|r| r.direction == Direction::Reverse);
    let pair = |change: &dyn Fn(&mut Run)| -> Vec<Run> {
        let mut runs = vec![base.clone()];
        runs.extend(reverse.cloned());
        place_after(campaign, &mut runs, 60.0);
        runs.iter_mut().for_each(change);
        runs
    };
    let loaded = base.normal_load_n.is_some_and(|n| n > 0.0);
    let turned = campaign.runs.iter().any(|r| r.stage_turned);
    let mut out = Vec::new();
    if loaded {
        out.push(Candidate {
            text: "one unloaded run (the reading without contact)",
            runs: pair(&|r| {
                r.normal_load_n = Some(0.0);
                r.normal_force_n = None;
                r.protocol = Protocol::Unloaded;
            })
            .into_iter()
            .take(1)
            .collect(),
            again: Vec::new(),
        });
    }
    let mut rested = vec![base.clone()];
    place_after(campaign, &mut rested, 3600.0);
    if base.started_s.is_some() {
        out.push(Candidate {
            text: "rest for an hour, then repeat one run",
            runs: rested,
            again: campaign
                .runs
                .iter()
                .position(|r| r == base)
                .into_iter()
                .collect(),
        });
    }
    out.push(Candidate {
        text: "one run of speed steps with sharp edges",
        runs: vec![reshaped(campaign, base, &steps)],
        again: Vec::new(),
    });
    out.push(Candidate {
        text: "one run back and forth, speed as a triangle",
        runs: vec![reshaped(campaign, base, &cycles)],
        again: Vec::new(),
    });
    out.push(Candidate {
        text: "one run at constant speed",
        runs: vec![reshaped(campaign, base, &constant)],
        again: Vec::new(),
    });
    out.push(Candidate {
        text: "one run of speed steps with sharp edges, sampled ten times as fast",
        runs: vec![hastened(reshaped(campaign, base, &steps))],
        again: Vec::new(),
    });
    if base.order.is_some() {
        let mut runs: Vec<Run> = campaign.runs.iter().rev().take(4).cloned().collect();
        place_after(campaign, &mut runs, 60.0);
        out.push(Candidate {
            text: "repeat the last four runs in reversed order",
            runs,
            again: (0..campaign.runs.len()).rev().take(4).collect(),
        });
    }
    if loaded {
        out.push(Candidate {
            text: "repeat one run each way at twice the load",
            runs: pair(&|r| {
                r.normal_load_n = r.normal_load_n.map(|n| 2.0 * n);
                if let Some(force) = &mut r.normal_force_n {
                    force.iter_mut().for_each(|f| *f *= 2.0);
                }
            }),
            again: Vec::new(),
        });
    }
    if !turned {
        out.push(Candidate {
            text: "turn the stage round and repeat one run each way",
            runs: pair(&|r| r.stage_turned = true),
            again: Vec::new(),
        });
    }
    out.push(Candidate {
        text: "turn the specimen round and repeat one run each way",
        runs: pair(&|r| r.specimen_turned = !r.specimen_turned),
        again: Vec::new(),
    });
    out
}

/// Puts runs behind the campaign's last one on its clock.
fn place_after(campaign: &Campaign, runs: &mut [Run], rest_s: f64) {
    let last = campaign
        .runs
        .iter()
        .filter_map(|r| Some(r.started_s? + r.time_s.last().copied().unwrap_or(0.0)))
        .fold(f64::NEG_INFINITY, f64::max);
    let order = campaign
        .runs
        .iter()
        .filter_map(|r| r.order)
        .fold(0.0, f64::max);
    let mut clock = last;
    for (k, run) in runs.iter_mut().enumerate() {
        clock += rest_s;
        if run.started_s.is_some() {
            run.started_s = Some(clock);
        }
        clock += run.time_s.last().copied().unwrap_or(0.0);
        if run.order.is_some() {
            run.order = Some(order + 1.0 + k as f64);
        }
        run.initial_state = InitialState::Relaxed;
    }
}

/// A run with another course of speed over the same time: `course(u)` in units of the top speed, u from 0 to 1.
fn reshaped(campaign: &Campaign, base: &Run, course: &dyn Fn(f64) -> f64) -> Run {
    let mut run = base.clone();
    let top = base
        .velocity_m_s
        .iter()
        .fold(0.0_f64, |m, v| m.max(v.abs()));
    let (start, end) = (run.time_s[0], run.time_s[run.time_s.len() - 1]);
    run.velocity_m_s = run
        .time_s
        .iter()
        .map(|t| top * course((t - start) / (end - start)))
        .collect();
    run.direction = if run.velocity_m_s.iter().any(|v| *v < 0.0) {
        Direction::Both
    } else {
        Direction::Forward
    };
    run.protocol = Protocol::Free;
    run.position_m = None;
    run.temperature_c = None;
    let mut one = [run];
    place_after(campaign, &mut one, 60.0);
    let [run] = one;
    run
}

/// The same course of speed in a tenth of the time, at as many samples: what lasts for less than a sample is drawn out over some.
fn hastened(mut run: Run) -> Run {
    const FASTER: f64 = 10.0;
    let start = run.time_s[0];
    for t in &mut run.time_s {
        *t = start + (*t - start) / FASTER;
    }
    run
}

fn steps(u: f64) -> f64 {
    const LEVELS: [f64; 5] = [0.1, 1.0, 0.2, 0.7, 0.4];
    if u <= 0.0 {
        0.0
    } else {
        LEVELS[((5.0 * u) as usize).min(4)]
    }
}

fn cycles(u: f64) -> f64 {
    // Four triangles of both signs, starting at rest.
    let phase = 4.0 * u;
    let t = phase - phase.floor();
    0.5 * if t < 0.25 {
        4.0 * t
    } else if t < 0.75 {
        2.0 - 4.0 * t
    } else {
        4.0 * t - 4.0
    }
}

fn constant(u: f64) -> f64 {
    0.5 * (u / 0.05).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prepare;
    use crate::selection::Start;
    use crate::settled::law_alone;
    use crate::subset::Subset;

    /// What is proposed to tell a lag of the force from a delay of it, both of `seconds`, in a campaign sampled 60 times a second.
    fn lag_or_delay(seconds: f64) -> Option<String> {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../../data/campaigns/brush-2x2-aluminium");
        let campaign = campaign::open(&folder).expect("a shipped campaign");
        let bench = prepare::bench(&campaign, &crate::Options::default()).expect("a bench");
        let law = law_alone(&bench, &Subset::all(&bench), Start::Scratch).expect("the law fits");
        let place = |id: &str| {
            let mut causes = bench.catalogue.iter();
            causes.position(|c| c.id() == id && c.parameters().len() == 1)
        };
        let [lag, delay] = ["sensor-lag", "clock-offset"].map(|id| [place(id).expect(id)]);
        let own = law.fitted.model.law_parameters();
        let mut parameters = law.fitted.parameters[..own].to_vec();
        parameters.push(seconds);
        let hypothesis = |effects| Hypothesis {
            effects,
            parameters: &parameters,
        };
        let sizes = &law.sizes;
        propose(&bench, sizes, &hypothesis(&lag), &hypothesis(&delay)).map(|p| p.text)
    }

    #[test]
    fn what_lasts_less_than_a_sample_asks_for_faster_samples() {
        let short = lag_or_delay(0.005).expect("an experiment");
        assert!(short.contains("sampled ten times as fast"), "{short}");
        let long = lag_or_delay(0.2).expect("an experiment");
        assert!(!long.contains("sampled"), "{long}");
    }
}

//! Very many runs: causes are searched in an excerpt of them, and what is found is then held against all the others.
//!
//! Runs are taken in groups of neighbours, evenly over the campaign, because history (heat, set, wear) lives from run to
//! run; then one run of every condition that no group holds. A run keeps its place in the day: when it started, how long the rig
//! rested, how far it had slid. Time and memory of the search do not grow with the campaign; the last comparison is one
//! prediction of every run.

use campaign::Campaign;
use rig::{Experiment, Model};

use crate::bench::Fitted;
use crate::floor;
use crate::samples::Samples;

/// Campaigns up to this many runs are searched as a whole.
const MOST_RUNS: usize = 64;
/// Groups of neighbours, and runs in a group.
const GROUPS: usize = 6;
const NEIGHBOURS: usize = 8;
/// Further runs for conditions that no group holds, at most.
const RARE: usize = 16;

/// Some runs of a campaign.
pub(crate) struct Excerpt {
    /// The campaign of these runs alone.
    pub(crate) campaign: Campaign,
    /// Their places among all runs.
    pub(crate) kept: Vec<usize>,
}

impl Excerpt {
    /// An excerpt of a campaign of very many runs; `None` where there are few.
    pub(crate) fn of(campaign: &Campaign) -> Option<Self> {
        let runs = campaign.runs.len();
        if runs <= MOST_RUNS {
            return None;
        }
        let mut kept: Vec<usize> = (0..GROUPS)
            .flat_map(|g| {
                let first = g * (runs - NEIGHBOURS) / (GROUPS - 1);
                first..first + NEIGHBOURS
            })
            .collect();
        let rare: Vec<usize> = campaign
            .conditions()
            .into_iter()
            .filter(|condition| !condition.iter().any(|k| kept.contains(k)))
            .map(|condition| condition[0])
            .take(RARE)
            .collect();
        kept.extend(rare);
        kept.sort_unstable();
        let few = Campaign {
            runs: kept.iter().map(|&k| campaign.runs[k].clone()).collect(),
            ..without_runs(campaign)
        };
        Some(Self {
            campaign: few,
            kept,
        })
    }

    /// Gives the excerpt's runs the history that they have in the whole campaign.
    pub(crate) fn place(&self, all: &Experiment, experiment: &mut Experiment) {
        for (run, &k) in experiment.runs.iter_mut().zip(&self.kept) {
            run.take_past_of(&all.runs[k]);
        }
    }

    /// Errors of the law alone and with the named causes on the runs that no fit has seen.
    pub(crate) fn unseen(
        &self,
        campaign: &Campaign,
        all: &Experiment,
        law: &Fitted,
        extended: &Fitted,
    ) -> Unseen {
        let mut samples = Samples::new(campaign);
        samples.least_speed_m_s = law.model.least_speed_m_s();
        let mut other = vec![true; campaign.runs.len()];
        self.kept.iter().for_each(|&k| other[k] = false);
        let others: Vec<usize> = (0..other.len()).filter(|&k| other[k]).collect();
        let error = |fitted: &Fitted| {
            let prediction = self.prediction(all, fitted);
            floor::rmse_of(&samples, &prediction, &others)
        };
        Unseen {
            searched: self.kept.len(),
            others: others.len(),
            unit: if samples.loaded {
                ""
            } else {
                " of the force's unit"
            },
            law: error(law),
            extended: (!extended.effects.is_empty()).then(|| error(extended)),
        }
    }

    /// Prediction of a fit for all runs; runs outside the excerpt start relaxed.
    fn prediction(&self, all: &Experiment, fitted: &Fitted) -> Vec<f64> {
        let effects = fitted.model.effects().iter().map(|e| e.boxed()).collect();
        let model = Model::new(fitted.model.law, effects, all)
            .expect("the same law and effects made a model of some of the runs");
        let shared = fitted.model.initial_states().start;
        let mut parameters = vec![0.0; model.parameters().len()];
        parameters[..shared].copy_from_slice(&fitted.parameters[..shared]);
        for (own, &k) in self.kept.iter().enumerate() {
            if let (Some(from), Some(to)) = (
                fitted.model.initial_state_of(own),
                model.initial_state_of(k),
            ) {
                parameters[to] = fitted.parameters[from];
            }
        }
        model.predict(all, &parameters)
    }
}

/// How a diagnosis made in an excerpt does on all the other runs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Unseen {
    searched: usize,
    others: usize,
    unit: &'static str,
    law: f64,
    extended: Option<f64>,
}

impl Unseen {
    /// Whether the named causes make the error no smaller there: then the excerpt was explained, not the campaign.
    pub(crate) fn speaks_against(&self) -> bool {
        self.extended.is_some_and(|extended| !(extended < self.law))
    }

    /// What the reader should know: how many runs were searched, and the errors on all the others.
    pub(crate) fn note(&self) -> String {
        let unit = self.unit;
        let named = match self.extended {
            Some(error) if self.speaks_against() => format!(
                "; with what was named in the excerpt it is {error:.3e}{unit}, no smaller, and the names were taken back"
            ),
            Some(error) => format!(", with the named causes {error:.3e}{unit}"),
            None => String::new(),
        };
        format!(
            "causes were searched in {} of {} runs; on the {} others, which no fit has seen, the error of the law alone is \
             {:.3e}{unit}{named}",
            self.searched,
            self.searched + self.others,
            self.others,
            self.law,
        )
    }
}

/// All that a campaign says beside its runs.
fn without_runs(campaign: &Campaign) -> Campaign {
    Campaign {
        name: campaign.name.clone(),
        title: campaign.title.clone(),
        provenance: campaign.provenance,
        axis: campaign.axis,
        specimen: campaign.specimen.clone(),
        counterface: campaign.counterface.clone(),
        rig: campaign.rig.clone(),
        runs: Vec::new(),
        input_hashes: campaign.input_hashes.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A shipped campaign's first run, `runs` times; one of them at another load.
    fn many(runs: usize, odd: usize) -> Campaign {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../../data/campaigns/brush-2x2-aluminium");
        let mut campaign = campaign::open(&folder).expect("a shipped campaign");
        let one = campaign.runs[0].clone();
        campaign.runs = (0..runs)
            .map(|k| {
                let mut run = one.clone();
                run.name = format!("run-{k}");
                run.order = Some(k as f64);
                run.started_s = Some(60.0 * k as f64);
                if k == odd {
                    run.normal_load_n = run.normal_load_n.map(|n| 2.0 * n);
                }
                run
            })
            .collect();
        campaign
    }

    /// Names that make the error on unseen runs no smaller do not stay, and the note says so.
    #[test]
    fn unseen_runs_speak_against_names_that_do_not_help() {
        let unseen = |extended| Unseen {
            searched: 48,
            others: 952,
            unit: "",
            law: 0.02,
            extended,
        };
        for (extended, against) in [
            (None, false),
            (Some(0.019), false),
            (Some(0.02), true),
            (Some(0.021), true),
            (Some(f64::NAN), true),
        ] {
            let unseen = unseen(extended);
            assert_eq!(unseen.speaks_against(), against, "{extended:?}");
            assert_eq!(unseen.note().contains("taken back"), against);
            assert!(unseen.note().contains("in 48 of 1000 runs"));
        }
    }

    #[test]
    fn few_runs_are_searched_whole() {
        assert!(Excerpt::of(&many(MOST_RUNS, 3)).is_none());
    }

    #[test]
    fn the_search_does_not_grow_with_the_runs_and_keeps_rare_conditions_and_history() {
        for runs in [100, 400, 1000] {
            let odd = runs / 3 + 1;
            let campaign = many(runs, odd);
            let excerpt = Excerpt::of(&campaign).expect("many");
            assert_eq!(excerpt.kept.len(), GROUPS * NEIGHBOURS + 1);
            assert!(excerpt.kept.contains(&odd) && excerpt.kept.contains(&0));
            assert!(excerpt.kept.contains(&(runs - 1)));
            let all = Experiment::new(&campaign).expect("it moves");
            let mut few = Experiment::new(&excerpt.campaign).expect("it moves");
            excerpt.place(&all, &mut few);
            let slid = all.runs[0].distance_m.last().copied().expect("samples");
            for (run, &k) in few.runs.iter().zip(&excerpt.kept) {
                assert_eq!(run.started_s, Some(60.0 * k as f64));
                let before = run.prior_distance_m.expect("the order is known");
                assert!((before - slid * k as f64).abs() < 1e-9 * before.max(1.0));
            }
        }
    }
}

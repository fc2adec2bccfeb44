//! Which cases the benchmark tries: every kind of truth, in an order of which every beginning is a fair sample.

use planting::protocols::Protocol;
use planting::roughness::stream;
use planting::species::{ALIENS, CAUSES, SECOND_SHAPES};
use planting::{Base, Case, NoiseKind};
use rand::RngExt;
use serde::{Deserialize, Serialize};

/// What a case is meant to show.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Group {
    /// Nothing planted.
    Nothing,
    /// One cause.
    Single,
    /// One cause in another shape than the catalogue's.
    SecondShape,
    /// Two causes.
    Pair,
    /// Three causes.
    Triple,
    /// Something outside the catalogue.
    Alien,
    /// One cause, taken out of the finder's catalogue.
    Control,
    /// One cause on another law.
    OtherLaw,
}

/// A case of the benchmark; sizes are in thresholds until the oracle has looked.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trial {
    /// Stable name of the case.
    pub id: String,
    /// What it shows.
    pub group: Group,
    /// The case, sizes of what is planted still to be set.
    pub case: Case,
    /// Size in thresholds of the oracle.
    pub ratio: f64,
    /// Cause taken out of the finder's catalogue.
    pub without: Option<String>,
}

/// Seeds: those used while developing and those kept for the final figures do not meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Season {
    /// Used while developing the diagnosis.
    Development,
    /// Kept for the final figures.
    Final,
}

impl Season {
    /// First seed.
    pub fn first_seed(self) -> u64 {
        match self {
            Self::Development => 1_000_000,
            Self::Final => 9_000_000,
        }
    }
}

/// Specimens of each protocol: few, because the oracle looks at each.
const SPECIMENS: u64 = 3;

struct Builder {
    season: Season,
    trials: Vec<Trial>,
    next_seed: u64,
}

impl Builder {
    fn add(&mut self, group: Group, mut case: Case, ratio: f64, without: Option<&str>) {
        let seed = self.next_seed;
        self.next_seed += 1;
        case.seed = seed;
        case.specimen = self.season.first_seed() + 500_000 + case.specimen % SPECIMENS;
        let names: Vec<String> = case
            .planted
            .iter()
            .map(|p| {
                if p.second_shape {
                    format!("{}-2", p.id)
                } else {
                    p.id.clone()
                }
            })
            .collect();
        let what = if names.is_empty() {
            "nothing".to_string()
        } else {
            names.join("+")
        };
        let left_out = without.map_or(String::new(), |cause| format!(":without-{cause}"));
        let id = format!(
            "{seed}:{what}:{}:{}:{ratio}{left_out}",
            case.protocol.id(),
            case.noise.id()
        );
        self.trials.push(Trial {
            id,
            group,
            case,
            ratio,
            without: without.map(Into::into),
        });
    }
}

/// All trials of a season, mixed.
pub fn trials(season: Season) -> Vec<Trial> {
    let mut builder = Builder {
        season,
        trials: Vec::new(),
        next_seed: season.first_seed(),
    };
    nothing(&mut builder);
    singles(&mut builder);
    several(&mut builder);
    strangers(&mut builder);
    // Plates whose roughness has no corners, which no noise model here describes exactly; a force channel whose zero wanders while it measures.
    nothing_on_brushes(&mut builder, NoiseKind::SmoothRoughness);
    nothing_on_brushes(&mut builder, NoiseKind::Amplifier);
    let mut trials = builder.trials;
    // Fisher-Yates with a fixed stream: every beginning of the list is a fair sample of the whole.
    let mut generator = stream(season.first_seed(), 77);
    for i in (1..trials.len()).rev() {
        trials.swap(i, generator.random_range(0..=i));
    }
    trials
}

fn nothing(builder: &mut Builder) {
    for replicate in 0..28 {
        for noise in NoiseKind::HEALTHY {
            for protocol in Protocol::ALL {
                if !protocol.is_brush() && replicate % 4 != 0 {
                    continue;
                }
                builder.add(
                    Group::Nothing,
                    Case::nothing(protocol, noise, replicate),
                    0.0,
                    None,
                );
            }
        }
    }
}

fn singles(builder: &mut Builder) {
    for specimen in 0..SPECIMENS {
        for ratio in [1.0, 1.5, 2.0, 3.0, 5.0, 10.0] {
            for protocol in [
                Protocol::PaperBlocked,
                Protocol::PaperAlternating,
                Protocol::Rich,
                Protocol::RichTurned,
                Protocol::Drive,
            ] {
                for cause in CAUSES {
                    let case = Case::one(cause, 1.0, protocol, specimen);
                    builder.add(Group::Single, case, ratio, None);
                }
            }
        }
    }
    for specimen in 0..SPECIMENS {
        for protocol in [Protocol::PaperBlocked, Protocol::Rich] {
            for ratio in [2.0, 5.0] {
                for cause in SECOND_SHAPES {
                    let case =
                        Case::nothing(protocol, NoiseKind::Usual, specimen).with(cause, 1.0, true);
                    builder.add(Group::SecondShape, case, ratio, None);
                }
            }
        }
    }
    for (base, protocol) in [
        (Base::SymmetricBristle, Protocol::Rich),
        (Base::Lugre, Protocol::Speeds),
        (Base::Lugre, Protocol::Rotary),
        (Base::Stribeck, Protocol::Rich),
        (Base::Dahl, Protocol::Drive),
        (Base::CoulombViscous, Protocol::Speeds),
    ] {
        for cause in CAUSES {
            builder.add(
                Group::OtherLaw,
                Case::one(cause, 1.0, protocol, 0).on(base),
                5.0,
                None,
            );
        }
    }
}

fn several(builder: &mut Builder) {
    let mut generator = stream(builder.season.first_seed(), 78);
    for replicate in 0..160_u64 {
        let count = if replicate % 4 == 0 { 3 } else { 2 };
        let mut chosen: Vec<&str> = Vec::new();
        while chosen.len() < count {
            let cause = CAUSES[generator.random_range(0..CAUSES.len())];
            if !chosen.contains(&cause) {
                chosen.push(cause);
            }
        }
        let protocol = if replicate % 2 == 0 {
            Protocol::Rich
        } else {
            Protocol::RichTurned
        };
        let mut case = Case::nothing(protocol, NoiseKind::Usual, replicate);
        for cause in chosen {
            case = case.with(cause, 1.0, false);
        }
        builder.add(
            if count == 3 {
                Group::Triple
            } else {
                Group::Pair
            },
            case,
            5.0,
            None,
        );
    }
}

fn strangers(builder: &mut Builder) {
    for replicate in 0..8 {
        for alien in ALIENS {
            for protocol in [
                Protocol::PaperBlocked,
                Protocol::PaperAlternating,
                Protocol::Rich,
            ] {
                builder.add(
                    Group::Alien,
                    Case::one(alien, 1.0, protocol, replicate),
                    5.0,
                    None,
                );
            }
        }
    }
    for specimen in 0..SPECIMENS {
        for cause in CAUSES {
            builder.add(
                Group::Control,
                Case::one(cause, 1.0, Protocol::Rich, specimen),
                5.0,
                Some(cause),
            );
        }
    }
}

/// Nothing on every protocol of brushes, with this noise.
fn nothing_on_brushes(builder: &mut Builder, noise: NoiseKind) {
    for replicate in 0..28 {
        for protocol in Protocol::ALL {
            if protocol.is_brush() {
                let case = Case::nothing(protocol, noise, replicate);
                builder.add(Group::Nothing, case, 0.0, None);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    /// Names are unique, seasons share no seed.
    #[test]
    fn trials_are_distinct() {
        let development = trials(Season::Development);
        let ids: BTreeSet<&str> = development.iter().map(|trial| trial.id.as_str()).collect();
        assert_eq!(ids.len(), development.len());
        let seeds: BTreeSet<u64> = development.iter().map(|trial| trial.case.seed).collect();
        assert!(
            trials(Season::Final)
                .iter()
                .all(|trial| !seeds.contains(&trial.case.seed))
        );
    }
}

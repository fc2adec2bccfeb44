//! A stage between its samples: the force tells a velocity that is straight there from one as smooth as the samples look.

mod rigs;

use campaign::Campaign;
use diagnosis::{Diagnosis, Options, Status, diagnose};
use friction::LawKind;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use rig::{Experiment, Model};

/// Some thirty samples a turn of the cycles: the chord of a step cuts off ten micrometres of way.
const SAMPLES: usize = 60;
const NOISE_N: f64 = 5e-4;

/// A LuGre contact on the motions that are chosen, recorded with noise.
fn recorded(moving: impl Fn(Experiment) -> Experiment) -> Campaign {
    let mut campaign = rigs::rich(SAMPLES);
    let experiment = moving(Experiment::new(&campaign).expect("it moves"));
    let model = Model::new(LawKind::Lugre, Vec::new(), &experiment).expect("a law");
    let force = model.predict(&experiment, &rigs::LUGRE);
    let mut generator = ChaCha8Rng::seed_from_u64(4711);
    let noise = Normal::new(0.0, NOISE_N).expect("a spread");
    for (run, motion) in campaign.runs.iter_mut().zip(&experiment.runs) {
        let own = force[motion.samples.clone()].iter();
        run.force_n = own.map(|f| f + noise.sample(&mut generator)).collect();
    }
    campaign
}

fn asked(campaign: &Campaign) -> (Diagnosis, bool) {
    let options = Options {
        law: Some(LawKind::Lugre),
        quick: true,
        ..Options::default()
    };
    let answer = diagnose(campaign, &options).expect("an answer");
    let straight = (answer.notes.iter()).any(|note| note.contains("straight between its samples"));
    (answer, straight)
}

#[test]
fn a_stage_along_its_chords_is_no_error_of_the_law() {
    let chords = |bent: Experiment| bent.along_chords().expect("the cycles bend");
    let (answer, straight) = asked(&recorded(chords));
    assert!(straight, "{:?}", answer.notes);
    assert_eq!(answer.status, Status::Consistent, "{:?}", answer.findings);
}

#[test]
fn a_smooth_stage_stays_smooth() {
    let (answer, straight) = asked(&recorded(|bent| bent));
    assert!(!straight);
    assert_eq!(answer.status, Status::Consistent, "{:?}", answer.findings);
}

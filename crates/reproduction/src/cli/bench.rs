//! `bench`: how long the main steps take, and whether 95 % intervals cover. Timings are for reading, never assertions.

use std::time::Instant;

use campaign::Campaign;
use friction::LawKind;
use identification::{Question, identify};
use rig::{Experiment, Model};

use super::{BenchArguments, Failure, Outcome, coverage, root};
use crate::names::nearest;
use crate::results::significant;

/// The campaign that all of them use.
const CAMPAIGN: &str = "data/campaigns/brush-2x2-aluminium";

type Bench = fn(&Campaign, &BenchArguments) -> Result<(), Failure>;

const BENCHES: [(&str, Bench); 3] = [
    ("ramp", ramp),
    ("identification", identification),
    ("coverage", covers),
];

pub(super) fn run(arguments: &BenchArguments) -> Result<Outcome, Failure> {
    let chosen: Vec<&(&str, Bench)> = match &arguments.name {
        // Coverage takes an hour with its full count: it is asked for by name.
        None => BENCHES
            .iter()
            .filter(|(name, _)| *name != "coverage")
            .collect(),
        Some(wanted) => {
            let found = BENCHES
                .iter()
                .find(|(name, _)| name == wanted)
                .ok_or_else(|| {
                    let names = BENCHES
                        .iter()
                        .map(|(name, _)| *name)
                        .chain(["hidden-effects"]);
                    Failure::Input(format!(
                        "no benchmark is called `{wanted}`; the nearest name is `{}`",
                        nearest(wanted, names)
                    ))
                })?;
            vec![found]
        }
    };
    let campaign = campaign::open(&root::root()?.join(CAMPAIGN)).map_err(Failure::input)?;
    for (name, bench) in chosen {
        say!("{name}");
        bench(&campaign, arguments)?;
    }
    Ok(Outcome::Done)
}

/// Microseconds of the fastest of several rounds: what the machine can do, whatever else it is doing.
fn fastest_us(rounds: usize, calls: usize, mut f: impl FnMut()) -> f64 {
    (0..rounds)
        .map(|_| {
            let start = Instant::now();
            (0..calls).for_each(|_| f());
            start.elapsed().as_secs_f64() * 1e6 / calls as f64
        })
        .fold(f64::INFINITY, f64::min)
}

/// One run of 600 samples without derivatives, and the Jacobian of the campaign.
fn ramp(campaign: &Campaign, _: &BenchArguments) -> Result<(), Failure> {
    let found = identify(
        campaign,
        &Question::of(LawKind::AsymmetricBristle).values_only(),
    )
    .map_err(Failure::input)?;
    let one = Campaign {
        runs: campaign.runs[..1].to_vec(),
        ..campaign.clone()
    };
    let experiment = Experiment::new(&one).map_err(Failure::input)?;
    let model =
        Model::new(LawKind::AsymmetricBristle, Vec::new(), &experiment).map_err(Failure::input)?;
    let mut sum = 0.0;
    let plain = fastest_us(20, 50, || {
        sum += model.predict(&experiment, &found.parameters)[0]
    });
    let jacobian = fastest_us(5, 10, || {
        sum += model
            .predict_with_jacobian(&experiment, &found.parameters, None)
            .0[0];
    });
    say!(
        "  prediction of one ramp of {} samples  {} us",
        experiment.samples(),
        significant(plain)
    );
    say!(
        "  the same with its Jacobian            {} us ({} predictions)",
        significant(jacobian),
        significant(jacobian / plain)
    );
    // The sum keeps the calls from being dropped.
    if sum.is_nan() {
        Err(Failure::Output("a prediction is no number".into()))
    } else {
        Ok(())
    }
}

/// Identification of the campaign: values and noise, then with intervals.
fn identification(campaign: &Campaign, _: &BenchArguments) -> Result<(), Failure> {
    let question = || Question::of(LawKind::AsymmetricBristle);
    for (words, question) in [
        ("values and noise", question().values_only()),
        ("with profile intervals", question()),
    ] {
        let start = Instant::now();
        let found = identify(campaign, &question).map_err(Failure::input)?;
        let seconds = start.elapsed().as_secs_f64();
        say!(
            "  {words:24} {} s, {}",
            significant(seconds),
            found.status.id()
        );
    }
    Ok(())
}

/// How often nominal 95 % intervals hold the truth in simulated campaigns.
fn covers(_: &Campaign, arguments: &BenchArguments) -> Result<(), Failure> {
    coverage::run(arguments.count, arguments.seed)
}

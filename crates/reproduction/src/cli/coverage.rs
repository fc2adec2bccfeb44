//! `bench coverage`: does 95 % mean 95 %?

use identification::{Coverage, Question, Truth, coverage, identify};

use super::Failure;

/// Campaigns whose identified parameters and noise are the truth of the simulation.
const CAMPAIGNS: [&str; 2] = ["brush-2x2-aluminium", "brush-2x2-nylon"];
/// Every so many campaigns is also resampled over runs.
const RESAMPLE_EVERY: usize = 4;

/// Simulates and identifies `count` campaigns after each template.
pub(super) fn run(count: usize, seed: u64) -> Result<(), Failure> {
    CAMPAIGNS
        .iter()
        .try_for_each(|name| of_campaign(name, count, seed))
}

/// The truth is what the campaign itself gives: parameters and noise as identified, with a parameter whose interval
/// reaches its bound put on the bound (there the interval is one-sided).
fn of_campaign(name: &str, count: usize, seed: u64) -> Result<(), Failure> {
    let path = super::root::root()?.join("data/campaigns").join(name);
    let template = campaign::open(&path).map_err(Failure::input)?;
    let law = friction::LawKind::AsymmetricBristle;
    let found = identify(&template, &Question::of(law)).map_err(Failure::input)?;
    let parameters = found
        .estimates
        .iter()
        .map(|e| match e.interval.as_ref().map(|i| &i.lower) {
            Some(fitting::Limit::OwnBound { value }) => *value,
            _ => e.value,
        })
        .collect();
    let truth = Truth {
        law,
        parameters,
        noise: found.noise.sizes,
    };
    eprintln!("{name}: simulating and identifying {count} campaigns");
    let covered =
        coverage(&template, &truth, count, seed, RESAMPLE_EVERY).map_err(Failure::input)?;
    print(name, seed, &covered);
    Ok(())
}

fn print(name: &str, seed: u64, found: &Coverage) {
    println!(
        "{name}: {} campaigns, seed {seed}, {} converged, {} resampled over runs",
        found.campaigns, found.converged, found.resampled
    );
    println!(
        "{:20} {:>12} {:>9} {:>7} {:>7} {:>9} {:>10} {:>10} {:>7}",
        "parameter",
        "truth",
        "covered",
        "above",
        "below",
        "on bound",
        "half width",
        "bootstrap",
        "bias"
    );
    let share = |count: usize, of: usize| 100.0 * count as f64 / of.max(1) as f64;
    for p in &found.parameters {
        println!(
            "{:20} {:>12.5e} {:>8.2}% {:>6.2}% {:>6.2}% {:>8.2}% {:>9.2}% {:>9.2}% {:>+7.3}",
            p.name,
            p.truth,
            share(p.covered, found.campaigns),
            share(p.above, found.campaigns),
            share(p.below, found.campaigns),
            share(p.at_bound, found.campaigns),
            100.0 * p.median_half_width,
            share(p.bootstrap_covered, found.resampled),
            p.bias
        );
    }
}

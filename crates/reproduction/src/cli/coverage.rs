//! `bench coverage`: does 95 % mean 95 %?
//!
//! Campaigns that are done are kept below `target/coverage`, one line each, and not repeated while program, truth and
//! seed stay the same: an interrupted run goes on where it stopped.

use std::path::{Path, PathBuf};

use identification::{
    Coverage, Identification, Question, Simulated, Simulation, Truth, coverage, identify,
};
use rayon::prelude::*;
use serde_json::{Value, json};

use super::{Failure, root};
use crate::cache::{Key, program_identity};

/// Campaigns whose identified parameters and noise are the truth of the simulation.
const CAMPAIGNS: [&str; 2] = ["brush-2x2-aluminium", "brush-2x2-nylon"];
/// Every so many campaigns is also resampled over runs.
const RESAMPLE_EVERY: usize = 4;
/// Campaigns between two words on progress.
const BATCH: usize = 20;

/// Simulates and identifies `count` campaigns after each template, in turn, so that a run that is stopped has as many
/// of each; prints the counts and writes them to `target/coverage/coverage.json`.
pub(super) fn run(count: usize, seed: u64) -> Result<(), Failure> {
    let root = root::root()?;
    let folder = root.join("target/coverage");
    std::fs::create_dir_all(&folder)
        .map_err(|error| Failure::Output(format!("{}: {error}", folder.display())))?;
    let templates = CAMPAIGNS
        .iter()
        .map(|name| Template::open(&root, name))
        .collect::<Result<Vec<_>, _>>()?;
    let mut series = templates
        .iter()
        .map(|template| Series::open(template, &folder, seed))
        .collect::<Result<Vec<_>, _>>()?;
    for first in (0..count).step_by(BATCH) {
        let last = (first + BATCH).min(count);
        for one in &mut series {
            one.go_on(first..last)?;
        }
        say_aside!("{last} of {count} campaigns of each");
    }
    let mut tables = serde_json::Map::new();
    for one in &series {
        let counted = coverage(&one.template.truth, &one.done[..count]);
        print(one.template.name, seed, &counted);
        tables.insert(one.template.name.to_owned(), one.table(&counted));
    }
    let document = json!({
        "schema": "bristle/coverage/1",
        "commit": crate::provenance::run(&root).commit,
        "seed": seed,
        "campaigns": tables,
    });
    let path = folder.join("coverage.json");
    let text = format!("{document:#}\n");
    campaign::write_atomically(&path, text.as_bytes())
        .map_err(|error| Failure::Output(format!("{}: {error}", path.display())))?;
    say!("written to {}", path.display());
    Ok(())
}

/// A campaign and what is taken from it as the truth.
struct Template {
    name: &'static str,
    campaign: campaign::Campaign,
    found: Identification,
    truth: Truth,
}

impl Template {
    /// The truth is what the campaign itself gives: parameters and noise as identified, with a parameter whose
    /// interval reaches its bound put on the bound (there the interval is one-sided).
    fn open(root: &Path, name: &'static str) -> Result<Self, Failure> {
        let path = root.join("data/campaigns").join(name);
        let campaign = campaign::open(&path).map_err(Failure::input)?;
        let law = friction::LawKind::AsymmetricBristle;
        let found = identify(&campaign, &Question::of(law)).map_err(Failure::input)?;
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
        Ok(Self {
            name,
            campaign,
            found,
            truth,
        })
    }
}

/// The campaigns simulated after one template.
struct Series<'a> {
    template: &'a Template,
    simulation: Simulation<'a>,
    path: PathBuf,
    done: Vec<Option<Vec<Simulated>>>,
}

impl<'a> Series<'a> {
    fn open(template: &'a Template, folder: &Path, seed: u64) -> Result<Self, Failure> {
        let simulation = Simulation::new(&template.campaign, &template.truth, seed, RESAMPLE_EVERY)
            .map_err(Failure::input)?;
        let program = program_identity()
            .map_err(|error| Failure::Output(format!("the program cannot be read: {error}")))?;
        let mut key = Key::new(&program);
        key.add("truth", &format!("{:?}", template.truth));
        key.add("seed", &seed.to_string());
        let path = folder.join(format!("{}-{}.txt", template.name, &key.text()[..16]));
        let parameters = template.truth.parameters.len();
        // A last line that an interruption cut short does not parse: it and what follows it is done again.
        let done = std::fs::read_to_string(&path)
            .unwrap_or_default()
            .lines()
            .map_while(|line| parsed(line, parameters))
            .collect();
        Ok(Self {
            template,
            simulation,
            path,
            done,
        })
    }

    /// Does those of `range` that are not yet done, side by side, and keeps them in order.
    fn go_on(&mut self, range: std::ops::Range<usize>) -> Result<(), Failure> {
        let first = self.done.len().max(range.start);
        if first >= range.end {
            return Ok(());
        }
        let fresh: Vec<_> = (first..range.end)
            .into_par_iter()
            .map(|k| self.simulation.campaign(k))
            .collect();
        self.done.extend(fresh);
        let text: String = self.done.iter().map(line).collect();
        campaign::write_atomically(&self.path, text.as_bytes())
            .map_err(|error| Failure::Output(format!("{}: {error}", self.path.display())))
    }

    /// Counts, and the estimates of the template by which a reader sees whether the identification is still the one
    /// that was counted.
    fn table(&self, counted: &Coverage) -> Value {
        let parameters: Vec<Value> = counted
            .parameters
            .iter()
            .zip(&self.template.found.estimates)
            .map(|(p, e)| {
                let end = |x: f64| x.is_finite().then_some(x);
                let interval = e.interval.as_ref();
                json!({
                    "name": p.name,
                    "truth": p.truth,
                    "estimate": e.value,
                    "ci95": interval.map(|i| [end(i.low()), end(i.high())]),
                    "covered": p.covered,
                    "above": p.above,
                    "below": p.below,
                    "at_bound": p.at_bound,
                    "bootstrap_covered": p.bootstrap_covered,
                    "median_relative_half_width": end(p.median_half_width),
                })
            })
            .collect();
        json!({
            "campaigns": counted.campaigns,
            "converged": counted.converged,
            "resampled": counted.resampled,
            "parameters": parameters,
        })
    }
}

/// One campaign as a line: eight words a parameter, or one dash where the fit did not converge.
fn line(outcome: &Option<Vec<Simulated>>) -> String {
    let Some(all) = outcome else {
        return "-\n".to_owned();
    };
    let words: Vec<String> = all
        .iter()
        .map(|s| {
            let bootstrap = s.bootstrap.map_or("-", |held| if held { "1" } else { "0" });
            format!(
                "{:e} {:e} {:e} {:e} {} {:e} {:e} {bootstrap}",
                s.value,
                s.sd,
                s.low,
                s.high,
                u8::from(s.at_bound),
                s.degrees,
                s.gain_share
            )
        })
        .collect();
    words.join(" ") + " .\n"
}

/// The reverse of [`line`]; `None` for anything else.
fn parsed(line: &str, parameters: usize) -> Option<Option<Vec<Simulated>>> {
    if line == "-" {
        return Some(None);
    }
    let words: Vec<&str> = line.strip_suffix(" .")?.split(' ').collect();
    let all: Option<Vec<Simulated>> = words
        .chunks(8)
        .map(|w| {
            let [
                value,
                sd,
                low,
                high,
                at_bound,
                degrees,
                gain_share,
                bootstrap,
            ] = w
            else {
                return None;
            };
            Some(Simulated {
                value: value.parse().ok()?,
                sd: sd.parse().ok()?,
                low: low.parse().ok()?,
                high: high.parse().ok()?,
                at_bound: *at_bound == "1",
                degrees: degrees.parse().ok()?,
                gain_share: gain_share.parse().ok()?,
                bootstrap: match *bootstrap {
                    "1" => Some(true),
                    "0" => Some(false),
                    _ => None,
                },
            })
        })
        .collect();
    all.filter(|all| all.len() == parameters).map(Some)
}

fn print(name: &str, seed: u64, found: &Coverage) {
    say!(
        "{name}: {} campaigns, seed {seed}, {} converged, {} resampled over runs",
        found.campaigns,
        found.converged,
        found.resampled
    );
    say!(
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
        say!(
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_holds_every_digit_and_a_torn_one_nothing() {
        let one = Simulated {
            value: 0.1 + 0.2,
            sd: f64::NAN,
            low: f64::NEG_INFINITY,
            high: 1.0 / 3.0,
            at_bound: true,
            degrees: f64::INFINITY,
            gain_share: 0.25,
            bootstrap: Some(false),
        };
        let text = line(&Some(vec![one, one]));
        let back = parsed(text.trim_end(), 2).unwrap().unwrap();
        assert!(back[1].sd.is_nan());
        let whole = Simulated { sd: 0.0, ..back[1] };
        assert_eq!(whole, Simulated { sd: 0.0, ..one });
        assert_eq!(parsed(line(&None).trim_end(), 2), Some(None));
        for cut in 1..text.len() - 1 {
            assert_eq!(parsed(&text[..cut], 2), None);
        }
    }
}

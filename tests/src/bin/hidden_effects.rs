//! The benchmark of hidden effects: plants, asks, judges, adds up. Can be interrupted and taken up again.

use std::collections::BTreeSet;
use std::fs::{File, OpenOptions};
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use indicatif::{ProgressBar, ProgressStyle};
use whole_program::hidden::carry_out::{Workshop, side_by_side};
use whole_program::hidden::judge::Verdict;
use whole_program::hidden::selection::{Season, Trial, trials};
use whole_program::hidden::tally::{Judged, table};
use whole_program::identity::of_diagnosis;

const USAGE: &str = "usage: bench hidden-effects [--final] [--limit N] [--minutes M] [--only TEXT] [--gain] [--export DIR] [--out FILE]";

const HELP: &str = "\
Hides effects in synthetic campaigns, lets the diagnosis answer, and judges the answers.
  --final       seeds that are not used while developing (default: development seeds)
  --limit N     at most N trials in all, earlier ones included
  --minutes M   stop after M minutes
  --only TEXT   only trials whose name holds TEXT
  --gain        also let the diagnosis compute its held-out gain (slower)
  --export DIR  write the packages of the trials (chosen by --only and --limit) and their keys below DIR, ask nothing
  --out FILE    where the table goes (default: beside the judged trials)
Judged trials are kept below target/hidden-effects and not repeated while the diagnosis stays the same.";

struct Request {
    season: Season,
    limit: usize,
    minutes: f64,
    only: Option<String>,
    gain: bool,
    out: Option<PathBuf>,
    export: Option<PathBuf>,
}

fn main() -> ExitCode {
    let request = match parse() {
        Ok(Some(request)) => request,
        Ok(None) => {
            println!("{USAGE}\n{HELP}");
            return ExitCode::SUCCESS;
        }
        Err(problem) => {
            eprintln!("{problem}\n{USAGE}");
            return ExitCode::from(2);
        }
    };
    match run(&request) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("hidden-effects: {error}");
            ExitCode::from(3)
        }
    }
}

fn parse() -> Result<Option<Request>, String> {
    let mut request = Request {
        season: Season::Development,
        limit: usize::MAX,
        minutes: f64::INFINITY,
        only: None,
        gain: false,
        out: None,
        export: None,
    };
    let mut arguments = std::env::args().skip(1).peekable();
    while arguments
        .peek()
        .is_some_and(|word| word == "bench" || word == "hidden-effects")
    {
        arguments.next();
    }
    while let Some(argument) = arguments.next() {
        let mut value = || {
            arguments
                .next()
                .ok_or_else(|| format!("{argument} needs a value"))
        };
        match argument.as_str() {
            "--final" => request.season = Season::Final,
            "--gain" => request.gain = true,
            "--limit" => {
                request.limit = value()?
                    .parse()
                    .map_err(|_| "--limit needs a number".to_string())?
            }
            "--minutes" => {
                request.minutes = value()?
                    .parse()
                    .map_err(|_| "--minutes needs a number".to_string())?
            }
            "--only" => request.only = Some(value()?),
            "--out" => request.out = Some(value()?.into()),
            "--export" => request.export = Some(value()?.into()),
            "--help" | "-h" => return Ok(None),
            other => return Err(format!("unknown option {other:?}")),
        }
    }
    Ok(Some(request))
}

fn run(request: &Request) -> Result<(), String> {
    if let Some(folder) = &request.export {
        return export(request, folder);
    }
    let identity = of_diagnosis();
    let season = if request.season == Season::Final {
        "final"
    } else {
        "development"
    };
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/hidden-effects");
    let folder = root.join(format!("{season}-{identity}"));
    std::fs::create_dir_all(&folder).map_err(|error| error.to_string())?;
    let kept = folder.join("judged.jsonl");
    let mut judged = read_kept(&kept)?;
    let known: BTreeSet<String> = judged.iter().map(|one| one.trial.id.clone()).collect();
    let wanted: Vec<Trial> = trials(request.season)
        .into_iter()
        .filter(|trial| matches(request, trial))
        .filter(|trial| !known.contains(&trial.id))
        .take(request.limit.saturating_sub(known.len()))
        .collect();
    carry_out(request, &wanted, &kept, &mut judged)?;
    // The same table whatever the order in which trials were carried out.
    judged.sort_by(|a, b| a.trial.id.cmp(&b.trial.id));
    let table = table(request.season, &identity, &judged);
    let mut text = serde_json::to_string_pretty(&table).map_err(|error| error.to_string())?;
    text.push('\n');
    let out = request
        .out
        .clone()
        .unwrap_or_else(|| folder.join("table.json"));
    std::fs::write(&out, &text).map_err(|error| format!("{}: {error}", out.display()))?;
    summary(&table);
    eprintln!("table: {}", out.display());
    Ok(())
}

fn carry_out(
    request: &Request,
    wanted: &[Trial],
    kept: &Path,
    judged: &mut Vec<Judged>,
) -> Result<(), String> {
    let mut file = OpenOptions::new()
        .create(true)
        .append(true)
        .open(kept)
        .map_err(|error| format!("{}: {error}", kept.display()))?;
    let bar = ProgressBar::new(wanted.len() as u64);
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {pos}/{len} {eta} {msg}") {
        bar.set_style(style);
    }
    let workshop = Workshop::default();
    let begun = Instant::now();
    let enough = || begun.elapsed().as_secs_f64() > 60.0 * request.minutes;
    let stopped = side_by_side(
        wanted,
        |trial| workshop.carry_out(trial, !request.gain),
        enough,
        |place, outcome| {
            bar.inc(1);
            match outcome {
                Ok((one, answer)) => {
                    keep(kept, &mut file, &one, &answer)?;
                    bar.suspend(|| say(&one));
                    judged.push(one);
                }
                Err(error) => bar.suspend(|| eprintln!("{}: {error}", wanted[place].id)),
            }
            Ok(())
        },
    );
    let left = bar.position() < wanted.len() as u64;
    bar.finish_and_clear();
    if stopped.is_ok() && left {
        eprintln!("time is up; the next call goes on from here");
    }
    stopped
}

/// Keeps a judgement, one line each.
fn keep(
    kept: &Path,
    file: &mut File,
    one: &Judged,
    answer: &serde_json::Value,
) -> Result<(), String> {
    keep_answer(kept, one, answer)?;
    let line = serde_json::to_string(one).map_err(|error| error.to_string())?;
    writeln!(file, "{line}").map_err(|error| error.to_string())
}

/// Says how a trial was judged; nothing where the law absorbs what was planted.
fn say(one: &Judged) {
    if let Some(judgement) = &one.judgement {
        let (id, forced) = (&one.trial.id, one.forced.join("|"));
        println!(
            "{:?} {id} -> {} {:?} (forced {forced}, distance {:.1})",
            judgement.verdict, judgement.status, judgement.named, one.distance
        );
    }
}

/// Keeps answers that were not right, for whoever wants to know why.
fn keep_answer(kept: &Path, one: &Judged, answer: &serde_json::Value) -> Result<(), String> {
    let right = one
        .judgement
        .as_ref()
        .is_none_or(|judgement| judgement.verdict == Verdict::Right);
    let Some(folder) = kept.parent().filter(|_| !right) else {
        return Ok(());
    };
    let folder = folder.join("answers");
    std::fs::create_dir_all(&folder).map_err(|error| error.to_string())?;
    let text = serde_json::to_string_pretty(answer).map_err(|error| error.to_string())?;
    std::fs::write(folder.join(format!("{}.json", one.trial.case.seed)), text)
        .map_err(|error| error.to_string())
}

fn matches(request: &Request, trial: &Trial) -> bool {
    request
        .only
        .as_ref()
        .is_none_or(|text| format!("{:?} {}", trial.group, trial.id).contains(text))
}

/// Writes packages, the keys apart from them.
fn export(request: &Request, folder: &Path) -> Result<(), String> {
    let workshop = Workshop::default();
    let chosen = trials(request.season)
        .into_iter()
        .filter(|trial| matches(request, trial))
        .take(request.limit);
    for trial in chosen {
        let Some(sized) = workshop.sized(&trial)? else {
            eprintln!("{}: absorbed by the law", trial.id);
            continue;
        };
        let outcome = sized.case.carry_out()?;
        let name = sized.case.seed.to_string();
        planting::package::write(&folder.join(&name), &outcome.files)
            .map_err(|error| error.to_string())?;
        let key = serde_json::to_string_pretty(&(&sized, &outcome.key))
            .map_err(|error| error.to_string())?;
        std::fs::write(folder.join(format!("{name}.key.json")), key)
            .map_err(|error| error.to_string())?;
        println!("{name}: {}", sized.id);
    }
    Ok(())
}

/// Trials judged before; a line cut off by an interruption is dropped.
fn read_kept(path: &Path) -> Result<Vec<Judged>, String> {
    let Ok(file) = File::open(path) else {
        return Ok(Vec::new());
    };
    let mut judged = Vec::new();
    for line in BufReader::new(file).lines() {
        let line = line.map_err(|error| error.to_string())?;
        if let Ok(one) = serde_json::from_str(&line) {
            judged.push(one);
        }
    }
    Ok(judged)
}

fn summary(table: &serde_json::Value) {
    println!("trials: {}", table["cases"]);
    println!("nothing planted, named: {}", table["nothing"]["named"]);
    for row in table["nothing"]["by_noise"]
        .as_array()
        .into_iter()
        .flatten()
    {
        println!(
            "  {}: named {}, unexplained {}",
            row["noise"], row["named"], row["unexplained"]
        );
    }
    for row in table["power"].as_array().into_iter().flatten() {
        println!(
            "ratio {}: detected {}, exact set {}, truth in set {}, wrong name {}, of {}",
            row["ratio"],
            row["detected"],
            row["exact_set"],
            row["truth_in_set"],
            row["wrong_name"],
            row["detected"]["cases"]
        );
    }
    for group in [
        "second_shapes",
        "other_laws",
        "pairs",
        "triples",
        "aliens",
        "control",
    ] {
        println!("{group}: {}", table[group]);
    }
    println!("places of aliens: {}", table["alien_places"]);
    println!("coverage: {}", table["coverage"]["of_95"]);
    println!("gain: {}", table["gain"]);
}

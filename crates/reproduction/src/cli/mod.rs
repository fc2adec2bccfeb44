//! The command line.

mod bench;
mod claim;
mod coverage;
mod diagnose;
mod files;
mod identify;
mod inputs;
mod left;
mod merge;
mod output;
mod packages;
mod plan;
mod reproduce;
mod root;
mod run_task;
mod simulate;
mod sweep;
mod twice;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};

/// How a command ended: the exit codes of the contract.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// 0: done, whatever was found.
    Done,
    /// 1: verdicts or values on shipped data are not the pinned ones, or two runs differ.
    Disagrees,
}

/// Why a command gave up.
#[derive(Debug)]
pub enum Failure {
    /// 2: bad input or usage.
    Input(String),
    /// 3: no result could be written.
    Output(String),
}

impl Failure {
    /// Bad input, in the words of the error.
    pub(crate) fn input(error: impl std::fmt::Display) -> Self {
        Self::Input(error.to_string())
    }

    /// No result, in the words of the error.
    pub(crate) fn output(error: impl std::fmt::Display) -> Self {
        Self::Output(error.to_string())
    }
}

/// Audits a paper on the friction of steel brushes, and says what a friction simulation gets wrong and why.
#[derive(Debug, Parser)]
#[command(
    name = "cargo xtask",
    bin_name = "cargo xtask",
    version,
    propagate_version = true
)]
#[command(
    after_help = "stand-ins [--check]  regenerates the stand-in campaigns, or checks that they are what the recipe makes\n\nExit codes: 0 done; 1 verdicts or values on shipped data are not the pinned ones, or two runs (--twice, --like) differ; 2 bad input or usage; 3 no result could be written."
)]
struct Cli {
    /// Threads to compute with; any number gives the same bytes.
    #[arg(long, global = true, value_name = "N")]
    threads: Option<std::num::NonZeroUsize>,
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Runs all stages, the audit and the diagnosis; writes the report, the results, tables and figures.
    Reproduce(ReproduceArguments),
    /// Runs only what one claim needs; prints its verdict, evidence and cost. With --budget, the claims that say most.
    Claim(ClaimArguments),
    /// Prints the stages as tasks for several machines, with needs, keys and costs, as JSON: a matrix of GitHub Actions.
    Plan(PlanArguments),
    /// Computes stages and what they need, and leaves their outputs in a folder for `merge`.
    RunTask(RunTaskArguments),
    /// Makes the report from the outputs of several machines; refuses what does not fit.
    Merge(MergeArguments),
    /// Identifies the parameters of a law from a campaign.
    Identify(IdentifyArguments),
    /// Says what the simulation gets wrong in a campaign, why, and what an extended model gains.
    Diagnose(DiagnoseArguments),
    /// Writes the campaign as a model predicts it.
    Simulate(SimulateArguments),
    /// Makes a package from plain CSV files.
    Init(InitArguments),
    /// Checks a campaign.
    Check(CheckArguments),
    /// Runs the benchmarks.
    Bench(BenchArguments),
}

/// What results are made from, besides the printed numbers.
#[derive(Clone, Debug, Args)]
struct Basis {
    /// Folder whose subfolders replace the stand-ins of the same name.
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
    /// An extended model to use beside the paper's.
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// Fewer starts and repetitions: for a look, not for the record.
    #[arg(long)]
    quick: bool,
}

#[derive(Debug, Args)]
struct ReproduceArguments {
    /// Folder for the report, the results, tables and figures.
    #[arg(long, value_name = "DIR", default_value = "target/reproduction")]
    out: PathBuf,
    /// Runs this stage and what it needs; may be given several times.
    #[arg(long, value_name = "NAME")]
    stage: Vec<String>,
    #[command(flatten)]
    basis: Basis,
    /// Computes everything in two processes, with one thread and with all, and compares what they leave byte for byte.
    #[arg(long)]
    twice: bool,
    /// An earlier report to compare with.
    #[arg(long, value_name = "OLD.html")]
    against: Option<PathBuf>,
}

#[derive(Debug, Args)]
#[command(
    after_help = "Prints {\"include\": [...]}, one entry for each task in the order of the report. Without --shards an entry has `stage`, `title`, `needs`, `key` and `seconds`; with it `shard`, `stages` (words for run-task) and `seconds`. Nothing is computed. Seconds are those of the machine that measured data/costs.json."
)]
struct PlanArguments {
    /// Plans this stage and what it needs; may be given several times.
    #[arg(long, value_name = "NAME")]
    stage: Vec<String>,
    #[command(flatten)]
    basis: Basis,
    /// Packs the tasks into at most N bundles of like cost; no bundle needs another one's output.
    #[arg(long, value_name = "N")]
    shards: Option<std::num::NonZeroUsize>,
}

#[derive(Debug, Args)]
#[command(
    after_help = "What the folder holds already is not computed again, so a task whose needs another machine computed takes their files from there. The program is part of every key: build once and copy the executable (target/release/bristle), or build the same commit in the same folder with the same compiler."
)]
struct RunTaskArguments {
    /// Stages of the plan.
    #[arg(required = true, value_name = "STAGE")]
    stages: Vec<String>,
    /// Folder for the outputs, one file a stage; it can be copied anywhere.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    #[command(flatten)]
    basis: Basis,
}

#[derive(Debug, Args)]
#[command(
    after_help = "Refused (exit code 2): an output that is damaged or altered, that was made by another program or from other inputs, one that is missing, and two outputs of one stage that are not equal byte for byte (the first difference is named)."
)]
struct MergeArguments {
    /// Folders that `run-task` filled.
    #[arg(required = true, value_name = "DIR")]
    folders: Vec<PathBuf>,
    /// Folder for the report, the results, tables and figures.
    #[arg(long, value_name = "DIR", default_value = "target/reproduction")]
    out: PathBuf,
    /// Merges this stage and what it needs; may be given several times.
    #[arg(long, value_name = "NAME")]
    stage: Vec<String>,
    #[command(flatten)]
    basis: Basis,
    /// What one process left (`reproduce --out DIR` with the same options): says whether the merged bytes are the same, and
    /// ends with code 1 where they are not.
    #[arg(long, value_name = "DIR")]
    like: Option<PathBuf>,
}

#[derive(Debug, Args)]
struct ClaimArguments {
    /// The claim, C01 to C22.
    #[arg(required_unless_present = "budget", conflicts_with = "budget")]
    id: Option<String>,
    /// Plans and runs the claims that say most within this time: 90s, 10min, 1h.
    #[arg(long, value_name = "TIME")]
    budget: Option<String>,
    /// Folder that keeps the outputs of stages.
    #[arg(long, value_name = "DIR", default_value = "target/reproduction")]
    out: PathBuf,
}

#[derive(Debug, Args)]
struct IdentifyArguments {
    /// The campaign.
    package: PathBuf,
    /// The law; default asymmetric-bristle where the specimen has a layout, else lugre.
    #[arg(long)]
    law: Option<String>,
    /// Writes the answer as JSON.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Writes a report.
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Writes the model with its covariance.
    #[arg(long, value_name = "FILE")]
    model_out: Option<PathBuf>,
}

#[derive(Debug, Args)]
struct DiagnoseArguments {
    /// The campaign.
    package: PathBuf,
    /// Says what the protocol could and could not tell apart; the forces are not read.
    #[arg(long)]
    design: bool,
    /// The law; default asymmetric-bristle where the specimen has a layout, else lugre.
    #[arg(long)]
    law: Option<String>,
    /// A model to validate: its parameters stay as they are.
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// Writes the answer as JSON.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Writes a report.
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Writes the extended model.
    #[arg(long, value_name = "FILE")]
    extension: Option<PathBuf>,
}

#[derive(Debug, Args)]
struct SimulateArguments {
    /// The campaign whose motions are used.
    package: PathBuf,
    /// The model.
    #[arg(long, value_name = "FILE")]
    model: PathBuf,
    /// Folder for the predicted campaign.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

#[derive(Debug, Args)]
struct InitArguments {
    /// Folder for the package.
    folder: PathBuf,
    /// Plain CSV files, one run each, in their order.
    #[arg(required = true, value_name = "CSV")]
    files: Vec<PathBuf>,
}

#[derive(Debug, Args)]
struct CheckArguments {
    /// The campaign.
    package: PathBuf,
}

#[derive(Debug, Args)]
struct BenchArguments {
    /// ramp, identification, coverage or hidden-effects; the first two without a name.
    name: Option<String>,
    /// Simulated campaigns of `coverage`.
    #[arg(long, value_name = "N", default_value_t = 2000)]
    count: usize,
    /// Seed of `coverage`.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// Parses the command line, runs the command, and says how it ended.
#[must_use]
pub fn main() -> ExitCode {
    let cli = Cli::parse();
    if let Some(threads) = cli.threads
        && let Err(error) = rayon::ThreadPoolBuilder::new()
            .num_threads(threads.get())
            .build_global()
    {
        say_aside!("error: {error}");
        return ExitCode::from(3);
    }
    let outcome = match cli.command {
        Command::Reproduce(arguments) => reproduce::run(&arguments),
        Command::Claim(arguments) => claim::run(&arguments),
        Command::Plan(arguments) => plan::run(&arguments),
        Command::RunTask(arguments) => run_task::run(&arguments),
        Command::Merge(arguments) => merge::run(&arguments),
        Command::Check(arguments) => packages::check(&arguments),
        Command::Init(arguments) => packages::init(&arguments),
        Command::Identify(arguments) => identify::run(&arguments),
        Command::Diagnose(arguments) => diagnose::run(&arguments),
        Command::Simulate(arguments) => simulate::run(&arguments),
        Command::Bench(arguments) => bench::run(&arguments),
    };
    match outcome {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::Disagrees) => ExitCode::from(1),
        Err(Failure::Input(message)) => {
            say_aside!("error: {message}");
            ExitCode::from(2)
        }
        Err(Failure::Output(message)) => {
            say_aside!("error: {message}");
            ExitCode::from(3)
        }
    }
}

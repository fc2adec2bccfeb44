//! The reviewer's checklist, filled in from this run: the questions of the ACM badges, of the SOSP and EuroSys artefact
//! committees, and of a CODECHECK certificate, in our words.

use report::{Answer, CheckItem, NegativeControl, Verdict};

use super::{Surroundings, counts};
use crate::flips::flips;
use crate::results::Results;

/// All questions; links aim at parts of the page that are there in every run.
pub(super) fn items(results: &Results, around: &Surroundings) -> Vec<CheckItem> {
    let asked = [
        available(around),
        (
            "ACM: functional",
            "Is it documented what the artefact is and how it is run?",
            Answer::Yes,
            "README.md names the one command of this page, `docs/architecture.md` the rooms, [Reconstruction choices](#choices) what had to be filled in.".to_owned(),
        ),
        complete(around),
        exercised(results),
        (
            "EuroSys: functional",
            "Does every claim name its command and the resources that it needs?",
            Answer::Yes,
            "Each row of the [ledger](#ledger) ends with both; `cargo xtask claim --budget 10min` runs those that say most within a time. No accelerator and no network are needed; memory was not measured.".to_owned(),
        ),
        consistent(around),
        matched(results),
        tolerances(results),
        red(&around.controls),
        again(around),
        (
            "SOSP: functional",
            "Does it survive forgotten arguments, a second run and an interrupted one?",
            Answer::Yes,
            "Unknown names are refused with the nearest right one, files appear under their names only when they are whole, and stages are kept by the content of their inputs. `cargo test` drives the program so.".to_owned(),
        ),
        (
            "CODECHECK",
            "Is there a manifest of the outputs?",
            Answer::Yes,
            "`codecheck.yml` beside the page lists them; `ro-crate-metadata.json` and `statement.json` say the same to programs, with hashes. Inputs and their hashes: [Inputs](#inputs).".to_owned(),
        ),
        (
            "CODECHECK",
            "Did somebody else run it, and do the outputs match?",
            Answer::Yours,
            "Compare the identity of the results at the top with that of your own run, or give `--against` this page. On another platform the last digits may differ; a chapter on what changed then stands after the deviations.".to_owned(),
        ),
        (
            "Reviewer",
            "Is the commit the one that is under review, without local changes?",
            Answer::Yours,
            "[Facts of this run](#run) name the commit and say whether the working copy had changes.".to_owned(),
        ),
        (
            "Reviewer",
            "Are verdicts, tolerances and their reasons those that you would have chosen?",
            Answer::Yours,
            "Read the [deviations](#deviations) first, then [How this report could be wrong](#doubts).".to_owned(),
        ),
    ];
    asked
        .into_iter()
        .enumerate()
        .map(|(k, (source, question, answer, evidence))| CheckItem {
            id: format!("R{:02}", k + 1),
            source: source.to_owned(),
            question: question.to_owned(),
            answer,
            evidence: evidence.into(),
        })
        .collect()
}

type Asked = (&'static str, &'static str, Answer, String);

fn available(around: &Surroundings) -> Asked {
    let question = "Is the artefact archived in public under a lasting identifier?";
    let (answer, words) = match &around.repository {
        Some(address) => (
            Answer::Partly,
            format!(
                "Its repository is {}; no archive with an identifier of its own is recorded.",
                report::literal(address)
            ),
        ),
        None => (
            Answer::No,
            "This run knows no public address of its repository, and no archive is recorded."
                .to_owned(),
        ),
    };
    ("ACM: available", question, answer, words)
}

fn complete(around: &Surroundings) -> Asked {
    let all = around.campaigns.len();
    let synthetic = around
        .campaigns
        .iter()
        .filter(|(_, kind)| *kind == "synthetic")
        .count();
    let answer = if synthetic == 0 && all > 0 {
        Answer::Yes
    } else {
        Answer::Partly
    };
    let words = format!(
        "Program, printed numbers and recipes are all here. Of {all} campaigns {synthetic} are synthetic stand-ins: [What is synthetic, unpublished or left out](#limits)."
    );
    (
        "ACM: functional",
        "Is everything there that the results were made from?",
        answer,
        words,
    )
}

fn exercised(results: &Results) -> Asked {
    let all = results.stages.len();
    let done = results
        .stages
        .iter()
        .filter(|stage| stage.status() == "done")
        .count();
    let answer = if done == all {
        Answer::Yes
    } else {
        Answer::Partly
    };
    let words = format!("{done} of {all} stages of this run are done: [Stages](#stages).");
    ("ACM: functional", "Does it run to its end?", answer, words)
}

fn consistent(around: &Surroundings) -> Asked {
    let (missing, printed) = (around.numbers.unledgered.len(), around.numbers.printed);
    let answer = if missing == 0 {
        Answer::Yes
    } else {
        Answer::Partly
    };
    let words = format!(
        "{missing} of {printed} printed numbers have no place in the ledger: [Every printed number](#completeness). Each claim names its place in the paper."
    );
    (
        "ACM: functional",
        "Is it about the claims of the paper, all of them?",
        answer,
        words,
    )
}

fn matched(results: &Results) -> Asked {
    let counts = counts(results);
    let of = |wanted: Verdict| {
        counts
            .iter()
            .find(|(verdict, _)| *verdict == wanted)
            .map_or(0, |(_, count)| *count)
    };
    let (reproduced, all) = (of(Verdict::Reproduced), results.claims.len());
    let answer = match reproduced {
        0 => Answer::No,
        some if some == all => Answer::Yes,
        _ => Answer::Partly,
    };
    let words: Vec<String> = counts
        .iter()
        .map(|(verdict, count)| format!("{count} {}", verdict.word()))
        .collect();
    let words = format!(
        "{}. Why not more: [Deviations](#deviations).",
        words.join(", ")
    );
    (
        "ACM: results reproduced",
        "Do the results agree with the paper?",
        answer,
        words,
    )
}

/// Claims whose verdict half or twice the tolerance would turn.
fn tolerances(results: &Results) -> Asked {
    let near: Vec<&str> = results
        .claims
        .iter()
        .filter(|(claim, judged)| {
            let found = flips(claim, &judged.checks);
            found.below.is_some_and(|(factor, _)| factor > 0.5)
                || found.above.is_some_and(|(factor, _)| factor < 2.0)
        })
        .map(|(claim, _)| claim.id.as_str())
        .collect();
    let links: Vec<String> = near.iter().map(|id| format!("[{id}](#{id})")).collect();
    let words = if near.is_empty() {
        "Every tolerance stands with its reason; half or twice of it would turn no verdict."
            .to_owned()
    } else {
        format!(
            "Every tolerance stands with its reason and the factor that would turn the verdict. Half or twice the tolerance would turn {}.",
            links.join(", ")
        )
    };
    let answer = if near.is_empty() {
        Answer::Yes
    } else {
        Answer::Partly
    };
    (
        "SOSP: reproduced",
        "Are the criteria stated, and do the verdicts stand apart from them?",
        answer,
        words,
    )
}

fn red(controls: &[NegativeControl]) -> Asked {
    let passed = controls.iter().filter(|control| control.passed()).count();
    let answer = if passed == controls.len() && passed > 0 {
        Answer::Yes
    } else {
        Answer::No
    };
    let words = format!(
        "{passed} of {} deliberate damages turned exactly the claims that they must: [Negative controls](#controls).",
        controls.len()
    );
    ("Reviewer", "Can the check fail?", answer, words)
}

fn again(around: &Surroundings) -> Asked {
    let question = "Do two runs give the same bytes?";
    let (answer, words) = match &around.twice {
        None => (
            Answer::Yours,
            "Not tried in this run; `cargo xtask reproduce --twice` computes everything in two processes: [Same bytes twice?](#bit-identity)".to_owned(),
        ),
        Some(twice) => (
            if twice.same() { Answer::Yes } else { Answer::No },
            format!("{}: [Same bytes twice?](#bit-identity)", report::literal(&twice.words())),
        ),
    };
    ("SOSP: functional", question, answer, words)
}

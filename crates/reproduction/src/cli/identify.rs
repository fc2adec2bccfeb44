//! `identify`: the parameters of a law from a campaign, what cannot be identified, and an honest word about the fit.

use campaign::Campaign;
use identification::{Estimate, Identification, LawFit, Question, compare_laws, identify};
use report::{Block, Cell, Column, NoticeKind, Section, Table, literal};
use serde_json::json;

use super::{Failure, IdentifyArguments, Outcome, files};
use crate::campaign_page::{document, fit_figure, force_unit, residual_figure};
use crate::provenance;
use crate::results::significant;

pub(super) fn run(arguments: &IdentifyArguments) -> Result<Outcome, Failure> {
    let campaign = campaign::open(&arguments.package).map_err(Failure::input)?;
    let law = files::law(arguments.law.as_deref(), &campaign)?;
    say_aside!("identifying {} from {} runs", law.id(), campaign.runs.len());
    let found = identify(&campaign, &Question::of(law)).map_err(Failure::input)?;
    say_aside!("fitting the other laws");
    let laws = compare_laws(&campaign, &found);
    let word = word(&campaign, &found, &laws);
    print(&found, &word);
    let answer = answer(&found, &laws, &word);
    files::json(arguments.json.as_deref(), &answer)?;
    files::json(
        arguments.model_out.as_deref(),
        &model_file(&campaign, &found),
    )?;
    let run = provenance::run(&super::root::root()?);
    files::page(arguments.report.as_deref(), || {
        let lead = literal(&word.join(" "));
        let command = format!("cargo xtask identify PACKAGE --law {}", found.law.id());
        let section = section(&campaign, &found, &laws, &word);
        document(
            &campaign,
            "Parameters",
            lead,
            &command,
            run,
            vec![section],
            answer.clone(),
        )
    })?;
    Ok(Outcome::Done)
}

/// The interval as two numbers; `None` where an end is open.
fn ci95(estimate: &Estimate) -> Option<[f64; 2]> {
    let interval = estimate.interval.as_ref()?;
    let ends = [interval.low(), interval.high()];
    ends.iter().all(|end| end.is_finite()).then_some(ends)
}

/// What a reader should know before using the numbers, a sentence each.
fn word(campaign: &Campaign, found: &Identification, laws: &[LawFit]) -> Vec<String> {
    let mut word = Vec::new();
    let unit = if campaign
        .runs
        .iter()
        .any(|run| run.normal_load_n.is_some() || run.normal_force_n.is_some())
    {
        "of the coefficient"
    } else {
        force_unit(campaign)
    };
    let quality = &found.quality;
    word.push(format!(
        "The fit is {}; its residual is {} {unit}, {} % of the record's size.",
        found.status.id(),
        significant(quality.rmse),
        significant(100.0 * quality.rmse / quality.rms)
    ));
    match quality.floor_rmse {
        Some(floor) => word.push(format!("Repeats scatter by {} {unit}.", significant(floor))),
        None => word.push("There are no repeats, so what the law leaves cannot be told from what would not repeat.".to_owned()),
    }
    if found.weighting == identification::Weighting::Plain {
        word.push("The law misses the record by far more than its noise: its parameters are those of plain least squares, its intervals widened by the correlation of what is left.".to_owned());
    }
    if let Some(test) = &quality.lack_of_fit {
        word.push(if test.rejects() {
            format!("The law does not say everything: structure is left in the residual (p = {:.1e}). Its intervals are then too narrow; `diagnose` says where it sits.", test.p_value)
        } else {
            "No structure is left that the noise would not explain.".to_owned()
        });
    }
    let open = found.not_identifiable();
    if !open.is_empty() {
        word.push(format!(
            "Not identifiable from these data: {}.",
            open.join(", ")
        ));
    }
    let bound = found.at_bound();
    if !bound.is_empty() {
        word.push(format!("On a bound: {}.", bound.join(", ")));
    }
    word.extend(levels_beyond_the_record(campaign, found));
    if found.better_found {
        word.push(
            "A profile met a better point than the fit: the answer is not the minimum.".to_owned(),
        );
    }
    let better: Vec<&str> = ranked(laws)
        .into_iter()
        .take_while(|(law, _)| law.law != found.law)
        .map(|(law, _)| law.law.id())
        .collect();
    word.push(if better.is_empty() {
        "No other law fits better (AICc).".to_owned()
    } else {
        format!("Laws that fit better (AICc): {}.", better.join(", "))
    });
    word
}

/// Levels of friction that the record never reaches: there the fit bends its curve with them, and they are no friction
/// that was measured.
fn levels_beyond_the_record(campaign: &Campaign, found: &Identification) -> Vec<String> {
    /// A level this many times the largest recorded friction is no reading of it.
    const BEYOND: f64 = 1.5;
    let largest = campaign
        .runs
        .iter()
        .flat_map(|run| {
            let load = |i: usize| match (&run.normal_force_n, run.normal_load_n) {
                (Some(column), _) => column[i],
                (None, Some(load)) => load,
                (None, None) => 1.0,
            };
            run.force_n
                .iter()
                .enumerate()
                .filter(move |(i, _)| load(*i) > 0.0)
                .map(move |(i, force)| (force / load(i)).abs())
        })
        .fold(0.0, f64::max);
    found
        .estimates
        .iter()
        .filter(|e| ["mu_c", "mu_s"].contains(&e.name.as_str()) && e.value > BEYOND * largest)
        .map(|e| {
            format!(
                "{} is {} times the largest recorded friction: the fit bends its curve with it where the record is not sliding; it is no level that was measured.",
                e.name,
                significant(e.value / largest)
            )
        })
        .collect()
}

/// Laws that were fitted, best first, with AICc less that of the best.
fn ranked(laws: &[LawFit]) -> Vec<(&LawFit, f64)> {
    let mut fitted: Vec<(&LawFit, f64)> = laws
        .iter()
        .filter_map(|law| Some((law, law.identification.as_ref().ok()?.aicc)))
        .filter(|(_, aicc)| aicc.is_finite())
        .collect();
    fitted.sort_by(|(_, one), (_, other)| one.total_cmp(other));
    let best = fitted.first().map_or(0.0, |(_, aicc)| *aicc);
    fitted
        .into_iter()
        .map(|(law, aicc)| (law, aicc - best))
        .collect()
}

fn print(found: &Identification, word: &[String]) {
    say!("{}: law {}", found.campaign, found.law.id());
    for estimate in &found.estimates {
        let interval = ci95(estimate).map_or_else(
            || "no interval".to_owned(),
            |[low, high]| format!("95 % [{}, {}]", significant(low), significant(high)),
        );
        let note = if estimate.held {
            "held"
        } else {
            estimate.verdict.id()
        };
        say!(
            "  {:24} {:>12} {:10} {interval}  {note}",
            estimate.name,
            significant(estimate.value),
            estimate.unit
        );
    }
    for sentence in word {
        say!("{sentence}");
    }
}

/// The answer as JSON.
fn answer(found: &Identification, laws: &[LawFit], word: &[String]) -> serde_json::Value {
    let parameters: Vec<_> = found
        .estimates
        .iter()
        .map(|estimate| {
            json!({"name": estimate.name, "value": estimate.value, "unit": estimate.unit, "sd": estimate.sd,
                "ci95": ci95(estimate), "held": estimate.held, "at_bound": estimate.at_bound.is_some(),
                "identifiable": estimate.verdict.id()})
        })
        .collect();
    let laws: Vec<_> = ranked(laws)
        .into_iter()
        .map(|(law, delta)| {
            let rmse = law.identification.as_ref().ok().map(|found| found.quality.rmse);
            let held_out = law.held_out.as_ref().map(|held| held.rmse);
            json!({"law": law.law.id(), "delta_aicc": delta, "rmse": rmse, "held_out_rmse": held_out,
                "directional": law.directional})
        })
        .collect();
    let sizes = &found.noise.sizes;
    json!({
        "schema": "bristle/identification/1",
        "campaign": found.campaign,
        "law": found.law.id(),
        "status": found.status.id(),
        "parameters": parameters,
        "not_identifiable": found.not_identifiable(),
        "rmse": found.quality.rmse,
        "floor_rmse": found.quality.floor_rmse,
        "lack_of_fit_p": found.quality.lack_of_fit.as_ref().map(|test| test.p_value),
        "noise": {"sensor": sizes.sensor, "roughness_private": sizes.private, "roughness_plate": sizes.plate,
            "correlation_length": sizes.length, "smoothing": sizes.smoothing, "plate_ratio": sizes.plate_ratio, "plate_smoothing": sizes.plate_smoothing, "scatter": sizes.scatter},
        "log_likelihood": found.log_likelihood,
        "aicc": found.aicc,
        "laws": laws,
        "word": word,
    })
}

/// The model with its covariance and the speeds that the data covered.
fn model_file(campaign: &Campaign, found: &Identification) -> rig::ModelFile {
    let values: Vec<f64> = found
        .estimates
        .iter()
        .take(found.law.parameters().len())
        .map(|e| e.value)
        .collect();
    let mut file = rig::ModelFile::new(found.law, &values, None);
    for (entry, estimate) in file.parameters.iter_mut().zip(&found.estimates) {
        entry.sd = estimate.sd;
        entry.unit.clone_from(&estimate.unit);
    }
    file.covariance = found.covariance.as_ref().map(|covariance| {
        (0..values.len())
            .map(|i| (0..values.len()).map(|j| covariance[(i, j)]).collect())
            .collect()
    });
    let speeds = || {
        campaign
            .runs
            .iter()
            .flat_map(|run| &run.velocity_m_s)
            .map(|v| v.abs())
    };
    file.valid_speed_m_s = Some([
        speeds().fold(f64::INFINITY, f64::min),
        speeds().fold(0.0, f64::max),
    ]);
    file
}

/// The one section of the report.
fn section(
    campaign: &Campaign,
    found: &Identification,
    laws: &[LawFit],
    word: &[String],
) -> Section {
    let evidence = Some(crate::evidence_of(campaign.provenance));
    let number = |estimate: &Estimate| match ci95(estimate) {
        Some(ends) => Cell::Interval(estimate.value, ends),
        None => Cell::Number(estimate.value),
    };
    let parameters = Table {
        id: "parameters".into(),
        title: format!("Parameters of {}", found.law.id()),
        caption: "Values with 95 % intervals by profile likelihood.".into(),
        columns: vec![
            Column::text("parameter"),
            Column::number("value", ""),
            Column::text("unit"),
            Column::text("what the data say"),
            Column::text("meaning"),
        ],
        rows: found
            .estimates
            .iter()
            .map(|e| {
                vec![
                    e.name.as_str().into(),
                    number(e),
                    e.unit.as_str().into(),
                    e.verdict.id().into(),
                    e.doc.as_str().into(),
                ]
            })
            .collect(),
        evidence,
        ..Table::default()
    };
    let others = Table {
        id: "laws".into(),
        title: "All laws on the same data".into(),
        caption: "AICc less that of the best law; smaller is better. The error on held-out runs needs repeats.".into(),
        columns: vec![
            Column::text("law"),
            Column::number("AICc less the best", "1"),
            Column::number("residual", ""),
            Column::number("held-out error", ""),
        ],
        rows: ranked(laws)
            .into_iter()
            .map(|(law, delta)| {
                let rmse = law.identification.as_ref().map_or(f64::NAN, |found| found.quality.rmse);
                let held = law.held_out.as_ref().map_or_else(|| Cell::Missing("no repeats".into()), |held| held.rmse.into());
                vec![law.law.id().into(), delta.into(), rmse.into(), held]
            })
            .collect(),
        evidence,
        ..Table::default()
    };
    let honest = Block::notice(
        NoticeKind::Caution,
        "An honest word about the fit",
        literal(&word.join(" ")),
    );
    Section {
        id: "identification".into(),
        title: "Identification".into(),
        lead: literal(&word[0]).into(),
        method: Some("Weighted least squares from several starts; the noise (white sensor noise, roughness correlated along the sliding path, scatter between runs) is estimated from the residual. Intervals by profile likelihood.".into()),
        status: (!found.status.converged()).then(|| found.status.to_string()),
        claims: Vec::new(),
        blocks: vec![
            honest,
            parameters.into(),
            fit_figure(campaign, &found.predicted_n, "fit").into(),
            residual_figure(campaign, &found.predicted_n, "residual").into(),
            others.into(),
        ],
    }
}

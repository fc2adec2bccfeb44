//! The answer put together from what the search found.

use crate::anatomy::anatomy;
use crate::answer::{
    Baseline, Diagnosis, Estimate, Evidence, Finding, Hidden, LawFit, Place, Rival, Share, Status,
    Unexplained,
};
use crate::bench::Bench;
use crate::equivalence::Contest;
use crate::floor;
use crate::integrity::{Integrity, Read};
use crate::intervals::{self, unit_on_rig};
use crate::probability::weight_of_set;
use crate::selection::{ALPHA_GENERAL, ALPHA_NAME, SHAPE_TOLERANCE, Selected, strict};
use crate::steps;
use crate::tail::equivalent_z;
use crate::ways::deviance_of_positions;
use crate::whole::Whole;

/// The answer but for what folds and designed experiments add.
pub(crate) fn assemble(
    whole: &Whole<'_>,
    selected: &Selected,
    contests: &[Contest],
    integrity: &Integrity,
) -> Diagnosis {
    let bench = whole.bench;
    let noise_floor = floor::noise_floor(bench, selected, &whole.extended.prediction, whole.apart);
    let rmse = floor::rmse(bench, &whole.stated.prediction, None);
    let mut findings: Vec<Finding> = contests
        .iter()
        .enumerate()
        .map(|(k, contest)| finding(whole, selected, contest, k))
        .collect();
    // Finding order: what saves most comes first.
    findings.sort_by(|a, b| {
        b.evidence
            .delta_log_likelihood
            .total_cmp(&a.evidence.delta_log_likelihood)
    });
    findings.extend(integrity_findings(bench, integrity));
    let gate = selected.gate_log_p < (ALPHA_NAME + ALPHA_GENERAL).ln();
    // What a named cause's shape may be wrong by is no structure of its own.
    let explained = (selected.baseline.deviance - selected.stand.deviance).max(0.0);
    let beyond_shape = selected.names_nothing()
        || selected
            .left
            .excess
            .max(equivalent_z(selected.left.log_p).powi(2))
            > SHAPE_TOLERANCE.powi(2) * explained;
    let detected = gate && beyond_shape && selected.leaves_something();
    let status = if detected {
        Status::Unexplained
    } else if findings.iter().any(|f| !f.equivalent.is_empty()) {
        Status::Ambiguous
    } else if findings.is_empty() {
        Status::Consistent
    } else {
        Status::Explained
    };
    let explainable = if rmse > noise_floor.rmse && status != Status::Consistent {
        1.0 - (noise_floor.rmse / rmse).powi(2)
    } else {
        0.0
    };
    let residual: Vec<f64> = bench
        .samples
        .force
        .iter()
        .zip(&whole.stated.prediction)
        .zip(&bench.samples.load)
        .map(|((m, p), n)| {
            if bench.samples.loaded && *n > 0.0 {
                (m - p) / n
            } else {
                m - p
            }
        })
        .collect();
    Diagnosis {
        schema: "bristle/diagnosis/1".into(),
        campaign: bench.campaign.name.clone(),
        law: bench.law.id().into(),
        status,
        baseline: Baseline {
            rmse,
            held_out_rmse: None,
            explainable_fraction: explainable,
        },
        anatomy: shares(bench, selected, &residual, noise_floor.rmse),
        noise_floor,
        findings,
        unexplained: Unexplained {
            detected,
            r#where: selected
                .left
                .place
                .clone()
                .filter(|_| detected)
                .map(|place| Place {
                    unit: unit_on_rig(bench, &place.unit),
                    ..place
                }),
            z: equivalent_z(selected.left.log_p),
        },
        undecidable: Vec::new(),
        laws: Vec::<LawFit>::new(),
        hidden: hidden(bench, selected),
        gain: None,
        notes: selected
            .refused
            .iter()
            .cloned()
            .chain(notes(whole))
            .collect(),
    }
}

/// What a reader should not miss.
fn notes(whole: &Whole<'_>) -> Vec<String> {
    let mut notes = Vec::new();
    if whole.bench.prior.is_some() {
        notes.push(
            "errors of the law are those of the given model as it stands; within its covariance its parameters may differ: a cause must stand out beyond that"
                .to_owned(),
        );
    }
    if !whole.law.converged {
        notes.push(
            "the fit of the law alone did not converge: not converged: iteration limit".to_owned(),
        );
    }
    if !whole.extended.converged && !whole.extended.effects.is_empty() {
        notes.push("the fit of the extended model did not converge: iteration limit".to_owned());
    }
    if deviance_of_positions(whole.bench, &whole.extended) < 0.0 {
        notes.push(
            "the stage went further between samples than the recorded speeds tell, as where these are read late: the recorded positions show the filter of the velocity channel"
                .to_owned(),
        );
    }
    let noise = whole.bench.experiment.channel_noise;
    if let Some(load) = noise.load.filter(|load| load.kept < 1.0) {
        notes.push(format!(
            "the recorded load scatters by {:.2e} N about its course, and the friction follows {:.0} % of that: the rest is taken for noise of the load's channel",
            load.sd_n,
            100.0 * load.kept
        ));
    }
    if let Some(sd_m_s) = noise.velocity_m_s {
        notes.push(format!(
            "the recorded velocity scatters by {sd_m_s:.2e} {} about its course: that is taken for noise of its channel",
            unit_on_rig(whole.bench, "m/s")
        ));
    }
    for (spec, value) in whole.law.law_at_bounds() {
        notes.push(format!(
            "with the law alone, {} runs to its bound ({value:.4})",
            spec.name
        ));
    }
    if whole.bench.samples.temperature.is_none() {
        notes.push(
            "no temperature is recorded: its share of the residual cannot be shown".to_owned(),
        );
    }
    notes
}

/// A named cause as it stands in the answer.
fn finding(whole: &Whole<'_>, selected: &Selected, contest: &Contest, k: usize) -> Finding {
    let bench = whole.bench;
    let own = selected.stand.fitted.effects[k];
    let cause = &bench.catalogue[own];
    let mut equivalent: Vec<String> = contest
        .tied()
        .into_iter()
        .map(|cause| bench.catalogue[cause].id().to_owned())
        .collect();
    equivalent.sort();
    equivalent.dedup();
    let mut rivals: Vec<Rival> = contest
        .opponents
        .iter()
        .map(|o| Rival {
            cause: bench.catalogue[o.cause].id().to_owned(),
            delta: if o.excess_deviance.is_finite() {
                -0.5 * o.excess_deviance
            } else {
                -0.5 * o.separation * o.separation
            },
            separation: Some(o.separation),
        })
        .collect();
    rivals.sort_by(|a, b| b.delta.total_cmp(&a.delta).then(a.cause.cmp(&b.cause)));
    rivals.truncate(8);
    let log_p = selected.entry_log_p.get(k).copied().unwrap_or(0.0);
    // Rows of a condensed record are too long for steps to be seen.
    let searched_whole = selected.stand.fitted.prediction.len() == bench.samples.len();
    let stepped = searched_whole
        .then(|| steps::interval(bench, &selected.subset, &selected.stand, k))
        .flatten();
    Finding {
        cause: cause.id().into(),
        station: cause.station().id().into(),
        probability: weight_of_set(bench, contest, own, &equivalent),
        equivalent,
        parameters: intervals::estimates(bench, &selected.stand, &whole.extended, k, stepped),
        gain: None,
        evidence: Evidence {
            delta_log_likelihood: 0.5 * contest.saved,
            z: equivalent_z(log_p),
            rivals,
        },
        experiment: None,
    }
}

/// Shares of the law's residual over the axes, in the rig's own units.
fn shares(bench: &Bench<'_>, selected: &Selected, residual: &[f64], floor: f64) -> Vec<Share> {
    let length = selected.stand.sizes.length;
    let mut shares = anatomy(&bench.samples, residual, floor, length);
    for share in &mut shares {
        share.unit = unit_on_rig(bench, &share.unit);
    }
    shares
}

/// Findings that the numbers themselves show.
fn integrity_findings(bench: &Bench<'_>, integrity: &Integrity) -> Vec<Finding> {
    let rotary = bench.experiment.axis == campaign::Axis::Rotary;
    let unit = if rotary { "N m" } else { "N" };
    [
        ("force-saturation", "level_n", integrity.saturation()),
        ("force-resolution", "step_n", integrity.resolution),
    ]
    .into_iter()
    .filter_map(|(cause, name, value)| {
        let Read { value, half } = value?;
        bench
            .catalogue
            .iter()
            .any(|c| c.id() == cause)
            .then(|| Finding {
                cause: cause.into(),
                station: "sensor".into(),
                equivalent: Vec::new(),
                probability: 0.999,
                parameters: vec![Estimate {
                    name: name.into(),
                    value,
                    ci95: Some([value - half, value + half]),
                    unit: unit.into(),
                }],
                gain: None,
                evidence: Evidence {
                    delta_log_likelihood: 0.0,
                    z: 0.0,
                    rivals: Vec::new(),
                },
                experiment: None,
            })
    })
    .collect()
}

/// How large an effect of each cause could have hidden: the size found with 90 % power.
fn hidden(bench: &Bench<'_>, selected: &Selected) -> Vec<Hidden> {
    let threshold = equivalent_z(strict(&selected.first)) + 1.2816;
    selected
        .first
        .candidates
        .iter()
        .map(|c| {
            let cause = &bench.catalogue[c.cause];
            let first = cause.sizes()[0];
            let spec = &cause.parameters_for(&bench.experiment)[first];
            let sd = c.score.sd.first().copied().unwrap_or(f64::INFINITY);
            Hidden {
                cause: cause.id().into(),
                parameter: spec.name.to_string(),
                size: Some(threshold * sd * c.unit).filter(|s| s.is_finite()),
                unit: intervals::unit_on_rig(bench, &spec.unit),
            }
        })
        .collect()
}

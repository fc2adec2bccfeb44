//! `check` and `init`: packages without stages.

use campaign::{Axis, Campaign};

use super::{CheckArguments, Failure, InitArguments, Outcome};

/// Opens a package and says what is in it and what cannot be told for want of metadata.
pub(super) fn check(arguments: &CheckArguments) -> Result<Outcome, Failure> {
    let campaign = campaign::open(&arguments.package).map_err(Failure::input)?;
    let samples: usize = campaign.runs.iter().map(|run| run.time_s.len()).sum();
    let conditions = campaign.conditions();
    say!(
        "{}: {}",
        campaign.name,
        crate::evidence_of(campaign.provenance).word()
    );
    say!(
        "{} runs, {samples} samples, {} conditions",
        campaign.runs.len(),
        conditions.len()
    );
    for condition in &conditions {
        let first = &campaign.runs[condition[0]];
        let names: Vec<&str> = condition
            .iter()
            .map(|run| campaign.runs[*run].name.as_str())
            .collect();
        let load = first
            .normal_load_n
            .map_or_else(|| "no load".to_owned(), |load| format!("{load} N"));
        say!(
            "  {:?} {:?}, {load}: {}",
            first.direction,
            first.protocol,
            names.join(", ")
        );
    }
    for missing in missing(&campaign) {
        say!("not stated: {missing}");
    }
    Ok(Outcome::Done)
}

/// What is not stated, and what cannot be computed without it.
fn missing(campaign: &Campaign) -> Vec<&'static str> {
    let runs = &campaign.runs;
    let all = |stated: &dyn Fn(&campaign::Run) -> bool| runs.iter().all(stated);
    let facts: [(bool, &'static str); 7] = [
        (
            all(&|run| run.order.is_some() || run.started_s.is_some()),
            "order of the runs: wear, heat and set cannot be told",
        ),
        (
            all(&|run| run.normal_load_n.is_some() || run.normal_force_n.is_some()),
            "normal load: friction is fitted as a force; load causes are undecidable",
        ),
        (
            campaign.conditions().iter().any(|runs| runs.len() > 1),
            "repeats: the noise floor rests on the sensor's stated accuracy",
        ),
        (
            campaign.specimen.contact_height_m.is_some(),
            "specimen.contact_height_mm: bristle laws cannot be used",
        ),
        (
            campaign.specimen.layout.is_some(),
            "specimen.layout: the default law is lugre",
        ),
        (
            campaign.rig.sensor_full_scale_n.is_some() || campaign.axis == Axis::Rotary,
            "rig.sensor_full_scale_n: saturation and accuracy of the sensor",
        ),
        (
            campaign.rig.moving_mass_kg.is_some(),
            "rig.moving_mass_kg: inertia counts as friction",
        ),
    ];
    facts
        .into_iter()
        .filter(|(stated, _)| !stated)
        .map(|(_, words)| words)
        .collect()
}

/// Makes a package from plain files.
pub(super) fn init(arguments: &InitArguments) -> Result<Outcome, Failure> {
    let made = match campaign::init(&arguments.folder, &arguments.files) {
        Ok(made) => made,
        Err(campaign::InitError::Write(error)) => return Err(Failure::output(error)),
        Err(error) => return Err(Failure::input(error)),
    };
    for line in &made.read {
        say!("read      {line}");
    }
    for line in &made.fill_in {
        say!("fill in   {line}");
    }
    for line in &made.optional {
        say!("optional  {line}");
    }
    say!(
        "package   {}",
        arguments.folder.join("datapackage.json").display()
    );
    Ok(Outcome::Done)
}

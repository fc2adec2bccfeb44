//! From a campaign and a question to the bench: the law, the catalogue, what a model file knows, samples that say nothing.

use std::sync::OnceLock;

use campaign::{Campaign, Protocol};
use friction::LawKind;
use rig::{Experiment, ModelFile};

use crate::bench::{Bench, conditions};
use crate::causes;
use crate::diagnose::{DiagnosisError, Options};
use crate::integrity::{Rail, beside_flat_top, inspect};
use crate::prior::Prior;
use crate::samples::Samples;
use crate::ways::Ways;

/// The law that is used where none is asked for.
#[must_use]
pub fn default_law(campaign: &Campaign) -> LawKind {
    if campaign.specimen.layout.is_some() && campaign.specimen.contact_height_m.is_some() {
        LawKind::AsymmetricBristle
    } else {
        LawKind::Lugre
    }
}

/// Prepares the bench of a campaign and a question.
pub(crate) fn bench<'a>(
    campaign: &'a Campaign,
    options: &Options,
) -> Result<Bench<'a>, DiagnosisError> {
    let law = match (&options.model, options.law) {
        (Some(file), asked) => {
            let own = file.law_kind().map_err(DiagnosisError::ModelFile)?;
            if asked.is_some_and(|law| law != own) {
                return Err(DiagnosisError::ModelFile(format!(
                    "it holds law {}, --law asks for another",
                    own.id()
                )));
            }
            own
        }
        (None, Some(law)) => law,
        (None, None) => default_law(campaign),
    };
    let mut experiment = Experiment::new(campaign)?;
    let least_speed = rig::Model::new(law, Vec::new(), &experiment)?.least_speed_m_s();
    let prior = options
        .model
        .as_ref()
        .map(|file| Prior::new(file, law).map_err(DiagnosisError::ModelFile))
        .transpose()?;
    let catalogue = causes::catalogue()
        .into_iter()
        .filter(|c| {
            c.applies_to(law)
                && c.lack(&experiment).is_none()
                && !options.without.iter().any(|id| id == c.id())
        })
        .collect();
    let stated_sensor = match (
        campaign.rig.sensor_full_scale_n,
        campaign.rig.sensor_accuracy_percent_fs,
    ) {
        (Some(full), Some(percent)) => Some(full * percent / 100.0),
        _ => None,
    };
    let numbers = inspect(campaign, 0.0);
    let masked = masked(campaign, &numbers.rails, least_speed);
    let mut samples = Samples::new(campaign);
    samples.least_speed_m_s = least_speed;
    if let Some(file) = &options.model {
        take_extension_off(file, law, &mut experiment, &mut samples)?;
    }
    Ok(Bench {
        campaign,
        samples,
        ways: Ways::of(&experiment),
        may_wander: true,
        redrawn: OnceLock::new(),
        told: options.told,
        experiment,
        law,
        catalogue,
        prior,
        stated_sensor,
        conditions: conditions(campaign),
        masked,
        step_n: numbers.resolution.map(|step| step.value),
    })
}

/// One of the stand-ins that the repository ships.
#[cfg(test)]
pub(crate) fn stand_in(name: &str) -> Campaign {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/campaigns");
    campaign::open(&folder.join(name)).expect("a campaign")
}

/// Samples that say nothing about the law: those that a clipped channel hides or picks out (the flat top is a finding of its own),
/// those at a standstill that a static law does not know, and both ends of a run, where no record tells from what its filters
/// started and how long its stage took to change its acceleration.
fn masked(campaign: &Campaign, rails: &[Rail], least_speed_m_s: f64) -> Vec<bool> {
    let hidden: Vec<Vec<bool>> = rails
        .iter()
        .map(|rail| beside_flat_top(campaign, rail))
        .collect();
    let mut masked = Vec::new();
    for run in &campaign.runs {
        let first = masked.len();
        let last = first + run.force_n.len() - 1;
        masked.extend((first..=last).map(|i| hidden.iter().any(|hidden| hidden[i])));
        // Without contact there is no friction: the reading is all that is asked for.
        if run.protocol != Protocol::Unloaded {
            for (masked, v) in masked[first..].iter_mut().zip(&run.velocity_m_s) {
                *masked |= v.abs() < least_speed_m_s;
            }
        }
        masked[first] = true;
        masked[last] = true;
    }
    masked
}

/// Takes what a model file's extension adds to the law's prediction off the record, so that only what is beyond it is
/// asked for. The law stays within the file's covariance, so the two add up.
fn take_extension_off(
    file: &ModelFile,
    law: LawKind,
    experiment: &mut Experiment,
    samples: &mut Samples,
) -> Result<(), DiagnosisError> {
    let extension = file
        .extension_from(&causes::catalogue())
        .map_err(DiagnosisError::ModelFile)?;
    if extension.is_empty() {
        return Ok(());
    }
    let values = file.law_values().map_err(DiagnosisError::ModelFile)?;
    let plain = rig::Model::new(law, Vec::new(), experiment)?;
    let (effects, own): (Vec<_>, Vec<_>) = extension.into_iter().unzip();
    let extended = rig::Model::new(law, effects, experiment)?;
    let mut p = values.clone();
    p.extend(own.into_iter().flatten());
    p.resize(extended.parameters().len(), 0.0);
    let with = extended.predict(experiment, &p);
    let without = plain.predict(experiment, &plain.at_null(&values, experiment));
    for i in 0..with.len() {
        let added = with[i] - without[i];
        experiment.measured_n[i] -= added;
        samples.force[i] -= added;
    }
    Ok(())
}

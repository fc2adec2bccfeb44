//! `simulate`: the motions of a package with the forces of a model.

use campaign::Provenance;

use super::{Failure, Outcome, SimulateArguments, files};

pub(super) fn run(arguments: &SimulateArguments) -> Result<Outcome, Failure> {
    let mut campaign = campaign::open(&arguments.package).map_err(Failure::input)?;
    let file = files::model(&arguments.model)?;
    let refuse =
        |problem: String| Failure::Input(format!("{}: {problem}", arguments.model.display()));
    let law = file.law_kind().map_err(refuse)?;
    let law_values = file.law_values().map_err(refuse)?;
    let extension = file
        .extension_from(&diagnosis::causes::catalogue())
        .map_err(refuse)?;
    let (effects, fitted): (Vec<_>, Vec<_>) = extension.into_iter().unzip();
    let experiment = rig::Experiment::new(&campaign).map_err(Failure::input)?;
    let model = rig::Model::new(law, effects, &experiment).map_err(Failure::input)?;
    let mut parameters = model.at_null(&law_values, &experiment);
    for (effect, values) in fitted.iter().enumerate() {
        parameters[model.span(effect)].copy_from_slice(values);
    }
    let predicted = model.predict(&experiment, &parameters);
    if let Some(sample) = predicted.iter().position(|force| !force.is_finite()) {
        return Err(Failure::Output(format!(
            "the model's force is not finite at sample {sample}"
        )));
    }
    let mut rest = predicted.as_slice();
    for run in &mut campaign.runs {
        let (force, after) = rest.split_at(run.time_s.len());
        run.force_n.copy_from_slice(force);
        rest = after;
    }
    campaign.provenance = Provenance::Synthetic;
    campaign.title = format!("{} (as the model predicts it, synthetic)", campaign.title);
    campaign::write(&arguments.out, &campaign).map_err(Failure::output)?;
    say!(
        "{} runs, {} samples, law {}",
        campaign.runs.len(),
        predicted.len(),
        law.id()
    );
    for entry in &file.extension {
        say!("extended by {}", entry.cause);
    }
    if let Some([_, fastest]) = file.valid_speed_m_s {
        let top = campaign
            .runs
            .iter()
            .flat_map(|run| &run.velocity_m_s)
            .fold(0.0_f64, |top, v| top.max(v.abs()));
        if top > fastest {
            say!(
                "beyond its data: the model was identified up to {fastest} m/s, the motions go to {top} m/s"
            );
        }
    }
    say!(
        "package   {}",
        arguments.out.join("datapackage.json").display()
    );
    Ok(Outcome::Done)
}

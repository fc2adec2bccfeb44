//! The numbers of the stage for results.json.

use identification::{LawFit, PaperForm};
use report::{Evidence, Value};

use super::Identified;
use crate::stage::{StageContext, StageError};
use crate::stages::friction_curves::{DIRECTIONS, relative_error};

const STAGE: &str = "identification";

fn value(id: String, number: f64, unit: &str, evidence: Evidence) -> Value {
    Value::new(id, number, unit, STAGE, evidence)
}

pub(super) fn all(
    context: &StageContext<'_>,
    materials: &[Identified],
    laws: &[LawFit],
    paper: &PaperForm,
) -> Result<Vec<Value>, StageError> {
    let mut values = Vec::new();
    for one in materials {
        parameters(context, one, &mut values)?;
        quality(one, &mut values);
    }
    let evidence = materials[0].evidence;
    for law in laws {
        let id = |part: &str| format!("identification.laws.{}.{part}", law.law.id());
        if let Some(held) = &law.held_out {
            values.push(value(id("held_out_rmse"), held.rmse, "1", evidence));
        }
        if let Ok(found) = &law.identification {
            values.push(value(id("aicc"), found.aicc, "1", evidence));
            values.push(value(id("rmse"), found.quality.rmse, "1", evidence));
        }
        if let Some(ratio) = law.direction_ratio {
            values.push(value(id("direction_ratio"), ratio, "1", evidence));
        }
    }
    let highest = |points: &[fitting::ProfilePoint]| {
        points.iter().map(|p| p.deviance.abs()).fold(0.0, f64::max)
    };
    let along = paper
        .profiles
        .iter()
        .map(|(_, points)| highest(points))
        .fold(0.0, f64::max);
    let singular = &paper.identifiability.singular_values;
    for (part, number) in [
        ("rank", paper.identifiability.rank as f64),
        ("parameters", singular.len() as f64),
        ("ray_deviance", along),
        ("contrast_deviance", highest(&paper.contrast.1)),
        (
            "singular_ratio",
            singular.last().copied().unwrap_or(f64::NAN) / singular[0],
        ),
    ] {
        values.push(value(
            format!("identification.paper_form.{part}"),
            number,
            "1",
            evidence,
        ));
    }
    Ok(values)
}

/// The printed row of a material and the printed number beside a parameter of ours.
fn printed(
    context: &StageContext<'_>,
    material: &str,
    name: &str,
) -> Result<Option<String>, StageError> {
    let row = if material == "aluminium" {
        "table1".to_owned()
    } else {
        format!("table2.{material}")
    };
    let number = |part: &str| {
        context
            .published
            .number(&format!("{row}.{part}"))
            .map(|p| p.printed.clone())
    };
    Ok(match name {
        "theta_c_over_sigma" => Some(format!("{}/{}", number("theta_c")?, number("sigma")?)),
        "theta_s_over_sigma" => Some(format!("{}/{}", number("theta_s")?, number("sigma")?)),
        "theta0" => None,
        other => Some(number(other)?),
    })
}

fn parameters(
    context: &StageContext<'_>,
    one: &Identified,
    values: &mut Vec<Value>,
) -> Result<(), StageError> {
    for estimate in &one.found.estimates {
        let id = format!("identification.{}.{}", one.material, estimate.name);
        let mut found = value(id, estimate.value, &estimate.unit, one.evidence);
        if let Some(interval) = &estimate.interval {
            found = found.with_ci95(interval.low(), interval.high());
        }
        if let Some(text) = printed(context, one.material, &estimate.name)? {
            found = found.with_published(text);
        }
        values.push(found);
    }
    Ok(())
}

fn quality(one: &Identified, values: &mut Vec<Value>) {
    let mut add = |part: &str, number: f64, unit: &str| {
        let id = format!("identification.{}.{part}", one.material);
        values.push(value(id, number, unit, one.evidence));
    };
    for (direction, word, _) in DIRECTIONS {
        let error = relative_error(
            &one.campaign,
            &one.experiment,
            &one.found.predicted_n,
            direction,
        );
        add(&format!("nrmse_{word}"), error.unwrap_or(f64::NAN), "1");
    }
    let quality = &one.found.quality;
    add("rmse", quality.rmse, "1");
    add("floor_rmse", quality.floor_rmse.unwrap_or(f64::NAN), "1");
    let lack = quality.lack_of_fit.map_or(f64::NAN, |test| test.p_value);
    add("lack_of_fit_p", lack, "1");
    let sizes = &one.found.noise.sizes;
    add("run_scatter", sizes.scatter, "1");
    add("roughness_private", sizes.private, "1");
    add("roughness_plate", sizes.plate, "1");
    add("roughness_length", 1e3 * sizes.length, "mm");
    add("sensor_noise", sizes.sensor, "N");
}

//! What a protocol could tell: thresholds of the test that knows the cause, and how far pairs of causes are apart.
//!
//! Nothing of the recorded forces is read: they are replaced by a nominal friction before anything is computed.

use campaign::{Campaign, InitialState};
use fitting::noise::Sizes;
use nalgebra::DMatrix;
use rayon::prelude::*;

use crate::answer::{Design, Hidden, NoiseFloor};
use crate::bench::{Beside, Fitted};
use crate::diagnose::{DiagnosisError, Options};
use crate::equivalence::{flattened, sine};
use crate::floor;
use crate::intervals::unit_on_rig;
use crate::prepare::bench;
use crate::scan::scan_nominal;
use crate::selection::strict;
use crate::stand::Stand;
use crate::subset::Subset;
use crate::tail::equivalent_z;
use crate::ties;

/// Nominal coefficient of friction where no model says better.
const NOMINAL_FRICTION: f64 = 0.5;
/// Nominal roughness, half of it fixed to the plate, and scatter between runs.
const NOMINAL_ROUGHNESS: f64 = 0.008;
const NOMINAL_SCATTER: f64 = 0.01;

/// What the protocol of a campaign could and could not tell apart.
///
/// # Errors
/// Where law and campaign do not go together.
pub fn design(campaign: &Campaign, options: &Options) -> Result<Design, DiagnosisError> {
    let mut blind = campaign.clone();
    for run in &mut blind.runs {
        let load = run.normal_load_n.unwrap_or(1.0);
        run.force_n = run
            .velocity_m_s
            .iter()
            .map(|v| {
                let sign = if *v == 0.0 { 0.0 } else { v.signum() };
                NOMINAL_FRICTION * load * sign
            })
            .collect();
        run.initial_state = InitialState::Relaxed;
    }
    let mut bench = bench(&blind, options)?;
    // The stand-in for the forces is flat: that is no clipped and no coarse channel.
    bench.masked.fill(false);
    bench.step_n = None;
    let model = rig::Model::new(bench.law, Vec::new(), &bench.experiment)?;
    let parameters: Vec<f64> = match &bench.prior {
        Some(prior) => model.at_null(&prior.values, &bench.experiment),
        None => {
            let typical: Vec<f64> = model
                .parameters()
                .iter()
                .take(model.law_parameters())
                .map(|s| s.typical)
                .collect();
            model.at_null(&typical, &bench.experiment)
        }
    };
    let prediction = model.predict(&bench.experiment, &parameters);
    bench.experiment.measured_n.clone_from(&prediction);
    bench.samples.force.clone_from(&prediction);
    let strongest = prediction.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
    let (lo, hi) = bench
        .samples
        .place
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &x| {
            (a.min(x), b.max(x))
        });
    let half = NOMINAL_ROUGHNESS * std::f64::consts::FRAC_1_SQRT_2;
    let sizes = Sizes {
        sensor: bench.stated_sensor.unwrap_or(1e-3 * strongest),
        private: half,
        plate: half,
        length: (hi - lo) / 200.0,
        scatter: NOMINAL_SCATTER,
        ..Sizes::NONE
    };
    let subset = Subset::all(&bench);
    let fitted = Fitted {
        effects: Vec::new(),
        model,
        parameters,
        prediction,
        cost: 0.0,
        converged: true,
        beside: Beside::default(),
    };
    let stand = Stand::new(&bench, &subset, fitted, sizes);
    let found = scan_nominal(&bench, &subset, &stand, sizes.scatter);
    let mut candidates = found.candidates.clone();
    candidates.sort_by_key(|c| c.cause);
    let limit = equivalent_z(strict(&found)) + 1.2816;
    let mut thresholds: Vec<Hidden> = candidates
        .iter()
        .map(|c| {
            let cause = &bench.catalogue[c.cause];
            let spec = &cause.parameters_for(&bench.experiment)[cause.sizes()[0]];
            let sd = stand
                .ground
                .size_deviation(&bench, &found.rays, c.cause, sizes.scatter);
            let search = if cause.is_periodic() { 6.1 / 4.8 } else { 1.0 };
            Hidden {
                cause: cause.id().into(),
                parameter: spec.name.to_string(),
                size: sd.map(|s| s * limit * search).filter(|s| s.is_finite()),
                unit: unit_on_rig(&bench, &spec.unit),
            }
        })
        .collect();
    let flat: Vec<Vec<DMatrix<f64>>> = candidates
        .par_iter()
        .map(|c| flattened(&stand.ground, &found.rays, c.cause, sizes.scatter))
        .collect();
    let isolability = flat
        .iter()
        .map(|a| flat.iter().map(|b| sine(a, b)).collect())
        .collect();
    thresholds.extend(found.absorbed.iter().map(|&c| Hidden {
        cause: bench.catalogue[c].id().into(),
        parameter: bench.catalogue[c].parameters()[0].name.to_string(),
        size: None,
        unit: unit_on_rig(&bench, &bench.catalogue[c].parameters()[0].unit),
    }));
    let mut undecidable = ties::ties(&bench, &stand, &found, sizes.scatter);
    undecidable.extend(ties::lacking(&bench));
    Ok(Design {
        schema: "bristle/design/1".into(),
        campaign: campaign.name.clone(),
        law: bench.law.id().into(),
        noise_floor: NoiseFloor {
            rmse: floor::modelled(&bench, &stand.fitted.prediction, &sizes),
            unit: floor::unit(&bench).into(),
            source: "assumed".into(),
            sensor: sizes.sensor,
            wander: sizes.wander,
            wander_time_s: None,
            roughness_private: sizes.private,
            roughness_plate: sizes.plate,
            roughness_length: sizes.length,
            roughness_smoothing: sizes.smoothing,
            roughness_plate_ratio: sizes.plate_ratio,
            roughness_plate_smoothing: sizes.plate_smoothing,
            scatter: sizes.scatter,
            caveats: vec!["nothing of the forces was read: noise and friction are nominal".into()],
        },
        thresholds,
        isolability,
        undecidable,
    })
}

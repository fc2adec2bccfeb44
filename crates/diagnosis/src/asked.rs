//! What a scan asks beside a fitted model: which causes, and at which of their shapes, sizes and periods.

use crate::bench::{Bench, Fitted};
use crate::joint::is_dear;
use crate::peaks::{Line, Peaks};
use crate::scan::period;

/// Chords of a cause that is not periodic: at most this many.
const MOST_CHORDS: usize = 8;
/// Shapes of a cause: at most this many tangents.
const MOST_SHAPES: usize = 16;

/// Cause, its parameters, and whether the signature is a chord (else a tangent).
pub(crate) type Task = (usize, Vec<f64>, bool);

/// The signatures that a scan asks for.
pub(crate) struct Tasks {
    pub(crate) tasks: Vec<Task>,
    /// Path length of the search over each cause's period.
    pub(crate) paths: Vec<f64>,
    /// Causes that are the law's own parameters under another name.
    pub(crate) shifts: Vec<usize>,
}

/// What is asked beside a fit: of each cause that is not skipped a tangent at every shape, and chords; of a periodic one its lines.
pub(crate) fn tasks(bench: &Bench<'_>, fitted: &Fitted, peaks: &Peaks, skipped: &[usize]) -> Tasks {
    let mut tasks: Vec<Task> = Vec::new();
    let mut paths: Vec<f64> = vec![0.0; bench.catalogue.len()];
    let mut shifts: Vec<usize> = Vec::new();
    let dear = fitted.effects.iter().any(|&e| is_dear(bench, e));
    for cause in 0..bench.catalogue.len() {
        let effect = &bench.catalogue[cause];
        if bench.prior.is_none() && is_shift(bench, cause) {
            shifts.push(cause);
            continue;
        }
        // Another form of a cause in the model is no further cause.
        let known = fitted.names(bench, cause) || effect.is_data_integrity();
        let scaled = is_a_named_one_scaled(bench, fitted, cause);
        if known || scaled || effect.refines() || skipped.contains(&cause) {
            continue;
        }
        if effect.is_periodic() {
            let Some((shape, in_time)) = period(bench, cause) else {
                continue;
            };
            let specs = effect.parameters_for(&bench.experiment);
            paths[cause] = peaks.path(cause);
            for Line { frequency, .. } in peaks.of(cause).iter().copied() {
                let value = if in_time { frequency } else { 1.0 / frequency };
                if specs[shape].admits(value) {
                    let mut at = vec![0.0; specs.len()];
                    at[shape] = value;
                    tasks.push((cause, at, false));
                }
            }
            continue;
        }
        // Beside a mass on a cord every signature is dear: three shapes, no chords.
        let shapes = effect.shape_grid(&bench.experiment);
        let stride = if dear { shapes.len().div_ceil(3) } else { 1 };
        for at in shapes.into_iter().take(MOST_SHAPES).step_by(stride) {
            tasks.push((cause, at, false));
        }
        if dear {
            continue;
        }
        // Mechanics that are dear to compute (a mass on a cord) are looked at in one size beside the tangent.
        let starts = effect.starts(&bench.experiment);
        let most = if is_dear(bench, cause) {
            1
        } else {
            MOST_CHORDS
        };
        let from = if is_dear(bench, cause) {
            (starts.len() - 1) / 2
        } else {
            0
        };
        for at in starts.into_iter().skip(from).take(most) {
            tasks.push((cause, at, true));
        }
    }
    Tasks {
        tasks,
        paths,
        shifts,
    }
}

/// Whether a cause is the law's own parameters under another name: only a model from elsewhere shows it. A lean is where the law has one of its
/// own (upright bristles have none), a gain wherever nothing but friction is in the record (a stated mass whose inertia it scales too tells
/// it from the law).
pub(crate) fn is_shift(bench: &Bench<'_>, cause: usize) -> bool {
    match bench.catalogue[cause].id() {
        "lean-angle" => bench.law.parameters().iter().any(|p| p.name == "theta0"),
        "force-gain" => bench.experiment.moving_mass_kg == 0.0,
        _ => false,
    }
}

/// Whether a cause is another size of one in the model, the law scaled: a gain g on a mass M + m is, where the law is free, a mass
/// (1 + g) (M + m), whatever g and m are.
fn is_a_named_one_scaled(bench: &Bench<'_>, fitted: &Fitted, cause: usize) -> bool {
    let other = match bench.catalogue[cause].id() {
        "force-gain" => "moving-inertia",
        "moving-inertia" => "force-gain",
        _ => return false,
    };
    bench.prior.is_none() && fitted.ids(bench).contains(&other)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Options;
    use crate::bench::Beside;
    use crate::prepare::{self, stand_in};

    /// Beside the law alone a stated mass tells a gain; beside a mass that is off by something the gain is that mass once more, and the other
    /// way round.
    #[test]
    fn a_gain_and_a_mass_are_not_asked_beside_one_another() {
        let mut campaign = stand_in("brush-2x2-aluminium");
        campaign.rig.moving_mass_kg = Some(1.5);
        let bench = prepare::bench(&campaign, &Options::default()).expect("a bench");
        let place = |id: &str| {
            let mut ids = bench.catalogue.iter().map(|cause| cause.id());
            ids.position(|own| own == id).expect("in it")
        };
        let (gain, mass, lag) = (
            place("force-gain"),
            place("moving-inertia"),
            place("sensor-lag"),
        );
        let beside = |effects: Vec<usize>| {
            let model = bench.model(&effects).expect("a model");
            let law = bench.law_starts(&bench.model(&[]).expect("a law"))[0].clone();
            let parameters = model.at_null(&law[..model.law_parameters()], &bench.experiment);
            Fitted {
                effects,
                prediction: Vec::new(),
                model,
                parameters,
                cost: 0.0,
                converged: true,
                beside: Beside::default(),
            }
        };
        let asked = |effects: Vec<usize>| -> [bool; 3] {
            let Tasks { tasks, .. } = tasks(&bench, &beside(effects), &Peaks::none(), &[]);
            [gain, mass, lag].map(|cause| tasks.iter().any(|task| task.0 == cause))
        };
        assert_eq!(asked(vec![]), [true, true, true]);
        assert_eq!(asked(vec![mass]), [false, false, true]);
        assert_eq!(asked(vec![gain]), [false, false, true]);
        assert_eq!(asked(vec![lag]), [true, true, false]);
    }
}

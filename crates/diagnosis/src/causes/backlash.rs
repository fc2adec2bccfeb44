//! Play: after every reversal of the stage the specimen stays behind until the gap (m) is crossed. A run starts with the play
//! taken up in the direction of its first motion; or the play stands as the run before left it, so that a run from rest against that one
//! crosses the gap first; or it opens only where the joint has no force left, some way after the turn, which between two runs it has not.

use friction::{LawKind, ParameterSpec, Scalar};
use rig::{Cause, Experiment, Place, Reach, Requirement, RunMotion, Station};

use super::{grids, marker};

const DESCRIPTION: &str = "Play is crossed after a reversal before force builds.";

/// A run starts with the play taken up.
#[derive(Clone, Copy, Debug)]
pub struct Backlash;

const GAP: ParameterSpec =
    ParameterSpec::new("gap_m", "m", "width of the play", 0.0, 1e9, 1e-4).with_null(0.0);
const PARAMETERS: &[ParameterSpec] = &[GAP];

/// Steps from sample to sample: a gap that is crossed between two samples is known no better than one of them.
const STEPS: usize = 8;

impl Cause for Backlash {
    fn id(&self) -> &'static str {
        "backlash"
    }

    fn station(&self) -> Station {
        Station::Coupling
    }

    fn reach(&self) -> Reach {
        Reach::Stage
    }

    fn describe(&self) -> &'static str {
        DESCRIPTION
    }

    fn parameters(&self) -> &'static [ParameterSpec] {
        PARAMETERS
    }

    fn parameters_for(&self, experiment: &Experiment) -> Vec<ParameterSpec> {
        bounds(experiment)
    }

    fn requirements(&self) -> &'static [Requirement] {
        &[Requirement::Reversals]
    }

    fn starts(&self, experiment: &Experiment) -> Vec<Vec<f64>> {
        gaps(experiment)
    }

    fn stepped(&self) -> Option<usize> {
        Some(0)
    }

    fn steps_a_sample(&self, _p: &[f64], run: &RunMotion) -> usize {
        let goes = |way: f64| run.velocity_m_s.iter().any(|v| v * way > 0.0);
        if goes(1.0) && goes(-1.0) { STEPS } else { 1 }
    }

    fn stage<D: Scalar>(&self, p: &[D], at: Place<'_>, velocity: &mut [D]) {
        cross(p[0], &at.run.time_s, 0.0, velocity);
    }
}

/// The play stands as the run before left it.
#[derive(Clone, Copy, Debug)]
pub struct CarriedBacklash;

/// Beside the gap, what tells this form from the other one in a file.
const CARRIED: &str = "carried_between_runs";

impl Cause for CarriedBacklash {
    marker::marked_form!(Backlash, "carried from run to run", CARRIED);

    fn requirements(&self) -> &'static [Requirement] {
        &[Requirement::Order, Requirement::BothDirections]
    }

    fn starts(&self, experiment: &Experiment) -> Vec<Vec<f64>> {
        Backlash.starts(experiment)
    }

    fn stepped(&self) -> Option<usize> {
        Backlash.stepped()
    }

    fn steps_a_sample(&self, _p: &[f64], run: &RunMotion) -> usize {
        let goes = |way: f64| heading_left(run) * way > 0.0 || run.velocity_m_s.iter().any(|v| v * way > 0.0);
        if goes(1.0) && goes(-1.0) { STEPS } else { 1 }
    }

    fn stage<D: Scalar>(&self, p: &[D], at: Place<'_>, velocity: &mut [D]) {
        cross(p[0], &at.run.time_s, heading_left(at.run), velocity);
    }
}

/// The direction in which the run before left the play taken up; 0 where it does not matter: a run that is recorded from the middle of a
/// motion has crossed its gap.
fn heading_left(run: &RunMotion) -> f64 {
    let moves = run.velocity_m_s.first().is_some_and(|v| *v != 0.0);
    if run.initial_state_unknown && moves { 0.0 } else { run.heading_before }
}

/// Stops that give way: of a step within the gap the share 1 - (1 - s/gap)^(1/softness) is lost, s the slack that is left. Softness 0
/// is a gap between hard stops.
#[derive(Clone, Copy, Debug)]
pub struct SoftBacklash;

/// Below the least one stops are as good as hard, and slack is lost faster than the steps through the gap follow.
const SOFTNESS: ParameterSpec =
    ParameterSpec::new("softness", "1", "how early the stops of the play give way", 1.0 / STEPS_A_GAP, 1.0, 0.5);

impl Cause for SoftBacklash {
    marker::refining_form!(Backlash, "soft stops", [GAP, SOFTNESS]);

    fn parameters_for(&self, experiment: &Experiment) -> Vec<ParameterSpec> {
        let mut specs = bounds(experiment);
        specs.push(SOFTNESS);
        specs
    }

    fn starts(&self, experiment: &Experiment) -> Vec<Vec<f64>> {
        let gaps = gaps(experiment).into_iter();
        gaps.map(|gap| [gap, vec![SOFTNESS.typical]].concat()).collect()
    }

    fn steps_a_sample(&self, p: &[f64], run: &RunMotion) -> usize {
        Backlash.steps_a_sample(p, run)
    }

    fn stage<D: Scalar>(&self, p: &[D], at: Place<'_>, velocity: &mut [D]) {
        // A gap that is crossed at once is lost whole, whatever its stops.
        if p[0].value() <= 0.0 {
            cross(p[0], &at.run.time_s, 0.0, velocity);
            return;
        }
        follow(p[0], &at.run.time_s, 0.0, velocity, |slack, path| {
            let before = *slack;
            give_way(p[0], p[1], slack, path);
            before - *slack
        });
    }
}

/// Steps in which a way as long as the gap is gone through between soft stops,
const STEPS_A_GAP: f64 = 8.0;
/// and the share of the gap below which no slack is left.
const NO_SLACK: f64 = 1e-9;

/// Takes from the slack what is lost of a way within a gap with soft stops: d(slack)/d(way) = -(1 - (1 - slack/gap)^(1/softness)), by
/// midpoints. As no softness lies below one part in [`STEPS_A_GAP`], no step takes more than there is.
fn give_way<D: Scalar>(gap: D, softness: D, slack: &mut D, path: D) {
    let lost = |slack: D| {
        let gone = -(slack / gap) + 1.0;
        // Where the gap is whole nothing gives way yet.
        if gone.value() > 1e-9 {
            -(gone.ln() / softness).exp() + 1.0
        } else {
            D::constant(1.0)
        }
    };
    let steps = (STEPS_A_GAP * (path / gap).value()).ceil().max(1.0);
    let step = path / steps;
    let mut gone = 0.0;
    while gone < steps && slack.value() > NO_SLACK * gap.value() {
        let middle = *slack - lost(*slack) * step * 0.5;
        *slack -= lost(middle) * step;
        gone += 1.0;
    }
}

/// A play that stays closed as long as the joint is pulled: bent bristles hold it over a way after the turn, and only then the gap is
/// crossed.
#[derive(Clone, Copy, Debug)]
pub struct HeldBacklash;

const HELD: ParameterSpec =
    ParameterSpec::new("held_m", "m", "way after a turn over which the play stays closed", 0.0, 1e9, 1e-4);

impl Cause for HeldBacklash {
    marker::form_of!(Backlash, "opens without force");

    fn parameters(&self) -> &'static [ParameterSpec] {
        const ALL: &[ParameterSpec] = &[GAP, HELD];
        ALL
    }

    fn parameters_for(&self, experiment: &Experiment) -> Vec<ParameterSpec> {
        let travel = experiment.scales.travel_m;
        let mut specs = bounds(experiment);
        specs.push(grids::bounded(&HELD, 0.0, 0.9 * travel, 0.01 * travel));
        specs
    }

    fn requirements(&self) -> &'static [Requirement] {
        Backlash.requirements()
    }

    /// Without a stretch before sliding the force is gone where the motion turns.
    fn applies_to(&self, law: LawKind) -> bool {
        !matches!(law, LawKind::CoulombViscous | LawKind::Stribeck)
    }

    fn shape_grid(&self, experiment: &Experiment) -> Vec<Vec<f64>> {
        holds(experiment).into_iter().map(|held| vec![0.0, held]).collect()
    }

    fn starts(&self, experiment: &Experiment) -> Vec<Vec<f64>> {
        let of_gap = |gap: Vec<f64>| holds(experiment).into_iter().map(move |held| vec![gap[0], held]);
        gaps(experiment).into_iter().skip(1).take(2).flat_map(of_gap).collect()
    }

    fn stepped(&self) -> Option<usize> {
        Some(0)
    }

    fn steps_a_sample(&self, p: &[f64], run: &RunMotion) -> usize {
        Backlash.steps_a_sample(p, run)
    }

    fn stage<D: Scalar>(&self, p: &[D], at: Place<'_>, velocity: &mut [D]) {
        cross_held(p[0], p[1], at.run, 0.0, velocity);
    }
}

/// A play that stays closed as long as the joint is pulled, and stands between runs as the run before left it: there nothing pulls.
#[derive(Clone, Copy, Debug)]
pub struct HeldCarriedBacklash;

impl Cause for HeldCarriedBacklash {
    marker::marked_form!(HeldBacklash, "opens without force, carried from run to run", CARRIED);

    fn refines(&self) -> bool {
        true
    }

    fn requirements(&self) -> &'static [Requirement] {
        &[Requirement::Reversals, Requirement::Order, Requirement::BothDirections]
    }

    fn shape_grid(&self, experiment: &Experiment) -> Vec<Vec<f64>> {
        HeldBacklash.shape_grid(experiment)
    }

    fn starts(&self, experiment: &Experiment) -> Vec<Vec<f64>> {
        HeldBacklash.starts(experiment)
    }

    fn stepped(&self) -> Option<usize> {
        HeldBacklash.stepped()
    }

    fn steps_a_sample(&self, p: &[f64], run: &RunMotion) -> usize {
        CarriedBacklash.steps_a_sample(p, run)
    }

    fn stage<D: Scalar>(&self, p: &[D], at: Place<'_>, velocity: &mut [D]) {
        cross_held(p[0], p[1], at.run, heading_left(at.run), velocity);
    }
}

/// Ways over which bent bristles may hold a play closed, m: about that after which the recorded force changes its sign.
fn holds(experiment: &Experiment) -> Vec<f64> {
    let mut ways: Vec<f64> = experiment.runs.iter().flat_map(|run| ways_to_release(experiment, run)).collect();
    ways.sort_by(f64::total_cmp);
    match ways.get(ways.len() / 2) {
        Some(&way) if way > 0.0 => [0.7, 0.9, 1.1, 1.4].map(|share| share * way).to_vec(),
        _ => grids::logarithmic(1e-4 * experiment.scales.travel_m, 3e-2 * experiment.scales.travel_m, 4),
    }
}

/// Ways from the turns of a run to where the force has the sign of the motion again, m.
fn ways_to_release(experiment: &Experiment, run: &RunMotion) -> Vec<f64> {
    let force = &experiment.measured_n[run.samples.clone()];
    let (mut heading, mut turned_m) = (0.0, None);
    let mut ways = Vec::new();
    for ((&v, &f), &at_m) in run.velocity_m_s.iter().zip(force).zip(&run.distance_m) {
        if v == 0.0 {
            continue;
        }
        if v * heading < 0.0 {
            turned_m = Some(at_m);
        }
        heading = v.signum();
        if let Some(from_m) = turned_m.filter(|_| f * v >= 0.0) {
            ways.push(at_m - from_m);
            turned_m = None;
        }
    }
    ways
}

fn bounds(experiment: &Experiment) -> Vec<ParameterSpec> {
    let travel = experiment.scales.travel_m;
    vec![grids::bounded(&PARAMETERS[0], 0.0, 0.9 * travel, 0.01 * travel)]
}

/// The moment at which a gap is crossed makes a sample's force jump, so a fit gets over few of them: a ladder of gaps.
fn gaps(experiment: &Experiment) -> Vec<Vec<f64>> {
    let travel = experiment.scales.travel_m;
    [3e-5, 1e-4, 3e-4, 1e-3, 1e-2].iter().map(|share| vec![share * travel]).collect()
}

/// Takes the crossing of the gap out of a velocity. `heading`: the direction in which the play is taken up before the first
/// sample, 0 for that of the first motion.
fn cross<D: Scalar>(gap: D, time: &[f64], heading: f64, velocity: &mut [D]) {
    follow(gap, time, heading, velocity, |slack, path| {
        if slack.value() >= path.value() {
            *slack -= path;
            path
        } else {
            std::mem::replace(slack, D::constant(0.0))
        }
    });
}

/// Goes along a velocity and takes from each sample what is lost of its way: `lost` is handed the slack and the way.
fn follow<D: Scalar>(
    gap: D,
    time: &[f64],
    mut heading: f64,
    velocity: &mut [D],
    lost: impl Fn(&mut D, D) -> D,
) {
    let mut slack = D::constant(0.0);
    for i in 0..velocity.len() {
        let v = velocity[i];
        if v.value() == 0.0 {
            continue;
        }
        let sign = v.value().signum();
        if heading != 0.0 && sign != heading {
            slack = gap - slack;
        }
        heading = sign;
        let path = v * (sign * weight_s(time, i));
        let lost = lost(&mut slack, path);
        velocity[i] = if lost.value() == path.value() {
            D::constant(0.0)
        } else {
            v * (-(lost / path) + 1.0)
        };
    }
}

/// A gap that opens `held` after a turn, and at once where the first motion goes against `left`, the direction in which the play was left: of
/// the way at s after a turn the share of [s - d/2, s + d/2] is lost that lies within [held, held + gap]. d is what the stage goes from sample to sample, for where between two of them the play opens no record tells; a
/// sample is not taken while a gap is crossed that is narrower than half of it.
fn cross_held<D: Scalar>(gap: D, held: D, run: &RunMotion, left: f64, velocity: &mut [D]) {
    let none = D::constant(0.0);
    let parts = run.steps_a_sample;
    let mut heading = 0.0;
    // Where the gap lies after the last turn, and the way since; taken up: nothing is to be crossed.
    let mut ahead: Option<[D; 2]> = None;
    let mut gone = none;
    // Of a gap that a run begins with the place is known.
    let mut from_rest = true;
    for i in 0..velocity.len() {
        let v = velocity[i];
        if v.value() == 0.0 {
            continue;
        }
        let sign = v.value().signum();
        if heading == 0.0 && left * sign < 0.0 {
            ahead = Some([none, gap]);
        }
        if heading * sign < 0.0 {
            ahead = match ahead {
                // It had not opened: the same side pulls again.
                Some([from, _]) if gone.value() <= from.value() => None,
                // What was crossed is crossed back.
                Some([from, to]) if gone.value() < to.value() => Some([none, gone - from]),
                _ => Some([held, held + gap]),
            };
            gone = none;
            from_rest = false;
        }
        heading = sign;
        let step = v * (sign * weight_s(&run.time_s, i));
        let window = if from_rest { step } else { step * parts as f64 };
        let middle = gone + step * 0.5;
        gone += step;
        let Some([from, to]) = ahead else { continue };
        let near = larger(middle - window * 0.5, from);
        let far = smaller(middle + window * 0.5, to);
        if far.value() < near.value() {
            continue;
        }
        let lost = (far - near) / window;
        if from_rest {
            velocity[i] = v * (-lost + 1.0);
            continue;
        }
        let narrow = (to - from).value() < 0.5 * window.value();
        velocity[i] = match (parts > 1 && i.is_multiple_of(parts), narrow) {
            (true, true) => v,
            (true, false) => if lost.value() > 0.5 { none } else { v },
            // The others take over what the sample does not lose.
            (false, true) if parts > 1 => v * (-lost * (parts as f64 / (parts - 1) as f64) + 1.0),
            (false, _) => v * (-lost + 1.0),
        };
    }
}

fn larger<D: Scalar>(a: D, b: D) -> D {
    if a.value() > b.value() { a } else { b }
}

fn smaller<D: Scalar>(a: D, b: D) -> D {
    if a.value() < b.value() { a } else { b }
}

/// The share of the record that a sample stands for, s: the trapezium's weight.
fn weight_s(time: &[f64], i: usize) -> f64 {
    let before = if i > 0 { time[i] - time[i - 1] } else { 0.0 };
    let after = if i + 1 < time.len() { time[i + 1] - time[i] } else { 0.0 };
    0.5 * (before + after)
}

#[cfg(test)]
mod tests {
    use super::{SOFTNESS, give_way};

    /// Slack is lost and never grows, over all softnesses, and a way of many gaps leaves none.
    #[test]
    fn slack_is_only_lost() {
        let gap = 1e-4_f64;
        for softness in [SOFTNESS.lower, 0.3, 0.7, SOFTNESS.upper] {
            let mut slack = gap;
            for _ in 0..400 {
                let before = slack;
                give_way(gap, softness, &mut slack, 0.07 * gap);
                assert!((0.0..=before).contains(&slack), "{softness}: {before} {slack}");
            }
            assert!(slack < 1e-6 * gap, "{softness}: {slack}");
            let mut at_once = gap;
            give_way(gap, softness, &mut at_once, 40.0 * gap);
            assert!((0.0..1e-6 * gap).contains(&at_once), "{softness}: {at_once}");
        }
    }
}

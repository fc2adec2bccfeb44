//! The static level grows with rest: s (1 + b log10(rest/1 s)) for rests above 1 s, b per decade. The rest is that before the
//! run; a stand of the stage inside a run counts from its end on (in one form it does not). What came before the first run is not recorded: it is
//! taken as the median of the other rests, or is free. What was gained lasts for the motion, or is lost where the motion turns, or sliding wears it
//! off: then b fades as exp(-x/d), x the distance slid since the stand (m), d a distance (m). A contact that has itself grown with rest
//! has a higher kinetic level too, until sliding has worn it off.

use std::collections::BTreeMap;

use friction::{Aged, LawKind, ParameterSpec, Scalar};
use rig::{Cause, Experiment, Place, Reach, Reported, Requirement, Station};

use super::{grids, marker};

const DESCRIPTION: &str = "Static friction grows with the time of rest.";

/// Rest before a run, s.
fn rest_before(at: Place<'_>) -> f64 {
    at.run.rest_s.unwrap_or_else(|| median_rest(at.experiment))
}

/// The median of the rests that are recorded, s; 1 s where there are none.
fn median_rest(experiment: &Experiment) -> f64 {
    let mut rests: Vec<f64> = experiment.runs.iter().filter_map(|run| run.rest_s).collect();
    rests.sort_by(f64::total_cmp);
    rests.get(rests.len() / 2).copied().unwrap_or(1.0)
}

/// What was gained lasts for the motion.
#[derive(Clone, Copy, Debug)]
pub struct DwellAgeing;

const PER_DECADE: ParameterSpec =
    ParameterSpec::new("per_decade", "1", "growth of the static level per decade of rest", -0.9, 10.0, 0.05).with_null(0.0);
const PARAMETERS: &[ParameterSpec] = &[PER_DECADE];

impl Cause for DwellAgeing {
    fn id(&self) -> &'static str {
        "dwell-ageing"
    }

    fn station(&self) -> Station {
        Station::History
    }

    fn reach(&self) -> Reach {
        Reach::RestGain
    }

    fn describe(&self) -> &'static str {
        DESCRIPTION
    }

    fn parameters(&self) -> &'static [ParameterSpec] {
        PARAMETERS
    }

    fn requirements(&self) -> &'static [Requirement] {
        &[Requirement::Clock]
    }

    fn applies_to(&self, law: LawKind) -> bool {
        !matches!(law, LawKind::CoulombViscous | LawKind::Dahl)
    }

    fn rest_gain<D: Scalar>(&self, p: &[D], at: Place<'_>, gain: &mut [D]) {
        for (gain, since) in gain.iter_mut().zip(last_stand(at)) {
            *gain *= p[0] * since.rest_s.max(1.0).log10() + 1.0;
        }
    }
}

/// What was gained is lost where the motion turns.
#[derive(Clone, Copy, Debug)]
pub struct TurnedAgeing;

/// Beside the growth, what tells this form from the plain one in a file.
const LOST: &str = "lost_in_turning";

impl Cause for TurnedAgeing {
    marker::marked_form!(DwellAgeing, "lost where the motion turns", LOST);

    fn requirements(&self) -> &'static [Requirement] {
        &[Requirement::Clock, Requirement::Reversals]
    }

    fn rest_gain<D: Scalar>(&self, p: &[D], at: Place<'_>, gain: &mut [D]) {
        for ((gain, since), turned) in gain.iter_mut().zip(last_stand(at)).zip(turned(at)) {
            let decades = if turned { 0.0 } else { since.rest_s.max(1.0).log10() };
            *gain *= p[0] * decades + 1.0;
        }
    }
}

/// Only the rest before a run counts, not a stand within it.
#[derive(Clone, Copy, Debug)]
pub struct AgeingBetweenRuns;

/// Beside the growth, what tells this form from the others in a file.
const BETWEEN_RUNS: &str = "between_runs";

impl Cause for AgeingBetweenRuns {
    marker::marked_form!(DwellAgeing, "stands within runs do not count", BETWEEN_RUNS);

    fn refines(&self) -> bool {
        true
    }

    fn requirements(&self) -> &'static [Requirement] {
        DwellAgeing.requirements()
    }

    fn rest_gain<D: Scalar>(&self, p: &[D], at: Place<'_>, gain: &mut [D]) {
        let factor = p[0] * rest_before(at).max(1.0).log10() + 1.0;
        gain.iter_mut().for_each(|gain| *gain *= factor);
    }
}

/// Whether the motion has turned between the last stand and the step from each sample to the next one.
fn turned(at: Place<'_>) -> Vec<bool> {
    let speed = &at.run.velocity_m_s;
    let (mut way, mut turned, mut still) = (0.0, false, 0);
    (0..speed.len())
        .map(|i| {
            let now = speed[i];
            if now == 0.0 {
                still += 1;
            } else {
                // a single sample of rest is a start or a reversal, not a stand
                let stood = still > 1;
                turned = !stood && (turned || now * way < 0.0);
                (way, still) = (now, 0);
            }
            turned
        })
        .collect()
}

/// Sliding wears off what was gained.
#[derive(Clone, Copy, Debug)]
pub struct FadingAgeing;

const FADING_PER_DECADE: ParameterSpec =
    ParameterSpec::new("per_decade", "1", "growth of the static level per decade of rest, before sliding", -0.9, 10.0, 0.05).with_null(0.0);
const FADING_DISTANCE: ParameterSpec =
    ParameterSpec::new("fading_distance_m", "m", "sliding that leaves 1/e of the growth", 1e-9, 1e9, 1e-2);
const FADING: &[ParameterSpec] = &[FADING_PER_DECADE, FADING_DISTANCE];

/// Distances over which growth fades, as shares of the longest run, and how many of them the scan looks at.
const FADES: (f64, f64) = (0.01, 0.3);
const LOOKS: usize = 4;

impl Cause for FadingAgeing {
    fn id(&self) -> &'static str {
        "dwell-ageing"
    }

    fn variant(&self) -> Option<&'static str> {
        Some("worn off by sliding")
    }

    fn station(&self) -> Station {
        Station::History
    }

    fn reach(&self) -> Reach {
        Reach::RestGain
    }

    fn describe(&self) -> &'static str {
        DESCRIPTION
    }

    fn parameters(&self) -> &'static [ParameterSpec] {
        FADING
    }

    fn parameters_for(&self, experiment: &Experiment) -> Vec<ParameterSpec> {
        let (run, _) = grids::slid_m(experiment);
        let (shortest, longest) = (0.3 * FADES.0 * run, 3.0 * FADES.1 * run);
        vec![FADING[0].clone(), grids::bounded(&FADING[1], shortest, longest, 0.05 * run)]
    }

    fn requirements(&self) -> &'static [Requirement] {
        &[Requirement::Clock]
    }

    fn applies_to(&self, law: LawKind) -> bool {
        DwellAgeing.applies_to(law)
    }

    fn shape_grid(&self, experiment: &Experiment) -> Vec<Vec<f64>> {
        let (run, _) = grids::slid_m(experiment);
        grids::logarithmic(FADES.0 * run, FADES.1 * run, LOOKS).into_iter().map(|d| vec![0.0, d]).collect()
    }

    fn rest_gain<D: Scalar>(&self, p: &[D], at: Place<'_>, gain: &mut [D]) {
        let rate = p[1].recip();
        for (gain, since) in gain.iter_mut().zip(last_stand(at)) {
            *gain *= p[0] * (-(rate * since.slid_m)).exp() * since.rest_s.max(1.0).log10() + 1.0;
        }
    }
}

/// Decades of rest above 1 s before the first run, where they are free.
const FIRST: ParameterSpec =
    ParameterSpec::new("decades_before_first_run", "1", "decades of rest above 1 s before the first run", 0.0, 8.0, 1.0);

/// Decades of rest before each sample's motion, those before the first run free.
fn decades<D: Scalar>(at: Place<'_>, since: &SinceStand, first: D) -> D {
    if since.before_run && at.run.rest_s.is_none() {
        first
    } else {
        D::constant(since.rest_s.max(1.0).log10())
    }
}

/// The same bounds with the median of the other rests as the first run's.
fn with_first(mut specs: Vec<ParameterSpec>, experiment: &Experiment) -> Vec<ParameterSpec> {
    let typical = median_rest(experiment).max(1.0).log10();
    specs.push(grids::bounded(&FIRST, FIRST.lower, FIRST.upper, typical));
    specs
}

/// What was gained lasts for the motion; nobody knows how long the specimen had rested before the first run.
#[derive(Clone, Copy, Debug)]
pub struct FreshAgeing;

impl Cause for FreshAgeing {
    marker::refining_form!(DwellAgeing, "the rest before the first run free", [PER_DECADE, FIRST]);

    fn parameters_for(&self, experiment: &Experiment) -> Vec<ParameterSpec> {
        with_first(DwellAgeing.parameters_for(experiment), experiment)
    }

    fn applies_to(&self, law: LawKind) -> bool {
        DwellAgeing.applies_to(law)
    }

    fn rest_gain<D: Scalar>(&self, p: &[D], at: Place<'_>, gain: &mut [D]) {
        for (gain, since) in gain.iter_mut().zip(last_stand(at)) {
            *gain *= p[0] * decades(at, &since, p[1]) + 1.0;
        }
    }
}

/// Sliding wears off what was gained; nobody knows how long the specimen had rested before the first run.
#[derive(Clone, Copy, Debug)]
pub struct FreshFadingAgeing;

impl Cause for FreshFadingAgeing {
    marker::refining_form!(
        FadingAgeing,
        "worn off by sliding, the rest before the first run free",
        [FADING_PER_DECADE, FADING_DISTANCE, FIRST]
    );

    fn parameters_for(&self, experiment: &Experiment) -> Vec<ParameterSpec> {
        with_first(FadingAgeing.parameters_for(experiment), experiment)
    }

    fn applies_to(&self, law: LawKind) -> bool {
        FadingAgeing.applies_to(law)
    }

    fn rest_gain<D: Scalar>(&self, p: &[D], at: Place<'_>, gain: &mut [D]) {
        let rate = p[1].recip();
        for (gain, since) in gain.iter_mut().zip(last_stand(at)) {
            *gain *= p[0] * (-(rate * since.slid_m)).exp() * decades(at, &since, p[2]) + 1.0;
        }
    }
}

/// The contact has grown: the Stribeck curve as a whole is higher, until sliding wears it off.
#[derive(Clone, Copy, Debug)]
pub struct GrownContact;

/// Beside growth and distance, what tells this form from the one of the static level in a file.
const WHOLE: &str = "of_the_whole_curve";

impl Cause for GrownContact {
    fn id(&self) -> &'static str {
        DwellAgeing.id()
    }

    fn variant(&self) -> Option<&'static str> {
        Some("of the whole curve, worn off by sliding")
    }

    fn station(&self) -> Station {
        DwellAgeing.station()
    }

    fn reach(&self) -> Reach {
        Reach::RestGain
    }

    fn aged(&self) -> Aged {
        Aged::Whole
    }

    fn describe(&self) -> &'static str {
        DESCRIPTION
    }

    fn parameters(&self) -> &'static [ParameterSpec] {
        FADING
    }

    fn parameters_for(&self, experiment: &Experiment) -> Vec<ParameterSpec> {
        FadingAgeing.parameters_for(experiment)
    }

    fn requirements(&self) -> &'static [Requirement] {
        FadingAgeing.requirements()
    }

    fn shape_grid(&self, experiment: &Experiment) -> Vec<Vec<f64>> {
        FadingAgeing.shape_grid(experiment)
    }

    fn reported(&self, fitted: &[f64]) -> Vec<Reported> {
        marker::marked(FadingAgeing.reported(fitted), WHOLE)
    }

    fn from_reported(&self, reported: &BTreeMap<String, f64>) -> Result<Vec<f64>, String> {
        marker::demanded(reported, WHOLE)?;
        FadingAgeing.from_reported(reported)
    }

    fn rest_gain<D: Scalar>(&self, p: &[D], at: Place<'_>, gain: &mut [D]) {
        FadingAgeing.rest_gain(p, at, gain);
    }
}

/// The last stand of the stage before a moment: how long it was, and how far the contact has slid since.
struct SinceStand {
    rest_s: f64,
    slid_m: f64,
    /// Whether it is the rest before the run.
    before_run: bool,
}

/// The last stand before the middle of each sample's step to the next one, which belongs to the motion after the stand.
fn last_stand(at: Place<'_>) -> Vec<SinceStand> {
    let (time, speed, slid) = (&at.run.time_s, &at.run.velocity_m_s, &at.run.distance_m);
    let mut rest = rest_before(at);
    let mut standing_since = None;
    let mut left_at = 0.0;
    let mut before_run = true;
    (0..time.len())
        .map(|i| {
            if speed[i] == 0.0 {
                standing_since = standing_since.or(Some(time[i]));
            } else if let Some(since) = standing_since.take() {
                // a single sample of rest is a start or a reversal, not a stand
                let stood = time[i - 1] - since;
                if stood > 0.0 {
                    before_run = since == time[0];
                    rest = stood + if before_run { rest } else { 0.0 };
                    left_at = slid[i - 1];
                }
            }
            let middle = 0.5 * (slid[i] + slid[(i + 1).min(slid.len() - 1)]);
            SinceStand { rest_s: rest, slid_m: middle - left_at, before_run }
        })
        .collect()
}

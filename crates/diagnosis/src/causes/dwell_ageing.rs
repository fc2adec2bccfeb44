//! The static level grows with rest: s (1 + b log10(rest/1 s)) for rests above 1 s, b per decade. The rest is that before the
//! run; a stand of the stage inside a run counts from its end on. What came before the first run is not recorded: it is
//! taken as the median of the other rests.

use friction::{ParameterSpec, Scalar, LawKind};
use rig::{Cause, Place, Reach, Requirement, Station};

fn median_rest(at: Place<'_>) -> f64 {
    let mut rests: Vec<f64> = at.experiment.runs.iter().filter_map(|run| run.rest_s).collect();
    rests.sort_by(f64::total_cmp);
    rests.get(rests.len() / 2).copied().unwrap_or(1.0)
}

/// Static friction grows with the time of rest.
#[derive(Clone, Copy, Debug)]
pub struct DwellAgeing;

const PARAMETERS: &[ParameterSpec] = &[
    ParameterSpec::new("per_decade", "1", "growth of the static level per decade of rest", -0.9, 10.0, 0.05).with_null(0.0),
];

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
        "Static friction grows with the time of rest."
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
        let (time, speed) = (&at.run.time_s, &at.run.velocity_m_s);
        let mut rest = at.run.rest_s.unwrap_or_else(|| median_rest(at));
        let mut standing_since = None;
        for i in 0..gain.len() {
            if speed[i] == 0.0 {
                standing_since = standing_since.or(Some(time[i]));
            } else if let Some(since) = standing_since.take() {
                // a single sample of rest is a start or a reversal, not a stand
                let stood = time[i - 1] - since;
                if stood > 0.0 {
                    rest = stood + if since == time[0] { rest } else { 0.0 };
                }
            }
            // the interval that begins here belongs to the motion after the stand
            gain[i] *= p[0] * rest.max(1.0).log10() + 1.0;
        }
    }
}

//! Curves of an answer, for figures.

use crate::selection::Selected;
use crate::whole::Whole;

/// Stacked curves of all runs, in the unit of the record (N or N m).
#[derive(Clone, Debug)]
pub struct Curves {
    /// Samples of each run.
    pub runs: Vec<std::ops::Range<usize>>,
    /// Names of the runs.
    pub names: Vec<String>,
    /// Time in the run, s.
    pub time_s: Vec<f64>,
    /// Velocity, m/s.
    pub velocity_m_s: Vec<f64>,
    /// Recorded force.
    pub measured: Vec<f64>,
    /// Law alone.
    pub law: Vec<f64>,
    /// Law with the named causes.
    pub extended: Vec<f64>,
    /// Half width of the 95 % noise band about a prediction.
    pub band: Vec<f64>,
}

/// Curves of a selection on all recorded runs.
pub(crate) fn curves(whole: &Whole<'_>, selected: &Selected) -> Curves {
    let bench = whole.bench;
    let s = selected.stand.sizes;
    let relative = s.private.powi(2) + s.plate.powi(2) + s.scatter.powi(2);
    let extended = whole.extended.prediction.clone();
    Curves {
        runs: bench.samples.runs.clone(),
        names: bench.campaign.runs.iter().map(|r| r.name.clone()).collect(),
        time_s: bench.samples.time.clone(),
        velocity_m_s: bench.samples.velocity.clone(),
        measured: bench.samples.force.clone(),
        law: whole.stated.prediction.clone(),
        band: extended
            .iter()
            .map(|f| 1.96 * (s.of_the_channel() + relative * f * f).sqrt())
            .collect(),
        extended,
    }
}

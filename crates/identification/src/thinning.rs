//! Fewer samples of the same motions, for what needs no precision: comparing starts and laws.

use campaign::Campaign;

/// The campaign with every k-th sample of each run, k the smallest that leaves at most `most` samples in all (and at
/// least forty a run); the campaign itself where it is small enough.
pub(crate) fn thinned(campaign: &Campaign, most: usize) -> Campaign {
    let all: usize = campaign.runs.iter().map(|run| run.time_s.len()).sum();
    let mut thin = campaign.clone();
    if all <= most {
        return thin;
    }
    for run in &mut thin.runs {
        let step = all.div_ceil(most).min(run.time_s.len() / 40).max(1);
        let every =
            |column: &mut Vec<f64>| *column = column.iter().copied().step_by(step).collect();
        every(&mut run.time_s);
        every(&mut run.velocity_m_s);
        every(&mut run.force_n);
        for column in [
            &mut run.position_m,
            &mut run.normal_force_n,
            &mut run.temperature_c,
        ]
        .into_iter()
        .flatten()
        {
            every(column);
        }
    }
    thin
}

//! A line in time that no cause may be: something that beats in all runs, all of the time, and begins anew with each.
//!
//! Without a recorded load an oscillation of it cannot be named, and [`crate::rhythm`] takes what is in all stretches for their background. Here
//! the phase is that of each run's clock, so that all of them count as one wave of a factor on friction; frequencies, backgrounds and the
//! price of the search are those of [`crate::periodic`].

use nalgebra::DMatrix;

use crate::answer::Place;
use crate::bench::Bench;
use crate::general::Lack;
use crate::ground::look_elsewhere;
use crate::peaks::{
    MOST_LINES, SLOW, highest, in_time, information, longest, middling_step, solved_back,
};
use crate::periodic::Family;
use crate::samples::Samples;
use crate::stand::Stand;
use crate::subset::Subset;

/// The strongest line; `None` where a cause may be one.
pub(crate) fn line_in_time(
    bench: &Bench<'_>,
    subset: &Subset,
    stand: &Stand,
    samples: &Samples,
    scale: &[f64],
) -> Option<Lack> {
    let named = (0..bench.catalogue.len())
        .any(|cause| bench.catalogue[cause].is_periodic() && in_time(bench, cause));
    let (span, step) = (
        longest(samples, &samples.time),
        middling_step(samples, &samples.time),
    );
    if named || !(span > 0.0 && step > 0.0) {
        return None;
    }
    let spacing = 0.5 / span;
    let family = Family {
        coordinate: &samples.time,
        along: scale.to_vec(),
        across: vec![0.0; scale.len()],
        band: (2.0 / span, 0.45 / step),
        spacing,
        slow: SLOW * spacing,
        comb: None,
    };
    let scatter = stand.ground.likeliest_scatter();
    let g = solved_back(subset, stand, scatter);
    let information = |columns: &DMatrix<f64>| information(stand, scatter, columns);
    let peaks = family.peaks(&g, &information, MOST_LINES);
    let lines = highest(peaks.into_iter().map(|p| (&family, p)).collect(), &g, 1);
    let line = lines.first()?;
    let white = stand.whiten_own(&family.columns(line.frequency));
    let score = (stand.ground.score(&stand.ground.direction(&white)?)).over(line.background);
    Some(Lack {
        log_p: look_elsewhere(&score, family.path()),
        place: Some(Place {
            axis: "time".into(),
            from: 0.0,
            to: samples.time.iter().copied().fold(0.0, f64::max),
            unit: "s".into(),
            runs: bench.run_names(subset),
        }),
        excess: (score.statistic - score.columns as f64).max(0.0),
    })
}

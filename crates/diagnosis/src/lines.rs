//! A line in time that no cause may be: something that beats in all runs, all of the time, and begins anew with each.
//!
//! Without a recorded load an oscillation of it cannot be named, and [`crate::rhythm`] takes what is in all stretches for their background. Here
//! the phase is that of each run's clock, so that all of them count as one wave of a factor on friction; frequencies, backgrounds and the
//! price of the search are those of [`crate::periodic`].

use nalgebra::DMatrix;

use crate::bench::Bench;
use crate::general::Lack;
use crate::ground::look_elsewhere;
use crate::peaks::{MOST_LINES, SLOW, highest, in_time, information, solved_back, span_and_band};
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
    if named {
        return None;
    }
    let (span, band) = span_and_band(samples, &samples.time)?;
    let spacing = 0.5 / span;
    let family = Family {
        coordinate: &samples.time,
        along: scale.to_vec(),
        across: vec![0.0; scale.len()],
        band,
        spacing,
        slow: SLOW * spacing,
        comb: None,
    };
    let scatter = stand.ground.likeliest_scatter();
    let g = solved_back(stand, scatter);
    let information = |columns: &DMatrix<f64>| information(stand, scatter, columns);
    let peaks = family.peaks(&g, &information, MOST_LINES);
    let lines = highest(peaks.into_iter().map(|p| (&family, p)).collect(), &g, 1);
    let line = lines.first()?;
    let white = stand.whiten_own(&family.columns(line.frequency));
    let score = (stand.ground.score(&stand.ground.direction(&white)?)).over(line.background);
    let runs: Vec<usize> = (0..samples.runs.len()).collect();
    Some(Lack {
        log_p: look_elsewhere(&score, family.path()),
        place: Some(samples.place_of_runs(&runs, &bench.run_names(subset))),
        excess: (score.statistic - score.columns as f64).max(0.0),
    })
}

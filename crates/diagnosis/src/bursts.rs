//! Short bursts of unrest in single runs, such as stick-slip that comes and goes: a stretch that is louder than the same stretch
//! of other runs, one that beats in a rhythm, or a single blow. The three searches pay for one another by Bonferroni's bound.

use nalgebra::DVector;

use crate::answer::Place;
use crate::general::Lack;
use crate::ground::Ground;
use crate::rhythm::rhythm;
use crate::samples::Samples;
use crate::tail::log_chi2_tail;

/// Samples of a stretch; neighbours overlap by half.
const WINDOW: usize = 40;
/// Beyond so many standard deviations a sample is a blow and says nothing more about unrest or rhythm.
const CLIP: f64 = 3.0;

/// The strongest burst in the whitened residual.
pub(crate) fn bursts(ground: &Ground, samples: &Samples, names: &[String]) -> Lack {
    let y = ground.y.rows(0, samples.len()).into_owned();
    let mean_square = y.norm_squared() / y.len().max(1) as f64;
    let y = y.unscale(mean_square.sqrt().max(f64::MIN_POSITIVE));
    let clipped = y.map(|v| v.clamp(-CLIP, CLIP));
    let searches = [
        unrest(&clipped, samples, names),
        rhythm(&clipped, samples, names),
        blow(&y, samples, names),
    ];
    let price = (searches.len() as f64).ln();
    let mut best = searches
        .into_iter()
        .min_by(|a, b| a.log_p.total_cmp(&b.log_p))
        .unwrap_or_else(Lack::nothing);
    best.log_p = (best.log_p + price).min(0.0);
    best
}

/// A stretch of one run, by its first and last sample.
pub(crate) fn in_run(
    samples: &Samples,
    names: &[String],
    run: usize,
    first: usize,
    last: usize,
) -> Place {
    Place {
        axis: "time".into(),
        from: samples.time[first],
        to: samples.time[last],
        unit: "s".into(),
        runs: vec![names[run].clone()],
    }
}

/// The largest single sample beside the others' tails. Of m samples above a level u whose tail falls as x^-alpha the largest
/// exceeds r u with probability m r^-alpha; no healthy noise is taken to have heavier tails than alpha = 4, and where they are
/// lighter only a gross blow is one.
fn blow(y: &DVector<f64>, samples: &Samples, names: &[String]) -> Lack {
    const ALPHA: f64 = 4.0;
    const ABOVE: usize = 10;
    let mut order: Vec<usize> = (0..y.len()).collect();
    order.sort_by(|&a, &b| y[b].abs().total_cmp(&y[a].abs()));
    let (Some(&at), Some(&level)) = (order.first(), order.get(ABOVE)) else {
        return Lack::nothing();
    };
    let ratio = y[at].abs() / y[level].abs().max(1.0);
    let run = samples.owner[at];
    let ends = &samples.runs[run];
    let (first, last) = (at.max(ends.start + 1) - 1, (at + 1).min(ends.end - 1));
    Lack {
        log_p: ((ABOVE as f64).ln() - ALPHA * ratio.ln()).min(0.0),
        place: Some(in_run(samples, names, run, first, last)),
        excess: y[at] * y[at],
    }
}

/// Unrest: stretches of whitened residual whose mean square is above what the same stretch shows in the calmest quarter
/// of the runs (a burst may come back in every other run), and above what the campaign's own tails allow.
fn unrest(y: &DVector<f64>, samples: &Samples, names: &[String]) -> Lack {
    // Run, first sample, place in the run, mean square.
    let mut windows: Vec<(usize, usize, usize, f64)> = Vec::new();
    for (k, run) in samples.runs.iter().enumerate() {
        let mut start = run.start;
        while start + WINDOW <= run.end {
            let power = y.as_slice()[start..start + WINDOW]
                .iter()
                .map(|x| x * x)
                .sum::<f64>();
            windows.push((
                k,
                start,
                (start - run.start) / (WINDOW / 2),
                power / WINDOW as f64,
            ));
            start += WINDOW / 2;
        }
    }
    let nothing = Lack::nothing();
    if windows.len() < 20 {
        return nothing;
    }
    // The same stretch in all runs: its lower quartile, never below the campaign's.
    let calm = |of: &mut Vec<f64>| -> f64 {
        of.sort_by(f64::total_cmp);
        of[of.len() / 4]
    };
    let mut all: Vec<f64> = windows.iter().map(|w| w.3).collect();
    let typical = calm(&mut all);
    let ratios: Vec<f64> = windows
        .iter()
        .map(|w| {
            let mut same: Vec<f64> = windows.iter().filter(|o| o.2 == w.2).map(|o| o.3).collect();
            let own = if same.len() >= 4 {
                calm(&mut same)
            } else {
                typical
            };
            w.3 / own.max(typical)
        })
        .collect();
    // Spread of the logarithms, robust (quartiles): heavy tails of the noise itself widen it.
    let mut logs: Vec<f64> = ratios.iter().map(|r| r.max(1e-12).ln()).collect();
    logs.sort_by(f64::total_cmp);
    let quartile = |q: f64| logs[((logs.len() - 1) as f64 * q) as usize];
    let spread = ((quartile(0.75) - quartile(0.25)) / 1.349).max((2.0 / WINDOW as f64).sqrt());
    let best = (0..windows.len())
        .max_by(|&a, &b| ratios[a].total_cmp(&ratios[b]))
        .unwrap_or(0);
    // Logarithms of mean squares are nearly normal; their upper tail is a little heavier than that.
    let z = (ratios[best].max(1e-12).ln() - quartile(0.5)) / (1.5 * spread);
    let log_p = log_chi2_tail(z.max(0.0).powi(2), 1) - 2.0_f64.ln() + (windows.len() as f64).ln();
    let (k, start, _, power) = windows[best];
    let end = start + WINDOW - 1;
    Lack {
        log_p: log_p.min(0.0),
        place: Some(in_run(samples, names, k, start, end)),
        excess: ((power - 1.0) * WINDOW as f64).max(0.0),
    }
}

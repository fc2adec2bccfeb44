//! Short bursts of unrest in single runs, such as stick-slip that comes and goes.

use crate::answer::Place;
use crate::general::Lack;
use crate::ground::Ground;
use crate::samples::Samples;
use crate::tail::log_chi2_tail;

/// Short bursts: stretches of whitened residual whose mean square is above what the same stretch shows in the calmest quarter
/// of the runs (a burst may come back in every other run), and above what the campaign's own tails allow.
pub(crate) fn bursts(ground: &Ground, samples: &Samples, names: &[String]) -> Lack {
    const WINDOW: usize = 40;
    let y = ground.y.rows(0, samples.len()).into_owned();
    let n = y.len() as f64;
    let mean = y.norm_squared() / n;
    // Run, first sample, place in the run, mean square.
    let mut windows: Vec<(usize, usize, usize, f64)> = Vec::new();
    for (k, run) in samples.runs.iter().enumerate() {
        let mut start = run.start;
        while start + WINDOW <= run.end {
            let power = y.as_slice()[start..start + WINDOW]
                .iter()
                .map(|x| x * x / mean)
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
        place: Some(Place {
            axis: "time".into(),
            from: samples.time[start],
            to: samples.time[end],
            unit: "s".into(),
            runs: vec![names[k].clone()],
        }),
        excess: ((power - 1.0) * WINDOW as f64).max(0.0),
    }
}

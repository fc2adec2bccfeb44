//! Errors of held-out runs, and the gain that they show, (D4) or (D8).
//!
//! The noise in the squared errors is not the repeats' but what these runs happened to draw. Where that may move (D4) by more
//! than a few hundredths, the share is that of errors weighed by the noise (`weighed.rs`); where they do not tell it either, none
//! is stated.

use crate::answer::Gain;
use crate::bench::Bench;
use crate::floor;
use crate::fold::Fold;
use crate::intervals::student;
use crate::weighed::Weighed;

/// Squared errors of held-out runs.
pub(crate) struct Errors {
    /// Sum of squares and samples of each held-out run.
    runs: Vec<(f64, f64)>,
    /// The same sums weighed by the noise and the fold's own doubt (D11), where they are known.
    weighed: Vec<f64>,
}

impl Errors {
    pub(crate) fn pool(
        bench: &Bench<'_>,
        weighed: Option<&Weighed<'_>>,
        folds: &[Fold],
        prediction: &dyn Fn(&Fold) -> &[f64],
    ) -> Self {
        let runs = folds
            .iter()
            .flat_map(|f| {
                let predicted = prediction(f);
                let held = f.held.iter();
                held.map(move |&k| floor::squares(bench, predicted, Some(&[k])))
            })
            .filter(|(_, n)| *n > 0.0)
            .collect();
        let by_noise = |w: &Weighed<'_>| {
            let each = folds.iter().enumerate();
            each.flat_map(|(k, f)| w.errors(k, f, prediction(f)))
                .collect()
        };
        Self {
            runs,
            weighed: weighed.map(by_noise).unwrap_or_default(),
        }
    }

    fn total(&self) -> f64 {
        self.runs.iter().map(|r| r.0).sum()
    }

    /// By what gains are compared: the errors weighed by the noise and the fold's doubt where these are known.
    pub(crate) fn judged(&self) -> f64 {
        if self.weighed.is_empty() {
            self.total()
        } else {
            self.weighed.iter().sum()
        }
    }

    fn count(&self) -> f64 {
        self.runs.iter().map(|r| r.1).sum::<f64>().max(1.0)
    }

    pub(crate) fn rmse(&self) -> f64 {
        (self.total() / self.count()).sqrt()
    }
}

/// Half the 95 % interval of a sum over runs (Student's t); `None` of one run.
fn paired_half(differences: &[f64]) -> Option<f64> {
    let n = differences.len() as f64;
    let mean = differences.iter().sum::<f64>() / n;
    let squares: f64 = differences.iter().map(|d| (d - mean).powi(2)).sum();
    // Standard error of the sum: sqrt(n) times that of one difference.
    (n > 1.0).then(|| student(n - 1.0) * (n * squares / (n - 1.0)).sqrt())
}

/// Share of the denominator of (D4) by which a floor from repeats may be wrong.
const KNOWN_TO: f64 = 0.03;

/// What gains are judged by.
pub(crate) struct Judged<'a> {
    /// Drops that the scrambled extensions bring.
    pub(crate) placebo: Vec<f64>,
    pub(crate) floor_rmse: f64,
    /// Sum of squares by which that floor may be wrong.
    pub(crate) beside_floor: f64,
    pub(crate) weighed: Option<Weighed<'a>>,
}

impl Judged<'_> {
    pub(crate) fn gain(&self, before: &Errors, after: &Errors) -> Gain {
        let dropped = before.judged() - after.judged();
        let share = self
            .share_above_floor(before, after)
            .or_else(|| self.share_weighed(before, after));
        let beaten = self.placebo.iter().filter(|p| dropped > **p).count();
        let placebos = self.placebo.len();
        Gain {
            held_out_rmse_before: before.rmse(),
            held_out_rmse_after: after.rmse(),
            explained_fraction: share.map(|(share, _)| share),
            ci95: share.and_then(|(share, half)| half.map(|half| [share - half, share + half])),
            placebo_exceeded: (placebos > 0).then(|| beaten as f64 / placebos as f64),
        }
    }

    /// (D4) and half its interval's width; `None` where its denominator is within its uncertainty. A share is the ratio of two sums over
    /// runs, d of e: it is as uncertain as the sum of d - share e, however differently large the effect is in the runs.
    fn share_above_floor(&self, before: &Errors, after: &Errors) -> Option<(f64, Option<f64>)> {
        let floor = before.count() * self.floor_rmse.powi(2);
        let explainable = before.total() - floor;
        // What the extension leaves is the noise that was drawn, and little else. Less than the floor it cannot leave but where that is too high, as
        // that of repeats that differ by what was found.
        let left = after.total() - floor;
        let unknown = if left < 0.0 {
            -left
        } else {
            left.min(self.beside_floor)
        };
        if !(explainable > 0.0 && unknown < KNOWN_TO * explainable) {
            return None;
        }
        let pairs = before.runs.iter().zip(&after.runs);
        let differences: Vec<f64> = pairs.map(|(b, a)| b.0 - a.0).collect();
        let share = differences.iter().sum::<f64>() / explainable;
        let beside = before
            .runs
            .iter()
            .zip(&differences)
            .map(|((square, n), d)| d - share * (square - n * self.floor_rmse.powi(2)));
        let half = paired_half(&beside.collect::<Vec<f64>>());
        Some((share, half.map(|h| h.hypot(share * unknown) / explainable)))
    }

    /// (D8) and half its interval's width, from d share/dD = A/(D + A)^2 and d share/dA = -D/(D + A)^2.
    fn share_weighed(&self, before: &Errors, after: &Errors) -> Option<(f64, Option<f64>)> {
        let Weighed { own, wrong, .. } = *self.weighed.as_ref()?;
        let pairs = before.weighed.iter().zip(&after.weighed);
        let differences: Vec<f64> = pairs.map(|(b, a)| b - a).collect();
        let dropped: f64 = differences.iter().sum();
        let explainable = dropped + own;
        if !(dropped > 0.0 && explainable > wrong * own) {
            return None;
        }
        let half = paired_half(&differences);
        let half = half.map(|h| own * h.hypot(dropped * wrong) / explainable.powi(2));
        Some((dropped / explainable, half))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn errors(runs: &[f64]) -> Errors {
        Errors {
            runs: runs.iter().map(|&square| (square, 100.0)).collect(),
            weighed: Vec::new(),
        }
    }

    /// Repeats that differ by what was found (wear, in blocked order) make a floor above what the extension leaves: of it no share is stated.
    #[test]
    fn a_floor_above_what_is_left_states_no_share() {
        let judged = Judged {
            placebo: Vec::new(),
            floor_rmse: 0.1,
            beside_floor: 0.0,
            weighed: None,
        };
        let before = errors(&[3.0, 3.0, 3.0]);
        let share = |left: f64| judged.gain(&before, &errors(&[left; 3])).explained_fraction;
        assert_eq!(share(0.5), None);
        assert!(share(1.0).is_some_and(|share| (share - 1.0).abs() < 1e-12));
    }

    /// A share that every run shows is known however large the error is in each; one that differs from run to run is not.
    #[test]
    fn a_share_that_all_runs_agree_on_is_certain() {
        let judged = Judged {
            placebo: Vec::new(),
            floor_rmse: 0.0,
            beside_floor: 0.0,
            weighed: None,
        };
        let before = errors(&[1.0, 4.0, 9.0, 2.0]);
        let half = |after: &[f64]| {
            let gain = judged.gain(&before, &errors(after));
            let [low, high] = gain.ci95.expect("four runs");
            (
                gain.explained_fraction.expect("no floor"),
                0.5 * (high - low),
            )
        };
        let (share, agreed) = half(&[0.1, 0.4, 0.9, 0.2]);
        assert!(
            (share - 0.9).abs() < 1e-12 && agreed < 1e-12,
            "{share} {agreed}"
        );
        // The same sums, one run hiding what another shows: residuals of 2 and -2 on 16, Student's t of three degrees of freedom.
        let (same, unlike) = half(&[0.1, 2.4, -1.1, 0.2]);
        let expected = student(3.0) * (4.0_f64 / 3.0 * 8.0).sqrt() / 16.0;
        assert!(
            (same - 0.9).abs() < 1e-12 && (unlike - expected).abs() < 1e-12,
            "{unlike}"
        );
    }
}

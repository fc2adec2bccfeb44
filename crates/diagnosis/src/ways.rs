//! What a recorded position says of the velocity channel.
//!
//! Where the velocity is filtered and the position is not, the stage goes further from one sample to the next than the recorded speeds
//! tell:
//!
//! ```text
//! r_i = x_{i+1} - x_i - h (v_i + v_{i+1}) / 2 = l (v_{i+1} - v_i)                                      (P1)
//! ```
//!
//! with l how late the velocity is, s. The size of what is left of r is not known; taken at its likeliest, -2 log likelihood is
//! n ln sum_i (r_i - l dv_i)^2. Only what speaks for a filter counts: a position that goes with the recorded speeds may be their sum (by
//! trapezia r = 0, by the speed at the end of each way l = h / 2, and then nothing is said). Every lag that leaves little counts alike,
//! as stages are no better than that at going along chords.

use rig::{Experiment, Reach, RunMotion, Station};

use crate::bench::{Bench, Fitted};

/// Share of r squared that a lag may leave: what leaves more has another reason, what leaves less is as good.
const LEFT: f64 = 0.25;

/// Positions are sums of the speeds at the ends of ways where l = h / 2 leaves no more than so many times what the best lag leaves.
const SUMMED: f64 = 2.0;

/// The sums of (P1) over a campaign: of r^2, r dv and dv^2, of (r - h dv / 2)^2, and how many ways there are.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Ways {
    rr: f64,
    rd: f64,
    dd: f64,
    beside_sums: f64,
    count: f64,
}

impl Ways {
    /// Of all runs; a run without a recorded position has r = 0.
    pub(crate) fn of(experiment: &Experiment) -> Self {
        let mut ways = Self::default();
        experiment.runs.iter().for_each(|run| ways.add(run));
        ways
    }

    fn add(&mut self, run: &RunMotion) {
        let (t, v, x) = (&run.time_s, &run.velocity_m_s, &run.position_m);
        let chord = |i: usize| 0.5 * (v[i] + v[i + 1]) * (t[i + 1] - t[i]);
        let intervals = 0..t.len().saturating_sub(1);
        let along: f64 = intervals
            .clone()
            .map(|i| (x[i + 1] - x[i]) * chord(i))
            .sum();
        for i in intervals {
            let r = along.signum() * (x[i + 1] - x[i]) - chord(i);
            self.add_way(r, v[i + 1] - v[i], t[i + 1] - t[i]);
        }
    }

    fn add_way(&mut self, r: f64, dv: f64, h: f64) {
        self.rr += r * r;
        self.rd += r * dv;
        self.dd += dv * dv;
        self.beside_sums += (r - 0.5 * h * dv).powi(2);
        self.count += 1.0;
    }

    /// -2 log likelihood of the positions where the velocity is late by so much (s), less that where it is not late: of [`LEFT`], or zero
    /// where more than that is left.
    pub(crate) fn deviance(&self, late_s: f64) -> f64 {
        let left = self.rr - 2.0 * late_s * self.rd + late_s * late_s * self.dd;
        let best = self.rr - self.rd * self.rd / self.dd;
        let summed = self.beside_sums <= SUMMED * best.max(f64::EPSILON * self.rr);
        if left < LEFT * self.rr && !summed {
            self.count * LEFT.ln()
        } else {
            0.0
        }
    }
}

/// [`Ways::deviance`] of a fitted model.
pub(crate) fn deviance_of_positions(bench: &Bench<'_>, fitted: &Fitted) -> f64 {
    bench.ways.deviance(velocity_late_s(bench, fitted))
}

/// How late the velocity channel of a fitted model is, s.
fn velocity_late_s(bench: &Bench<'_>, fitted: &Fitted) -> f64 {
    let effects = fitted.effects.iter().enumerate();
    effects
        .map(|(k, &effect)| (&bench.catalogue[effect], fitted.model.span(k)))
        .filter(|(cause, _)| cause.station() == Station::Sensor && cause.reach() == Reach::Stage)
        .map(|(cause, span)| -cause.lateness_s(&fitted.parameters[span]))
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A stage that speeds up and slows down, its velocity read through a filter of `lag_s`, its position to `step_m`.
    fn stage(lag_s: f64, step_m: f64) -> Ways {
        let (h, turn) = (0.01, std::f64::consts::TAU);
        let mut ways = Ways::default();
        // v = 1 + sin(turn t) behind a filter, once it has settled: 1 + (sin - lag turn cos) / (1 + (lag turn)^2).
        let w = lag_s * turn;
        let speed = |t: f64| 1.0 + ((turn * t).sin() - w * (turn * t).cos()) / (1.0 + w * w);
        let place = |t: f64| ((t + (1.0 - (turn * t).cos()) / turn) / step_m).round() * step_m;
        for i in 0..300 {
            let (a, b) = (h * f64::from(i), h * f64::from(i + 1));
            let r = place(b) - place(a) - 0.5 * h * (speed(a) + speed(b));
            ways.add_way(r, speed(b) - speed(a), h);
        }
        ways
    }

    #[test]
    fn a_filtered_velocity_shows_in_the_position() {
        let ways = stage(3e-3, 1e-7);
        assert!(ways.deviance(3e-3) < -300.0, "{}", ways.deviance(3e-3));
        assert_eq!(ways.deviance(2.5e-3), ways.deviance(3e-3));
        // Nor is every lag shown because one is.
        assert_eq!(ways.deviance(8e-3), 0.0);
        assert_eq!(ways.deviance(-3e-3), 0.0);
    }

    #[test]
    fn what_goes_with_the_speeds_or_is_too_coarse_says_nothing() {
        for late_s in [0.0, 3e-4, 3e-3, 3e-2] {
            assert_eq!(stage(0.0, 1e-7).deviance(late_s), 0.0);
            assert_eq!(stage(3e-3, 1e-3).deviance(late_s), 0.0);
            assert_eq!(Ways::default().deviance(late_s), 0.0);
        }
    }

    /// Positions that were summed from the recorded speeds as x += v h.
    #[test]
    fn a_sum_of_the_speeds_is_no_lag() {
        let h = 0.01;
        let speed = |i: i32| (h * f64::from(i)).sin();
        for step_m in [1e-12, 1e-7, 1e-5] {
            let mut ways = Ways::default();
            for i in 0..300 {
                let way = (h * speed(i + 1) / step_m).round() * step_m;
                let chord = 0.5 * h * (speed(i) + speed(i + 1));
                ways.add_way(way - chord, speed(i + 1) - speed(i), h);
            }
            assert_eq!(ways.deviance(0.5 * h), 0.0);
        }
    }
}

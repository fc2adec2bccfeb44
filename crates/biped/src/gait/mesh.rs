//! The intervals of the collocation: even ones, or short where a compliant foot strikes.
//!
//! A foot that lands at several metres per second is stopped within some 3 ms; what it does for the rest of a stance of up to
//! 100 ms is slow. With u the part of a stance's intervals that has passed, the part of its time that has is
//!
//! phi(u) = a u + (1 - a) u^2,   a = 1/5,
//!
//! so that the first intervals are a fifth as long as even ones and the last 9/5. Halving all intervals keeps every boundary.

use super::layout::Place;
use super::{Problem, STANDING};
use serde::{Deserialize, Serialize};

/// How the intervals of a stance share its time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Grading {
    /// Evenly.
    Even,
    /// Short where the stance begins.
    Strike,
}

/// Slope of phi at the start of a stance.
const FIRST: f64 = 0.2;

/// Collocation intervals of a stance and of a flight.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Mesh {
    /// Intervals of a stance.
    pub stance: usize,
    /// Intervals of a flight, which are even.
    pub flight: usize,
    /// How those of a stance share its time.
    pub grading: Grading,
}

impl Default for Mesh {
    fn default() -> Self {
        Self::even(8, 5)
    }
}

impl Mesh {
    /// Even intervals.
    pub const fn even(stance: usize, flight: usize) -> Self {
        let grading = Grading::Even;
        Self {
            stance,
            flight,
            grading,
        }
    }

    /// Short intervals where a stance begins.
    pub const fn for_strikes(stance: usize, flight: usize) -> Self {
        let grading = Grading::Strike;
        Self {
            stance,
            flight,
            grading,
        }
    }

    /// The same with so many times the intervals.
    #[must_use]
    pub const fn times(self, factor: usize) -> Self {
        Self {
            stance: factor * self.stance,
            flight: factor * self.flight,
            ..self
        }
    }

    /// Intervals of a phase.
    pub fn intervals(&self, phase: usize) -> usize {
        if STANDING[phase].is_some() {
            self.stance
        } else {
            self.flight
        }
    }

    /// phi: the part of a phase's time that has passed where an interval begins.
    pub fn begin(&self, phase: usize, interval: usize) -> f64 {
        let u = interval as f64 / self.intervals(phase) as f64;
        match self.grading {
            Grading::Strike if STANDING[phase].is_some() => u * (FIRST + (1.0 - FIRST) * u),
            _ => u,
        }
    }

    /// Length of an interval in parts of its phase's time.
    pub fn length(&self, phase: usize, interval: usize) -> f64 {
        match self.grading {
            Grading::Strike => self.begin(phase, interval + 1) - self.begin(phase, interval),
            Grading::Even => 1.0 / self.intervals(phase) as f64,
        }
    }

    /// The part of its phase's time that has passed at a point.
    pub fn passed(&self, place: Place) -> f64 {
        let within = Problem::RADAU_C[place.stage] * self.length(place.phase, place.interval);
        self.begin(place.phase, place.interval) + within
    }

    /// Length of an interval over the mean one of its phase.
    pub fn relative_length(&self, phase: usize, interval: usize) -> f64 {
        match self.grading {
            Grading::Strike => self.intervals(phase) as f64 * self.length(phase, interval),
            Grading::Even => 1.0,
        }
    }

    /// The interval within which a part of a phase's time passes, and how much of the interval has, in (0, 1].
    pub(super) fn locate(&self, phase: usize, passed: f64) -> (usize, f64) {
        // Rounding must not put the end of an interval into the next one, where a line would be extrapolated.
        let last = self.intervals(phase) - 1;
        let interval = (0..last)
            .find(|&i| passed < self.begin(phase, i + 1) + 1e-12)
            .unwrap_or(last);
        let part = (passed - self.begin(phase, interval)) / self.length(phase, interval);
        (interval, part)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_fill_their_phase_and_halving_keeps_their_ends() {
        for mesh in [Mesh::even(8, 5), Mesh::for_strikes(28, 8)] {
            for phase in 0..4 {
                let n = mesh.intervals(phase);
                let whole: f64 = (0..n).map(|i| mesh.relative_length(phase, i)).sum();
                assert!((whole / n as f64 - 1.0).abs() < 1e-14);
                for i in 0..=n {
                    let halved = mesh.times(2).begin(phase, 2 * i);
                    assert!((halved - mesh.begin(phase, i)).abs() < 1e-15);
                }
            }
        }
        let strike = Mesh::for_strikes(28, 8);
        assert!(strike.relative_length(0, 0) < 0.25 && strike.relative_length(1, 0) == 1.0);
    }

    #[test]
    fn a_moment_lies_in_the_interval_that_it_passes_in() {
        let mesh = Mesh::for_strikes(28, 8);
        for (interval, part) in [(0, 1.0), (3, 0.4), (27, 1.0)] {
            let passed = mesh.begin(2, interval) + part * mesh.length(2, interval);
            let (found, within) = mesh.locate(2, passed);
            assert_eq!(found, interval);
            assert!((within - part).abs() < 1e-9);
        }
    }
}

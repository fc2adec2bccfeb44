//! Axes: limits from data, ticks at round numbers, linear and logarithmic, for plotters.

use std::ops::Range;

use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint, Ranged};

use super::super::Scale;
use crate::number;

/// One axis of a drawing: maps numbers to canvas units and knows its ticks.
#[derive(Clone, Debug)]
pub(super) struct Ruler {
    low: f64,
    high: f64,
    scale: Scale,
    ticks: Vec<(f64, String)>,
}

impl Ruler {
    /// An axis over `limits`; about `wanted` ticks.
    pub(super) fn new([low, high]: [f64; 2], scale: Scale, wanted: usize) -> Self {
        let ticks = match scale {
            Scale::Linear => linear_ticks(low, high, wanted),
            Scale::Log => log_ticks(low, high, wanted),
        };
        Self {
            low,
            high,
            scale,
            ticks,
        }
    }

    /// An axis of categories: the middle of category k lies at k.
    pub(super) fn categories(names: &[String]) -> Self {
        #[allow(clippy::cast_precision_loss)] // a handful of categories
        let count = names.len() as f64;
        let mut middle = -1.0;
        Self {
            low: -0.5,
            high: count - 0.5,
            scale: Scale::Linear,
            ticks: names
                .iter()
                .map(|name| {
                    middle += 1.0;
                    (middle, name.clone())
                })
                .collect(),
        }
    }

    pub(super) fn limits(&self) -> [f64; 2] {
        [self.low, self.high]
    }

    /// The label of a tick.
    pub(super) fn label(&self, at: f64) -> String {
        self.ticks
            .iter()
            .find(|(tick, _)| tick.total_cmp(&at).is_eq())
            .map(|(_, label)| label.clone())
            .unwrap_or_default()
    }

    pub(super) fn ticks(&self) -> &[(f64, String)] {
        &self.ticks
    }

    /// Whether the axis can show this number.
    pub(super) fn shows(&self, number: f64) -> bool {
        number.is_finite() && (self.scale == Scale::Linear || number > 0.0)
    }

    /// The number on the even scale of the page: itself, or its logarithm.
    pub(super) fn even(&self, number: f64) -> f64 {
        match self.scale {
            Scale::Linear => number,
            Scale::Log => number.log10(),
        }
    }
}

impl Ranged for Ruler {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (from, to): (i32, i32)) -> i32 {
        let (low, high) = (self.even(self.low), self.even(self.high));
        let share = (self.even(*value) - low) / (high - low);
        let place = f64::from(from) + share * f64::from(to - from);
        #[allow(clippy::cast_possible_truncation)] // saturates far outside the drawing
        let place = place.round() as i32;
        place.clamp(-1_000_000, 1_000_000)
    }

    fn key_points<Hint: KeyPointHint>(&self, _hint: Hint) -> Vec<f64> {
        self.ticks.iter().map(|(tick, _)| *tick).collect()
    }

    fn range(&self) -> Range<f64> {
        self.low..self.high
    }
}

/// A round step (1, 2, 2.5 or 5 times a power of ten) that gives about `wanted` intervals.
fn round_step(span: f64, wanted: usize) -> f64 {
    #[allow(clippy::cast_precision_loss)] // a handful of ticks
    let raw = span / wanted.max(1) as f64;
    let power = 10f64.powf(raw.log10().floor());
    let factor = raw / power;
    let round = if factor < 1.5 {
        1.0
    } else if factor < 2.25 {
        2.0
    } else if factor < 3.5 {
        2.5
    } else if factor < 7.5 {
        5.0
    } else {
        10.0
    };
    round * power
}

fn linear_ticks(low: f64, high: f64, wanted: usize) -> Vec<(f64, String)> {
    let step = round_step(high - low, wanted);
    let decimals = (0..12)
        .find(|&decimals| {
            let scaled = step * 10f64.powi(decimals);
            (scaled - scaled.round()).abs() < 1e-6 * scaled
        })
        .unwrap_or(12);
    let large = low.abs().max(high.abs());
    let as_power = !(1e-4..1e6).contains(&large);
    let first = (low / step - 1e-9).ceil();
    let mut ticks = Vec::new();
    let mut index = first;
    while index * step <= high + 1e-9 * step && ticks.len() < 40 {
        let at = index * step;
        let label = if as_power && at != 0.0 {
            number::significant(at, 2)
        } else {
            number::fixed(at, usize::try_from(decimals).unwrap_or(0))
        };
        ticks.push((at, label));
        index += 1.0;
    }
    ticks
}

fn log_ticks(low: f64, high: f64, wanted: usize) -> Vec<(f64, String)> {
    let (from, to) = (low.log10(), high.log10());
    if to - from < 1.0 {
        return linear_ticks(low, high, wanted);
    }
    #[allow(clippy::cast_precision_loss)] // a handful of ticks
    let stride = ((to - from) / wanted.max(1) as f64).ceil().max(1.0);
    let mut ticks = Vec::new();
    let mut decade = (from - 1e-9).ceil();
    while decade <= to + 1e-9 && ticks.len() < 40 {
        let at = 10f64.powf(decade);
        let label = if (-3.0..4.0).contains(&decade) {
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // at most three
            let decimals = (-decade).max(0.0) as usize;
            number::fixed(at, decimals)
        } else {
            number::significant(at, 1)
                .trim_start_matches("1\u{2009}×\u{2009}")
                .to_string()
        };
        ticks.push((at, label));
        decade += stride;
    }
    ticks
}

/// Limits that hold all numbers with a small margin; `zero` keeps zero in view.
pub(super) fn limits_of(
    numbers: impl Iterator<Item = f64>,
    scale: Scale,
    zero: bool,
) -> Option<[f64; 2]> {
    let log = scale == Scale::Log;
    let (low, high) = numbers
        .filter(|number| number.is_finite() && (!log || *number > 0.0))
        .map(|number| if log { number.log10() } else { number })
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), number| {
            (low.min(number), high.max(number))
        });
    if low > high {
        return None;
    }
    let (low, high) = if zero && !log {
        (low.min(0.0), high.max(0.0))
    } else {
        (low, high)
    };
    let span = high - low;
    let margin = if span > 0.0 {
        0.04 * span
    } else if low == 0.0 {
        1.0
    } else {
        0.1 * low.abs()
    };
    let keep = |edge: f64, moved: f64| {
        if zero && !log && edge == 0.0 {
            0.0
        } else {
            moved
        }
    };
    let (low, high) = (keep(low, low - margin), keep(high, high + margin));
    Some(if log {
        [10f64.powf(low), 10f64.powf(high)]
    } else {
        [low, high]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(ruler: &Ruler) -> Vec<String> {
        ruler
            .ticks()
            .iter()
            .map(|(_, label)| label.clone())
            .collect()
    }

    #[test]
    fn ticks_are_round_and_zero_has_no_sign() {
        assert_eq!(
            labels(&Ruler::new([-0.5, 1.0], Scale::Linear, 6)),
            [
                "\u{2212}0.50",
                "\u{2212}0.25",
                "0.00",
                "0.25",
                "0.50",
                "0.75",
                "1.00"
            ]
        );
        assert_eq!(
            labels(&Ruler::new([0.0, 60.0], Scale::Linear, 6)),
            ["0", "10", "20", "30", "40", "50", "60"]
        );
        assert_eq!(
            labels(&Ruler::new([0.01, 10.0], Scale::Log, 6)),
            ["0.01", "0.1", "1", "10"]
        );
    }

    #[test]
    fn a_single_number_still_has_limits() {
        assert_eq!(
            limits_of([2.0].into_iter(), Scale::Linear, false),
            Some([1.8, 2.2])
        );
        assert_eq!(
            limits_of([0.0].into_iter(), Scale::Linear, false),
            Some([-1.0, 1.0])
        );
        assert_eq!(
            limits_of([f64::NAN].into_iter(), Scale::Linear, false),
            None
        );
        assert_eq!(limits_of([-1.0].into_iter(), Scale::Log, false), None);
    }
}

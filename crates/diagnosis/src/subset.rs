//! The runs that are looked at, and what the noise must know of them.

use std::ops::Range;

use fitting::noise::{Context, Ring};
use nalgebra::{DMatrix, DVector};

use crate::bench::{Bench, Fitted};
use crate::samples::Samples;

/// Runs that are looked at; the others keep their commands and hide their force.
#[derive(Clone)]
pub(crate) struct Subset {
    pub(crate) runs: Vec<usize>,
    /// Places of each run among the rows.
    ranges: Vec<Range<usize>>,
    rows: Vec<usize>,
    /// Weight of each row, where rows have weights.
    weight: Option<DVector<f64>>,
    whole: bool,
    /// How late samples tell of the plate, s (see [`crate::lateness`]).
    late_s: f64,
}

impl Subset {
    pub(crate) fn new(bench: &Bench<'_>, runs: Vec<usize>) -> Self {
        let mut rows: Vec<usize> = Vec::new();
        let mut ranges = Vec::new();
        let mut kept = Vec::new();
        for k in runs {
            let start = rows.len();
            rows.extend(bench.samples.runs[k].clone().filter(|&i| !bench.masked[i]));
            if rows.len() > start {
                ranges.push(start..rows.len());
                kept.push(k);
            }
        }
        let whole = rows.len() == bench.samples.len();
        let weights = || rows.iter().map(|&i| bench.samples.weight(i));
        let weight = (!bench.samples.averaged.is_empty())
            .then(|| DVector::from_iterator(rows.len(), weights()));
        Self {
            runs: kept,
            ranges,
            weight,
            rows,
            whole,
            late_s: 0.0,
        }
    }

    pub(crate) fn all(bench: &Bench<'_>) -> Self {
        Self::new(bench, (0..bench.samples.runs.len()).collect())
    }

    /// The same runs, whose samples tell of places on the plate so much later.
    pub(crate) fn late_by(&self, late_s: f64) -> Self {
        Self {
            late_s,
            ..self.clone()
        }
    }

    /// How late samples tell of the plate, s.
    pub(crate) fn lateness_s(&self) -> f64 {
        self.late_s
    }

    /// Whether samples are means over rows.
    pub(crate) fn is_averaged(&self) -> bool {
        self.weight.is_some()
    }

    /// Number of samples looked at.
    pub(crate) fn len(&self) -> usize {
        self.rows.len()
    }

    /// A stacked series at the rows that are looked at, times their weights.
    pub(crate) fn gather(&self, stacked: &[f64]) -> DVector<f64> {
        let mut own =
            DVector::from_iterator(self.rows.len(), self.rows.iter().map(|&i| stacked[i]));
        if let Some(weight) = &self.weight {
            own.component_mul_assign(weight);
        }
        own
    }

    /// The same of columns.
    pub(crate) fn gather_columns(&self, stacked: &DMatrix<f64>) -> DMatrix<f64> {
        let mut own = if self.whole {
            stacked.clone()
        } else {
            stacked.select_rows(&self.rows)
        };
        if let Some(weight) = &self.weight {
            for mut column in own.column_iter_mut() {
                column.component_mul_assign(weight);
            }
        }
        own
    }

    /// The noise's context of these runs.
    pub(crate) fn context(&self, bench: &Bench<'_>, scale: &[f64]) -> Context {
        let pick = |x: &[f64]| self.rows.iter().map(|&i| x[i]).collect::<Vec<f64>>();
        let (place, velocity) = (&bench.samples.place, &bench.samples.velocity);
        let seen = |&i: &usize| place[i] - self.late_s * velocity[i];
        Context {
            runs: self.ranges.clone(),
            sliding: pick(&bench.samples.sliding),
            place: self.rows.iter().map(seen).collect(),
            scale: self.gather(scale).as_slice().to_vec(),
            ring: Vec::new(),
            rows: bench.samples.averaged_at(&self.rows),
        }
    }

    /// The noise's context beside a fit: on a cord roughness reaches the record through the cord's resonance, which averaged
    /// samples do not show.
    pub(crate) fn context_of(&self, bench: &Bench<'_>, fitted: &Fitted) -> Context {
        let mut context = self.context(bench, fitted.friction(bench));
        if self.weight.is_some() {
            return context;
        }
        context.ring = self
            .runs
            .iter()
            .map(|&k| {
                let held = fitted
                    .model
                    .coupling(&bench.experiment, k, &fitted.parameters);
                let slope = fitted
                    .model
                    .steady_slope(&bench.experiment, k, &fitted.parameters);
                let run = &bench.experiment.runs[k];
                let span = run.time_s.last()? - run.time_s.first()?;
                let step = span / (run.len() - 1).max(1) as f64;
                Ring::new(
                    held.mass,
                    held.compliance,
                    held.damping + slope.max(0.0),
                    step,
                )
            })
            .collect();
        context
    }

    /// The samples of these runs.
    pub(crate) fn samples(&self, bench: &Bench<'_>) -> Samples {
        if self.whole {
            return bench.samples.clone();
        }
        bench.samples.select(&self.ranges, &self.rows)
    }
}

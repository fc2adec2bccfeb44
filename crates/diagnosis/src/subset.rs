//! The runs that are looked at, and what the noise must know of them.

use std::f64::consts::TAU;
use std::ops::Range;
use std::sync::Arc;

use fitting::noise::{Channel, Context, Lag, Ring, Spring};
use nalgebra::{DMatrix, DVector};

use crate::bench::{Bench, Fitted};
use crate::lateness::Lateness;
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
    /// How late samples tell of the plate.
    late: Lateness,
    /// Whether the plate turns: after a revolution the same place comes round again.
    turns: bool,
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
            late: Lateness::default(),
            turns: false,
        }
    }

    pub(crate) fn all(bench: &Bench<'_>) -> Self {
        Self::new(bench, (0..bench.samples.runs.len()).collect())
    }

    /// The same runs, whose samples tell of places on the plate so much later.
    pub(crate) fn late_by(&self, late: Lateness) -> Self {
        Self {
            late,
            ..self.clone()
        }
    }

    /// Some of these runs alone, on the same plate.
    pub(crate) fn only(&self, bench: &Bench<'_>, runs: Vec<usize>) -> Self {
        Self {
            late: self.late,
            turns: self.turns,
            ..Self::new(bench, runs)
        }
    }

    /// How late samples tell of the plate.
    pub(crate) fn lateness(&self) -> Lateness {
        self.late
    }

    /// The same runs on a plate that turns, or does not ([`Self::can_turn`]).
    pub(crate) fn turning(&self, turns: bool) -> Self {
        Self {
            turns,
            ..self.clone()
        }
    }

    /// Whether the plate turns.
    pub(crate) fn turns(&self) -> bool {
        self.turns
    }

    /// Whether the runs take a rotary rig round more than once, so that a disc and a plate without end are two things.
    pub(crate) fn can_turn(&self, bench: &Bench<'_>) -> bool {
        bench.experiment.axis == campaign::Axis::Rotary && {
            let (lo, hi) = bench.samples.extent();
            hi - lo > TAU
        }
    }

    /// Where on the plate a coordinate lies.
    fn on_the_plate(&self, bench: &Bench<'_>, places: &mut [f64]) {
        if self.turns {
            let origin = bench.samples.extent().0;
            places
                .iter_mut()
                .for_each(|x| *x = origin + (*x - origin).rem_euclid(TAU));
        }
    }

    /// Places on the plate of all samples of the record.
    pub(crate) fn all_places(&self, bench: &Bench<'_>) -> Vec<f64> {
        let mut places = bench.samples.place.clone();
        self.on_the_plate(bench, &mut places);
        places
    }

    /// Whether samples are means over rows.
    pub(crate) fn is_averaged(&self) -> bool {
        self.weight.is_some()
    }

    /// Places of a run among the rows; none where it is not looked at.
    pub(crate) fn rows_of(&self, run: usize) -> Range<usize> {
        let place = self.runs.iter().position(|&own| own == run);
        place.map_or(0..0, |place| self.ranges[place].clone())
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
        let steps_s = self.steps_s(bench);
        let seen = |(&i, &step): (&usize, &f64)| place[i] - self.late.at_s(step) * velocity[i];
        let mut places: Vec<f64> = self.rows.iter().zip(&steps_s).map(seen).collect();
        self.on_the_plate(bench, &mut places);
        Context {
            runs: self.ranges.clone(),
            conditions: self.conditions(bench),
            sliding: pick(&bench.samples.sliding),
            place: places,
            scale: self.gather(scale).as_slice().to_vec(),
            channel: Arc::new(Channel {
                lag: Lag::new(steps_s.iter().copied(), self.late.lag_s),
                rings: Vec::new(),
            }),
            rows: bench.samples.averaged_at(&self.rows),
            steps_s,
        }
    }

    /// Condition of each run, counted anew.
    fn conditions(&self, bench: &Bench<'_>) -> Vec<usize> {
        let mut met: Vec<usize> = Vec::new();
        let own = self.runs.iter().map(|&run| bench.conditions[run]);
        own.map(|condition| {
            met.iter().position(|m| *m == condition).unwrap_or_else(|| {
                met.push(condition);
                met.len() - 1
            })
        })
        .collect()
    }

    /// Time since the sample before, s; zero at the first of a run.
    fn steps_s(&self, bench: &Bench<'_>) -> Vec<f64> {
        let time = |row: usize| bench.samples.time[self.rows[row]];
        let mut steps = vec![0.0; self.rows.len()];
        for run in &self.ranges {
            for row in run.start + 1..run.end {
                steps[row] = time(row) - time(row - 1);
            }
        }
        steps
    }

    /// The noise's context beside a fit: on a cord roughness reaches the record through the cord's resonance, which averaged
    /// samples do not show.
    pub(crate) fn context_of(&self, bench: &Bench<'_>, fitted: &Fitted) -> Context {
        let mut context = self.context(bench, fitted.friction(bench));
        let rings = self.rings(bench, fitted);
        for (run, ring) in &rings {
            for i in run.clone() {
                context.place[i] -= ring.left_s() * bench.samples.velocity[self.rows[i]];
            }
        }
        self.on_the_plate(bench, &mut context.place);
        Arc::make_mut(&mut context.channel).rings = rings;
        context
    }

    /// The resonances of a fit's runs; none where samples are averaged or roughness passes by them.
    pub(crate) fn rings(&self, bench: &Bench<'_>, fitted: &Fitted) -> Vec<(Range<usize>, Ring)> {
        if self.weight.is_some() || self.late.past_resonance {
            return Vec::new();
        }
        let runs = self.runs.iter().zip(&self.ranges);
        runs.filter_map(|(&k, run)| Some((run.clone(), ring_of(bench, fitted, k)?)))
            .collect()
    }

    /// The samples of these runs.
    pub(crate) fn samples(&self, bench: &Bench<'_>) -> Samples {
        if self.whole {
            return bench.samples.clone();
        }
        bench.samples.select(&self.ranges, &self.rows)
    }

    /// The same, each in its place on the plate: of a disc within one revolution.
    pub(crate) fn samples_on_the_plate(&self, bench: &Bench<'_>) -> Samples {
        let mut samples = self.samples(bench);
        self.on_the_plate(bench, &mut samples.place);
        samples
    }
}

/// The resonance of a run's specimen on its cord beside a fit.
fn ring_of(bench: &Bench<'_>, fitted: &Fitted, k: usize) -> Option<Ring> {
    let (experiment, parameters) = (&bench.experiment, &fitted.parameters);
    let held = fitted.model.coupling(experiment, k, parameters);
    let friction_n_s_m = fitted.model.contact_damping(experiment, k, parameters);
    let run = &experiment.runs[k];
    let span = run.time_s.last()? - run.time_s.first()?;
    let spring = Spring {
        mass_kg: held.mass,
        compliance_m_n: held.compliance_at(level_n(bench, fitted, k)),
        damping_n_s_m: held.damping,
        friction_n_s_m,
    };
    Ring::new(&spring, span / (run.len() - 1).max(1) as f64)
}

/// Root mean square of the predicted force in a run, N: the tension about which the specimen swings.
fn level_n(bench: &Bench<'_>, fitted: &Fitted, k: usize) -> f64 {
    let run = &fitted.prediction[bench.samples.runs[k].clone()];
    let squares: f64 = run.iter().map(|force| force * force).sum();
    (squares / run.len().max(1) as f64).sqrt()
}

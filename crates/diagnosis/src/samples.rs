//! What is known of each sample before any law is fitted: stacked plain numbers.

use std::ops::Range;

use campaign::{Campaign, Direction};
use fitting::noise::Averaged;

use crate::answer::Place;

/// Loads closer than this share of the larger are one.
const SAME_LOAD: f64 = 0.05;

/// The different loads of a campaign.
pub(crate) struct Levels {
    /// The loads, N, in ascending order.
    pub(crate) levels: Vec<f64>,
    /// For each run its place among them.
    pub(crate) of_run: Vec<usize>,
}

/// Stacked samples of all runs of a campaign, in the campaign's canonical order.
#[derive(Clone, Debug)]
pub(crate) struct Samples {
    /// Samples of each run.
    pub(crate) runs: Vec<Range<usize>>,
    /// Run of each sample.
    pub(crate) owner: Vec<usize>,
    /// Time since the start of the run, s.
    pub(crate) time: Vec<f64>,
    /// Time since the first run began, s; that of the run where the day's clock is not recorded.
    pub(crate) clock: Vec<f64>,
    /// Velocity, m/s.
    pub(crate) velocity: Vec<f64>,
    /// Stage coordinate, m.
    pub(crate) place: Vec<f64>,
    /// Distance slid since the start of the run, m.
    pub(crate) sliding: Vec<f64>,
    /// Normal load, N, or 1 where there is none.
    pub(crate) load: Vec<f64>,
    /// +1 in forward motion, -1 in reverse; at rest by the run's direction.
    heading: Vec<f64>,
    /// Recorded force, N.
    pub(crate) force: Vec<f64>,
    /// Temperature, degrees Celsius, where every run records it.
    pub(crate) temperature: Option<Vec<f64>>,
    /// Whether every run has a load (then results are coefficients).
    pub(crate) loaded: bool,
    /// Speed below which the law does not say how large friction is, m/s: zero where it always does.
    pub(crate) least_speed_m_s: f64,
    /// What each row is the mean of, where rows stand for several samples; else empty.
    pub(crate) averaged: Vec<Averaged>,
}

impl Samples {
    /// Some runs as a place: all of their time. `names`: of every run.
    pub(crate) fn place_of_runs(&self, runs: &[usize], names: &[String]) -> Place {
        let ends = runs.iter().map(|&run| self.time[self.runs[run].end - 1]);
        Place {
            axis: "time".into(),
            from: 0.0,
            to: ends.fold(0.0, f64::max),
            unit: "s".into(),
            runs: runs.iter().map(|&run| names[run].clone()).collect(),
        }
    }

    /// The loads, by the mean of each run.
    pub(crate) fn load_levels(&self) -> Levels {
        let mean =
            |run: &Range<usize>| self.load[run.clone()].iter().sum::<f64>() / run.len() as f64;
        let loads: Vec<f64> = self.runs.iter().map(mean).collect();
        let mut levels = loads.clone();
        levels.sort_by(f64::total_cmp);
        levels.dedup_by(|b, a| *b - *a < SAME_LOAD * *b);
        let of = |load: &f64| levels.partition_point(|l| l <= load).max(1) - 1;
        let of_run = loads.iter().map(of).collect();
        Levels { levels, of_run }
    }

    pub(crate) fn new(campaign: &Campaign) -> Self {
        let loaded = campaign
            .runs
            .iter()
            .all(|r| r.normal_load_n.is_some() || r.normal_force_n.is_some());
        let mut out = Self {
            runs: Vec::new(),
            owner: Vec::new(),
            time: Vec::new(),
            clock: Vec::new(),
            velocity: Vec::new(),
            place: Vec::new(),
            sliding: Vec::new(),
            load: Vec::new(),
            heading: Vec::new(),
            force: Vec::new(),
            temperature: campaign
                .runs
                .iter()
                .all(|r| r.temperature_c.is_some())
                .then(Vec::new),
            loaded,
            least_speed_m_s: 0.0,
            averaged: Vec::new(),
        };
        let starts: Option<Vec<f64>> = campaign.runs.iter().map(|run| run.started_s).collect();
        let starts = starts.unwrap_or_else(|| vec![0.0; campaign.runs.len()]);
        let first = starts.iter().copied().fold(f64::INFINITY, f64::min);
        for (k, run) in campaign.runs.iter().enumerate() {
            let start = out.time.len();
            let n = run.time_s.len();
            let (mut place, mut slid) = (run.start_position_m, 0.0);
            for i in 0..n {
                if i > 0 {
                    // Trapezoid: the velocity record is taken as piecewise linear.
                    let step = run.time_s[i] - run.time_s[i - 1];
                    let (a, b) = (run.velocity_m_s[i - 1], run.velocity_m_s[i]);
                    place += 0.5 * step * (a + b);
                    slid += 0.5 * step * (a.abs() + b.abs());
                }
                out.owner.push(k);
                out.time.push(run.time_s[i] - run.time_s[0]);
                out.clock.push(starts[k] - first + run.time_s[i]);
                out.velocity.push(run.velocity_m_s[i]);
                out.place
                    .push(run.position_m.as_ref().map_or(place, |p| p[i]));
                out.sliding.push(slid);
                out.load
                    .push(match (&run.normal_force_n, run.normal_load_n) {
                        (Some(force), _) => force[i],
                        (None, Some(load)) if loaded => load,
                        _ => 1.0,
                    });
                let v = run.velocity_m_s[i];
                out.heading.push(if v != 0.0 {
                    v.signum()
                } else if run.direction == Direction::Reverse {
                    -1.0
                } else {
                    1.0
                });
                out.force.push(run.force_n[i]);
                if let (Some(all), Some(own)) = (&mut out.temperature, &run.temperature_c) {
                    all.push(own[i]);
                }
            }
            out.runs.push(start..out.time.len());
        }
        out
    }

    pub(crate) fn len(&self) -> usize {
        self.time.len()
    }

    /// Lowest and highest stage coordinate.
    pub(crate) fn extent(&self) -> (f64, f64) {
        let places = self.place.iter();
        places.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), &x| {
            (lo.min(x), hi.max(x))
        })
    }

    /// +1 in forward motion, -1 in reverse.
    pub(crate) fn heading(&self) -> &[f64] {
        &self.heading
    }

    /// Weight of a row: the root of the number of recorded samples that it stands for.
    pub(crate) fn weight(&self, row: usize) -> f64 {
        self.averaged.get(row).map_or(1.0, |row| row.samples.sqrt())
    }

    /// What the rows are means of; nothing where they are samples.
    pub(crate) fn averaged_at(&self, rows: &[usize]) -> Vec<Averaged> {
        match self.averaged.as_slice() {
            [] => Vec::new(),
            all => rows.iter().map(|&i| all[i]).collect(),
        }
    }

    /// The samples at these rows, whose runs take these places.
    pub(crate) fn select(&self, ranges: &[Range<usize>], rows: &[usize]) -> Self {
        let pick = |x: &[f64]| rows.iter().map(|&i| x[i]).collect::<Vec<f64>>();
        let mut owner = Vec::with_capacity(rows.len());
        for (place, range) in ranges.iter().enumerate() {
            owner.extend(std::iter::repeat_n(place, range.len()));
        }
        Self {
            runs: ranges.to_vec(),
            owner,
            time: pick(&self.time),
            clock: pick(&self.clock),
            velocity: pick(&self.velocity),
            place: pick(&self.place),
            sliding: pick(&self.sliding),
            load: pick(&self.load),
            heading: pick(&self.heading),
            force: pick(&self.force),
            temperature: self.temperature.as_deref().map(pick),
            loaded: self.loaded,
            least_speed_m_s: self.least_speed_m_s,
            averaged: self.averaged_at(rows),
        }
    }
}

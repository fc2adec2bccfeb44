//! Frames: the campaign as one long table, and a summary of its conditions.

use polars::prelude::{Column, CsvWriter, DataFrame, PolarsError, PolarsResult, SerWriter};

use crate::description::{DIRECTIONS, PROTOCOLS};
use crate::record::{Campaign, Direction, Protocol, Run};

impl Campaign {
    /// All samples, one a row, runs in canonical order: `run` (index), `condition` (index), `direction`, `protocol`,
    /// `time_s`, `velocity`, `position`, `force`, `normal_force`, `temperature_c` (SI units; linear m, N; rotary rad, N m)
    /// and `mu` = force / normal load. Cells are null where nothing was recorded.
    ///
    /// # Errors
    /// None is expected: all columns have one length.
    pub fn frame(&self) -> PolarsResult<DataFrame> {
        let mut condition = vec![0_u32; self.runs.len()];
        for (number, runs) in self.conditions().iter().enumerate() {
            for run in runs {
                condition[*run] = index(number);
            }
        }
        let each = |value: &dyn Fn(usize, &Run) -> u32| -> Vec<u32> {
            let runs = self.runs.iter().enumerate();
            runs.flat_map(|(i, run)| std::iter::repeat_n(value(i, run), run.time_s.len()))
                .collect()
        };
        let words = |value: &dyn Fn(&Run) -> &'static str| -> Vec<&'static str> {
            self.runs
                .iter()
                .flat_map(|run| std::iter::repeat_n(value(run), run.time_s.len()))
                .collect()
        };
        let samples = |value: &dyn Fn(&Run) -> Vec<Option<f64>>| -> Vec<Option<f64>> {
            self.runs.iter().flat_map(value).collect()
        };
        let full = |column: &[f64]| column.iter().copied().map(Some).collect::<Vec<_>>();
        let partial = |column: Option<&Vec<f64>>, run: &Run| match column {
            Some(column) => full(column),
            None => vec![None; run.time_s.len()],
        };
        let columns = vec![
            Column::new("run".into(), each(&|i, _| index(i))),
            Column::new("condition".into(), each(&|i, _| condition[i])),
            Column::new(
                "direction".into(),
                words(&|run| direction_word(run.direction)),
            ),
            Column::new("protocol".into(), words(&|run| protocol_word(run.protocol))),
            Column::new("time_s".into(), samples(&|run| full(&run.time_s))),
            Column::new("velocity".into(), samples(&|run| full(&run.velocity_m_s))),
            Column::new(
                "position".into(),
                samples(&|run| partial(run.position_m.as_ref(), run)),
            ),
            Column::new("force".into(), samples(&|run| full(&run.force_n))),
            Column::new(
                "normal_force".into(),
                samples(&|run| partial(run.normal_force_n.as_ref(), run)),
            ),
            Column::new(
                "temperature_c".into(),
                samples(&|run| partial(run.temperature_c.as_ref(), run)),
            ),
            Column::new("mu".into(), samples(&|run| coefficient(run))),
        ];
        DataFrame::new(columns.first().map_or(0, Column::len), columns)
    }

    /// One row a condition: `condition`, `direction`, `protocol`, `repeats`, `samples`, `normal_load_n`, largest speed,
    /// mean of |force| over its samples, and the standard deviation between repeats of each run's mean |force|.
    ///
    /// # Errors
    /// None is expected.
    pub fn condition_summary(&self) -> PolarsResult<DataFrame> {
        let frame = self.frame()?;
        let conditions = self.conditions();
        let mut rows = Rows::default();
        for (number, runs) in conditions.iter().enumerate() {
            let first = &self.runs[runs[0]];
            let part = frame.filter(
                &frame
                    .column("condition")?
                    .u32()?
                    .iter()
                    .map(|found| found == Some(index(number)))
                    .collect(),
            )?;
            let force = part.column("force")?.f64()?;
            let velocity = part.column("velocity")?.f64()?;
            let magnitude = |value: Option<f64>| value.unwrap_or_default().abs();
            rows.condition.push(index(number));
            rows.direction.push(direction_word(first.direction));
            rows.protocol.push(protocol_word(first.protocol));
            rows.repeats.push(index(runs.len()));
            rows.samples.push(index(part.height()));
            rows.load.push(first.normal_load_n);
            rows.fastest
                .push(velocity.iter().map(magnitude).fold(0.0, f64::max));
            rows.mean.push(mean(force.iter().map(magnitude)));
            let means: Vec<f64> = runs
                .iter()
                .map(|run| mean(self.runs[*run].force_n.iter().map(|f| f.abs())))
                .collect();
            rows.scatter.push(deviation(&means));
        }
        rows.frame()
    }
}

/// Columns of the summary while they grow.
#[derive(Default)]
struct Rows {
    condition: Vec<u32>,
    direction: Vec<&'static str>,
    protocol: Vec<&'static str>,
    repeats: Vec<u32>,
    samples: Vec<u32>,
    load: Vec<Option<f64>>,
    fastest: Vec<f64>,
    mean: Vec<f64>,
    scatter: Vec<Option<f64>>,
}

impl Rows {
    fn frame(self) -> PolarsResult<DataFrame> {
        DataFrame::new(
            self.condition.len(),
            vec![
                Column::new("condition".into(), self.condition),
                Column::new("direction".into(), self.direction),
                Column::new("protocol".into(), self.protocol),
                Column::new("repeats".into(), self.repeats),
                Column::new("samples".into(), self.samples),
                Column::new("normal_load_n".into(), self.load),
                Column::new("largest_speed".into(), self.fastest),
                Column::new("mean_force".into(), self.mean),
                Column::new("sd_between_repeats".into(), self.scatter),
            ],
        )
    }
}

/// A frame as the text of a CSV file.
///
/// # Errors
/// Where a column has no text form.
pub fn csv(frame: &mut DataFrame) -> PolarsResult<String> {
    let mut bytes = Vec::new();
    CsvWriter::new(&mut bytes).finish(frame)?;
    String::from_utf8(bytes).map_err(|error| PolarsError::ComputeError(error.to_string().into()))
}

/// mu = force / normal load: the recorded load where there is one, else the nominal one; null without load.
fn coefficient(run: &Run) -> Vec<Option<f64>> {
    let load = |sample: usize| match (&run.normal_force_n, run.normal_load_n) {
        (Some(recorded), _) => Some(recorded[sample]),
        (None, nominal) => nominal,
    };
    let loaded = run.protocol != Protocol::Unloaded;
    run.force_n
        .iter()
        .enumerate()
        .map(|(sample, force)| load(sample).filter(|_| loaded).map(|load| force / load))
        .collect()
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len();
    values.sum::<f64>() / count as f64
}

/// Sample standard deviation; none of a single value.
fn deviation(values: &[f64]) -> Option<f64> {
    if values.len() < 2 {
        return None;
    }
    let centre = mean(values.iter().copied());
    let squares: f64 = values.iter().map(|value| (value - centre).powi(2)).sum();
    Some((squares / (values.len() - 1) as f64).sqrt())
}

/// Counts in frames are 32 bit: the door takes no more bytes than that many samples.
fn index(number: usize) -> u32 {
    u32::try_from(number).unwrap_or(u32::MAX)
}

pub(crate) fn direction_word(direction: Direction) -> &'static str {
    DIRECTIONS
        .iter()
        .find(|(_, known)| *known == direction)
        .map_or("", |(word, _)| *word)
}

pub(crate) fn protocol_word(protocol: Protocol) -> &'static str {
    PROTOCOLS
        .iter()
        .find(|(_, known)| *known == protocol)
        .map_or("", |(word, _)| *word)
}

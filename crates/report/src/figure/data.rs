//! The numbers behind a figure, as rows of text: for its table on the page and its file beside the report.

use super::{BarPlot, Figure, HeatMap, LinePlot, Plot};
use crate::escape::csv as cell;
use crate::number::{exact, unit};

/// Heading and rows of the data behind a figure; empty for drawings.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Data {
    pub(crate) heading: Vec<String>,
    pub(crate) rows: Vec<Vec<Datum>>,
}

/// One entry.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Datum {
    Word(String),
    Number(f64),
    Nothing,
}

impl Datum {
    fn text(&self, digits: Option<u8>) -> String {
        match self {
            Self::Word(word) => word.clone(),
            Self::Number(number) => match digits {
                // Rounded, then written the shortest way.
                Some(digits) => {
                    let rounded = format!("{number:.*e}", usize::from(digits.max(1)) - 1);
                    rounded.parse::<f64>().map_or(rounded, exact)
                }
                None => exact(*number),
            },
            Self::Nothing => String::new(),
        }
    }
}

impl Data {
    /// Comma-separated values (RFC 4180); numbers exact, or to so many significant digits.
    pub(crate) fn csv(&self, digits: Option<u8>) -> String {
        let mut out = String::new();
        let mut line = |cells: Vec<String>| {
            out.push_str(&cells.join(","));
            out.push('\n');
        };
        line(self.heading.iter().map(|name| cell(name)).collect());
        for row in &self.rows {
            line(row.iter().map(|datum| cell(&datum.text(digits))).collect());
        }
        out
    }
}

fn named(label: &str, raw_unit: &str) -> String {
    match unit(raw_unit).as_str() {
        "" => label.into(),
        unit => format!("{label} ({unit})"),
    }
}

fn word(text: &str) -> Datum {
    Datum::Word(text.into())
}

fn optional(number: Option<f64>) -> Datum {
    number
        .filter(|n| n.is_finite())
        .map_or(Datum::Nothing, Datum::Number)
}

fn number(number: f64) -> Datum {
    optional(Some(number))
}

/// The data behind a figure.
pub(crate) fn of(figure: &Figure) -> Data {
    match &figure.plot {
        Plot::Lines(plot) => lines(plot),
        Plot::Bars(plot) => bars(plot),
        Plot::Heat(map) => heat(map),
        Plot::Drawing(_) | Plot::Animation(_) => Data::default(),
    }
}

fn lines(plot: &LinePlot) -> Data {
    let (x, y) = (
        named(&plot.x.label, &plot.x.unit),
        named(&plot.y.label, &plot.y.unit),
    );
    let intervals = !plot.bands.is_empty() || plot.series.iter().any(|s| !s.intervals.is_empty());
    let mut heading = vec!["series".to_string(), x, y];
    if intervals {
        heading.extend(["low".to_string(), "high".to_string()]);
    }
    let mut rows = Vec::new();
    for series in &plot.series {
        for (index, point) in series.points.iter().enumerate() {
            let mut row = vec![word(&series.label), number(point[0]), number(point[1])];
            if intervals {
                let interval = series.intervals.get(index);
                row.extend([
                    optional(interval.map(|i| i[0])),
                    optional(interval.map(|i| i[1])),
                ]);
            }
            rows.push(row);
        }
    }
    for band in &plot.bands {
        for [x, low, high] in &band.points {
            rows.push(vec![
                word(&band.label),
                number(*x),
                Datum::Nothing,
                number(*low),
                number(*high),
            ]);
        }
    }
    for region in &plot.regions {
        for [x, y] in &region.corners {
            let mut row = vec![word(&region.label), number(*x), number(*y)];
            if intervals {
                row.extend([Datum::Nothing, Datum::Nothing]);
            }
            rows.push(row);
        }
    }
    Data { heading, rows }
}

fn bars(plot: &BarPlot) -> Data {
    let label = if plot.category_label.is_empty() {
        "category"
    } else {
        &plot.category_label
    };
    let rows = plot
        .groups
        .iter()
        .flat_map(|group| {
            plot.categories.iter().enumerate().map(|(index, category)| {
                let interval = group.intervals.get(index).copied().flatten();
                vec![
                    word(category),
                    word(&group.label),
                    optional(group.values.get(index).copied().flatten()),
                    optional(interval.map(|i| i[0])),
                    optional(interval.map(|i| i[1])),
                ]
            })
        })
        .collect();
    Data {
        heading: vec![
            label.to_string(),
            "group".into(),
            named(&plot.y.label, &plot.y.unit),
            "low".into(),
            "high".into(),
        ],
        rows,
    }
}

fn heat(map: &HeatMap) -> Data {
    let mut heading = vec![named(&map.y.label, &map.y.unit)];
    heading.extend(map.columns.iter().cloned());
    let rows = map
        .rows
        .iter()
        .zip(&map.values)
        .map(|(row, values)| {
            let mut cells = vec![word(row)];
            cells.extend(values.iter().map(|value| optional(*value)));
            cells
        })
        .collect();
    Data { heading, rows }
}

//! Words for readers who cannot see a figure, made from its data: kind, ranges, extremes, trend.

use super::{Axis, BarPlot, Figure, HeatMap, LinePlot, Mark, Plot, Rule, Series};
use crate::Evidence;
use crate::number::{plain, with_unit};
use crate::prose::letters;

/// The description of a figure.
pub(crate) fn describe(figure: &Figure) -> String {
    let mut text = match &figure.plot {
        Plot::Lines(plot) => lines(plot),
        Plot::Bars(plot) => bars(plot),
        Plot::Heat(map) => heat(map),
        Plot::Drawing(drawing) => format!("Drawing to scale. {}", drawing.description),
        Plot::Animation(animation) => format!(
            "Animation to scale, {} frames. {}",
            animation.frames.len(),
            animation.description
        ),
    };
    if figure.evidence == Evidence::Synthetic {
        text.push_str(" Made from synthetic data.");
    }
    letters(&text)
}

fn named(axis: &Axis) -> String {
    if axis.label.is_empty() {
        "unnamed axis".into()
    } else {
        axis.label.clone()
    }
}

fn amount(number: f64, unit: &str) -> String {
    with_unit(&plain(number), unit)
}

fn range(numbers: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let (low, high) = numbers
        .filter(|number| number.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), number| {
            (low.min(number), high.max(number))
        });
    (low <= high).then_some((low, high))
}

fn lines(plot: &LinePlot) -> String {
    let kind = if plot
        .series
        .iter()
        .all(|s| matches!(s.mark, Mark::Points | Mark::Dots))
        && !plot.series.is_empty()
    {
        "Scatter plot"
    } else if plot.series.is_empty() {
        "Plot of regions"
    } else {
        "Line plot"
    };
    let mut text = format!("{kind} of {} over {}.", named(&plot.y), named(&plot.x));
    for series in &plot.series {
        text.push(' ');
        text.push_str(&sentence(series, plot));
    }
    for region in &plot.regions {
        if let (Some(x), Some(y)) = (
            range(region.corners.iter().map(|c| c[0])),
            range(region.corners.iter().map(|c| c[1])),
        ) {
            text.push_str(&format!(
                " Region {}: {} corners, {} {} to {}, {} {} to {}.",
                region.label,
                region.corners.len(),
                named(&plot.x),
                plain(x.0),
                amount(x.1, &plot.x.unit),
                named(&plot.y),
                plain(y.0),
                amount(y.1, &plot.y.unit)
            ));
        }
    }
    for band in &plot.bands {
        text.push_str(&format!(" Band: {}.", band.label));
    }
    for rule in &plot.rules {
        text.push_str(&match rule {
            Rule::Vertical(at, label) => {
                format!(" Vertical line at {}: {label}.", amount(*at, &plot.x.unit))
            }
            Rule::Horizontal(at, label) => format!(
                " Horizontal line at {}: {label}.",
                amount(*at, &plot.y.unit)
            ),
        });
    }
    text
}

/// One series in words: number of points, ranges, where the extremes lie, trend.
fn sentence(series: &Series, plot: &LinePlot) -> String {
    let label = if series.label.is_empty() {
        "Series"
    } else {
        &series.label
    };
    let points: Vec<[f64; 2]> = series
        .points
        .iter()
        .copied()
        .filter(|p| p.iter().all(|number| number.is_finite()))
        .collect();
    let (Some(first), Some(last)) = (points.first(), points.last()) else {
        return format!("{label}: no points.");
    };
    let lowest = points
        .iter()
        .min_by(|a, b| a[1].total_cmp(&b[1]))
        .unwrap_or(first);
    let highest = points
        .iter()
        .max_by(|a, b| a[1].total_cmp(&b[1]))
        .unwrap_or(first);
    let (x_unit, y_unit) = (&plot.x.unit, &plot.y.unit);
    if points.len() == 1 {
        return format!(
            "{label}: one point, {} at {}.",
            amount(first[1], y_unit),
            amount(first[0], x_unit)
        );
    }
    format!(
        "{label}: {} points, lowest {} at {}, highest {} at {}; {}.",
        points.len(),
        amount(lowest[1], y_unit),
        amount(lowest[0], x_unit),
        amount(highest[1], y_unit),
        amount(highest[0], x_unit),
        trend(first[1], last[1], lowest[1], highest[1])
    )
}

/// From first to last, in one word, against the span.
fn trend(first: f64, last: f64, lowest: f64, highest: f64) -> &'static str {
    let span = highest - lowest;
    let change = last - first;
    if span <= 1e-12 * highest.abs().max(lowest.abs()) {
        "constant"
    } else if change > 0.5 * span {
        "rises over all"
    } else if change < -0.5 * span {
        "falls over all"
    } else {
        "ends near where it starts"
    }
}

fn bars(plot: &BarPlot) -> String {
    let mut text = format!(
        "Bar chart of {} for {} categories: {}.",
        named(&plot.y),
        plot.categories.len(),
        plot.categories.join(", ")
    );
    for group in &plot.groups {
        let values: Vec<String> = plot
            .categories
            .iter()
            .zip(&group.values)
            .map(|(category, value)| match value {
                Some(value) => format!("{category} {}", amount(*value, &plot.y.unit)),
                None => format!("{category} without value"),
            })
            .collect();
        text.push_str(&format!(" {}: {}.", group.label, values.join(", ")));
    }
    text
}

fn heat(map: &HeatMap) -> String {
    let mut text = format!(
        "Map of {} over {} ({} columns) and {} ({} rows).",
        map.quantity,
        named(&map.x),
        map.columns.len(),
        named(&map.y),
        map.rows.len()
    );
    let cells = || {
        map.values.iter().zip(&map.rows).flat_map(|(cells, row)| {
            cells
                .iter()
                .zip(&map.columns)
                .filter_map(move |(value, column)| value.map(|value| (value, row, column)))
        })
    };
    if let (Some(low), Some(high)) = (
        cells().min_by(|a, b| a.0.total_cmp(&b.0)),
        cells().max_by(|a, b| a.0.total_cmp(&b.0)),
    ) {
        text.push_str(&format!(
            " Lowest {} at {}, {}; highest {} at {}, {}.",
            amount(low.0, &map.unit),
            low.2,
            low.1,
            amount(high.0, &map.unit),
            high.2,
            high.1
        ));
    }
    let absent = map
        .values
        .iter()
        .flatten()
        .filter(|value| value.is_none())
        .count();
    if absent > 0 {
        text.push_str(&format!(" {absent} cells without a value."));
    }
    text
}

//! Lines, points, bands and regions over two axes.

use super::super::{Ink, Limits, LinePlot, Mark, Rule, Scale, Series};
use super::canvas::{FONT, Paint, SCALE};
use super::frame::{Frame, axis_name, left_of};
use super::ruler::{Ruler, limits_of};
use super::sheet::{Anchor, Drawn, Sheet, Swatch, WIDTH, legend_height};
use super::stamp_height;
use super::thin::{Place, clip_line, clip_polygon, evenly, thin_line};

/// Height of the frame with its axes.
const HEIGHT: i32 = 390 * SCALE;
/// Dots of one series at most.
const MOST_DOTS: usize = 900;

/// Draws the plot into `out`; the height of the sheet comes back.
pub(super) fn draw(
    plot: &LinePlot,
    limits: Option<&Limits>,
    synthetic: bool,
    out: &mut String,
) -> Result<i32, String> {
    let (x, y) = rulers(plot, limits)?;
    let entries = entries(plot);
    let left = left_of(&y);
    let top = legend_height(&entries, left) + stamp_height(synthetic);
    let mut height = HEIGHT + top;
    let (x, y) = if plot.equal_aspect {
        height += 90 * SCALE;
        equal(
            &x,
            &y,
            f64::from(WIDTH - left - 20 * SCALE),
            f64::from(height - top - 54 * SCALE),
        )
    } else {
        (x, y)
    };
    let sheet = Sheet::new(out, height);
    paint(plot, &sheet, (x, y), &entries, top, synthetic).map_err(|error| error.to_string())?;
    Ok(height)
}

fn paint(
    plot: &LinePlot,
    sheet: &Sheet<'_>,
    rulers: (Ruler, Ruler),
    entries: &[(Swatch, String)],
    top: i32,
    synthetic: bool,
) -> Drawn {
    let left = left_of(&rulers.1);
    sheet.legend(entries, left)?;
    let names = (axis_name(&plot.x), axis_name(&plot.y));
    let frame = Frame::draw(sheet, rulers, (&names.0, &names.1), (top, 0), true)?;
    for region in &plot.regions {
        let corners: Vec<Place> = region
            .corners
            .iter()
            .map(|&corner| frame.place(corner))
            .collect();
        if corners.iter().flatten().all(|number| number.is_finite()) {
            sheet.area(
                &clip_polygon(&corners, frame.edges),
                Paint::Wash(region.ink),
            )?;
            let mut outline = corners;
            outline.extend(outline.first().copied());
            for part in clip_line(&outline, frame.edges) {
                sheet.line(&part, Paint::Ink(region.ink), 16)?;
            }
        }
    }
    for band in &plot.bands {
        let low = band.points.iter().map(|&[x, low, _]| frame.place([x, low]));
        let high = band
            .points
            .iter()
            .rev()
            .map(|&[x, _, high]| frame.place([x, high]));
        let low = thin_line(&low.filter(finite).collect::<Vec<_>>(), 30.0, 3.0);
        let mut high: Vec<Place> = high.filter(finite).collect();
        high.reverse();
        let mut corners = low;
        corners.extend(thin_line(&high, 30.0, 3.0).into_iter().rev());
        sheet.area(&clip_polygon(&corners, frame.edges), Paint::Wash(band.ink))?;
    }
    for rule in &plot.rules {
        draw_rule(rule, sheet, &frame)?;
    }
    for series in &plot.series {
        draw_series(series, sheet, &frame)?;
    }
    for rule in &plot.rules {
        name_rule(rule, sheet, &frame)?;
    }
    for (x, y, text) in &plot.notes {
        let place = frame.place([*x, *y]);
        if frame.holds(place) {
            sheet.text(
                text,
                [place[0], place[1] - 50.0],
                Anchor::Above,
                Paint::Text,
                FONT - 5,
            )?;
        }
    }
    if synthetic {
        frame.stamp(sheet)?;
    }
    Ok(())
}

fn finite(place: &Place) -> bool {
    place.iter().all(|number| number.is_finite())
}

/// The line of a rule, under the data.
pub(super) fn draw_rule(rule: &Rule, sheet: &Sheet<'_>, frame: &Frame) -> Drawn {
    let [left, top, right, bottom] = frame.edges;
    match rule_place(rule, frame) {
        Some((Rule::Vertical(..), x)) => sheet.line(&[[x, top], [x, bottom]], Paint::Rule, 12),
        Some((Rule::Horizontal(..), y)) => sheet.line(&[[left, y], [right, y]], Paint::Rule, 12),
        None => Ok(()),
    }
}

/// The name of a rule, over the data.
pub(super) fn name_rule(rule: &Rule, sheet: &Sheet<'_>, frame: &Frame) -> Drawn {
    let [left, top, right, _] = frame.edges;
    let size = FONT - 10;
    match rule_place(rule, frame) {
        Some((Rule::Vertical(_, label), x)) if x > left + 0.75 * (right - left) => sheet.text(
            label,
            [x - 40.0, top + 90.0],
            Anchor::Right,
            Paint::Over,
            size,
        ),
        Some((Rule::Vertical(_, label), x)) => sheet.text(
            label,
            [x + 40.0, top + 90.0],
            Anchor::Left,
            Paint::Over,
            size,
        ),
        Some((Rule::Horizontal(_, label), y)) => {
            let y = if y < top + 170.0 { y + 90.0 } else { y - 80.0 };
            sheet.text(label, [right - 40.0, y], Anchor::Right, Paint::Over, size)
        }
        None => Ok(()),
    }
}

/// Where a rule crosses its axis, if that is in view.
fn rule_place<'r>(rule: &'r Rule, frame: &Frame) -> Option<(&'r Rule, f64)> {
    let [left, top, right, bottom] = frame.edges;
    let (place, low, high) = match rule {
        Rule::Vertical(at, _) => (frame.place([*at, frame.y.limits()[0]])[0], left, right),
        Rule::Horizontal(at, _) => (frame.place([frame.x.limits()[0], *at])[1], top, bottom),
    };
    (low..=high).contains(&place).then_some((rule, place))
}

fn draw_series(series: &Series, sheet: &Sheet<'_>, frame: &Frame) -> Drawn {
    let places: Vec<Place> = series
        .points
        .iter()
        .map(|&point| frame.place(point))
        .collect();
    for (point, interval) in series.points.iter().zip(&series.intervals) {
        let ends = [
            frame.place([point[0], interval[0]]),
            frame.place([point[0], interval[1]]),
        ];
        if ends.iter().all(finite) {
            for part in clip_line(&ends, frame.edges) {
                sheet.line(&part, Paint::Solid(series.ink), 12)?;
            }
        }
    }
    if matches!(series.mark, Mark::Line | Mark::LinePoints) {
        for part in clip_line(&places, frame.edges) {
            sheet.line(&thin_line(&part, 24.0, 1.5), Paint::Ink(series.ink), 18)?;
        }
    }
    let inside: Vec<Place> = places
        .into_iter()
        .filter(|&place| frame.holds(place))
        .collect();
    match series.mark {
        Mark::Dots => {
            for place in evenly(&inside, MOST_DOTS) {
                sheet.dot(place, 11, Paint::Solid(series.ink))?;
            }
        }
        Mark::Points | Mark::LinePoints => {
            for place in evenly(&inside, MOST_DOTS) {
                sheet.marker(place, series.ink)?;
            }
        }
        Mark::Line => {}
    }
    Ok(())
}

/// The legend: one entry for each name; a name used twice (forward and reverse of one model) is listed once.
fn entries(plot: &LinePlot) -> Vec<(Swatch, String)> {
    let mut entries: Vec<(Swatch, String)> = Vec::new();
    let series = plot
        .series
        .iter()
        .map(|s| (Swatch::Series(s.ink, s.mark), &s.label, s.ink));
    let bands = plot
        .bands
        .iter()
        .map(|b| (Swatch::Area(b.ink), &b.label, b.ink));
    let regions = plot
        .regions
        .iter()
        .map(|r| (Swatch::Area(r.ink), &r.label, r.ink));
    let mut seen: Vec<(&String, Ink)> = Vec::new();
    for (swatch, label, ink) in series.chain(bands).chain(regions) {
        if !label.is_empty() && !seen.contains(&(label, ink)) {
            seen.push((label, ink));
            entries.push((swatch, label.clone()));
        }
    }
    alike_together(entries)
}

/// Entries that look alike and share the first words of their names, up to a comma, become one: nobody could tell them
/// apart by the legend, and the data keep their names.
fn alike_together(entries: Vec<(Swatch, String)>) -> Vec<(Swatch, String)> {
    let mut groups: Vec<(Swatch, Vec<String>)> = Vec::new();
    for (swatch, label) in entries {
        let shared = |other: &String| {
            let stem = |label: &str| label.split_once(", ").map(|(stem, _)| stem.to_owned());
            stem(other).is_some() && stem(other) == stem(&label)
        };
        match groups
            .iter_mut()
            .find(|(other, labels)| *other == swatch && labels.iter().all(shared))
        {
            Some((_, labels)) => labels.push(label),
            None => groups.push((swatch, vec![label])),
        }
    }
    let named = |(swatch, labels): (Swatch, Vec<String>)| {
        let name = match labels.as_slice() {
            [one] => one.clone(),
            several => {
                let stem = several[0].split_once(", ").map_or("", |(stem, _)| stem);
                format!("{stem}, all {}", several.len())
            }
        };
        (swatch, name)
    };
    groups.into_iter().map(named).collect()
}

/// The axes of the view: the paper's limits, else the axis's own, else the data's.
fn rulers(plot: &LinePlot, limits: Option<&Limits>) -> Result<(Ruler, Ruler), String> {
    let xs = plot
        .series
        .iter()
        .flat_map(|s| s.points.iter().map(|p| p[0]))
        .chain(
            plot.bands
                .iter()
                .flat_map(|b| b.points.iter().map(|p| p[0])),
        )
        .chain(
            plot.regions
                .iter()
                .flat_map(|r| r.corners.iter().map(|c| c[0])),
        )
        .chain(plot.rules.iter().filter_map(|rule| match rule {
            Rule::Vertical(at, _) => Some(*at),
            Rule::Horizontal(..) => None,
        }));
    let ys = plot
        .series
        .iter()
        .flat_map(|s| {
            s.points
                .iter()
                .map(|p| p[1])
                .chain(s.intervals.iter().flatten().copied())
        })
        .chain(
            plot.bands
                .iter()
                .flat_map(|b| b.points.iter().flat_map(|p| [p[1], p[2]])),
        )
        .chain(
            plot.regions
                .iter()
                .flat_map(|r| r.corners.iter().map(|c| c[1])),
        )
        .chain(plot.rules.iter().filter_map(|rule| match rule {
            Rule::Horizontal(at, _) => Some(*at),
            Rule::Vertical(..) => None,
        }));
    let x = limits.map(|l| l.x).or(plot.x.limits);
    let y = limits.map(|l| l.y).or(plot.y.limits);
    let x = checked(
        x.or_else(|| limits_of(xs, plot.x.scale, false)),
        plot.x.scale,
    )?;
    let y = checked(
        y.or_else(|| limits_of(ys, plot.y.scale, false)),
        plot.y.scale,
    )?;
    Ok((
        Ruler::new(x, plot.x.scale, 7),
        Ruler::new(y, plot.y.scale, 6),
    ))
}

pub(super) fn checked(limits: Option<[f64; 2]>, scale: Scale) -> Result<[f64; 2], String> {
    let [low, high] = limits.ok_or("no finite number to draw")?;
    if !(low.is_finite() && high.is_finite() && low < high) {
        return Err(format!("an axis from {low} to {high}"));
    }
    if scale == Scale::Log && low <= 0.0 {
        return Err(format!("a logarithmic axis from {low}"));
    }
    Ok([low, high])
}

/// Widens one axis so that a unit is as long on both.
fn equal(x: &Ruler, y: &Ruler, width: f64, height: f64) -> (Ruler, Ruler) {
    let ([x0, x1], [y0, y1]) = (x.limits(), y.limits());
    let per_unit = (width / (x1 - x0)).min(height / (y1 - y0));
    let widen = |low: f64, high: f64, room: f64| {
        let middle = 0.5 * (low + high);
        let half = 0.5 * room / per_unit;
        [middle - half, middle + half]
    };
    (
        Ruler::new(widen(x0, x1, width), Scale::Linear, 9),
        Ruler::new(widen(y0, y1, height), Scale::Linear, 6),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_looks_alike_is_one_entry_and_what_does_not_keeps_its_own() {
        let entry = |ink, label: &str| (Swatch::Series(ink, Mark::Line), label.to_owned());
        let entries = vec![
            entry(Ink::FORWARD, "forward, repeat 1"),
            entry(Ink::FORWARD, "forward, repeat 2"),
            entry(Ink::REVERSE, "reverse, repeat 1"),
            entry(Ink::FORWARD, "law alone"),
            (Swatch::Area(Ink::FORWARD), "forward, repeat 3".to_owned()),
        ];
        let names: Vec<String> = alike_together(entries)
            .into_iter()
            .map(|(_, name)| name)
            .collect();
        assert_eq!(
            names,
            [
                "forward, all 2",
                "reverse, repeat 1",
                "law alone",
                "forward, repeat 3"
            ]
        );
    }
}

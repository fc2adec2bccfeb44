//! Bars by category.

use super::super::{BarPlot, Mark, Rule, Scale};
use super::canvas::{Paint, SCALE};
use super::frame::{Frame, axis_name, left_of};
use super::lines::{checked, draw_rule, name_rule};
use super::ruler::{Ruler, limits_of};
use super::sheet::{Drawn, Sheet, Swatch, legend_height};
use super::stamp_height;

const HEIGHT: i32 = 360 * SCALE;

/// Draws the plot into `out`; the height of the sheet comes back.
pub(super) fn draw(plot: &BarPlot, synthetic: bool, out: &mut String) -> Result<i32, String> {
    for group in &plot.groups {
        if group.values.len() != plot.categories.len() {
            return Err(format!(
                "{} values in `{}` for {} categories",
                group.values.len(),
                group.label,
                plot.categories.len()
            ));
        }
    }
    let numbers = plot
        .groups
        .iter()
        .flat_map(|g| {
            g.values
                .iter()
                .flatten()
                .copied()
                .chain(g.intervals.iter().flatten().flatten().copied())
        })
        .chain(plot.rules.iter().filter_map(|rule| match rule {
            Rule::Horizontal(at, _) => Some(*at),
            Rule::Vertical(..) => None,
        }));
    let limits = plot
        .y
        .limits
        .or_else(|| limits_of(numbers, Scale::Linear, true));
    let y = Ruler::new(checked(limits, Scale::Linear)?, Scale::Linear, 6);
    let x = Ruler::categories(&plot.categories);
    let entries: Vec<_> = plot
        .groups
        .iter()
        .filter(|group| !group.label.is_empty())
        .map(|group| (Swatch::Series(group.ink, Mark::Points), group.label.clone()))
        .collect();
    let top = legend_height(&entries, left_of(&y)) + stamp_height(synthetic);
    let sheet = Sheet::new(out, HEIGHT + top);
    paint(plot, &sheet, (x, y), &entries, top, synthetic).map_err(|error| error.to_string())?;
    Ok(HEIGHT + top)
}

fn paint(
    plot: &BarPlot,
    sheet: &Sheet<'_>,
    rulers: (Ruler, Ruler),
    entries: &[(Swatch, String)],
    top: i32,
    synthetic: bool,
) -> Drawn {
    sheet.legend(entries, left_of(&rulers.1))?;
    let names = (plot.category_label.clone(), axis_name(&plot.y));
    let frame = Frame::draw(sheet, rulers, (&names.0, &names.1), (top, 0), false)?;
    let [low, high] = frame.y.limits();
    let zero = 0.0_f64.clamp(low, high);
    #[allow(clippy::cast_precision_loss)] // a handful of groups
    let width = 0.72 / plot.groups.len().max(1) as f64;
    let mut offset = -0.36 + 0.5 * width;
    for group in &plot.groups {
        let mut category = 0.0;
        for (index, value) in group.values.iter().enumerate() {
            let middle = category + offset;
            category += 1.0;
            let Some(value) = value.filter(|value| value.is_finite()) else {
                continue;
            };
            let half = 0.44 * width;
            let value = value.clamp(low, high);
            let corners = [
                frame.place([middle - half, zero]),
                frame.place([middle + half, zero]),
                frame.place([middle + half, value]),
                frame.place([middle - half, value]),
            ];
            sheet.area(&corners, Paint::Wash(group.ink))?;
            sheet.line(
                &[corners[0], corners[3], corners[2], corners[1]],
                Paint::Solid(group.ink),
                14,
            )?;
            if let Some([from, to]) = group.intervals.get(index).copied().flatten() {
                let ends = [from.clamp(low, high), to.clamp(low, high)]
                    .map(|end| frame.place([middle, end]));
                sheet.line(&ends, Paint::Solid(group.ink), 14)?;
                for [x, y] in ends {
                    sheet.line(&[[x - 40.0, y], [x + 40.0, y]], Paint::Solid(group.ink), 14)?;
                }
            }
            sheet.marker(frame.place([middle, value]), group.ink)?;
        }
        offset += width;
    }
    let [left, _, right, _] = frame.edges;
    let base = frame.place([0.0, zero])[1];
    sheet.line(&[[left, base], [right, base]], Paint::Axis, 10)?;
    for rule in &plot.rules {
        draw_rule(rule, sheet, &frame)?;
        name_rule(rule, sheet, &frame)?;
    }
    if synthetic {
        frame.stamp(sheet)?;
    }
    Ok(())
}

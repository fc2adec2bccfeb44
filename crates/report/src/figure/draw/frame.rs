//! A frame with two axes on a sheet: from numbers to places.

use plotters::prelude::ChartBuilder;

use super::super::Axis;
use super::canvas::{FONT, Paint, SCALE, text_width};
use super::ruler::Ruler;
use super::sheet::{Anchor, Drawn, Sheet, WIDTH, stroke, words};
use super::thin::Place;
use crate::number;
use crate::prose::letters;

/// Room for the ticks and the name of the horizontal axis.
const BELOW: i32 = 46 * SCALE;
/// Room right of the frame, for half a tick label.
const RIGHT: i32 = 20 * SCALE;

/// The frame of a plot: its axes and its place on the sheet.
pub(super) struct Frame {
    pub(super) x: Ruler,
    pub(super) y: Ruler,
    /// Left, top, right, bottom in canvas units.
    pub(super) edges: [f64; 4],
}

/// Room for the ticks and the name of the vertical axis.
pub(super) fn left_of(y: &Ruler) -> i32 {
    let widest = y
        .ticks()
        .iter()
        .map(|(_, label)| text_width(label, FONT))
        .max()
        .unwrap_or(0);
    i32::try_from(widest).unwrap_or(0) + 36 * SCALE
}

/// The name of an axis with its unit.
pub(super) fn axis_name(axis: &Axis) -> String {
    match number::unit(&axis.unit).as_str() {
        "" => axis.label.clone(),
        unit if axis.label.is_empty() => unit.to_string(),
        unit => format!("{} ({unit})", axis.label),
    }
}

impl Frame {
    /// Draws axes, grid and names below `top`; `right` is kept free beside the frame.
    pub(super) fn draw(
        sheet: &Sheet<'_>,
        (x, y): (Ruler, Ruler),
        (x_name, y_name): (&str, &str),
        (top, right): (i32, i32),
        grid: bool,
    ) -> Drawn<Self> {
        let (_, height) = sheet.root.dim_in_pixel();
        let left = left_of(&y);
        let mut chart = ChartBuilder::on(&sheet.root)
            .margin_top(top + 80)
            .margin_right(RIGHT + right)
            .x_label_area_size(BELOW)
            .y_label_area_size(left)
            .build_cartesian_2d(x.clone(), y.clone())?;
        let x_label = |at: &f64| x.label(*at);
        let y_label = |at: &f64| y.label(*at);
        let mut mesh = chart.configure_mesh();
        mesh.disable_mesh()
            .axis_style(stroke(Paint::Axis, 10))
            .set_all_tick_mark_size(45)
            .x_labels(100)
            .y_labels(100)
            .x_label_formatter(&x_label)
            .y_label_formatter(&y_label)
            .label_style(words(Paint::Text, FONT));
        // The grid goes first, under the axes; plotters would draw it with a style of its own for every tick.
        let edges = [
            f64::from(left),
            f64::from(top + 80),
            f64::from(WIDTH - RIGHT - right),
            f64::from(i32::try_from(height).unwrap_or(0) - BELOW),
        ];
        let frame = Self {
            x: x.clone(),
            y: y.clone(),
            edges,
        };
        if grid {
            frame.grid(sheet)?;
        }
        mesh.draw()?;
        let middle_y = 0.5 * (edges[1] + edges[3]);
        sheet.text(
            x_name,
            [0.5 * (edges[0] + edges[2]), edges[3] + 370.0],
            Anchor::Middle,
            Paint::Text,
            FONT,
        )?;
        frame.upright(sheet, y_name, [100.0, middle_y])?;
        Ok(frame)
    }

    fn grid(&self, sheet: &Sheet<'_>) -> Drawn {
        let [left, top, right, bottom] = self.edges;
        for (tick, _) in self.x.ticks() {
            let x = self.place([*tick, self.y.limits()[0]])[0];
            sheet.line(&[[x, top], [x, bottom]], Paint::Grid, 8)?;
        }
        for (tick, _) in self.y.ticks() {
            let y = self.place([self.x.limits()[0], *tick])[1];
            sheet.line(&[[left, y], [right, y]], Paint::Grid, 8)?;
        }
        Ok(())
    }

    /// Words that read upward.
    fn upright(&self, sheet: &Sheet<'_>, text: &str, at: Place) -> Drawn {
        use plotters::prelude::{IntoTextStyle, Text};
        use plotters::style::FontTransform;
        use plotters::style::text_anchor::{HPos, Pos, VPos};
        #[allow(clippy::cast_possible_truncation)] // a place on the sheet
        let place = (at[0] as i32, at[1] as i32);
        let style = words(Paint::Text, FONT)
            .into_text_style(&sheet.root)
            .transform(FontTransform::Rotate270)
            .pos(Pos::new(HPos::Center, VPos::Center));
        sheet.root.draw(&Text::new(letters(text), place, style))
    }

    /// Where a point of the data lies on the sheet.
    pub(super) fn place(&self, [x, y]: [f64; 2]) -> Place {
        let share = |ruler: &Ruler, number: f64| {
            if !ruler.shows(number) {
                return f64::NAN;
            }
            let [low, high] = ruler.limits();
            (ruler.even(number) - ruler.even(low)) / (ruler.even(high) - ruler.even(low))
        };
        let [left, top, right, bottom] = self.edges;
        [
            left + share(&self.x, x) * (right - left),
            bottom - share(&self.y, y) * (bottom - top),
        ]
    }

    /// Whether a place lies in the frame.
    pub(super) fn holds(&self, [x, y]: Place) -> bool {
        let [left, top, right, bottom] = self.edges;
        (left - 1.0..=right + 1.0).contains(&x) && (top - 1.0..=bottom + 1.0).contains(&y)
    }

    /// The stamp that no figure of stand-in data goes without.
    pub(super) fn stamp(&self, sheet: &Sheet<'_>) -> Drawn {
        let [_, top, right, _] = self.edges;
        super::stamp(sheet, [right, top - 130.0])
    }
}

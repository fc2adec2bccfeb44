//! The sheet that a figure is drawn on: strokes, areas, words, markers and the legend, in canvas units.

use std::convert::Infallible;

use plotters::coord::Shift;
use plotters::prelude::{
    Circle, DrawingArea, DrawingAreaErrorKind, IntoDrawingArea, IntoTextStyle, PathElement,
    Polygon, Text,
};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{IntoFont, ShapeStyle, TextStyle};

use super::super::{Ink, Mark};
use super::canvas::{Canvas, FONT, Paint, SCALE, paint, text_width};
use super::thin::Place;
use crate::prose::letters;

/// How drawing ends; the canvas itself cannot fail.
pub(super) type Drawn<T = ()> = Result<T, DrawingAreaErrorKind<Infallible>>;

/// Width of every figure, canvas units.
pub(super) const WIDTH: i32 = 720 * SCALE;

/// Where words sit relative to their place.
#[derive(Clone, Copy, Debug)]
pub(super) enum Anchor {
    Left,
    Middle,
    Right,
    Above,
}

/// What a legend entry shows beside its name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Swatch {
    Series(Ink, Mark),
    Plain(Ink),
    Area(Ink),
}

pub(super) struct Sheet<'a> {
    pub(super) root: DrawingArea<Canvas<'a>, Shift>,
}

#[allow(clippy::cast_possible_truncation)] // canvas units, clamped by the rulers
fn whole([x, y]: Place) -> (i32, i32) {
    (x.round() as i32, y.round() as i32)
}

/// A stroke of this paint and width.
pub(super) fn stroke(kind: Paint, width: u32) -> ShapeStyle {
    ShapeStyle {
        color: paint(kind).into(),
        filled: false,
        stroke_width: width,
    }
}

fn filled(kind: Paint) -> ShapeStyle {
    ShapeStyle {
        color: paint(kind).into(),
        filled: true,
        stroke_width: 0,
    }
}

/// The style of words.
pub(super) fn words(kind: Paint, size: u32) -> TextStyle<'static> {
    ("sans-serif", size).into_font().color(&paint(kind))
}

impl<'a> Sheet<'a> {
    pub(super) fn new(out: &'a mut String, height: i32) -> Self {
        let size = (WIDTH.unsigned_abs(), height.unsigned_abs());
        Self {
            root: Canvas::new(out, size).into_drawing_area(),
        }
    }

    pub(super) fn line(&self, points: &[Place], kind: Paint, width: u32) -> Drawn {
        if points.len() < 2 {
            return Ok(());
        }
        let points: Vec<_> = points.iter().map(|&point| whole(point)).collect();
        self.root
            .draw(&PathElement::new(points, stroke(kind, width)))
    }

    pub(super) fn area(&self, corners: &[Place], kind: Paint) -> Drawn {
        if corners.len() < 3 {
            return Ok(());
        }
        let corners: Vec<_> = corners.iter().map(|&point| whole(point)).collect();
        self.root.draw(&Polygon::new(corners, filled(kind)))
    }

    pub(super) fn dot(&self, at: Place, radius: i32, kind: Paint) -> Drawn {
        self.root
            .draw(&Circle::new(whole(at), radius, filled(kind)))
    }

    pub(super) fn ring(&self, at: Place, radius: i32, kind: Paint, width: u32) -> Drawn {
        self.root
            .draw(&Circle::new(whole(at), radius, stroke(kind, width)))
    }

    pub(super) fn text(
        &self,
        text: &str,
        at: Place,
        anchor: Anchor,
        kind: Paint,
        size: u32,
    ) -> Drawn {
        let (horizontal, vertical) = match anchor {
            Anchor::Left => (HPos::Left, VPos::Center),
            Anchor::Middle => (HPos::Center, VPos::Center),
            Anchor::Right => (HPos::Right, VPos::Center),
            Anchor::Above => (HPos::Center, VPos::Bottom),
        };
        let style = words(kind, size)
            .into_text_style(&self.root)
            .pos(Pos::new(horizontal, vertical));
        self.root.draw(&Text::new(letters(text), whole(at), style))
    }

    /// The marker of an ink: each ink has its own shape, so that colour is never the only difference.
    pub(super) fn marker(&self, at: Place, ink: Ink) -> Drawn {
        let kind = Paint::Solid(ink);
        let r = 38.0;
        let polygon = |corners: &[[f64; 2]]| {
            let corners: Vec<Place> = corners
                .iter()
                .map(|[x, y]| [at[0] + r * x, at[1] + r * y])
                .collect();
            self.area(&corners, kind)
        };
        let strokes = |ends: [[f64; 4]; 2]| {
            for [x0, y0, x1, y1] in ends {
                self.line(
                    &[
                        [at[0] + r * x0, at[1] + r * y0],
                        [at[0] + r * x1, at[1] + r * y1],
                    ],
                    kind,
                    18,
                )?;
            }
            Ok(())
        };
        match ink {
            Ink::Slot(slot) => match slot % 8 {
                0 => self.dot(at, 36, kind),
                1 => polygon(&[[-0.9, -0.9], [0.9, -0.9], [0.9, 0.9], [-0.9, 0.9]]),
                2 => polygon(&[[0.0, -1.2], [1.1, 0.8], [-1.1, 0.8]]),
                3 => polygon(&[[0.0, -1.3], [1.3, 0.0], [0.0, 1.3], [-1.3, 0.0]]),
                4 => polygon(&[[0.0, 1.2], [1.1, -0.8], [-1.1, -0.8]]),
                5 => strokes([[-0.9, -0.9, 0.9, 0.9], [-0.9, 0.9, 0.9, -0.9]]),
                6 => strokes([[-1.2, 0.0, 1.2, 0.0], [0.0, -1.2, 0.0, 1.2]]),
                _ => self.ring(at, 32, kind, 16),
            },
            Ink::Muted => self.ring(at, 28, kind, 12),
        }
    }

    /// Draws the legend in rows over the figure and returns its height.
    pub(super) fn legend(&self, entries: &[(Swatch, String)], left: i32) -> Drawn {
        for ((swatch, label), (column, row)) in entries.iter().zip(places(entries, left)) {
            let (x, y) = (f64::from(column), f64::from(row * ROW + ROW / 2));
            match swatch {
                Swatch::Area(ink) => {
                    let corners = [
                        [x, y - 45.0],
                        [x + 240.0, y - 45.0],
                        [x + 240.0, y + 45.0],
                        [x, y + 45.0],
                    ];
                    self.area(&corners, Paint::Wash(*ink))?;
                }
                Swatch::Plain(ink) => {
                    self.line(&[[x, y], [x + 240.0, y]], Paint::Solid(*ink), 26)?
                }
                Swatch::Series(ink, mark) => {
                    let middle = [x + 120.0, y];
                    if matches!(mark, Mark::Line | Mark::LinePoints) {
                        self.line(&[[x, y], [x + 240.0, y]], Paint::Ink(*ink), 20)?;
                    }
                    match mark {
                        Mark::Points | Mark::LinePoints => self.marker(middle, *ink)?,
                        Mark::Dots => {
                            for offset in [-70.0, 0.0, 70.0] {
                                self.dot([middle[0] + offset, y], 14, Paint::Solid(*ink))?;
                            }
                        }
                        Mark::Line => {}
                    }
                }
            }
            self.text(label, [x + 300.0, y], Anchor::Left, Paint::Text, FONT)?;
        }
        Ok(())
    }
}

/// Height of a legend row.
const ROW: i32 = 210;

/// Height of a legend, zero without entries.
pub(super) fn legend_height(entries: &[(Swatch, String)], left: i32) -> i32 {
    places(entries, left)
        .last()
        .map_or(0, |(_, row)| (row + 1) * ROW + 60)
}

/// Column (canvas units) and row of each entry.
fn places(entries: &[(Swatch, String)], left: i32) -> Vec<(i32, i32)> {
    let (mut x, mut row) = (left, 0);
    entries
        .iter()
        .map(|(_, label)| {
            let width = 300 + i32::try_from(text_width(&letters(label), FONT)).unwrap_or(0) + 260;
            if x > left && x + width - 260 > WIDTH {
                x = left;
                row += 1;
            }
            let place = (x, row);
            x += width;
            place
        })
        .collect()
}

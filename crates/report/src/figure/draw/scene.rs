//! Drawings to scale and animations.

use super::super::{Animation, Drawing, Ink, Shape};
use super::canvas::{FONT, Paint, SCALE, text_width};
use super::sheet::{Anchor, Drawn, Sheet, Swatch, WIDTH, legend_height};
use super::thin::Place;
use crate::number;

/// Highest drawing, without its legend.
const MOST_HEIGHT: f64 = 430.0 * SCALE as f64;
/// Free border around the shapes.
const BORDER: f64 = 34.0 * SCALE as f64;

/// From the drawing's unit to the sheet.
struct View {
    per_unit: f64,
    left: f64,
    top: f64,
    x0: f64,
    y1: f64,
}

impl View {
    fn place(&self, [x, y]: [f64; 2]) -> Place {
        [
            self.left + (x - self.x0) * self.per_unit,
            self.top + (self.y1 - y) * self.per_unit,
        ]
    }
}

/// Draws a drawing to scale into `out`; the height of the sheet comes back.
pub(super) fn draw(drawing: &Drawing, synthetic: bool, out: &mut String) -> Result<i32, String> {
    let (view, top, height) = layout(drawing.shapes.iter(), &drawing.legend)?;
    let sheet = Sheet::new(out, height);
    let paint = || -> Drawn {
        sheet.legend(&entries(&drawing.legend), 100)?;
        for shape in &drawing.shapes {
            draw_shape(shape, &sheet, &view)?;
        }
        scale_bar(&drawing.unit, &sheet, &view, height)?;
        if synthetic {
            super::stamp(&sheet, [f64::from(WIDTH) - 60.0, f64::from(top) + 110.0])?;
        }
        Ok(())
    };
    paint().map_err(|error| error.to_string())?;
    Ok(height)
}

/// Draws an animation: backdrop, then one group a frame; style alone moves from one to the next.
pub(super) fn animate(
    animation: &Animation,
    id: &str,
    synthetic: bool,
    out: &mut String,
) -> Result<i32, String> {
    if animation.frames.is_empty() {
        return Err("an animation without frames".into());
    }
    let shapes = || {
        animation
            .backdrop
            .iter()
            .chain(animation.frames.iter().flat_map(|frame| &frame.shapes))
    };
    let (view, top, height) = layout(shapes(), &animation.legend)?;
    {
        let sheet = Sheet::new(out, height);
        let paint = || -> Drawn {
            sheet.legend(&entries(&animation.legend), 100)?;
            for shape in &animation.backdrop {
                draw_shape(shape, &sheet, &view)?;
            }
            scale_bar(&animation.unit, &sheet, &view, height)?;
            if synthetic {
                super::stamp(&sheet, [f64::from(WIDTH) - 60.0, f64::from(top) + 110.0])?;
            }
            Ok(())
        };
        paint().map_err(|error| error.to_string())?;
    }
    #[allow(clippy::cast_precision_loss)] // a few dozen frames
    let count = animation.frames.len() as f64;
    let cycle = if animation.cycle_s > 0.0 {
        animation.cycle_s
    } else {
        2.0
    };
    let name: String = id
        .chars()
        .map(|c| if c.is_ascii_alphanumeric() { c } else { '-' })
        .collect();
    out.push_str(&format!(
        "<style>@keyframes k-{name}{{0%{{visibility:visible}}{share:.4}%{{visibility:hidden}}100%{{visibility:hidden}}}}</style>",
        share = 100.0 / count
    ));
    let mut delay = -cycle;
    for (index, frame) in animation.frames.iter().enumerate() {
        let still = if animation.still.contains(&index) {
            " still"
        } else {
            ""
        };
        out.push_str(&format!(
            "<g class=\"frame{still}\" style=\"--k:k-{name};animation-duration:{cycle:.3}s;animation-delay:{delay:.3}s\">"
        ));
        {
            let sheet = Sheet::new(out, height);
            frame
                .shapes
                .iter()
                .try_for_each(|shape| draw_shape(shape, &sheet, &view))
                .map_err(|error| error.to_string())?;
        }
        out.push_str("</g>");
        delay += cycle / count;
    }
    Ok(height)
}

fn entries(legend: &[(Ink, String)]) -> Vec<(Swatch, String)> {
    legend
        .iter()
        .map(|(ink, name)| (Swatch::Plain(*ink), name.clone()))
        .collect()
}

fn layout<'s>(
    shapes: impl Iterator<Item = &'s Shape>,
    legend: &[(Ink, String)],
) -> Result<(View, i32, i32), String> {
    let mut bounds = [
        f64::INFINITY,
        f64::INFINITY,
        f64::NEG_INFINITY,
        f64::NEG_INFINITY,
    ];
    for [x, y] in shapes.flat_map(extent) {
        if !(x.is_finite() && y.is_finite()) {
            return Err("a shape at a place that is not finite".into());
        }
        bounds = [
            bounds[0].min(x),
            bounds[1].min(y),
            bounds[2].max(x),
            bounds[3].max(y),
        ];
    }
    let [x0, y0, x1, y1] = bounds;
    if x0 > x1 {
        return Err("a drawing without shapes".into());
    }
    let (width, height) = ((x1 - x0).max(1e-12), (y1 - y0).max(1e-12));
    let room = f64::from(WIDTH) - 2.0 * BORDER;
    let per_unit = (room / width).min((MOST_HEIGHT - 2.0 * BORDER) / height);
    let top = legend_height(&entries(legend), 100);
    let view = View {
        per_unit,
        left: 0.5 * (f64::from(WIDTH) - width * per_unit),
        top: f64::from(top) + BORDER,
        x0,
        y1,
    };
    #[allow(clippy::cast_possible_truncation)] // bounded by MOST_HEIGHT
    let total = (f64::from(top) + height * per_unit + 2.0 * BORDER + 300.0) as i32;
    Ok((view, top, total))
}

/// The points that a shape reaches.
fn extent(shape: &Shape) -> Vec<[f64; 2]> {
    match shape {
        Shape::Line { points, .. } | Shape::Area { points, .. } => points.clone(),
        Shape::Circle {
            centre: [x, y],
            radius,
            ..
        } => vec![[x - radius, y - radius], [x + radius, y + radius]],
        Shape::Arrow { from, to, .. } | Shape::Dimension { from, to, .. } => vec![*from, *to],
        Shape::Angle { at, .. } | Shape::Label { at, .. } => vec![*at],
    }
}

fn draw_shape(shape: &Shape, sheet: &Sheet<'_>, view: &View) -> Drawn {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a stroke of a few pixels
    let units = |pixels: f64| (pixels.clamp(0.2, 40.0) * f64::from(SCALE)) as u32;
    match shape {
        Shape::Line {
            points,
            ink,
            width,
            dashed,
        } => {
            let points: Vec<Place> = points.iter().map(|&point| view.place(point)).collect();
            if *dashed {
                return dashes(&points, *ink, units(*width), sheet);
            }
            sheet.line(&points, Paint::Solid(*ink), units(*width))
        }
        Shape::Area { points, ink } => {
            let points: Vec<Place> = points.iter().map(|&point| view.place(point)).collect();
            sheet.area(&points, Paint::Wash(*ink))
        }
        Shape::Circle {
            centre,
            radius,
            ink,
            filled,
        } => {
            #[allow(clippy::cast_possible_truncation)] // bounded by the sheet
            let radius = (radius * view.per_unit).round().max(4.0) as i32;
            if *filled {
                sheet.dot(view.place(*centre), radius, Paint::Solid(*ink))
            } else {
                sheet.ring(view.place(*centre), radius, Paint::Solid(*ink), 14)
            }
        }
        Shape::Arrow { from, to, ink } => arrow(
            view.place(*from),
            view.place(*to),
            Paint::Solid(*ink),
            sheet,
        ),
        Shape::Dimension { from, to, label } => {
            let (from, to) = (view.place(*from), view.place(*to));
            sheet.line(&[from, to], Paint::Text, 8)?;
            let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
            let length = dx.hypot(dy).max(1.0);
            let (nx, ny) = (-dy / length * 45.0, dx / length * 45.0);
            for [x, y] in [from, to] {
                sheet.line(&[[x - nx, y - ny], [x + nx, y + ny]], Paint::Text, 8)?;
            }
            let middle = [0.5 * (from[0] + to[0]), 0.5 * (from[1] + to[1])];
            if dx.abs() > dy.abs() {
                sheet.text(
                    label,
                    [middle[0], middle[1] - 40.0],
                    Anchor::Above,
                    Paint::Text,
                    FONT,
                )
            } else if middle[0] + 80.0 + f64::from(text_width(label, FONT)) < f64::from(WIDTH) {
                sheet.text(
                    label,
                    [middle[0] + 80.0, middle[1]],
                    Anchor::Left,
                    Paint::Text,
                    FONT,
                )
            } else {
                sheet.text(
                    label,
                    [middle[0] - 80.0, middle[1]],
                    Anchor::Right,
                    Paint::Text,
                    FONT,
                )
            }
        }
        Shape::Angle {
            at,
            from_rad,
            to_rad,
            radius,
            label,
        } => {
            let arc: Vec<Place> = (0..=24)
                .map(|step| {
                    let angle = from_rad + (to_rad - from_rad) * f64::from(step) / 24.0;
                    view.place([at[0] + radius * angle.cos(), at[1] + radius * angle.sin()])
                })
                .collect();
            sheet.line(&arc, Paint::Text, 8)?;
            let middle = 0.5 * (from_rad + to_rad);
            let place = view.place([
                at[0] + 1.25 * radius * middle.cos(),
                at[1] + 1.25 * radius * middle.sin(),
            ]);
            sheet.text(label, place, Anchor::Middle, Paint::Text, FONT)
        }
        Shape::Label { at, text, ink: _ } => {
            sheet.text(text, view.place(*at), Anchor::Middle, Paint::Text, FONT)
        }
    }
}

/// A dashed line of its own, because the dash of an ink is its mark of recognition.
fn dashes(points: &[Place], ink: Ink, width: u32, sheet: &Sheet<'_>) -> Drawn {
    for pair in points.windows(2) {
        let (dx, dy) = (pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]);
        let length = dx.hypot(dy);
        let (mut from, dash, gap) = (0.0, 60.0, 50.0);
        while from < length {
            let to = (from + dash).min(length);
            let at = |s: f64| [pair[0][0] + dx * s / length, pair[0][1] + dy * s / length];
            sheet.line(&[at(from), at(to)], Paint::Solid(ink), width)?;
            from += dash + gap;
        }
    }
    Ok(())
}

fn arrow(from: Place, to: Place, kind: Paint, sheet: &Sheet<'_>) -> Drawn {
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    let length = dx.hypot(dy);
    if length < 1.0 {
        return Ok(());
    }
    let (ux, uy) = (dx / length, dy / length);
    let head = 110.0_f64.min(0.6 * length);
    let neck = [to[0] - head * ux, to[1] - head * uy];
    sheet.line(&[from, neck], kind, 18)?;
    let side = 0.42 * head;
    sheet.area(
        &[
            to,
            [neck[0] - side * uy, neck[1] + side * ux],
            [neck[0] + side * uy, neck[1] - side * ux],
        ],
        kind,
    )
}

/// A bar of a round length at the lower left.
fn scale_bar(unit: &str, sheet: &Sheet<'_>, view: &View, height: i32) -> Drawn {
    let wanted = 0.16 * f64::from(WIDTH) / view.per_unit;
    let power = 10f64.powf(wanted.log10().floor());
    let round = [5.0, 2.0, 1.0]
        .into_iter()
        .map(|f| f * power)
        .find(|&l| l <= wanted)
        .unwrap_or(power);
    let y = f64::from(height) - 150.0;
    let (x0, x1) = (BORDER, BORDER + round * view.per_unit);
    sheet.line(&[[x0, y], [x1, y]], Paint::Text, 14)?;
    for x in [x0, x1] {
        sheet.line(&[[x, y - 40.0], [x, y + 40.0]], Paint::Text, 14)?;
    }
    let label = number::with_unit(&number::significant(round, 1), unit);
    sheet.text(&label, [x1 + 80.0, y], Anchor::Left, Paint::Text, FONT)
}

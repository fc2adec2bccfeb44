//! A plotters backend that writes lean SVG: colours become classes, so that the page can have a light and a dark form.
//!
//! Coordinates are whole numbers in plotters, so everything is drawn at [`SCALE`] times the size and scaled back by
//! the `viewBox`. A colour is not a colour here but a name: [`paint`] packs a [`Paint`] into the three bytes that
//! plotters hands through, and the canvas unpacks them into a class. Neighbouring strokes of one class share one path.

use std::convert::Infallible;
use std::fmt::Write as _;

use plotters::style::RGBColor;
use plotters_backend::text_anchor::{HPos, VPos};
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind,
    FontStyle, FontTransform,
};

use super::super::Ink;
use crate::escape::html;
use crate::palette::LEVELS;

/// Canvas units per pixel of the page.
pub(super) const SCALE: i32 = 10;

/// Font size of labels, canvas units.
pub(super) const FONT: u32 = 125;

/// What a mark is, which decides its colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Paint {
    /// A series; dashed by its ink.
    Ink(Ink),
    /// A mark of a series that is never dashed: markers, intervals.
    Solid(Ink),
    /// A pale area of a series.
    Wash(Ink),
    /// Axis and frame.
    Axis,
    /// Grid.
    Grid,
    /// Words.
    Text,
    /// Words over the data, with a rim in the colour of the ground.
    Over,
    /// The ground of the page, such as under labels.
    Ground,
    /// A reference line.
    Rule,
    /// A cell without a value.
    Absent,
    /// The stamp on synthetic data.
    Stamp,
    /// Words of a cell: dark on pale cells, pale on dark ones.
    OnCell(bool),
    /// A level of the sequential scale.
    Sequential(u8),
    /// A level of the diverging scale.
    Diverging(u8),
}

/// The paint packed into three bytes.
pub(super) fn paint(paint: Paint) -> RGBColor {
    let slot = |ink: Ink| match ink {
        Ink::Slot(slot) => slot % 8,
        Ink::Muted => 8,
    };
    match paint {
        Paint::Ink(ink) => RGBColor(slot(ink), 0, 0),
        Paint::Solid(ink) => RGBColor(slot(ink), 1, 0),
        Paint::Wash(ink) => RGBColor(slot(ink), 2, 0),
        Paint::Axis => RGBColor(0, 3, 0),
        Paint::Grid => RGBColor(1, 3, 0),
        Paint::Text => RGBColor(2, 3, 0),
        Paint::Over => RGBColor(10, 3, 0),
        Paint::Ground => RGBColor(4, 3, 0),
        Paint::Rule => RGBColor(5, 3, 0),
        Paint::Absent => RGBColor(6, 3, 0),
        Paint::Stamp => RGBColor(7, 3, 0),
        Paint::OnCell(dark) => RGBColor(if dark { 9 } else { 8 }, 3, 0),
        Paint::Sequential(level) => RGBColor(level.min(LEVELS), 4, 0),
        Paint::Diverging(level) => RGBColor(level.min(LEVELS), 5, 0),
    }
}

/// The class of a packed paint.
fn class((index, kind, _): (u8, u8, u8)) -> String {
    match kind {
        0 => format!("i{index}"),
        1 => format!("i{index} n"),
        2 => format!("i{index} w"),
        3 if index == 10 => "p2 h".into(),
        3 => format!("p{index}"),
        4 => format!("s{index}"),
        _ => format!("d{index}"),
    }
}

/// Collects the elements of one drawing.
pub(super) struct Canvas<'a> {
    size: (u32, u32),
    out: &'a mut String,
    /// Class, stroke width and pen position of the path that is still open.
    open: Option<(String, u32)>,
}

impl<'a> Canvas<'a> {
    pub(super) fn new(out: &'a mut String, size: (u32, u32)) -> Self {
        Self {
            size,
            out,
            open: None,
        }
    }

    fn close(&mut self) {
        if self.open.take().is_some() {
            self.out.push_str("\"/>");
        }
    }

    /// Opens a path of this class, or goes on with the one that is open.
    fn path(&mut self, class: String, width: u32) {
        let key = (class, width);
        if self.open.as_ref() == Some(&key) {
            return;
        }
        self.close();
        let _ = write!(self.out, "<path class=\"{}\"", key.0);
        if width != 0 {
            let _ = write!(self.out, " stroke-width=\"{width}\"");
        }
        self.out.push_str(" d=\"");
        self.open = Some(key);
    }

    /// Move and relative lines, as short as whole numbers allow.
    fn trace<I: IntoIterator<Item = BackendCoord>>(&mut self, points: I) -> usize {
        let mut last: Option<BackendCoord> = None;
        let mut count = 0;
        for (x, y) in points {
            match last {
                None => {
                    let _ = write!(self.out, "M{x},{y}");
                }
                Some((x0, y0)) => {
                    if (x, y) == (x0, y0) {
                        continue;
                    }
                    self.out.push(if count == 1 { 'l' } else { ',' });
                    let (dx, dy) = (x - x0, y - y0);
                    let _ = write!(self.out, "{dx}{}{dy}", if dy < 0 { "" } else { "," });
                }
            }
            last = Some((x, y));
            count += 1;
        }
        count
    }
}

impl Drop for Canvas<'_> {
    fn drop(&mut self) {
        self.close();
    }
}

type Drawn = Result<(), DrawingErrorKind<Infallible>>;

impl DrawingBackend for Canvas<'_> {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        self.size
    }

    fn ensure_prepared(&mut self) -> Drawn {
        Ok(())
    }

    fn present(&mut self) -> Drawn {
        self.close();
        Ok(())
    }

    fn draw_pixel(&mut self, point: BackendCoord, color: BackendColor) -> Drawn {
        self.draw_circle(point, 1, &color, true)
    }

    fn draw_line<S: BackendStyle>(
        &mut self,
        from: BackendCoord,
        to: BackendCoord,
        style: &S,
    ) -> Drawn {
        self.draw_path([from, to], style)
    }

    fn draw_rect<S: BackendStyle>(
        &mut self,
        (x0, y0): BackendCoord,
        (x1, y1): BackendCoord,
        style: &S,
        fill: bool,
    ) -> Drawn {
        let corners = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)];
        if fill {
            return self.fill_polygon(corners, style);
        }
        self.draw_path(
            [corners[0], corners[1], corners[2], corners[3], corners[0]],
            style,
        )
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        path: I,
        style: &S,
    ) -> Drawn {
        if style.color().alpha > 0.0 {
            self.path(
                format!("l {}", class(style.color().rgb)),
                style.stroke_width(),
            );
            self.trace(path);
        }
        Ok(())
    }

    /// Discs are strokes of no length with round ends: many of them share one path.
    fn draw_circle<S: BackendStyle>(
        &mut self,
        (x, y): BackendCoord,
        radius: u32,
        style: &S,
        fill: bool,
    ) -> Drawn {
        if style.color().alpha == 0.0 {
            return Ok(());
        }
        if fill {
            self.path(format!("o {}", class(style.color().rgb)), 2 * radius);
            let _ = write!(self.out, "M{x},{y}h0");
        } else {
            self.path(
                format!("l {}", class(style.color().rgb)),
                style.stroke_width(),
            );
            let r = radius;
            let _ = write!(
                self.out,
                "M{},{y}a{r},{r},0,1,0,{},0a{r},{r},0,1,0,-{},0",
                i64::from(x) - i64::from(r),
                2 * r,
                2 * r
            );
        }
        Ok(())
    }

    fn fill_polygon<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        path: I,
        style: &S,
    ) -> Drawn {
        if style.color().alpha > 0.0 {
            let class = class(style.color().rgb);
            // Overlapping areas must not share a path: even their overlap would be filled once only.
            self.close();
            self.path(format!("f {class}"), 0);
            self.trace(path);
            self.out.push('z');
        }
        Ok(())
    }

    fn draw_text<S: BackendTextStyle>(
        &mut self,
        text: &str,
        style: &S,
        (x, y): BackendCoord,
    ) -> Drawn {
        if style.color().alpha == 0.0 || text.is_empty() {
            return Ok(());
        }
        self.close();
        let size = style.size();
        // Heights of a usual sans-serif face: capitals 0.72 em, so the middle lies 0.36 em above the baseline.
        let drop = match style.anchor().v_pos {
            VPos::Top => 0.78 * size,
            VPos::Center => 0.36 * size,
            VPos::Bottom => -0.22 * size,
        };
        let anchor = match style.anchor().h_pos {
            HPos::Left => "",
            HPos::Center => " text-anchor=\"middle\"",
            HPos::Right => " text-anchor=\"end\"",
        };
        let angle = match style.transform() {
            FontTransform::None => 0,
            FontTransform::Rotate90 => 90,
            FontTransform::Rotate180 => 180,
            FontTransform::Rotate270 => 270,
        };
        #[allow(clippy::cast_possible_truncation)] // a fraction of a font size
        let drop = drop.round() as i32;
        let _ = write!(
            self.out,
            "<text class=\"{}\"{anchor}",
            class(style.color().rgb)
        );
        if angle == 0 {
            let _ = write!(self.out, " x=\"{x}\" y=\"{}\"", y + drop);
        } else {
            let _ = write!(
                self.out,
                " x=\"0\" y=\"{drop}\" transform=\"translate({x} {y}) rotate({angle})\""
            );
        }
        if (size - f64::from(FONT)).abs() > 0.5 {
            let _ = write!(self.out, " font-size=\"{size}\"");
        }
        if matches!(style.style(), FontStyle::Bold) {
            self.out.push_str(" font-weight=\"600\"");
        }
        let _ = write!(self.out, ">{}</text>", html(text));
        Ok(())
    }

    /// By counting characters: no font is at hand, and the answer must not depend on one.
    fn estimate_text_size<S: BackendTextStyle>(
        &self,
        text: &str,
        style: &S,
    ) -> Result<(u32, u32), DrawingErrorKind<Infallible>> {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // sizes of labels
        let size = style.size() as u32;
        Ok((text_width(text, size), size))
    }
}

/// Width of a text in a usual sans-serif face, canvas units.
pub(super) fn text_width(text: &str, size: u32) -> u32 {
    let tenths: u32 = text
        .chars()
        .map(|c| match c {
            'i' | 'j' | 'l' | '.' | ',' | ':' | ';' | '|' | '\'' | '!' | '(' | ')' | '[' | ']'
            | ' ' => 32,
            'm' | 'w' | 'M' | 'W' | '@' => 88,
            c if c.is_uppercase() => 68,
            _ => 56,
        })
        .sum();
    tenths * size / 100
}

//! From a figure to SVG.

mod bars;
mod canvas;
mod frame;
mod heat;
mod lines;
mod ruler;
mod scene;
mod sheet;
pub(crate) mod thin;

use super::{Figure, Plot};
use crate::escape::html;
use crate::{Error, Evidence};
use canvas::{FONT, Paint};
use sheet::{Anchor, Drawn, Sheet, WIDTH};

/// Which axes a drawing has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum View {
    /// The paper's limits.
    Paper,
    /// Everything.
    Full,
}

impl View {
    fn suffix(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::Full => "full",
        }
    }
}

/// The figure as inline SVG without colours of its own: the page's style (or [`STANDALONE`]) gives them.
pub(crate) fn svg(figure: &Figure, view: View, description: &str) -> Result<String, Error> {
    let mut body = String::new();
    let synthetic = figure.evidence == Evidence::Synthetic;
    let limits = match view {
        View::Paper => figure.paper_limits.as_ref(),
        View::Full => None,
    };
    let drawn = match &figure.plot {
        Plot::Lines(plot) => lines::draw(plot, limits, synthetic, &mut body),
        Plot::Bars(plot) => bars::draw(plot, synthetic, &mut body),
        Plot::Heat(plot) => heat::draw(plot, synthetic, &mut body),
        Plot::Drawing(plot) => scene::draw(plot, synthetic, &mut body),
        Plot::Animation(plot) => scene::animate(plot, &figure.id, synthetic, &mut body),
    };
    let height = drawn.map_err(|why| Error::Figure {
        id: figure.id.clone(),
        why,
    })?;
    let (id, view) = (html(&figure.id), view.suffix());
    Ok(format!(
        "<svg class=\"plot\" xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height}\" role=\"img\" \
         aria-labelledby=\"{id}-{view}-t\" aria-describedby=\"{id}-{view}-d\" font-size=\"{FONT}\">\
         <title id=\"{id}-{view}-t\">{title}</title><desc id=\"{id}-{view}-d\">{description}</desc>{body}</svg>",
        title = html(&figure.title),
        description = html(description),
    ))
}

/// A file of its own: the same drawing with the light palette inside.
pub(crate) fn standalone(svg: &str, style: &str) -> String {
    let at = svg.find('>').map_or(svg.len(), |at| at + 1);
    format!(
        "{}<style>{style}</style><rect class=\"p4 f\" width=\"100%\" height=\"100%\"/>{}",
        &svg[..at],
        &svg[at..]
    )
}

/// Room for the stamp above a frame.
fn stamp_height(synthetic: bool) -> i32 {
    if synthetic { 190 } else { 0 }
}

/// The stamp that no figure of stand-in data goes without; its right end is at `at`.
fn stamp(sheet: &Sheet<'_>, at: [f64; 2]) -> Drawn {
    let text = "SYNTHETIC DATA";
    let width = f64::from(canvas::text_width(text, FONT)) + 120.0;
    let [right, middle] = at;
    let (left, top, bottom) = (right - width, middle - 90.0, middle + 90.0);
    let corners = [[left, top], [right, top], [right, bottom], [left, bottom]];
    sheet.area(&corners, Paint::Ground)?;
    sheet.line(
        &[corners[0], corners[1], corners[2], corners[3], corners[0]],
        Paint::Stamp,
        12,
    )?;
    sheet.text(
        text,
        [0.5 * (left + right), middle],
        Anchor::Middle,
        Paint::Stamp,
        FONT - 5,
    )
}

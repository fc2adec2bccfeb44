//! Equations: LaTeX in, MathML out, when the page is built.

use pulldown_latex::config::{DisplayMode, RenderConfig};
use pulldown_latex::{Parser, Storage, push_mathml};

use crate::Error;

/// MathML of a formula; `display` for one on a line of its own.
pub(crate) fn render(latex: &str, display: bool, place: &str) -> Result<String, Error> {
    let refuse = |why: String| Error::Equation {
        place: place.into(),
        latex: latex.into(),
        why,
    };
    let storage = Storage::new();
    let mut events = Vec::new();
    for event in Parser::new(latex, &storage) {
        events.push(Ok::<_, std::convert::Infallible>(
            event.map_err(|error| refuse(error.to_string()))?,
        ));
    }
    let config = RenderConfig {
        display_mode: if display {
            DisplayMode::Block
        } else {
            DisplayMode::Inline
        },
        annotation: None,
        ..RenderConfig::default()
    };
    let mut out = String::new();
    push_mathml(&mut out, events.into_iter(), config).map_err(|error| refuse(error.to_string()))?;
    Ok(out)
}

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
    Ok(spaces_before_scripts(out))
}

/// Takes the space before an operator out of the operator's own script: a script has two children, and with the space as
/// the first of three an exponent stands on the line (`\theta\cos^2` as "θ cos2").
fn spaces_before_scripts(mut markup: String) -> String {
    for script in ["<msup>", "<msub>", "<msubsup>"] {
        let opening = format!("{script}<mspace");
        while let Some(at) = markup.find(&opening) {
            let space = at + script.len();
            let Some(length) = markup[space..].find("/>").map(|end| end + 2) else {
                break;
            };
            let element = markup[space..space + length].to_owned();
            markup.replace_range(at..space + length, &format!("{element}{script}"));
        }
    }
    markup
}

#[cfg(test)]
mod tests {
    use super::render;

    #[test]
    fn an_exponent_of_an_operator_after_a_letter_has_two_children() {
        let found = render(r"\theta\cos^2\theta", true, "test").unwrap();
        assert!(
            found.contains("<msup><mi>cos</mi><mn>2</mn></msup>"),
            "{found}"
        );
        assert!(found.contains("<mspace"), "{found}");
    }
}

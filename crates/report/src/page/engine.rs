//! The template engine: strict about what is undefined, escaping everywhere.

use minijinja::{Environment, UndefinedBehavior, Value};

use crate::Error;

/// Templates by name. Names end in `.html`: that switches escaping on.
const TEMPLATES: [(&str, &str); 7] = [
    ("page.html", include_str!("../../../../report/page.html")),
    (
        "ledger.html",
        include_str!("../../../../report/ledger.html"),
    ),
    ("drift.html", include_str!("../../../../report/drift.html")),
    (
        "figure.html",
        include_str!("../../../../report/figure.html"),
    ),
    ("table.html", include_str!("../../../../report/table.html")),
    (
        "origin.html",
        include_str!("../../../../report/origin.html"),
    ),
    ("chain.html", include_str!("../../../../report/chain.html")),
];

pub(super) struct Engine {
    environment: Environment<'static>,
}

impl Engine {
    pub(super) fn new() -> Result<Self, Error> {
        let mut environment = Environment::new();
        environment.set_undefined_behavior(UndefinedBehavior::Strict);
        for (name, source) in TEMPLATES {
            environment.add_template(name, source)?;
        }
        Ok(Self { environment })
    }

    pub(super) fn render(&self, name: &str, context: Value) -> Result<String, Error> {
        let html = self.environment.get_template(name)?.render(context)?;
        Ok(without_trailing_space(&html))
    }
}

/// Lines that hold nothing but the engine's own blocks leave their indentation behind: validators call that an error.
fn without_trailing_space(html: &str) -> String {
    let lines: Vec<&str> = html.split('\n').map(str::trim_ascii_end).collect();
    lines.join("\n")
}

/// Mark-up that this crate wrote: the engine must not escape it again.
pub(super) fn safe(html: String) -> Value {
    Value::from_safe_string(html)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_template_escapes() {
        assert!(TEMPLATES.iter().all(|(name, _)| name.ends_with(".html")));
    }

    #[test]
    fn lines_end_where_their_text_does() {
        assert_eq!(
            without_trailing_space("<p>\n  \n  a b \n</p>\n"),
            "<p>\n\n  a b\n</p>\n"
        );
    }

    #[test]
    fn what_is_undefined_is_an_error() {
        let engine = Engine::new().unwrap();
        assert!(engine.render("drift.html", minijinja::context! {}).is_err());
    }
}

//! The page: a document becomes one HTML file.

use minijinja::value::Serde;
use minijinja::{Environment, UndefinedBehavior, context};

use crate::{Document, Error};

/// Renders the document as one self-contained HTML file.
///
/// # Errors
/// An unknown value id, a doubled id, a broken link, an unreadable equation, a figure or table that cannot be drawn.
pub fn render(document: &Document) -> Result<String, Error> {
    let mut environment = Environment::new();
    environment.set_undefined_behavior(UndefinedBehavior::Strict);
    environment.add_template("page.html", include_str!("../../../report/page.html"))?;
    Ok(environment
        .get_template("page.html")?
        .render(context! { document => Serde(document) })?)
}

//! Texts that name values instead of holding numbers.
//!
//! | written | shown |
//! |---|---|
//! | `{{ v("envelope.gain.pitch0") }}` | the value with its unit; digits follow from its interval, else four significant |
//! | `{{ v("envelope.gain.pitch0", 3) }}` | the same to three significant digits |
//! | `{{ n("envelope.gain.pitch0") }}` | the bare number, without unit (also with digits) |
//! | `{{ ci("identification.aluminium.sigma0") }}` | value, 95 % interval and unit |
//! | `{{ ni("identification.aluminium.sigma0") }}` | the same without unit |
//! | `{{ published("identification.aluminium.sigma0") }}` | the published number as printed |
//! | `*word*`, `**word**`, `` `word` `` | emphasis, strong, code |
//! | `$\theta_c/\sigma$` | inline mathematics, LaTeX in, MathML out |
//! | `[Table 1](#table-1)` | a link to a part of this page (or to an `https:` address, which is not loaded) |
//!
//! A blank line ends a paragraph. A backslash takes the meaning from the next character. Whatever does not come from
//! the author of the text (names in metadata, file names, messages) goes through [`literal`] first.

mod reader;
mod typeset;

use serde::{Deserialize, Serialize};

pub(crate) use reader::Lookup;
pub(crate) use typeset::letters;
pub use typeset::{typeset, typeset_prose};

/// A text with the mark-up described in this module.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Prose(pub String);

impl Prose {
    /// Whether there is nothing to show.
    pub fn is_empty(&self) -> bool {
        self.0.trim().is_empty()
    }
}

impl From<&str> for Prose {
    fn from(text: &str) -> Self {
        Self(text.into())
    }
}

impl From<String> for Prose {
    fn from(text: String) -> Self {
        Self(text)
    }
}

/// The text with every character of the mark-up made harmless: for names and messages that the author did not write.
pub fn literal(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for character in text.chars() {
        if matches!(character, '\\' | '{' | '}' | '*' | '`' | '$' | '[' | ']') {
            out.push('\\');
        }
        out.push(if character.is_control() {
            ' '
        } else {
            character
        });
    }
    out
}

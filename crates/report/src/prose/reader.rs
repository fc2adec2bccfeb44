//! From the mark-up of [`Prose`] to HTML.

use std::collections::{BTreeMap, BTreeSet};

use crate::escape::html;
use crate::{Error, Prose, Value, mathml, number};

/// What texts may refer to: the values by id and the ids of the page.
#[derive(Debug, Default)]
pub(crate) struct Lookup<'a> {
    values: BTreeMap<&'a str, &'a Value>,
    ids: BTreeSet<String>,
}

impl<'a> Lookup<'a> {
    /// Values and the ids that links may aim at.
    pub(crate) fn new(values: &'a [Value], ids: BTreeSet<String>) -> Self {
        Self {
            values: values.iter().map(|v| (v.id.as_str(), v)).collect(),
            ids,
        }
    }

    /// The value with this id.
    pub(crate) fn value(&self, id: &str, place: &str) -> Result<&'a Value, Error> {
        self.values
            .get(id)
            .copied()
            .ok_or_else(|| Error::UnknownValue {
                place: place.into(),
                id: id.into(),
            })
    }

    /// Whether something on the page has this id.
    pub(crate) fn has(&self, id: &str) -> bool {
        self.ids.contains(id)
    }

    /// A link to a part of the page, or the bare text where that part is absent from this page.
    pub(crate) fn link(&self, id: &str, text: &str) -> String {
        if self.has(id) {
            format!("<a href=\"#{}\">{}</a>", html(id), html(text))
        } else {
            html(text)
        }
    }

    /// One line of text, without paragraphs.
    pub(crate) fn inline(&self, prose: &Prose, place: &str) -> Result<String, Error> {
        Reader::new(&prose.0, self, place).all()
    }

    /// Paragraphs.
    pub(crate) fn paragraphs(&self, prose: &Prose, place: &str) -> Result<String, Error> {
        let mut out = String::new();
        for paragraph in prose.0.split("\n\n").filter(|p| !p.trim().is_empty()) {
            out.push_str("<p>");
            out.push_str(&Reader::new(paragraph.trim(), self, place).all()?);
            out.push_str("</p>");
        }
        Ok(out)
    }

    /// The text without mark-up, for attributes and files.
    pub(crate) fn plain(&self, prose: &Prose, place: &str) -> Result<String, Error> {
        let marked = self.inline(prose, place)?;
        let mut out = String::with_capacity(marked.len());
        let mut inside = false;
        for character in marked.chars() {
            match character {
                '<' => inside = true,
                '>' => inside = false,
                c if !inside => out.push(c),
                _ => {}
            }
        }
        Ok(out
            .replace("&lt;", "<")
            .replace("&gt;", ">")
            .replace("&quot;", "\"")
            .replace("&#39;", "'")
            .replace("&amp;", "&"))
    }
}

/// Reads one text from left to right.
struct Reader<'t, 'l, 'v> {
    rest: &'t str,
    lookup: &'l Lookup<'v>,
    place: &'l str,
}

impl<'t, 'l, 'v> Reader<'t, 'l, 'v> {
    fn new(text: &'t str, lookup: &'l Lookup<'v>, place: &'l str) -> Self {
        Self {
            rest: text,
            lookup,
            place,
        }
    }

    fn refuse(&self, why: impl Into<String>) -> Error {
        Error::Prose {
            place: self.place.into(),
            why: why.into(),
        }
    }

    fn all(mut self) -> Result<String, Error> {
        let mut out = String::new();
        let mut open: Vec<&'static str> = Vec::new();
        while let Some(character) = self.rest.chars().next() {
            if let Some(rest) = self.rest.strip_prefix("{{") {
                let (inside, after) = rest
                    .split_once("}}")
                    .ok_or_else(|| self.refuse("a `{{` is not closed"))?;
                out.push_str(&self.placeholder(inside.trim())?);
                self.rest = after;
            } else if let Some(rest) = self.rest.strip_prefix("**") {
                toggle(&mut out, &mut open, "strong");
                self.rest = rest;
            } else {
                self.rest = &self.rest[character.len_utf8()..];
                match character {
                    '\\' => {
                        if let Some(next) = self.rest.chars().next() {
                            out.push_str(&html(&next.to_string()));
                            self.rest = &self.rest[next.len_utf8()..];
                        }
                    }
                    '*' => toggle(&mut out, &mut open, "em"),
                    '`' => {
                        let code = self.until('`')?;
                        out.push_str(&format!("<code>{}</code>", html(&code)));
                    }
                    '$' => {
                        let latex = self.until('$')?;
                        out.push_str(&mathml::render(&latex, false, self.place)?);
                    }
                    '[' => out.push_str(&self.link()?),
                    other => out.push_str(&html(&other.to_string())),
                }
            }
        }
        if let Some(tag) = open.pop() {
            return Err(self.refuse(format!("<{tag}> is not closed")));
        }
        Ok(out)
    }

    /// Everything up to the next `end`, which is consumed; a backslash keeps the next character.
    fn until(&mut self, end: char) -> Result<String, Error> {
        let mut taken = String::new();
        let mut characters = self.rest.char_indices();
        while let Some((at, character)) = characters.next() {
            if character == end {
                self.rest = &self.rest[at + character.len_utf8()..];
                return Ok(taken);
            }
            taken.push(character);
            // In mathematics a backslash belongs to the command; only an escaped end mark loses it.
            if character == '\\' && self.rest[at + 1..].starts_with(end) {
                taken.pop();
                taken.push(end);
                characters.next();
            }
        }
        Err(self.refuse(format!("`{end}` is not closed")))
    }

    /// `label](#target)` after the opening bracket.
    fn link(&mut self) -> Result<String, Error> {
        let label = self.until(']')?;
        let Some(rest) = self.rest.strip_prefix('(') else {
            return Ok(html(&format!("[{label}]")));
        };
        self.rest = rest;
        let target = self.until(')')?;
        let inner = Reader::new(&label, self.lookup, self.place).all()?;
        if let Some(id) = target.strip_prefix('#') {
            return Ok(if self.lookup.has(id) {
                format!("<a href=\"#{}\">{inner}</a>", html(id))
            } else {
                inner
            });
        }
        if !target.starts_with("https://") {
            return Err(self.refuse(format!(
                "a link aims at `{target}`: neither `#id` nor `https://`"
            )));
        }
        Ok(format!(
            "<a href=\"{}\" rel=\"noreferrer\">{inner}</a>",
            html(&target)
        ))
    }

    /// `v("id")`, `v("id", 3)`, `n(...)`, `ci("id")`, `published("id")`.
    fn placeholder(&self, call: &str) -> Result<String, Error> {
        let refuse = || {
            self.refuse(format!(
                "`{call}` is none of v, n, ci, ni, published with an id in quotes"
            ))
        };
        let (name, rest) = call.split_once('(').ok_or_else(refuse)?;
        let arguments = rest.strip_suffix(')').ok_or_else(refuse)?;
        let (id, digits) = match arguments.split_once(',') {
            Some((id, digits)) => (id, Some(digits.trim().parse::<u8>().map_err(|_| refuse())?)),
            None => (arguments, None),
        };
        let id = id.trim().trim_matches('"');
        let value = self.lookup.value(id, self.place)?;
        let name = name.trim();
        if name == "published" {
            return Ok(match &value.published {
                Some(printed) => html(&number::with_unit(printed, &value.unit)),
                None => html("not published"),
            });
        }
        let Some(bare) = value.value else {
            return Ok("<span class=\"absent\">no result</span>".into());
        };
        let text = match (name, digits, value.ci95) {
            ("ci" | "ni", _, Some(interval)) => number::with_interval(bare, interval),
            ("v" | "n" | "ci" | "ni", Some(digits), _) => number::significant(bare, digits),
            ("v" | "n", None, Some(interval)) => {
                number::significant(bare, number::digits_of(bare, interval))
            }
            ("v" | "n" | "ci" | "ni", None, None) => number::plain(bare),
            _ => return Err(refuse()),
        };
        let text = if matches!(name, "n" | "ni") {
            text
        } else {
            number::with_unit(&text, &value.unit)
        };
        Ok(format!(
            "<data value=\"{}\" title=\"{}\">{}</data>",
            number::exact(bare),
            html(id),
            html(&text)
        ))
    }
}

fn toggle(out: &mut String, open: &mut Vec<&'static str>, tag: &'static str) {
    if open.last() == Some(&tag) {
        open.pop();
        out.push_str(&format!("</{tag}>"));
    } else {
        open.push(tag);
        out.push_str(&format!("<{tag}>"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Evidence, literal};

    fn values() -> Vec<Value> {
        vec![
            Value::new("a.b", 1.640_123, "1/rad", "s", Evidence::Computed)
                .with_ci95(1.622, 1.658)
                .with_published("1.64"),
            Value::new("c", f64::NAN, "1", "s", Evidence::Computed),
        ]
    }

    fn read(text: &str) -> Result<String, Error> {
        let values = values();
        let ids = BTreeSet::from(["C01".to_string()]);
        Lookup::new(&values, ids).inline(&Prose::from(text), "test")
    }

    #[test]
    fn values_come_by_id() {
        let html = read(
            "{{ v(\"a.b\") }} and {{ ci(\"a.b\") }}; {{ n(\"a.b\", 2) }}; {{ published(\"a.b\") }}",
        )
        .unwrap();
        assert!(html.contains(">1.640\u{202f}rad⁻¹</data>"), "{html}");
        assert!(
            html.contains(">1.640 [1.622, 1.658]\u{202f}rad⁻¹</data>"),
            "{html}"
        );
        assert!(html.contains(">1.6</data>"), "{html}");
        assert!(html.ends_with("1.64\u{202f}rad⁻¹"), "{html}");
        assert!(read("{{ v(\"c\") }}").unwrap().contains("no result"));
    }

    #[test]
    fn an_unknown_value_is_an_error_that_names_it() {
        let error = read("{{ v(\"nope\") }}").unwrap_err();
        assert_eq!(error.to_string(), "test: no value has the id `nope`");
        assert!(read("{{ w(\"a.b\") }}").is_err());
        assert!(read("{{ v(\"a.b\"").is_err());
    }

    #[test]
    fn markup() {
        assert_eq!(
            read("*a* **b** `c<` [d](#C01) [e](#none)").unwrap(),
            "<em>a</em> <strong>b</strong> <code>c&lt;</code> <a href=\"#C01\">d</a> e"
        );
        assert!(read("$\\theta_c/\\sigma$").unwrap().contains("<math"));
        assert!(read("*a").is_err());
        assert!(read("[x](javascript:alert)").is_err());
    }

    #[test]
    fn a_literal_stays_what_it_is() {
        let hostile =
            "<script>alert(1)</script> {{ v(\"nope\") }} *a* [x](javascript:y) $\\frac$ `q";
        let html = read(&literal(hostile)).unwrap();
        assert!(!html.contains("<script"), "{html}");
        assert!(
            html.contains("{{ v(&quot;nope&quot;) }} *a* [x](javascript:y) $\\frac$ `q"),
            "{html}"
        );
    }
}

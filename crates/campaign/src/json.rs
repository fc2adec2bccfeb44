//! A cursor over a JSON document that knows where it is, so that every refusal names the entry.

use serde_json::Value;

use crate::refusal::{Problem, Refusal, quoted};

/// An entry of a JSON file with its place.
#[derive(Clone, Debug)]
pub(crate) struct Node<'a> {
    value: &'a Value,
    file: &'a str,
    field: String,
}

impl<'a> Node<'a> {
    /// The whole document.
    pub(crate) fn root(file: &'a str, value: &'a Value) -> Self {
        Self {
            value,
            file,
            field: String::new(),
        }
    }

    /// A refusal about this entry.
    pub(crate) fn refuse(&self, problem: Problem) -> Refusal {
        if self.field.is_empty() {
            Refusal::of(self.file, problem)
        } else {
            Refusal::at_field(self.file, &self.field, problem)
        }
    }

    /// The entry under `key`; an explicit null counts as not there. A value that is no object has no entries.
    pub(crate) fn get(&self, key: &str) -> Option<Self> {
        let value = self.value.get(key).filter(|value| !value.is_null())?;
        Some(Self {
            value,
            file: self.file,
            field: self.join(key),
        })
    }

    /// The entry under `key`, which must be there.
    pub(crate) fn need(&self, key: &str) -> Result<Self, Refusal> {
        self.get(key)
            .ok_or_else(|| Refusal::at_field(self.file, &self.join(key), Problem::Missing))
    }

    fn join(&self, key: &str) -> String {
        if self.field.is_empty() {
            key.to_owned()
        } else {
            format!("{}.{key}", self.field)
        }
    }

    /// This entry as an object.
    pub(crate) fn object(self) -> Result<Self, Refusal> {
        if self.value.is_object() {
            Ok(self)
        } else {
            Err(self.wrong("an object"))
        }
    }

    /// The elements of this array.
    pub(crate) fn array(&self) -> Result<Vec<Self>, Refusal> {
        let elements = self
            .value
            .as_array()
            .ok_or_else(|| self.wrong("an array"))?;
        let place = |index| format!("{}[{index}]", self.field);
        Ok(elements
            .iter()
            .enumerate()
            .map(|(index, value)| Self {
                value,
                file: self.file,
                field: place(index),
            })
            .collect())
    }

    /// This entry as text.
    pub(crate) fn text(&self) -> Result<&'a str, Refusal> {
        self.value.as_str().ok_or_else(|| self.wrong("a text"))
    }

    /// This entry as a number; JSON numbers that overflow a double are refused by the parser.
    pub(crate) fn number(&self) -> Result<f64, Refusal> {
        self.value
            .as_f64()
            .filter(|number| number.is_finite())
            .ok_or_else(|| self.wrong("a finite number"))
    }

    /// This entry as a number above zero.
    pub(crate) fn positive(&self) -> Result<f64, Refusal> {
        let number = self.number()?;
        if number > 0.0 {
            Ok(number)
        } else {
            Err(self.refuse(Problem::NotPositive(number)))
        }
    }

    /// This entry as a whole number from 0.
    pub(crate) fn count(&self) -> Result<u32, Refusal> {
        self.value
            .as_u64()
            .and_then(|number| u32::try_from(number).ok())
            .ok_or_else(|| self.wrong("a whole number"))
    }

    /// This entry as true or false.
    pub(crate) fn truth(&self) -> Result<bool, Refusal> {
        self.value
            .as_bool()
            .ok_or_else(|| self.wrong("true or false"))
    }

    /// This entry as one of some words.
    pub(crate) fn word<T: Copy>(&self, words: &[(&str, T)]) -> Result<T, Refusal> {
        let text = self.text()?;
        words
            .iter()
            .find(|(word, _)| *word == text)
            .map(|(_, value)| *value)
            .ok_or_else(|| {
                let known = words
                    .iter()
                    .map(|(word, _)| *word)
                    .collect::<Vec<_>>()
                    .join(", ");
                self.refuse(Problem::UnknownWord {
                    found: quoted(text, 40),
                    known,
                })
            })
    }

    fn wrong(&self, expected: &'static str) -> Refusal {
        self.refuse(Problem::WrongType { expected })
    }
}

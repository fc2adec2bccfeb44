//! A cursor over a JSON document that knows where it is, so that every refusal names the entry.

use std::fmt;

use serde::de::{Deserialize, Deserializer, Error, MapAccess, SeqAccess, Visitor};
use serde_json::{Map, Value};

use crate::refusal::{Problem, Refusal, quoted};

/// Reads a document. An object with a key that stands twice is refused: which of the two is meant, nobody can tell.
pub(crate) fn parse(file: &str, text: &[u8]) -> Result<Value, Refusal> {
    let Strict(value) = serde_json::from_slice(text).map_err(|error| {
        let what = quoted(&error.to_string(), 200);
        // Any value is welcome, so that the only complaint about data is our own.
        let problem = if error.is_data() {
            Problem::DoubledKey(what)
        } else {
            Problem::Json(what)
        };
        Refusal::of(file, problem)
    })?;
    Ok(value)
}

/// A JSON value whose objects hold every key once.
struct Strict(Value);

impl<'de> Deserialize<'de> for Strict {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(StrictVisitor).map(Self)
    }
}

struct StrictVisitor;

impl<'de> Visitor<'de> for StrictVisitor {
    type Value = Value;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("JSON")
    }

    fn visit_bool<E>(self, value: bool) -> Result<Value, E> {
        Ok(Value::from(value))
    }

    fn visit_i64<E>(self, value: i64) -> Result<Value, E> {
        Ok(Value::from(value))
    }

    fn visit_u64<E>(self, value: u64) -> Result<Value, E> {
        Ok(Value::from(value))
    }

    fn visit_f64<E>(self, value: f64) -> Result<Value, E> {
        Ok(Value::from(value))
    }

    fn visit_str<E>(self, value: &str) -> Result<Value, E> {
        Ok(Value::from(value))
    }

    fn visit_unit<E>(self) -> Result<Value, E> {
        Ok(Value::Null)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut elements: A) -> Result<Value, A::Error> {
        let mut array = Vec::new();
        while let Some(Strict(element)) = elements.next_element()? {
            array.push(element);
        }
        Ok(Value::Array(array))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<Value, A::Error> {
        let mut object = Map::new();
        while let Some(key) = entries.next_key::<String>()? {
            if object.contains_key(&key) {
                return Err(A::Error::custom(format!("`{key}` stands twice")));
            }
            let Strict(value) = entries.next_value()?;
            object.insert(key, value);
        }
        Ok(Value::Object(object))
    }
}

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

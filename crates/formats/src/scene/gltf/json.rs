//! JSON text as a tree that borrows from it.
//!
//! Objects keep the order of their keys, and a key that comes twice is an
//! error: the readers of the world disagree on which of the two counts. Texts
//! without escapes are not copied, so that a buffer in the text costs nothing
//! before it is decoded.
//!
//! Source: Bray, *The JavaScript Object Notation (JSON) Data Interchange
//! Format*, RFC 8259, 2017.

use crate::error::{SceneError, SceneErrorKind, Source};
use crate::limits::Limits;
use crate::shown::shown;
use serde::de::{DeserializeSeed, Deserializer, Error, MapAccess, SeqAccess, Visitor};
use std::borrow::Cow;
use std::cell::Cell;
use std::collections::HashSet;
use std::fmt;
use std::path::Path;

/// A JSON value.
#[derive(Debug, PartialEq)]
pub(super) enum Json<'j> {
    Null,
    Flag(bool),
    Number(f64),
    Text(Cow<'j, str>),
    List(Vec<Json<'j>>),
    /// Every key once, in the order of the text.
    Object(Vec<(Cow<'j, str>, Json<'j>)>),
}

/// Levels that the parser goes down itself, whatever the limits.
const DEEPEST: u64 = 120;

/// An object with more keys is searched for duplicates by a set.
const FEW_KEYS: usize = 16;

/// The value in a text of UTF-8, a byte order mark before it allowed. `chunk` says that the text
/// is a part of the file at `path`: places are then told in words.
pub(super) fn parse<'j>(
    text: &'j [u8],
    path: &Path,
    chunk: bool,
    limits: &Limits,
) -> Result<Json<'j>, SceneError> {
    let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
    let allowed = limits.nesting.min(DEEPEST);
    let too_deep = Cell::new(false);
    let mut parser = serde_json::Deserializer::from_slice(text);
    let seed = Level { depth: 0, allowed, too_deep: &too_deep };
    let json = seed.deserialize(&mut parser).and_then(|json| parser.end().map(|()| json));
    json.map_err(|error| {
        let (line, column) = (error.line(), characters(text, error.line(), error.column()));
        let said = error.to_string();
        let said = if text.trim_ascii().is_empty() {
            "it is empty"
        } else if error.is_eof() {
            "it ends in the middle of a value"
        } else if text.contains(&0) {
            "this is no glTF document"
        } else {
            said.rsplit_once(" at line ").map_or(&*said, |(what, _)| what)
        };
        let kind = if too_deep.get() {
            SceneErrorKind::Limit { what: "levels of nesting", asked: allowed + 1, allowed }
        } else if chunk {
            let what = format!("its JSON, line {line}, column {column}: {said}");
            return SceneError::invalid_file(path, what);
        } else {
            SceneErrorKind::Invalid(said.to_owned())
        };
        let at =
            if chunk { Source::file(path) } else { Source::at(path, line as u32, column as u32) };
        SceneError { at, kind }
    })
}

/// A column in characters, from 1, for one in bytes of a line counted from 1.
fn characters(text: &[u8], line: usize, column: usize) -> usize {
    let line = text.split(|&b| b == b'\n').nth(line.saturating_sub(1)).unwrap_or_default();
    let before = &line[..column.saturating_sub(1).min(line.len())];
    String::from_utf8_lossy(before).chars().count() + 1
}

/// Reads a value so many levels down.
#[derive(Clone, Copy)]
struct Level<'c> {
    depth: u64,
    allowed: u64,
    too_deep: &'c Cell<bool>,
}

impl Level<'_> {
    fn below<E: Error>(self) -> Result<Self, E> {
        if self.depth == self.allowed {
            self.too_deep.set(true);
            return Err(E::custom("too deep"));
        }
        Ok(Self { depth: self.depth + 1, ..self })
    }
}

impl<'de> DeserializeSeed<'de> for Level<'_> {
    type Value = Json<'de>;

    fn deserialize<D: Deserializer<'de>>(self, parser: D) -> Result<Json<'de>, D::Error> {
        parser.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Level<'_> {
    type Value = Json<'de>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a JSON value")
    }

    fn visit_unit<E: Error>(self) -> Result<Json<'de>, E> {
        Ok(Json::Null)
    }

    fn visit_bool<E: Error>(self, flag: bool) -> Result<Json<'de>, E> {
        Ok(Json::Flag(flag))
    }

    fn visit_u64<E: Error>(self, number: u64) -> Result<Json<'de>, E> {
        Ok(Json::Number(number as f64))
    }

    fn visit_i64<E: Error>(self, number: i64) -> Result<Json<'de>, E> {
        Ok(Json::Number(number as f64))
    }

    fn visit_f64<E: Error>(self, number: f64) -> Result<Json<'de>, E> {
        Ok(Json::Number(number))
    }

    fn visit_borrowed_str<E: Error>(self, text: &'de str) -> Result<Json<'de>, E> {
        Ok(Json::Text(Cow::Borrowed(text)))
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Json<'de>, E> {
        Ok(Json::Text(Cow::Owned(text.to_owned())))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Json<'de>, A::Error> {
        let below = self.below()?;
        let mut list = Vec::new();
        while let Some(item) = items.next_element_seed(below)? {
            list.push(item);
        }
        Ok(Json::List(list))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<Json<'de>, A::Error> {
        let below = self.below()?;
        let mut object: Vec<(Cow<'de, str>, Json<'de>)> = Vec::new();
        let mut many: HashSet<Cow<'de, str>> = HashSet::new();
        while let Some(key) = entries.next_key_seed(Key)? {
            if object.len() == FEW_KEYS {
                many.extend(object.iter().map(|(key, _)| key.clone()));
            }
            let again = match object.len() < FEW_KEYS {
                true => object.iter().any(|(other, _)| *other == key),
                false => !many.insert(key.clone()),
            };
            if again {
                return Err(A::Error::custom(format_args!("\"{}\" comes twice", shown(&key))));
            }
            object.push((key, entries.next_value_seed(below)?));
        }
        Ok(Json::Object(object))
    }
}

/// Reads the key of an object.
struct Key;

impl<'de> DeserializeSeed<'de> for Key {
    type Value = Cow<'de, str>;

    fn deserialize<D: Deserializer<'de>>(self, parser: D) -> Result<Cow<'de, str>, D::Error> {
        parser.deserialize_str(self)
    }
}

impl<'de> Visitor<'de> for Key {
    type Value = Cow<'de, str>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a key")
    }

    fn visit_borrowed_str<E: Error>(self, text: &'de str) -> Result<Cow<'de, str>, E> {
        Ok(Cow::Borrowed(text))
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Cow<'de, str>, E> {
        Ok(Cow::Owned(text.to_owned()))
    }
}

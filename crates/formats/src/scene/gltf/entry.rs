//! Values of a document with their places, read as what they must be.
//!
//! A place is told as one would write it in a program:
//! `meshes[3].primitives[0].attributes.POSITION`. It is a chain of borrowed
//! links, and becomes text only in an error or a note.

use super::json::Json;
use crate::error::SceneErrorKind;
use crate::shown::shown;
use std::borrow::Cow;
use std::cell::RefCell;
use std::collections::HashMap;
use std::fmt;

/// What reading a part of a document gives; the file is added by whoever opened it.
pub(super) type Result<T> = std::result::Result<T, SceneErrorKind>;

/// Where a value stands.
#[derive(Clone, Copy)]
pub(super) enum Place<'p> {
    Root,
    Key(&'p Place<'p>, &'p str),
    Item(&'p Place<'p>, usize),
    Extension(&'p Place<'p>, &'p str),
}

impl fmt::Display for Place<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Root => write!(f, "the document"),
            Self::Key(Self::Root, key) => write!(f, "{}", shown(key)),
            Self::Key(parent, key) => write!(f, "{parent}.{}", shown(key)),
            Self::Item(parent, i) => write!(f, "{parent}[{i}]"),
            Self::Extension(Self::Root, name) => write!(f, "extensions.{}", shown(name)),
            Self::Extension(parent, name) => write!(f, "{parent}.extensions.{}", shown(name)),
        }
    }
}

/// What a person should know of a document: each kind of thing once, with how often and where
/// it came first.
#[derive(Default)]
pub(super) struct Notes(RefCell<Vec<(&'static str, String, u64)>>);

impl Notes {
    /// Counts one more of `what`; `first` says where, or what else is to be told of the first.
    pub(super) fn add(&self, what: &'static str, first: impl FnOnce() -> String) {
        let mut notes = self.0.borrow_mut();
        match notes.iter_mut().find(|(other, _, _)| *other == what) {
            Some((_, _, count)) => *count += 1,
            None => notes.push((what, first(), 1)),
        }
    }

    /// One line each.
    pub(super) fn lines(self) -> Vec<String> {
        let line = |(what, first, count)| match count {
            1 => format!("{what}: {first}"),
            _ => format!("{what}: {count} (first {first})"),
        };
        self.0.into_inner().into_iter().map(line).collect()
    }
}

/// A value and its place.
#[derive(Clone, Copy)]
pub(super) struct Entry<'p, 'j> {
    json: &'j Json<'j>,
    pub(super) place: Place<'p>,
    pub(super) notes: &'j Notes,
}

impl<'j> Entry<'_, 'j> {
    /// The whole document.
    pub(super) fn root(json: &'j Json<'j>, notes: &'j Notes) -> Self {
        Self { json, place: Place::Root, notes }
    }

    /// That something is wrong here: "… is 7, but …", to follow the place.
    #[cold]
    pub(super) fn wrong(&self, what: impl fmt::Display) -> SceneErrorKind {
        SceneErrorKind::Invalid(format!("{} {what}", self.place))
    }

    /// The same with a colon between, for a whole sentence.
    #[cold]
    pub(super) fn trouble(&self, what: impl fmt::Display) -> SceneErrorKind {
        SceneErrorKind::Invalid(format!("{}: {what}", self.place))
    }

    #[cold]
    fn ill_typed(&self, wanted: &str) -> SceneErrorKind {
        let is = match self.json {
            Json::Null => "null".to_owned(),
            Json::Flag(flag) => flag.to_string(),
            Json::Number(number) => number.to_string(),
            Json::Text(text) => format!("\"{}\"", shown(text)),
            Json::List(_) => "a list".to_owned(),
            Json::Object(_) => "an object".to_owned(),
        };
        self.wrong(format_args!("is {is}, but must be {wanted}"))
    }

    /// The keys and values of an object.
    pub(super) fn object(&self) -> Result<&'j [(Cow<'j, str>, Json<'j>)]> {
        match self.json {
            Json::Object(entries) => Ok(entries),
            _ => Err(self.ill_typed("an object")),
        }
    }

    /// The values of an object by their keys, for objects that may have very many.
    pub(super) fn by_key<'s>(&'s self) -> Result<HashMap<&'s str, Entry<'s, 'j>>> {
        let entry = |(key, json): &'j (Cow<'j, str>, Json<'j>)| {
            (&**key, Entry { json, place: Place::Key(&self.place, key), notes: self.notes })
        };
        Ok(self.object()?.iter().map(entry).collect())
    }

    /// The value of a key of an object; `None` where there is none.
    pub(super) fn get<'s>(&'s self, key: &'s str) -> Result<Option<Entry<'s, 'j>>> {
        let found = self.object()?.iter().find(|(name, _)| name == key);
        let place = Place::Key(&self.place, key);
        Ok(found.map(|(_, json)| Entry { json, place, notes: self.notes }))
    }

    /// The value of a key that must be there.
    pub(super) fn need<'s>(&'s self, key: &'s str) -> Result<Entry<'s, 'j>> {
        self.get(key)?.ok_or_else(|| self.wrong(format_args!("has no \"{key}\"")))
    }

    /// The value of an extension of this object; `None` where it has none.
    pub(super) fn extension<'s>(&'s self, name: &'s str) -> Result<Option<Entry<'s, 'j>>> {
        let Some(extensions) = self.get("extensions")? else { return Ok(None) };
        let found = extensions.object()?.iter().find(|(key, _)| key == name);
        let place = Place::Extension(&self.place, name);
        let entry = found.map(|(_, json)| Entry { json, place, notes: self.notes });
        entry.as_ref().map_or(Ok(()), |entry| entry.object().map(|_| ()))?;
        Ok(entry)
    }

    /// The items of a list.
    pub(super) fn items<'s>(&'s self) -> Result<impl ExactSizeIterator<Item = Entry<'s, 'j>>> {
        let Json::List(list) = self.json else { return Err(self.ill_typed("a list")) };
        Ok(list.iter().enumerate().map(move |(i, json)| Entry {
            json,
            place: Place::Item(&self.place, i),
            notes: self.notes,
        }))
    }

    /// How many items the list of a key has; 0 where there is none.
    pub(super) fn count(&self, key: &str) -> Result<usize> {
        self.get(key)?.map_or(Ok(0), |list| list.items().map(|items| items.len()))
    }

    /// What `read` makes of each item of the list of a key; nothing where there is none.
    pub(super) fn each<T>(
        &self,
        key: &str,
        mut read: impl FnMut(&Entry<'_, 'j>) -> Result<T>,
    ) -> Result<Vec<T>> {
        let Some(list) = self.get(key)? else { return Ok(Vec::new()) };
        list.items()?.map(|item| read(&item)).collect()
    }

    /// A text.
    pub(super) fn text(&self) -> Result<&'j str> {
        match self.json {
            Json::Text(text) => Ok(text),
            _ => Err(self.ill_typed("a text")),
        }
    }

    /// The text of a key; empty where there is none.
    pub(super) fn text_or_empty(&self, key: &str) -> Result<&'j str> {
        self.get(key)?.map_or(Ok(""), |entry| entry.text())
    }

    /// The name of this object; empty where there is none.
    pub(super) fn name(&self) -> Result<String> {
        Ok(self.text_or_empty("name")?.to_owned())
    }

    /// `true` or `false` of a key.
    pub(super) fn flag(&self, key: &str, default: bool) -> Result<bool> {
        let Some(entry) = self.get(key)? else { return Ok(default) };
        match entry.json {
            Json::Flag(flag) => Ok(*flag),
            _ => Err(entry.ill_typed("true or false")),
        }
    }

    /// A number that single precision can hold.
    pub(super) fn number(&self) -> Result<f32> {
        match *self.json {
            Json::Number(number) if (number as f32).is_finite() => Ok(number as f32),
            Json::Number(number) => {
                Err(self.wrong(format_args!("is {number:e}, too large for single precision")))
            }
            _ => Err(self.ill_typed("a number")),
        }
    }

    /// The number of a key.
    pub(super) fn number_or(&self, key: &str, default: f32) -> Result<f32> {
        self.get(key)?.map_or(Ok(default), |entry| entry.number())
    }

    /// A list of exactly `N` numbers.
    pub(super) fn numbers<const N: usize>(&self) -> Result<[f32; N]> {
        let items = self.items()?;
        if items.len() != N {
            return Err(self.wrong(format_args!("has {} numbers, but must have {N}", items.len())));
        }
        let mut numbers = [0.0; N];
        for (number, item) in numbers.iter_mut().zip(items) {
            *number = item.number()?;
        }
        Ok(numbers)
    }

    /// The `N` numbers of a key.
    pub(super) fn numbers_or<const N: usize>(
        &self,
        key: &str,
        default: [f32; N],
    ) -> Result<[f32; N]> {
        self.get(key)?.map_or(Ok(default), |entry| entry.numbers())
    }

    /// The factor of a key, moved into its range, with a note, where it lies outside.
    pub(super) fn factor(&self, key: &str, default: f32, range: [f32; 2]) -> Result<f32> {
        let Some(entry) = self.get(key)? else { return Ok(default) };
        Ok(entry.moved_into(entry.number()?, range))
    }

    /// The factors of a key, each moved into the range as by [`factor`](Self::factor).
    pub(super) fn factors<const N: usize>(
        &self,
        key: &str,
        default: [f32; N],
        range: [f32; 2],
    ) -> Result<[f32; N]> {
        let Some(entry) = self.get(key)? else { return Ok(default) };
        Ok(entry.numbers()?.map(|number| entry.moved_into(number, range)))
    }

    fn moved_into(&self, number: f32, [low, high]: [f32; 2]) -> f32 {
        if !(low..=high).contains(&number) {
            self.notes.add("factors outside their range, moved to its end", || {
                format!("{} is {number}", self.place)
            });
        }
        number.clamp(low, high)
    }

    /// A whole number from 0 to `most`.
    pub(super) fn whole(&self, most: u64) -> Result<u64> {
        match *self.json {
            Json::Number(number)
                if number.fract() == 0.0 && (0.0..=most as f64).contains(&number) =>
            {
                Ok(number as u64)
            }
            Json::Number(number) if number.fract() == 0.0 => {
                Err(self.wrong(format_args!("is {number}, but must lie between 0 and {most}")))
            }
            _ => Err(self.ill_typed("a whole number")),
        }
    }

    /// A length, an offset or a count: what fits into memory and is exact in JSON.
    pub(super) fn size(&self) -> Result<usize> {
        // 2⁵³ - 1, the largest whole number all readers of JSON agree on (RFC 8259, section 6).
        self.whole((1 << 53) - 1).map(|size| usize::try_from(size).unwrap_or(usize::MAX))
    }

    /// The size of a key; 0 where there is none.
    pub(super) fn size_or_zero(&self, key: &str) -> Result<usize> {
        self.get(key)?.map_or(Ok(0), |entry| entry.size())
    }

    /// The number of one of `count` things that are called `what`.
    pub(super) fn index(&self, what: &str, count: usize) -> Result<usize> {
        let index = self.whole(u64::from(u32::MAX))? as usize;
        if index < count {
            return Ok(index);
        }
        Err(self.wrong(match count {
            0 => format!("names {what} {index}, but there are none"),
            1 => format!("names {what} {index}, but there is only one (number 0)"),
            _ => format!("names {what} {index}, but there are only {count} (numbered from 0)"),
        }))
    }

    /// The number of a thing by a key; `None` where there is none.
    pub(super) fn index_of(&self, key: &str, what: &str, count: usize) -> Result<Option<usize>> {
        self.get(key)?.map(|entry| entry.index(what, count)).transpose()
    }
}

//! From TOML to types: every value is read here, and every mistake gets its place.
//!
//! A [`Table`] hands out the values of its keys in three ways: [`Table::must`]
//! for those that have to be there, [`Table::or`] for those with a default,
//! and [`Table::maybe`] for the rest. How a value is read is one of the
//! methods of [`Value`]: `table.or("radius", Value::number, 1.0)`.

use super::document::Document;
use super::{hex, keys};
use crate::error::{SceneError, SceneErrorKind, Source};
use crate::scene::nearest::nearest;
use crate::shown::shown;
use rutilant::color::Rgb;
use rutilant_geom::{Vec2, Vec3};
use toml::de::{DeTable, DeValue};

/// A table of a scene: `[camera]`, one `[[shape]]`, `{ radiance = 5 }`.
#[derive(Clone, Copy)]
pub(super) struct Table<'d> {
    document: &'d Document<'d>,
    /// What people call it: "[camera]", "a sphere".
    name: &'static str,
    entries: &'d DeTable<'d>,
    /// The byte where it starts.
    at: usize,
}

impl<'d> Table<'d> {
    /// The table that holds all others.
    pub(super) fn root(document: &'d Document<'d>, entries: &'d DeTable<'d>) -> Self {
        Self { document, name: "the scene", entries, at: 0 }
    }

    /// The same table under a name that says more.
    pub(super) fn named(self, name: &'static str) -> Self {
        Self { name, ..self }
    }

    /// Something is wrong with the table as a whole.
    pub(super) fn invalid(&self, what: impl Into<String>) -> SceneError {
        self.document.invalid(self.at, what)
    }

    /// Something is wrong with the table as a whole.
    pub(super) fn error(&self, kind: SceneErrorKind) -> SceneError {
        self.document.error(self.at, kind)
    }

    /// The number of the line that it begins in, from 1.
    pub(super) fn line(&self) -> u32 {
        self.document.line(self.at).0
    }

    /// Something that a person should know about the table.
    pub(super) fn note(&self, what: &str) -> String {
        self.document.note(self.at, what)
    }

    /// Something is wrong at some byte of the text.
    pub(super) fn invalid_at(&self, at: usize, what: impl Into<String>) -> SceneError {
        self.document.invalid(at, what)
    }

    /// The value of `key`, if it is there.
    pub(super) fn get(&self, key: &'static str) -> Option<Value<'d>> {
        let value = self.entries.get(key)?;
        Some(Value { document: self.document, key, at: value.span().start, value: value.get_ref() })
    }

    /// What `read` makes of the value of `key`; `None` where it is not there.
    pub(super) fn maybe<T>(
        &self,
        key: &'static str,
        read: impl FnOnce(&Value<'d>) -> Result<T, SceneError>,
    ) -> Result<Option<T>, SceneError> {
        self.get(key).as_ref().map(read).transpose()
    }

    /// What `read` makes of the value of `key`; the default where it is not there.
    pub(super) fn or<T>(
        &self,
        key: &'static str,
        read: impl FnOnce(&Value<'d>) -> Result<T, SceneError>,
        default: T,
    ) -> Result<T, SceneError> {
        Ok(self.maybe(key, read)?.unwrap_or(default))
    }

    /// What `read` makes of the value of `key`, which has to be there.
    pub(super) fn must<T>(
        &self,
        key: &'static str,
        read: impl FnOnce(&Value<'d>) -> Result<T, SceneError>,
    ) -> Result<T, SceneError> {
        self.maybe(key, read)?.ok_or_else(|| self.missing(key))
    }

    /// Which of two keys is there: not both, and not neither.
    pub(super) fn either(&self, keys: [&'static str; 2]) -> Result<&'static str, SceneError> {
        self.at_most_one(&keys)?.ok_or_else(|| {
            self.invalid(format!("{} needs \"{}\" or \"{}\"", self.name, keys[0], keys[1]))
        })
    }

    /// Which of some keys is there, if any. They say the same thing in different ways, so that
    /// two of them would be one too many.
    pub(super) fn at_most_one(
        &self,
        keys: &[&'static str],
    ) -> Result<Option<&'static str>, SceneError> {
        let mut given: Vec<Value<'d>> = keys.iter().filter_map(|key| self.get(key)).collect();
        given.sort_by_key(|value| value.at);
        match given[..] {
            [] => Ok(None),
            [value] => Ok(Some(value.key)),
            [first, second, ..] => {
                Err(second.invalid(format!("give {} or {}, not both", first.key, second.key)))
            }
        }
    }

    /// Refuses keys that are in none of the lists.
    pub(super) fn only(&self, allowed: &[&[&'static str]]) -> Result<(), SceneError> {
        let known = |name: &str| allowed.iter().any(|keys| keys.contains(&name));
        let mut unknown: Vec<(usize, &str)> = self
            .entries
            .keys()
            .map(|key| (key.span().start, &**key.get_ref()))
            .filter(|(_, name)| !known(name))
            .collect();
        unknown.sort_unstable();
        let Some(&(at, name)) = unknown.first() else {
            return Ok(());
        };
        let allowed = || allowed.iter().copied().flatten().copied();
        let (quoted, here) = (shown(name), self.name);
        let kind = match (nearest(name, allowed()), keys::where_it_belongs(name)) {
            (Some(closest), _) => unknown_name("key", name, closest),
            (None, Some(places)) => {
                SceneErrorKind::Invalid(format!("no key \"{quoted}\" in {here}, only in {places}"))
            }
            (None, None) => SceneErrorKind::Invalid(format!(
                "no key \"{quoted}\" in {here}; there are {}",
                list(allowed())
            )),
        };
        Err(self.document.error(at, kind))
    }

    /// The byte that a problem with `key` is about: its value, that of a key that stands for it,
    /// or the table. True where the value is `key`'s own.
    pub(super) fn place_of(&self, key: &str) -> (usize, bool) {
        let own = self.entries.get(key).or_else(|| {
            let mut nested = self.entries.values().filter_map(|value| value.get_ref().as_table());
            nested.find_map(|table| table.get(key))
        });
        let stand_in = || {
            let all = keys::STANDS_FOR.iter().filter(|(name, _)| *name == key || *name == "*");
            all.flat_map(|(_, others)| *others).find_map(|other| self.entries.get(*other))
        };
        let own_key = own.is_some() || keys::STANDS_FOR.iter().any(|(name, _)| *name == key);
        (own.or_else(stand_in).map_or(self.at, |value| value.span().start), own_key)
    }

    /// What is to be added to a problem with the number of `key` that reads otherwise than it is
    /// written.
    pub(super) fn rounded(&self, key: &str) -> Option<String> {
        rounded(self.entries.get(key)?.get_ref())
    }

    /// There should be a `key`.
    pub(super) fn missing(&self, key: &'static str) -> SceneError {
        // A key that nearly has this name is more likely misspelled than superfluous.
        let slip = self
            .entries
            .keys()
            .find(|k| nearest(k.get_ref(), [key]).is_some() && !keys::is_known(k.get_ref()));
        match slip {
            Some(k) => self.document.error(k.span().start, unknown_name("key", k.get_ref(), key)),
            None => self.invalid(format!("{} needs \"{key}\"{}", self.name, keys::hint(key))),
        }
    }
}

/// The value of a key, or an entry of an array that is one.
#[derive(Clone, Copy)]
pub(super) struct Value<'d> {
    document: &'d Document<'d>,
    key: &'static str,
    at: usize,
    value: &'d DeValue<'d>,
}

impl<'d> Value<'d> {
    /// Something is wrong with this value.
    pub(super) fn invalid(&self, what: impl Into<String>) -> SceneError {
        self.document.invalid(self.at, what)
    }

    /// Something is wrong with this value.
    pub(super) fn error(&self, kind: SceneErrorKind) -> SceneError {
        self.document.error(self.at, kind)
    }

    /// Nothing named `name` was declared among `names`.
    pub(super) fn unknown<'n>(
        &self,
        what: &'static str,
        name: &str,
        names: impl IntoIterator<Item = &'n str> + Clone,
    ) -> SceneError {
        self.error(match nearest(name, names.clone()) {
            Some(closest) => unknown_name(what, name, closest),
            None => {
                let known: Vec<_> = names.into_iter().take(MOST_LISTED).collect();
                let there_are = match known.len() {
                    0 => "there is none".to_owned(),
                    1 => format!("there is only {}", list(known)),
                    _ => format!("there are {}", list(known)),
                };
                SceneErrorKind::Invalid(format!("no {what} \"{}\"; {there_are}", shown(name)))
            }
        })
    }

    /// Where it stands.
    pub(super) fn source(&self) -> Source {
        self.invalid("").at
    }

    /// Whether it is a table.
    pub(super) fn is_table(&self) -> bool {
        self.value.is_table()
    }

    /// A finite number.
    pub(super) fn number(&self) -> Result<f32, SceneError> {
        self.finite("a number")
    }

    /// A finite number above 0.
    pub(super) fn positive(&self) -> Result<f32, SceneError> {
        let number = self.number()?;
        let key = self.key;
        if number > 0.0 {
            Ok(number)
        } else {
            let rounded = rounded(self.value).unwrap_or_default();
            Err(self.invalid(format!("{key} is {number}, but must be more than 0{rounded}")))
        }
    }

    /// A whole number from 0 to the largest that `T` holds.
    pub(super) fn whole<T: TryFrom<u64>>(&self) -> Result<T, SceneError> {
        self.as_whole().ok_or_else(|| match self.value.as_integer() {
            Some(number) if !number.as_str().starts_with('-') => {
                self.invalid(format!("{} is too large", self.key))
            }
            _ => self.must_be("a whole number, 0 or more"),
        })
    }

    /// Several whole numbers.
    pub(super) fn wholes<const N: usize>(&self, expected: &str) -> Result<[u32; N], SceneError> {
        self.several(expected, |entry| {
            entry.as_whole().ok_or_else(|| match entry.value.as_integer() {
                Some(number) if !number.as_str().starts_with('-') => {
                    let (key, number) = (entry.key, shown(number.as_str()));
                    entry.invalid(format!("{key} holds {number}, which is too large"))
                }
                _ => entry.must_be(expected),
            })
        })
    }

    /// Several finite numbers.
    pub(super) fn numbers<const N: usize>(&self, expected: &str) -> Result<[f32; N], SceneError> {
        self.several(expected, |entry| entry.finite(expected))
    }

    /// Two numbers.
    pub(super) fn pair(&self) -> Result<Vec2, SceneError> {
        self.numbers("two numbers [x, y]").map(Vec2::from_array)
    }

    /// Three numbers: a point, a direction, sizes.
    pub(super) fn triple(&self) -> Result<Vec3, SceneError> {
        self.numbers("three numbers [x, y, z]").map(Vec3::from_array)
    }

    /// A colour: `[r, g, b]`, a number for grey, or `"#rrggbb"` in sRGB.
    pub(super) fn color(&self) -> Result<Rgb, SceneError> {
        const EXPECTED: &str = "a color ([r, g, b], a number for grey, or \"#rrggbb\" in sRGB)";
        match self.value {
            DeValue::Integer(_) | DeValue::Float(_) => self.number().map(Rgb::grey),
            DeValue::String(text) => hex::color(text).ok_or_else(|| self.must_be(EXPECTED)),
            DeValue::Array(_) => self.numbers(EXPECTED).map(Rgb),
            DeValue::Boolean(_) | DeValue::Datetime(_) | DeValue::Table(_) => {
                Err(self.must_be(EXPECTED))
            }
        }
    }

    /// True or false.
    pub(super) fn flag(&self) -> Result<bool, SceneError> {
        self.value.as_bool().ok_or_else(|| self.must_be("true or false"))
    }

    /// Text in quotes.
    pub(super) fn text(&self) -> Result<&'d str, SceneError> {
        self.value.as_str().ok_or_else(|| self.must_be("a text in quotes"))
    }

    /// One of some names, each of which stands for something.
    pub(super) fn one_of<T: Copy>(
        &self,
        what: &'static str,
        names: &[(&'static str, T)],
    ) -> Result<T, SceneError> {
        let text = self.text()?;
        match names.iter().find(|(name, _)| *name == text) {
            Some((_, meaning)) => Ok(*meaning),
            None => {
                let called = keys::SYNONYMS.iter().find(|(other, _)| *other == text);
                let called = called.filter(|(_, name)| names.iter().any(|(n, _)| n == name));
                Err(match called {
                    Some((_, name)) => self.error(unknown_name(what, text, name)),
                    None => self.unknown(what, text, names.iter().map(|(name, _)| *name)),
                })
            }
        }
    }

    /// A table, by the name people give it.
    pub(super) fn table(&self, name: &'static str) -> Result<Table<'d>, SceneError> {
        let entries = self.value.as_table().ok_or_else(|| match self.value {
            DeValue::Array(_) if name.starts_with('[') => {
                self.invalid(format!("there is only one {name}: write it with single brackets"))
            }
            _ => self.must_be("a table"),
        })?;
        Ok(Table { document: self.document, name, entries, at: self.at })
    }

    /// The tables of an array of tables, by the name people give each.
    pub(super) fn tables(&self, name: &'static str) -> Result<Vec<Table<'d>>, SceneError> {
        if self.value.is_table() {
            let what = format!("there can be several: write {name} with double brackets");
            return Err(self.invalid(what));
        }
        self.entries(&format!("tables like {name}"))?.map(|entry| entry.table(name)).collect()
    }

    /// The entries of an array.
    pub(super) fn entries(
        &self,
        expected: &str,
    ) -> Result<impl ExactSizeIterator<Item = Self> + use<'d>, SceneError> {
        let array = self.value.as_array().ok_or_else(|| self.must_be(expected))?;
        let (document, key) = (self.document, self.key);
        Ok(array.iter().map(move |entry| Self {
            document,
            key,
            at: entry.span().start,
            value: entry.get_ref(),
        }))
    }

    /// Whether it is an array.
    pub(super) fn is_array(&self) -> bool {
        self.value.is_array()
    }

    /// Whether it is a number, finite or not.
    pub(super) fn is_number(&self) -> bool {
        matches!(self.value, DeValue::Integer(_) | DeValue::Float(_))
    }

    /// The value has the wrong type.
    pub(super) fn must_be(&self, expected: &str) -> SceneError {
        self.invalid(format!("{} must be {expected}, not {}", self.key, self.describe()))
    }

    /// What it is, for people.
    fn describe(&self) -> String {
        match self.value {
            DeValue::String(text) => format!("the text \"{}\"", shown(text)),
            DeValue::Integer(number) => format!("the number {}", shown(&number.to_string())),
            DeValue::Float(number) => format!("the number {}", shown(number.as_str())),
            DeValue::Boolean(_) => "a boolean".to_owned(),
            DeValue::Datetime(_) => "a date".to_owned(),
            DeValue::Array(array) => match array.len() {
                1 => "an array with 1 entry".to_owned(),
                n => format!("an array with {n} entries"),
            },
            DeValue::Table(_) => "a table".to_owned(),
        }
    }

    fn finite(&self, expected: &str) -> Result<f32, SceneError> {
        let number = match self.value {
            DeValue::Float(number) => number.as_str().parse().ok(),
            DeValue::Integer(number) if number.radix() == 10 => number.as_str().parse().ok(),
            DeValue::Integer(number) => {
                u128::from_str_radix(number.as_str(), number.radix()).ok().map(|n| n as f32)
            }
            DeValue::String(_)
            | DeValue::Boolean(_)
            | DeValue::Datetime(_)
            | DeValue::Array(_)
            | DeValue::Table(_) => return Err(self.must_be(expected)),
        };
        number.filter(|n: &f32| n.is_finite()).ok_or_else(|| {
            let (key, found) = (self.key, self.describe());
            self.invalid(format!("{key} holds {found}, but must be finite, at most {:e}", f32::MAX))
        })
    }

    fn as_whole<T: TryFrom<u64>>(&self) -> Option<T> {
        let number = self.value.as_integer()?;
        T::try_from(u64::from_str_radix(number.as_str(), number.radix()).ok()?).ok()
    }

    fn several<T, const N: usize>(
        &self,
        expected: &str,
        read: impl Fn(Self) -> Result<T, SceneError>,
    ) -> Result<[T; N], SceneError> {
        let entries = self.entries(expected)?;
        if entries.len() != N {
            return Err(self.must_be(expected));
        }
        let values: Vec<T> = entries.map(read).collect::<Result<_, _>>()?;
        values.try_into().map_err(|_| self.must_be(expected))
    }
}

/// That a number becomes another one in single precision, for people; `None` where the nearest
/// single is written in the same digits.
fn rounded(value: &DeValue<'_>) -> Option<String> {
    let text = value.as_float()?.as_str();
    let single: f32 = text.parse().ok().filter(|n: &f32| n.is_finite())?;
    let mantissa = text.split(['e', 'E']).next().unwrap_or(text);
    let vanishes = single == 0.0 && mantissa.contains(|c: char| ('1'..='9').contains(&c));
    let same = single.to_string().parse::<f64>() == text.parse::<f64>();
    let shows = if (1e-5..1e7).contains(&single.abs()) || single == 0.0 {
        single.to_string()
    } else {
        format!("{single:e}")
    };
    (vanishes || !same).then(|| format!(" ({} is {shows} in single precision)", shown(text)))
}

/// Names in a message that says which there are.
const MOST_LISTED: usize = 20;

fn list<'n>(names: impl IntoIterator<Item = &'n str>) -> String {
    names.into_iter().map(shown).collect::<Vec<_>>().join(", ")
}

fn unknown_name(what: &'static str, name: &str, closest: &str) -> SceneErrorKind {
    SceneErrorKind::Unknown { what, name: shown(name), closest: Some(shown(closest)) }
}

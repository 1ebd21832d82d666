//! What a table says, key by key: the way back from types to TOML.
//!
//! Each reader of a table has beside it a function that gives the [`Group`]s of
//! keys which say what it read. A new scene is written from them, and an edited
//! one is compared by them: only groups that differ are touched.

use rutilant::color::Rgb;
use rutilant_geom::Vec3;
use std::fmt::Write as _;

/// One thing that a table says, by one key or by several that belong together.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Group {
    /// Every key by which the same thing can be said. All in a table are of one group.
    pub(super) family: &'static [&'static str],
    /// The keys by which it is said; none where it goes without saying.
    pub(super) says: Vec<Said>,
}

/// A key with its value.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Said {
    pub(super) key: &'static str,
    pub(super) value: Written,
    /// Whether this is what is meant where the key is not there.
    pub(super) usual: bool,
}

/// A value as it is written.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Written {
    /// A number, a text, an array.
    Plain(String),
    /// A table in the table.
    Table(Vec<Group>),
}

impl Group {
    /// A key that says its thing alone.
    pub(super) fn one(key: &'static [&'static str; 1], value: String) -> Self {
        Self { family: key, says: vec![Said::new(key[0], value)] }
    }

    /// The same with a value that goes without saying if it is the `usual` one.
    pub(super) fn or(key: &'static [&'static str; 1], value: String, usual: &str) -> Self {
        Self { family: key, says: vec![Said::or(key[0], value, usual)] }
    }

    /// A key that may be absent.
    pub(super) fn maybe(key: &'static [&'static str; 1], value: Option<String>) -> Self {
        Self {
            family: key,
            says: value.map(|value| Said::new(key[0], value)).into_iter().collect(),
        }
    }

    /// One of several ways to say a thing.
    pub(super) fn of(family: &'static [&'static str], says: impl Into<Vec<Said>>) -> Self {
        Self { family, says: says.into() }
    }
}

impl Said {
    /// A key that has to be there.
    pub(super) fn new(key: &'static str, value: String) -> Self {
        Self { key, value: Written::Plain(value), usual: false }
    }

    /// A key that is not needed if its value is the `usual` one.
    pub(super) fn or(key: &'static str, value: String, usual: &str) -> Self {
        let usual = value == usual;
        Self { key, value: Written::Plain(value), usual }
    }
}

impl Written {
    /// The text behind the equals sign.
    pub(super) fn text(&self) -> String {
        match self {
            Self::Plain(text) => text.clone(),
            Self::Table(groups) => {
                let entries: Vec<_> = needed(groups)
                    .map(|said| format!("{} = {}", said.key, said.value.text()))
                    .collect();
                if entries.is_empty() {
                    "{}".to_owned()
                } else {
                    format!("{{ {} }}", entries.join(", "))
                }
            }
        }
    }
}

/// The keys that a new table needs.
pub(super) fn needed(groups: &[Group]) -> impl Iterator<Item = &Said> {
    groups.iter().flat_map(|group| &group.says).filter(|said| !said.usual)
}

/// A new table: its header, and a line for each key that it needs.
pub(super) fn table(header: &str, groups: &[Group]) -> String {
    let mut text = format!("{header}\n");
    for said in needed(groups) {
        let _ = writeln!(text, "{} = {}", said.key, said.value.text());
    }
    text
}

/// A number in the fewest digits that read back to it.
pub(super) fn number(value: f32) -> String {
    let whole = value.trunc() == value && value.abs() < 1e7;
    if whole && (value != 0.0 || value.is_sign_positive()) {
        value.to_string()
    } else {
        // With a point or an exponent: a whole number would lose the sign of zero, and large ones
        // are hard to read.
        format!("{value:?}")
    }
}

/// Some numbers in an array.
pub(super) fn numbers<N: ToString>(values: impl IntoIterator<Item = N>) -> String {
    let values: Vec<_> = values.into_iter().map(|value| value.to_string()).collect();
    format!("[{}]", values.join(", "))
}

/// A point or a direction.
pub(super) fn triple(value: Vec3) -> String {
    numbers(value.to_array().map(number))
}

/// A colour: one number where it is grey.
pub(super) fn color(Rgb(channels): Rgb) -> String {
    let [r, g, b] = channels.map(f32::to_bits);
    if r == g && g == b { number(channels[0]) } else { numbers(channels.map(number)) }
}

/// A text in quotes, on one line.
pub(super) fn text(value: &str) -> String {
    let mut quoted = String::with_capacity(value.len() + 2);
    quoted.push('"');
    for c in value.chars() {
        match c {
            '"' => quoted.push_str("\\\""),
            '\\' => quoted.push_str("\\\\"),
            '\n' => quoted.push_str("\\n"),
            '\t' => quoted.push_str("\\t"),
            '\r' => quoted.push_str("\\r"),
            c if c.is_control() => {
                let _ = write!(quoted, "\\u{:04X}", u32::from(c));
            }
            c => quoted.push(c),
        }
    }
    quoted.push('"');
    quoted
}

/// The name in a table that stands for a value, in quotes.
pub(super) fn name<T: PartialEq>(names: &[(&'static str, T)], value: &T) -> String {
    let found = names.iter().find(|(_, meaning)| meaning == value);
    text(found.map_or("", |(name, _)| name))
}

/// The degrees that are read as `radians`, in the fewest digits. A few angles lie between those
/// of two neighbouring numbers of degrees; these get the nearest.
pub(super) fn degrees(radians: f32) -> String {
    let exact = f64::from(radians).to_degrees();
    let reads = |degrees: f32| degrees.to_radians().to_bits() == radians.to_bits();
    let short = (0..10).filter_map(|digits| format!("{exact:.digits$}").parse().ok());
    let near = exact as f32;
    let beside = [near, near.next_up(), near.next_down()];
    let found = short.chain(beside).find(|degrees| reads(*degrees));
    number(found.unwrap_or(near))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is written reads back to the same bits.
    #[test]
    fn numbers_read_back() {
        let mut state = 1_u64;
        let random = (0..100_000).map(|_| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            f32::from_bits((state >> 32) as u32)
        });
        let known = [0.0, -0.0, 1.0, -3.0, 0.1, 1e7, 9_999_999.0, 1e30, f32::MAX, 1e-45, -1e-7];
        for value in known.into_iter().chain(random).filter(|value| value.is_finite()) {
            let written = number(value);
            let read: f32 = written.parse().expect("a number");
            assert_eq!(read.to_bits(), value.to_bits(), "{written}");
        }
        assert_eq!([0.0, -0.0, 12.0, 0.1, 1e30].map(number), ["0", "-0.0", "12", "0.1", "1e30"]);
    }

    /// Every angle that comes of degrees goes back to degrees that give it, and a short one to
    /// itself.
    #[test]
    fn degrees_read_back() {
        let mut state = 7_u64;
        for i in 0..100_000_u32 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let any = (state >> 40) as f32 / 16384.0 - 512.0;
            for given in [any, i as f32 * 0.01 - 500.0] {
                let radians = given.to_radians();
                let read: f32 = degrees(radians).parse().expect("a number");
                assert_eq!(read.to_radians().to_bits(), radians.to_bits(), "{given}");
            }
        }
        for given in ["0", "-0.0", "45", "22.5", "0.1", "-720", "1e-5"] {
            let value: f32 = given.parse().expect("a number");
            assert_eq!(degrees(value.to_radians()), number(value), "{given}");
        }
    }

    /// Whatever a text holds, TOML reads it back.
    #[test]
    fn texts_read_back() {
        for value in ["", "a", "a \"b\" \\ c", "é\u{1f600}", "\n\r\t\0\u{7f}\u{85}", "'''\"\"\""] {
            let written = text(value);
            let read = toml::de::DeValue::parse(&written).expect("a value");
            assert_eq!(read.get_ref().as_str(), Some(value), "{written}");
        }
    }
}

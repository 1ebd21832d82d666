//! The header of a PLY file: which elements follow, how many of each, and what each is made of.
//!
//! It is taken at its word only for what the elements are called; whether there can be so many is
//! for the reader of the body to find out.

use crate::error::{SceneError, SceneErrorKind};
use crate::scene::text::{self, Cursor, place};
use crate::shown::{decode, quoted};
use std::path::Path;

#[derive(Clone, Copy, PartialEq)]
pub(super) enum Format {
    Ascii,
    Little,
    Big,
}

/// The type of a number in a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn from_name(name: &[u8]) -> Option<Self> {
        Some(match name {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    /// Bytes in a binary file.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    pub(super) fn is_integer(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }
}

pub(super) struct Property {
    pub(super) name: String,
    /// The type of the count, if this is a list.
    pub(super) count: Option<Scalar>,
    pub(super) scalar: Scalar,
    /// Where in the header it is declared.
    pub(super) at: usize,
}

pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
    /// Where in the header it is declared.
    pub(super) at: usize,
}

impl Element {
    /// The fewest bytes that one of it takes.
    pub(super) fn least_size(&self, format: Format) -> u64 {
        let each = self.properties.iter().map(|p| match format {
            // A digit and a blank.
            Format::Ascii => 2,
            Format::Little | Format::Big => p.count.unwrap_or(p.scalar).size() as u64,
        });
        each.sum()
    }

    pub(super) fn find(&self, name: &str) -> Option<usize> {
        self.properties.iter().position(|p| p.name == name && p.count.is_none())
    }
}

pub(super) struct Header {
    pub(super) format: Format,
    pub(super) elements: Vec<Element>,
    /// Where the body begins.
    pub(super) end: usize,
}

impl Header {
    pub(super) fn read(bytes: &[u8], path: &Path) -> Result<Self, SceneError> {
        let mut cursor = Cursor::new(bytes);
        if cursor.word() != b"ply" {
            let what = "this is not a PLY file: it does not begin with \"ply\"";
            return Err(SceneError::invalid_file(path, what));
        }
        let mut reader = HeaderReader { bytes, path, cursor };
        let mut format = None;
        let mut elements: Vec<Element> = Vec::new();
        loop {
            reader.next_line()?;
            let (at, keyword) = reader.word();
            match keyword {
                b"" | b"comment" | b"obj_info" => {}
                b"format" => format = Some(reader.format()?),
                b"element" => {
                    let element = reader.element(at, &elements)?;
                    elements.push(element);
                }
                b"property" => {
                    let Some(element) = elements.last_mut() else {
                        return Err(reader.invalid(at, "a property before the first element"));
                    };
                    element.properties.push(reader.property(at)?);
                }
                b"end_header" => break,
                _ => {
                    let what = format!(
                        "no header keyword {}; there are format, comment, obj_info, element, \
                         property and end_header",
                        quoted(keyword)
                    );
                    return Err(reader.invalid(at, what));
                }
            }
        }
        let Some(format) = format else {
            return Err(reader.invalid(reader.cursor.at, "the header has no \"format\" line"));
        };
        reader.skip_line();
        Ok(Self { format, elements, end: reader.cursor.at })
    }
}

/// Reads the lines of a header, word by word.
struct HeaderReader<'a> {
    bytes: &'a [u8],
    path: &'a Path,
    cursor: Cursor<'a>,
}

impl<'a> HeaderReader<'a> {
    /// Goes to the next line, which there must be.
    fn next_line(&mut self) -> Result<(), SceneError> {
        let before = self.cursor.at;
        self.skip_line();
        if self.cursor.peek().is_none() && self.cursor.at == before {
            return Err(self.invalid(before, "the header has no \"end_header\""));
        }
        Ok(())
    }

    /// To the beginning of the next line. Nothing but its own end is taken: the body may begin
    /// there.
    fn skip_line(&mut self) {
        let rest = self.cursor.rest();
        let length = rest.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(rest.len());
        self.cursor.at += length;
        self.cursor.take(b'\r');
        self.cursor.take(b'\n');
    }

    /// The next word of the line, and its place; an empty one where the line has no more.
    fn word(&mut self) -> (usize, &'a [u8]) {
        while self.cursor.peek().is_some_and(text::is_blank) {
            self.cursor.at += 1;
        }
        (self.cursor.at, self.cursor.word())
    }

    /// What follows the keyword `format`.
    fn format(&mut self) -> Result<Format, SceneError> {
        let (at, name) = self.word();
        let format = match name {
            b"ascii" => Format::Ascii,
            b"binary_little_endian" => Format::Little,
            b"binary_big_endian" => Format::Big,
            _ => {
                let what = format!(
                    "no format {}; there are ascii, binary_little_endian and binary_big_endian",
                    quoted(name)
                );
                return Err(self.invalid(at, what));
            }
        };
        match self.word() {
            (_, b"1.0") => Ok(format),
            (at, version) => {
                let what = format!("PLY version {}, but only 1.0 is known", quoted(version));
                Err(self.invalid(at, what))
            }
        }
    }

    /// What follows the keyword `element`, which stands at `at`.
    fn element(&mut self, at: usize, others: &[Element]) -> Result<Element, SceneError> {
        let (name_at, name) = self.word();
        let name = decode(name);
        if others.iter().any(|e| e.name == name) {
            let what = format!("element {} is declared twice", quoted(name.as_bytes()));
            return Err(self.invalid(name_at, what));
        }
        let (count_at, count) = self.word();
        let Some(count) = count_of(count) else {
            let what = format!("{} is not a count of elements", quoted(count));
            return Err(self.invalid(count_at, what));
        };
        Ok(Element { name, count, properties: Vec::new(), at })
    }

    /// What follows the keyword `property`, which stands at `at`.
    fn property(&mut self, at: usize) -> Result<Property, SceneError> {
        let first = self.word();
        let (count, scalar) = if first.1 == b"list" {
            let (count_at, count) = self.word();
            let count = self.scalar((count_at, count))?;
            if !count.is_integer() {
                let what = "the count of a list must be of an integer type";
                return Err(self.invalid(count_at, what));
            }
            let of = self.word();
            (Some(count), self.scalar(of)?)
        } else {
            (None, self.scalar(first)?)
        };
        let (name_at, name) = self.word();
        if name.is_empty() {
            return Err(self.invalid(name_at, "the property has no name"));
        }
        Ok(Property { name: decode(name), count, scalar, at })
    }

    /// The type that a word names.
    fn scalar(&self, (at, word): (usize, &[u8])) -> Result<Scalar, SceneError> {
        Scalar::from_name(word).ok_or_else(|| {
            let what = format!(
                "no type {}; there are char, uchar, short, ushort, int, uint, float and double",
                quoted(word)
            );
            self.invalid(at, what)
        })
    }

    fn invalid(&self, at: usize, what: impl Into<String>) -> SceneError {
        let kind = SceneErrorKind::Invalid(what.into());
        SceneError { at: place(self.path, self.bytes, at), kind }
    }
}

/// A number without sign, and nothing else; one too large comes out as the largest.
fn count_of(word: &[u8]) -> Option<u64> {
    word.first().filter(|byte| byte.is_ascii_digit())?;
    let mut cursor = Cursor::at(word, 0);
    let count = cursor.whole_number()?;
    u64::try_from(count).ok().filter(|_| cursor.rest().is_empty())
}

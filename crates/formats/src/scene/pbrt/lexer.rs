//! Words, texts and brackets out of a scene's text, each with its place.

use crate::error::{SceneError, SceneErrorKind, Source};
use crate::scene::notes::Notes;
use crate::scene::text;
use crate::shown::{decode, quoted};
use std::path::PathBuf;
use std::sync::Arc;

/// A byte in one of the texts that a scene is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Place {
    /// Which text, by its number in [`Texts`].
    pub(super) text: u32,
    /// Which byte of it.
    pub(super) at: usize,
    /// The line, from 1.
    pub(super) line: u32,
}

/// All texts that were read, so that any place can be told.
#[derive(Default)]
pub(super) struct Texts(Vec<(PathBuf, Arc<[u8]>)>);

impl Texts {
    /// Takes one in, and gives a lexer of it.
    pub(super) fn open(&mut self, file: PathBuf, bytes: Vec<u8>) -> Lexer {
        let bytes: Arc<[u8]> = bytes.into();
        let text = self.0.len() as u32;
        self.0.push((file, Arc::clone(&bytes)));
        let at = if bytes.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
        Lexer { bytes, text, at, line: 1, next: None }
    }

    /// File, line and column.
    pub(super) fn source(&self, place: Place) -> Source {
        let (file, bytes) = &self.0[place.text as usize];
        text::place(file, bytes, place.at)
    }

    pub(super) fn error(&self, place: Place, kind: SceneErrorKind) -> SceneError {
        SceneError { at: self.source(place), kind }
    }

    /// The text breaks the format.
    pub(super) fn invalid(&self, place: Place, what: impl Into<String>) -> SceneError {
        self.error(place, SceneErrorKind::Invalid(what.into()))
    }

    /// What is meant is not done here.
    pub(super) fn unsupported(&self, place: Place, what: impl Into<String>) -> SceneError {
        self.error(place, SceneErrorKind::Unsupported(what.into()))
    }
}

impl Notes {
    /// Says it at its place, the first time.
    pub(super) fn say(&mut self, texts: &Texts, place: Place, what: impl Into<String>) {
        let what = what.into();
        self.once(&what, || format!("{}: {what}", texts.source(place)));
    }
}

/// What stands next in a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// Bare letters: the name of a statement, a number, true or false.
    Word,
    /// Letters between quotation marks.
    Text,
    /// `[`
    Open,
    /// `]`
    Close,
}

/// A piece of a text.
#[derive(Clone, Copy, Debug)]
pub(super) struct Token {
    pub(super) kind: Kind,
    pub(super) place: Place,
    /// Where its letters begin and end.
    begin: usize,
    end: usize,
}

/// Goes through a text.
pub(super) struct Lexer {
    bytes: Arc<[u8]>,
    text: u32,
    at: usize,
    line: u32,
    /// What was looked at, but not taken.
    next: Option<Token>,
}

impl Lexer {
    /// The letters of a piece.
    pub(super) fn letters(&self, token: &Token) -> &[u8] {
        &self.bytes[token.begin..token.end]
    }

    /// A piece as a text: backslashes take the next letter as it is.
    pub(super) fn string(&self, token: &Token) -> String {
        let letters = self.letters(token);
        if !letters.contains(&b'\\') {
            return decode(letters);
        }
        let mut plain = Vec::with_capacity(letters.len());
        let mut rest = letters.iter();
        while let Some(&letter) = rest.next() {
            plain.push(match letter {
                b'\\' => match rest.next() {
                    Some(b'n') => b'\n',
                    Some(b't') => b'\t',
                    Some(&other) => other,
                    None => b'\\',
                },
                other => other,
            });
        }
        decode(&plain)
    }

    /// A piece for a message.
    pub(super) fn shown(&self, token: &Token) -> String {
        quoted(self.letters(token))
    }

    /// The place of what comes next.
    pub(super) fn place(&self) -> Place {
        let here = Place { text: self.text, at: self.at, line: self.line };
        self.next.map_or(here, |token| token.place)
    }

    /// What comes next; it comes again. `None` at the end.
    pub(super) fn peek(&mut self, texts: &Texts) -> Result<Option<Token>, SceneError> {
        if self.next.is_none() {
            self.next = self.read(texts)?;
        }
        Ok(self.next)
    }

    /// Takes what comes next; `None` at the end.
    pub(super) fn take(&mut self, texts: &Texts) -> Result<Option<Token>, SceneError> {
        match self.next.take() {
            Some(token) => Ok(Some(token)),
            None => self.read(texts),
        }
    }

    fn read(&mut self, texts: &Texts) -> Result<Option<Token>, SceneError> {
        // Blanks and comments.
        loop {
            match self.bytes.get(self.at) {
                None => return Ok(None),
                Some(b'\n') => {
                    self.line = self.line.saturating_add(1);
                    self.at += 1;
                }
                Some(b'#') => {
                    let rest = &self.bytes[self.at..];
                    let length = rest.iter().position(|byte| matches!(byte, b'\n' | b'\r'));
                    self.at += length.unwrap_or(rest.len());
                }
                Some(&byte) if text::is_space(byte) => self.at += 1,
                Some(_) => break,
            }
        }
        let place = Place { text: self.text, at: self.at, line: self.line };
        let begin = self.at;
        let token = |kind, begin, end| Token { kind, place, begin, end };
        let found = match self.bytes[begin] {
            b'[' => token(Kind::Open, begin, begin + 1),
            b']' => token(Kind::Close, begin, begin + 1),
            b'"' => {
                let mut end = begin + 1;
                loop {
                    match self.bytes.get(end) {
                        Some(b'"') => break,
                        Some(b'\\') if self.bytes.get(end + 1).is_some() => end += 2,
                        Some(b'\n' | b'\r') | None => {
                            return Err(
                                texts.invalid(place, "there is no \" at the end of this text")
                            );
                        }
                        Some(_) => end += 1,
                    }
                }
                self.at = end + 1;
                return Ok(Some(token(Kind::Text, begin + 1, end)));
            }
            _ => {
                let rest = &self.bytes[begin..];
                let ends =
                    |&byte: &u8| text::is_space(byte) || matches!(byte, b'[' | b']' | b'"' | b'#');
                let length = rest.iter().position(ends).unwrap_or(rest.len());
                token(Kind::Word, begin, begin + length)
            }
        };
        self.at = found.end;
        Ok(Some(found))
    }
}

/// The number that all of these letters are; `None` where they are none.
pub(super) fn number(letters: &[u8]) -> Option<f32> {
    let mut cursor = text::Cursor::at(letters, 0);
    let value = cursor.number()?;
    cursor.word_is_done().then_some(value)
}

/// The whole number that all of these letters are.
pub(super) fn whole(letters: &[u8]) -> Option<i64> {
    let mut cursor = text::Cursor::at(letters, 0);
    let value = cursor.whole_number();
    match value.filter(|_| cursor.peek().is_none()) {
        Some(value) => Some(value),
        // Older exporters write 3.0 or 3e0 for 3.
        None => number(letters).filter(|v| v.fract() == 0.0 && v.abs() < 1e9).map(|v| v as i64),
    }
}

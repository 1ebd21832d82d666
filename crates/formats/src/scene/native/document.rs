//! The text of a scene, and what is wrong at which place in it.

use crate::error::{SceneError, SceneErrorKind, Source};
use std::path::Path;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A scene's text and the file it stands in.
pub(super) struct Document<'d> {
    file: &'d Path,
    text: &'d str,
    /// The byte at which each line begins.
    lines: Vec<usize>,
}

impl<'d> Document<'d> {
    pub(super) fn new(text: &'d str, file: &'d Path) -> Self {
        let ends = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n');
        let lines = std::iter::once(0).chain(ends.map(|(end, _)| end + 1)).collect();
        Self { file, text, lines }
    }

    /// The tree of tables and values, each with its place in the text.
    pub(super) fn parse(&self) -> Result<Spanned<DeTable<'d>>, SceneError> {
        DeTable::parse(self.text).map_err(|error| {
            let at = error.span().map_or(0, |span| span.start);
            let message = error.message().trim_end_matches(", expected nothing");
            // The parser's words for this are about itself.
            if message.starts_with("cannot recurse further") {
                return self.invalid(at, "tables and arrays lie too deep in each other here");
            }
            self.invalid(at, format!("{message}{}", self.syntax_hint(at)))
        })
    }

    /// Refuses tables and arrays that lie more than `allowed` levels deep in each other.
    pub(super) fn must_be_shallow(
        &self,
        tree: &DeTable<'_>,
        allowed: u64,
    ) -> Result<(), SceneError> {
        tree.values().try_for_each(|value| self.within(value, 1, allowed))
    }

    /// The same for a value that lies on `level`.
    fn within(
        &self,
        value: &Spanned<DeValue<'_>>,
        level: u64,
        allowed: u64,
    ) -> Result<(), SceneError> {
        let is_scalar = match value.get_ref() {
            DeValue::Table(_) | DeValue::Array(_) => false,
            DeValue::String(_)
            | DeValue::Integer(_)
            | DeValue::Float(_)
            | DeValue::Boolean(_)
            | DeValue::Datetime(_) => true,
        };
        if is_scalar {
            return Ok(());
        }
        if level > allowed {
            let kind = SceneErrorKind::Limit { what: "levels of nesting", asked: level, allowed };
            return Err(self.error(value.span().start, kind));
        }
        let mut deeper = |value| self.within(value, level + 1, allowed);
        let table = value.get_ref().as_table().into_iter().flat_map(|table| table.values());
        let array = value.get_ref().as_array().into_iter().flat_map(|array| array.iter());
        table.chain(array).try_for_each(&mut deeper)
    }

    /// What often lies behind a mistake in the syntax at byte `at`.
    fn syntax_hint(&self, at: usize) -> &'static str {
        let (_, start) = self.line(at);
        let line = self.text[start..].lines().next().unwrap_or("");
        if self.text.trim_start_matches('\u{feff}').trim_start().starts_with(['{', '<']) {
            "; scenes are written in TOML: see docs/scene-format.md"
        } else if self.text.contains('\r') && !self.text.contains('\n') {
            "; the line ends are CR alone: save the file with LF or CR LF"
        } else if line.contains(|c: char| c.is_control() && c != '\t') {
            "; the line holds bytes that are no text"
        } else if line.contains('\\') {
            "; in paths write / instead of \\"
        } else {
            ""
        }
    }

    /// The file breaks the format at byte `at`.
    pub(super) fn invalid(&self, at: usize, what: impl Into<String>) -> SceneError {
        self.error(at, SceneErrorKind::Invalid(what.into()))
    }

    /// Something is wrong at byte `at`.
    pub(super) fn error(&self, at: usize, kind: SceneErrorKind) -> SceneError {
        let (line, start) = self.line(at);
        let before = &self.text[start..self.text.floor_char_boundary(at).max(start)];
        let column = 1 + before.trim_start_matches('\u{feff}').chars().count();
        let column = u32::try_from(column).unwrap_or(u32::MAX);
        SceneError { at: Source::at(self.file, line, column), kind }
    }

    /// Something that a person should know about the line of byte `at`.
    ///
    /// There can be as many notes as shapes, so none of them counts its way along the text.
    pub(super) fn note(&self, at: usize, what: &str) -> String {
        let (line, _) = self.line(at);
        format!("{}: {what}", Source { line, ..Source::file(self.file) })
    }

    /// The number of the line that holds byte `at`, from 1, and the byte where it begins.
    pub(super) fn line(&self, at: usize) -> (u32, usize) {
        let number = self.lines.partition_point(|start| *start <= at).max(1);
        (u32::try_from(number).unwrap_or(u32::MAX), self.lines[number - 1])
    }
}

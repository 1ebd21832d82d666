//! The text of a scene, and what is wrong at which place in it.

use crate::{SceneError, SceneErrorKind, Source};
use std::path::Path;
use toml::Spanned;
use toml::de::DeTable;

/// A scene's text and the file it stands in.
pub(super) struct Document<'d> {
    file: &'d Path,
    text: &'d str,
}

impl<'d> Document<'d> {
    pub(super) fn new(text: &'d str, file: &'d Path) -> Self {
        Self { file, text }
    }

    /// The tree of tables and values, each with its place in the text.
    pub(super) fn parse(&self) -> Result<Spanned<DeTable<'d>>, SceneError> {
        DeTable::parse(self.text).map_err(|error| {
            let at = error.span().map_or(0, |span| span.start);
            let message = error.message().trim_end_matches(", expected nothing");
            self.invalid(at, format!("{message}{}", self.syntax_hint(at)))
        })
    }

    /// What often lies behind a mistake in the syntax at byte `at`.
    fn syntax_hint(&self, at: usize) -> &'static str {
        let line_start =
            self.text[..self.text.floor_char_boundary(at)].rfind('\n').map_or(0, |i| i + 1);
        let line = self.text[line_start..].lines().next().unwrap_or("");
        if line.contains('\\') { "; in paths write / instead of \\" } else { "" }
    }

    /// The file breaks the format at byte `at`.
    pub(super) fn invalid(&self, at: usize, what: impl Into<String>) -> SceneError {
        self.error(at, SceneErrorKind::Invalid(what.into()))
    }

    /// Something is wrong at byte `at`.
    pub(super) fn error(&self, at: usize, kind: SceneErrorKind) -> SceneError {
        let before = &self.text[..self.text.floor_char_boundary(at)];
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        let line = 1 + before.bytes().filter(|b| *b == b'\n').count();
        let column = 1 + before[line_start..].trim_start_matches('\u{feff}').chars().count();
        let count = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
        SceneError { at: Source::at(self.file, count(line), count(column)), kind }
    }
}

//! Why a file was refused, and where.

use crate::limits::Limits;
use std::fmt;
use std::path::PathBuf;

/// A place in a file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Source {
    /// The file.
    pub file: PathBuf,
    /// Line, from 1; 0 where the file has no lines or the whole file is meant.
    pub line: u32,
    /// Column in characters, from 1; 0 where only the line is known.
    pub column: u32,
}

impl Source {
    /// The file as a whole.
    pub fn file(file: impl Into<PathBuf>) -> Self {
        Self { file: file.into(), line: 0, column: 0 }
    }

    /// A line and column, both from 1.
    pub fn at(file: impl Into<PathBuf>, line: u32, column: u32) -> Self {
        Self { file: file.into(), line, column }
    }
}

impl fmt::Display for Source {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file.display())?;
        if self.line > 0 {
            write!(f, ":{}", self.line)?;
            if self.column > 0 {
                write!(f, ":{}", self.column)?;
            }
        }
        Ok(())
    }
}

/// Why a scene was refused, and where: `kitchen.toml:41:17: roughness is 1.7, …`.
#[derive(Debug, thiserror::Error)]
#[error("{at}: {kind}")]
pub struct SceneError {
    /// The place to mend: file, line and column.
    pub at: Source,
    /// What is wrong there.
    pub kind: SceneErrorKind,
}

impl SceneError {
    /// Something is wrong with a file as a whole.
    pub(crate) fn in_file(file: impl Into<PathBuf>, kind: SceneErrorKind) -> Self {
        Self { at: Source::file(file), kind }
    }

    /// A file breaks its own format as a whole.
    pub(crate) fn invalid_file(file: impl Into<PathBuf>, what: impl Into<String>) -> Self {
        Self::in_file(file, SceneErrorKind::Invalid(what.into()))
    }
}

/// Why an image could not be read or written: `sky.hdr: the file ends after 3 of 512 rows`.
#[derive(Debug, thiserror::Error)]
#[error("{}: {what}", file.display())]
pub struct ImageError {
    /// The image's file.
    pub file: PathBuf,
    /// What is wrong, and a hint if there is one.
    pub what: String,
}

impl ImageError {
    pub(crate) fn new(file: impl Into<PathBuf>, what: impl Into<String>) -> Self {
        Self { file: file.into(), what: what.into() }
    }
}

/// What is wrong with a scene.
#[derive(Debug)]
#[non_exhaustive]
pub enum SceneErrorKind {
    /// The file breaks its own format: the author can mend it.
    Invalid(String),
    /// Legal, but not done here (yet): the author can avoid it.
    Unsupported(String),
    /// A name nobody declared, with the nearest one that exists.
    Unknown {
        /// What kind of thing: "key", "material".
        what: &'static str,
        /// The name as written.
        name: String,
        /// The nearest name that would have been right.
        closest: Option<String>,
    },
    /// More memory or depth than the caller allowed.
    Limit {
        /// What there is too much of: "triangles", "bytes".
        what: &'static str,
        /// How much the file asks for.
        asked: u64,
        /// How much [`Limits`](crate::Limits) allows.
        allowed: u64,
    },
    /// The disk, not the file.
    Io(std::io::Error),
}

impl fmt::Display for SceneErrorKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Invalid(what) | Self::Unsupported(what) => write!(f, "{what}"),
            Self::Unknown { what, name, closest: None } => write!(f, "no {what} \"{name}\""),
            Self::Unknown { what, name, closest: Some(closest) } => {
                write!(f, "no {what} \"{name}\"; did you mean \"{closest}\"?")
            }
            Self::Limit { what, asked, allowed } => {
                let hint = Limits::hint(what);
                let what = match (asked, *what) {
                    (1, "levels of nesting") => "level of nesting",
                    (1, "vertices") => "vertex",
                    (1, many) => many.strip_suffix('s').unwrap_or(many),
                    (_, many) => many,
                };
                write!(f, "{asked} {what}, but at most {allowed} are allowed{hint}")
            }
            Self::Io(error) => write!(f, "{error}"),
        }
    }
}

impl std::error::Error for SceneErrorKind {}

#[cfg(test)]
mod tests {
    use super::*;

    /// One is not written as many.
    #[test]
    fn one_is_singular() {
        for (what, one) in [
            ("levels of nesting", "1 level of nesting"),
            ("objects", "1 object"),
            ("vertices", "1 vertex"),
            ("triangles", "1 triangle"),
            ("pixels", "1 pixel"),
            ("bytes", "1 byte"),
        ] {
            let said = |asked| SceneErrorKind::Limit { what, asked, allowed: 0 }.to_string();
            assert!(said(1).starts_with(&format!("{one}, but at most 0")), "{}", said(1));
            assert!(said(2).starts_with(&format!("2 {what}, but at most 0")), "{}", said(2));
        }
    }
}

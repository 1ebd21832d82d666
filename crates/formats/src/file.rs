//! The bytes of a file, if it is a regular file of a size the caller allows.
//!
//! Folders, pipes and devices are refused before they are opened: a folder has
//! no bytes, a pipe may never send any, and a device may never stop.

use crate::Limits;
use std::fmt;
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

/// Why a file gave no bytes.
#[derive(Debug)]
pub(crate) enum Refused {
    /// A folder, a pipe or a device.
    NotAFile(&'static str),
    /// More than [`Limits::file_bytes`].
    TooLarge { asked: u64, allowed: u64 },
    /// The disk's own words.
    Io(io::Error),
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotAFile(what) => write!(f, "this is {what}, not a file"),
            Self::TooLarge { asked, allowed } => {
                write!(f, "{asked} bytes, but at most {allowed} are allowed")
            }
            Self::Io(error) => write!(f, "{error}"),
        }
    }
}

impl From<io::Error> for Refused {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

/// All bytes of the regular file at `path`; symbolic links are followed.
pub(crate) fn bytes(path: &Path, limits: &Limits) -> Result<Vec<u8>, Refused> {
    must_be_regular(&fs::metadata(path)?)?;
    let file = File::open(path)?;
    // What was opened may be something else than what was looked at.
    let metadata = file.metadata()?;
    must_be_regular(&metadata)?;

    let allowed = limits.file_bytes;
    if metadata.len() > allowed {
        return Err(Refused::TooLarge { asked: metadata.len(), allowed });
    }
    let mut bytes = Vec::with_capacity(usize::try_from(metadata.len()).unwrap_or(0));
    // A file may grow while it is read: one byte more than allowed shows it.
    file.take(allowed.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > allowed {
        return Err(Refused::TooLarge { asked: bytes.len() as u64, allowed });
    }
    Ok(bytes)
}

fn must_be_regular(metadata: &fs::Metadata) -> Result<(), Refused> {
    if metadata.is_file() {
        Ok(())
    } else if metadata.is_dir() {
        Err(Refused::NotAFile("a folder"))
    } else {
        Err(Refused::NotAFile("a pipe or a device"))
    }
}

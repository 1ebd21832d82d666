//! The binary container: a JSON chunk and a chunk of bytes in one file.
//!
//! Source: Khronos Group, *glTF 2.0 Specification*, 2021, section 4.4.

use super::entry::{Notes, Result};
use crate::error::SceneErrorKind;

/// What a binary file begins with.
pub(super) const MAGIC: &[u8] = b"glTF";

/// The chunks of a file.
pub(super) struct Chunks<'b> {
    /// The document's text.
    pub(super) json: &'b [u8],
    /// The bytes of its first buffer; `None` where there is no such chunk.
    pub(super) binary: Option<&'b [u8]>,
}

/// Takes a file that begins with [`MAGIC`] apart. Chunks of unknown types are skipped.
pub(super) fn open<'b>(bytes: &'b [u8], notes: &Notes) -> Result<Chunks<'b>> {
    let invalid = |what: String| SceneErrorKind::Invalid(what);
    let (Some(version), Some(length)) = (word(bytes, 4), word(bytes, 8)) else {
        return Err(invalid("the file ends in its header".to_owned()));
    };
    if version != 2 {
        let what = format!("a binary glTF of version {version}; only version 2 is read");
        return Err(SceneErrorKind::Unsupported(what));
    }
    let length = length as usize;
    let bytes = match bytes.get(..length) {
        Some(whole) => {
            let more = bytes.len() - length;
            if more > 0 {
                notes.add("bytes after the end that the header tells, left out", || {
                    more.to_string()
                });
            }
            whole
        }
        None => {
            let what = format!("the file ends after {} of {length} bytes", bytes.len());
            return Err(invalid(what));
        }
    };

    let (mut json, mut binary) = (None, None);
    let mut at = 12;
    let mut number = 0;
    while at < bytes.len() {
        let (Some(size), Some(kind)) = (word(bytes, at), bytes.get(at + 4..at + 8)) else {
            return Err(invalid(format!("the header of chunk {number} is cut off")));
        };
        let rest = &bytes[at + 8..];
        let Some(chunk) = rest.get(..size as usize) else {
            let what = format!("chunk {number} has {size} bytes, but only {} are left", rest.len());
            return Err(invalid(what));
        };
        match kind {
            b"JSON" if json.is_none() && number == 0 => json = Some(chunk),
            b"BIN\0" if binary.is_none() => binary = Some(chunk),
            _ => {}
        }
        at += 8 + size as usize;
        number += 1;
    }
    let Some(json) = json else {
        return Err(invalid("its first chunk is not JSON".to_owned()));
    };
    // Blanks fill a chunk up to four bytes; older exporters took zeros.
    let end = json.iter().rposition(|&byte| byte != 0).map_or(0, |last| last + 1);
    Ok(Chunks { json: &json[..end], binary })
}

/// Four bytes as a number, the lowest first; `None` at the end.
fn word(bytes: &[u8], at: usize) -> Option<u32> {
    let four = bytes.get(at..at.checked_add(4)?)?;
    Some(u32::from_le_bytes(four.try_into().ok()?))
}

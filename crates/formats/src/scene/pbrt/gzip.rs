//! Files that are packed with gzip.

use crate::error::{SceneError, SceneErrorKind};
use crate::limits::Limits;
use flate2::read::MultiGzDecoder;
use std::io::Read;
use std::path::Path;

/// Numbers as text, which meshes and scenes are, hardly shrink to a twentieth; what would grow more
/// than so many times is not believed.
const MOST_GROWTH: u64 = 200;
/// What small files may become whatever they are.
const FREE: u64 = 1 << 20;

/// The content of a file, unpacked if it is packed.
pub(super) fn unpacked(
    bytes: Vec<u8>,
    file: &Path,
    limits: &Limits,
) -> Result<Vec<u8>, SceneError> {
    if !bytes.starts_with(&[0x1f, 0x8b]) {
        return Ok(bytes);
    }
    let believed = (bytes.len() as u64).saturating_mul(MOST_GROWTH).saturating_add(FREE);
    let allowed = believed.min(limits.file_bytes);
    let mut plain = Vec::new();
    MultiGzDecoder::new(&*bytes)
        .take(allowed.saturating_add(1))
        .read_to_end(&mut plain)
        .map_err(|error| SceneError::invalid_file(file, format!("cannot be unpacked: {error}")))?;
    let asked = plain.len() as u64;
    if asked <= allowed {
        return Ok(plain);
    }
    Err(if limits.file_bytes <= believed {
        SceneError::in_file(file, SceneErrorKind::Limit { what: "bytes", asked, allowed })
    } else {
        let what = format!("{} bytes unpack to more than {allowed}", bytes.len());
        SceneError::invalid_file(file, what)
    })
}

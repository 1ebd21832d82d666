//! Files as this crate meets them: their extension, their folder, their bytes.
//!
//! Only regular files of a size that the caller allows are read. Folders,
//! pipes and devices are refused before they are opened: a folder has no
//! bytes, a pipe may never send any, and a device may never stop.

use crate::error::{ImageError, SceneError, SceneErrorKind};
use crate::limits::Limits;
use std::fs::{self, File};
use std::io::Read;
use std::path::Path;

/// All bytes of a scene's file; symbolic links are followed.
pub(crate) fn scene_bytes(path: &Path, limits: &Limits) -> Result<Vec<u8>, SceneError> {
    bytes(path, limits).map_err(|kind| SceneError::in_file(path, kind))
}

/// All bytes of an image's file; symbolic links are followed.
pub(crate) fn image_bytes(path: &Path, limits: &Limits) -> Result<Vec<u8>, ImageError> {
    bytes(path, limits).map_err(|kind| ImageError::new(path, kind.to_string()))
}

fn bytes(path: &Path, limits: &Limits) -> Result<Vec<u8>, SceneErrorKind> {
    must_be_regular(&fs::metadata(path).map_err(SceneErrorKind::Io)?)?;
    let file = File::open(path).map_err(SceneErrorKind::Io)?;
    // What was opened may be something else than what was looked at.
    let metadata = file.metadata().map_err(SceneErrorKind::Io)?;
    must_be_regular(&metadata)?;

    let allowed = limits.file_bytes;
    let must_fit = |asked: u64| match asked <= allowed {
        true => Ok(()),
        false => Err(SceneErrorKind::Limit { what: "bytes", asked, allowed }),
    };
    must_fit(metadata.len())?;
    let mut bytes = Vec::with_capacity(usize::try_from(metadata.len()).unwrap_or(0));
    // A file may grow while it is read: one byte more than allowed shows it.
    let mut file = file.take(allowed.saturating_add(1));
    file.read_to_end(&mut bytes).map_err(SceneErrorKind::Io)?;
    must_fit(bytes.len() as u64)?;
    Ok(bytes)
}

fn must_be_regular(metadata: &fs::Metadata) -> Result<(), SceneErrorKind> {
    match not_regular(metadata) {
        None => Ok(()),
        Some(what) => Err(SceneErrorKind::Invalid(format!("this is {what}, not a file"))),
    }
}

/// What stands there instead of a regular file, for people; `None` for a regular file.
pub(crate) fn not_regular(metadata: &fs::Metadata) -> Option<&'static str> {
    if metadata.is_file() {
        None
    } else if metadata.is_dir() {
        Some("a folder")
    } else {
        Some("a pipe or a device")
    }
}

/// The extension in small letters, without the dot; empty where there is none.
pub(crate) fn extension(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_lowercase()
}

/// The name of a file without its folder and its extension, or both extensions where it is packed.
pub(crate) fn title(path: &Path) -> String {
    let stem = Path::new(path.file_stem().unwrap_or_default());
    let stem = if extension(path) == "gz" { stem.file_stem() } else { Some(stem.as_os_str()) };
    stem.unwrap_or_default().to_string_lossy().into_owned()
}

/// What is said of a file whose extension is none of the `known` ones. `what` is the kind of
/// file that was wanted: "image", "scene".
pub(crate) fn unknown_format<'k>(
    what: &str,
    path: &Path,
    known: impl IntoIterator<Item = &'k str>,
) -> String {
    let known: Vec<_> = known.into_iter().map(|name| format!(".{name}")).collect();
    let known = known.join(", ");
    match &*extension(path) {
        "" => format!("no extension, so no {what} format; there are {known}"),
        other => format!("no {what} format .{}; there are {known}", other.escape_debug()),
    }
}

/// The folder that `path` stands in, in words that the system understands.
pub(crate) fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// How a scene in `folder` names a file: by the way from there, where it lies within; else by its
/// whole path.
pub fn named_from(folder: &Path, file: &Path) -> String {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let whole = |path: &Path| path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let file = whole(file);
    let within = file.strip_prefix(whole(folder)).unwrap_or(&file);
    within.to_string_lossy().replace('\\', "/")
}

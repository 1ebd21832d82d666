//! The files that a scene names: found beside it, and nowhere else unless allowed.

use super::nearest::shown;
use crate::{Limits, ReadOptions, SceneError, SceneErrorKind, Source};
use std::fs;
use std::path::{Component, Path, PathBuf};

/// Where the files of one scene are looked for.
pub(super) struct Files<'o> {
    folder: PathBuf,
    options: &'o ReadOptions<'o>,
}

/// A file that exists and may be read.
pub(super) struct Found {
    /// Its path in the words of the scene, for messages.
    pub(super) path: PathBuf,
    /// The same for every name of the same file.
    pub(super) identity: PathBuf,
}

impl<'o> Files<'o> {
    /// The files beside `scene`.
    pub(super) fn beside(scene: &Path, options: &'o ReadOptions<'o>) -> Self {
        Self { folder: scene.parent().unwrap_or(Path::new("")).to_owned(), options }
    }

    /// The bytes carried along under `name`.
    pub(super) fn embedded(&self, name: &str) -> Option<&'o [u8]> {
        self.options.embedded.iter().find(|(n, _)| *n == name).map(|(_, bytes)| *bytes)
    }

    /// The file `name`, or what is wrong with it.
    pub(super) fn find(&self, name: &str) -> Result<Found, String> {
        let quoted = shown(name);
        if !self.options.allow_outside && leaves(Path::new(name)) {
            return Err(format!("\"{quoted}\" leads out of the scene's folder; {HINT}"));
        }
        let path = self.folder.join(name);
        let identity = path.canonicalize().map_err(|error| match error.kind() {
            std::io::ErrorKind::NotFound if name.contains('\\') => {
                format!("there is no file \"{quoted}\"; write / between folders, not \\")
            }
            std::io::ErrorKind::NotFound => {
                format!("there is no file \"{quoted}\" beside the scene")
            }
            _ => format!("\"{quoted}\" cannot be read: {error}"),
        })?;
        if !self.options.allow_outside && !self.holds(&identity) {
            return Err(format!(
                "\"{quoted}\" leads out of the scene's folder through a symbolic link; {HINT}"
            ));
        }
        match fs::metadata(&identity) {
            Ok(found) if found.is_file() => Ok(Found { path, identity }),
            Ok(found) if found.is_dir() => Err(format!("\"{quoted}\" is a folder, not a file")),
            Ok(_) => Err(format!("\"{quoted}\" is not a regular file")),
            Err(error) => Err(format!("\"{quoted}\" cannot be read: {error}")),
        }
    }

    /// Whether a resolved path lies in the scene's folder, links followed on both sides.
    fn holds(&self, resolved: &Path) -> bool {
        let here = if self.folder.as_os_str().is_empty() { Path::new(".") } else { &self.folder };
        here.canonicalize().is_ok_and(|folder| resolved.starts_with(folder))
    }
}

/// How to read a file elsewhere all the same.
const HINT: &str = "move the file beside the scene, or allow this with --allow-path";

/// Whether a path names something above its start, or starts at a root.
fn leaves(path: &Path) -> bool {
    let mut depth = 0_usize;
    path.components().any(|component| match component {
        Component::Prefix(_) | Component::RootDir => true,
        Component::CurDir => false,
        Component::Normal(_) => {
            depth += 1;
            false
        }
        Component::ParentDir => match depth.checked_sub(1) {
            None => true,
            Some(less) => {
                depth = less;
                false
            }
        },
    })
}

/// Refuses what would block or never end (pipes, devices), and what is larger than allowed.
pub(crate) fn check_regular(path: &Path, limits: &Limits) -> Result<(), SceneError> {
    let kind = match fs::metadata(path) {
        Err(error) => SceneErrorKind::Io(error),
        Ok(found) if found.is_dir() => SceneErrorKind::Invalid("a folder, not a file".to_owned()),
        Ok(found) if !found.is_file() => SceneErrorKind::Invalid("not a regular file".to_owned()),
        Ok(found) if found.len() > limits.file_bytes => {
            SceneErrorKind::Limit { what: "bytes", asked: found.len(), allowed: limits.file_bytes }
        }
        Ok(_) => return Ok(()),
    };
    Err(SceneError { at: Source::file(path), kind })
}

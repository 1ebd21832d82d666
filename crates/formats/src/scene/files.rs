//! The files that a scene names: found beside it, and nowhere else unless allowed.

use crate::file;
use crate::options::ReadOptions;
use crate::shown::shown;
use std::fs;
use std::io;
use std::path::{Component, Path, PathBuf};

/// The folder that all files of a scene must lie in, symbolic links followed; or none, where the
/// caller allows any.
#[derive(Clone, Debug)]
pub(super) struct Fence(Option<PathBuf>);

impl Fence {
    /// Around the folder of `scene`.
    pub(super) fn around(scene: &Path) -> Self {
        Self(Some(file::folder(scene).to_owned()))
    }

    /// Around the folder of `scene`, unless the caller allows any.
    pub(super) fn asked(scene: &Path, options: &ReadOptions<'_>) -> Self {
        if options.allow_outside { Self(None) } else { Self::around(scene) }
    }

    /// Whether any file will do.
    pub(super) fn is_open(&self) -> bool {
        self.0.is_none()
    }

    /// Whether a path without links in it lies inside.
    pub(super) fn holds(&self, resolved: &Path) -> bool {
        let inside = |folder: PathBuf| resolved.starts_with(folder);
        self.0.as_ref().is_none_or(|folder| folder.canonicalize().is_ok_and(inside))
    }
}

/// Where the files of one scene are looked for.
pub(super) struct Files<'o> {
    folder: PathBuf,
    /// Where they may lie.
    pub(super) fence: Fence,
    embedded: &'o [(&'o str, &'o [u8])],
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
        Self {
            folder: scene.parent().unwrap_or(Path::new("")).to_owned(),
            fence: Fence::asked(scene, options),
            embedded: options.embedded,
        }
    }

    /// The bytes carried along under `name`.
    pub(super) fn embedded(&self, name: &str) -> Option<&'o [u8]> {
        self.embedded.iter().find(|(n, _)| *n == name).map(|(_, bytes)| *bytes)
    }

    /// The file `name`, or what is wrong with it.
    pub(super) fn find(&self, name: &str) -> Result<Found, String> {
        let quoted = shown(name);
        if !self.fence.is_open() && leaves(Path::new(name)) {
            return Err(format!("\"{quoted}\" leads out of the scene's folder; {HINT}"));
        }
        let path = self.folder.join(name);
        let identity = path.canonicalize().map_err(|error| match error.kind() {
            io::ErrorKind::NotFound if name.contains('\\') => {
                format!("there is no file \"{quoted}\"; write / between folders, not \\")
            }
            io::ErrorKind::NotFound => format!("there is no file \"{quoted}\" beside the scene"),
            _ => format!("\"{quoted}\" cannot be read: {error}"),
        })?;
        if !self.fence.holds(&identity) {
            return Err(format!(
                "\"{quoted}\" leads out of the scene's folder through a symbolic link; {HINT}"
            ));
        }
        let metadata = fs::metadata(&identity)
            .map_err(|error| format!("\"{quoted}\" cannot be read: {error}"))?;
        match file::not_regular(&metadata) {
            None => Ok(Found { path, identity }),
            Some(what) => Err(format!("\"{quoted}\" is {what}, not a file")),
        }
    }
}

/// How to read a file elsewhere all the same.
pub(super) const HINT: &str = "move the file beside the scene, or allow this with --allow-path";

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

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

    /// Where a file called `name` would stand.
    pub(super) fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
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

/// The file `name`, counted from `folder`, if it is there and inside the `fence`. Names that lead
/// elsewhere, which often are paths of the machine that wrote the file, are looked for by their
/// last part.
pub(super) fn find_mentioned(folder: &Path, name: &str, fence: &Fence) -> Option<PathBuf> {
    let name = with_slashes(name);
    let last = name.rsplit('/').next().unwrap_or_default();
    [&*name, last].into_iter().map(Path::new).find_map(|name| {
        // Elsewhere's paths start at a root, and asking after one could wake another machine.
        let may_be_inside = fence.is_open() || !starts_at_root(name);
        let path = folder.join(name);
        let is_inside = || path.canonicalize().is_ok_and(|resolved| fence.holds(&resolved));
        (may_be_inside && path.is_file() && is_inside()).then_some(path)
    })
}

/// Why there is no such file, unless there is just none.
pub(super) fn why_not_found(folder: &Path, name: &str, fence: &Fence) -> Option<String> {
    let name = with_slashes(name);
    if find_mentioned(folder, &name, fence).is_some() {
        return None;
    }
    let name = Path::new(&name);
    if !fence.is_open() && (starts_at_root(name) || !fence.holds(&climbed(folder, name)?)) {
        return Some(format!("leads out of the folder; {HINT}"));
    }
    let path = folder.join(name);
    if !fence.holds(&path.canonicalize().ok()?) {
        return Some(format!("leads out of the folder through a symbolic link; {HINT}"));
    }
    let what = file::not_regular(&path.metadata().ok()?)?;
    Some(format!("is {what}, not a file"))
}

/// Where a name leads from a folder, by its words alone: nothing is looked at outside.
fn climbed(folder: &Path, name: &Path) -> Option<PathBuf> {
    let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let mut path = here.canonicalize().ok()?;
    for part in name.components() {
        match part {
            Component::ParentDir => {
                path.pop();
            }
            Component::Normal(part) => path.push(part),
            Component::CurDir | Component::RootDir | Component::Prefix(_) => {}
        }
    }
    Some(path)
}

/// A name as it stands in an OBJ or MTL statement, with the slashes of all systems.
fn with_slashes(name: &str) -> String {
    name.trim_matches('"').replace('\\', "/")
}

fn starts_at_root(path: &Path) -> bool {
    path.components().any(|part| matches!(part, Component::Prefix(_) | Component::RootDir))
}

/// Whether a path names something above its start, or starts at a root.
pub(super) fn leaves(path: &Path) -> bool {
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

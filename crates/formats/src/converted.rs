//! A scene in the native format with the files that belong to it, before it is on the disk.

use crate::error::{SceneError, SceneErrorKind};
use crate::file;
use crate::replace::replace_file;
use crate::shown::shown;
use std::borrow::Cow;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A scene as a native one, proven to be the same: see [`convert`](crate::convert).
#[derive(Clone, Debug)]
pub struct Converted {
    /// The scene.
    pub text: String,
    /// The files that it names and that are not there yet.
    pub assets: Vec<Asset>,
    /// What a person should know: names that had to change, pictures that are missing. One line
    /// each.
    pub notes: Vec<String>,
}

/// A file that a scene needs beside it.
#[derive(Clone, Debug)]
pub struct Asset {
    /// Its path from the scene's folder, with `/` between folders, of which there is one.
    pub name: String,
    /// What is to stand in it.
    pub content: Content,
}

/// What is to stand in a file.
#[derive(Clone, Debug)]
pub enum Content {
    /// These bytes.
    Bytes(Arc<Vec<u8>>),
    /// A copy of this file.
    File(PathBuf),
}

impl Content {
    /// The bytes, from the disk if need be.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn bytes(&self) -> io::Result<Cow<'_, [u8]>> {
        match self {
            Self::Bytes(bytes) => Ok(Cow::Borrowed(bytes)),
            Self::File(path) => fs::read(path).map(Cow::Owned),
        }
    }
}

impl Converted {
    /// Writes everything, the scene itself last, to `to`, and gives the paths in that order. Each file
    /// appears as a whole or not at all; where one cannot be written, those that were new are taken
    /// away again.
    ///
    /// # Errors
    /// A file that is there already, unless `overwrite`, and an asset whose name is none, which
    /// [`convert`](crate::convert) never gives: then nothing is written. A disk that does not take a
    /// file ([`SceneErrorKind::Io`]).
    pub fn write(&self, to: &Path, overwrite: bool) -> Result<Vec<PathBuf>, SceneError> {
        if let Some(asset) = self.assets.iter().find(|asset| !is_plain(&asset.name)) {
            let what = format!("\"{}\" is no name of a file beside the scene", shown(&asset.name));
            return Err(SceneError::invalid_file(to, what));
        }
        let folder = file::folder(to);
        let beside = to.parent().unwrap_or(Path::new(""));
        let paths = self.assets.iter().map(|asset| beside.join(&asset.name));
        let paths: Vec<PathBuf> = paths.chain([to.to_owned()]).collect();
        let there: Vec<bool> =
            paths.iter().map(|path| fs::symlink_metadata(path).is_ok()).collect();
        if let (Some(first), false) = (there.iter().position(|there| *there), overwrite) {
            let what = "there is such a file already";
            return Err(SceneError::invalid_file(&paths[first], what));
        }
        let mut made = Made::default();
        for (i, (path, there)) in paths.iter().zip(there).enumerate() {
            let written = match self.assets.get(i) {
                Some(asset) => made.folder_of(path, folder).and_then(|()| {
                    let bytes = asset.content.bytes()?;
                    replace_file(path, &bytes)
                }),
                None => replace_file(path, self.text.as_bytes()),
            };
            if let Err(error) = written {
                made.take_back();
                return Err(SceneError::in_file(path, SceneErrorKind::Io(error)));
            }
            if !there {
                made.files.push(path.clone());
            }
        }
        Ok(paths)
    }
}

/// Whether a name is that of a file in the scene's folder, or in one folder of that, on every system.
fn is_plain(name: &str) -> bool {
    let odd = |c: char| c.is_control() || matches!(c, '\\' | ':');
    let sound = |part: &str| !part.is_empty() && part != "." && part != ".." && !part.contains(odd);
    name.split('/').count() <= 2 && name.split('/').all(sound)
}

/// What was not there before.
#[derive(Default)]
struct Made {
    files: Vec<PathBuf>,
    folders: Vec<PathBuf>,
}

impl Made {
    /// Makes the folder that a file is to stand in, within that of the scene.
    fn folder_of(&mut self, path: &Path, scene: &Path) -> io::Result<()> {
        let folder = file::folder(path);
        match fs::create_dir(folder) {
            Ok(()) => self.folders.push(folder.to_owned()),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error),
        }
        // Through a symbolic link the scene would not find it again.
        if folder.canonicalize()?.starts_with(scene.canonicalize()?) {
            Ok(())
        } else {
            Err(io::Error::other("its folder leads out of the scene's folder"))
        }
    }

    fn take_back(&self) {
        // What cannot be taken away is no worse than what made it necessary.
        self.files.iter().for_each(|file| drop(fs::remove_file(file)));
        self.folders.iter().for_each(|folder| drop(fs::remove_dir(folder)));
    }
}

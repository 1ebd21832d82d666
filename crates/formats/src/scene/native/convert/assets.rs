//! Which file of a new scene has which name: those that are there already, and those that come with
//! it.

use super::names::{self, FileNames};
use crate::converted::{Asset, Content};
use crate::error::{SceneError, SceneErrorKind};
use crate::file;
use crate::image::Format;
use crate::scene::files;
use crate::scene::origins::PictureOrigin;
use std::collections::HashMap;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

/// The files of a scene that is being written.
pub(super) struct Assets {
    /// Where the scene will stand, symbolic links followed.
    folder: PathBuf,
    /// The name of the folder there for what comes with it.
    beside: String,
    /// Whether files that are there already come with it as well.
    copy: bool,
    names: FileNames,
    /// What those are called that have been named.
    files: HashMap<PathBuf, String>,
    contents: HashMap<Arc<Vec<u8>>, String>,
    /// All that comes with the scene.
    pub(super) list: Vec<Asset>,
}

impl Assets {
    /// For a scene that is to stand at `to`, and is made of the files `sources`, which nothing may
    /// write over.
    pub(super) fn new<'s>(
        to: &Path,
        sources: impl IntoIterator<Item = &'s Path>,
        copy: bool,
    ) -> Result<Self, SceneError> {
        let folder = file::folder(to);
        let folder = folder.canonicalize().map_err(|error| {
            let what = std::io::Error::new(error.kind(), format!("its folder: {error}"));
            SceneError::in_file(to, SceneErrorKind::Io(what))
        })?;
        let stem = to.file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
        let is_plain = |c: char| c.is_alphanumeric() || " -_.()".contains(c);
        let stem = if stem.chars().all(is_plain) { stem.to_owned() } else { names::safe(stem) };
        let beside = format!("{stem}_assets");
        let mut names = FileNames::default();
        for source in sources.into_iter().filter_map(|source| source.canonicalize().ok()) {
            if let Ok(name) = source.strip_prefix(folder.join(&beside)) {
                names.keep(&name.to_string_lossy());
            }
        }
        let (files, contents) = (HashMap::new(), HashMap::new());
        Ok(Self { folder, beside, copy, names, files, contents, list: Vec::new() })
    }

    /// The name of a file that is there, symbolic links followed: as it is where the scene may name
    /// it, else that of a copy.
    pub(super) fn file(&mut self, path: &Path, other: &str) -> String {
        if let Some(name) = self.files.get(path) {
            return name.clone();
        }
        let name = match self.inside(path).filter(|_| !self.copy) {
            Some(name) => name,
            None => {
                let stem = path.file_stem().unwrap_or_default().to_string_lossy();
                let extension = names::safe(&file::extension(path)).to_lowercase();
                self.add(&stem, other, &extension, Content::File(path.to_owned()))
            }
        };
        self.files.insert(path.to_owned(), name.clone());
        name
    }

    /// The name of a new file; the same for the same content.
    pub(super) fn bytes(
        &mut self,
        title: &str,
        other: &str,
        extension: &str,
        bytes: Arc<Vec<u8>>,
    ) -> String {
        if let Some(name) = self.contents.get(&bytes) {
            return name.clone();
        }
        let name = self.add(title, other, extension, Content::Bytes(Arc::clone(&bytes)));
        self.contents.insert(bytes, name.clone());
        name
    }

    /// The name of a picture.
    pub(super) fn picture(&mut self, origin: &PictureOrigin) -> String {
        match origin {
            PictureOrigin::File(path) => self.file(path, "picture"),
            PictureOrigin::Bytes { title, bytes } => {
                // Of files whose names are told, without the extension.
                let format = Format::from_bytes(bytes);
                let extension = format.map_or("bin", Format::extension);
                let path = Path::new(title);
                let is_file = Format::from_path(path).is_ok();
                let stem = path.file_stem().and_then(|stem| stem.to_str()).filter(|_| is_file);
                self.bytes(stem.unwrap_or(title), "picture", extension, Arc::clone(bytes))
            }
            PictureOrigin::Missing(name) => {
                let is_plain = !name.contains(['\\', ':']) && !name.chars().any(char::is_control);
                let is_free = |name: &str| !self.folder.join(name).exists();
                if !name.is_empty() && is_plain && !files::leaves(Path::new(name)) && is_free(name)
                {
                    return name.clone();
                }
                let last = name.rsplit(['/', '\\']).next().unwrap_or_default();
                let stem = Path::new(last).file_stem().unwrap_or_default().to_string_lossy();
                let extension = names::safe(&file::extension(Path::new(last))).to_lowercase();
                format!("{}/{}", self.beside, self.names.free(&stem, "picture", &extension))
            }
        }
    }

    fn add(&mut self, stem: &str, other: &str, extension: &str, content: Content) -> String {
        let name = format!("{}/{}", self.beside, self.names.free(stem, other, extension));
        self.list.push(Asset { name: name.clone(), content });
        name
    }

    /// The way from the scene's folder to a file within.
    fn inside(&self, path: &Path) -> Option<String> {
        let within = path.strip_prefix(&self.folder).ok()?;
        let parts = within.components().map(|part| match part {
            Component::Normal(part) => part.to_str(),
            Component::Prefix(_)
            | Component::RootDir
            | Component::CurDir
            | Component::ParentDir => None,
        });
        let parts: Vec<&str> = parts.collect::<Option<_>>()?;
        (!parts.is_empty()).then(|| parts.join("/"))
    }
}

//! The pictures that a scene's textures show: each file is read once, all of them at the same time.

use super::files::{Files, Found};
use super::origins::PictureOrigin;
use crate::error::{ImageError, SceneError, SceneErrorKind, Source};
use crate::image::{self, Format};
use crate::limits::Limits;
use crate::shown::few;
use rayon::prelude::*;
use rutilant::image::Image;
use rutilant::scene::BitmapId;
use rutilant::texture::Bitmap;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A picture that is to be read.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Wanted {
    pub(crate) from: From,
    /// What asks for it.
    pub(crate) at: Source,
}

/// Where a picture comes from.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum From {
    /// A file: its path for messages, and the same for every name of the same file.
    File { path: PathBuf, identity: PathBuf },
    /// Bytes that are at hand, under a name for messages and one by their author.
    Bytes { name: String, title: String, bytes: Arc<Vec<u8>> },
    /// A file of this name that is not there, and why.
    Nowhere { name: String, what: String },
}

/// What stands in for a picture that is missing: nobody takes it for anything else.
const MISSING: [u8; 4] = [255, 0, 255, 255];

/// The picture of a sky, and where it comes from: bytes that are carried along under `name`, or the
/// file that `find` finds.
///
/// # Errors
/// That there is no such file; what is wrong with its content stands in the picture's place.
pub(super) fn sky_picture<E>(
    files: &Files<'_>,
    name: &str,
    limits: &Limits,
    find: impl FnOnce() -> Result<Found, E>,
) -> Result<(Result<Image, ImageError>, PictureOrigin), E> {
    if let Some(bytes) = files.embedded(name) {
        let read = image::read_bytes(bytes, Path::new(name), limits);
        let (title, bytes) = (name.to_owned(), Arc::new(bytes.to_owned()));
        return Ok((read, PictureOrigin::Bytes { title, bytes }));
    }
    let Found { path, identity } = find()?;
    Ok((image::read(&path, limits), PictureOrigin::File(identity)))
}

/// All pictures that a scene has asked for so far, by [`BitmapId`].
#[derive(Clone, Debug, Default)]
pub(crate) struct Pictures {
    wanted: Vec<Wanted>,
    known: HashMap<PathBuf, BitmapId>,
    /// By the address of bytes, which `wanted` keeps where they are.
    known_bytes: HashMap<usize, BitmapId>,
}

impl Pictures {
    /// Asks for a picture; the same file, or the same bytes in memory, are asked for once.
    pub(crate) fn want(&mut self, wanted: Wanted) -> BitmapId {
        let next = BitmapId(self.wanted.len() as u32);
        let id = match &wanted.from {
            From::File { identity, .. } => *self.known.entry(identity.clone()).or_insert(next),
            From::Bytes { bytes, .. } => {
                *self.known_bytes.entry(Arc::as_ptr(bytes).addr()).or_insert(next)
            }
            From::Nowhere { .. } => next,
        };
        if id != next {
            return id;
        }
        self.wanted.push(wanted);
        next
    }

    /// Asks for the picture of a name that a scene says.
    pub(super) fn want_named(&mut self, name: &str, files: &Files<'_>, at: Source) -> BitmapId {
        let from = match files.embedded(name) {
            Some(bytes) => From::Bytes {
                name: name.to_owned(),
                title: name.to_owned(),
                bytes: Arc::new(bytes.to_owned()),
            },
            None => match files.find(name) {
                Ok(Found { path, identity }) => From::File { path, identity },
                Err(what) => From::Nowhere { name: name.to_owned(), what },
            },
        };
        self.want(Wanted { from, at })
    }

    /// The files that were found.
    pub(crate) fn files(&self) -> impl Iterator<Item = PathBuf> {
        self.wanted.iter().filter_map(|wanted| match &wanted.from {
            From::File { identity, .. } => Some(identity.clone()),
            From::Bytes { .. } | From::Nowhere { .. } => None,
        })
    }

    /// Where each comes from.
    pub(crate) fn origins(&self) -> Vec<PictureOrigin> {
        let origin = |wanted: &Wanted| match &wanted.from {
            From::File { identity, .. } => PictureOrigin::File(identity.clone()),
            From::Bytes { title, bytes, .. } => {
                PictureOrigin::Bytes { title: title.clone(), bytes: Arc::clone(bytes) }
            }
            From::Nowhere { name, .. } => PictureOrigin::Missing(name.clone()),
        };
        self.wanted.iter().map(origin).collect()
    }

    /// Reads all of them. One that cannot be read is magenta, with a note; or an error, if `strict`.
    pub(crate) fn read(
        &self,
        limits: &Limits,
        strict: bool,
        notes: &mut Vec<String>,
    ) -> Result<Vec<Arc<Bitmap>>, SceneError> {
        let mut left = limits.texture_bytes;
        let mut missing = Vec::new();
        let mut bitmaps = Vec::with_capacity(self.wanted.len());
        // No more at once than threads can read: small files may hold large pictures, and those that
        // are too many in all must not all be there before that is known.
        let some = self.wanted.chunks(rayon::current_num_threads());
        let read = some.flat_map(|some| {
            let read = some.par_iter().map(|wanted| wanted.read(limits));
            some.iter().zip(read.collect::<Vec<Result<Bitmap, String>>>())
        });
        for (wanted, read) in read {
            let bitmap = match read {
                Ok(bitmap) => bitmap,
                Err(what) if strict => {
                    let (at, kind) = (wanted.at.clone(), SceneErrorKind::Invalid(what));
                    return Err(SceneError { at, kind });
                }
                Err(what) => {
                    missing.push((&wanted.at, format!("{what}: magenta stands in")));
                    Bitmap::solid(MISSING)
                }
            };
            left = left.checked_sub(bitmap.bytes()).ok_or_else(|| {
                let allowed = limits.texture_bytes;
                let asked = (allowed - left).saturating_add(bitmap.bytes());
                let kind = SceneErrorKind::Limit { what: "bytes of textures", asked, allowed };
                SceneError { at: wanted.at.clone(), kind }
            })?;
            bitmaps.push(Arc::new(bitmap));
        }
        let what = "pictures that cannot be read: magenta stands in";
        notes.extend(few(&missing, what));
        Ok(bitmaps)
    }

    /// What stands for them before they are read.
    pub(crate) fn bare(&self) -> Vec<Arc<Bitmap>> {
        let missing = Arc::new(Bitmap::solid(MISSING));
        self.wanted.iter().map(|_| Arc::clone(&missing)).collect()
    }

    /// Takes over those of another list, and gives the new number of each.
    pub(crate) fn adopt(&mut self, others: Self) -> Vec<BitmapId> {
        others.wanted.into_iter().map(|wanted| self.want(wanted)).collect()
    }
}

impl Wanted {
    fn read(&self, limits: &Limits) -> Result<Bitmap, String> {
        match &self.from {
            From::File { path, .. } => image::read_bitmap(path, limits).map_err(|e| e.to_string()),
            From::Bytes { name, bytes, .. } => {
                let path = Path::new(name);
                if path.extension().is_none() && Format::from_bytes(bytes).is_none() {
                    let count = bytes.len();
                    return Err(format!(
                        "{name}: its {count} bytes are of no image format read here"
                    ));
                }
                image::read_bitmap_bytes(bytes, path, limits).map_err(|e| e.to_string())
            }
            From::Nowhere { what, .. } => Err(what.clone()),
        }
    }
}

//! Scenes and images from files, and images to files.
//!
//! This crate is the only door for untrusted bytes: whatever they are, it
//! returns a value or an error and never panics.
//!
//! [`read_scene`] takes a path and gives what the renderer needs:
//!
//! ```no_run
//! let loaded = rutilant_formats::read_scene("kitchen.toml".as_ref(), &Default::default())?;
//! println!("{} objects", loaded.scene.objects.len());
//! # Ok::<(), rutilant_formats::SceneError>(())
//! ```

pub mod camera;
mod error;
mod file;
pub mod image;
mod limits;
mod options;
pub mod scene;
mod shown;

pub use error::{ImageError, SceneError, SceneErrorKind, Source};
pub use limits::Limits;
pub use options::ReadOptions;
pub use scene::loaded::LoadedScene;

use std::path::Path;

/// What reads one kind of scene file.
type SceneReader = fn(&Path, &ReadOptions<'_>) -> Result<LoadedScene, SceneError>;

/// Every kind of scene file, by its extension.
const SCENES: &[(&str, SceneReader)] =
    &[("toml", scene::native::read), ("obj", scene::bare::read), ("ply", scene::bare::read)];

/// Reads the scene in a file of any kind that is known by its extension.
///
/// `.toml` is the native format (docs/scene-format.md). A bare `.obj` or `.ply`
/// becomes a scene as well: under an even sky, seen by a camera that fits it.
///
/// # Errors
/// The first thing in the file, or in the files it names, that cannot be used,
/// with its place.
pub fn read_scene(path: &Path, options: &ReadOptions<'_>) -> Result<LoadedScene, SceneError> {
    let extension = file::extension(path);
    match SCENES.iter().find(|(name, _)| *name == extension) {
        Some((_, read)) => read(path, options),
        None => {
            let known = SCENES.iter().map(|(name, _)| *name);
            let what = file::unknown_format("scene", path, known);
            Err(SceneError::in_file(path, SceneErrorKind::Unsupported(what)))
        }
    }
}

/// Reads a native scene (docs/scene-format.md) that is already in memory.
///
/// `file` is where it would stand: errors name it, and the files that the
/// scene names are looked for beside it, after those in
/// [`ReadOptions::embedded`].
///
/// # Errors
/// The first thing in the text, or in the files it names, that cannot be used,
/// with its place.
pub fn parse_native(
    text: &str,
    file: &Path,
    options: &ReadOptions<'_>,
) -> Result<LoadedScene, SceneError> {
    scene::native::parse(text, file, options)
}

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
mod converted;
mod error;
mod file;
pub mod image;
mod limits;
mod look;
mod options;
mod replace;
pub mod scene;
mod shown;

pub use converted::{Asset, Content, Converted};
pub use error::{ImageError, SceneError, SceneErrorKind, Source};
pub use file::named_from;
pub use limits::Limits;
pub use look::Look;
pub use options::{CameraChoice, ReadOptions, SkyChoice};
pub use replace::replace_file;
pub use scene::loaded::{LoadedScene, TextureName};
pub use scene::native::convert::ConvertOptions;
pub use scene::origins::{MeshOrigin, Origins, PictureOrigin};

use std::path::Path;

/// What reads one kind of scene file.
type SceneReader = fn(&Path, &ReadOptions<'_>) -> Result<LoadedScene, SceneError>;

/// Every kind of scene file, by its extension.
const SCENES: &[(&str, SceneReader)] = &[
    ("toml", |path, options| scene::native::read(path, options)?.without_variants(path, options)),
    ("gltf", scene::gltf::scene::read),
    ("glb", scene::gltf::scene::read),
    ("pbrt", |path, options| {
        scene::pbrt::scene::read(path, options)?.without_variants(path, options)
    }),
    ("xml", |path, options| {
        scene::mitsuba::scene::read(path, options)?.without_variants(path, options)
    }),
    ("obj", |path, options| scene::bare::read(path, options)?.without_variants(path, options)),
    ("ply", |path, options| scene::bare::read(path, options)?.without_variants(path, options)),
    ("stl", |path, options| scene::bare::read(path, options)?.without_variants(path, options)),
];

/// Reads the scene in a file of any kind that is known by its extension.
///
/// `.toml` is the native format (docs/scene-format.md), `.gltf` and `.glb` are glTF 2.0
/// (docs/gltf.md), `.pbrt` is pbrt's (docs/pbrt.md) and `.xml` Mitsuba's (docs/mitsuba.md). A bare
/// `.obj`, `.ply` or `.stl` becomes a scene as well: under an even sky, seen by a camera that fits
/// it.
///
/// # Errors
/// The first thing in the file, or in the files it names, that cannot be used,
/// with its place.
pub fn read_scene(path: &Path, options: &ReadOptions<'_>) -> Result<LoadedScene, SceneError> {
    let extension = file::extension(path);
    match SCENES.iter().find(|(name, _)| *name == extension) {
        Some((name, read)) => {
            if *name != WITH_PARAMETERS {
                without_parameters(path, options)?;
            }
            read(path, options)?.under(path, options)
        }
        None => {
            let known = SCENES.iter().map(|(name, _)| *name);
            let what = file::unknown_format("scene", path, known);
            Err(SceneError::in_file(path, SceneErrorKind::Unsupported(what)))
        }
    }
}

/// The extension of scenes that have parameters.
const WITH_PARAMETERS: &str = "xml";

/// Asks for no parameters, in a file that cannot have any.
fn without_parameters(path: &Path, options: &ReadOptions<'_>) -> Result<(), SceneError> {
    let Some((name, _)) = options.parameters.first() else { return Ok(()) };
    let name = shown::shown(name);
    let what = format!("no parameter \"{name}\": only Mitsuba scenes have parameters");
    Err(SceneError::invalid_file(path, what))
}

/// The text of the native scene at `path`, for [`parse_native`] and [`rewrite`].
///
/// # Errors
/// A file that cannot be read, exceeds the `limits`, or is not UTF-8.
pub fn native_text(path: &Path, limits: &Limits) -> Result<String, SceneError> {
    scene::native::text(path, limits)
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
    without_parameters(file, options)?;
    let loaded = scene::native::parse(text, file, options)?;
    loaded.without_variants(file, options)?.under(file, options)
}

/// Reads a scene of pbrt (docs/pbrt.md) that is already in memory.
///
/// `file` is where it would stand: errors name it, and the files that the scene names are looked for
/// beside it, after those in [`ReadOptions::embedded`].
///
/// # Errors
/// As for [`parse_native`].
pub fn parse_pbrt(
    bytes: Vec<u8>,
    file: &Path,
    options: &ReadOptions<'_>,
) -> Result<LoadedScene, SceneError> {
    without_parameters(file, options)?;
    let loaded = scene::pbrt::scene::read_bytes(bytes, file, options)?;
    loaded.without_variants(file, options)?.under(file, options)
}

/// Reads a scene of Mitsuba (docs/mitsuba.md) that is already in memory.
///
/// `file` is where it would stand: errors name it, and the files that the scene names are looked for
/// beside it, after those in [`ReadOptions::embedded`].
///
/// # Errors
/// As for [`parse_native`].
pub fn parse_mitsuba(
    bytes: Vec<u8>,
    file: &Path,
    options: &ReadOptions<'_>,
) -> Result<LoadedScene, SceneError> {
    let loaded = scene::mitsuba::scene::read_bytes(bytes, file, options)?;
    loaded.without_variants(file, options)?.under(file, options)
}

/// The text of a native scene with another look: only values that differ are changed, all else
/// stays byte by byte as it is, comments and line ends among it.
///
/// `text` is what `before` was read from, with the same `file` and `options`. `image_names` are
/// those of `before`, followed by those of images that have been added since, by
/// [`ImageId`](rutilant::scene::ImageId). New materials stand behind all old ones; in the file
/// they come before those of mesh files. `Settings::planned_spp` is not written.
///
/// The result has been read again: it gives `after`, bit for bit. Numbers that have no meaning are
/// as usual then: see [`meant`](camera::AuthoredCamera::meant).
///
/// # Errors
/// Changes that a scene's text cannot hold: to materials of mesh files, custom ones, angles between
/// those of two neighbouring numbers of degrees, values that a reader refuses; and a text that is
/// not that of `before`.
pub fn rewrite(
    text: &str,
    file: &Path,
    options: &ReadOptions<'_>,
    before: &LoadedScene,
    after: &Look,
    image_names: &[String],
) -> Result<String, SceneError> {
    scene::native::rewrite::rewrite(text, file, options, before, after, image_names)
}

/// A native scene for the look `after` of a bare mesh file, read as `before`, that shows the same
/// picture. `mesh` is the name of the mesh file as seen from the folder of `file`, where the scene
/// will stand.
///
/// The result has been read again, as in [`rewrite`], so the mesh file must be there.
///
/// # Errors
/// As for [`rewrite`].
pub fn native_for_mesh(
    mesh: &str,
    file: &Path,
    options: &ReadOptions<'_>,
    before: &LoadedScene,
    after: &Look,
    image_names: &[String],
) -> Result<String, SceneError> {
    scene::native::rewrite::native_for_mesh(mesh, file, options, before, after, image_names)
}

/// Any scene as a native one, to go on with: `loaded` was read from the file `from`, and is to stand
/// at `to`.
///
/// Files that lie in the folder of `to` or below are named there, with [`ConvertOptions::copy`] none
/// of them. All else comes along as [`Converted::assets`], in a folder `NAME_assets` beside `NAME.toml`:
/// meshes as binary PLY files, pictures with the bytes that they had. Names of materials, textures and
/// cameras stay where they are unique. Nothing is written before [`Converted::write`].
///
/// The result has been read again, from memory: it is the same scene, bit for bit, but for the names
/// of meshes, those that had to change, and the order of meshes that stand in several places.
/// `Settings::planned_spp` is not written.
///
/// # Errors
/// A scene that is not sound; custom shapes and materials, pictures that come from no file, and
/// angles between those of two neighbouring numbers of degrees; a folder that is not there.
pub fn convert(
    loaded: &LoadedScene,
    from: &Path,
    to: &Path,
    options: &ConvertOptions,
) -> Result<Converted, SceneError> {
    scene::native::convert::convert(loaded, from, to, options)
}

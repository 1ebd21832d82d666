//! glTF 2.0: scenes as most programs exchange them, as text or in one binary file.
//!
//! Bytes become a [`Document`]: plain arrays, in which every number of another
//! part exists and every accessor has been decoded. What is wrong is refused in
//! one line that names the place, `meshes[3].primitives[0].attributes.POSITION`
//! for example; what a picture can do without is left out with a note.
//!
//! A document is not yet a scene of the renderer: it keeps the words of the
//! format. Images in it are not decoded.
//!
//! Source: Khronos Group, *glTF 2.0 Specification*, 2021, and the extensions
//! named in docs/gltf.md.

mod accessor;
mod animation;
mod document;
mod draco;
mod entry;
mod glb;
mod json;
mod material;
mod mesh;
mod meshopt;
mod node;
mod pose;
pub(crate) mod scene;
mod store;
mod texture;
mod uri;

pub use super::affine::Affine;
pub use animation::{Animation, Channel, Interpolation, Target};
pub use document::{Document, SceneRoots};
pub use material::{
    Alpha, Anisotropy, Clearcoat, DiffuseTransmission, Iridescence, Material, Sheen, Specular,
    SpecularGlossiness, Transmission, Volume,
};
pub use mesh::{Mesh, MorphTarget, Primitive, Skinning};
pub use node::{Camera, Light, LightKind, Node, Parts, Placement, Projection, Skin};
pub use pose::{Bent, Moment, Placed, Pose};
pub use texture::{Encoding, Filter, Image, ImageBytes, Texture, TextureRef, UvTransform, Wrap};

use crate::error::SceneError;
use crate::file;
use crate::options::ReadOptions;
use std::path::Path;

/// Reads the document at `path`, a `.gltf` or `.glb` file, with the buffers beside it.
///
/// # Errors
/// A file that cannot be read, breaks the format, needs what is not read, or
/// exceeds the limits of the `options`.
pub fn read(path: &Path, options: &ReadOptions<'_>) -> Result<Document, SceneError> {
    let bytes = file::scene_bytes(path, &options.limits)?;
    read_bytes(&bytes, path, options)
}

/// As [`read`], for the content of a file that would stand at `path`: buffers are looked for
/// beside it, and messages name it.
///
/// # Errors
/// As [`read`].
pub fn read_bytes(
    bytes: &[u8],
    path: &Path,
    options: &ReadOptions<'_>,
) -> Result<Document, SceneError> {
    document::read(bytes, path, options)
}
